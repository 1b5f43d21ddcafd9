//! A mapping of a model: a checker on it, its distortion, its layout and figures.

use serde::Deserialize;
use texmap_io::framing::View;
use texmap_lab::uv_pictures;
use texmap_math::Level;
use texmap_math::glam::DVec3;
use texmap_uv::{Faces, Mapping, Mesh, Origin, ProjectionSource, ReportOptions, Shape, report};

use crate::answer::Answer;
use crate::load::Files;

/// A model under a mapping.
#[derive(Clone, Debug, Deserialize)]
pub struct Mapped {
    model: String,
    shape: String,
    by: String,
    repeat: [f64; 2],
    seams: bool,
    view: String,
    size: u32,
    /// The checker alone, without the report: it comes first.
    #[serde(default)]
    quick: bool,
}

impl Mapped {
    pub(crate) fn answer(&self, files: &Files) -> Result<Answer, String> {
        let scene = files.scene(&self.model, None, 1.0)?;
        let (mut positions, mut faces) = (Vec::new(), Faces::new());
        for part in &scene.meshes {
            let first = positions.len() as u32;
            let world = part.positions.iter().map(|p| {
                let p = DVec3::from(p.map(f64::from));
                part.world_from_object
                    .transform_point3(p)
                    .as_vec3()
                    .to_array()
            });
            positions.extend(world);
            for triangle in &part.triangles {
                faces.push(&triangle.map(|v| v + first));
            }
        }
        let mesh = Mesh::new(&positions, &faces).map_err(|e| e.to_string())?;
        let mapping = Mapping {
            by: match self.by.as_str() {
                "normal" => ProjectionSource::Normal,
                "centroid" => ProjectionSource::Centroid,
                _ => ProjectionSource::Position,
            },
            repeat: self.repeat,
            fix_seams: self.seams,
            ..Mapping::new(match self.shape.as_str() {
                "plane" => Shape::Plane,
                "cylinder" => Shape::Cylinder,
                "box" => Shape::Box,
                _ => Shape::Sphere,
            })
        };
        let mapped = mapping
            .map(Level::new(), &mesh, &[])
            .map_err(|e| e.to_string())?;
        let view: View = self.view.parse().map_err(|_| "unknown view")?;
        let size = self.size.clamp(64, 1024);
        // The words of the error would bring every demo of the lab along.
        let drawn = |_: texmap_lab::LabError| "the model cannot be drawn".to_owned();
        let mut answer = Answer::default();
        let checker = uv_pictures::checker(&mesh, &mapped.set, Origin::TopLeft, view, size);
        answer.picture("a checker of 16 x 16", &checker.map_err(drawn)?);
        if self.quick {
            return Ok(answer);
        }
        let options = ReportOptions {
            views: false,
            ..ReportOptions::default()
        };
        let figures = report(&mesh, &mapped.set, &options).map_err(|e| e.to_string())?;
        answer.picture(
            "distortion: blue none, red from 2 on",
            &uv_pictures::heat(&mesh, &figures, view, size).map_err(drawn)?,
        );
        answer.picture(
            "layout: overlaps pink, mirrored blue",
            &uv_pictures::layout(&mapped.set, &figures, Origin::TopLeft, size),
        );
        answer.figure(
            "stretch, root mean square (1 is best)",
            figures.stretch_l2,
            "",
        );
        answer.figure("angle distortion, mean (1 is best)", figures.angle_mean, "");
        answer.figure("area distortion, mean (1 is best)", figures.area_mean, "");
        answer.figure("triangles torn by the seam", figures.wide as f64, "");
        answer.figure("overlapping triangles", figures.overlapping as f64, "");
        answer.figure("mirrored triangles", figures.flipped as f64, "");
        answer.figure("islands", figures.islands as f64, "");
        Ok(answer)
    }
}

//! Map shapes around an object (SUSTech, lecture 08, slides 13 to 20; CS184, lecture 20): a checker by plane, cylinder, sphere and box,
//! and the stretch of each against its closed form.

use texmap_io::framing::View;
use texmap_math::Level;
use texmap_math::deterministic_f64::sin_cos;
use texmap_math::glam::DVec3;
use texmap_truth::picture::Picture;
use texmap_uv::{Faces, Mapping, Mesh, Origin, Report, ReportOptions, Shape, UvSet, report};

use super::DemoPicture;
use super::lit::ball;
use super::sheet::sheet;
use crate::LabError;
use crate::uv_pictures::{checker, heat};

/// Degrees from the equator up to which triangles are judged; at the poles the sphere map has no limit.
const REACH: f64 = 60.0;
/// Faces of the ball around, and from pole to pole.
const COLUMNS: u32 = 96;
const ROWS: u32 = COLUMNS / 2;
/// Step of its vertices in radians, along both circles.
const STEP: f64 = std::f64::consts::TAU / 96.0;

/// An object with the coordinates of one mapping.
struct Mapped<'a> {
    mesh: Mesh<'a>,
    set: UvSet,
    report: Report,
}

impl<'a> Mapped<'a> {
    fn new(object: &'a Object, mapping: &Mapping) -> Result<Self, LabError> {
        let mesh = Mesh::new(&object.positions, &object.faces)?;
        let set = mapping.map(Level::new(), &mesh, &[])?.set;
        let report = report(&mesh, &set, &ReportOptions::default())?;
        Ok(Self { mesh, set, report })
    }

    /// The checker and the heat map of its distortion.
    fn pictures(&self, size: u32) -> Result<[Picture; 2], LabError> {
        Ok([
            checker(&self.mesh, &self.set, Origin::TopLeft, View::Iso, size)?,
            heat(&self.mesh, &self.report, View::Iso, size)?,
        ])
    }

    /// Largest relative difference of the area of a face in the picture over its area in space to a formula of its middle and its unit
    /// normal, up to [`REACH`] from the equator.
    fn worst(&self, formula: impl Fn(DVec3, DVec3) -> f64) -> f64 {
        let (positions, corners) = (self.mesh.positions(), self.mesh.faces().corners());
        let point = |k: u32| DVec3::from(positions[corners[k as usize] as usize].map(f64::from));
        let size = f64::from(ReportOptions::default().texture_size);
        let (highest, _) = sin_cos(REACH.to_radians());
        let mut worst = 0.0f64;
        for face in self.report.triangles.chunk_by(|a, b| a.face == b.face) {
            // Areas in space as vectors, those in the picture, and the sum of corners.
            let (mut space, mut picture, mut sum) = (DVec3::ZERO, 0.0, DVec3::ZERO);
            for triangle in face {
                let [a, b, c] = triangle.corners.map(point);
                let area = (b - a).cross(c - a) * 0.5;
                picture += (f64::from(triangle.density) / size).powi(2) * area.length();
                space += area;
                sum += a + b + c;
            }
            let (middle, normal) = (sum.normalize(), space.normalize());
            if middle.y.abs() <= highest {
                let density = picture / space.length();
                worst = worst.max((density / formula(middle, normal) - 1.0).abs());
            }
        }
        worst
    }
}

/// Positions and faces of a mesh.
struct Object {
    positions: Vec<[f32; 3]>,
    faces: Faces,
}

/// A ball of radius 1 with faces of four corners and one column of vertices at the seam.
fn globe() -> Object {
    let positions = ball(DVec3::ZERO, 1.0, 0).positions;
    let mut faces = Faces::new();
    for (j, i) in (0..ROWS).flat_map(|j| (0..COLUMNS).map(move |i| (j, i))) {
        let at = |j: u32, i: u32| j * (COLUMNS + 1) + i % COLUMNS;
        let [a, b, right, above] = [at(j, i), at(j + 1, i), at(j + 1, i + 1), at(j, i + 1)];
        match j {
            0 => faces.push(&[a, b, right]),
            _ if j + 1 == ROWS => faces.push(&[a, b, above]),
            _ => faces.push(&[a, b, right, above]),
        }
    }
    Object { positions, faces }
}

fn cube() -> Object {
    let mesh = texmap_scene::Mesh::cube();
    Object {
        faces: Faces::from_triangles(&mesh.triangles),
        positions: mesh.positions,
    }
}

pub(super) fn uv_mappings(size: u32) -> Result<DemoPicture, LabError> {
    let (globe, cube) = (globe(), cube());
    let plane = Mapped::new(&globe, &Mapping::new(Shape::Plane))?;
    let lathe = Mapping {
        caps: false,
        ..Mapping::new(Shape::Cylinder)
    };
    let cylinder = Mapped::new(&globe, &lathe)?;
    let sphere = Mapped::new(&globe, &Mapping::new(Shape::Sphere))?;
    let sides = Mapped::new(&cube, &Mapping::new(Shape::Box))?;
    let torn = Mapping {
        fix_seams: false,
        ..Mapping::new(Shape::Sphere)
    };
    let torn = Mapped::new(&globe, &torn)?;

    // A facet stands for a curved patch: its area and its middle are off by squares of the step, most where the circles of latitude
    // shrink fastest.
    let (sin, cos) = sin_cos(REACH.to_radians());
    let facets = STEP * STEP * (1.0 + 2.0 * (sin / cos).powi(2)) / 2.0;
    use std::f64::consts::PI;
    let claims = claims! {
        // u is the longitude, v the latitude.
        "sphere on a ball: largest relative error of texel areas against 1 / (2 pi^2 cos latitude), to 60 degrees" =>
            sphere.worst(|p, _| 1.0 / (2.0 * PI * PI * (1.0 - p.y * p.y).sqrt())), 0.0, facets;
        // Archimedes: the side of the cylinder around a ball has its area.
        "cylinder on a ball: the same against 1 / (4 pi) everywhere" => cylinder.worst(|_, _| 1.0 / (4.0 * PI)), 0.0, facets;
        // A flat facet is seen under the cosine of its slope, exactly but for coordinates of 24 bits.
        "plane on a ball: the same against the cosine of the slope / 4" => plane.worst(|_, n| n.z.abs() / 4.0), 0.0, 1e-3;
        "box on a cube: largest distortion of areas" => sides.report.area_max, 1.0, 1e-5;
        "box on a cube: largest distortion of angles" => sides.report.angle_max, 1.0, 1e-5;
        "triangles torn by the seam of the sphere" => sphere.report.wide as f64, 0.0, 0.0;
        // Two triangles of each of 48 rows cross it, one in those at the poles.
        "the same, seam left as it is" => torn.report.wide as f64, 94.0, 0.0;
    };
    let [plane, plane_heat] = plane.pictures(size)?;
    let [cylinder, cylinder_heat] = cylinder.pictures(size)?;
    let [sphere, sphere_heat] = sphere.pictures(size)?;
    let [sides, sides_heat] = sides.pictures(size)?;
    let panels = panels! {
        plane => "Plane", "A slide projector: right where the surface faces it, streaks where it is edge-on.";
        cylinder => "Cylinder, no caps", "Film around the object: areas stay on a ball, shapes do not.";
        sphere => "Sphere", "Longitude and latitude: shapes shrink toward the poles.";
        sides => "Box on a cube", "Each side takes the picture straight.";
        plane_heat => "Plane: distortion", "Blue 1, green 1.25, yellow 1.5, red 2 and more.";
        cylinder_heat => "Cylinder: distortion", "The larger of the distortions of angle and of area.";
        sphere_heat => "Sphere: distortion", "Angles are kept at 60 degrees, where a square picture is as wide as it is high.";
        sides_heat => "Box: distortion", "None.";
    };
    Ok(sheet(
        "Shapes around an object: a checker and its stretch",
        panels,
        claims,
    ))
}

//! The scenes of the filtering panel with their truths, for whoever draws them.

use texmap_math::camera::Camera;
use texmap_sample::{ColorSpace, Origin, Sampler, Texture2d};
use texmap_scene::{ColorMode, Material, Mesh, Scene, Shading, TextureRole, TextureSlot};

use super::Error;
use crate::LabError;
use crate::plane::{Pattern, SIDE, TEXELS, TiltedPlane, Truth, View, nearest, sines};
use texmap_truth::picture::Picture;
use texmap_truth::strip::heat;

/// A picture on the tilted plane, and what it should look like.
#[derive(Debug)]
pub struct PlaneScene {
    /// Short name, unique: that of the chart.
    pub id: String,
    /// The drawn scene.
    pub title: String,
    /// The reference, in words.
    pub told: String,
    /// The texture of the plane.
    pub pattern: Pattern,
    /// The plane with the pixels that count.
    pub plane: TiltedPlane,
    /// The value of each counted pixel, 0 to 1.
    pub truth: Vec<f64>,
}

impl PlaneScene {
    /// All of them, from `grid` x `grid` samples a pixel: each pattern with the pixel's square for truth, each with a Gaussian
    /// pixel, the waves turned, the waves magnified.
    pub fn all(grid: usize) -> Vec<Self> {
        let bytes = Pattern::ALL.map(Pattern::bytes);
        let value = |p: &[u8], at| f64::from(p[nearest(at)]) / 255.0;
        let told = format!("mean of {grid} x {grid} nearest look-ups over the pixel's square");
        let mut scenes = Vec::new();
        let plain = TiltedPlane::default();
        for (truth, ending, shape, told) in [
            (Truth::Box, "", "the pixel's square", told.as_str()),
            (
                Truth::Gaussian,
                "-gaussian",
                "a Gaussian pixel",
                "Gaussian of 0.5 pixels over +-2 pixels; the times are those above",
            ),
        ] {
            let means = plain.truth_by(truth, grid, |at| bytes.each_ref().map(|p| value(p, at)));
            for (k, pattern) in Pattern::ALL.into_iter().enumerate() {
                let name = format!("{pattern:?}").to_lowercase();
                scenes.push(Self {
                    id: format!("filtering-{name}{ending}"),
                    title: format!("The tilted plane, {name}, truth: {shape}"),
                    told: told.to_owned(),
                    pattern,
                    plane: TiltedPlane::default(),
                    truth: means.iter().map(|m| m[k]).collect(),
                });
            }
        }
        let waves =
            |id: &str, title: &str, told: String, plane: TiltedPlane, truth: Vec<[f64; 1]>| Self {
                id: format!("filtering-{id}"),
                title: format!("The tilted plane, sines {title}"),
                told,
                pattern: Pattern::Sines,
                plane,
                truth: truth.into_flattened(),
            };
        let plane = TiltedPlane::new(View {
            turn: 30f64.to_radians(),
            magnify: 1.0,
        });
        let truth = plane.truth_by(Truth::Box, grid, |at| [value(&bytes[1], at)]);
        scenes.push(waves("turned", "turned by 30 degrees", told, plane, truth));
        let plane = TiltedPlane::new(View {
            turn: 0.0,
            magnify: 8.0,
        });
        let truth = plane.truth_by(Truth::Box, grid.min(16), |[x, y]| {
            [sines([x - 0.5, y - 0.5])]
        });
        let told = "mean of the continuous waves over the pixel's square".to_owned();
        scenes.push(waves("magnified", "magnified 8 times", told, plane, truth));
        scenes
    }

    /// The plane as a scene for renderers of polygons; draw it at 256 x 256 pixels.
    ///
    /// # Errors
    /// If the texture is refused, which would be a bug.
    pub fn scene(&self, sampler: Sampler) -> Result<Scene, LabError> {
        scene(&self.plane, self.pattern, sampler)
    }

    /// The values of the counted pixels in a drawn picture of four bytes a pixel, rows top to bottom.
    pub fn values(&self, rgba: &[u8]) -> Vec<f64> {
        values(&self.plane, rgba)
    }

    /// The error of a value for each counted pixel.
    pub fn error(&self, values: &[f64]) -> Error {
        Error::of(values.iter().zip(&self.truth).map(|(v, t)| v - t))
    }

    /// A picture of a value for each counted pixel: 128 x 128 pixels from the far edge of the plane and, beside them, their error: white from 0.25.
    pub fn picture(&self, values: &[f64]) -> Picture {
        const PART: u32 = 128;
        let top = self.plane.places().map(|p| p.1).min().unwrap_or(0) as i64;
        let mut picture = Picture::new(2 * PART + 2, PART, [255; 4]);
        picture.fill(0, 0, 2 * PART + 2, PART, [96, 96, 128, 255]);
        let part = i64::from(PART);
        for (((x, y, _), value), truth) in self.plane.places().zip(values).zip(&self.truth) {
            let (x, y) = (x as i64 - 64, y as i64 - top);
            if (0..part).contains(&x) && (0..part).contains(&y) {
                // 16 greys are enough to see by, and compress.
                let c = ((value.clamp(0.0, 1.0) * 15.0).round() * 17.0) as u8;
                picture.set(x, y, [c, c, c, 255]);
                let off = ((value - truth).abs() * 4.0 * 12.0).round() / 12.0;
                picture.set(x + part + 2, y, heat(off));
            }
        }
        picture
    }
}

fn scene(plane: &TiltedPlane, pattern: Pattern, sampler: Sampler) -> Result<Scene, LabError> {
    let (corners, side) = (plane.polygon(), TEXELS as u32);
    let texture = Texture2d::from_rgba8(
        side,
        side,
        pattern.rgba(),
        ColorSpace::Linear,
        Origin::TopLeft,
    )?;
    let mesh = Mesh {
        positions: corners.iter().map(|c| c.0.as_vec3().to_array()).collect(),
        uvs: corners.iter().map(|c| c.1.map(|c| c as f32)).collect(),
        triangles: (2..corners.len() as u32).map(|i| [0, i - 1, i]).collect(),
        ..Mesh::default()
    };
    Ok(decal_scene(TiltedPlane::camera(), mesh, texture, sampler))
}

/// A mesh whose surface is its texture and nothing else, before black.
pub fn decal_scene(
    camera: Camera,
    mesh: Mesh,
    texture: Texture2d<'static>,
    sampler: Sampler,
) -> Scene {
    Scene {
        color: ColorMode::Raw,
        textures: vec![texture.with_mips()],
        materials: vec![Material {
            base_color: Some(TextureSlot {
                sampler,
                ..TextureSlot::new(0)
            }),
            shading: Shading::Unlit,
            texture_role: TextureRole::Decal,
            ..Material::default()
        }],
        meshes: vec![mesh],
        ..Scene::new(camera)
    }
}

fn values(plane: &TiltedPlane, rgba: &[u8]) -> Vec<f64> {
    let at = |(x, y, _): (usize, usize, [f64; 2])| {
        rgba.get((y * SIDE + x) * 4)
            .map_or(f64::NAN, |c| f64::from(*c) / 255.0)
    };
    plane.places().map(at).collect()
}

#[cfg(test)]
mod tests {
    use texmap_math::glam::DVec3;
    use texmap_render::{RenderSettings, Renderer};
    use texmap_sample::Filter;

    use super::*;

    /// The plane's polygon drawn by texmap, nearest texel.
    fn drawn(plane: &TiltedPlane) -> Vec<f64> {
        let sampler = Sampler {
            filter: Filter::Nearest,
            ..Sampler::default()
        };
        let scene = scene(plane, Pattern::Noise, sampler).unwrap();
        let settings = RenderSettings::new(SIDE as u32, SIDE as u32);
        let frame = Renderer::new(&scene, &settings)
            .unwrap()
            .draw(&texmap_render::no_progress)
            .unwrap();
        values(plane, &frame.rgba)
    }

    #[test]
    fn a_drawn_polygon_shows_what_the_rays_of_the_plane_see() {
        let turned = View {
            turn: 0.5,
            magnify: 2.0,
        };
        for view in [View::default(), turned] {
            let plane = TiltedPlane::new(view);
            let bytes = Pattern::Noise.bytes();
            let exact = |p: (usize, usize, [f64; 2])| {
                f64::from(bytes[nearest(p.2.map(|c| c * TEXELS as f64))]) / 255.0
            };
            let exact: Vec<f64> = plane.places().map(exact).collect();
            let off = |found: &[f64]| {
                let pairs = found.iter().zip(&exact);
                pairs.filter(|(f, e)| (*f - *e).abs() > 1e-6).count()
            };
            let found = off(&drawn(&plane));
            // A sample within a rounding of the border of two texels may fall to either.
            assert!(found * 1000 < plane.len(), "{found} of {}", plane.len());
            // Negative twin: the texture lies another way.
            let other = TiltedPlane::new(View {
                turn: view.turn + 1e-2,
                ..view
            });
            let found = off(&drawn(&other));
            assert!(found * 2 > plane.len(), "{found}");
        }
    }

    #[test]
    fn the_polygon_lies_before_the_eye() {
        let camera = TiltedPlane::camera();
        let corners = TiltedPlane::default().polygon();
        let forward = (camera.look - camera.eye).normalize();
        let ahead = |p: &(DVec3, [f64; 2])| (p.0 - camera.eye).dot(forward);
        assert_eq!(corners.len(), 5);
        assert!(corners.iter().all(|p| ahead(p) > 0.04 && p.0.z == 0.0));
    }

    #[test]
    fn a_perfect_picture_has_no_error_and_each_scene_a_name() {
        let scenes = PlaneScene::all(2);
        let mut names: Vec<&str> = scenes.iter().map(|s| s.id.as_str()).collect();
        for scene in &scenes {
            assert_eq!(scene.error(&scene.truth), Error::default());
            let mut off = scene.truth.clone();
            off[0] += 0.5;
            assert!((scene.error(&off).max - 0.5).abs() < 1e-12);
        }
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), 8);
    }
}

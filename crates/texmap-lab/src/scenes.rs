//! The accuracy scenes of interpolation: quads whose coordinates are known exactly at every pixel.
//!
//! Each scene can be drawn by the whole renderer ([`UvScene::by_render`], the `uv` buffer) or by the
//! rasterizer alone ([`UvScene::by_raster`]) and is judged against one f64 ray a pixel ([`UvScene::error`]).

use texmap_math::camera::Camera;
use texmap_math::glam::{DMat3, DVec2, DVec3, DVec4};
use texmap_raster::{DrawCall, Interp};
use texmap_render::{Aov, AovData, RenderSettings};
use texmap_scene::{ColorMode, Material, Mesh, Scene, Shading};

use crate::LabError;
use crate::cases::visit;
use texmap_truth::caster::{Caster, Pinhole};

/// Coordinates under each pixel, rows top to bottom; `None` where nothing is seen.
pub type UvImage = Vec<Option<DVec2>>;

/// A quad with texture coordinates before a camera.
#[derive(Clone, Debug)]
pub struct UvScene {
    /// The eye.
    pub camera: Camera,
    /// Pixels a side.
    pub size: u32,
    /// Corners, in order around the quad; every coordinate is an f32 value.
    pub corners: [DVec3; 4],
    /// Coordinates of the corners.
    pub uv: [DVec2; 4],
    /// Texels to a unit of u and v.
    pub texels: f64,
    /// Texels that a pixel may be off, unless one f32 step of its value is more.
    pub allowed: f64,
}

/// Error of an image of coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UvError {
    /// Pixels that both see.
    pub compared: usize,
    /// Pixels that only one of them sees.
    pub mismatches: f64,
    /// Largest difference of u or v.
    pub max: f64,
    /// Largest difference in texels.
    pub texels: f64,
    /// Largest difference as a part of what is allowed at its pixel: the scene's texels, or one f32 step of
    /// the larger of u and v where that is more.
    pub of_allowed: f64,
}

impl UvScene {
    /// The quad of the OpenGL conformance test of varying interpolation: w = 1.3, 0.8, 0.6, 2.0 at the corners
    /// of the picture, u and v from 0 to 1, 1024 texels.
    pub fn cts_quad() -> Self {
        Self::facing([1.3, 0.8, 0.6, 2.0], 256)
    }

    /// A plane that fills the picture with w = 1 at the left and w = `ratio` at the right.
    pub fn ratio(ratio: f64) -> Self {
        Self::facing([1.0, ratio, ratio, 1.0], 256)
    }

    /// The ground plane of the given half-size under the eye, running through the eye's plane; u = x / 8,
    /// v = z / 8, 1024 texels to a unit. 0.01 texel is allowed, 1 texel beyond a half-size of 1e5.
    pub fn ground(half: f64) -> Self {
        let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
            .map(|(x, z)| DVec3::new(x, 0.0, z) * half);
        Self::level(corners, if half > 1e5 { 1.0 } else { 0.01 })
    }

    /// A part of the ground that lies wholly behind the eye: nothing may be seen.
    pub fn behind() -> Self {
        let corners = [(-9.0, 20.0), (9.0, 20.0), (9.0, 60.0), (-9.0, 60.0)]
            .map(|(x, z)| DVec3::new(x, 0.0, z));
        Self::level(corners, 0.01)
    }

    fn level(corners: [DVec3; 4], allowed: f64) -> Self {
        let camera = Camera {
            eye: DVec3::new(0.0, 2.0, 8.0),
            look: DVec3::new(0.0, 0.0, 2.0),
            up: DVec3::Y,
            fov_x: 60f64.to_radians(),
            near: 1e-3,
            far: f64::INFINITY,
        };
        let uv = corners.map(|p| DVec2::new(p.x, p.z) / 8.0);
        Self {
            camera,
            size: 256,
            corners,
            uv,
            texels: 1024.0,
            allowed,
        }
    }

    fn facing(w: [f64; 4], size: u32) -> Self {
        let camera = Camera {
            eye: DVec3::ZERO,
            look: DVec3::NEG_Z,
            up: DVec3::Y,
            fov_x: 90f64.to_radians(),
            near: 1e-3,
            far: f64::INFINITY,
        };
        let square = [(-1.0, 1.0), (1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)];
        let corners = [0, 1, 2, 3].map(|i| {
            let (x, y) = square[i];
            (DVec3::new(x, y, -1.0) * w[i]).as_vec3().as_dvec3()
        });
        let uv = square.map(|(x, y): (f64, f64)| DVec2::new(0.5 + 0.5 * x, 0.5 - 0.5 * y));
        // 1e-6 of the range.
        Self {
            camera,
            size,
            corners,
            uv,
            texels: 1024.0,
            allowed: 1024e-6,
        }
    }

    /// Two triangles along the diagonal from corner 0 to corner 2.
    pub(crate) const TRIANGLES: [[u32; 3]; 2] = [[0, 3, 2], [0, 2, 1]];

    /// The scene for the renderer, with an untextured material.
    pub fn scene(&self, interp: Interp) -> Scene {
        let mesh = Mesh {
            positions: self.corners.map(|p| p.as_vec3().to_array()).to_vec(),
            uvs: self.uv.map(|c| c.as_vec2().to_array()).to_vec(),
            triangles: Self::TRIANGLES.to_vec(),
            ..Mesh::default()
        };
        Scene {
            background: [0.0; 4],
            color: ColorMode::Raw,
            depth_test: texmap_raster::DepthTest::Less,
            materials: vec![Material {
                shading: Shading::Unlit,
                interp,
                ..Material::default()
            }],
            meshes: vec![mesh],
            ..Scene::new(self.camera)
        }
    }

    /// The `uv` buffer of the renderer.
    ///
    /// # Errors
    /// If the renderer refuses the scene.
    pub fn by_render(&self, interp: Interp) -> Result<UvImage, LabError> {
        let settings = RenderSettings {
            aovs: vec![Aov::Uv],
            ..RenderSettings::new(self.size, self.size)
        };
        let frame =
            texmap_render::render(&self.scene(interp), &settings, &texmap_render::no_progress)?;
        let values = match frame.aovs.into_iter().next() {
            Some((_, _, AovData::F32(values))) => values,
            _ => Vec::new(),
        };
        let pair = |c: &[f32]| DVec2::new(f64::from(c[0]), f64::from(c[1]));
        Ok(values
            .chunks_exact(2)
            .map(pair)
            .map(|uv| (!uv.is_nan()).then_some(uv))
            .collect())
    }

    /// The corners as the rasterizer takes them.
    pub(crate) fn positions(&self) -> [[f32; 3]; 4] {
        self.corners.map(|p| p.as_vec3().to_array())
    }

    /// u and v of each corner.
    pub(crate) fn attributes(&self) -> Vec<f32> {
        let uv = self.uv.iter();
        uv.flat_map(|c| c.as_vec2().to_array()).collect()
    }

    /// The coordinates that the rasterizer interpolates.
    ///
    /// # Errors
    /// If the rasterizer refuses the draw.
    pub fn by_raster(&self, interp: Interp) -> Result<UvImage, LabError> {
        let (positions, attributes) = (self.positions(), self.attributes());
        let draw = DrawCall {
            positions: &positions,
            indices: &Self::TRIANGLES,
            clip_from_object: self.camera.clip_from_world(1.0)?,
            attributes: &attributes,
            attribute_count: 2,
            interp,
            ..DrawCall::default()
        };
        let mut image = self.empty();
        visit((self.size, self.size), &[draw], |x, y, fragment| {
            let uv = DVec2::new(f64::from(fragment.values[0]), f64::from(fragment.values[1]));
            image[(y * self.size + x) as usize] = Some(uv);
        })?;
        Ok(image)
    }

    /// The naive way in f32: planes of homogeneous barycentrics from the adjugate of the clip positions (Olano
    /// and Greer 1997), evaluated from the corner of the picture.
    ///
    /// # Errors
    /// If the camera has no view.
    pub fn by_f32_homogeneous(&self) -> Result<UvImage, LabError> {
        let clip = self.clip()?.map(|c| [c.x as f32, c.y as f32, c.w as f32]);
        Ok(self.naive(|corners, uv, x, y| {
            let [a, b, c] = corners.map(|i| clip[i as usize]);
            let cross = |a: [f32; 3], b: [f32; 3]| {
                [
                    a[1] * b[2] - a[2] * b[1],
                    a[2] * b[0] - a[0] * b[2],
                    a[0] * b[1] - a[1] * b[0],
                ]
            };
            let weights = [cross(b, c), cross(c, a), cross(a, b)]
                .map(|p| p[0] * x as f32 + p[1] * y as f32 + p[2]);
            let determinant = a[0] * cross(b, c)[0] + a[1] * cross(b, c)[1] + a[2] * cross(b, c)[2];
            let inside = weights.iter().all(|w| w * determinant.signum() >= 0.0);
            let sum = weights[0] + weights[1] + weights[2];
            let value = |k: usize| {
                f64::from(
                    (0..3)
                        .map(|i| weights[i] / sum * uv[i].to_array()[k] as f32)
                        .sum::<f32>(),
                )
            };
            inside.then(|| DVec2::new(value(0), value(1)))
        }))
    }

    /// The naive way of a rasterizer without a clipper. Every vertex is divided by its w, whatever its sign,
    /// and the triangle between the points so found is filled.
    ///
    /// # Errors
    /// If the camera has no view.
    pub fn by_projected_vertices(&self) -> Result<UvImage, LabError> {
        let clip = self.clip()?;
        Ok(self.naive(|corners, uv, x, y| {
            let [a, b, c] = corners
                .map(|i| clip[i as usize])
                .map(|p| DVec3::new(p.x / p.w, p.y / p.w, 1.0));
            let weights = DMat3::from_cols(a, b, c).inverse() * DVec3::new(x, y, 1.0);
            let inside = weights.min_element() >= 0.0;
            inside.then(|| uv[0] * weights.x + uv[1] * weights.y + uv[2] * weights.z)
        }))
    }

    /// The exact coordinates, by one f64 ray a pixel.
    ///
    /// # Errors
    /// If the camera has no view.
    pub fn truth(&self) -> Result<UvImage, LabError> {
        let pinhole = Pinhole::of_camera(&self.camera, self.size, self.size)?;
        let triangles = Self::TRIANGLES.map(|t| t.map(|i| self.corners[i as usize]));
        let caster = Caster::new(pinhole, self.size, self.size, &triangles);
        let pixels = (0..self.size).flat_map(|y| (0..self.size).map(move |x| (x, y)));
        let see = |(x, y): (u32, u32)| {
            let hit = caster.nearest(f64::from(x) + 0.5, f64::from(y) + 0.5, false)?;
            let uv = Self::TRIANGLES[hit.triangle as usize].map(|i| self.uv[i as usize]);
            Some(DVec2::new(
                hit.attribute(uv.map(|c| c.x)),
                hit.attribute(uv.map(|c| c.y)),
            ))
        };
        Ok(pixels.map(see).collect())
    }

    /// Judges an image of coordinates.
    ///
    /// # Errors
    /// If the camera has no view.
    pub fn error(&self, found: &UvImage) -> Result<UvError, LabError> {
        let mut error = UvError {
            compared: 0,
            mismatches: 0.0,
            max: 0.0,
            texels: 0.0,
            of_allowed: 0.0,
        };
        for (found, truth) in found.iter().zip(self.truth()?) {
            let (Some(found), Some(truth)) = (found, truth) else {
                error.mismatches += f64::from(u8::from(found.is_some() != truth.is_some()));
                continue;
            };
            let off = (*found - truth).abs().max_element();
            let off = if off.is_nan() { f64::INFINITY } else { off };
            let largest = truth.abs().max_element() as f32;
            let step = f64::from(largest.next_up() - largest) * self.texels;
            error.compared += 1;
            error.max = error.max.max(off);
            error.texels = error.texels.max(off * self.texels);
            error.of_allowed = error
                .of_allowed
                .max(off * self.texels / self.allowed.max(step));
        }
        Ok(error)
    }

    fn clip(&self) -> Result<[DVec4; 4], LabError> {
        let matrix = self.camera.clip_from_world(1.0)?;
        Ok(self.corners.map(|p| matrix * p.extend(1.0)))
    }

    fn empty(&self) -> UvImage {
        vec![None; self.size as usize * self.size as usize]
    }

    /// Fills an image from a function of a triangle and a position in -1..=1, y up.
    fn naive(&self, value: impl Fn([u32; 3], [DVec2; 3], f64, f64) -> Option<DVec2>) -> UvImage {
        let mut image = self.empty();
        let n = f64::from(self.size);
        for (index, pixel) in image.iter_mut().enumerate() {
            let (x, y) = (index as u32 % self.size, index as u32 / self.size);
            let (x, y) = (
                2.0 * (f64::from(x) + 0.5) / n - 1.0,
                1.0 - 2.0 * (f64::from(y) + 0.5) / n,
            );
            for t in Self::TRIANGLES {
                *pixel = pixel.or_else(|| value(t, t.map(|i| self.uv[i as usize]), x, y));
            }
        }
        image
    }
}

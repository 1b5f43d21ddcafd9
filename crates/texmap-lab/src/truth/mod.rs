//! A whole frame in f64: what the renderer must draw, computed without any of its code paths.
//!
//! One ray for each sample meets every triangle ([`crate::reference`]); coordinates, colours, normals and
//! positions come from its barycentrics, texels from `texmap_sample::reference`, light from
//! `texmap_light::reference`. Nothing is snapped, clipped or binned, and nothing is fast: a picture costs
//! pixels times triangles in the worst case. The interpolation that a material names is not followed: the
//! truth is perspective.

pub mod rays;
mod solids;
mod surface;

use texmap_math::det;
use texmap_math::glam::{DVec3, DVec4};
use texmap_raster::{Cull, DepthTest};
use texmap_render::{AlphaMode, ColorMode, Mesh, Scene};

use crate::LabError;
use crate::picture::Picture;
use crate::reference::{Caster, Hit, Pinhole};
use surface::Surface;

/// Two distances along a ray closer than this part of their size are one depth: the resolution of the
/// renderer's f32 depth buffer, so that surfaces in one plane tie here too.
const SAME_DEPTH: f64 = 1.0 / (1u64 << 22) as f64;

/// A frame computed in f64.
#[derive(Clone, Debug)]
pub struct Truth {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Premultiplied linear light (raw values under [`ColorMode::Raw`]), rows top to bottom.
    pub color: Vec<DVec4>,
    /// Mesh and triangle of the nearest opaque or cut-out surface at the centre of each pixel.
    pub seen: Vec<Option<(usize, u32)>>,
    mode: ColorMode,
}

impl Truth {
    /// The picture in 8-bit code values without rounding: straight alpha, sRGB (or raw), each 0..=255.
    pub fn codes(&self) -> Vec<f64> {
        let code = |c: f64| match self.mode {
            ColorMode::Srgb => encode(c),
            ColorMode::Raw => c,
        };
        let pixel = |p: &DVec4| {
            let straight = if p.w > 0.0 {
                p.truncate() / p.w
            } else {
                DVec3::ZERO
            };
            [code(straight.x), code(straight.y), code(straight.z), p.w]
                .map(|c| c.clamp(0.0, 1.0) * 255.0)
        };
        self.color.iter().flat_map(pixel).collect()
    }

    /// The picture rounded to bytes.
    pub fn picture(&self) -> Picture {
        let bytes = self
            .codes()
            .into_iter()
            .map(|c| (c + 0.5).floor() as u8)
            .collect();
        Picture::from_rgba(self.width, self.height, bytes)
            .unwrap_or_else(|| Picture::new(self.width, self.height, [0; 4]))
    }
}

/// Computes a frame with `samples` x `samples` samples a pixel.
///
/// # Errors
/// When the scene does not pass its own check.
pub fn frame(scene: &Scene, width: u32, height: u32, samples: u32) -> Result<Truth, LabError> {
    scene.check()?;
    let samples = samples.max(1);
    let (columns, rows) = (width * samples, height * samples);
    let pinhole = Pinhole::of_camera(&scene.camera, columns, rows)?;
    let surfaces = scene
        .meshes
        .iter()
        .map(|mesh| Surface::new(scene, mesh))
        .collect::<Result<Vec<_>, _>>()?;
    let (mut corners, mut owners) = (Vec::new(), Vec::new());
    for (index, surface) in surfaces.iter().enumerate() {
        for triangle in 0..surface.triangles() {
            corners.push(surface.corners(triangle));
            owners.push((index, triangle));
        }
    }
    let caster = Caster::new(pinhole, columns, rows, &corners);
    let background = background(scene);
    let mut truth = Truth {
        width,
        height,
        color: vec![DVec4::ZERO; width as usize * height as usize],
        seen: vec![None; width as usize * height as usize],
        mode: scene.color,
    };
    let view = Sight {
        scene,
        pinhole,
        surfaces: &surfaces,
        owners: &owners,
    };
    let share = 1.0 / f64::from(samples * samples);
    for y in 0..rows {
        for x in 0..columns {
            let (at_x, at_y) = (f64::from(x) + 0.5, f64::from(y) + 0.5);
            let (color, seen) = view.sample(caster.hits(at_x, at_y), at_x, at_y, background);
            let pixel = (y / samples) as usize * width as usize + (x / samples) as usize;
            truth.color[pixel] += color * share;
            if [x, y].map(|c| c % samples) == [samples / 2; 2] {
                // An even number of samples has none at the centre.
                truth.seen[pixel] = if samples % 2 == 1 {
                    seen
                } else {
                    let (x, y) = (at_x - 0.5, at_y - 0.5);
                    view.sample(caster.hits(x, y), x, y, background).1
                };
            }
        }
    }
    Ok(truth)
}

/// What is looked at, and from where.
struct Sight<'a> {
    scene: &'a Scene,
    pinhole: Pinhole,
    surfaces: &'a [Surface<'a>],
    owners: &'a [(usize, u32)],
}

impl Sight<'_> {
    /// The colour of one sample and what is seen there.
    fn sample(
        &self,
        hits: impl Iterator<Item = Hit>,
        x: f64,
        y: f64,
        background: DVec4,
    ) -> (DVec4, Option<(usize, u32)>) {
        let (near, far) = (self.scene.camera.near, self.scene.camera.far);
        let mut nearest: Option<Hit> = None;
        let mut blended = Vec::new();
        for hit in hits.filter(|hit| hit.t >= near && hit.t <= far) {
            let (surface, triangle) = self.owner(&hit);
            let material = surface.material();
            let front = surface.front(&hit);
            let culled = match material.cull {
                Cull::None => false,
                Cull::Back => !front,
                Cull::Front => front,
            };
            if culled || !surface.kept(triangle, &hit, &self.pinhole, x, y) {
                continue;
            }
            if material.alpha == AlphaMode::Blend {
                blended.push(hit);
            } else if self.passes(hit.t, nearest.map(|n| n.t)) {
                nearest = Some(hit);
            }
        }
        let mut color = background;
        if let Some(hit) = &nearest {
            let (surface, triangle) = self.owner(hit);
            color = surface.shade(triangle, hit, &self.pinhole, x, y);
        }
        for hit in blended
            .iter()
            .filter(|hit| self.passes(hit.t, nearest.map(|n| n.t)))
        {
            let (surface, triangle) = self.owner(hit);
            let over = surface.shade(triangle, hit, &self.pinhole, x, y);
            color = over + color * (1.0 - over.w);
        }
        (color, nearest.map(|hit| self.owners[hit.triangle as usize]))
    }

    fn owner(&self, hit: &Hit) -> (&Surface<'_>, u32) {
        let (surface, triangle) = self.owners[hit.triangle as usize];
        (&self.surfaces[surface], triangle)
    }

    /// The depth test against what was drawn before.
    fn passes(&self, t: f64, before: Option<f64>) -> bool {
        let Some(before) = before else { return true };
        let same = (t - before).abs() <= SAME_DEPTH * before;
        match self.scene.depth_test {
            DepthTest::Less => t < before && !same,
            DepthTest::LessOrEqual => t < before || same,
            DepthTest::Always => true,
        }
    }
}

fn background(scene: &Scene) -> DVec4 {
    let [r, g, b, a] = scene.background.map(f64::from);
    let light = |c: f64| match scene.color {
        ColorMode::Srgb => decode(c),
        ColorMode::Raw => c,
    };
    DVec4::new(light(r) * a, light(g) * a, light(b) * a, a)
}

/// sRGB to linear light (IEC 61966-2-1).
fn decode(c: f64) -> f64 {
    if c <= 0.04045 {
        c / 12.92
    } else {
        det::pow((c + 0.055) / 1.055, 2.4)
    }
}

/// Linear light to sRGB.
fn encode(c: f64) -> f64 {
    if c <= 0.003_130_8 {
        c * 12.92
    } else {
        1.055 * det::pow(c, 1.0 / 2.4) - 0.055
    }
}

/// The world positions of a mesh's vertices.
fn world(mesh: &Mesh) -> Vec<DVec3> {
    mesh.positions
        .iter()
        .map(|p| mesh.world_from_object.transform_point3(wide(*p)))
        .collect()
}

fn wide(a: [f32; 3]) -> DVec3 {
    DVec3::from_array(a.map(f64::from))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn transfer_curves_invert_each_other() {
        for i in 0..=100 {
            let c = f64::from(i) / 100.0;
            assert!((encode(decode(c)) - c).abs() < 1e-7, "{c}");
        }
        assert!((decode(0.5) - 0.214_041_140_482_232_55).abs() < 1e-12);
    }
}

//! A ray through a volume of emitting and absorbing matter, front to back. Source: Max 1995, "Optical Models for
//! Direct Volume Rendering", emission and absorption.

use crate::{
    address::{lod, wrap::Wrap},
    batch::{Batch, Places},
    bound_texture::BoundTexture,
    error::SampleError,
    sampler::{Filter, Sampler},
    texture::Texture2d,
    volume::{Texture3d, UvwBatch, VolumeView},
};
use alloc::boxed::Box;
use texmap_math::{Level, deterministic_f32, float, simd::Scalar};

/// Transmittance below which a ray ends: less than one code of 255, even of white in the dark.
pub const OPAQUE: f32 = 1.0 / 4096.0;

/// Most steps of a ray; a finer step is widened.
pub const MAX_STEPS: u32 = 1 << 16;

/// Matter in the unit cube.
///
/// Without a transfer function a voxel's largest channel is how dense it is and its colour is itself over that (a
/// single channel is white); a grid with an [alpha channel](Texture3d::has_alpha_channel) has its density there, also if
/// all of it is 1. With one, the voxel's first channel is looked up along it: a dependent look-up, whose colour shines and
/// whose alpha is the density.
#[derive(Clone, Debug)]
pub struct VolumeIntegrator<'a> {
    grid: &'a Texture3d<'a>,
    sampler: &'a Sampler,
    transfer: Option<(&'a Texture2d<'a>, &'a Sampler)>,
    density: f32,
    step: f32,
    lanes: Option<Box<Lanes<'a>>>,
}

/// Bound textures for look-ups of sixteen steps at once.
#[derive(Clone, Debug)]
struct Lanes<'a> {
    level: Level,
    voxels: VolumeView<'a>,
    transfer: Option<(BoundTexture<'a>, &'a Sampler)>,
}

/// Steps that are looked up at once.
const STEPS: usize = 16;
/// So few steps cost less one by one.
const FEW: u32 = 4;

/// Colour and number of look-ups of one ray.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RayRadiance {
    /// Premultiplied colour, linear light; alpha is what the volume hides of that behind it.
    pub color: [f32; 4],
    /// Voxels looked up.
    pub steps: u32,
}

impl<'a> VolumeIntegrator<'a> {
    /// `density` is the extinction of density 1, per unit of the ray's parameter. Through a length L of it shows
    /// `exp(-density L)` of what is behind. `step` is the distance of look-ups in the same unit. With a filter that reads
    /// mip levels a step longer than a voxel reads a level whose voxels are about as long.
    ///
    /// # Errors
    /// [`SampleError::March`] unless `density` is finite and not negative and `step` finite and above 0.
    pub fn new(
        grid: &'a Texture3d<'a>,
        sampler: &'a Sampler,
        transfer: Option<(&'a Texture2d<'a>, &'a Sampler)>,
        density: f32,
        step: f32,
    ) -> Result<Self, SampleError> {
        if !(density.is_finite() && density >= 0.0 && step.is_finite() && step > 0.0) {
            return Err(SampleError::March { density, step });
        }
        Ok(Self {
            grid,
            sampler,
            transfer,
            density,
            step,
            lanes: None,
        })
    }

    /// With look-ups of sixteen steps of a ray at once by the level's instructions. No bit of what a ray sees depends on it.
    #[must_use]
    pub fn on_level(mut self, level: Level) -> Self {
        let transfer = self
            .transfer
            .map(|(ramp, along)| Some((BoundTexture::new(along, ramp)?, along)));
        let voxels = VolumeView::new(self.sampler, self.grid, Wrap::ClampToEdge);
        self.lanes = match (voxels, transfer) {
            (Some(voxels), None) => Some((voxels, None)),
            (Some(voxels), Some(Some(transfer))) => Some((voxels, Some(transfer))),
            _ => None,
        }
        .map(|(voxels, transfer)| {
            Box::new(Lanes {
                level,
                voxels,
                transfer,
            })
        });
        self
    }

    /// The ray `origin + t direction` for t in `span`, in the space of the unit cube. The eye may be inside. The part
    /// inside is cut into equal steps of at most `step`, each looked up at its middle and weighed by
    /// `1 - exp(-density step)`, so the result does not depend on the step where the matter does not change. A ray that
    /// misses, or is not finite, sees nothing.
    pub fn integrate(
        &self,
        origin: [f64; 3],
        direction: [f64; 3],
        span: (f64, f64),
    ) -> RayRadiance {
        let mut seen = RayRadiance::default();
        let Some((near, far)) = through(origin, direction, span) else {
            return seen;
        };
        let length = far - near;
        let wanted = float::ceil(length / f64::from(self.step));
        let count = if wanted >= f64::from(MAX_STEPS) {
            MAX_STEPS
        } else if wanted >= 1.0 {
            wanted as u32
        } else {
            1
        };
        let step = length / f64::from(count);
        let lod = self.level(direction, step);
        // Finite, so that a density of 0 stays none.
        let depth = self.density * (step as f32).min(f32::MAX);
        // Many steps of little matter: 32-bit sums would lose what each adds.
        let (mut left, mut sums) = (1.0f64, [0.0f64; 3]);
        let at = |i: u32| {
            let t = near + (f64::from(i) + 0.5) * step;
            [0, 1, 2].map(|k| (origin[k] + t * direction[k]) as f32)
        };
        let mut ahead = [([0.0; 3], 0.0); STEPS];
        'steps: for first in (0..count).step_by(STEPS) {
            let part = (count - first).min(STEPS as u32);
            let lanes = self.lanes.as_ref().filter(|_| part > FEW);
            if let Some(lanes) = lanes {
                let points = core::array::from_fn(|i| at(first + (i as u32).min(part - 1)));
                self.look_up(lanes, &points, lod, &mut ahead);
            }
            for i in 0..part {
                let ([r, g, b], dense) = if lanes.is_some() {
                    ahead[i as usize]
                } else {
                    self.density_at(at(first + i), lod)
                };
                seen.steps += 1;
                if dense > 0.0 {
                    let weight = left * f64::from(absorbed(depth * dense));
                    for (sum, c) in sums.iter_mut().zip([r, g, b]) {
                        *sum += weight * f64::from(c);
                    }
                    left -= weight;
                    if left < f64::from(OPAQUE) {
                        break 'steps;
                    }
                }
            }
        }
        let [r, g, b] = sums.map(|sum| sum as f32);
        seen.color = [r, g, b, (1.0 - left) as f32];
        seen
    }

    /// Straight colour and density, 0 or more, at a point of the unit cube.
    pub fn density_at(&self, at: [f32; 3], lod: f32) -> ([f32; 3], f32) {
        let voxel = self
            .sampler
            .sample_3d(self.grid, at, Wrap::ClampToEdge, lod);
        match self.transfer {
            Some((ramp, along)) => straight(along.sample_lod(ramp, [voxel[0], 0.5], 0.0)),
            None => straight(self.dense(voxel)),
        }
    }

    /// [`density_at`](Self::density_at) of the steps ahead.
    fn look_up(
        &self,
        lanes: &Lanes<'_>,
        points: &[[f32; 3]; STEPS],
        lod: f32,
        out: &mut [([f32; 3], f32); STEPS],
    ) {
        let [u, v, w] = [0, 1, 2].map(|k| points.map(|p| p[k]));
        let at = UvwBatch {
            u: &u,
            v: &v,
            w: &w,
            lod: Some(&[lod; STEPS]),
        };
        let mut columns = [[0.0; STEPS]; 4];
        let colors = columns.each_mut().map(|c| &mut c[..]);
        lanes.voxels.columns(lanes.level, &at, colors);
        if let Some((view, along)) = &lanes.transfer {
            let values = columns[0];
            let at = Places {
                u: &values,
                v: &[0.5; STEPS],
                gradients: None,
            };
            let ramp = Batch::new(along, view, at);
            ramp.columns(lanes.level, columns.each_mut().map(|c| &mut c[..]));
        }
        let [r, g, b, a] = &columns;
        for (i, out) in out.iter_mut().enumerate() {
            let c = [r[i], g[i], b[i], a[i]];
            *out = straight(if lanes.transfer.is_some() {
                c
            } else {
                self.dense(c)
            });
        }
    }

    /// A voxel with its density for its alpha.
    fn dense(&self, [r, g, b, a]: [f32; 4]) -> [f32; 4] {
        if self.grid.has_alpha_channel() {
            return [r, g, b, a];
        }
        let most = if r > g { r } else { g };
        [r, g, b, if most > b { most } else { b }]
    }

    /// The level whose voxels a step is long.
    fn level(&self, direction: [f64; 3], step: f64) -> f32 {
        if matches!(self.sampler.filter, Filter::Nearest | Filter::Bilinear)
            || self.grid.levels() == 1
        {
            return 0.0;
        }
        let size = self.grid.level_size(0).unwrap_or([1; 3]);
        let voxels = [0, 1, 2].map(|k| (step * direction[k] * f64::from(size[k])) as f32);
        0.5 * lod::log2(Scalar, voxels.iter().map(|v| v * v).sum())
    }
}

/// `1 - exp(-depth)` for a depth of 0 or more. Near 0 by its series, as the exponential has few digits below 1 there.
fn absorbed(depth: f32) -> f32 {
    if depth < 0.015_625 {
        depth * (1.0 - depth * (0.5 - depth * (1.0 / 6.0 - depth * (1.0 / 24.0))))
    } else {
        1.0 - deterministic_f32::exp(-depth)
    }
}

/// Straight colour, finite, and how dense it is.
fn straight([r, g, b, a]: [f32; 4]) -> ([f32; 3], f32) {
    if a > 0.0 {
        ([r, g, b].map(|c| (c / a).min(f32::MAX)), a)
    } else {
        ([0.0; 3], 0.0)
    }
}

/// The part of a ray that lies in the unit cube, within `span`. `None` if none does (Kay and Kajiya 1986: slabs). A ray
/// that runs along a slab is inside of it all the way or not at all; on its face counts as inside.
fn through(origin: [f64; 3], direction: [f64; 3], span: (f64, f64)) -> Option<(f64, f64)> {
    let (mut near, mut far) = span;
    for k in 0..3 {
        let (o, d) = (origin[k], direction[k]);
        if !(o.is_finite() && d.is_finite()) {
            return None;
        }
        if d == 0.0 {
            if !(0.0..=1.0).contains(&o) {
                return None;
            }
            continue;
        }
        let (a, b) = (-o / d, (1.0 - o) / d);
        let (first, last) = if a < b { (a, b) } else { (b, a) };
        if first > near {
            near = first;
        }
        if last < far {
            far = last;
        }
    }
    (near < far && near.is_finite() && far.is_finite()).then_some((near, far))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::texture::{Alpha, ColorSpace, Image, Origin};

    /// Fine steps add up to what the closed form says, however thin the matter is; alphas of 1 and above are a density as others are.
    #[test]
    fn fine_steps_lose_nothing() {
        for alpha in [1e-3f32, 0.02, 0.5, 1.0, 2.0] {
            let grid = Texture3d::new(
                1,
                &Image {
                    width: 1,
                    height: 1,
                    channels: 4,
                    texels: crate::texel_data::TexelData::F32(&[
                        alpha / 4.0,
                        alpha / 2.0,
                        0.0,
                        alpha,
                    ]),
                    color: ColorSpace::Linear,
                    alpha: Alpha::Premultiplied,
                    origin: Origin::TopLeft,
                },
            )
            .unwrap();
            let exact = 1.0 - texmap_math::deterministic_f64::exp(-f64::from(alpha));
            let sampler = Sampler::default();
            for step in [0.1, 1e-3, 1e-5] {
                let volume = VolumeIntegrator::new(&grid, &sampler, None, 1.0, step).unwrap();
                let seen = volume.integrate([0.5, 0.5, -1.0], [0.0, 0.0, 1.0], (0.0, 10.0));
                for (got, share) in seen.color.into_iter().zip([0.25, 0.5, 0.0, 1.0]) {
                    let right = share * exact;
                    assert!(
                        (f64::from(got) - right).abs() <= 2e-6 * exact,
                        "{alpha} {step}: {got} {right}"
                    );
                }
            }
        }
        // A density of 0 hides nothing, even where the parameter of the ray leaves f32 within the cube.
        let grid = Texture3d::new(
            1,
            &Image {
                width: 1,
                height: 1,
                channels: 1,
                texels: crate::texel_data::TexelData::F32(&[1.0]),
                color: ColorSpace::Linear,
                alpha: Alpha::Data,
                origin: Origin::TopLeft,
            },
        )
        .unwrap();
        let sampler = Sampler::default();
        let volume = VolumeIntegrator::new(&grid, &sampler, None, 0.0, 0.1).unwrap();
        let seen = volume.integrate([0.5, 0.5, 0.0], [0.0, 0.0, 1e-45], (0.0, f64::MAX));
        assert_eq!(seen.color, [0.0; 4]);
        // A voxel of nearly no matter has no endless colour.
        assert!(straight([1.0, 0.0, 0.0, 1e-39]).0[0].is_finite());
    }
}

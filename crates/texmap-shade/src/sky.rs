//! The sky: an environment seen from inside.

use texmap_light::lanes::{RayLanes, Vector};
use texmap_light::{Environment, EnvironmentLight};
use texmap_math::glam::DMat4;
use texmap_math::simd::Isa;
use texmap_math::{Level, ViewRays, dispatch_simd};

use crate::batch::{Batch, Colors, LANES};
use crate::compose::Display;
use crate::coordinates::EyeRays;

/// Light by direction.
#[derive(Clone, Copy)]
pub enum Sky<'s> {
    /// An environment, read without blur.
    Chart(&'s Environment),
    /// An environment that lights, read at its sharpest level.
    Light(&'s EnvironmentLight),
}

impl Sky<'_> {
    /// Angle of a texel.
    fn step(self) -> f64 {
        let texels = match self {
            Self::Chart(environment) => {
                let (width, height) = environment.size();
                let faces = environment.layout().faces() as f64;
                f64::from(width) * f64::from(height) * faces
            }
            Self::Light(light) => 6.0 * f64::from(light.size()) * f64::from(light.size()),
        };
        (4.0 * std::f64::consts::PI / texels).sqrt()
    }

    #[inline(always)]
    fn radiance<I: Isa>(self, i: I, direction: Vector<I>) -> Vector<I> {
        let zero = i.f32(0.0);
        match self {
            Self::Chart(environment) => {
                let ray = RayLanes {
                    direction,
                    dx: [zero; 3],
                    dy: [zero; 3],
                };
                environment.radiance_lanes(i, &ray)
            }
            Self::Light(light) => light.radiance_lanes(i, zero, direction),
        }
    }
}

/// An environment as a sky.
pub struct SkyStage<'s> {
    sky: Sky<'s>,
    /// Through the positions in a pixel that are looked up: one or more for each texel that it sees.
    rays: Vec<EyeRays>,
    display: Display,
}

impl<'s> SkyStage<'s> {
    /// The sky behind every pixel that no opaque surface covers.
    pub fn new(sky: Sky<'s>, rays: &ViewRays, view_from_world: DMat4, display: Display) -> Self {
        let side = (rays.step() / sky.step()).ceil().clamp(1.0, 8.0) as u32;
        let middle = EyeRays::new(rays, view_from_world);
        let inside = |k: u32| (f64::from(k) + 0.5) / f64::from(side) - 0.5;
        let places = (0..side).flat_map(|j| (0..side).map(move |i| (i, j)));
        Self {
            sky,
            display,
            rays: places
                .map(|(i, j)| middle.beside([inside(i), inside(j)]))
                .collect(),
        }
    }

    /// The light behind the fragments of a batch, as display light.
    pub fn shade(&self, level: Level, batch: &Batch<'_>, out: &mut Colors) {
        dispatch_simd!(level, i => for (index, block) in batch.list.iter().enumerate() {
            self.shade_block(i, batch.sample(*block, 0), index * LANES, out);
        });
    }

    #[inline(always)]
    fn shade_block<I: Isa>(&self, i: I, sample: [u32; 2], first: usize, out: &mut Colors) {
        let (zero, one) = (i.f32(0.0), i.f32(1.0));
        for pixel in (0..LANES).step_by(I::LANES) {
            let mut sum = [zero; 3];
            for rays in &self.rays {
                let [x, y, z] = rays.part(i, sample, pixel);
                let light = self.sky.radiance(i, [-x, -y, -z]);
                for k in 0..3 {
                    sum[k] = sum[k] + light[k];
                }
            }
            let count = self.rays.len() as f32;
            let [r, g, b] = [sum[0] / count, sum[1] / count, sum[2] / count];
            let [r, g, b] = self.display.of(i, [r, g, b]);
            out.store(i, first + pixel, [r, g, b, one]);
        }
    }
}

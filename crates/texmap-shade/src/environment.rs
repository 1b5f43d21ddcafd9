//! Reflections: the light of environments in the direction of the mirrored ray.

use texmap_light::lanes::{RayLanes, dot, reflect_across, splat};
use texmap_light::{Environment, ReflectionBox};
use texmap_math::simd::{Isa, prelude::*};

use crate::Slot;
use crate::batch::{Part, flip, load_changes, load_vector, parts};
use crate::coordinates::EyeRays;
use crate::stage::{Inputs, Kernel, ShadeColumns};

/// The light of an environment that a surface reflects, added to its highlights.
pub struct Reflection<'a> {
    /// The environment that is mirrored.
    pub environment: &'a Environment,
    /// Factor of its light, and a texture that multiplies it.
    pub share: f32,
    /// A map of reflectivity, which multiplies `share`.
    pub map: Option<&'a Slot<'a>>,
    /// Walls that mirrored rays are led to.
    pub within: Option<ReflectionBox>,
    /// Rays from the eye.
    pub rays: EyeRays,
}

impl Kernel for Reflection<'_> {
    fn read(&self, inputs: &Inputs<'_>, columns: &mut ShadeColumns) {
        if let Some(slot) = self.map {
            columns.fetch(inputs, slot);
        }
    }

    #[inline(always)]
    fn lanes<I: Isa>(&self, i: I, inputs: &Inputs<'_>, columns: &mut ShadeColumns) {
        for part in parts(i, inputs.batch.list) {
            let mut share = i.f32(self.share);
            if self.map.is_some() {
                let [factor, ..] = columns.texels.straight(i, part.at);
                share = factor * self.share;
            }
            let ray = self.ray(i, inputs, columns, &part);
            let light = self.environment.radiance_lanes(i, &ray);
            let mut sum = columns.highlight.load(i, part.at);
            for k in 0..3 {
                sum[k] = sum[k] + light[k] * share;
            }
            columns.highlight.store(i, part.at, sum);
        }
    }
}

impl Reflection<'_> {
    /// The mirrored view. The bends of the normal detail are left out of its change.
    #[inline(always)]
    fn ray<I: Isa>(
        &self,
        i: I,
        inputs: &Inputs<'_>,
        columns: &ShadeColumns,
        part: &Part,
    ) -> RayLanes<I> {
        let at = part.at;
        let view = RayLanes {
            direction: self
                .rays
                .part(i, inputs.batch.sample(part.block, 0), part.pixel),
            dx: splat(i, self.rays.dx),
            dy: splat(i, self.rays.dy),
        };
        let back = part.mask(i, inputs.sides.back[part.index]);
        let smooth = flip(i, back, load_vector(i, inputs.vectors.normal, at));
        let [normal_dx, normal_dy] = load_changes(i, inputs.vectors.normal, at);
        let normal = RayLanes {
            direction: columns.normal.load(i, at),
            dx: flip(i, back, normal_dx),
            dy: flip(i, back, normal_dy),
        };
        let mirrored = reflect_across(i, &view, &normal, dot(smooth, smooth).sqrt());
        let (Some(walls), Some(position)) = (&self.within, inputs.vectors.position) else {
            return mirrored;
        };
        let [dx, dy] = load_changes(i, position, at);
        let position = RayLanes {
            direction: load_vector(i, position, at),
            dx,
            dy,
        };
        walls.led(i, &position, &mirrored)
    }
}

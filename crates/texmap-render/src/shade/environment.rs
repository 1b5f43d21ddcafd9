//! Reflections: the light of environments in the direction of the mirrored ray.

use texmap_light::Environment;
use texmap_light::lanes::{RayLanes, TermsLanes, Vector, dot, reflect_across, splat};
use texmap_math::simd::{Isa, prelude::*};

use super::batch::{Batch, Part, flip, load_changes};
use super::coordinates::EyeRays;
use super::normal::Vectors;

/// The reflections of a surface.
pub(crate) struct Reflections<'a> {
    /// The environment that is mirrored, and its reflectivity.
    pub(crate) mirror: Option<(&'a Environment, f32)>,
    /// The environment of highlights, and the factor of its light.
    pub(crate) specular: Option<(&'a Environment, f32)>,
    pub(crate) rays: EyeRays,
}

impl Reflections<'_> {
    pub(crate) fn is_empty(&self) -> bool {
        self.mirror.is_none() && self.specular.is_none()
    }

    /// Adds the reflected light to the highlights. `smooth` are the normals of the vertices on the side that is seen, `normal` the unit
    /// normals of the surface: the bends of its detail are left out of the change of the ray. `reflectivity` is a factor by a map.
    #[inline(always)]
    pub(crate) fn add<I: Isa, const ALL: bool>(
        &self,
        i: I,
        (batch, part): (&Batch<'_>, &Part),
        vectors: &Vectors<'_>,
        back: I::Mask,
        [smooth, normal]: [Vector<I>; 2],
        reflectivity: Option<I::F32>,
        terms: &mut TermsLanes<I>,
    ) {
        let first = batch.sample(part.block, 0);
        let view = RayLanes {
            direction: self.rays.part(i, first, part.pixel),
            dx: splat(i, self.rays.dx),
            dy: splat(i, self.rays.dy),
        };
        let [normal_dx, normal_dy] = load_changes(i, vectors.normal, part.at);
        let length = dot(smooth, smooth).sqrt();
        let normal = RayLanes {
            direction: normal,
            dx: flip(i, back, normal_dx),
            dy: flip(i, back, normal_dy),
        };
        let ray = reflect_across(i, &view, &normal, length);
        if let Some((mirror, share)) = self.mirror {
            let share = match reflectivity {
                Some(factor) if ALL => factor * share,
                _ => i.f32(share),
            };
            add(&mut terms.highlight, mirror.radiance_lanes(i, &ray), share);
        }
        if ALL && let Some((map, share)) = self.specular {
            add(
                &mut terms.highlight,
                map.radiance_lanes(i, &ray),
                i.f32(share),
            );
        }
    }
}

#[inline(always)]
fn add<F: Number<f32>>(sum: &mut [F; 3], light: [F; 3], share: F) {
    for (sum, light) in sum.iter_mut().zip(light) {
        *sum = *sum + light * share;
    }
}

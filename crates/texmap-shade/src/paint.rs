//! Projectors that paint: their texels over the base color.

use texmap_light::lanes::{Vector, dot, splat};
use texmap_math::simd::{Isa, prelude::*};

use crate::batch::{Part, load_vector, parts};
use crate::lighting::visibility;
use crate::projector::Projected;
use crate::stage::{Inputs, Kernel, ShadeColumns};

/// Projectors that paint, the later over the earlier. `first` is the index of the first among those of the surface.
#[derive(Clone)]
pub struct Paint<'a> {
    /// The projectors.
    pub projectors: Vec<&'a Projected<'a>>,
    /// Index of the first in the texels of the inputs.
    pub first: usize,
}

impl Paint<'_> {
    /// The paint over straight colors of a part.
    #[inline(always)]
    pub(crate) fn over<I: Isa>(
        &self,
        i: I,
        inputs: &Inputs<'_>,
        part: &Part,
        base: Vector<I>,
    ) -> Vector<I> {
        let Some(position) = inputs.vectors.position else {
            return base;
        };
        let (at, one) = (part.at, i.f32(1.0));
        let mut sum = [i.f32(0.0); 4];
        let point = load_vector(i, position, at);
        let plane = inputs.sides.plane.load(i, at);
        let texels = &inputs.projectors[self.first..];
        for (projected, texels) in self.projectors.iter().zip(texels) {
            let Some(texel) = texels.load(i, part.index, part.pixel) else {
                continue;
            };
            let mut toward = splat(i, projected.position);
            for k in 0..3 {
                toward[k] = toward[k] - point[k];
            }
            let on = dot(plane, toward).simd_gt(0.0) & texel[3].simd_gt(0.0);
            let on = on & part.mask(i, part.block.mask);
            let share = match &projected.shadow {
                Some(shadow) => visibility(i, shadow, on, point, plane),
                None => one,
            };
            let keep = one - texel[3] * share;
            for k in 0..4 {
                sum[k] = on.select(texel[k] * share + keep * sum[k], sum[k]);
            }
        }
        let ([r, g, b, a], [base_r, base_g, base_b]) = (sum, base);
        let keep = one - a;
        [r + keep * base_r, g + keep * base_g, b + keep * base_b]
    }
}

impl Kernel for Paint<'_> {
    #[inline(always)]
    fn lanes<I: Isa>(&self, i: I, inputs: &Inputs<'_>, columns: &mut ShadeColumns) {
        for part in parts(i, inputs.batch.list) {
            let [r, g, b, alpha] = columns.color.load(i, part.at);
            let [r, g, b] = self.over(i, inputs, &part, [r, g, b]);
            columns.color.store(i, part.at, [r, g, b, alpha]);
        }
    }
}

//! OpenGL's choices of texels and levels: `mag` on level 0 where nothing is minified, else `min` and `mip`. In f32, then in bytes.

use super::{
    ANY, At, View,
    float::{self, Color},
    packed,
};
use crate::sampler::{Mip, Texel};
use texmap_math::{
    fearless_simd::{f32x16, i32x16, mask32x16, prelude::*, u32x16},
    lanes::floor_to_i32,
};

/// OpenGL's choice of texels and levels for sixteen lanes, scaled: `mag` on level 0 where nothing is minified, else `min` and `mip`.
#[inline(always)]
pub fn float_lanes<S: Simd>(
    s: S,
    view: &View<'_>,
    gl: (Texel, Texel, Mip),
    [u, v]: [f32x16<S>; 2],
    lod: f32x16<S>,
) -> Color<S> {
    let reads = Reads::new(s, view, gl, lod);
    let mut colors = reads.none(s);
    for (color, (wanted, texel, level)) in colors.iter_mut().zip(&reads.levels) {
        if *wanted {
            let at = At::of(s, view, *level);
            *color = match texel {
                Texel::Nearest => float::nearest_at::<S, ANY>(s, view, &at, u, v),
                Texel::Linear => float::bilinear_at::<S, ANY>(s, view, &at, u, v),
            };
        }
    }
    float::scaled(reads.blended(view, colors), view)
}

/// What OpenGL's choices read, in a list: code that reads a level stands once.
pub(crate) struct Reads<S: Simd> {
    /// Whether some lane reads it, which texels, of which level: that of magnified lanes, the finer of the others and the coarser.
    pub(crate) levels: [(bool, Texel, i32x16<S>); 3],
    magnified: mask32x16<S>,
    /// Lanes that blend two levels, and the share of the coarser.
    two: mask32x16<S>,
    weight: f32x16<S>,
}

impl<S: Simd> Reads<S> {
    #[inline(always)]
    pub(crate) fn new(
        s: S,
        view: &View<'_>,
        (mag, min, mip): (Texel, Texel, Mip),
        lod: f32x16<S>,
    ) -> Self {
        let (zero, none) = (f32x16::splat(s, 0.0), i32x16::splat(s, 0));
        let magnified = lod.simd_le(zero);
        let top = f32x16::splat(s, view.last as f32);
        let lod = lod.simd_gt(top).select(top, lod);
        let lod = magnified.select(zero, lod);
        let fine = match mip {
            Mip::None => none,
            // ceil(lod + 0.5) - 1: halves go to the finer level.
            Mip::Nearest => -1 - floor_to_i32(s, -0.5 - lod),
            Mip::Linear => lod.to_int::<i32x16<S>>(),
        };
        let weight = match mip {
            Mip::Linear => lod - fine.to_float::<f32x16<S>>(),
            _ => zero,
        };
        let (two, last) = (weight.simd_gt(zero), i32x16::splat(s, view.last));
        let next = fine + 1;
        let next = next.simd_gt(last).select(last, next);
        Self {
            levels: [
                (magnified.any_true(), mag, none),
                (!magnified.all_true(), min, fine),
                (two.any_true(), min, next),
            ],
            magnified,
            two,
            weight,
        }
    }

    /// Colours that are not read.
    #[inline(always)]
    pub(crate) fn none(&self, s: S) -> [Color<S>; 3] {
        [[f32x16::splat(s, 0.0); 4]; 3]
    }

    #[inline(always)]
    pub(crate) fn blended(&self, view: &View<'_>, [near, fine, coarse]: [Color<S>; 3]) -> Color<S> {
        let far = float::select(self.two, float::mix(view, fine, coarse, self.weight), fine);
        float::select(self.magnified, near, far)
    }
}

/// [`float_lanes`] with weights of a byte; `lod` has 8 fraction bits.
#[inline(always)]
pub fn byte_lanes<S: Simd>(
    s: S,
    view: &View<'_>,
    (mag, min, mip): (Texel, Texel, Mip),
    [u, v]: [f32x16<S>; 2],
    lod: i32x16<S>,
) -> u32x16<S> {
    let zero = i32x16::splat(s, 0);
    let magnified = lod.simd_le(zero);
    let (last, top) = (
        i32x16::splat(s, view.last),
        i32x16::splat(s, view.last << 8),
    );
    let lod = lod.simd_gt(top).select(top, lod);
    let lod = magnified.select(zero, lod);
    let (fine, weight) = match mip {
        Mip::None => (zero, zero),
        // ceil(lod + 1/2) - 1: halves go to the finer level.
        Mip::Nearest => ((lod + 127) >> 8, zero),
        Mip::Linear => (lod >> 8, lod & 255),
    };
    let next = fine + 1;
    let next = next.simd_gt(last).select(last, next);
    // One place in the code for all that may be read.
    let reads = [
        (magnified.any_true(), mag, zero),
        (!magnified.all_true(), min, fine),
        (weight.simd_gt(zero).any_true(), min, next),
    ];
    let mut texels = [u32x16::splat(s, 0); 3];
    for (to, (wanted, texel, level)) in texels.iter_mut().zip(&reads) {
        if *wanted {
            let at = At::of(s, view, *level);
            *to = match texel {
                Texel::Nearest => packed::nearest_at(s, view, &at, u, v),
                Texel::Linear => packed::join(packed::bilinear_at::<S>(s, view, &at, u, v)),
            };
        }
    }
    let [near, fine, coarse] = texels;
    let far = packed::lerp_lanes(
        s,
        packed::halves(fine),
        packed::halves(coarse),
        packed::spread(weight),
    );
    magnified.select(near, packed::join(far))
}

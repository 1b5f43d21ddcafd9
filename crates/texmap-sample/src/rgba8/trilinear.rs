//! Bilinear on the two mip levels around.

use super::bilinear::{bilinear_at, steps};
use crate::{
    address::texel::LaneLevel,
    bound_texture::BoundTexture,
    filter::{ByteKernel, LookUp},
};
use texmap_math::simd::{ByteIsa, prelude::*};

pub(crate) struct Trilinear;

impl ByteKernel for Trilinear {
    const WIDE: bool = true;

    #[inline(always)]
    fn word<I: ByteIsa>(i: I, view: &BoundTexture<'_>, at: &LookUp<I>) -> I::U32 {
        let [u, v] = at.uv;
        trilinear(i, view, u, v, at.fixed_lod(i, view))
    }
}

/// Trilinear at a level with 8 fraction bits: vectors of one level take short cuts.
#[inline(always)]
pub fn trilinear<I: ByteIsa>(
    i: I,
    view: &BoundTexture<'_>,
    u: I::F32,
    v: I::F32,
    lod: I::I32,
) -> I::U32 {
    let top = i.i32(view.last << 8);
    let lod = lod.simd_gt(top).select(top, lod);
    let lod = lod.simd_gt(0).select(lod, i.i32(0));
    let (level, weight) = (lod >> 8, lod & 255);
    let [fine, coarse] = LaneLevel::pair(i, view, level);
    let at = steps(i, view, &fine, [u, v]);
    let a = bilinear_at(i, view, &fine, at);
    if weight.simd_eq(0).all_true() {
        return i.words(a);
    }
    // Powers of two times a coordinate are exact: a level of half the size has half the steps, rounded down. If a side is one
    // texel long, all positions on it are the same, and if there is no next level it weighs nothing.
    let at = if view.masked {
        [at[0] >> 1, at[1] >> 1]
    } else {
        steps(i, view, &coarse, [u, v])
    };
    let b = bilinear_at(i, view, &coarse, at);
    i.words(i.lerp_bytes(a, b, i.weights(weight)))
}

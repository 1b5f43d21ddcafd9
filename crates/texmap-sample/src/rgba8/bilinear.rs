//! Four texels weighted by distance.

use super::tap;
use crate::{
    address::texel::{Corners, LaneLevel},
    bound_texture::{BoundTexture, RGBA8},
    filter::{ByteKernel, LookUp},
};
use texmap_math::simd::{ByteIsa, Isa, prelude::*};

pub(crate) struct Bilinear;

impl ByteKernel for Bilinear {
    const WIDE: bool = true;

    #[inline(always)]
    fn word<I: ByteIsa>(i: I, view: &BoundTexture<'_>, at: &LookUp<I>) -> I::U32 {
        let [u, v] = at.uv;
        bilinear(i, view, u, v)
    }
}

/// Bilinear on level 0 for each lane.
#[inline(always)]
pub fn bilinear<I: ByteIsa>(i: I, view: &BoundTexture<'_>, u: I::F32, v: I::F32) -> I::U32 {
    let level = LaneLevel::uniform(i, view, 0);
    i.words(bilinear_in(i, view, &level, [u, v]))
}

#[inline(always)]
pub(super) fn bilinear_in<I: ByteIsa>(
    i: I,
    view: &BoundTexture<'_>,
    level: &LaneLevel<I>,
    uv: [I::F32; 2],
) -> I::Bytes {
    bilinear_at(i, view, level, steps(i, view, level, uv))
}

/// Coordinates in whole 256ths of texels of a level.
#[inline(always)]
pub(super) fn steps<I: Isa>(
    i: I,
    view: &BoundTexture<'_>,
    level: &LaneLevel<I>,
    uv: [I::F32; 2],
) -> [I::I32; 2] {
    let [x, y] = level.scale(i, view, uv);
    [x.floor_to_i32(), y.floor_to_i32()]
}

/// [`bilinear_in`] at such coordinates.
#[inline(always)]
pub(super) fn bilinear_at<I: ByteIsa>(
    i: I,
    view: &BoundTexture<'_>,
    level: &LaneLevel<I>,
    [x, y]: [I::I32; 2],
) -> I::Bytes {
    debug_assert_eq!(view.format, RGBA8, "bytes that are read whole");
    let (x, y) = (x - 128, y - 128);
    let (wx, wy) = (i.weights(x & 255), i.weights(y & 255));
    let [a, b, c, d] = match level.corners::<RGBA8>(i, view, [x >> 8, y >> 8]) {
        Corners::Pairs([top, bottom]) => {
            let [a, b] = i.gather_pairs(view.words, top);
            let [c, d] = i.gather_pairs(view.words, bottom);
            [a, b, c, d]
        }
        Corners::Apart([a, b, c, d]) => [
            tap(i, view, a),
            tap(i, view, b),
            tap(i, view, c),
            tap(i, view, d),
        ],
    };
    let top = i.lerp_bytes(i.bytes(a), i.bytes(b), wx);
    let bottom = i.lerp_bytes(i.bytes(c), i.bytes(d), wx);
    i.lerp_bytes(top, bottom, wy)
}

//! Four texels weighted by distance.

use super::{FilterKernel, Input, LookUp};
use crate::{
    address::texel::LaneLevel,
    bound_texture::BoundTexture,
    fetch::{Color, fetch_corners, mix_four, scaled},
};
use texmap_math::simd::{Isa, prelude::*};

/// Bilinear on level 0.
pub(crate) struct Bilinear<const FORMAT: u8>;

impl<const FORMAT: u8> FilterKernel for Bilinear<FORMAT> {
    const FORMAT: u8 = FORMAT;
    const INPUT: Input = Input::Coordinates;

    #[inline(always)]
    fn color<I: Isa>(i: I, view: &BoundTexture<'_>, at: &LookUp<I>, _: I::F32) -> Color<I> {
        let [u, v] = at.uv;
        level_0::<I, FORMAT>(i, view, u, v)
    }
}

/// Bilinear on level 0. `FORMAT` is the view's.
#[inline(always)]
pub fn level_0<I: Isa, const FORMAT: u8>(
    i: I,
    view: &BoundTexture<'_>,
    u: I::F32,
    v: I::F32,
) -> Color<I> {
    let level = LaneLevel::uniform(i, view, 0);
    scaled::<I>(bilinear::<I, FORMAT>(i, view, &level, [u, v]), view)
}

/// Bilinear on a level, unscaled.
#[inline(always)]
pub(crate) fn bilinear<I: Isa, const FORMAT: u8>(
    i: I,
    view: &BoundTexture<'_>,
    level: &LaneLevel<I>,
    uv: [I::F32; 2],
) -> Color<I> {
    let [x, y] = level.scale(i, view, uv);
    let ([x, y], weights) = cell::<I>([x - 0.5, y - 0.5]);
    let texels = fetch_corners::<I, FORMAT>(i, view, level, [x, y]);
    mix_four::<I>(view, texels, weights)
}

/// Whole parts and fractions.
#[inline(always)]
pub(crate) fn cell<I: Isa>([x, y]: [I::F32; 2]) -> ([I::I32; 2], [I::F32; 2]) {
    let at = [x.floor_to_i32(), y.floor_to_i32()];
    (at, [x - at[0].to_f32(), y - at[1].to_f32()])
}

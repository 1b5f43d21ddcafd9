//! The nearest texel.

use super::{FilterKernel, Input, LookUp};
use crate::{
    address::texel::LaneLevel,
    bound_texture::BoundTexture,
    fetch::{Color, scaled, tap},
};
use texmap_math::simd::Isa;

/// The nearest texel of level 0.
pub(crate) struct Nearest<const FORMAT: u8>;

impl<const FORMAT: u8> FilterKernel for Nearest<FORMAT> {
    const FORMAT: u8 = FORMAT;
    const INPUT: Input = Input::Coordinates;

    #[inline(always)]
    fn color<I: Isa>(i: I, view: &BoundTexture<'_>, at: &LookUp<I>, _: I::F32) -> Color<I> {
        let level = LaneLevel::uniform(i, view, 0);
        scaled::<I>(nearest::<I, FORMAT>(i, view, &level, at.uv), view)
    }
}

/// The nearest texel of a level, unscaled.
#[inline(always)]
pub(crate) fn nearest<I: Isa, const FORMAT: u8>(
    i: I,
    view: &BoundTexture<'_>,
    level: &LaneLevel<I>,
    uv: [I::F32; 2],
) -> Color<I> {
    let at = level.nearest(i, view, uv, 0);
    tap::<I, FORMAT>(i, view, level.texel::<FORMAT>(i, view, at))
}

//! The nearest texel.

use super::tap;
use crate::{
    address::texel::LaneLevel,
    bound_texture::{BoundTexture, RGBA8},
    filter::{ByteKernel, LookUp},
};
use texmap_math::simd::{ByteIsa, Isa, prelude::*};

pub(crate) struct Nearest;

impl ByteKernel for Nearest {
    const WIDE: bool = true;

    #[inline(always)]
    fn word<I: ByteIsa>(i: I, view: &BoundTexture<'_>, at: &LookUp<I>) -> I::U32 {
        let [u, v] = at.uv;
        nearest(i, view, u, v)
    }
}

/// The nearest texel of level 0 for each lane.
#[inline(always)]
pub fn nearest<I: Isa>(i: I, view: &BoundTexture<'_>, u: I::F32, v: I::F32) -> I::U32 {
    nearest_in(i, view, &LaneLevel::uniform(i, view, 0), [u, v])
}

#[inline(always)]
pub(super) fn nearest_in<I: Isa>(
    i: I,
    view: &BoundTexture<'_>,
    level: &LaneLevel<I>,
    uv: [I::F32; 2],
) -> I::U32 {
    debug_assert_eq!(view.format, RGBA8, "bytes that are read whole");
    let at = level.nearest(i, view, uv, 8);
    tap(i, view, level.texel::<RGBA8>(i, view, at))
}

/// The texel of coordinates in 256ths.
#[inline(always)]
fn whole<I: Isa>([x, y]: [I::F32; 2]) -> [I::I32; 2] {
    [x.floor_to_i32() >> 8, y.floor_to_i32() >> 8]
}

/// The finest level of a view whose wraps are masks, in lanes once for many look-ups.
#[derive(Clone, Copy, Debug)]
pub struct PowerOfTwoTexture<'v, I: Isa> {
    view: &'v BoundTexture<'v>,
    level: LaneLevel<I>,
}

impl<'v, I: Isa> PowerOfTwoTexture<'v, I> {
    /// `None` under other wraps, and for sides that are no powers of two.
    #[inline(always)]
    pub fn new(i: I, view: &'v BoundTexture<'v>) -> Option<Self> {
        debug_assert_eq!(view.format, RGBA8, "bytes that are read whole");
        view.masked.then(
            #[inline(always)]
            || Self {
                view,
                level: LaneLevel::uniform(i, view, 0),
            },
        )
    }

    /// [`nearest`] in a fraction of its code, which leaves registers to the loop around.
    #[inline(always)]
    pub fn nearest(&self, i: I, u: I::F32, v: I::F32) -> I::U32 {
        let Self { view, level } = self;
        let at = whole::<I>(level.scale_masked(i, view, [u, v]));
        i.gather(view.words, level.texel_masked::<RGBA8>(view, at).word)
    }
}

//! Light to 8-bit codes.

use super::{GatherTable, prelude::*};
use crate::color::{SRGB8_FIRST, SRGB8_STEPS};

/// `round(255 x)` of `x` within 0..=1: [`color::unit_to_u8`](crate::color::unit_to_u8). NaN gives 0.
#[inline(always)]
pub fn encode_unorm8<I: Isa>(i: I, x: I::F32) -> I::U32 {
    let x = x.clamp(i.f32(0.0), i.f32(1.0));
    // By signed integers: only AVX-512 converts to the others.
    (x * 255.0 + 0.5).to_i32().to_u32()
}

/// The sRGB code of linear light: [`color::linear_to_srgb8`](crate::color::linear_to_srgb8). NaN gives 0.
#[inline(always)]
pub fn encode_srgb8<I: Isa>(i: I, x: I::F32) -> I::U32 {
    let x = x.clamp(i.f32(f32::from_bits(SRGB8_FIRST)), i.f32(1.0));
    let Some(steps) = GatherTable::new(&SRGB8_STEPS) else {
        return i.u32(0);
    };
    let bits = x.to_bits();
    let step = i.gather(steps, (bits >> 16) - (SRGB8_FIRST >> 16));
    (step + (bits & 0xffff)) >> 16
}

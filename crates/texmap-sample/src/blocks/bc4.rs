//! Channels between two ends: BC4, BC5, and the alpha of BC3.

use texmap_math::{
    lanes::GatherTable,
    simd::{Isa, prelude::*},
};

/// Sevenths of the two ends by index, where the first is above the second.
const SEVENTHS: [[f32; 8]; 2] = [
    [7.0, 0.0, 6.0, 5.0, 4.0, 3.0, 2.0, 1.0],
    [0.0, 7.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0],
];
/// Fifths of the two ends otherwise; the last two indices are 0 and 255.
const FIFTHS: [[f32; 8]; 2] = [
    [5.0, 0.0, 4.0, 3.0, 2.0, 1.0, 0.0, 0.0],
    [0.0, 5.0, 1.0, 2.0, 3.0, 4.0, 0.0, 0.0],
];

/// The value of texel `t` of the channel that begins at a word, times `scale` (1 for codes, 257 for 16 bits) and rounded: the divisors
/// are odd, so that no value lies halfway. Whole numbers below 2^24 are exact, and so is the floor of their quotient.
#[inline(always)]
pub(super) fn value<I: Isa>(
    i: I,
    words: GatherTable<'_>,
    first: I::U32,
    t: I::I32,
    scale: f32,
) -> I::I32 {
    let [low, high] = i.gather_pairs(words, first);
    let a = (low & 255).to_i32().to_f32();
    let b = ((low >> 8) & 255).to_i32().to_f32();
    // Indices of 3 bits from bit 16 on, seen through windows of 32 bits that begin at every sixteenth.
    let bit = t * 3 + 16;
    let second = bit.simd_ge(32).select(high, (low >> 16) | (high << 16));
    let window = bit.simd_ge(48).select(high >> 16, second);
    let index = ((window.to_i32() >> (bit & 15)) & 7).to_u32();
    let eight = a.simd_gt(b);
    let wa = eight.select(i.table8(&SEVENTHS[0], index), i.table8(&FIFTHS[0], index));
    let wb = eight.select(i.table8(&SEVENTHS[1], index), i.table8(&FIFTHS[1], index));
    let parts = eight.select(i.f32(7.0), i.f32(5.0));
    let white = index.simd_eq(7) & !eight;
    let sum = white.select(i.f32(255.0 * 5.0), a * wa + b * wb);
    ((sum * (2.0 * scale) + parts) / (parts * 2.0)).to_i32()
}

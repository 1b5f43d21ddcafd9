//! Colours of BC1 to BC3.

use texmap_math::{
    lanes::GatherTable,
    simd::{Isa, prelude::*},
};

/// Sixths of the first colour by index, with four colours, then with three.
const FIRST: [f32; 8] = [6.0, 0.0, 4.0, 2.0, 6.0, 0.0, 3.0, 0.0];
/// Sixths of the second.
const SECOND: [f32; 8] = [0.0, 6.0, 2.0, 4.0, 0.0, 6.0, 3.0, 0.0];

/// Codes of texel `t` of the colours that begin at a word: the nearest to the real value, the greater of two. With `holes`, blocks whose
/// first colour is not above the second have three colours, and a fourth index of alpha 0.
#[inline(always)]
pub(super) fn codes<I: Isa>(
    i: I,
    words: GatherTable<'_>,
    first: I::U32,
    t: I::I32,
    holes: bool,
) -> [I::I32; 4] {
    let [ends, indices] = i.gather_pairs(words, first);
    let (a, b) = (ends & 0xffff, ends >> 16);
    let index = (indices.to_i32() >> (t << 1)) & 3;
    let three = a.simd_le(b) & i.mask(holes);
    let entry = three.select(index + 4, index).to_u32();
    let weights = [i.table8(&FIRST, entry), i.table8(&SECOND, entry)];
    let hole = three & index.simd_eq(3);
    [
        code::<I>([a >> 11, b >> 11], weights, 31.0),
        code::<I>([(a >> 5) & 63, (b >> 5) & 63], weights, 63.0),
        code::<I>([a & 31, b & 31], weights, 31.0),
        hole.select(i.i32(0), i.i32(255)),
    ]
}

/// `255 (a w0 + b w1) / (6 most)`, rounded: whole numbers below 2^24 are exact, and so is the floor of their quotient.
#[inline(always)]
fn code<I: Isa>([a, b]: [I::U32; 2], [wa, wb]: [I::F32; 2], most: f32) -> I::I32 {
    let sum = a.to_i32().to_f32() * wa + b.to_i32().to_f32() * wb;
    ((sum * 255.0 + 3.0 * most) / (6.0 * most)).to_i32()
}

/// The 4-bit alpha of texel `t` of the alphas of BC2 that begin at a word.
#[inline(always)]
pub(super) fn alpha4<I: Isa>(i: I, words: GatherTable<'_>, first: I::U32, t: I::I32) -> I::I32 {
    let [low, high] = i.gather_pairs(words, first);
    let word = t.simd_lt(8).select(low, high).to_i32();
    ((word >> ((t & 7) << 2)) & 15) * 17
}

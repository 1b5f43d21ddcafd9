//! BC7: eight modes, one formula over their numbers.

use super::partitions::{ANCHORS, SUBSETS};
use texmap_math::{
    lanes::GatherTable,
    simd::{Isa, prelude::*},
};

/// Numbers of a mode. Source: Khronos Data Format Specification 1.3, table "BPTC modes".
struct Mode {
    subsets: u32,
    partition: u32,
    rotation: u32,
    selection: u32,
    color: u32,
    alpha: u32,
    /// 0: none, 1: one for each end, 2: one for each subset.
    shared: u32,
    index: u32,
    second: u32,
}

const MODES: [[u32; 9]; 8] = [
    [3, 4, 0, 0, 4, 0, 1, 3, 0],
    [2, 6, 0, 0, 6, 0, 2, 3, 0],
    [3, 6, 0, 0, 5, 0, 0, 2, 0],
    [2, 6, 0, 0, 7, 0, 1, 2, 0],
    [1, 0, 2, 1, 5, 6, 0, 2, 3],
    [1, 0, 2, 0, 7, 8, 0, 2, 2],
    [1, 0, 0, 0, 7, 7, 1, 4, 0],
    [2, 6, 0, 0, 5, 5, 1, 2, 0],
];

const fn mode(k: usize) -> Mode {
    let [
        subsets,
        partition,
        rotation,
        selection,
        color,
        alpha,
        shared,
        index,
        second,
    ] = MODES[if k < 8 { k } else { 0 }];
    Mode {
        subsets,
        partition,
        rotation,
        selection,
        color,
        alpha,
        shared,
        index,
        second,
    }
}

/// Bits of colour, alpha, partition, index and second index, 4 bits each from the low end, then subsets and shared bits.
static SHAPES: [u32; 16] = shapes();
/// First bit of the colours, of the shared bits, of the indices and of the second indices, a byte each.
static STARTS: [u32; 16] = starts();

const fn shapes() -> [u32; 16] {
    let mut out = [0; 16];
    let mut k = 0;
    while k < 16 {
        let m = mode(k);
        out[k] = m.color
            | m.alpha << 4
            | m.partition << 8
            | m.index << 12
            | m.second << 16
            | m.subsets << 20
            | m.shared << 24;
        k += 1;
    }
    out
}

const fn starts() -> [u32; 16] {
    let mut out = [0; 16];
    let mut k = 0;
    while k < 16 {
        let m = mode(k);
        let colors = if k < 8 { k as u32 + 1 } else { 1 } + m.partition + m.rotation + m.selection;
        let shared = colors + 2 * m.subsets * (3 * m.color + m.alpha);
        let indices = shared
            + match m.shared {
                1 => 2 * m.subsets,
                2 => m.subsets,
                _ => 0,
            };
        let second = indices + 16 * m.index - m.subsets;
        out[k] = colors | shared << 8 | indices << 16 | second << 24;
        k += 1;
    }
    out
}

/// `2^n - 1`.
static MASKS: [u32; 16] = [
    0, 1, 3, 7, 15, 31, 63, 127, 255, 511, 1023, 2047, 4095, 8191, 16383, 32767,
];
/// `2^(8 - n)`.
static RISES: [u32; 16] = [256, 128, 64, 32, 16, 8, 4, 2, 1, 1, 1, 1, 1, 1, 1, 1];

/// Weights of the second end in 64ths, of indices of n bits from entry 2^n on.
static WEIGHTS: [u32; 32] = [
    0, 0, 0, 0, 0, 21, 43, 64, 0, 9, 18, 27, 37, 46, 55, 64, 0, 4, 9, 13, 17, 21, 26, 30, 34, 38,
    43, 47, 51, 55, 60, 64,
];

/// Red, green, blue and alpha of texel `t` of a block: 8-bit codes, exact. A block of no mode is 0 in all four.
#[inline(always)]
pub(super) fn codes<I: Isa>(i: I, words: GatherTable<'_>, block: I::I32, t: I::I32) -> [I::I32; 4] {
    let bits: Bits<'_, I> = Bits {
        words,
        first: block << 2,
    };
    let head = i.gather(words, bits.first.to_u32()).to_i32();
    let byte = head & 255;
    let none = byte.simd_eq(0);
    // The lowest bit that is set, by the exponent of a float.
    let lowest = none.select(i.i32(1), byte & -byte);
    let mode = (lowest.to_f32().to_bits() >> 23).to_i32() - 127;
    let shape = i.table16(&SHAPES, mode.to_u32()).to_i32();
    let start = i.table16(&STARTS, mode.to_u32());

    // The subset of the texel.
    let subsets = (shape >> 20) & 15;
    let partition = (head >> (mode + 1)) & mask(i, (shape >> 8) & 15);
    let entry = subsets.simd_eq(3).select(partition + 64, partition);
    let entry = subsets.simd_eq(1).select(i.i32(128), entry);
    let subset = (table(i, &SUBSETS, entry) >> (t << 1)) & 3;
    let anchors = table(i, &ANCHORS, entry);

    // The indices.
    let (one, zero) = (i.i32(1), i.i32(0));
    let first = t.simd_eq(0);
    let is_anchor = first | t.simd_eq(anchors & 31) | t.simd_eq(anchors >> 8);
    let before = first.select(zero, one)
        + t.simd_gt(anchors & 31).select(one, zero)
        + t.simd_gt(anchors >> 8).select(one, zero);
    let width = (shape >> 12) & 15;
    let at = ((start >> 16) & 255).to_i32() + t * width - before;
    let index = bits.field(i, at, width - is_anchor.select(one, zero));
    let mut color = weight(i, width, index);
    let mut alpha = color;
    let width = (shape >> 16) & 15;
    let twice = width.simd_gt(0);
    if twice.any_true() {
        let before = first.select(zero, one);
        let at = (start >> 24).to_i32() + t * width - before;
        let index = bits.field(i, at, width - (one - before));
        let second = weight(i, width, twice.select(index, zero));
        let swapped = mode.simd_eq(4) & (head & 128).simd_gt(0);
        alpha = twice.select(swapped.select(color, second), color);
        color = (twice & swapped).select(second, color);
    }

    // Their ends.
    let shared = (shape >> 24) & 3;
    let mut low = [zero; 2];
    if shared.simd_gt(0).any_true() {
        let each = shared.simd_eq(1);
        let at = ((start >> 8) & 255).to_i32() + each.select(subset << 1, subset);
        let pair = bits.field(i, at, i.i32(2));
        low = [pair & 1, each.select(pair >> 1, pair) & 1];
    }
    let ends = Ends {
        low,
        has_low: shared.simd_gt(0),
    };
    let width = shape & 15;
    let stride = (subsets << 1) * width;
    let colors = (start & 255).to_i32();
    let mut out = [i.i32(255); 4];
    for (k, out) in out.iter_mut().enumerate().take(3) {
        let at = colors + stride * k as i32 + (subset << 1) * width;
        *out = ends.between(i, &bits, at, width, color);
    }
    let width = (shape >> 4) & 15;
    let has_alpha = width.simd_gt(0);
    if has_alpha.any_true() {
        let at = colors + stride * 3 + (subset << 1) * width;
        out[3] = has_alpha.select(ends.between(i, &bits, at, width, alpha), out[3]);
    }

    // Modes 4 and 5 may have changed alpha with another channel.
    let turns = mode.simd_eq(4) | mode.simd_eq(5);
    let rotation = turns.select((head >> (mode + 1)) & 3, zero);
    let old = out[3];
    for (k, c) in [1, 2, 3].into_iter().zip(0..3) {
        let here = rotation.simd_eq(k);
        out[3] = here.select(out[c], out[3]);
        out[c] = here.select(old, out[c]);
    }
    for c in &mut out {
        *c = none.select(zero, *c);
    }
    out
}

/// The ends of a channel.
struct Ends<I: Isa> {
    /// Their lowest bits, where those are shared by the channels.
    low: [I::I32; 2],
    has_low: I::Mask,
}

impl<I: Isa> Ends<I> {
    /// The code between two ends of `width` bits each that stand one after the other.
    #[inline(always)]
    fn between(
        &self,
        i: I,
        bits: &Bits<'_, I>,
        at: I::I32,
        width: I::I32,
        weight: I::I32,
    ) -> I::I32 {
        let pair = bits.field(i, at, width << 1);
        let mut ends = [pair & mask(i, width), pair >> width];
        let bits = self.has_low.select(width + 1, width);
        let rise = i.table16(&RISES, bits.to_u32()).to_i32();
        for (end, low) in ends.iter_mut().zip(&self.low) {
            let whole = self.has_low.select((*end << 1) | *low, *end) * rise;
            *end = whole | (whole >> bits);
        }
        let [a, b] = ends;
        (a * (i.i32(64) - weight) + b * weight + 32) >> 6
    }
}

/// The words of the blocks of each lane.
struct Bits<'a, I: Isa> {
    words: GatherTable<'a>,
    first: I::I32,
}

impl<I: Isa> Bits<'_, I> {
    /// `width` bits from bit `at` on, at most 16: a window of 32 bits that begins at a sixteenth holds them below its sign.
    #[inline(always)]
    fn field(&self, i: I, at: I::I32, width: I::I32) -> I::I32 {
        let word = self.first + (at >> 5);
        let [a, b] = i.gather_pairs(self.words, word.to_u32());
        let late = (at & 16).simd_gt(0);
        let window = late.select((a >> 16) | (b << 16), a).to_i32();
        (window >> (at & 15)) & field_mask(i, width)
    }
}

/// `2^n - 1` for n up to 16.
#[inline(always)]
fn field_mask<I: Isa>(i: I, n: I::I32) -> I::I32 {
    let whole = n.simd_eq(16);
    whole.select(i.i32(0xffff), mask(i, n))
}

/// `2^n - 1` for n below 16.
#[inline(always)]
fn mask<I: Isa>(i: I, n: I::I32) -> I::I32 {
    i.table16(&MASKS, (n & 15).to_u32()).to_i32()
}

/// The weight of an index of `width` bits.
#[inline(always)]
fn weight<I: Isa>(i: I, width: I::I32, index: I::I32) -> I::I32 {
    table(i, &WEIGHTS, mask(i, width) + 1 + index)
}

#[inline(always)]
fn table<I: Isa>(i: I, words: &[u32], entry: I::I32) -> I::I32 {
    match GatherTable::new(words) {
        Some(words) => i.gather(words, entry.to_u32()).to_i32(),
        None => entry,
    }
}

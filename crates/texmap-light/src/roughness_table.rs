//! Tables by roughness and by the cosine between view and normal.

use texmap_math::lanes::GatherTable;
use texmap_math::simd::{Isa, prelude::*};

/// A position in a table whose rows are even steps of roughness and whose columns are even steps of the cosine's square root.
pub(crate) struct TablePosition<I: Isa> {
    /// The entry at or below it; one of the next column and one of the next row lie beside it.
    at: I::U32,
    columns: u32,
    /// Distances from there, 0 to 1.
    x: I::F32,
    y: I::F32,
}

impl<I: Isa> TablePosition<I> {
    /// Both arguments within 0 to 1.
    #[inline(always)]
    pub(crate) fn new(
        i: I,
        roughness: I::F32,
        cosine: I::F32,
        [rows, columns]: [usize; 2],
    ) -> Self {
        let (row, y) = split(i, roughness, rows);
        let (column, x) = split(i, cosine.sqrt(), columns);
        Self {
            at: (row * columns as i32 + column).to_u32(),
            columns: columns as u32,
            x,
            y,
        }
    }

    /// The four entries around it: two of a row, and those below.
    #[inline(always)]
    pub(crate) fn read(&self, i: I, words: GatherTable<'_>) -> [I::U32; 4] {
        let [p, q] = i.gather_pairs(words, self.at);
        let [r, s] = i.gather_pairs(words, self.at + self.columns);
        [p, q, r, s]
    }

    /// The value here of values of the four entries.
    #[inline(always)]
    pub(crate) fn mean(&self, [p, q, r, s]: [I::F32; 4]) -> I::F32 {
        mix::<I>(mix::<I>(p, q, self.x), mix::<I>(r, s, self.x), self.y)
    }
}

/// Of `side` even steps the one at or below a coordinate within 0 to 1, with one above it, and the distance from there.
#[inline(always)]
pub(crate) fn split<I: Isa>(i: I, c: I::F32, side: usize) -> (I::I32, I::F32) {
    let c = c.clamp(i.f32(0.0), i.f32(1.0)) * (side - 1) as f32;
    let low = c.floor_to_i32().min(i.i32(side as i32 - 2));
    (low, c - low.to_f32())
}

#[inline(always)]
pub(crate) fn mix<I: Isa>(p: I::F32, q: I::F32, k: I::F32) -> I::F32 {
    p + (q - p) * k
}

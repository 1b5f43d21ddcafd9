//! Loads of several words at once by wasm's simd128: each lane has one load of 64 or 128 bits, and shuffles turn rows into columns.

use core::arch::wasm32::{
    u32x4_extract_lane, u32x4_min, u32x4_shuffle, u32x4_splat, u64x2_shuffle, v128, v128_load,
    v128_load64_lane, v128_load64_zero,
};

use super::GatherTable;

/// The words at four indices and those behind them, of more than one word. An index beyond the last pair reads that.
#[inline(always)]
pub(super) fn pairs(words: GatherTable<'_>, index: v128) -> [v128; 2] {
    let at = limited(index, words.last.saturating_sub(1));
    let start = words.data.as_ptr();
    // SAFETY: every index is below `last`, which is below `data.len()`, so that both words are elements; the loads ask for no alignment.
    let [a, b] = unsafe {
        let pair = |lane: usize| start.add(at[lane] as usize).cast::<u64>();
        [
            v128_load64_lane::<1>(v128_load64_zero(pair(0)), pair(1)),
            v128_load64_lane::<1>(v128_load64_zero(pair(2)), pair(3)),
        ]
    };
    [
        u32x4_shuffle::<0, 2, 4, 6>(a, b),
        u32x4_shuffle::<1, 3, 5, 7>(a, b),
    ]
}

/// The words at four indices and the three behind each, of more than three words. An index beyond the last four reads those.
#[inline(always)]
pub(super) fn quads(words: GatherTable<'_>, index: v128) -> [v128; 4] {
    let at = limited(index, words.last.saturating_sub(3));
    let start = words.data.as_ptr();
    // SAFETY: every index is at most three before `last`, which is below `data.len()`, so that all four words are elements; the loads
    // ask for no alignment.
    let [a, b, c, d] = unsafe {
        let quad = |lane: usize| v128_load(start.add(at[lane] as usize).cast());
        [quad(0), quad(1), quad(2), quad(3)]
    };
    let (low_ab, high_ab) = (
        u32x4_shuffle::<0, 4, 1, 5>(a, b),
        u32x4_shuffle::<2, 6, 3, 7>(a, b),
    );
    let (low_cd, high_cd) = (
        u32x4_shuffle::<0, 4, 1, 5>(c, d),
        u32x4_shuffle::<2, 6, 3, 7>(c, d),
    );
    [
        u64x2_shuffle::<0, 2>(low_ab, low_cd),
        u64x2_shuffle::<1, 3>(low_ab, low_cd),
        u64x2_shuffle::<0, 2>(high_ab, high_cd),
        u64x2_shuffle::<1, 3>(high_ab, high_cd),
    ]
}

/// The indices, none above `last`.
#[inline(always)]
fn limited(index: v128, last: u32) -> [u32; 4] {
    let at = u32x4_min(index, u32x4_splat(last));
    [
        u32x4_extract_lane::<0>(at),
        u32x4_extract_lane::<1>(at),
        u32x4_extract_lane::<2>(at),
        u32x4_extract_lane::<3>(at),
    ]
}

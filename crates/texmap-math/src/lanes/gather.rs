//! Sixteen indexed loads at once, and loads ahead of time: the only `unsafe` of the workspace.
#![allow(
    unsafe_code,
    reason = "the gather instructions take a raw pointer; each block states why its addresses are valid"
)]

#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
use fearless_simd::Level;
#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
use fearless_simd::SimdInto;
#[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
use fearless_simd::prelude::*;
use fearless_simd::{Simd, SimdBase, u32x4, u32x16};

#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
use super::is_wide;

#[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
mod wasm;
#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
mod x86;

/// 32-bit words to gather from: at least one. Texels of other sizes are cast to words first.
#[derive(Clone, Copy, Debug)]
pub struct GatherTable<'a> {
    data: &'a [u32],
    /// The largest index that is read: within `data` and within i32.
    last: u32,
}

impl<'a> GatherTable<'a> {
    /// None for an empty slice. Indices beyond 2^31 - 1 cannot be reached.
    #[inline]
    #[must_use]
    pub fn new(data: &'a [u32]) -> Option<Self> {
        let last = data.len().checked_sub(1)?;
        Some(Self {
            data,
            last: last.min(i32::MAX as usize) as u32,
        })
    }

    /// The word at `index`, or the last one beyond the end.
    #[inline(always)]
    #[must_use]
    pub fn get(&self, index: u32) -> u32 {
        self.data[index.min(self.last) as usize]
    }
}

/// Asks for the cache line of the first byte, to be written soon; nothing waits for it. No bit depends on it.
#[inline(always)]
pub fn prefetch(bytes: &[u8]) {
    #[cfg(target_arch = "x86_64")]
    // SAFETY: a prefetch reads nothing, faults nowhere, and is part of what every x86-64 has.
    unsafe {
        use core::arch::x86_64::{_MM_HINT_ET0, _mm_prefetch};
        _mm_prefetch::<_MM_HINT_ET0>(bytes.as_ptr().cast());
    }
    let _ = bytes;
}

/// The words at sixteen indices; an index beyond the end reads the last word. By a gather instruction on AVX-512; AVX2's is slower
/// than loads on most CPUs that have no AVX-512 of their own: AMD's, and Intel's since it is guarded against data sampling. Pairs are
/// half as many elements for a gather, and fours one load each on both.
#[inline(always)]
pub fn gather<S: Simd>(s: S, words: GatherTable<'_>, index: u32x16<S>) -> u32x16<S> {
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    match s.level() {
        Level::Avx512(token) => return x86::gather_avx512(token, words, index.into()).simd_into(s),
        Level::Avx2(token) => {
            let (low, high) = s.split_u32x16(index);
            let low = x86::loads_avx2(token, words, low.into()).simd_into(s);
            let high = x86::loads_avx2(token, words, high.into()).simd_into(s);
            return s.combine_u32x8(low, high);
        }
        _ => {}
    }
    gather_by_loads(s, words, index)
}

/// The words at sixteen indices and those behind them. If one of the two lies beyond the end, both hold no meaning.
#[inline(always)]
pub fn gather_pairs<S: Simd>(s: S, words: GatherTable<'_>, index: u32x16<S>) -> [u32x16<S>; 2] {
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    match (s.level(), words.last) {
        (Level::Avx512(token), 1..) => {
            let [a, b] = x86::pairs_avx512(token, words, index.into());
            return [a.simd_into(s), b.simd_into(s)];
        }
        (Level::Avx2(token), 1..) => {
            let (low, high) = s.split_u32x16(index);
            let [low, low_next] = x86::pairs_avx2(token, words, low.into());
            let [high, high_next] = x86::pairs_avx2(token, words, high.into());
            return [
                s.combine_u32x8(low.simd_into(s), high.simd_into(s)),
                s.combine_u32x8(low_next.simd_into(s), high_next.simd_into(s)),
            ];
        }
        (Level::Sse2(token), 1..) => {
            let (low, high) = s.split_u32x16(index);
            let ((a, b), (c, d)) = (s.split_u32x8(low), s.split_u32x8(high));
            let [a, a_next] = x86::pairs_sse2(token, words, a.into());
            let [b, b_next] = x86::pairs_sse2(token, words, b.into());
            let [c, c_next] = x86::pairs_sse2(token, words, c.into());
            let [d, d_next] = x86::pairs_sse2(token, words, d.into());
            return [
                s.combine_u32x8(
                    s.combine_u32x4(a.simd_into(s), b.simd_into(s)),
                    s.combine_u32x4(c.simd_into(s), d.simd_into(s)),
                ),
                s.combine_u32x8(
                    s.combine_u32x4(a_next.simd_into(s), b_next.simd_into(s)),
                    s.combine_u32x4(c_next.simd_into(s), d_next.simd_into(s)),
                ),
            ];
        }
        _ => {}
    }
    [gather(s, words, index), gather(s, words, index + 1)]
}

/// [`gather_pairs`] of indices in memory, through which the processor loads: `None` where a level gains nothing by it, or if some words
/// lie beyond the end.
#[inline(always)]
pub fn gather_pairs_at<S: Simd>(
    s: S,
    words: GatherTable<'_>,
    at: &[u32; 16],
) -> Option<[u32x16<S>; 2]> {
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    if let (Level::Avx2(token), [low, high]) = (s.level(), at.as_chunks::<8>().0) {
        let [low, low_next] = x86::pairs_at_avx2(token, words, low)?;
        let [high, high_next] = x86::pairs_at_avx2(token, words, high)?;
        return Some([
            s.combine_u32x8(low.simd_into(s), high.simd_into(s)),
            s.combine_u32x8(low_next.simd_into(s), high_next.simd_into(s)),
        ]);
    }
    let _ = (s, words, at);
    None
}

/// True if [`gather_pairs`] costs less than two gathers.
#[inline(always)]
pub fn has_pairs<S: Simd>(s: S) -> bool {
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    {
        is_wide(s) || matches!(s.level(), Level::Sse2(_))
    }
    #[cfg(not(any(target_arch = "x86", target_arch = "x86_64")))]
    {
        let _ = s;
        cfg!(all(target_arch = "wasm32", target_feature = "simd128"))
    }
}

/// The words at sixteen indices and the three behind each. Only if that costs less than [`gather`]s and none lies beyond the
/// end.
#[inline(always)]
pub fn gather_quads<S: Simd>(
    s: S,
    words: GatherTable<'_>,
    index: u32x16<S>,
) -> Option<[u32x16<S>; 4]> {
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    match s.level() {
        Level::Avx512(token) => {
            return Some(x86::whole(
                s,
                x86::quads_avx512(token, words, index.into())?,
            ));
        }
        Level::Avx2(token) => {
            let (low, high) = s.split_u32x16(index);
            let low = x86::quads_avx2(token, words, low.into())?;
            return Some(x86::joined(
                s,
                low,
                x86::quads_avx2(token, words, high.into())?,
            ));
        }
        _ => {}
    }
    let _ = (s, words, index);
    None
}

/// [`gather_quads`] of indices in memory. Loads take their addresses from there, and wait for those that were only just stored.
#[inline(always)]
pub fn gather_quads_at<S: Simd>(
    s: S,
    words: GatherTable<'_>,
    at: &[u32; 16],
) -> Option<[u32x16<S>; 4]> {
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    match (s.level(), at.as_chunks::<8>().0) {
        (Level::Avx512(token), _) => {
            return Some(x86::whole(s, x86::quads_at_avx512(token, words, at)?));
        }
        (Level::Avx2(token), [low, high]) => {
            let low = x86::quads_at_avx2(token, words, low)?;
            return Some(x86::joined(s, low, x86::quads_at_avx2(token, words, high)?));
        }
        _ => {}
    }
    let _ = (s, words, at);
    None
}

/// [`gather`] by sixteen loads.
#[inline(always)]
fn gather_by_loads<S: Simd>(s: S, words: GatherTable<'_>, index: u32x16<S>) -> u32x16<S> {
    let mut lanes = [0; 16];
    index.store_slice(&mut lanes);
    for lane in &mut lanes {
        let at = (*lane).min(words.last) as usize;
        // SAFETY: `last` is below `data.len()`. A check of each, which cannot fail, would be half of the code of SSE2's kernels.
        *lane = unsafe { *words.data.get_unchecked(at) };
    }
    u32x16::from_slice(s, &lanes)
}

/// [`gather`] for four lanes, by loads.
#[inline(always)]
pub(crate) fn gather_x4<S: Simd>(s: S, words: GatherTable<'_>, index: u32x4<S>) -> u32x4<S> {
    let mut lanes = [0; 4];
    index.store_slice(&mut lanes);
    for lane in &mut lanes {
        let at = (*lane).min(words.last) as usize;
        // SAFETY: `last` is below `data.len()`.
        *lane = unsafe { *words.data.get_unchecked(at) };
    }
    u32x4::from_slice(s, &lanes)
}

/// [`gather_pairs`] for four lanes.
#[inline(always)]
pub(crate) fn gather_pairs_x4<S: Simd>(
    s: S,
    words: GatherTable<'_>,
    index: u32x4<S>,
) -> [u32x4<S>; 2] {
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    if let (Level::Sse2(token), 1..) = (s.level(), words.last) {
        let [a, b] = x86::pairs_sse2(token, words, index.into());
        return [a.simd_into(s), b.simd_into(s)];
    }
    #[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
    if words.last > 0 {
        let [a, b] = wasm::pairs(words, index.into());
        return [a.simd_into(s), b.simd_into(s)];
    }
    [gather_x4(s, words, index), gather_x4(s, words, index + 1)]
}

/// [`gather_quads`] for four lanes.
#[inline(always)]
pub(crate) fn gather_quads_x4<S: Simd>(
    s: S,
    words: GatherTable<'_>,
    index: u32x4<S>,
) -> Option<[u32x4<S>; 4]> {
    #[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
    if let Some(last) = words.last.checked_sub(3)
        && !index.simd_gt(last).any_true()
    {
        let [a, b, c, d] = wasm::quads(words, index.into());
        return Some([
            a.simd_into(s),
            b.simd_into(s),
            c.simd_into(s),
            d.simd_into(s),
        ]);
    }
    let _ = (s, words, index);
    None
}

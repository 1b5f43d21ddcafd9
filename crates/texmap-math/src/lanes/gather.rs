//! Sixteen indexed loads at once: the only `unsafe` of the workspace.
#![allow(
    unsafe_code,
    reason = "the gather instructions take a raw pointer; each block states why its addresses are valid"
)]

#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
use fearless_simd::{Level, SimdInto};
use fearless_simd::{Simd, SimdBase, u32x16};

#[cfg(target_arch = "x86")]
use core::arch::x86::{
    __m256i, __m512i, _mm256_i32gather_epi32, _mm256_min_epu32, _mm256_set1_epi32,
    _mm512_i32gather_epi32, _mm512_min_epu32, _mm512_set1_epi32,
};
#[cfg(target_arch = "x86_64")]
use core::arch::x86_64::{
    __m256i, __m512i, _mm256_i32gather_epi32, _mm256_min_epu32, _mm256_set1_epi32,
    _mm512_i32gather_epi32, _mm512_min_epu32, _mm512_set1_epi32,
};

/// 32-bit words to gather from: at least one. Texels of other sizes are cast to words first.
#[derive(Clone, Copy, Debug)]
pub struct Words<'a> {
    data: &'a [u32],
    /// The largest index that is read: within `data` and within i32.
    last: u32,
}

impl<'a> Words<'a> {
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

/// The words at sixteen indices; an index beyond the end reads the last word. By a gather instruction where the level has one.
#[inline(always)]
pub fn gather<S: Simd>(s: S, words: Words<'_>, index: u32x16<S>) -> u32x16<S> {
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    match s.level() {
        Level::Avx512(token) => return gather_avx512(token, words, index.into()).simd_into(s),
        Level::Avx2(token) => {
            let (low, high) = s.split_u32x16(index);
            let low = gather_avx2(token, words, low.into()).simd_into(s);
            let high = gather_avx2(token, words, high.into()).simd_into(s);
            return s.combine_u32x8(low, high);
        }
        _ => {}
    }
    gather_by_loads(s, words, index)
}

/// [`gather`] by sixteen checked loads: the same words, the faster way on CPUs with slow gathers.
#[inline(always)]
pub fn gather_by_loads<S: Simd>(s: S, words: Words<'_>, index: u32x16<S>) -> u32x16<S> {
    let mut lanes = [0; 16];
    index.store_slice(&mut lanes);
    for lane in &mut lanes {
        *lane = words.get(*lane);
    }
    u32x16::from_slice(s, &lanes)
}

#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
fearless_simd::kernel!(
    #[inline]
    fn gather_avx512(token: Avx512, words: Words<'_>, index: __m512i) -> __m512i {
        let index = _mm512_min_epu32(index, _mm512_set1_epi32(words.last as i32));
        // SAFETY: every index is at most `last`, which is below `data.len()` and within i32, so each address is that of an element.
        unsafe { _mm512_i32gather_epi32::<4>(index, words.data.as_ptr().cast()) }
    }
);

#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
fearless_simd::kernel!(
    #[inline]
    fn gather_avx2(token: Avx2, words: Words<'_>, index: __m256i) -> __m256i {
        let index = _mm256_min_epu32(index, _mm256_set1_epi32(words.last as i32));
        // SAFETY: every index is at most `last`, which is below `data.len()` and within i32, so each address is that of an element.
        unsafe { _mm256_i32gather_epi32::<4>(words.data.as_ptr().cast(), index) }
    }
);

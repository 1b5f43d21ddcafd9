//! Gathers of x86: instructions on AVX-512, loads of words, pairs and fours elsewhere.

use super::GatherTable;
use crate::lanes::CacheAligned;
#[cfg(target_arch = "x86")]
use core::arch::x86::{
    __m128i, __m256i, __m512i, _MM_HINT_T0, _mm_castps_si128, _mm_castsi128_ps, _mm_loadu_si128,
    _mm_prefetch, _mm_set_epi64x, _mm_shuffle_ps, _mm_storeu_si128, _mm256_castps_si256,
    _mm256_castsi256_ps, _mm256_cmpeq_epi32, _mm256_loadu_si256, _mm256_min_epu32,
    _mm256_movemask_epi8, _mm256_set_m128i, _mm256_set1_epi32, _mm256_setr_epi32,
    _mm256_shuffle_ps, _mm256_storeu_si256, _mm256_unpackhi_epi32, _mm256_unpackhi_epi64,
    _mm256_unpacklo_epi32, _mm256_unpacklo_epi64, _mm512_castsi256_si512, _mm512_castsi512_si256,
    _mm512_cmpgt_epu32_mask, _mm512_extracti64x4_epi64, _mm512_i32gather_epi32,
    _mm512_i32gather_epi64, _mm512_inserti64x4, _mm512_loadu_si512, _mm512_min_epu32,
    _mm512_permutex2var_epi32, _mm512_set1_epi32, _mm512_setr_epi32, _mm512_setzero_si512,
    _mm512_storeu_si512, _mm512_unpackhi_epi32, _mm512_unpackhi_epi64, _mm512_unpacklo_epi32,
    _mm512_unpacklo_epi64,
};
#[cfg(target_arch = "x86_64")]
use core::arch::x86_64::{
    __m128i, __m256i, __m512i, _MM_HINT_T0, _mm_castps_si128, _mm_castsi128_ps, _mm_loadu_si128,
    _mm_prefetch, _mm_set_epi64x, _mm_shuffle_ps, _mm_storeu_si128, _mm256_castps_si256,
    _mm256_castsi256_ps, _mm256_cmpeq_epi32, _mm256_loadu_si256, _mm256_min_epu32,
    _mm256_movemask_epi8, _mm256_set_m128i, _mm256_set1_epi32, _mm256_setr_epi32,
    _mm256_shuffle_ps, _mm256_storeu_si256, _mm256_unpackhi_epi32, _mm256_unpackhi_epi64,
    _mm256_unpacklo_epi32, _mm256_unpacklo_epi64, _mm512_castsi256_si512, _mm512_castsi512_si256,
    _mm512_cmpgt_epu32_mask, _mm512_extracti64x4_epi64, _mm512_i32gather_epi32,
    _mm512_i32gather_epi64, _mm512_inserti64x4, _mm512_loadu_si512, _mm512_min_epu32,
    _mm512_permutex2var_epi32, _mm512_set1_epi32, _mm512_setr_epi32, _mm512_setzero_si512,
    _mm512_storeu_si512, _mm512_unpackhi_epi32, _mm512_unpackhi_epi64, _mm512_unpacklo_epi32,
    _mm512_unpacklo_epi64,
};
use fearless_simd::{Simd, SimdInto, u32x16};

/// Sixteen lanes of four words.
#[inline(always)]
pub(super) fn whole<S: Simd>(s: S, [a, b, c, d]: [__m512i; 4]) -> [u32x16<S>; 4] {
    [
        a.simd_into(s),
        b.simd_into(s),
        c.simd_into(s),
        d.simd_into(s),
    ]
}

/// Sixteen lanes of four words from two halves.
#[inline(always)]
pub(super) fn joined<S: Simd>(s: S, low: [__m256i; 4], high: [__m256i; 4]) -> [u32x16<S>; 4] {
    [
        s.combine_u32x8(low[0].simd_into(s), high[0].simd_into(s)),
        s.combine_u32x8(low[1].simd_into(s), high[1].simd_into(s)),
        s.combine_u32x8(low[2].simd_into(s), high[2].simd_into(s)),
        s.combine_u32x8(low[3].simd_into(s), high[3].simd_into(s)),
    ]
}

fearless_simd::kernel!(
    #[inline]
    pub(super) fn gather_avx512(token: Avx512, words: GatherTable<'_>, index: __m512i) -> __m512i {
        let index = _mm512_min_epu32(index, _mm512_set1_epi32(words.last as i32));
        // SAFETY: every index is at most `last`, which is below `data.len()` and within i32, so each address is that of an element.
        unsafe { _mm512_i32gather_epi32::<4>(index, words.data.as_ptr().cast()) }
    }
);

fearless_simd::kernel!(
    /// Of more than one word: a gather of eight pairs takes as long as one of sixteen words.
    #[inline]
    pub(super) fn pairs_avx512(
        token: Avx512,
        words: GatherTable<'_>,
        index: __m512i,
    ) -> [__m512i; 2] {
        let last = words.last.saturating_sub(1) as i32;
        let index = _mm512_min_epu32(index, _mm512_set1_epi32(last));
        let low = _mm512_castsi512_si256(index);
        let high = _mm512_extracti64x4_epi64::<1>(index);
        let start = words.data.as_ptr().cast();
        // SAFETY: every index is below `last`, which is below `data.len()` and within i32, so that both words are elements.
        let (low, high) = unsafe {
            (
                _mm512_i32gather_epi64::<4>(low, start),
                _mm512_i32gather_epi64::<4>(high, start),
            )
        };
        let even = _mm512_setr_epi32(0, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30);
        let odd = _mm512_setr_epi32(1, 3, 5, 7, 9, 11, 13, 15, 17, 19, 21, 23, 25, 27, 29, 31);
        [
            _mm512_permutex2var_epi32(low, even, high),
            _mm512_permutex2var_epi32(low, odd, high),
        ]
    }
);

fearless_simd::kernel!(
    /// True if no index is above `last`.
    #[inline(always)]
    fn within_avx512(token: Avx512, index: __m512i, last: u32) -> bool {
        _mm512_cmpgt_epu32_mask(index, _mm512_set1_epi32(last as i32)) == 0
    }
);

fearless_simd::kernel!(
    /// True if no index is above `last`.
    #[inline(always)]
    fn within_avx2(token: Avx2, index: __m256i, last: u32) -> bool {
        let cut = _mm256_min_epu32(index, _mm256_set1_epi32(last as i32));
        _mm256_movemask_epi8(_mm256_cmpeq_epi32(cut, index)) == -1
    }
);

/// In a cache line of their own: written across two, they are read back in twice the time.
#[repr(align(64))]
struct Indices([u32; 8]);

fearless_simd::kernel!(
    /// The indices, none above `last`.
    #[inline(always)]
    fn indices_avx2(token: Avx2, index: __m256i, last: u32) -> [u32; 8] {
        let last = _mm256_set1_epi32(last as i32);
        through_memory_avx2(token, _mm256_min_epu32(index, last))
    }
);

fearless_simd::kernel!(
    /// The words of a register: taking them out one by one is slower.
    #[inline(always)]
    fn through_memory_avx2(token: Avx2, index: __m256i) -> [u32; 8] {
        let mut lanes = Indices([0; 8]);
        // SAFETY: eight words are what the array holds.
        unsafe { _mm256_storeu_si256(lanes.0.as_mut_ptr().cast(), index) };
        core::hint::black_box(&lanes).0
    }
);

fearless_simd::kernel!(
    #[inline(always)]
    pub(super) fn loads_avx2(token: Avx2, words: GatherTable<'_>, index: __m256i) -> __m256i {
        // No `map`: its closure is not always inlined.
        let at = indices_avx2(token, index, words.last);
        // SAFETY: every index is at most `last`, which is below `data.len()`.
        unsafe {
            _mm256_setr_epi32(
                *words.data.get_unchecked(at[0] as usize) as i32,
                *words.data.get_unchecked(at[1] as usize) as i32,
                *words.data.get_unchecked(at[2] as usize) as i32,
                *words.data.get_unchecked(at[3] as usize) as i32,
                *words.data.get_unchecked(at[4] as usize) as i32,
                *words.data.get_unchecked(at[5] as usize) as i32,
                *words.data.get_unchecked(at[6] as usize) as i32,
                *words.data.get_unchecked(at[7] as usize) as i32,
            )
        }
    }
);

/// A word and the one behind it.
///
/// # Safety
/// Both lie within the words.
#[inline(always)]
unsafe fn pair(words: GatherTable<'_>, at: u32) -> i64 {
    let start = words.data.as_ptr().cast::<u8>();
    // SAFETY: the caller's word; eight bytes from there on are it and the next.
    unsafe { start.add(at as usize * 4).cast::<i64>().read_unaligned() }
}

/// The words at indices in memory, all below the last, and those behind them.
macro_rules! pairs_avx2 {
    ($words:expr, $at:expr) => {{
        let (words, at): (GatherTable<'_>, &[u32; 8]) = ($words, $at);
        // SAFETY: every index is below `last`, which is below `data.len()`, so that both words are elements.
        let [a, b, c, d] = unsafe {
            [
                _mm_set_epi64x(pair(words, at[1]), pair(words, at[0])),
                _mm_set_epi64x(pair(words, at[3]), pair(words, at[2])),
                _mm_set_epi64x(pair(words, at[5]), pair(words, at[4])),
                _mm_set_epi64x(pair(words, at[7]), pair(words, at[6])),
            ]
        };
        let (x, y) = (
            _mm256_castsi256_ps(_mm256_set_m128i(c, a)),
            _mm256_castsi256_ps(_mm256_set_m128i(d, b)),
        );
        [
            _mm256_castps_si256(_mm256_shuffle_ps::<0x88>(x, y)),
            _mm256_castps_si256(_mm256_shuffle_ps::<0xdd>(x, y)),
        ]
    }};
}

fearless_simd::kernel!(
    /// `None` if some words lie beyond the end.
    #[inline(always)]
    pub(super) fn pairs_at_avx2(
        token: Avx2,
        words: GatherTable<'_>,
        at: &[u32; 8],
    ) -> Option<[__m256i; 2]> {
        // SAFETY: eight words are what the array holds.
        let index = unsafe { _mm256_loadu_si256(at.as_ptr().cast()) };
        if !within_avx2(token, index, words.last.checked_sub(1)?) {
            return None;
        }
        Some(pairs_avx2!(words, as_stored(at)))
    }
);

fearless_simd::kernel!(
    /// Of more than one word.
    #[inline(always)]
    pub(super) fn pairs_avx2(token: Avx2, words: GatherTable<'_>, index: __m256i) -> [__m256i; 2] {
        pairs_avx2!(
            words,
            &indices_avx2(token, index, words.last.saturating_sub(1))
        )
    }
);

fearless_simd::kernel!(
    /// Of more than one word.
    #[inline(always)]
    pub(super) fn pairs_sse2(token: Sse2, words: GatherTable<'_>, index: __m128i) -> [__m128i; 2] {
        let last = words.last.saturating_sub(1);
        let mut at = [0_u32; 4];
        // SAFETY: four words are what the array holds.
        unsafe { _mm_storeu_si128(at.as_mut_ptr().cast(), index) };
        // SAFETY: every index is below `last` of the words, which is below `data.len()`, so that both words are elements.
        let (x, y) = unsafe {
            (
                _mm_set_epi64x(pair(words, at[1].min(last)), pair(words, at[0].min(last))),
                _mm_set_epi64x(pair(words, at[3].min(last)), pair(words, at[2].min(last))),
            )
        };
        let (x, y) = (_mm_castsi128_ps(x), _mm_castsi128_ps(y));
        [
            _mm_castps_si128(_mm_shuffle_ps::<0x88>(x, y)),
            _mm_castps_si128(_mm_shuffle_ps::<0xdd>(x, y)),
        ]
    }
);

/// Four words that follow one another.
///
/// # Safety
/// All lie within the words.
#[inline(always)]
unsafe fn quad(words: GatherTable<'_>, at: u32) -> __m128i {
    // SAFETY: the caller's word; sixteen bytes from there on are it and the next three.
    unsafe { _mm_loadu_si128(words.data.as_ptr().add(at as usize).cast()) }
}

/// Indices that are loaded one by one: a compiler that sees more of them would load vectors and take the indices out.
#[inline(always)]
fn as_stored<const N: usize>(at: &[u32; N]) -> &[u32; N] {
    core::hint::black_box(at)
}

/// Asks for the cache line of a word three blocks on, where `first` and `last` are those of the first and last of four pixels in a row.
#[inline(always)]
fn ahead(words: GatherTable<'_>, first: u32, last: u32) {
    let step = (last.wrapping_sub(first) as i32).wrapping_mul(4);
    let at = words.data.as_ptr();
    let at = at.wrapping_offset((first as i32).wrapping_add(step) as isize);
    // SAFETY: a prefetch reads nothing and faults nowhere, and every x86-64 has it.
    unsafe { _mm_prefetch::<{ _MM_HINT_T0 }>(at.cast()) };
}

/// The words at indices in memory, all at most three before the last, and the three behind each.
macro_rules! quads_avx512 {
    ($words:expr, $at:expr) => {{
        let (words, at): (GatherTable<'_>, &[u32; 16]) = ($words, $at);
        for row in 0..4 {
            ahead(words, at[4 * row], at[4 * row + 3]);
        }
        let mut rows = [_mm512_setzero_si512(); 4];
        for (i, row) in rows.iter_mut().enumerate() {
            // SAFETY: every index is at most three before `last`, which is below `data.len()`, so that all four words are elements.
            *row = unsafe {
                let low = _mm256_set_m128i(quad(words, at[i + 4]), quad(words, at[i]));
                let high = _mm256_set_m128i(quad(words, at[i + 12]), quad(words, at[i + 8]));
                _mm512_inserti64x4::<1>(_mm512_castsi256_si512(low), high)
            };
        }
        let [a, b, c, d] = rows;
        let (low_ab, high_ab) = (_mm512_unpacklo_epi32(a, b), _mm512_unpackhi_epi32(a, b));
        let (low_cd, high_cd) = (_mm512_unpacklo_epi32(c, d), _mm512_unpackhi_epi32(c, d));
        Some([
            _mm512_unpacklo_epi64(low_ab, low_cd),
            _mm512_unpackhi_epi64(low_ab, low_cd),
            _mm512_unpacklo_epi64(high_ab, high_cd),
            _mm512_unpackhi_epi64(high_ab, high_cd),
        ])
    }};
}

fearless_simd::kernel!(
    /// `None` if some words lie beyond the end.
    #[inline(always)]
    pub(super) fn quads_avx512(
        token: Avx512,
        words: GatherTable<'_>,
        index: __m512i,
    ) -> Option<[__m512i; 4]> {
        if !within_avx512(token, index, words.last.checked_sub(3)?) {
            return None;
        }
        let mut at = CacheAligned([0_u32; 16]);
        // SAFETY: sixteen words are what the array holds.
        unsafe { _mm512_storeu_si512(at.0.as_mut_ptr().cast(), index) };
        quads_avx512!(words, &core::hint::black_box(&at).0)
    }
);

fearless_simd::kernel!(
    /// `None` if some words lie beyond the end.
    #[inline(always)]
    pub(super) fn quads_at_avx512(
        token: Avx512,
        words: GatherTable<'_>,
        at: &[u32; 16],
    ) -> Option<[__m512i; 4]> {
        // SAFETY: sixteen words are what the array holds.
        let index = unsafe { _mm512_loadu_si512(at.as_ptr().cast()) };
        if !within_avx512(token, index, words.last.checked_sub(3)?) {
            return None;
        }
        quads_avx512!(words, as_stored(at))
    }
);

/// The words at indices in memory, all at most three before the last, and the three behind each.
macro_rules! quads_avx2 {
    ($words:expr, $at:expr) => {{
        let (words, at): (GatherTable<'_>, &[u32; 8]) = ($words, $at);
        ahead(words, at[0], at[3]);
        ahead(words, at[4], at[7]);
        // SAFETY: every index is at most three before `last`, which is below `data.len()`, so that all four words are elements.
        let [a, b, c, d] = unsafe {
            [
                _mm256_set_m128i(quad(words, at[4]), quad(words, at[0])),
                _mm256_set_m128i(quad(words, at[5]), quad(words, at[1])),
                _mm256_set_m128i(quad(words, at[6]), quad(words, at[2])),
                _mm256_set_m128i(quad(words, at[7]), quad(words, at[3])),
            ]
        };
        let (low_ab, high_ab) = (_mm256_unpacklo_epi32(a, b), _mm256_unpackhi_epi32(a, b));
        let (low_cd, high_cd) = (_mm256_unpacklo_epi32(c, d), _mm256_unpackhi_epi32(c, d));
        Some([
            _mm256_unpacklo_epi64(low_ab, low_cd),
            _mm256_unpackhi_epi64(low_ab, low_cd),
            _mm256_unpacklo_epi64(high_ab, high_cd),
            _mm256_unpackhi_epi64(high_ab, high_cd),
        ])
    }};
}

fearless_simd::kernel!(
    /// `None` if some words lie beyond the end.
    #[inline(always)]
    pub(super) fn quads_avx2(
        token: Avx2,
        words: GatherTable<'_>,
        index: __m256i,
    ) -> Option<[__m256i; 4]> {
        if !within_avx2(token, index, words.last.checked_sub(3)?) {
            return None;
        }
        quads_avx2!(words, &through_memory_avx2(token, index))
    }
);

fearless_simd::kernel!(
    /// `None` if some words lie beyond the end.
    #[inline(always)]
    pub(super) fn quads_at_avx2(
        token: Avx2,
        words: GatherTable<'_>,
        at: &[u32; 8],
    ) -> Option<[__m256i; 4]> {
        // SAFETY: eight words are what the array holds.
        let index = unsafe { _mm256_loadu_si256(at.as_ptr().cast()) };
        if !within_avx2(token, index, words.last.checked_sub(3)?) {
            return None;
        }
        quads_avx2!(words, as_stored(at))
    }
);

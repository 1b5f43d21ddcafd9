//! Sixteen-lane operations that a level has instructions for: gathers, small tables, byte mixes. Outside semantic versioning.
//!
//! Kernels call them through [`simd`](crate::simd), whose rules hold here too.

#[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
use core::arch::wasm32::{f32x4_pmax, f32x4_pmin};
#[cfg(target_arch = "x86")]
use core::arch::x86::{
    __m512, __m512i, _MM_FROUND_NO_EXC, _MM_FROUND_TO_NEG_INF, _mm512_cvt_roundps_epi32,
};
#[cfg(target_arch = "x86_64")]
use core::arch::x86_64::{
    __m512, __m512i, _MM_FROUND_NO_EXC, _MM_FROUND_TO_NEG_INF, _mm512_cvt_roundps_epi32,
};
#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
use fearless_simd::Level;
use fearless_simd::prelude::*;
use fearless_simd::{f32x4, f32x16, i32x16};

mod bytes;
mod gather;
mod table;

pub use bytes::lerp_bytes;
pub use gather::{
    GatherTable, gather, gather_pairs, gather_pairs_at, gather_quads, gather_quads_at, has_pairs,
    prefetch,
};
pub(crate) use gather::{gather_pairs_x4, gather_quads_x4, gather_x4};
pub use table::{lookup8, lookup16};

/// Lanes of every kernel, on every level.
pub const LANES: usize = 16;

/// Values of sixteen lanes in memory, in a cache line of their own. A kernel that keeps one has its stack laid out in such lines;
/// otherwise a compiler may put the registers that it must set aside across two of them, and each comes and goes in twice the time.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
#[repr(align(64))]
pub struct CacheAligned<T>(pub [T; LANES]);

/// 0, 1, ... 15.
#[inline(always)]
pub fn iota<S: Simd>(s: S) -> i32x16<S> {
    i32x16::from_slice(s, &[0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15])
}

/// True if a maximum is one of x86's instructions: the fallback is not.
#[inline(always)]
pub(crate) fn is_x86<S: Simd>(s: S) -> bool {
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    {
        use Level::{Avx2, Avx512, Sse2, Sse4_2};
        matches!(s.level(), Sse2(_) | Sse4_2(_) | Avx2(_) | Avx512(_))
    }
    #[cfg(not(any(target_arch = "x86", target_arch = "x86_64")))]
    {
        let _ = s;
        false
    }
}

/// The greater of each pair by selection, `other` where neither is: one of wasm's instructions, if `s` is its level.
#[inline(always)]
pub(crate) fn above_x4<S: Simd>(s: S, x: f32x4<S>, other: f32x4<S>) -> Option<f32x4<S>> {
    #[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
    return Some(f32x4_pmax(other.into(), x.into()).simd_into(s));
    #[cfg(not(all(target_arch = "wasm32", target_feature = "simd128")))]
    {
        let _ = (s, x, other);
        None
    }
}

/// The lesser of each pair, as [`above_x4`].
#[inline(always)]
pub(crate) fn below_x4<S: Simd>(s: S, x: f32x4<S>, other: f32x4<S>) -> Option<f32x4<S>> {
    #[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
    return Some(f32x4_pmin(other.into(), x.into()).simd_into(s));
    #[cfg(not(all(target_arch = "wasm32", target_feature = "simd128")))]
    {
        let _ = (s, x, other);
        None
    }
}

/// True if a level has AVX2's instructions. Pairs of words and small tables then cost less than words one by one.
#[inline(always)]
pub fn is_wide<S: Simd>(s: S) -> bool {
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    {
        matches!(s.level(), Level::Avx2(_) | Level::Avx512(_))
    }
    #[cfg(not(any(target_arch = "x86", target_arch = "x86_64")))]
    {
        let _ = s;
        false
    }
}

/// `floor(x)` as integers, for `|x| < 2^31`: one conversion where the rounding can be stated in it, a truncation and a comparison
/// on SSE2, which has no floor.
#[inline(always)]
pub fn floor_to_i32<S: Simd>(s: S, x: f32x16<S>) -> i32x16<S> {
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    match s.level() {
        Level::Avx512(token) => return floor_avx512(token, x.into()).simd_into(s),
        Level::Avx2(_) => return x.floor().to_int::<i32x16<S>>(),
        _ => {}
    }
    let cut = x.to_int::<i32x16<S>>();
    let above = cut.to_float::<f32x16<S>>().simd_gt(x);
    cut - above.select(i32x16::splat(s, 1), i32x16::splat(s, 0))
}

#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
fearless_simd::kernel!(
    #[inline]
    fn floor_avx512(token: Avx512, x: __m512) -> __m512i {
        _mm512_cvt_roundps_epi32::<{ _MM_FROUND_TO_NEG_INF | _MM_FROUND_NO_EXC }>(x)
    }
);

//! Helpers over sixteen lanes for kernels that are generic over the SIMD level ([`fearless_simd`]); outside semantic versioning.
//!
//! Each gives the bits of its scalar twin in every lane, on every level: only IEEE operations, comparisons, integers, and
//! conversions of values in range. Never use `mul_add`, `approximate_recip`, `min`/`max` of floats (but [`above`] and [`below`]) or an
//! out-of-range `to_int` of fearless_simd in a kernel: they differ by level.

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
use fearless_simd::{f32x16, i32x16, u32x16};

mod bytes;
mod gather;
mod table;

pub use bytes::lerp_bytes;
pub use gather::{
    GatherTable, gather, gather_pairs, gather_quads, gather_triples, has_pairs, prefetch,
};
pub(crate) use gather::{gather_pairs_x4, gather_x4};
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

/// `a` where it is above `b`, else `b`, zeros and NaN too: by comparison and selection, which is what x86 calls the maximum of these
/// operands.
#[inline(always)]
pub fn above<S: Simd>(a: f32x16<S>, b: f32x16<S>) -> f32x16<S> {
    if is_x86(a.simd) {
        a.max(b)
    } else {
        a.simd_gt(b).select(a, b)
    }
}

/// `a` where it is below `b`, else `b`: as [`above`].
#[inline(always)]
pub fn below<S: Simd>(a: f32x16<S>, b: f32x16<S>) -> f32x16<S> {
    if is_x86(a.simd) {
        a.min(b)
    } else {
        a.simd_lt(b).select(a, b)
    }
}

/// Whether a maximum is one of x86's instructions: the fallback is not.
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

/// Whether a level has AVX2's instructions: pairs of words and small tables then cost less than words one by one.
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

/// `x` within `[low, high]` by comparison and selection; NaN gives `low`.
#[inline(always)]
pub fn clamp<S: Simd>(x: f32x16<S>, low: f32x16<S>, high: f32x16<S>) -> f32x16<S> {
    below(above(x, low), high)
}

/// [`clamp`] for one lane.
#[inline(always)]
#[must_use]
pub fn clamp_scalar(x: f32, low: f32, high: f32) -> f32 {
    let x = if x > low { x } else { low };
    if x < high { x } else { high }
}

/// `a (1 - t) + b t`, as [`crate::interpolation::lerp_two_product`].
#[inline(always)]
pub fn lerp_two_product<S: Simd>(a: f32x16<S>, b: f32x16<S>, t: f32x16<S>) -> f32x16<S> {
    a * (1.0 - t) + b * t
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

/// [`floor_to_i32`] for one lane.
#[inline(always)]
#[must_use]
pub fn floor_to_i32_scalar(x: f32) -> i32 {
    let cut = x as i32;
    cut - i32::from(cut as f32 > x)
}

/// See [`encode_unorm8`](crate::simd::encode_unorm8).
#[inline(always)]
pub fn unit_to_u8<S: Simd>(s: S, x: f32x16<S>) -> u32x16<S> {
    crate::simd::encode_unorm8(crate::simd::X16(s), x)
}

/// See [`encode_srgb8`](crate::simd::encode_srgb8).
#[inline(always)]
pub fn linear_to_srgb8<S: Simd>(s: S, x: f32x16<S>) -> u32x16<S> {
    crate::simd::encode_srgb8(crate::simd::X16(s), x)
}

/// Sixteen values, or what there is of them, the rest filled with the last (0 for none).
#[inline(always)]
pub fn load_tail<S: Simd>(s: S, values: &[f32]) -> f32x16<S> {
    if let Some(full) = values.first_chunk::<LANES>() {
        return f32x16::from_slice(s, full);
    }
    let mut lanes = [values.last().copied().unwrap_or(0.0); LANES];
    lanes[..values.len()].copy_from_slice(values);
    f32x16::from_slice(s, &lanes)
}

/// Stores the first `out.len()` lanes, at most sixteen.
#[inline(always)]
pub fn store_tail<S: Simd>(x: f32x16<S>, out: &mut [f32]) {
    if let Some(full) = out.first_chunk_mut::<LANES>() {
        x.store_slice(full);
        return;
    }
    let mut lanes = [0.0; LANES];
    x.store_slice(&mut lanes);
    out.copy_from_slice(&lanes[..out.len()]);
}

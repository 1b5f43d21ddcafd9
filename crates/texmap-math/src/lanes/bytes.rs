//! Bytes in 16-bit lanes: the steps of packed filters.

#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
use fearless_simd::Level;
use fearless_simd::prelude::*;
use fearless_simd::u16x32;

#[cfg(target_arch = "x86")]
use core::arch::x86::{__m256i, __m512i, _mm256_mulhrs_epi16, _mm512_mulhrs_epi16};
#[cfg(target_arch = "x86_64")]
use core::arch::x86_64::{__m256i, __m512i, _mm256_mulhrs_epi16, _mm512_mulhrs_epi16};

/// `a + (b - a) w / 256`, halves up, of bytes `a`, `b` and `w`.
#[inline(always)]
pub fn lerp_bytes<S: Simd>(s: S, a: u16x32<S>, b: u16x32<S>, w: u16x32<S>) -> u16x32<S> {
    // A rounded product of 2^-15: with `w` in 2^-15ths of 128 it is the step itself, negative ones too.
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    match s.level() {
        Level::Avx512(token) => {
            let step: u16x32<S> =
                rounded_avx512(token, (b - a).into(), (w << 7).into()).simd_into(s);
            return a + step;
        }
        Level::Avx2(token) => {
            let (d, w) = (s.split_u16x32(b - a), s.split_u16x32(w << 7));
            let low = rounded_avx2(token, d.0.into(), w.0.into()).simd_into(s);
            let high = rounded_avx2(token, d.1.into(), w.1.into()).simd_into(s);
            return a + s.combine_u16x16(low, high);
        }
        _ => {}
    }
    let _ = s;
    ((a << 8) + (b - a) * w + 128) >> 8
}

#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
fearless_simd::kernel!(
    #[inline(always)]
    fn rounded_avx2(token: Avx2, a: __m256i, b: __m256i) -> __m256i {
        _mm256_mulhrs_epi16(a, b)
    }
);

#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
fearless_simd::kernel!(
    #[inline]
    fn rounded_avx512(token: Avx512, a: __m512i, b: __m512i) -> __m512i {
        _mm512_mulhrs_epi16(a, b)
    }
);

//! Look-ups in tables that fit a register.

use fearless_simd::prelude::*;
#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
use fearless_simd::{Level, f32x8, u32x8};
use fearless_simd::{f32x16, u32x16};

#[cfg(target_arch = "x86")]
use core::arch::x86::{
    __m256, __m256i, __m512, __m512i, _mm256_blendv_ps, _mm256_castps_si256, _mm256_castsi256_ps,
    _mm256_permutevar8x32_epi32, _mm256_permutevar8x32_ps, _mm256_slli_epi32,
    _mm512_castps256_ps512, _mm512_permutexvar_epi32, _mm512_permutexvar_ps,
};
#[cfg(target_arch = "x86_64")]
use core::arch::x86_64::{
    __m256, __m256i, __m512, __m512i, _mm256_blendv_ps, _mm256_castps_si256, _mm256_castsi256_ps,
    _mm256_permutevar8x32_epi32, _mm256_permutevar8x32_ps, _mm256_slli_epi32,
    _mm512_castps256_ps512, _mm512_permutexvar_epi32, _mm512_permutexvar_ps,
};

/// The values of a table of eight at sixteen indices below 8.
#[inline(always)]
pub fn lookup8<S: Simd>(s: S, table: &[f32; 8], index: u32x16<S>) -> f32x16<S> {
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    match s.level() {
        Level::Avx512(token) => {
            let table = f32x8::from_slice(s, table);
            return octet_avx512(token, table.into(), index.into()).simd_into(s);
        }
        Level::Avx2(token) => {
            let table = f32x8::from_slice(s, table);
            let (low, high) = s.split_u32x16(index);
            let low = octet_avx2(token, table.into(), low.into()).simd_into(s);
            let high = octet_avx2(token, table.into(), high.into()).simd_into(s);
            return s.combine_f32x8(low, high);
        }
        _ => {}
    }
    let mut lanes = [0; 16];
    index.store_slice(&mut lanes);
    f32x16::from_slice(s, &lanes.map(|i: u32| table[i as usize & 7]))
}

/// The words of a table of sixteen at sixteen indices, of which the last four bits count.
#[inline(always)]
pub fn lookup16<S: Simd>(s: S, table: &[u32; 16], index: u32x16<S>) -> u32x16<S> {
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    match s.level() {
        Level::Avx512(token) => {
            let table = u32x16::from_slice(s, table);
            return look_up_avx512(token, table.into(), index.into()).simd_into(s);
        }
        Level::Avx2(token) => {
            let (first, second) = table.split_at(8);
            let first = u32x8::from_slice(s, first).into();
            let second = u32x8::from_slice(s, second).into();
            let (low, high) = s.split_u32x16(index);
            let low = look_up_avx2(token, first, second, low.into()).simd_into(s);
            let high = look_up_avx2(token, first, second, high.into()).simd_into(s);
            return s.combine_u32x8(low, high);
        }
        _ => {}
    }
    let mut lanes = [0; 16];
    index.store_slice(&mut lanes);
    for lane in &mut lanes {
        *lane = table[*lane as usize & 15];
    }
    u32x16::from_slice(s, &lanes)
}

#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
fearless_simd::kernel!(
    #[inline(always)]
    fn octet_avx2(token: Avx2, table: __m256, index: __m256i) -> __m256 {
        _mm256_permutevar8x32_ps(table, index)
    }
);

#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
fearless_simd::kernel!(
    #[inline]
    fn octet_avx512(token: Avx512, table: __m256, index: __m512i) -> __m512 {
        _mm512_permutexvar_ps(index, _mm512_castps256_ps512(table))
    }
);

#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
fearless_simd::kernel!(
    /// From both halves of the table, and the half that bit 3 of an index names.
    #[inline(always)]
    fn look_up_avx2(token: Avx2, first: __m256i, second: __m256i, index: __m256i) -> __m256i {
        let first = _mm256_castsi256_ps(_mm256_permutevar8x32_epi32(first, index));
        let second = _mm256_castsi256_ps(_mm256_permutevar8x32_epi32(second, index));
        let half = _mm256_castsi256_ps(_mm256_slli_epi32::<28>(index));
        _mm256_castps_si256(_mm256_blendv_ps(first, second, half))
    }
);

#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
fearless_simd::kernel!(
    #[inline]
    fn look_up_avx512(token: Avx512, table: __m512i, index: __m512i) -> __m512i {
        _mm512_permutexvar_epi32(index, table)
    }
);

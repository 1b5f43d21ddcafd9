//! From a level to code: kernels exist up to three times on x86 and once elsewhere.

/// False in builds without optimisation (opt-level 0 of this crate). Each lane operation is a call there and has stack of its own, so
/// that kernels would need megabytes of it and more time than their scalar versions, which stand in with the same bits.
#[doc(hidden)]
pub const LANES: bool = !cfg!(texmap_unoptimised);

/// Runs `$lanes` with the token `$s` of `$level` where a register or two hold sixteen lanes, else `$plain`. For stores of whole cache
/// lines; kernels go through [`dispatch_simd!`](crate::dispatch_simd).
#[doc(hidden)]
#[macro_export]
macro_rules! on_wide_level {
    ($level:expr, $s:ident => $lanes:expr, else $plain:expr) => {
        match $level {
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            $crate::Level::Avx512($s) if $crate::LANES => $crate::fearless_simd::Simd::vectorize(
                $s,
                #[inline(always)]
                || $lanes,
            ),
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            $crate::Level::Avx2($s) if $crate::LANES => $crate::fearless_simd::Simd::vectorize(
                $s,
                #[inline(always)]
                || $lanes,
            ),
            #[cfg(target_arch = "aarch64")]
            $crate::Level::Neon($s) if $crate::LANES => $crate::fearless_simd::Simd::vectorize(
                $s,
                #[inline(always)]
                || $lanes,
            ),
            #[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
            $crate::Level::WasmSimd128($s) if $crate::LANES => {
                $crate::fearless_simd::Simd::vectorize(
                    $s,
                    #[inline(always)]
                    || $lanes,
                )
            }
            _ => $plain,
        }
    };
}

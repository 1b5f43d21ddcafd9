//! From a level to code: kernels exist up to three times on x86 and once elsewhere.

/// False in builds without optimisation (opt-level 0 of this crate): each lane operation is a call there and has stack of its own, so
/// that kernels would need megabytes of it and more time than their scalar twins, which stand in with the same bits.
#[doc(hidden)]
pub const LANES: bool = !cfg!(texmap_unoptimised);

/// Runs `$lanes` with the token `$s` of `$level` and its instructions, or `$plain` where there are no lanes (the scalar
/// fallback: the plain twin gives the same bits and compiles in a fraction of the time; lanes of arrays took texmap-uv minutes).
///
/// SSE4.2 takes the SSE2 kernels: f64 and i32 lanes of 128 bits gain too little to be compiled once more.
#[doc(hidden)]
#[macro_export]
macro_rules! on_level {
    ($level:expr, $s:ident => $lanes:expr, else $plain:expr) => {
        $crate::dispatch_simd!($level, $s => $lanes, else {
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            if $crate::LANES && let Some($s) = $level.as_sse2() {
                $crate::fearless_simd::Simd::vectorize(
                    $s,
                    #[inline(always)]
                    || $lanes,
                )
            } else {
                $plain
            }
            #[cfg(not(any(target_arch = "x86", target_arch = "x86_64")))]
            $plain
        })
    };
}

/// [`on_level!`] for kernels that are large and many: SSE, with half of AVX2's lanes and no gathers, takes `$plain` too.
#[doc(hidden)]
#[macro_export]
macro_rules! dispatch_simd {
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

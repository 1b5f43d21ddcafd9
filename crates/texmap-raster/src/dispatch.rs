//! From a level to code: the kernels of this crate exist three times on x86 and once elsewhere.

/// Runs `$lanes` with the token `$s` of `$level` and its instructions, or `$plain` where there are no lanes (the scalar
/// fallback: the plain twin gives the same bits and compiles in a fraction of the time).
///
/// SSE4.2 takes the SSE2 kernels: f64 and i32 lanes of 128 bits gain too little to be compiled once more.
macro_rules! on_level {
    ($level:expr, $s:ident => $lanes:expr, else $plain:expr) => {
        match $level {
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            texmap_math::Level::Avx512($s) => $s.vectorize(
                #[inline(always)]
                || $lanes,
            ),
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            texmap_math::Level::Avx2($s) => $s.vectorize(
                #[inline(always)]
                || $lanes,
            ),
            #[cfg(target_arch = "aarch64")]
            texmap_math::Level::Neon($s) => $s.vectorize(
                #[inline(always)]
                || $lanes,
            ),
            #[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
            texmap_math::Level::WasmSimd128($s) => $s.vectorize(
                #[inline(always)]
                || $lanes,
            ),
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            other => match other.as_sse2() {
                Some($s) => $s.vectorize(
                    #[inline(always)]
                    || $lanes,
                ),
                None => $plain,
            },
            #[cfg(not(any(target_arch = "x86", target_arch = "x86_64")))]
            _ => $plain,
        }
    };
}

pub(crate) use on_level;

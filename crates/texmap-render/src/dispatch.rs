//! From a level to code, for the few kernels of this crate.

/// Runs `$lanes` with the token `$s` of `$level` and its instructions, or `$plain`, its scalar twin, where there are no lanes.
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
            _ => $plain,
        }
    };
}

pub(crate) use on_level;

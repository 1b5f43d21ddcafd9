//! From a SIMD level to a kernel's width: the one table.

/// Runs `$kernel` with `$i` bound to the [`Isa`](crate::simd::Isa) of `$level`, compiled with its instructions:
///
/// | level | lanes | lanes with `wide` |
/// |---|---|---|
/// | AVX-512, AVX2 | 16 | 16 |
/// | SSE2 (and SSE4.2), NEON, wasm simd128 | 4 | 16 |
/// | none, and builds without optimisation | 1 | 1 |
///
/// `wide` is for kernels that gain by four registers at once on 128-bit levels: their code is three times as large there.
#[doc(hidden)]
#[macro_export]
macro_rules! dispatch_simd {
    ($level:expr, wide $i:ident => $kernel:expr) => {
        $crate::dispatch_simd!(@widths X16 X16, $level, $i => $kernel)
    };
    ($level:expr, $i:ident => $kernel:expr) => {
        $crate::dispatch_simd!(@widths X16 X4, $level, $i => $kernel)
    };
    (@widths $wide:ident $narrow:ident, $level:expr, $i:ident => $kernel:expr) => {
        match $level {
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            $crate::Level::Avx512(s) if $crate::LANES => {
                $crate::dispatch_simd!(@run $wide, s, $i => $kernel)
            }
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            $crate::Level::Avx2(s) if $crate::LANES => {
                $crate::dispatch_simd!(@run $wide, s, $i => $kernel)
            }
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            $crate::Level::Sse4_2(s) if $crate::LANES => {
                let s = $crate::fearless_simd::Simd::level(s).as_sse2();
                match s {
                    Some(s) => $crate::dispatch_simd!(@run $narrow, s, $i => $kernel),
                    None => $crate::dispatch_simd!(@scalar $i => $kernel),
                }
            }
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            $crate::Level::Sse2(s) if $crate::LANES => {
                $crate::dispatch_simd!(@run $narrow, s, $i => $kernel)
            }
            #[cfg(target_arch = "aarch64")]
            $crate::Level::Neon(s) if $crate::LANES => {
                $crate::dispatch_simd!(@run $narrow, s, $i => $kernel)
            }
            #[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
            $crate::Level::WasmSimd128(s) if $crate::LANES => {
                $crate::dispatch_simd!(@run $narrow, s, $i => $kernel)
            }
            _ => $crate::dispatch_simd!(@scalar $i => $kernel),
        }
    };
    (@run $width:ident, $s:ident, $i:ident => $kernel:expr) => {{
        let $i = $crate::simd::$width($s);
        $crate::fearless_simd::Simd::vectorize(
            $s,
            #[inline(always)]
            || $kernel,
        )
    }};
    (@scalar $i:ident => $kernel:expr) => {{
        let $i = $crate::simd::Scalar;
        $kernel
    }};
}

//! From a SIMD level to a kernel's width: the one table.

use fearless_simd::Level;
#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
use fearless_simd::{Avx2, Avx512, Sse2};

/// A level as kernels are compiled for it. SSE4.2 is SSE2 to them: one form of a kernel serves both, and is compiled once.
#[doc(hidden)]
#[derive(Clone, Copy, Debug)]
pub enum KernelLevel {
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    Avx512(Avx512),
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    Avx2(Avx2),
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    Sse2(Sse2),
    #[cfg(target_arch = "aarch64")]
    Neon(fearless_simd::Neon),
    #[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
    WasmSimd128(fearless_simd::WasmSimd128),
    /// No vector unit that kernels use.
    Scalar,
}

impl KernelLevel {
    #[inline(always)]
    pub fn of(level: Level) -> Self {
        match level {
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            Level::Avx512(s) => Self::Avx512(s),
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            Level::Avx2(s) => Self::Avx2(s),
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            _ => level.as_sse2().map_or(Self::Scalar, Self::Sse2),
            #[cfg(target_arch = "aarch64")]
            Level::Neon(s) => Self::Neon(s),
            #[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
            Level::WasmSimd128(s) => Self::WasmSimd128(s),
            #[cfg(not(any(target_arch = "x86", target_arch = "x86_64")))]
            #[allow(unreachable_patterns, reason = "some targets have no fallback")]
            _ => Self::Scalar,
        }
    }
}

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
        match $crate::simd::KernelLevel::of($level) {
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            $crate::simd::KernelLevel::Avx512(s) if $crate::LANES => {
                $crate::dispatch_simd!(@run $wide, s, $i => $kernel)
            }
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            $crate::simd::KernelLevel::Avx2(s) if $crate::LANES => {
                $crate::dispatch_simd!(@run $wide, s, $i => $kernel)
            }
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            $crate::simd::KernelLevel::Sse2(s) if $crate::LANES => {
                $crate::dispatch_simd!(@run $narrow, s, $i => $kernel)
            }
            #[cfg(target_arch = "aarch64")]
            $crate::simd::KernelLevel::Neon(s) if $crate::LANES => {
                $crate::dispatch_simd!(@run $narrow, s, $i => $kernel)
            }
            #[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
            $crate::simd::KernelLevel::WasmSimd128(s) if $crate::LANES => {
                $crate::dispatch_simd!(@run $narrow, s, $i => $kernel)
            }
            _ => {
                let $i = $crate::simd::Scalar;
                $kernel
            }
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
}

//! The operations that the formulas need, for one f64 and for lanes of it.

use core::ops::{Add, BitAnd, BitOr, Div, Mul, Not, Sub};

use fearless_simd::prelude::*;
use fearless_simd::{f32x4, f32x16, f64x4, f64x8, mask64x4, mask64x8};

use crate::simd::Isa;

/// 1.5 * 2^52: added to `|x| < 2^51` it leaves the nearest integer in the low bits.
const MAGIC: f64 = 6_755_399_441_055_744.0;
/// 2^52: over an integer below it in the low bits it reads as 2^52 + that integer.
const TWO_52: f64 = 4_503_599_627_370_496.0;
const ONE_BITS: u64 = 0x3ff0_0000_0000_0000;
const SQRT_HALF_BITS: u64 = 0x3fe6_a09e_667f_3bcd;
const MANTISSA: u64 = (1 << 52) - 1;
const SIGN: u64 = 1 << 63;

/// An f64 or eight of them.
pub(super) trait Wide:
    Copy
    + Add<Output = Self>
    + Add<f64, Output = Self>
    + Sub<Output = Self>
    + Sub<f64, Output = Self>
    + Mul<Output = Self>
    + Mul<f64, Output = Self>
    + Div<Output = Self>
{
    /// A truth value per number.
    type Mask: Copy
        + BitAnd<Output = Self::Mask>
        + BitOr<Output = Self::Mask>
        + Not<Output = Self::Mask>;

    /// `c` in every lane.
    fn constant(self, c: f64) -> Self;
    fn abs(self) -> Self;
    fn sqrt(self) -> Self;
    fn lt(self, other: Self) -> Self::Mask;
    fn eq(self, other: Self) -> Self::Mask;
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self;
    /// Bit `bit` of the integer nearest to `self`, `|self| < 2^51`.
    fn has_bit(self, bit: u32) -> Self::Mask;
    /// 2^self for an integer in -1022..=1023.
    fn power_of_two(self) -> Self;
    /// `self = 2^e (1 + f)` for a positive normal number, `1 + f` in [sqrt(1/2), sqrt 2): gives e and f, both exact.
    fn decompose(self) -> (Self, Self);
    /// The magnitude of `self` with the sign of `other`.
    fn with_sign_of(self, other: Self) -> Self;

    /// The nearest integer, ties to even, of `|self| < 2^51`.
    #[inline(always)]
    fn nearest(self) -> Self {
        (self + MAGIC) - MAGIC
    }

    #[inline(always)]
    fn negate_where(self, mask: Self::Mask) -> Self {
        Self::select(mask, self * -1.0, self)
    }

    #[inline(always)]
    fn is_nan(self) -> Self::Mask {
        !self.eq(self)
    }

    /// `self` within [low, high]; NaN gives `low`.
    #[inline(always)]
    fn clamp(self, low: f64, high: f64) -> Self {
        let (low, high) = (self.constant(low), self.constant(high));
        let x = Self::select(low.lt(self), self, low);
        Self::select(x.lt(high), x, high)
    }
}

impl Wide for f64 {
    type Mask = bool;

    #[inline(always)]
    fn constant(self, c: f64) -> Self {
        c
    }

    #[inline(always)]
    fn abs(self) -> Self {
        Self::abs(self)
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        crate::float::sqrt(self)
    }

    #[inline(always)]
    fn lt(self, other: Self) -> bool {
        self < other
    }

    #[inline(always)]
    fn eq(self, other: Self) -> bool {
        self == other
    }

    #[inline(always)]
    fn select(mask: bool, yes: Self, no: Self) -> Self {
        if mask { yes } else { no }
    }

    #[inline(always)]
    fn has_bit(self, bit: u32) -> bool {
        (self + MAGIC).to_bits() & (1 << bit) != 0
    }

    #[inline(always)]
    fn power_of_two(self) -> Self {
        Self::from_bits(((self + MAGIC).to_bits() << 52).wrapping_add(ONE_BITS))
    }

    #[inline(always)]
    fn decompose(self) -> (Self, Self) {
        let moved = self.to_bits() + (ONE_BITS - SQRT_HALF_BITS);
        let e = Self::from_bits((moved >> 52) | TWO_52.to_bits()) - (TWO_52 + 1023.0);
        let m = Self::from_bits((moved & MANTISSA) + SQRT_HALF_BITS);
        (e, m - 1.0)
    }

    #[inline(always)]
    fn with_sign_of(self, other: Self) -> Self {
        Self::from_bits(self.to_bits() & !SIGN | other.to_bits() & SIGN)
    }
}

macro_rules! wide {
    ($lanes:ident, $mask:ident) => {
        impl<S: Simd> Wide for $lanes<S> {
            type Mask = $mask<S>;

            #[inline(always)]
            fn constant(self, c: f64) -> Self {
                Self::splat(self.simd, c)
            }

            #[inline(always)]
            fn abs(self) -> Self {
                SimdBase::abs(self)
            }

            #[inline(always)]
            fn sqrt(self) -> Self {
                SimdFloat::sqrt(self)
            }

            #[inline(always)]
            fn lt(self, other: Self) -> $mask<S> {
                self.simd_lt(other)
            }

            #[inline(always)]
            fn eq(self, other: Self) -> $mask<S> {
                self.simd_eq(other)
            }

            #[inline(always)]
            fn select(mask: $mask<S>, yes: Self, no: Self) -> Self {
                Select::select(mask, yes, no)
            }

            #[inline(always)]
            fn has_bit(self, bit: u32) -> $mask<S> {
                !((self + MAGIC).to_bits() & (1 << bit)).simd_eq(0)
            }

            #[inline(always)]
            fn power_of_two(self) -> Self {
                Self::from_bits(((self + MAGIC).to_bits() << 52) + ONE_BITS)
            }

            #[inline(always)]
            fn decompose(self) -> (Self, Self) {
                let moved = self.to_bits() + (ONE_BITS - SQRT_HALF_BITS);
                let e = Self::from_bits((moved >> 52) | TWO_52.to_bits()) - (TWO_52 + 1023.0);
                let m = Self::from_bits((moved & MANTISSA) + SQRT_HALF_BITS);
                (e, m - 1.0)
            }

            #[inline(always)]
            fn with_sign_of(self, other: Self) -> Self {
                Self::from_bits((self.to_bits() & !SIGN) | (other.to_bits() & SIGN))
            }
        }
    };
}
wide!(f64x4, mask64x4);
wide!(f64x8, mask64x8);

/// Defines a function over lanes: of 16 and of 4 at once, or the scalar function for one. The formulas are compiled here, once per
/// level, and not again in each generic kernel that calls them.
macro_rules! lanes_of {
    ($(#[$doc:meta])* $name:ident($($x:ident),+) by $apply:ident = $formula:ident, $scalar:ident) => {
        $(#[$doc])*
        #[inline(always)]
        pub fn $name<I: Isa>(i: I, $($x: I::F32),+) -> I::F32 {
            fn four(level: Level, $($x: [f32; 4]),+) -> [f32; 4] {
                $crate::det32::wide::on_level!(level, t => {
                    $(let $x = $crate::simd::X4(t).widen(f32x4::from_slice(t, &$x));)+
                    $crate::det32::wide::narrow_x4($formula($($x),+)).into()
                }, core::array::from_fn(|i| $scalar($($x[i]),+)))
            }
            fn sixteen(level: Level, $($x: [f32; 16]),+) -> [f32; 16] {
                $crate::det32::wide::on_level!(level, t => {
                    $(let $x = t.widen_f32x16(f32x16::from_slice(t, &$x));)+
                    $crate::det32::wide::narrow($formula($($x.0),+), $formula($($x.1),+)).into()
                }, core::array::from_fn(|i| $scalar($($x[i]),+)))
            }
            i.$apply($($x,)+ $scalar, four, sixteen)
        }
    };
}
pub(super) use lanes_of;

/// One arm per level for an expression over its token, and an expression for the scalar fallback. SSE4.2 has nothing for f64 that SSE2
/// lacks here.
macro_rules! on_level {
    ($level:expr, $t:ident => $lanes:expr, $scalar:expr) => {{
        #[inline(always)]
        fn vectorize<S: Simd, R>(s: S, f: impl FnOnce(S) -> R) -> R {
            s.vectorize(
                #[inline(always)]
                || f(s),
            )
        }
        let level = $level;
        #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
        {
            if let Some($t) = level.as_avx512() {
                return vectorize(
                    $t,
                    #[inline(always)]
                    |$t| $lanes,
                );
            }
            if let Some($t) = level.as_avx2() {
                return vectorize(
                    $t,
                    #[inline(always)]
                    |$t| $lanes,
                );
            }
            if let Some($t) = level.as_sse2() {
                return vectorize(
                    $t,
                    #[inline(always)]
                    |$t| $lanes,
                );
            }
        }
        #[cfg(target_arch = "aarch64")]
        if let Some($t) = level.as_neon() {
            return vectorize(
                $t,
                #[inline(always)]
                |$t| $lanes,
            );
        }
        #[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
        if let Some($t) = level.as_wasm_simd128() {
            return vectorize(
                $t,
                #[inline(always)]
                |$t| $lanes,
            );
        }
        $scalar
    }};
}
pub(super) use on_level;

/// Two times eight f64 rounded to sixteen f32; every NaN becomes the same one.
#[inline(always)]
pub(super) fn narrow<S: Simd>(low: f64x8<S>, high: f64x8<S>) -> f32x16<S> {
    let x = low.simd.narrow_f64x8(low, high);
    x.simd_eq(x).select(x, f32x16::splat(x.simd, f32::NAN))
}

/// [`narrow`] of four.
#[inline(always)]
pub(super) fn narrow_x4<S: Simd>(x: f64x4<S>) -> f32x4<S> {
    let x = crate::simd::X4(x.simd).narrow(x);
    x.simd_eq(x).select(x, f32x4::splat(x.simd, f32::NAN))
}

/// [`narrow`] for one number.
#[inline(always)]
pub(super) fn round(x: f64) -> f32 {
    let x = x as f32;
    if x.is_nan() { f32::NAN } else { x }
}

/// The polynomial `c0 + c1 z + c2 z^2 + ...` by Horner's rule: multiply, then add.
macro_rules! polynomial {
    ($z:expr; $last:expr) => { $z.constant($last) };
    ($z:expr; $first:expr, $($rest:expr),+) => { $crate::det32::wide::polynomial!($z; $($rest),+) * $z + $first };
}
pub(super) use polynomial;

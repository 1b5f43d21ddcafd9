//! The operations that the formulas need, for one f64 and for lanes of it.

use core::ops::{Add, BitAnd, BitOr, Div, Mul, Not, Sub};

use fearless_simd::prelude::*;
use fearless_simd::{f64x4, f64x8, mask64x4, mask64x8};

use crate::simd::{self, Isa, Pair};

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

/// An f64 for each lane, in vectors that one formula serves. Closures are called where they are: a call by reference might not be inlined.
pub(super) trait Vectors: Copy {
    type Vector: Wide;
    /// `f` of each vector.
    fn map(self, f: &impl Fn(Self::Vector) -> Self::Vector) -> Self;
    /// `f` of each vector and that of `other`.
    fn map2(self, other: Self, f: &impl Fn(Self::Vector, Self::Vector) -> Self::Vector) -> Self;
}

macro_rules! one_vector {
    ($t:ty $(, $s:ident: $simd:ident)?) => {
        impl$(<$s: $simd>)? Vectors for $t {
            type Vector = Self;
            #[inline(always)]
            fn map(self, f: &impl Fn(Self) -> Self) -> Self {
                (*f)(self)
            }
            #[inline(always)]
            fn map2(self, other: Self, f: &impl Fn(Self, Self) -> Self) -> Self {
                (*f)(self, other)
            }
        }
    };
}
one_vector!(f64);
one_vector!(f64x4<S>, S: Simd);

impl<T: Wide> Vectors for Pair<T> {
    type Vector = T;
    #[inline(always)]
    fn map(self, f: &impl Fn(T) -> T) -> Self {
        Self((*f)(self.0), (*f)(self.1))
    }
    #[inline(always)]
    fn map2(self, other: Self, f: &impl Fn(T, T) -> T) -> Self {
        Self((*f)(self.0, other.0), (*f)(self.1, other.1))
    }
}

type Vector<I> = <<I as Isa>::F64 as Vectors>::Vector;

/// `f` of each of `x`, `N` of them a multiple of the lanes, rounded to f32. Every NaN becomes the same one.
#[inline(always)]
pub(super) fn each<I: Isa<F64: Vectors>, const N: usize>(
    i: I,
    x: [f32; N],
    f: impl Fn(Vector<I>) -> Vector<I>,
) -> [f32; N] {
    let mut out = [0.0; N];
    for at in (0..N).step_by(I::LANES) {
        let x = i.widen(i.load_f32(&x[at..]));
        simd::Number::store(narrow(i, x.map(&f)), &mut out[at..]);
    }
    out
}

/// [`each`] of two.
#[inline(always)]
pub(super) fn each2<I: Isa<F64: Vectors>, const N: usize>(
    i: I,
    x: [f32; N],
    y: [f32; N],
    f: impl Fn(Vector<I>, Vector<I>) -> Vector<I>,
) -> [f32; N] {
    let mut out = [0.0; N];
    for at in (0..N).step_by(I::LANES) {
        let x = i.widen(i.load_f32(&x[at..]));
        let y = i.widen(i.load_f32(&y[at..]));
        simd::Number::store(narrow(i, x.map2(y, &f)), &mut out[at..]);
    }
    out
}

#[inline(always)]
fn narrow<I: Isa>(i: I, x: I::F64) -> I::F32 {
    let x = i.narrow(x);
    simd::Select::select(simd::Compare::simd_eq(x, x), x, i.f32(f32::NAN))
}

/// Defines a function over lanes. The formulas are compiled here, once per level for 16 and for 4 numbers, and not again in each generic
/// kernel that calls them.
macro_rules! lanes_of {
    ($(#[$doc:meta])* $name:ident($($x:ident),+) by $apply:ident, $each:ident = $formula:ident, $scalar:ident) => {
        $(#[$doc])*
        #[inline(always)]
        pub fn $name<I: Isa>(i: I, $($x: I::F32),+) -> I::F32 {
            fn four(level: Level, $($x: [f32; 4]),+) -> [f32; 4] {
                $crate::dispatch_simd!(@widths X4 X4, level, i => $each(i, $($x,)+ #[inline(always)] |$($x),+| $formula($($x),+)))
            }
            fn sixteen(level: Level, $($x: [f32; 16]),+) -> [f32; 16] {
                $crate::dispatch_simd!(level, wide i => $each(i, $($x,)+ #[inline(always)] |$($x),+| $formula($($x),+)))
            }
            i.$apply($($x,)+ $scalar, four, sixteen)
        }
    };
}
pub(super) use lanes_of;

/// Rounds to f32; every NaN becomes the same one.
#[inline(always)]
pub(super) fn round(x: f64) -> f32 {
    let x = x as f32;
    if x.is_nan() { f32::NAN } else { x }
}

/// The polynomial `c0 + c1 z + c2 z^2 + ...` by Horner's rule: multiply, then add.
macro_rules! polynomial {
    ($z:expr; $last:expr) => { $z.constant($last) };
    ($z:expr; $first:expr, $($rest:expr),+) => { $crate::deterministic_f32::wide::polynomial!($z; $($rest),+) * $z + $first };
}
pub(super) use polynomial;

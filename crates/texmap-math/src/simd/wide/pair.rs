//! Sixteen lanes of f64 as two halves.

use core::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Neg, Not, Sub};

use fearless_simd::{Simd, SimdBase, SimdFloat, SimdMask, f64x8, mask64x8};

use super::super::{Compare, Float, Mask, Number, Select};

/// Two halves: f64 lanes as many as of f32.
#[derive(Clone, Copy, Debug)]
pub struct Pair<T>(pub T, pub T);

macro_rules! pair_operator {
    ($trait:ident, $name:ident) => {
        impl<T: $trait<Output = T>> $trait for Pair<T> {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                Self(self.0.$name(other.0), self.1.$name(other.1))
            }
        }
        impl<T: $trait<f64, Output = T>> $trait<f64> for Pair<T> {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: f64) -> Self {
                Self(self.0.$name(other), self.1.$name(other))
            }
        }
    };
    (same $trait:ident, $name:ident) => {
        impl<T: $trait<Output = T>> $trait for Pair<T> {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                Self(self.0.$name(other.0), self.1.$name(other.1))
            }
        }
    };
    (one $trait:ident, $name:ident) => {
        impl<T: $trait<Output = T>> $trait for Pair<T> {
            type Output = Self;
            #[inline(always)]
            fn $name(self) -> Self {
                Self(self.0.$name(), self.1.$name())
            }
        }
    };
}
pair_operator!(Add, add);
pair_operator!(Sub, sub);
pair_operator!(Mul, mul);
pair_operator!(Div, div);
pair_operator!(one Neg, neg);
pair_operator!(one Not, not);
pair_operator!(same BitAnd, bitand);
pair_operator!(same BitOr, bitor);
pair_operator!(same BitXor, bitxor);

macro_rules! pair_compare {
    ($($name:ident)*) => {
        impl<S: Simd> Compare<Self> for Pair<f64x8<S>> {
            type Mask = Pair<mask64x8<S>>;
            $(#[inline(always)]
            fn $name(self, other: Self) -> Self::Mask {
                Pair(Compare::$name(self.0, other.0), Compare::$name(self.1, other.1))
            })*
        }
        impl<S: Simd> Compare<f64> for Pair<f64x8<S>> {
            type Mask = Pair<mask64x8<S>>;
            $(#[inline(always)]
            fn $name(self, other: f64) -> Self::Mask {
                Pair(Compare::$name(self.0, other), Compare::$name(self.1, other))
            })*
        }
    };
}
pair_compare!(simd_eq simd_lt simd_le simd_gt simd_ge);

impl<S: Simd> Number<f64> for Pair<f64x8<S>> {
    #[inline(always)]
    fn store(self, out: &mut [f64]) {
        SimdBase::store_slice(&self.0, &mut out[..8]);
        SimdBase::store_slice(&self.1, &mut out[8..16]);
    }
}

impl<S: Simd> Float<f64, Pair<mask64x8<S>>> for Pair<f64x8<S>> {
    #[inline(always)]
    fn abs(self) -> Self {
        Self(SimdBase::abs(self.0), SimdBase::abs(self.1))
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(SimdFloat::sqrt(self.0), SimdFloat::sqrt(self.1))
    }
}

impl<S: Simd> Mask for Pair<mask64x8<S>> {
    #[inline(always)]
    fn any_true(self) -> bool {
        SimdMask::any_true(self.0 | self.1)
    }
    #[inline(always)]
    fn all_true(self) -> bool {
        SimdMask::all_true(self.0 & self.1)
    }
    #[inline(always)]
    fn to_bitmask(self) -> u32 {
        (SimdMask::to_bitmask(self.0) | SimdMask::to_bitmask(self.1) << 8) as u32
    }
}

impl<S: Simd> Select<Pair<f64x8<S>>> for Pair<mask64x8<S>> {
    #[inline(always)]
    fn select(self, yes: Pair<f64x8<S>>, no: Pair<f64x8<S>>) -> Pair<f64x8<S>> {
        Pair(
            Select::select(self.0, yes.0, no.0),
            Select::select(self.1, yes.1, no.1),
        )
    }
}

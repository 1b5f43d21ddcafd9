//! One lane: the same kernels as plain Rust, for single look-ups and for builds and CPUs without vector instructions.

use core::ops::{Add, BitAnd, BitOr, BitXor, Mul, Neg, Shl, Shr, Sub};

use super::{Compare, F32s, Float, GatherTable, I32s, Int, Isa, Level, Mask, Number, Select, U32s};

/// One lane.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Scalar;

/// An i32 or u32 whose arithmetic wraps, as that of vectors does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct One<T>(pub T);

macro_rules! compare {
    ($lane:ty, $other:ty, $left:ident, $right:ident => $a:expr, $b:expr) => {
        impl Compare<$other> for $lane {
            type Mask = bool;
            #[inline(always)]
            fn simd_eq(self, other: $other) -> bool {
                let ($left, $right) = (self, other);
                $a == $b
            }
            #[inline(always)]
            fn simd_lt(self, other: $other) -> bool {
                let ($left, $right) = (self, other);
                $a < $b
            }
            #[inline(always)]
            fn simd_le(self, other: $other) -> bool {
                let ($left, $right) = (self, other);
                $a <= $b
            }
            #[inline(always)]
            fn simd_gt(self, other: $other) -> bool {
                let ($left, $right) = (self, other);
                $a > $b
            }
            #[inline(always)]
            fn simd_ge(self, other: $other) -> bool {
                let ($left, $right) = (self, other);
                $a >= $b
            }
        }
    };
}
compare!(f32, f32, a, b => a, b);
compare!(f64, f64, a, b => a, b);
compare!(One<i32>, Self, a, b => a.0, b.0);
compare!(One<i32>, i32, a, b => a.0, b);
compare!(One<u32>, Self, a, b => a.0, b.0);
compare!(One<u32>, u32, a, b => a.0, b);

impl<T> Select<T> for bool {
    #[inline(always)]
    fn select(self, yes: T, no: T) -> T {
        if self { yes } else { no }
    }
}

impl Mask for bool {
    #[inline(always)]
    fn any_true(self) -> bool {
        self
    }
    #[inline(always)]
    fn all_true(self) -> bool {
        self
    }
    #[inline(always)]
    fn to_bitmask(self) -> u32 {
        u32::from(self)
    }
}

macro_rules! float {
    ($t:ty, $sqrt:path) => {
        impl Number<$t> for $t {
            #[inline(always)]
            fn store(self, out: &mut [$t]) {
                out[0] = self;
            }
        }
        impl Float<$t, bool> for $t {
            #[inline(always)]
            fn abs(self) -> Self {
                <$t>::abs(self)
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                $sqrt(self)
            }
        }
    };
}
float!(f32, crate::float::sqrt_f32);
float!(f64, crate::float::sqrt);

impl F32s<Scalar> for f32 {
    #[inline(always)]
    fn to_i32(self) -> One<i32> {
        One(self as i32)
    }
    #[inline(always)]
    fn to_bits(self) -> One<u32> {
        One(Self::to_bits(self))
    }
    #[inline(always)]
    fn above(self, other: Self) -> Self {
        if self > other { self } else { other }
    }
    #[inline(always)]
    fn below(self, other: Self) -> Self {
        if self < other { self } else { other }
    }
    #[inline(always)]
    fn floor_to_i32(self) -> One<i32> {
        let cut = self as i32;
        One(cut - i32::from(cut as Self > self))
    }
    #[inline(always)]
    fn floor(self) -> Self {
        crate::float::floor_f32(self)
    }
}

macro_rules! int {
    ($t:ty) => {
        int!($t, Add, add, wrapping_add);
        int!($t, Sub, sub, wrapping_sub);
        int!($t, Mul, mul, wrapping_mul);
        int!(bits $t, BitAnd, bitand, &);
        int!(bits $t, BitOr, bitor, |);
        int!(bits $t, BitXor, bitxor, ^);
        impl Shl<u32> for One<$t> {
            type Output = Self;
            #[inline(always)]
            fn shl(self, by: u32) -> Self {
                Self(self.0 << by)
            }
        }
        impl Shr<u32> for One<$t> {
            type Output = Self;
            #[inline(always)]
            fn shr(self, by: u32) -> Self {
                Self(self.0 >> by)
            }
        }
        impl Number<$t> for One<$t> {
            #[inline(always)]
            fn store(self, out: &mut [$t]) {
                out[0] = self.0;
            }
        }
        impl Int<$t, bool> for One<$t> {
            #[inline(always)]
            fn min(self, other: Self) -> Self {
                Ord::min(self, other)
            }
            #[inline(always)]
            fn max(self, other: Self) -> Self {
                Ord::max(self, other)
            }
        }
    };
    ($t:ty, $trait:ident, $name:ident, $wrapping:ident) => {
        impl $trait for One<$t> {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                Self(self.0.$wrapping(other.0))
            }
        }
        impl $trait<$t> for One<$t> {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: $t) -> Self {
                Self(self.0.$wrapping(other))
            }
        }
    };
    (bits $t:ty, $trait:ident, $name:ident, $op:tt) => {
        impl $trait for One<$t> {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                Self(self.0 $op other.0)
            }
        }
        impl $trait<$t> for One<$t> {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: $t) -> Self {
                Self(self.0 $op other)
            }
        }
    };
}
int!(i32);
int!(u32);

impl Shr for One<i32> {
    type Output = Self;
    #[inline(always)]
    fn shr(self, by: Self) -> Self {
        Self(self.0.wrapping_shr(by.0 as u32))
    }
}

impl Neg for One<i32> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(self.0.wrapping_neg())
    }
}

impl I32s<Scalar> for One<i32> {
    #[inline(always)]
    fn to_f32(self) -> f32 {
        self.0 as f32
    }
    #[inline(always)]
    fn to_u32(self) -> One<u32> {
        One(self.0 as u32)
    }
}

impl U32s<Scalar> for One<u32> {
    #[inline(always)]
    fn to_i32(self) -> One<i32> {
        One(self.0 as i32)
    }
    #[inline(always)]
    fn to_f32_bits(self) -> f32 {
        f32::from_bits(self.0)
    }
}

impl Isa for Scalar {
    const LANES: usize = 1;
    type F32 = f32;
    type F64 = f64;
    type I32 = One<i32>;
    type U32 = One<u32>;
    type Mask = bool;
    type Mask64 = bool;

    #[inline(always)]
    fn f32(self, x: f32) -> f32 {
        x
    }
    #[inline(always)]
    fn f64(self, x: f64) -> f64 {
        x
    }
    #[inline(always)]
    fn i32(self, x: i32) -> One<i32> {
        One(x)
    }
    #[inline(always)]
    fn u32(self, x: u32) -> One<u32> {
        One(x)
    }
    #[inline(always)]
    fn mask(self, x: bool) -> bool {
        x
    }
    #[inline(always)]
    fn mask_from_bits(self, bits: u32) -> bool {
        bits & 1 == 1
    }
    #[inline(always)]
    fn mask64_from_bits(self, bits: u32) -> bool {
        bits & 1 == 1
    }
    #[inline(always)]
    fn iota(self) -> One<i32> {
        One(0)
    }
    #[inline(always)]
    fn load_f32(self, values: &[f32]) -> f32 {
        values[0]
    }
    #[inline(always)]
    fn load_f64(self, values: &[f64]) -> f64 {
        values[0]
    }
    #[inline(always)]
    fn load_i32(self, values: &[i32]) -> One<i32> {
        One(values[0])
    }
    #[inline(always)]
    fn load_u32(self, values: &[u32]) -> One<u32> {
        One(values[0])
    }
    #[inline(always)]
    fn widen(self, x: f32) -> f64 {
        f64::from(x)
    }
    #[inline(always)]
    fn narrow(self, x: f64) -> f32 {
        x as f32
    }
    #[inline(always)]
    fn estimate_mul_add(self, a: f32, b: f32, c: f32) -> f32 {
        a * b + c
    }
    #[inline(always)]
    fn gather(self, words: GatherTable<'_>, index: One<u32>) -> One<u32> {
        One(words.get(index.0))
    }
    #[inline(always)]
    fn gather_pairs(self, words: GatherTable<'_>, index: One<u32>) -> [One<u32>; 2] {
        [self.gather(words, index), self.gather(words, index + 1)]
    }
    #[inline(always)]
    fn gather_quads(self, _: GatherTable<'_>, _: One<u32>) -> Option<[One<u32>; 4]> {
        None
    }
    #[inline(always)]
    fn has_pairs(self) -> bool {
        false
    }
    #[inline(always)]
    fn is_wide(self) -> bool {
        false
    }
    #[inline(always)]
    fn table8(self, table: &[f32; 8], index: One<u32>) -> f32 {
        table[index.0 as usize & 7]
    }
    #[inline(always)]
    fn table16(self, table: &[u32; 16], index: One<u32>) -> One<u32> {
        One(table[index.0 as usize & 15])
    }
    #[inline(always)]
    fn vectorize<R>(self, f: impl FnOnce() -> R) -> R {
        f()
    }
    #[inline(always)]
    fn apply(
        self,
        x: f32,
        x1: fn(f32) -> f32,
        _: fn(Level, [f32; 4]) -> [f32; 4],
        _: fn(Level, [f32; 16]) -> [f32; 16],
    ) -> f32 {
        x1(x)
    }
    #[inline(always)]
    fn apply2(
        self,
        x: f32,
        y: f32,
        x1: fn(f32, f32) -> f32,
        _: fn(Level, [f32; 4], [f32; 4]) -> [f32; 4],
        _: fn(Level, [f32; 16], [f32; 16]) -> [f32; 16],
    ) -> f32 {
        x1(x, y)
    }
    #[inline(always)]
    fn first(self, x: One<i32>) -> i32 {
        x.0
    }
    #[inline(always)]
    fn interleave(self, a: One<u32>, b: One<u32>) -> [One<u32>; 2] {
        [a, b]
    }
    #[inline(always)]
    fn deinterleave(self, a: One<u32>, b: One<u32>) -> [One<u32>; 2] {
        [a, b]
    }
    #[inline(always)]
    fn load_xyz(self, vectors: &[[f32; 3]]) -> [f32; 3] {
        vectors[0]
    }
}

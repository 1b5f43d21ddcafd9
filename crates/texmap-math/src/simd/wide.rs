//! Four and sixteen lanes of a SIMD level.

mod pair;

pub use pair::Pair;

use fearless_simd::{
    Bytes, Simd, SimdBase, SimdFloat, SimdInt, SimdMask, f32x4, f32x16, f64x4, f64x8, i32x4,
    i32x16, mask32x4, mask32x16, mask64x4, mask64x8, u32x4, u32x16,
};

use super::{
    Compare, F32s, Float, GatherTable, I32s, Int, Isa, Level, Mask, Number, Select, U32s, shuffle,
};
use crate::lanes::{self, is_x86};

/// Sixteen lanes: one, two or four registers.
#[derive(Clone, Copy, Debug)]
pub struct X16<S: Simd>(pub S);

/// Four lanes: one register of 128 bits.
#[derive(Clone, Copy, Debug)]
pub struct X4<S: Simd>(pub S);

macro_rules! compare {
    ($lane:ident, $other:ty, $mask:ident) => {
        impl<S: Simd> Compare<$other> for $lane<S> {
            type Mask = $mask<S>;
            #[inline(always)]
            fn simd_eq(self, other: $other) -> $mask<S> {
                SimdBase::simd_eq(self, other)
            }
            #[inline(always)]
            fn simd_lt(self, other: $other) -> $mask<S> {
                SimdBase::simd_lt(self, other)
            }
            #[inline(always)]
            fn simd_le(self, other: $other) -> $mask<S> {
                SimdBase::simd_le(self, other)
            }
            #[inline(always)]
            fn simd_gt(self, other: $other) -> $mask<S> {
                SimdBase::simd_gt(self, other)
            }
            #[inline(always)]
            fn simd_ge(self, other: $other) -> $mask<S> {
                SimdBase::simd_ge(self, other)
            }
        }
    };
}

macro_rules! mask {
    ($mask:ident, $($lane:ident),*) => {
        impl<S: Simd> Mask for $mask<S> {
            #[inline(always)]
            fn any_true(self) -> bool {
                SimdMask::any_true(self)
            }
            #[inline(always)]
            fn all_true(self) -> bool {
                SimdMask::all_true(self)
            }
            #[inline(always)]
            fn to_bitmask(self) -> u32 {
                SimdMask::to_bitmask(self) as u32
            }
        }
        $(impl<S: Simd> Select<$lane<S>> for $mask<S> {
            #[inline(always)]
            fn select(self, yes: $lane<S>, no: $lane<S>) -> $lane<S> {
                fearless_simd::Select::select(self, yes, no)
            }
        })*
    };
}

macro_rules! int {
    ($lane:ident, $t:ty, $mask:ident) => {
        compare!($lane, Self, $mask);
        compare!($lane, $t, $mask);
        impl<S: Simd> Number<$t> for $lane<S> {
            #[inline(always)]
            fn store(self, out: &mut [$t]) {
                SimdBase::store_slice(&self, &mut out[..Self::LEN]);
            }
        }
        impl<S: Simd> Int<$t, $mask<S>> for $lane<S> {
            #[inline(always)]
            fn min(self, other: Self) -> Self {
                SimdBase::min(self, other)
            }
            #[inline(always)]
            fn max(self, other: Self) -> Self {
                SimdBase::max(self, other)
            }
        }
    };
}

macro_rules! float {
    ($lane:ident, $t:ty, $mask:ident) => {
        compare!($lane, Self, $mask);
        compare!($lane, $t, $mask);
        impl<S: Simd> Number<$t> for $lane<S> {
            #[inline(always)]
            fn store(self, out: &mut [$t]) {
                SimdBase::store_slice(&self, &mut out[..Self::LEN]);
            }
        }
        impl<S: Simd> Float<$t, $mask<S>> for $lane<S> {
            #[inline(always)]
            fn abs(self) -> Self {
                SimdBase::abs(self)
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                SimdFloat::sqrt(self)
            }
        }
    };
}

macro_rules! width {
    ($isa:ident, $lanes:literal, $f32:ident, $i32:ident, $u32:ident, $mask:ident) => {
        float!($f32, f32, $mask);
        int!($i32, i32, $mask);
        int!($u32, u32, $mask);
        mask!($mask, $f32, $i32, $u32);

        impl<S: Simd> F32s<$isa<S>> for $f32<S> {
            #[inline(always)]
            fn to_i32(self) -> $i32<S> {
                SimdFloat::to_int::<$i32<S>>(self)
            }
            #[inline(always)]
            fn to_bits(self) -> $u32<S> {
                Bytes::bitcast(self)
            }
            #[inline(always)]
            fn above(self, other: Self) -> Self {
                if let Some(above) = $isa(self.simd).above(self, other) {
                    return above;
                }
                // The maximum of x86 is this selection.
                if is_x86(self.simd) {
                    SimdBase::max(self, other)
                } else {
                    Select::select(Compare::simd_gt(self, other), self, other)
                }
            }
            #[inline(always)]
            fn below(self, other: Self) -> Self {
                if let Some(below) = $isa(self.simd).below(self, other) {
                    return below;
                }
                if is_x86(self.simd) {
                    SimdBase::min(self, other)
                } else {
                    Select::select(Compare::simd_lt(self, other), self, other)
                }
            }
            #[inline(always)]
            fn floor_to_i32(self) -> $i32<S> {
                let s = self.simd;
                #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
                if matches!(s.level(), Level::Avx2(_)) {
                    return SimdFloat::floor(self).to_int::<$i32<S>>();
                }
                if let Some(floor) = $isa(s).floor(self) {
                    return floor;
                }
                let cut = SimdFloat::to_int::<$i32<S>>(self);
                let above = Compare::simd_gt(SimdInt::to_float::<$f32<S>>(cut), self);
                cut - Select::select(above, $i32::splat(s, 1), $i32::splat(s, 0))
            }
            #[inline(always)]
            fn floor(self) -> Self {
                SimdFloat::floor(self)
            }
        }

        impl<S: Simd> I32s<$isa<S>> for $i32<S> {
            #[inline(always)]
            fn to_f32(self) -> $f32<S> {
                SimdInt::to_float::<$f32<S>>(self)
            }
            #[inline(always)]
            fn to_u32(self) -> $u32<S> {
                Bytes::bitcast(self)
            }
        }

        impl<S: Simd> U32s<$isa<S>> for $u32<S> {
            #[inline(always)]
            fn to_i32(self) -> $i32<S> {
                Bytes::bitcast(self)
            }
            #[inline(always)]
            fn to_f32_bits(self) -> $f32<S> {
                Bytes::bitcast(self)
            }
        }
    };
}

/// The part of [`Isa`] that both widths write alike.
macro_rules! common {
    ($lanes:literal, $f32:ident, $i32:ident, $u32:ident, $mask:ident) => {
        const LANES: usize = $lanes;
        type F32 = $f32<S>;
        type I32 = $i32<S>;
        type U32 = $u32<S>;
        type Mask = $mask<S>;

        #[inline(always)]
        fn f32(self, x: f32) -> $f32<S> {
            $f32::splat(self.0, x)
        }
        #[inline(always)]
        fn i32(self, x: i32) -> $i32<S> {
            $i32::splat(self.0, x)
        }
        #[inline(always)]
        fn u32(self, x: u32) -> $u32<S> {
            $u32::splat(self.0, x)
        }
        #[inline(always)]
        fn mask(self, x: bool) -> $mask<S> {
            $mask::splat(self.0, x)
        }
        #[inline(always)]
        fn mask_from_bits(self, bits: u32) -> $mask<S> {
            $mask::from_bitmask(self.0, u64::from(bits) & ((1 << $lanes) - 1))
        }
        #[inline(always)]
        fn load_f32(self, values: &[f32]) -> $f32<S> {
            $f32::from_slice(self.0, &values[..$lanes])
        }
        #[inline(always)]
        fn load_i32(self, values: &[i32]) -> $i32<S> {
            $i32::from_slice(self.0, &values[..$lanes])
        }
        #[inline(always)]
        fn load_u32(self, values: &[u32]) -> $u32<S> {
            $u32::from_slice(self.0, &values[..$lanes])
        }
        #[inline(always)]
        fn is_wide(self) -> bool {
            lanes::is_wide(self.0)
        }
        #[inline(always)]
        fn vectorize<R>(self, f: impl FnOnce() -> R) -> R {
            self.0.vectorize(f)
        }
        #[inline(always)]
        fn first(self, x: $i32<S>) -> i32 {
            x[0]
        }
    };
}

width!(X4, 4, f32x4, i32x4, u32x4, mask32x4);
width!(X16, 16, f32x16, i32x16, u32x16, mask32x16);
float!(f64x4, f64, mask64x4);
mask!(mask64x4, f64x4);
float!(f64x8, f64, mask64x8);
mask!(mask64x8, f64x8);

impl<S: Simd> X4<S> {
    /// By a rounding and a conversion, where the level has both.
    #[inline(always)]
    fn floor(self, x: f32x4<S>) -> Option<i32x4<S>> {
        cfg!(all(target_arch = "wasm32", target_feature = "simd128")).then(
            #[inline(always)]
            || SimdFloat::floor(x).to_int::<i32x4<S>>(),
        )
    }
    /// By one instruction, where there is one.
    #[inline(always)]
    fn above(self, x: f32x4<S>, other: f32x4<S>) -> Option<f32x4<S>> {
        lanes::above_x4(self.0, x, other)
    }
    /// As [`above`](Self::above).
    #[inline(always)]
    fn below(self, x: f32x4<S>, other: f32x4<S>) -> Option<f32x4<S>> {
        lanes::below_x4(self.0, x, other)
    }
}

impl<S: Simd> X16<S> {
    #[inline(always)]
    fn floor(self, x: f32x16<S>) -> Option<i32x16<S>> {
        self.is_wide().then(
            #[inline(always)]
            || lanes::floor_to_i32(self.0, x),
        )
    }
    #[inline(always)]
    fn above(self, _: f32x16<S>, _: f32x16<S>) -> Option<f32x16<S>> {
        None
    }
    #[inline(always)]
    fn below(self, _: f32x16<S>, _: f32x16<S>) -> Option<f32x16<S>> {
        None
    }
}

impl<S: Simd> Isa for X4<S> {
    common!(4, f32x4, i32x4, u32x4, mask32x4);
    type F64 = f64x4<S>;
    type Mask64 = mask64x4<S>;

    #[inline(always)]
    fn f64(self, x: f64) -> f64x4<S> {
        f64x4::splat(self.0, x)
    }
    #[inline(always)]
    fn iota(self) -> i32x4<S> {
        self.load_i32(&[0, 1, 2, 3])
    }
    #[inline(always)]
    fn load_f64(self, values: &[f64]) -> f64x4<S> {
        f64x4::from_slice(self.0, &values[..4])
    }
    #[inline(always)]
    fn mask64_from_bits(self, bits: u32) -> mask64x4<S> {
        mask64x4::from_bitmask(self.0, u64::from(bits & 15))
    }
    #[inline(always)]
    fn estimate_mul_add(self, a: f32x4<S>, b: f32x4<S>, c: f32x4<S>) -> f32x4<S> {
        a * b + c
    }
    #[inline(always)]
    fn widen(self, x: f32x4<S>) -> f64x4<S> {
        let (low, high) = self.0.widen_f32x4(x);
        self.0.combine_f64x2(low, high)
    }
    #[inline(always)]
    fn narrow(self, x: f64x4<S>) -> f32x4<S> {
        let (low, high) = self.0.split_f64x4(x);
        self.0.narrow_f64x2(low, high)
    }
    #[inline(always)]
    fn gather(self, words: GatherTable<'_>, index: u32x4<S>) -> u32x4<S> {
        lanes::gather_x4(self.0, words, index)
    }
    #[inline(always)]
    fn gather_pairs(self, words: GatherTable<'_>, index: u32x4<S>) -> [u32x4<S>; 2] {
        lanes::gather_pairs_x4(self.0, words, index)
    }
    #[inline(always)]
    fn gather_quads(self, words: GatherTable<'_>, index: u32x4<S>) -> Option<[u32x4<S>; 4]> {
        lanes::gather_quads_x4(self.0, words, index)
    }
    #[inline(always)]
    fn has_pairs(self) -> bool {
        lanes::has_pairs(self.0)
    }
    #[inline(always)]
    fn table8(self, table: &[f32; 8], index: u32x4<S>) -> f32x4<S> {
        let i = <[u32; 4]>::from(index).map(
            #[inline(always)]
            |i| table[i as usize & 7],
        );
        self.load_f32(&i)
    }
    #[inline(always)]
    fn table16(self, table: &[u32; 16], index: u32x4<S>) -> u32x4<S> {
        let i = <[u32; 4]>::from(index).map(
            #[inline(always)]
            |i| table[i as usize & 15],
        );
        self.load_u32(&i)
    }
    #[inline(always)]
    fn apply(
        self,
        x: f32x4<S>,
        _: fn(f32) -> f32,
        x4: fn(Level, [f32; 4]) -> [f32; 4],
        _: fn(Level, [f32; 16]) -> [f32; 16],
    ) -> f32x4<S> {
        self.load_f32(&x4(self.0.level(), x.into()))
    }
    #[inline(always)]
    fn apply2(
        self,
        x: f32x4<S>,
        y: f32x4<S>,
        _: fn(f32, f32) -> f32,
        x4: fn(Level, [f32; 4], [f32; 4]) -> [f32; 4],
        _: fn(Level, [f32; 16], [f32; 16]) -> [f32; 16],
    ) -> f32x4<S> {
        self.load_f32(&x4(self.0.level(), x.into(), y.into()))
    }
    #[inline(always)]
    fn interleave(self, a: u32x4<S>, b: u32x4<S>) -> [u32x4<S>; 2] {
        let (low, high) = self.0.interleave_u32x4(a, b);
        [low, high]
    }
    #[inline(always)]
    fn deinterleave(self, a: u32x4<S>, b: u32x4<S>) -> [u32x4<S>; 2] {
        let (even, odd) = self.0.deinterleave_u32x4(a, b);
        [even, odd]
    }
    #[inline(always)]
    fn load_xyz(self, vectors: &[[f32; 3]]) -> [f32x4<S>; 3] {
        shuffle::load_xyz_x4(self.0, vectors.as_flattened())
    }
}

impl<S: Simd> Isa for X16<S> {
    common!(16, f32x16, i32x16, u32x16, mask32x16);
    type F64 = Pair<f64x8<S>>;
    type Mask64 = Pair<mask64x8<S>>;

    #[inline(always)]
    fn f64(self, x: f64) -> Pair<f64x8<S>> {
        let x = f64x8::splat(self.0, x);
        Pair(x, x)
    }
    #[inline(always)]
    fn iota(self) -> i32x16<S> {
        lanes::iota(self.0)
    }
    #[inline(always)]
    fn load_f64(self, values: &[f64]) -> Pair<f64x8<S>> {
        Pair(
            f64x8::from_slice(self.0, &values[..8]),
            f64x8::from_slice(self.0, &values[8..16]),
        )
    }
    #[inline(always)]
    fn mask64_from_bits(self, bits: u32) -> Pair<mask64x8<S>> {
        let half = |bits: u32| mask64x8::from_bitmask(self.0, u64::from(bits & 255));
        Pair(half(bits), half(bits >> 8))
    }
    #[inline(always)]
    fn estimate_mul_add(self, a: f32x16<S>, b: f32x16<S>, c: f32x16<S>) -> f32x16<S> {
        if self.is_wide() {
            self.0.mul_add_f32x16(a, b, c)
        } else {
            a * b + c
        }
    }
    #[inline(always)]
    fn widen(self, x: f32x16<S>) -> Pair<f64x8<S>> {
        let (low, high) = self.0.widen_f32x16(x);
        Pair(low, high)
    }
    #[inline(always)]
    fn narrow(self, x: Pair<f64x8<S>>) -> f32x16<S> {
        self.0.narrow_f64x8(x.0, x.1)
    }
    #[inline(always)]
    fn gather(self, words: GatherTable<'_>, index: u32x16<S>) -> u32x16<S> {
        lanes::gather(self.0, words, index)
    }
    #[inline(always)]
    fn gather_pairs(self, words: GatherTable<'_>, index: u32x16<S>) -> [u32x16<S>; 2] {
        lanes::gather_pairs(self.0, words, index)
    }
    #[inline(always)]
    fn gather_quads(self, words: GatherTable<'_>, index: u32x16<S>) -> Option<[u32x16<S>; 4]> {
        lanes::gather_quads(self.0, words, index)
    }
    #[inline(always)]
    fn gather_pairs_at(self, words: GatherTable<'_>, at: &[u32; 16]) -> [u32x16<S>; 2] {
        match lanes::gather_pairs_at(self.0, words, at) {
            Some(pairs) => pairs,
            None => self.gather_pairs(words, self.load_u32(at)),
        }
    }
    #[inline(always)]
    fn gather_quads_at(self, words: GatherTable<'_>, at: &[u32; 16]) -> Option<[u32x16<S>; 4]> {
        lanes::gather_quads_at(self.0, words, at)
    }
    #[inline(always)]
    fn has_pairs(self) -> bool {
        lanes::has_pairs(self.0)
    }
    #[inline(always)]
    fn table8(self, table: &[f32; 8], index: u32x16<S>) -> f32x16<S> {
        lanes::lookup8(self.0, table, index)
    }
    #[inline(always)]
    fn table16(self, table: &[u32; 16], index: u32x16<S>) -> u32x16<S> {
        lanes::lookup16(self.0, table, index)
    }
    #[inline(always)]
    fn apply(
        self,
        x: f32x16<S>,
        _: fn(f32) -> f32,
        _: fn(Level, [f32; 4]) -> [f32; 4],
        x16: fn(Level, [f32; 16]) -> [f32; 16],
    ) -> f32x16<S> {
        self.load_f32(&x16(self.0.level(), x.into()))
    }
    #[inline(always)]
    fn apply2(
        self,
        x: f32x16<S>,
        y: f32x16<S>,
        _: fn(f32, f32) -> f32,
        _: fn(Level, [f32; 4], [f32; 4]) -> [f32; 4],
        x16: fn(Level, [f32; 16], [f32; 16]) -> [f32; 16],
    ) -> f32x16<S> {
        self.load_f32(&x16(self.0.level(), x.into(), y.into()))
    }
    #[inline(always)]
    fn interleave(self, a: u32x16<S>, b: u32x16<S>) -> [u32x16<S>; 2] {
        let (low, high) = self.0.interleave_u32x16(a, b);
        [low, high]
    }
    #[inline(always)]
    fn deinterleave(self, a: u32x16<S>, b: u32x16<S>) -> [u32x16<S>; 2] {
        let (even, odd) = self.0.deinterleave_u32x16(a, b);
        [even, odd]
    }
    #[inline(always)]
    fn load_xyz(self, vectors: &[[f32; 3]]) -> [f32x16<S>; 3] {
        shuffle::load_xyz_x16(self.0, vectors.as_flattened())
    }
}

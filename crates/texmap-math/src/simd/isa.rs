//! The traits of a kernel's numbers: floats, integers and masks of one, four or sixteen lanes.
//!
//! Constants stand on the right of an operator or comparison as plain numbers (`x * 2.0`, `x.simd_lt(0.5)`); on the left they are
//! splatted (`i.f32(1.0) - x`), as Rust has no way to promise `f32 - x` for every `x`.

use core::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Neg, Not, Shl, Shr, Sub};

use super::GatherTable;

/// Comparison of each lane; false where one side is NaN.
pub trait Compare<Rhs> {
    /// One truth value for each lane.
    type Mask;
    /// `self == other`.
    fn simd_eq(self, other: Rhs) -> Self::Mask;
    /// `self < other`.
    fn simd_lt(self, other: Rhs) -> Self::Mask;
    /// `self <= other`.
    fn simd_le(self, other: Rhs) -> Self::Mask;
    /// `self > other`.
    fn simd_gt(self, other: Rhs) -> Self::Mask;
    /// `self >= other`.
    fn simd_ge(self, other: Rhs) -> Self::Mask;
}

/// Selection by a mask.
pub trait Select<T> {
    /// `yes` in the lanes that are true, `no` in the others.
    fn select(self, yes: T, no: T) -> T;
}

/// One truth value for each lane.
pub trait Mask:
    Copy
    + core::fmt::Debug
    + BitAnd<Output = Self>
    + BitOr<Output = Self>
    + BitXor<Output = Self>
    + Not<Output = Self>
{
    /// True if any lane is.
    fn any_true(self) -> bool;
    /// True if every lane is.
    fn all_true(self) -> bool;
    /// Bit `k` is lane `k`; the bits above are 0.
    fn to_bitmask(self) -> u32;
}

/// Arithmetic that floats and integers share, with lanes or a constant on the right.
pub trait Number<C>:
    Copy
    + core::fmt::Debug
    + Add<Output = Self>
    + Add<C, Output = Self>
    + Sub<Output = Self>
    + Sub<C, Output = Self>
    + Mul<Output = Self>
    + Mul<C, Output = Self>
{
    /// Stores the lanes at the front of `out`.
    ///
    /// # Panics
    /// If `out` has fewer elements than there are lanes.
    fn store(self, out: &mut [C]);
}

/// Lanes of f32 or f64 (`C`).
pub trait Float<C, M: Mask>:
    Number<C>
    + Div<Output = Self>
    + Div<C, Output = Self>
    + Neg<Output = Self>
    + Compare<Self, Mask = M>
    + Compare<C, Mask = M>
{
    /// The magnitude.
    fn abs(self) -> Self;
    /// The square root, rounded exactly; NaN below zero.
    fn sqrt(self) -> Self;
}

/// Lanes of f32.
pub trait F32s<I: Isa>: Float<f32, I::Mask> {
    /// Truncated, for values within i32.
    fn to_i32(self) -> I::I32;
    /// The bits.
    fn to_bits(self) -> I::U32;
    /// `self` where it is above `other`, else `other`, zeros and NaN too: by comparison and selection.
    fn above(self, other: Self) -> Self;
    /// `self` where it is below `other`, else `other`: as [`above`](Self::above).
    fn below(self, other: Self) -> Self;
    /// `floor(self)`, for `|self| < 2^31`.
    fn floor_to_i32(self) -> I::I32;

    /// Within `[low, high]` by comparison and selection; NaN gives `low`.
    #[inline(always)]
    fn clamp(self, low: Self, high: Self) -> Self {
        self.above(low).below(high)
    }

    /// The nearest whole number at most `self`.
    fn floor(self) -> Self;
}

/// Lanes of i32 or u32 (`C`); arithmetic wraps.
pub trait Int<C, M: Mask>:
    Number<C>
    + BitAnd<Output = Self>
    + BitAnd<C, Output = Self>
    + BitOr<Output = Self>
    + BitOr<C, Output = Self>
    + BitXor<Output = Self>
    + BitXor<C, Output = Self>
    + Shl<u32, Output = Self>
    + Shr<u32, Output = Self>
    + Compare<Self, Mask = M>
    + Compare<C, Mask = M>
{
    /// The lesser of each pair.
    fn min(self, other: Self) -> Self;
    /// The greater of each pair.
    fn max(self, other: Self) -> Self;
}

/// Lanes of i32.
pub trait I32s<I: Isa>: Int<i32, I::Mask> + Neg<Output = Self> + Shr<Output = Self> {
    /// To the nearest f32, ties to even.
    fn to_f32(self) -> I::F32;
    /// The same bits.
    fn to_u32(self) -> I::U32;
}

/// Lanes of u32.
pub trait U32s<I: Isa>: Int<u32, I::Mask> {
    /// The same bits.
    fn to_i32(self) -> I::I32;
    /// The float of these bits.
    fn to_f32_bits(self) -> I::F32;
}

/// Vector instructions and how many lanes a kernel takes through them: [`Scalar`](super::Scalar), [`X4`](super::X4) or
/// [`X16`](super::X16). Every operation gives the same bits in a lane for each of them.
pub trait Isa: Copy + core::fmt::Debug + Send + Sync + 'static {
    /// Lanes.
    const LANES: usize;
    /// f32 lanes.
    type F32: F32s<Self>;
    /// f64 lanes, as many as of f32.
    type F64: Float<f64, Self::Mask64>;
    /// i32 lanes.
    type I32: I32s<Self>;
    /// u32 lanes.
    type U32: U32s<Self>;
    /// Truth values of 32-bit lanes.
    type Mask: Mask + Select<Self::F32> + Select<Self::I32> + Select<Self::U32>;
    /// Truth values of f64 lanes.
    type Mask64: Mask + Select<Self::F64>;

    /// `x` in every lane.
    fn f32(self, x: f32) -> Self::F32;
    /// `x` in every lane.
    fn f64(self, x: f64) -> Self::F64;
    /// `x` in every lane.
    fn i32(self, x: i32) -> Self::I32;
    /// `x` in every lane.
    fn u32(self, x: u32) -> Self::U32;
    /// `x` in every lane.
    fn mask(self, x: bool) -> Self::Mask;
    /// Lane `k` is bit `k`.
    fn mask_from_bits(self, bits: u32) -> Self::Mask;
    /// Lane `k` is bit `k`.
    fn mask64_from_bits(self, bits: u32) -> Self::Mask64;
    /// 0, 1, 2 ...
    fn iota(self) -> Self::I32;
    /// The first [`LANES`](Self::LANES) values.
    ///
    /// # Panics
    /// If there are fewer; likewise for the other loads.
    fn load_f32(self, values: &[f32]) -> Self::F32;
    /// See [`load_f32`](Self::load_f32).
    fn load_f64(self, values: &[f64]) -> Self::F64;
    /// See [`load_f32`](Self::load_f32).
    fn load_i32(self, values: &[i32]) -> Self::I32;
    /// See [`load_f32`](Self::load_f32).
    fn load_u32(self, values: &[u32]) -> Self::U32;
    /// Exact.
    fn widen(self, x: Self::F32) -> Self::F64;
    /// Rounded to nearest.
    fn narrow(self, x: Self::F64) -> Self::F32;

    /// `a b + c`, rounded once or twice: whichever the level does faster. For estimates alone, whose users give the same result
    /// for both.
    fn estimate_mul_add(self, a: Self::F32, b: Self::F32, c: Self::F32) -> Self::F32;

    /// The words at `index`; an index beyond the end reads the last word.
    fn gather(self, words: GatherTable<'_>, index: Self::U32) -> Self::U32;
    /// The words at `index` and those behind them. If one of the two lies beyond the end, both hold no meaning.
    fn gather_pairs(self, words: GatherTable<'_>, index: Self::U32) -> [Self::U32; 2];
    /// The words at `index` and the three behind each. Only if that costs less than [`gather`](Self::gather)s and none lies
    /// beyond the end.
    fn gather_quads(self, words: GatherTable<'_>, index: Self::U32) -> Option<[Self::U32; 4]>;
    /// [`gather_pairs`](Self::gather_pairs) of indices in memory, the first [`LANES`](Self::LANES) of `at`. The processor loads through
    /// them, which is faster if they were stored a while before.
    #[inline(always)]
    fn gather_pairs_at(self, words: GatherTable<'_>, at: &[u32; 16]) -> [Self::U32; 2] {
        self.gather_pairs(words, self.load_u32(at))
    }
    /// [`gather_quads`](Self::gather_quads) of indices in memory, as [`gather_pairs_at`](Self::gather_pairs_at).
    #[inline(always)]
    fn gather_quads_at(self, words: GatherTable<'_>, at: &[u32; 16]) -> Option<[Self::U32; 4]> {
        self.gather_quads(words, self.load_u32(at))
    }
    /// True if [`gather_pairs`](Self::gather_pairs) costs less than two gathers.
    fn has_pairs(self) -> bool;
    /// True if a vector has 256 bits or more: small tables and pairs of words are then cheap.
    fn is_wide(self) -> bool;
    /// `table[index]` for indices below 8.
    fn table8(self, table: &[f32; 8], index: Self::U32) -> Self::F32;
    /// `table[index % 16]`.
    fn table16(self, table: &[u32; 16], index: Self::U32) -> Self::U32;

    /// Runs `f` with these instructions enabled. `f` must be `#[inline(always)]`.
    fn vectorize<R>(self, f: impl FnOnce() -> R) -> R;
    /// `f` of `x` by the form of this width. The formula is compiled where `x1`, `x4` and `x16` stand, not in each caller.
    fn apply(
        self,
        x: Self::F32,
        x1: fn(f32) -> f32,
        x4: fn(super::Level, [f32; 4]) -> [f32; 4],
        x16: fn(super::Level, [f32; 16]) -> [f32; 16],
    ) -> Self::F32;
    /// As [`apply`](Self::apply), of two.
    fn apply2(
        self,
        x: Self::F32,
        y: Self::F32,
        x1: fn(f32, f32) -> f32,
        x4: fn(super::Level, [f32; 4], [f32; 4]) -> [f32; 4],
        x16: fn(super::Level, [f32; 16], [f32; 16]) -> [f32; 16],
    ) -> Self::F32;

    /// Calls `f` for the lanes of `x` one after the other; for what has no vector form. `f` should be cold or out of line.
    #[inline(always)]
    fn each(self, x: Self::F32, mut f: impl FnMut(usize, f32) -> f32) -> Self::F32 {
        let mut lanes = [0.0; 16];
        x.store(&mut lanes);
        for (k, lane) in lanes[..Self::LANES].iter_mut().enumerate() {
            *lane = f(k, *lane);
        }
        self.load_f32(&lanes)
    }

    /// The first lane.
    fn first(self, x: Self::I32) -> i32;

    /// The words at `index` and the two behind each. If one of them lies beyond the end, it is the last word.
    #[inline(always)]
    fn gather_triples(self, words: GatherTable<'_>, index: Self::U32) -> [Self::U32; 3] {
        if let Some([a, b, c, _]) = self.gather_quads(words, index) {
            return [a, b, c];
        }
        [
            self.gather(words, index),
            self.gather(words, index + 1),
            self.gather(words, index + 2),
        ]
    }
    /// The lanes of `a` and `b` by turns: a0, b0, a1, b1 ...
    fn interleave(self, a: Self::U32, b: Self::U32) -> [Self::U32; 2];
    /// The even and the odd lanes of `a` and, behind them, of `b`: [`interleave`](Self::interleave) undone.
    fn deinterleave(self, a: Self::U32, b: Self::U32) -> [Self::U32; 2];
    /// The x, the y and the z of [`LANES`](Self::LANES) vectors.
    fn load_xyz(self, vectors: &[[f32; 3]]) -> [Self::F32; 3];
}

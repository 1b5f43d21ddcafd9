//! Three-component f32 arithmetic in one fixed order of operations, for numbers and lanes.

use texmap_math::glam::DVec3;
use texmap_math::simd::{Isa, prelude::*};

use crate::lanes::Vector;

/// `a + b`.
#[inline(always)]
pub(crate) fn add<T: Number<f32>>(a: [T; 3], b: [T; 3]) -> [T; 3] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// `a - b`.
#[inline(always)]
pub(crate) fn sub<T: Number<f32>>(a: [T; 3], b: [T; 3]) -> [T; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// `a k`.
#[inline(always)]
pub(crate) fn scale<T: Number<f32>>(a: [T; 3], k: T) -> [T; 3] {
    [a[0] * k, a[1] * k, a[2] * k]
}

/// Scalar product.
#[inline(always)]
pub fn dot<T: Number<f32>>(a: [T; 3], b: [T; 3]) -> T {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Vector product.
#[inline(always)]
pub fn cross<T: Number<f32>>(a: [T; 3], b: [T; 3]) -> [T; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

/// A point under an affine map, by its rows.
#[inline(always)]
pub fn affine<T: Number<f32>>(rows: &[[f32; 4]; 3], p: [T; 3]) -> [T; 3] {
    let mut out = p;
    for (out, [a, b, c, d]) in out.iter_mut().zip(rows) {
        *out = p[0] * *a + p[1] * *b + p[2] * *c + *d;
    }
    out
}

/// `yes` in the lanes that are true, `no` in the others.
#[inline(always)]
pub(crate) fn select<T: Copy>(mask: impl Select<T> + Copy, yes: [T; 3], no: [T; 3]) -> [T; 3] {
    [
        mask.select(yes[0], no[0]),
        mask.select(yes[1], no[1]),
        mask.select(yes[2], no[2]),
    ]
}

/// One vector in all lanes.
#[inline(always)]
pub fn splat<I: Isa>(i: I, a: [f32; 3]) -> Vector<I> {
    [i.f32(a[0]), i.f32(a[1]), i.f32(a[2])]
}

/// The vectors from `first` on in lanes; those beyond the end are the last.
#[inline(always)]
pub(crate) fn load<I: Isa, const N: usize>(i: I, values: &[[f32; N]], first: usize) -> [I::F32; N] {
    let mut columns = [[0.0; 16]; N];
    for lane in 0..I::LANES {
        let value = values[(first + lane).min(values.len() - 1)];
        for (column, c) in columns.iter_mut().zip(value) {
            column[lane] = c;
        }
    }
    let mut out = [i.f32(0.0); N];
    for (out, column) in out.iter_mut().zip(&columns) {
        *out = i.load_f32(column);
    }
    out
}

/// The lanes as columns.
#[inline(always)]
pub(crate) fn columns<I: Isa, const N: usize>(_: I, v: [I::F32; N]) -> [[f32; 16]; N] {
    let mut columns = [[0.0; 16]; N];
    for (column, c) in columns.iter_mut().zip(v) {
        c.store(column);
    }
    columns
}

/// A vector in f32.
pub(crate) fn narrow(a: DVec3) -> [f32; 3] {
    a.to_array().map(|c| c as f32)
}

/// True where all components are zero.
#[inline(always)]
pub(crate) fn is_zero<I: Isa>(_: I, a: Vector<I>) -> I::Mask {
    a[0].simd_eq(0.0) & a[1].simd_eq(0.0) & a[2].simd_eq(0.0)
}

/// Vectors with +Z instead of those without a direction, and the lanes of the others. Zero and not finite ones have no direction.
#[inline(always)]
pub(crate) fn usable<I: Isa>(i: I, [x, y, z]: Vector<I>) -> (Vector<I>, I::Mask) {
    let (ax, ay, az) = (x.abs(), y.abs(), z.abs());
    let finite = ax.simd_le(f32::MAX) & ay.simd_le(f32::MAX) & az.simd_le(f32::MAX);
    let usable = finite & (ax.simd_gt(0.0) | ay.simd_gt(0.0) | az.simd_gt(0.0));
    (select(usable, [x, y, z], splat(i, [0.0, 0.0, 1.0])), usable)
}

/// Squares of lengths between which nothing under- or overflows.
const SQUARES: [f32; 2] = [1e-20, 1e30];

/// Unit vectors; zero for a vector without a direction (zero or not finite). Off by 2 units in the last place.
#[inline(always)]
pub fn unit<I: Isa>(i: I, a: Vector<I>) -> Vector<I> {
    let square = dot(a, a);
    let usual = square.simd_gt(SQUARES[0]) & square.simd_lt(SQUARES[1]);
    let out = scale(a, i.f32(1.0) / square.sqrt());
    if usual.all_true() {
        out
    } else {
        select(usual, out, unit_of_any(i, a))
    }
}

/// [`unit`] of vectors of any length, divided by their largest component first. Out of line: they are few.
#[inline(never)]
fn unit_of_any<I: Isa>(i: I, a: Vector<I>) -> Vector<I> {
    i.vectorize(
        #[inline(always)]
        || {
            let largest = a[0].abs().above(a[1].abs()).above(a[2].abs());
            let a = [a[0] / largest, a[1] / largest, a[2] / largest];
            let length = dot(a, a).sqrt();
            // A NaN component may be lost in `largest` and shows in the length.
            let usable =
                largest.simd_gt(0.0) & largest.simd_lt(f32::INFINITY) & length.simd_gt(0.0);
            let unit = [a[0] / length, a[1] / length, a[2] / length];
            select(usable, unit, splat(i, [0.0; 3]))
        },
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use texmap_math::simd::Scalar;

    #[test]
    fn units_survive_every_magnitude() {
        for k in [1e-38, 1e-20, 1.0, 1e20, 1e38] {
            let n = unit(Scalar, [3.0 * k, 0.0, -3.0 * k]);
            assert!(
                (n[0] - 0.5f32.sqrt()).abs() < 1e-6 && n[0] == -n[2],
                "{k}: {n:?}"
            );
        }
        assert_eq!(unit(Scalar, [0.0, -0.0, 0.0]), [0.0; 3]);
        assert_eq!(unit(Scalar, [f32::NAN, 1.0, 0.0]), [0.0; 3]);
        assert_eq!(unit(Scalar, [f32::INFINITY, 1.0, 0.0]), [0.0; 3]);
    }

    /// Every width gives the bits of one vector, usual lengths beside others.
    #[test]
    fn widths_agree() {
        let all: [[f32; 16]; 3] = [3, 5, 7].map(|k| {
            core::array::from_fn(|lane| match (lane * k) % 9 {
                0 => 0.0,
                1 => 1e-30,
                2 => 3e25,
                3 if lane > 12 => f32::NAN,
                4 if lane > 12 => f32::INFINITY,
                n => n as f32 - 5.5,
            })
        });
        every_width!(i => check(i, &all));
        fn check<I: Isa>(i: I, all: &[[f32; 16]; 3]) {
            for at in (0..16).step_by(I::LANES) {
                let out = columns(i, unit(i, all.each_ref().map(|c| i.load_f32(&c[at..]))));
                for lane in 0..I::LANES {
                    let one = unit(Scalar, all.map(|c| c[at + lane]));
                    assert_eq!(out.map(|c| c[lane].to_bits()), one.map(f32::to_bits));
                }
            }
        }
    }
}

//! Three-component f32 arithmetic in one fixed order of operations.

use texmap_math::fearless_simd::{Simd, f32x16, mask32x16, prelude::*};
use texmap_math::float::sqrt_f32;
use texmap_math::glam::DVec3;
use texmap_math::lanes::LANES;

use crate::lanes::V3;

pub(crate) fn sub(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub(crate) fn scale(a: [f32; 3], k: f32) -> [f32; 3] {
    [a[0] * k, a[1] * k, a[2] * k]
}

pub(crate) fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// A vector in f32.
pub(crate) fn narrow(a: DVec3) -> [f32; 3] {
    a.to_array().map(|c| c as f32)
}

/// Whether a vector has a direction: not zero, and finite.
pub(crate) fn is_usable(a: [f32; 3]) -> bool {
    a.iter().all(|c| c.is_finite()) && a != [0.0; 3]
}

/// Squares of lengths between which nothing under- or overflows.
const SQUARES: [f32; 2] = [1e-20, 1e30];

/// Unit vector; zero for a vector without a direction (zero or not finite). Off by 2 units in the last place.
#[must_use]
pub fn unit(a: [f32; 3]) -> [f32; 3] {
    let square = dot(a, a);
    if square > SQUARES[0] && square < SQUARES[1] {
        scale(a, 1.0 / sqrt_f32(square))
    } else {
        unit_of_any(a)
    }
}

/// Divided by the largest component first.
fn unit_of_any(a: [f32; 3]) -> [f32; 3] {
    let largest = a[0].abs().max(a[1].abs()).max(a[2].abs());
    if !(largest > 0.0 && largest < f32::INFINITY) {
        return [0.0; 3];
    }
    let a = [a[0] / largest, a[1] / largest, a[2] / largest];
    let length = sqrt_f32(dot(a, a));
    // A NaN component passes `max` and shows here.
    if length.is_nan() || length <= 0.0 {
        return [0.0; 3];
    }
    [a[0] / length, a[1] / length, a[2] / length]
}

/// [`unit()`] for sixteen.
#[inline(always)]
pub fn unit_lanes<S: Simd>(s: S, a: V3<S>) -> V3<S> {
    let square = dot_lanes(a, a);
    let [low, high] = SQUARES;
    let usual = square.simd_gt(low) & square.simd_lt(high);
    let out = scale_lanes(a, f32x16::splat(s, 1.0) / square.sqrt());
    if usual.all_true() {
        out
    } else {
        unusual(s, a, out, usual.to_bitmask() as u16)
    }
}

/// The lanes of [`unit_lanes`] that are not in `usual`, one by one.
#[inline(always)]
fn unusual<S: Simd>(s: S, a: V3<S>, unit: V3<S>, usual: u16) -> V3<S> {
    let (mut from, mut to) = ([[0.0; LANES]; 3], [[0.0; LANES]; 3]);
    for i in 0..3 {
        a[i].store_slice(&mut from[i]);
        unit[i].store_slice(&mut to[i]);
    }
    one_by_one(&from, &mut to, usual);
    let mut out = unit;
    for i in 0..3 {
        out[i] = f32x16::from_slice(s, &to[i]);
    }
    out
}

#[inline(never)]
fn one_by_one(from: &[[f32; LANES]; 3], to: &mut [[f32; LANES]; 3], usual: u16) {
    for lane in (0..LANES).filter(|lane| usual >> lane & 1 == 0) {
        let one = unit_of_any(from.map(|column| column[lane]));
        for (column, value) in to.iter_mut().zip(one) {
            column[lane] = value;
        }
    }
}

/// +Z in place of directions that are none, and the lanes of those that are: [`is_usable`] for sixteen.
#[inline(always)]
pub(crate) fn usable_lanes<S: Simd>(s: S, [x, y, z]: V3<S>) -> (V3<S>, mask32x16<S>) {
    let (zero, one) = (f32x16::splat(s, 0.0), f32x16::splat(s, 1.0));
    let most = f32x16::splat(s, f32::MAX);
    let (ax, ay, az) = (x.abs(), y.abs(), z.abs());
    let finite = ax.simd_le(most) & ay.simd_le(most) & az.simd_le(most);
    let usable = finite & (ax.simd_gt(zero) | ay.simd_gt(zero) | az.simd_gt(zero));
    let d = [
        usable.select(x, zero),
        usable.select(y, zero),
        usable.select(z, one),
    ];
    (d, usable)
}

/// Scalar products.
#[inline(always)]
pub fn dot_lanes<S: Simd>(a: V3<S>, b: V3<S>) -> f32x16<S> {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Points under an affine map, by its rows.
#[inline(always)]
pub fn affine_lanes<S: Simd>(rows: &[[f32; 4]; 3], p: V3<S>) -> V3<S> {
    let mut out = p;
    for (out, [a, b, c, d]) in out.iter_mut().zip(rows) {
        *out = p[0] * *a + p[1] * *b + p[2] * *c + *d;
    }
    out
}

/// Vector products.
#[inline(always)]
pub fn cross_lanes<S: Simd>(a: V3<S>, b: V3<S>) -> V3<S> {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

#[inline(always)]
pub(crate) fn scale_lanes<S: Simd>(a: V3<S>, k: f32x16<S>) -> V3<S> {
    [a[0] * k, a[1] * k, a[2] * k]
}

#[inline(always)]
pub(crate) fn sub_lanes<S: Simd>(a: V3<S>, b: V3<S>) -> V3<S> {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// One vector in all lanes.
#[inline(always)]
pub fn spread<S: Simd>(s: S, a: [f32; 3]) -> V3<S> {
    [
        f32x16::splat(s, a[0]),
        f32x16::splat(s, a[1]),
        f32x16::splat(s, a[2]),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_survive_every_magnitude() {
        for k in [1e-38, 1e-20, 1.0, 1e20, 1e38] {
            let n = unit([3.0 * k, 0.0, -3.0 * k]);
            assert!(
                (n[0] - 0.5f32.sqrt()).abs() < 1e-6 && n[0] == -n[2],
                "{k}: {n:?}"
            );
        }
        assert_eq!(unit([0.0, -0.0, 0.0]), [0.0; 3]);
        assert_eq!(unit([f32::NAN, 1.0, 0.0]), [0.0; 3]);
        assert_eq!(unit([f32::INFINITY, 1.0, 0.0]), [0.0; 3]);
    }
}

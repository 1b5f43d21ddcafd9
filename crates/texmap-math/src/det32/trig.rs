//! Sine and cosine.

use fearless_simd::prelude::*;
use fearless_simd::{Level, f32x4, f32x16};

use super::wide::{Wide, narrow, narrow_x4, on_level, polynomial, round};
use crate::det;
use crate::simd::{Isa, X4};

/// pi/2 to 33 bits and the rest: their product with `|n| < 2^20` is exact, or far below the result.
const HALF_PI: (f64, f64) = (1.570_796_326_734_125_6, 6.077_100_506_506_192e-11);

/// Beyond this angle [`crate::det`] reduces.
const NEAR: f32 = 1_600_000.0;

/// Sine; NaN for infinities and NaN.
#[inline]
#[must_use]
pub fn sin(x: f32) -> f32 {
    sin_cos(x).0
}

/// Cosine; NaN for infinities and NaN.
#[inline]
#[must_use]
pub fn cos(x: f32) -> f32 {
    sin_cos(x).1
}

/// Sine and cosine.
#[inline]
#[must_use]
pub fn sin_cos(x: f32) -> (f32, f32) {
    if x.abs() <= NEAR {
        let (s, c) = near(f64::from(x));
        return (s as f32, c as f32);
    }
    far(x)
}

/// Tangent; NaN for infinities and NaN.
#[inline]
#[must_use]
pub fn tan(x: f32) -> f32 {
    let (s, c) = if x.abs() <= NEAR {
        near(f64::from(x))
    } else {
        det::sin_cos(f64::from(x))
    };
    round(s / c)
}

/// Sine of lanes.
#[inline(always)]
pub fn sin_lanes<I: Isa>(i: I, x: I::F32) -> I::F32 {
    i.apply(
        x,
        sin,
        |level, x| four(level, x).0,
        |level, x| sixteen(level, x).0,
    )
}

/// Cosine of lanes.
#[inline(always)]
pub fn cos_lanes<I: Isa>(i: I, x: I::F32) -> I::F32 {
    i.apply(
        x,
        cos,
        |level, x| four(level, x).1,
        |level, x| sixteen(level, x).1,
    )
}

fn four(level: Level, x: [f32; 4]) -> ([f32; 4], [f32; 4]) {
    if !x.iter().all(|x| x.abs() <= NEAR) {
        return one_by_one(x);
    }
    on_level!(
        level,
        t => {
            let (sine, cosine) = near(X4(t).widen(f32x4::from_slice(t, &x)));
            (narrow_x4(sine).into(), narrow_x4(cosine).into())
        },
        one_by_one(x)
    )
}

fn sixteen(level: Level, x: [f32; 16]) -> ([f32; 16], [f32; 16]) {
    if !x.iter().all(|x| x.abs() <= NEAR) {
        return one_by_one(x);
    }
    on_level!(
        level,
        t => {
            let (low, high) = t.widen_f32x16(f32x16::from_slice(t, &x));
            let ((sl, cl), (sh, ch)) = (near(low), near(high));
            (narrow(sl, sh).into(), narrow(cl, ch).into())
        },
        one_by_one(x)
    )
}

fn one_by_one<const N: usize>(x: [f32; N]) -> ([f32; N], [f32; N]) {
    let both = x.map(sin_cos);
    (both.map(|b| b.0), both.map(|b| b.1))
}

#[cold]
fn far(x: f32) -> (f32, f32) {
    if !x.is_finite() {
        return (f32::NAN, f32::NAN);
    }
    let (s, c) = det::sin_cos(f64::from(x));
    (s as f32, c as f32)
}

/// Both for `|x| <= NEAR`: reduction to |r| <= pi/4, Taylor to r^11 and r^12 (remainders below 2^-37).
#[inline(always)]
fn near<W: Wide>(x: W) -> (W, W) {
    let n = (x * core::f64::consts::FRAC_2_PI).nearest();
    let r = (x - n * HALF_PI.0) - n * HALF_PI.1;
    let z = r * r;
    let sine = polynomial!(z; -1.0 / 6.0, 1.0 / 120.0, -1.0 / 5_040.0, 1.0 / 362_880.0, -1.0 / 39_916_800.0);
    let sine = r + r * z * sine;
    let cosine = polynomial!(z; 1.0, -0.5, 1.0 / 24.0, -1.0 / 720.0, 1.0 / 40_320.0, -1.0 / 3_628_800.0, 1.0 / 479_001_600.0);
    let (odd, second) = (n.has_bit(0), n.has_bit(1));
    let (odd_or_second, both) = (odd | second, odd & second);
    let s = W::select(odd, cosine, sine).negate_where(second);
    let c = W::select(odd, sine, cosine).negate_where(odd_or_second & !both);
    // -0.0 - n * 0 is 0.0: a zero keeps its sign.
    (W::select(x.eq(x.constant(0.0)), x, s), c)
}

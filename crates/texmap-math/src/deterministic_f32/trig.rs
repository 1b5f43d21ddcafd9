//! Sine and cosine.

use fearless_simd::Level;

use super::wide::{Vectors, Wide, each, polynomial, round};
use crate::simd::Isa;
use crate::{deterministic_f64, dispatch_simd};

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
        deterministic_f64::sin_cos(f64::from(x))
    };
    round(s / c)
}

/// Sine of lanes.
#[inline(always)]
pub fn sin_lanes<I: Isa>(i: I, x: I::F32) -> I::F32 {
    i.apply(x, sin, four::<false>, sixteen::<false>)
}

/// Cosine of lanes.
#[inline(always)]
pub fn cos_lanes<I: Isa>(i: I, x: I::F32) -> I::F32 {
    i.apply(x, cos, four::<true>, sixteen::<true>)
}

fn four<const COSINE: bool>(level: Level, x: [f32; 4]) -> [f32; 4] {
    if !x.iter().all(|x| x.abs() <= NEAR) {
        return x.map(if COSINE { cos } else { sin });
    }
    dispatch_simd!(@widths X4 X4, level, i => near_lanes::<_, COSINE, _>(i, x))
}

fn sixteen<const COSINE: bool>(level: Level, x: [f32; 16]) -> [f32; 16] {
    if !x.iter().all(|x| x.abs() <= NEAR) {
        return x.map(if COSINE { cos } else { sin });
    }
    dispatch_simd!(level, wide i => near_lanes::<_, COSINE, _>(i, x))
}

#[inline(always)]
fn near_lanes<I: Isa<F64: Vectors>, const COSINE: bool, const N: usize>(
    i: I,
    x: [f32; N],
) -> [f32; N] {
    each(
        i,
        x,
        #[inline(always)]
        |x| {
            let (sine, cosine) = near(x);
            if COSINE { cosine } else { sine }
        },
    )
}

#[cold]
fn far(x: f32) -> (f32, f32) {
    if !x.is_finite() {
        return (f32::NAN, f32::NAN);
    }
    let (s, c) = deterministic_f64::sin_cos(f64::from(x));
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

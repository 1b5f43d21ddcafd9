//! Sine, cosine and tangent.

use super::{Double, reduce::reduce};

/// Sine. Error below 0.8 ulp for every finite `x`; NaN for infinities and NaN; `sin(-0.0)` is -0.0.
#[must_use]
pub const fn sin(x: f64) -> f64 {
    sin_cos(x).0
}

/// Cosine. Error below 0.8 ulp for every finite `x`; NaN for infinities and NaN.
#[must_use]
pub const fn cos(x: f64) -> f64 {
    sin_cos(x).1
}

/// Sine and cosine from one reduction.
#[must_use]
pub const fn sin_cos(x: f64) -> (f64, f64) {
    if !x.is_finite() {
        return (f64::NAN, f64::NAN);
    }
    // The sum of the series would lose the sign of -0.0.
    if x == 0.0 {
        return (x, 1.0);
    }
    let (quadrant, rest) = reduce(x);
    let (s, c) = (sin_rest(rest), cos_rest(rest));
    match quadrant {
        0 => (s, c),
        1 => (c, -s),
        2 => (-s, -c),
        _ => (-c, s),
    }
}

/// Tangent, sine over cosine. Error below 2.5 ulp; NaN for infinities and NaN.
#[must_use]
pub const fn tan(x: f64) -> f64 {
    let (s, c) = sin_cos(x);
    s / c
}

/// Sine of `|r| <= pi/4`: Taylor to r^17, remainder below 1e-19.
const fn sin_rest(r: Double) -> f64 {
    let x = r.hi;
    let z = x * x;
    let tail = 1.0 / 355_687_428_096_000.0;
    let tail = -1.0 / 1_307_674_368_000.0 + z * tail;
    let tail = 1.0 / 6_227_020_800.0 + z * tail;
    let tail = -1.0 / 39_916_800.0 + z * tail;
    let tail = 1.0 / 362_880.0 + z * tail;
    let tail = -1.0 / 5_040.0 + z * tail;
    let tail = 1.0 / 120.0 + z * tail;
    let tail = -1.0 / 6.0 + z * tail;
    // sin(hi + lo) = sin(hi) + lo cos(hi); the small terms are added first.
    x + (x * z * tail + r.lo * (1.0 - 0.5 * z))
}

/// Cosine of `|r| <= pi/4`: Taylor to r^16, remainder below 3e-18.
const fn cos_rest(r: Double) -> f64 {
    let x = r.hi;
    let z = x * x;
    let tail = 1.0 / 20_922_789_888_000.0;
    let tail = -1.0 / 87_178_291_200.0 + z * tail;
    let tail = 1.0 / 479_001_600.0 + z * tail;
    let tail = -1.0 / 3_628_800.0 + z * tail;
    let tail = 1.0 / 40_320.0 + z * tail;
    let tail = -1.0 / 720.0 + z * tail;
    let tail = 1.0 / 24.0 + z * tail;
    // 1 - z/2 with what it rounds away.
    let half = 0.5 * z;
    let first = 1.0 - half;
    first + (((1.0 - first) - half) + (z * z * tail - x * r.lo))
}

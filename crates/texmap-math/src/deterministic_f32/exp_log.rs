//! Exponentials, logarithms and powers.

use core::f64::consts::{LN_2, LOG2_E};

use fearless_simd::Level;

use super::wide::{Wide, each, each2, lanes_of, polynomial, round};
use crate::simd::Isa;

/// 2^x.
#[inline]
#[must_use]
pub fn exp2(x: f32) -> f32 {
    round(power(f64::from(x)))
}

/// e^x.
#[inline]
#[must_use]
pub fn exp(x: f32) -> f32 {
    round(power(f64::from(x) * LOG2_E))
}

/// Logarithm to base 2; -infinity at zero, NaN below it.
#[inline]
#[must_use]
pub fn log2(x: f32) -> f32 {
    round(logarithm(f64::from(x)))
}

/// Natural logarithm; -infinity at zero, NaN below it.
#[inline]
#[must_use]
pub fn ln(x: f32) -> f32 {
    round(logarithm(f64::from(x)) * LN_2)
}

/// `x` to the power `y`; NaN for a negative `x` with a `y` that is no integer. `pow(x, 0)` and `pow(1, y)` are 1, for NaN too.
#[inline]
#[must_use]
pub fn pow(x: f32, y: f32) -> f32 {
    round(raise(f64::from(x), f64::from(y)))
}

lanes_of! {
    /// 2^x of lanes.
    exp2_lanes(x) by apply, each = power, exp2
}

lanes_of! {
    /// Logarithm to base 2 of lanes.
    log2_lanes(x) by apply, each = logarithm, log2
}

lanes_of! {
    /// `x` to the power `y`.
    pow_lanes(x, y) by apply2, each2 = raise, pow
}

/// 2^x: Taylor of e^r to the 9th power for |r| <= ln(2)/2 (remainder below 2^-37). Beyond +-200 the f32 result is infinite or 0.
#[inline(always)]
fn power<W: Wide>(x: W) -> W {
    let inside = x.clamp(-200.0, 200.0);
    let n = inside.nearest();
    let r = (inside - n) * LN_2;
    let e = polynomial!(
        r;
        1.0,
        1.0,
        0.5,
        1.0 / 6.0,
        1.0 / 24.0,
        1.0 / 120.0,
        1.0 / 720.0,
        1.0 / 5_040.0,
        1.0 / 40_320.0,
        1.0 / 362_880.0
    );
    W::select(x.is_nan(), x.constant(f64::NAN), e * n.power_of_two())
}

/// log2 x = e + (2/ln 2) atanh(s), s = f/(2 + f): the series to z^7, z = s^2 < 0.0295 (remainder below 2^-44).
#[inline(always)]
fn logarithm<W: Wide>(x: W) -> W {
    let (zero, infinity) = (x.constant(0.0), x.constant(f64::INFINITY));
    let usable = zero.lt(x) & x.lt(infinity);
    let (e, f) = W::select(usable, x, x.constant(1.0)).decompose();
    let s = f / (f + 2.0);
    let z = s * s;
    let series = polynomial!(
        z;
        1.0,
        1.0 / 3.0,
        1.0 / 5.0,
        1.0 / 7.0,
        1.0 / 9.0,
        1.0 / 11.0,
        1.0 / 13.0,
        1.0 / 15.0
    );
    let l = e + s * (2.0 * LOG2_E) * series;
    // The remaining values: zero of either sign, infinity, negative numbers and NaN.
    let special = W::select(x.eq(infinity), infinity, x.constant(f64::NAN));
    let special = W::select(x.eq(zero), x.constant(f64::NEG_INFINITY), special);
    W::select(usable, l, special)
}

/// 2^(y log2 |x|) with the sign and the special cases of a power. x and y hold f32 values.
#[inline(always)]
fn raise<W: Wide>(x: W, y: W) -> W {
    let (zero, one) = (x.constant(0.0), x.constant(1.0));
    let magnitude = power(logarithm(x.abs()) * y);
    // An f32 of at least 2^23 is an integer, of at least 2^24 an even one.
    let size = y.abs();
    let fraction = size.lt(x.constant(8_388_608.0));
    let small = W::select(size.lt(x.constant(16_777_216.0)), y, zero);
    let integer = !fraction | small.nearest().eq(small);
    let odd = integer & small.has_bit(0);
    let negative = one.with_sign_of(x).lt(zero);
    let result = magnitude.negate_where(negative & odd);
    // A negative finite base with a broken exponent; -0 and -infinity behave as positive.
    let below = x.lt(zero) & x.constant(f64::NEG_INFINITY).lt(x);
    let result = W::select(below & !integer, x.constant(f64::NAN), result);
    // (-1)^(+-infinity), which would be 2^(0 * infinity).
    let result = W::select(
        x.eq(one * -1.0) & size.eq(x.constant(f64::INFINITY)),
        one,
        result,
    );
    W::select(y.eq(zero) | x.eq(one), one, result)
}

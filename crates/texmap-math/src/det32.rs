//! Deterministic elementary functions in f32: the f64 form, rounded once.

use crate::det;

macro_rules! rounded {
    ($($(#[$doc:meta])* $name:ident;)*) => {$(
        $(#[$doc])*
        #[inline]
        #[must_use]
        pub fn $name(x: f32) -> f32 {
            det::$name(f64::from(x)) as f32
        }
    )*};
}

rounded! {
    /// Sine.
    sin;
    /// Cosine.
    cos;
    /// Tangent.
    tan;
    /// Arc sine, NaN outside `[-1, 1]`.
    asin;
    /// Arc cosine, NaN outside `[-1, 1]`.
    acos;
    /// Arc tangent.
    atan;
    /// e^x.
    exp;
    /// 2^x.
    exp2;
    /// Natural logarithm.
    ln;
    /// Logarithm to base 2.
    log2;
}

/// Sine and cosine.
#[inline]
#[must_use]
pub fn sin_cos(x: f32) -> (f32, f32) {
    let (s, c) = det::sin_cos(f64::from(x));
    (s as f32, c as f32)
}

/// The angle of the point (`x`, `y`), in `[-pi, pi]`.
#[inline]
#[must_use]
pub fn atan2(y: f32, x: f32) -> f32 {
    det::atan2(f64::from(y), f64::from(x)) as f32
}

/// `x` to the power `y`.
#[inline]
#[must_use]
pub fn pow(x: f32, y: f32) -> f32 {
    det::pow(f64::from(x), f64::from(y)) as f32
}

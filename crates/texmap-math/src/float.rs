//! Square root and rounding for both `std` and `libm`: the same bits either way, since each of them is exactly rounded.

macro_rules! forward {
    ($($(#[$doc:meta])* $name:ident($ty:ty) = $std:ident, $libm:ident;)*) => {$(
        $(#[$doc])*
        #[inline(always)]
        #[must_use]
        pub fn $name(x: $ty) -> $ty {
            #[cfg(feature = "std")]
            {
                x.$std()
            }
            #[cfg(not(feature = "std"))]
            {
                libm::$libm(x)
            }
        }
    )*};
}

forward! {
    /// Square root, correctly rounded; NaN below zero.
    sqrt(f64) = sqrt, sqrt;
    /// Square root, correctly rounded; NaN below zero.
    sqrt_f32(f32) = sqrt, sqrtf;
    /// Greatest integer not above `x`; NaN and infinities pass.
    floor(f64) = floor, floor;
    /// Greatest integer not above `x`; NaN and infinities pass.
    floor_f32(f32) = floor, floorf;
    /// Least integer not below `x`; NaN and infinities pass.
    ceil(f64) = ceil, ceil;
    /// Least integer not below `x`; NaN and infinities pass.
    ceil_f32(f32) = ceil, ceilf;
    /// Integer part, towards zero; NaN and infinities pass.
    trunc(f64) = trunc, trunc;
    /// Integer part, towards zero; NaN and infinities pass.
    trunc_f32(f32) = trunc, truncf;
}

/// `floor(x + 1/2)`: the nearest integer, halves upwards also below zero. One formula everywhere: the sum is rounded
/// first, so the largest number below 1/2 gives 1.
#[inline(always)]
#[must_use]
pub fn round_half_up(x: f64) -> f64 {
    floor(x + 0.5)
}

/// `floor(x + 1/2)` in f32, as [`round_half_up`].
#[inline(always)]
#[must_use]
pub fn round_half_up_f32(x: f32) -> f32 {
    floor_f32(x + 0.5)
}

/// Fractional part `x - floor(x)`, in `[0, 1)`: -1e-17 would round to 1 and gives 0 instead. NaN for NaN and infinities.
#[inline(always)]
#[must_use]
pub fn fract(x: f64) -> f64 {
    let f = x - floor(x);
    if f >= 1.0 { 0.0 } else { f }
}

/// Fractional part in f32, as [`fract`].
#[inline(always)]
#[must_use]
pub fn fract_f32(x: f32) -> f32 {
    let f = x - floor_f32(x);
    if f >= 1.0 { 0.0 } else { f }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halves_round_up_and_fractions_stay_below_one() {
        assert_eq!(round_half_up(-0.5), 0.0);
        assert_eq!(round_half_up(-1.5), -1.0);
        assert_eq!(round_half_up(2.5), 3.0);
        assert_eq!(fract(-1e-17), 0.0);
        assert_eq!(fract_f32(-1e-9), 0.0);
        assert_eq!(fract(-0.25), 0.75);
        assert!(fract(f64::INFINITY).is_nan());
    }
}

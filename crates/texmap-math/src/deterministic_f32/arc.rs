//! Arc functions.

use fearless_simd::Level;

use super::wide::{Wide, each, each2, lanes_of, polynomial, round};
use crate::simd::Isa;

/// tan(pi/8).
const TAN_PI_8: f64 = 0.414_213_562_373_095_03;

/// The angle of the point (`x`, `y`) from the +x axis, in `[-pi, pi]`. Signed zeros and infinities as in C (annex F.10.1.4).
#[inline]
#[must_use]
pub fn atan2(y: f32, x: f32) -> f32 {
    round(angle(f64::from(y), f64::from(x)))
}

/// Arc tangent.
#[inline]
#[must_use]
pub fn atan(x: f32) -> f32 {
    atan2(x, 1.0)
}

/// Arc sine; NaN outside `[-1, 1]`.
#[inline]
#[must_use]
pub fn asin(x: f32) -> f32 {
    round(arc_sine(f64::from(x)))
}

/// Arc cosine; NaN outside `[-1, 1]`.
#[inline]
#[must_use]
pub fn acos(x: f32) -> f32 {
    let x = f64::from(x);
    round(angle(leg(x), x))
}

lanes_of! {
    /// The angle of points in lanes.
    atan2_lanes(y, x) by apply2, each2 = angle, atan2
}

lanes_of! {
    /// Arc sine of lanes.
    asin_lanes(x) by apply, each = arc_sine, asin
}

#[inline(always)]
fn arc_sine<W: Wide>(x: W) -> W {
    angle(x, leg(x))
}

/// The other leg of the right triangle with hypotenuse 1; NaN for `|x| > 1`.
#[inline(always)]
fn leg<W: Wide>(x: W) -> W {
    let one = x.constant(1.0);
    ((one - x) * (one + x)).sqrt()
}

#[inline(always)]
fn angle<W: Wide>(y: W, x: W) -> W {
    let zero = x.constant(0.0);
    let infinity = x.constant(f64::INFINITY);
    let (ay, ax) = (y.abs(), x.abs());
    let steep = ax.lt(ay);
    let (small, large) = (W::select(steep, ax, ay), W::select(steep, ay, ax));
    // Equal infinities make 45 degrees, one infinity an axis, two zeros the angle 0.
    let unbounded = large.eq(infinity);
    let small = W::select(
        unbounded,
        W::select(small.eq(infinity), x.constant(1.0), zero),
        small,
    );
    let large = W::select(unbounded | large.eq(zero), x.constant(1.0), large);
    // atan(q) = pi/4 + atan((q - 1)/(q + 1)) leaves |t| <= tan(pi/8).
    let upper = (large * TAN_PI_8).lt(small);
    let numerator = W::select(upper, small - large, small);
    let denominator = W::select(upper, small + large, large);
    let t = numerator / denominator;
    let z = t * t;
    // (atan(t)/t - 1)/z interpolated at the seven Chebyshev points of [0, tan^2(pi/8)]: within 2^-38 of the whole.
    let series = polynomial!(
        z;
        -0.333_333_333_314_394_95,
        0.199_999_989_166_905_62,
        -0.142_856_124_652_752_5,
        0.111_074_938_534_327_03,
        -0.090_289_675_621_104_18,
        0.071_352_346_474_640_81,
        -0.040_430_336_961_074_71
    );
    let near = t + t * z * series;
    let near = W::select(upper, near + core::f64::consts::FRAC_PI_4, near);
    let quarter = W::select(steep, near * -1.0 + core::f64::consts::FRAC_PI_2, near);
    let left = x.constant(1.0).with_sign_of(x).lt(zero);
    let half = W::select(left, quarter * -1.0 + core::f64::consts::PI, quarter);
    let signed = half.with_sign_of(y);
    W::select(x.is_nan() | y.is_nan(), x.constant(f64::NAN), signed)
}

//! Arc functions, all from one quotient and a table of nine arc tangents.

use super::Double;
use crate::float::sqrt;

/// atan(i/8) as `hi + lo`.
const TABLE: [(f64, f64); 9] = [
    (0.0, 0.0),
    (0.124_354_994_546_761_44, -3.125_324_142_453_938_3e-18),
    (0.244_978_663_126_864_14, 1.069_875_561_873_445_1e-17),
    (0.358_770_670_270_572_25, -2.462_381_558_263_863_5e-17),
    (0.463_647_609_000_806_1, 2.269_877_745_296_168_7e-17),
    (0.558_599_315_343_562_4, -5.455_630_548_591_626e-18),
    (0.643_501_108_793_284_4, 1.583_478_505_144_428_6e-17),
    (0.718_829_999_621_624_5, -2.147_838_844_445_698_3e-17),
    (core::f64::consts::FRAC_PI_4, 3.061_616_997_868_383e-17),
];

const HALF_PI: (f64, f64) = (core::f64::consts::FRAC_PI_2, 6.123_233_995_736_766e-17);
const PI: (f64, f64) = (core::f64::consts::PI, 1.224_646_799_147_353_2e-16);

/// Arc tangent, in `[-pi/2, pi/2]`. Error below 2 ulp; NaN for NaN; `atan(-0.0)` is -0.0.
#[must_use]
pub const fn atan(x: f64) -> f64 {
    atan2(x, 1.0)
}

/// The angle of the point (`x`, `y`) from the +x axis, in `[-pi, pi]`. Error below 2 ulp (results below 1e-300 to one subnormal
/// step more); signed zeros and infinities as in C (annex F.10.1.4): `atan2(+0, -0)` is pi.
#[must_use]
pub const fn atan2(y: f64, x: f64) -> f64 {
    if x.is_nan() || y.is_nan() {
        return f64::NAN;
    }
    let angle = quadrant_angle(y.abs(), x.abs());
    let angle = if x.is_sign_negative() {
        let d = Double::sum(PI.0, -angle.hi);
        d.hi + (d.lo + (PI.1 - angle.lo))
    } else {
        angle.hi + angle.lo
    };
    if y.is_sign_negative() { -angle } else { angle }
}

/// Arc sine, in `[-pi/2, pi/2]`; NaN outside `[-1, 1]`. Error below 2.5 ulp.
#[must_use]
pub fn asin(x: f64) -> f64 {
    atan2(x, sqrt((1.0 - x) * (1.0 + x)))
}

/// Arc cosine, in `[0, pi]`; NaN outside `[-1, 1]`. Error below 2.5 ulp.
#[must_use]
pub fn acos(x: f64) -> f64 {
    atan2(sqrt((1.0 - x) * (1.0 + x)), x)
}

/// atan(y/x) of non-negative numbers, in `[0, pi/2]`.
const fn quadrant_angle(y: f64, x: f64) -> Double {
    if y == 0.0 {
        return Double { hi: 0.0, lo: 0.0 };
    }
    let steep = y > x;
    let (a, b) = if steep { (x, y) } else { (y, x) };
    let near = if b.is_infinite() {
        if a.is_infinite() {
            Double {
                hi: TABLE[8].0,
                lo: TABLE[8].1,
            }
        } else {
            Double { hi: 0.0, lo: 0.0 }
        }
    } else {
        octant_angle(a, b)
    };
    if !steep {
        return near;
    }
    let d = Double::sum(HALF_PI.0, -near.hi);
    Double {
        hi: d.hi,
        lo: d.lo + (HALF_PI.1 - near.lo),
    }
}

/// atan(a/b) for finite `0 <= a <= b`, `b > 0`: atan(a/b) = atan(c) + atan((a - c b)/(b + c a)) with c = i/8 nearest to a/b.
const fn octant_angle(a: f64, b: f64) -> Double {
    // Keep c*a, b + c*a and the small quotient inside the range.
    let (a, b) = if b > 1e300 {
        (a * 1e-20, b * 1e-20)
    } else if b < 1e-280 {
        (a * 1e250, b * 1e250)
    } else {
        (a, b)
    };
    let index = (8.0 * (a / b) + 0.5) as usize;
    if index == 0 {
        let t = a / b;
        return Double {
            hi: t,
            lo: t * series(t * t),
        };
    }
    let c = index as f64 * 0.125;
    let t = (a - c * b) / (b + c * a);
    let (hi, lo) = TABLE[index];
    Double::fast_sum(hi, lo + (t + t * series(t * t)))
}

/// atan(t)/t - 1 for z = t^2 <= 1/256: Taylor to z^7, remainder below 1e-20.
const fn series(z: f64) -> f64 {
    let s = -1.0 / 15.0;
    let s = 1.0 / 13.0 + z * s;
    let s = -1.0 / 11.0 + z * s;
    let s = 1.0 / 9.0 + z * s;
    let s = -1.0 / 7.0 + z * s;
    let s = 1.0 / 5.0 + z * s;
    let s = -1.0 / 3.0 + z * s;
    z * s
}

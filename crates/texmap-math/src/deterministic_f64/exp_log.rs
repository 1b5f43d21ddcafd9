//! Exponentials, logarithms and powers.

use super::{Double, nearest, power_of_two, scale};

/// ln 2 to 33 bits, so that `n * LN2.0` is exact for `|n| < 2^20`, and the rest.
const LN2: (f64, f64) = (0.693_147_180_485_539_1, 7.440_617_110_012_397e-11);
const LN2_FULL: Double = Double {
    hi: core::f64::consts::LN_2,
    lo: 2.319_046_813_846_299_6e-17,
};
const LOG2_E: Double = Double {
    hi: core::f64::consts::LOG2_E,
    lo: 2.035_527_374_093_103_3e-17,
};

/// 2^x. Error below 0.75 ulp; 0 below -1075, infinity from 1024 up; NaN for NaN.
#[must_use]
pub const fn exp2(x: f64) -> f64 {
    if x.is_nan() {
        return f64::NAN;
    }
    exp2_double(Double { hi: x, lo: 0.0 })
}

/// e^x. Error below 0.75 ulp; 0 below -746, infinity above 709.79; NaN for NaN.
#[must_use]
pub const fn exp(x: f64) -> f64 {
    if x.is_nan() {
        return f64::NAN;
    }
    if x > 710.0 {
        return f64::INFINITY;
    }
    if x < -746.0 {
        return 0.0;
    }
    let n = nearest(x * core::f64::consts::LOG2_E);
    let r = Double::sum(x - n * LN2.0, -(n * LN2.1));
    scale(exp_rest(r), n as i32)
}

/// Natural logarithm. Error below 1 ulp; -infinity at zero, NaN below it.
#[must_use]
pub const fn ln(x: f64) -> f64 {
    if let Some(special) = log_special(x) {
        return special;
    }
    let (e, f) = decompose(x);
    // ln(1 + f) = f - (f^2/2 - s (f^2/2 + R)), s = f/(2 + f), R = ln((1+s)/(1-s))/s - 2.
    let s = f / (2.0 + f);
    let half = 0.5 * f * f;
    let rest = s * (half + 2.0 * atanh_series(s * s));
    if e == 0.0 {
        return f - (half - rest);
    }
    e * LN2.0 - ((half - (rest + e * LN2.1)) - f)
}

/// Logarithm to base 2. Error below 0.75 ulp, exact for powers of two; -infinity at zero, NaN below it.
#[must_use]
pub const fn log2(x: f64) -> f64 {
    if let Some(special) = log_special(x) {
        return special;
    }
    let l = log2_double(x);
    l.hi + l.lo
}

/// `x` to the power `y`. Error below 0.75 ulp; NaN for a negative `x` with a `y` that is no integer; `pow(x, 0)` and `pow(1, y)` are 1,
/// for NaN too (IEEE 754-2019, section 9.2.1).
#[must_use]
pub const fn pow(x: f64, y: f64) -> f64 {
    if y == 0.0 || x == 1.0 {
        return 1.0;
    }
    if x.is_nan() || y.is_nan() {
        return f64::NAN;
    }
    let odd = is_odd_integer(y);
    let negative = x.is_sign_negative() && odd;
    let size = x.abs();
    let magnitude = if size == 0.0 || size.is_infinite() {
        if (size == 0.0) == (y < 0.0) {
            f64::INFINITY
        } else {
            0.0
        }
    } else if y.is_infinite() {
        if size == 1.0 {
            1.0
        } else if (size > 1.0) == (y > 0.0) {
            f64::INFINITY
        } else {
            0.0
        }
    } else if x < 0.0 && !odd && !is_integer(y) {
        return f64::NAN;
    } else {
        pow_finite(size, y)
    };
    if negative { -magnitude } else { magnitude }
}

/// x^y of a positive finite `x`: 2^(y log2 x) with the exponent in about 75 bits.
const fn pow_finite(x: f64, y: f64) -> f64 {
    let l = log2_double(x);
    let rough = y * l.hi;
    if rough > 1100.0 {
        return f64::INFINITY;
    }
    if rough < -1200.0 {
        return 0.0;
    }
    // Here |y| < 2^64: log2 of the number next to 1 is 2^-53, so nothing overflows in the product.
    let p = Double::product(l.hi, y);
    exp2_double(Double::fast_sum(p.hi, p.lo + l.lo * y))
}

/// 2^(hi + lo).
const fn exp2_double(x: Double) -> f64 {
    if x.hi >= 1025.0 {
        return f64::INFINITY;
    }
    if x.hi < -1080.0 {
        return 0.0;
    }
    let n = nearest(x.hi);
    let f = Double {
        hi: x.hi - n,
        lo: x.lo,
    };
    scale(
        exp_rest(Double::fast_sum(f.hi, f.lo).times(LN2_FULL)),
        n as i32,
    )
}

/// e^(hi + lo) for |hi| <= 0.35: Taylor to the 13th power, remainder below 4e-18.
const fn exp_rest(r: Double) -> f64 {
    let x = r.hi;
    let s = 1.0 / 6_227_020_800.0;
    let s = 1.0 / 479_001_600.0 + x * s;
    let s = 1.0 / 39_916_800.0 + x * s;
    let s = 1.0 / 3_628_800.0 + x * s;
    let s = 1.0 / 362_880.0 + x * s;
    let s = 1.0 / 40_320.0 + x * s;
    let s = 1.0 / 5_040.0 + x * s;
    let s = 1.0 / 720.0 + x * s;
    let s = 1.0 / 120.0 + x * s;
    let s = 1.0 / 24.0 + x * s;
    let s = 1.0 / 6.0 + x * s;
    let s = 0.5 + x * s;
    let first = Double::fast_sum(1.0, x);
    first.hi + (first.lo + (x * x * s + r.lo * (1.0 + x)))
}

/// log2 of a positive finite number in about 75 bits.
const fn log2_double(x: f64) -> Double {
    let (e, f) = decompose(x);
    if f == 0.0 {
        return Double { hi: e, lo: 0.0 };
    }
    // s = f/(2 + f) with the rest of the division.
    let d = Double::fast_sum(2.0, f);
    let s = f / d.hi;
    let p = Double::product(s, d.hi);
    let s = Double::fast_sum(s, (((f - p.hi) - p.lo) - s * d.lo) / d.hi);
    // ln(1 + f) = 2s + 2s^3/3 + ...; the cubic term keeps its low part as well.
    let z = s.times(s);
    let third = Double {
        hi: 0.333_333_333_333_333_3,
        lo: 1.850_371_707_708_594e-17,
    };
    let cubic = s.times(z).times(third);
    let tail = s.hi * z.hi * z.hi * quintic_series(z.hi);
    let sum = Double::fast_sum(s.hi, s.lo).plus(cubic);
    let sum = Double::fast_sum(sum.hi, sum.lo + tail);
    let ln = Double {
        hi: 2.0 * sum.hi,
        lo: 2.0 * sum.lo,
    };
    let l = ln.times(LOG2_E);
    Double::sum(e, l.hi).plus(Double { hi: l.lo, lo: 0.0 })
}

/// atanh(s)/s - 1 = z/3 + z^2/5 + ... for z = s^2 <= 0.0295, to z^11.
const fn atanh_series(z: f64) -> f64 {
    z * (1.0 / 3.0 + z * quintic_series(z))
}

/// 1/5 + z/7 + z^2/9 + ... to z^9.
const fn quintic_series(z: f64) -> f64 {
    let s = 1.0 / 23.0;
    let s = 1.0 / 21.0 + z * s;
    let s = 1.0 / 19.0 + z * s;
    let s = 1.0 / 17.0 + z * s;
    let s = 1.0 / 15.0 + z * s;
    let s = 1.0 / 13.0 + z * s;
    let s = 1.0 / 11.0 + z * s;
    let s = 1.0 / 9.0 + z * s;
    let s = 1.0 / 7.0 + z * s;
    1.0 / 5.0 + z * s
}

/// `x = 2^e (1 + f)` with `1 + f` in `[sqrt(1/2), sqrt(2))`; `f` is exact. `x` is positive and finite.
const fn decompose(x: f64) -> (f64, f64) {
    let (x, shift) = if x < f64::MIN_POSITIVE {
        (x * power_of_two(54), -54.0)
    } else {
        (x, 0.0)
    };
    let bits = x.to_bits();
    // Adding the distance from the bits of sqrt(1/2) to those of 1 carries into the exponent exactly where the mantissa passes sqrt(2).
    let moved = bits + (0x3ff0_0000_0000_0000 - 0x3fe6_a09e_667f_3bcd);
    let e = (moved >> 52) as i64 - 1023;
    let m = f64::from_bits(bits.wrapping_sub((e as u64) << 52));
    (e as f64 + shift, m - 1.0)
}

const fn log_special(x: f64) -> Option<f64> {
    if x.is_nan() || x < 0.0 {
        Some(f64::NAN)
    } else if x == 0.0 {
        Some(f64::NEG_INFINITY)
    } else if x.is_infinite() {
        Some(x)
    } else {
        None
    }
}

const fn is_integer(x: f64) -> bool {
    x.abs() >= 4_503_599_627_370_496.0 || nearest(x) == x
}

const fn is_odd_integer(x: f64) -> bool {
    x.abs() < 9_007_199_254_740_992.0 && x as i64 as f64 == x && (x as i64) & 1 == 1
}

//! Reduction of an angle to a quadrant and a rest within pi/4, for every finite number.

use super::{Double, nearest};

/// pi/2 in three parts of 33 bits and the rest: `n * part` is exact for `|n| < 2^20`.
const HALF_PI: [f64; 4] = [
    1.570_796_326_734_125_6,
    6.077_100_506_303_966e-11,
    2.022_266_248_711_166_5e-21,
    8.478_427_660_368_9e-32,
];

/// Above this the parts of [`HALF_PI`] no longer multiply exactly and the long way is taken.
const NEAR: f64 = 1_600_000.0;

/// The first 1280 bits of 2/pi after the point.
const TWO_OVER_PI: [u64; 20] = [
    0xa2f9836e4e441529,
    0xfc2757d1f534ddc0,
    0xdb6295993c439041,
    0xfe5163abdebbc561,
    0xb7246e3a424dd2e0,
    0x06492eea09d1921c,
    0xfe1deb1cb129a73e,
    0xe88235f52ebb4484,
    0xe99c7026b45f7e41,
    0x3991d639835339f4,
    0x9c845f8bbdf9283b,
    0x1ff897ffde05980f,
    0xef2f118b5a0a6d1f,
    0x6d367ecf27cb09b7,
    0x4f463f669e5fea2d,
    0x7527bac7ebe5f17b,
    0x3d0739f78a5292ea,
    0x6bfb5fb11f8d5d08,
    0x56033046fc7b6bab,
    0xf0cfbc209af4361d,
];

/// `x = quadrant * pi/2 + rest`, the rest within pi/4 (and a few units in its last place). `x` is finite.
pub(super) const fn reduce(x: f64) -> (u32, Double) {
    if x.abs() <= core::f64::consts::FRAC_PI_4 {
        return (0, Double { hi: x, lo: 0.0 });
    }
    if x.abs() <= NEAR {
        return cody_waite(x);
    }
    let (quadrant, rest) = payne_hanek(x.abs());
    if x < 0.0 {
        (
            quadrant.wrapping_neg() & 3,
            Double {
                hi: -rest.hi,
                lo: -rest.lo,
            },
        )
    } else {
        (quadrant, rest)
    }
}

/// Subtracts `n` times pi/2 part by part (Cody and Waite 1980), keeping what each difference rounds away.
const fn cody_waite(x: f64) -> (u32, Double) {
    let n = nearest(x * core::f64::consts::FRAC_2_PI);
    let a = Double::sum(x, -(n * HALF_PI[0]));
    let b = Double::sum(a.hi, -(n * HALF_PI[1]));
    let c = Double::sum(b.hi, -(n * HALF_PI[2]));
    let rest = Double::sum(c.hi, a.lo + b.lo + c.lo - n * HALF_PI[3]);
    (n as i64 as u32 & 3, rest)
}

/// Multiplies by the bits of 2/pi that matter (Payne and Hanek 1983). `x` is finite and at least 2^20.
const fn payne_hanek(x: f64) -> (u32, Double) {
    let bits = x.to_bits();
    let exponent = (bits >> 52) as i32 - 1075;
    let mantissa = (bits & ((1 << 52) - 1)) | (1 << 52);
    // x = mantissa * 2^exponent. Bits of 2/pi of weight 2^-k with exponent - k >= 2 only add multiples of 4 quadrants, so the
    // window begins at k = exponent - 1; with a negative exponent it begins before the point, with zeros.
    let start = exponent - 2;
    let window = [
        bits_from(start),
        bits_from(start + 64),
        bits_from(start + 128),
    ];
    // mantissa * window modulo 2^192: two bits of quadrant, 190 of fraction.
    let low = mantissa as u128 * window[2] as u128;
    let middle = mantissa as u128 * window[1] as u128 + (low >> 64);
    let high = mantissa
        .wrapping_mul(window[0])
        .wrapping_add((middle >> 64) as u64);
    let mut quadrant = (high >> 62) as u32;
    let mut fraction =
        ((high as u128) << 64 | (middle as u64) as u128) << 2 | ((low as u64) >> 62) as u128;
    // Above one half the next quadrant is nearer.
    let above = fraction >> 127 == 1;
    if above {
        quadrant = (quadrant + 1) & 3;
        fraction = fraction.wrapping_neg();
    }
    let shift = fraction.leading_zeros();
    if shift == 128 {
        return (quadrant, Double { hi: 0.0, lo: 0.0 });
    }
    let aligned = fraction << shift;
    let unit = f64::from_bits((1023 - 53 - shift as u64) << 52);
    let hi = (aligned >> 75) as f64 * unit;
    let lo = ((aligned >> 22) & ((1 << 53) - 1)) as f64 * unit * (1.0 / 9_007_199_254_740_992.0);
    let rest = Double::fast_sum(hi, lo).times(Double {
        hi: core::f64::consts::FRAC_PI_2,
        lo: 6.123_233_995_736_766e-17,
    });
    (
        quadrant,
        if above {
            Double {
                hi: -rest.hi,
                lo: -rest.lo,
            }
        } else {
            rest
        },
    )
}

/// 64 bits of 2/pi from bit `start` after the point (bit 0 has weight 1/2); zeros before the point.
const fn bits_from(start: i32) -> u64 {
    let word = start.div_euclid(64);
    let offset = start.rem_euclid(64);
    let first = word_at(word);
    if offset == 0 {
        first
    } else {
        first << offset | word_at(word + 1) >> (64 - offset)
    }
}

const fn word_at(index: i32) -> u64 {
    if index < 0 {
        0
    } else {
        TWO_OVER_PI[index as usize]
    }
}

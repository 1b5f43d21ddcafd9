//! Light to 8-bit codes.

use super::{GatherTable, prelude::*};
use crate::color::{SRGB8_FIRST, SRGB8_STEPS};
use crate::deterministic_f64;

/// `round(255 x)` of `x` within 0..=1: [`color::unit_to_u8`](crate::color::unit_to_u8). NaN gives 0.
#[inline(always)]
pub fn encode_unorm8<I: Isa>(i: I, x: I::F32) -> I::U32 {
    let x = x.clamp(i.f32(0.0), i.f32(1.0));
    // By signed integers: only AVX-512 converts to the others.
    (x * 255.0 + 0.5).to_i32().to_u32()
}

/// The sRGB codes of linear red, green and blue, red in the lowest byte and zero in the highest:
/// [`color::linear_to_srgb8`](crate::color::linear_to_srgb8) of each. NaN gives 0.
///
/// Vectors of 256 bits and more compute the codes to one part in 2,000 and look up where one may be on the other side of
/// a threshold, which happens in about one of twenty vectors.
#[inline(always)]
pub fn encode_srgb8<I: Isa>(i: I, [r, g, b]: [I::F32; 3]) -> I::U32 {
    let (r, g, b) = (within_curve(i, r), within_curve(i, g), within_curve(i, b));
    if !i.is_wide() {
        return look_up(i, [r, g, b]);
    }
    let (red, green, blue) = (estimate(i, r), estimate(i, g), estimate(i, b));
    if (is_close::<I>(red) | is_close::<I>(green) | is_close::<I>(blue)).any_true() {
        return look_up(i, [r, g, b]);
    }
    ((red >> FRACTION) | ((green >> FRACTION) << 8) | ((blue >> FRACTION) << 16)).to_u32()
}

/// From where the curve leaves code 0 behind to its end.
#[inline(always)]
fn within_curve<I: Isa>(i: I, x: I::F32) -> I::F32 {
    x.clamp(i.f32(f32::from_bits(SRGB8_FIRST)), i.f32(1.0))
}

#[inline(always)]
fn look_up<I: Isa>(i: I, [r, g, b]: [I::F32; 3]) -> I::U32 {
    let Some(steps) = GatherTable::new(&SRGB8_STEPS) else {
        return i.u32(0);
    };
    step(i, steps, r) | (step(i, steps, g) << 8) | (step(i, steps, b) << 16)
}

#[inline(always)]
fn step<I: Isa>(i: I, steps: GatherTable<'_>, x: I::F32) -> I::U32 {
    let bits = x.to_bits();
    let step = i.gather(steps, (bits >> 16) - (SRGB8_FIRST >> 16));
    (step + (bits & 0xffff)) >> 16
}

/// Bits of an estimate below the code.
const FRACTION: u32 = 11;

const ONE: f64 = (1 << FRACTION) as f64;

/// `ONE * 255 * 1.055 * 2^(5 e / 12)` by the last four bits of the exponent, for e in -13..=0.
static OCTAVES: [u32; 16] = {
    let mut octaves = [0; 16];
    let mut exponent = SRGB8_FIRST >> 23;
    while exponent <= 127 {
        let power = deterministic_f64::pow(2.0, (exponent as f64 - 127.0) / 2.4);
        octaves[exponent as usize % 16] = ((ONE * 255.0 * 1.055 * power) as f32).to_bits();
        exponent += 1;
    }
    octaves
};

/// The code plus one half as an integer of [`FRACTION`] bits behind the point, off by less than one.
///
/// The power is one of the exponent times one of the mantissa, a polynomial (of least greatest error on 1..=2, 1.4e-6, by Remez'
/// algorithm): off by 2.8e-4 codes, and by 0.6e-4 more in f32, of the 4.9e-4 that are allowed.
#[inline(always)]
fn estimate<I: Isa>(i: I, x: I::F32) -> I::I32 {
    let bits = x.to_bits();
    let octave = i.table16(&OCTAVES, bits >> 23).to_f32_bits();
    let m = ((bits & 0x7f_ffff) | 0x3f80_0000).to_f32_bits();
    let power = i.estimate_mul_add(m, i.f32(0.005_333_131), i.f32(-0.050_653_334));
    let power = i.estimate_mul_add(power, m, i.f32(0.206_318_1));
    let power = i.estimate_mul_add(power, m, i.f32(-0.488_464_82));
    let power = i.estimate_mul_add(power, m, i.f32(0.950_480_6));
    let power = i.estimate_mul_add(power, m, i.f32(0.376_987_72));
    let curve = i.estimate_mul_add(power, octave, i.f32((ONE * (0.5 - 255.0 * 0.055)) as f32));
    let slope = i.f32((ONE * 255.0 * 12.92) as f32);
    let line = i.estimate_mul_add(x, slope, i.f32((ONE * 0.5) as f32));
    x.simd_lt(0.003_130_8).select(line, curve).to_i32()
}

/// True where a whole number lies within one of an estimate's last place.
#[inline(always)]
fn is_close<I: Isa>(estimate: I::I32) -> I::Mask {
    ((estimate + 1) & ((1 << FRACTION) - 2)).simd_eq(0)
}

#[cfg(test)]
mod tests {
    use super::super::Scalar;
    use super::*;
    use crate::color::{SRGB8_THRESHOLDS, linear_to_srgb8};

    #[test]
    fn estimates_are_wrong_near_thresholds_and_there_alone() {
        let mut wrong = 0;
        for threshold in &SRGB8_THRESHOLDS[..255] {
            for bits in threshold.to_bits() - 100..threshold.to_bits() + 100 {
                let x = f32::from_bits(bits);
                let estimated = estimate(Scalar, x);
                if estimated.0 >> FRACTION != i32::from(linear_to_srgb8(x)) {
                    wrong += 1;
                    assert!(is_close::<Scalar>(estimated), "{x:e}: {estimated:?}");
                }
            }
        }
        assert!(wrong > 0);
    }
}

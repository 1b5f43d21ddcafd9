//! Light in one word: three channels of 9 bits under one exponent of 5, from 0 to [`MOST`]. A channel is off by at most 2^-9 of the
//! brightest one, or by 2^-21. (The layout is that of `E5B9G9R9_UFLOAT_PACK32`, Vulkan 1.4, with another bias.)

use texmap_math::simd::{F32s, Isa, Scalar, prelude::*};

use crate::lanes::Vector;

/// Largest value: 511 times 2^11.
pub(crate) const MOST: f32 = 1_046_528.0;
/// A step of exponent 0 is 2^-20.
const BIAS: u32 = 20;

/// Rounded to the nearest; beyond 0 to [`MOST`] to the nearer end, NaN to 0.
pub(crate) fn pack(texel: &[f32; 3]) -> u32 {
    let texel = texel.map(|c| F32s::<Scalar>::clamp(c, 0.0, MOST));
    let most = texel[0].above(texel[1]).above(texel[2]);
    // 2^power is at most the brightest channel, whose mantissa then has 9 bits.
    let power = (most.to_bits() >> 23) as i32 - 127;
    let exponent = (power + BIAS as i32 - 8).max(0) as u32;
    // The brightest may round to 512.
    let exponent = exponent + u32::from(steps(most, exponent) > 511);
    let [r, g, b] = texel.map(|c| steps(c, exponent));
    r | g << 9 | b << 18 | exponent << 27
}

fn steps(c: f32, exponent: u32) -> u32 {
    (c / step(exponent) + 0.5) as u32
}

fn step(exponent: u32) -> f32 {
    f32::from_bits((exponent + 127 - BIAS) << 23)
}

#[inline(always)]
pub(crate) fn unpack<I: Isa>(_: I, word: I::U32) -> Vector<I> {
    let step = (((word >> 27) + (127 - BIAS)) << 23).to_f32_bits();
    [
        (word & 511).to_i32().to_f32() * step,
        ((word >> 9) & 511).to_i32().to_f32() * step,
        ((word >> 18) & 511).to_i32().to_f32() * step,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use texmap_math::simd::One;

    fn back(texel: [f32; 3]) -> [f32; 3] {
        unpack(Scalar, One(pack(&texel)))
    }

    #[test]
    fn channels_are_off_by_half_a_step_of_the_brightest() {
        let mut worst = 0.0f32;
        for k in 0..40_000u16 {
            // 2^-18 to 2^20, and two darker channels.
            let most = (f32::from(k) / 40_000.0 * 37.99 - 18.0).exp2();
            let texel = [most * 0.37, most, most * 0.001];
            for (c, got) in texel.into_iter().zip(back(texel)) {
                worst = worst.max((got - c).abs() / most.max(1.0 / 2048.0));
            }
        }
        assert!(worst <= 1.0 / 512.0, "{worst}");
        // It comes near to that.
        assert!(worst > 1.0 / 540.0, "{worst}");
    }

    #[test]
    fn powers_of_two_and_the_ends_are_held_and_others_come_to_the_nearer_end() {
        for exact in [0.0, 0.25, 1.0, 2.0, 511.0, 65536.0, MOST] {
            assert_eq!(back([exact, 0.0, exact]), [exact, 0.0, exact]);
        }
        assert_eq!(back([511.6, 0.0, 1.0])[0], 512.0);
        assert_eq!(back([f32::NAN, -1.0, f32::INFINITY]), [0.0, 0.0, MOST]);
        assert_eq!(back([1e-30, f32::NEG_INFINITY, 0.0]), [0.0; 3]);
    }
}

//! Light in one word: three channels of 10 bits in steps of 1/1020. That holds raw 8-bit values, and the means of four of them, as they
//! are.

use texmap_math::simd::{Isa, prelude::*};

use crate::lanes::Vector;

/// Steps of 1.
const STEPS: f32 = 1020.0;
/// Factor of a channel of an unpacked texel.
pub(crate) const UNIT: f32 = 1.0 / STEPS;

/// True if [`pack`] loses nothing.
pub(crate) fn holds(texel: &[f32; 3]) -> bool {
    texel.iter().all(|c| {
        let step = steps(*c);
        *c >= 0.0 && *c <= 1.0 && step as f32 / STEPS == *c
    })
}

/// Rounded to the nearest step; beyond 0 to 1 to the nearer end.
pub(crate) fn pack(texel: &[f32; 3]) -> u32 {
    let [r, g, b] = texel.map(steps);
    r | g << 10 | b << 20
}

fn steps(c: f32) -> u32 {
    let c = if c < 1.0 { c } else { 1.0 };
    // Conversions give 0 for negative values and for NaN.
    (c * STEPS + 0.5) as u32
}

/// Channels in steps.
#[inline(always)]
pub(crate) fn unpack<I: Isa>(_: I, word: I::U32) -> Vector<I> {
    let [r, g, b] = [word & 1023, (word >> 10) & 1023, word >> 20];
    [
        r.to_i32().to_f32(),
        g.to_i32().to_f32(),
        b.to_i32().to_f32(),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use texmap_math::simd::{One, Scalar};

    #[test]
    fn bytes_and_means_of_four_are_held() {
        for c in 0..=1020u16 {
            let light = [f32::from(c) / 1020.0, 0.0, 1.0];
            assert!(holds(&light), "{c}");
            let [r, g, b] = unpack(Scalar, One(pack(&light)));
            assert_eq!([r, g, b], [f32::from(c), 0.0, 1020.0]);
            assert!((r * UNIT - light[0]).abs() < 1e-7, "{c}");
        }
        assert!((0..=255u8).all(|c| holds(&[f32::from(c) / 255.0; 3])));
        for other in [-0.1, 1.01, 0.3001, f32::NAN, f32::INFINITY] {
            assert!(!holds(&[0.0, other, 0.0]), "{other}");
        }
        // Half a step off at most.
        let light = [0.123, 0.777, 0.5004];
        let back = unpack(Scalar, One(pack(&light))).map(|c| c * UNIT);
        assert!((0..3).all(|i| (light[i] - back[i]).abs() <= 0.5001 * UNIT));
    }
}

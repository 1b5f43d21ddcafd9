//! Level of detail from derivatives.

use crate::texels::Level;
use texmap_math::footprint::Footprint;

/// Derivatives in texels of level 0 per pixel, all finite.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TexelFootprint {
    pub(crate) ux: f32,
    pub(crate) vx: f32,
    pub(crate) uy: f32,
    pub(crate) vy: f32,
}

/// Derivatives are cut at 2^30 texels, so that their fourth powers stay finite.
pub(crate) const LIMIT: f32 = 1_073_741_824.0;

impl TexelFootprint {
    pub(crate) fn new(d: Footprint, level: &Level) -> Self {
        let (w, h) = (level.width as f32, level.height as f32);
        Self {
            ux: tame(d.du_dx * w),
            vx: tame(d.dv_dx * h),
            uy: tame(d.du_dy * w),
            vy: tame(d.dv_dy * h),
        }
    }

    /// All derivatives times a number of at most 2, whose powers stay finite too.
    pub(crate) fn times(&self, by: f32) -> Self {
        Self {
            ux: self.ux * by,
            vx: self.vx * by,
            uy: self.uy * by,
            vy: self.vy * by,
        }
    }

    /// The larger of the squared lengths of the two columns (Vulkan 1.4, "Scale Factor Operation").
    pub(crate) fn rho_max_squared(&self) -> f32 {
        let x = self.ux * self.ux + self.vx * self.vx;
        let y = self.uy * self.uy + self.vy * self.vy;
        if x > y { x } else { y }
    }
}

/// NaN to 0, the rest to +-2^30.
pub(crate) fn tame(x: f32) -> f32 {
    if x > LIMIT {
        LIMIT
    } else if x < -LIMIT {
        -LIMIT
    } else if x.is_nan() {
        0.0
    } else {
        x
    }
}

/// Below 2^-100 the logarithm stops: such a footprint is magnified by any measure.
pub(crate) const TINY: f32 = 7.888_609e-31;

/// log2 of a positive finite number within 1e-5: the exponent plus a polynomial of the mantissa.
pub(crate) fn log2(x: f32) -> f32 {
    let bits = if x > TINY {
        x.to_bits()
    } else {
        TINY.to_bits()
    };
    let exponent = (bits >> 23) as i32 - 127;
    let t = f32::from_bits(bits & 0x007f_ffff | 0x3f80_0000) - 1.0;
    let [c0, c1, c2, c3, c4, c5] = LOG2_POLYNOMIAL;
    exponent as f32 + t * (c0 + t * (c1 + t * (c2 + t * (c3 + t * (c4 + t * c5)))))
}

/// log2(1 + t) / t on [0, 1], interpolated at Chebyshev nodes; error 8e-6.
pub(crate) const LOG2_POLYNOMIAL: [f32; 6] = [
    1.442_681_4,
    -0.720_358_8,
    0.468_658_86,
    -0.301_638,
    0.144_471_1,
    -0.033_822_045,
];

/// 256 log2(sqrt(x)) as an integer by reading the float's bits; error at most 0.043 levels.
pub(crate) fn log2_sqrt_fixed(x: f32) -> i32 {
    let bits = if x > TINY {
        x.to_bits()
    } else {
        TINY.to_bits()
    };
    (bits as i32 - 0x3f80_0000) >> 16
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn logarithms_keep_their_bounds() {
        let mut x = 1e-20_f32;
        while x < 1e20 {
            let truth = f64::from(x).log2();
            assert!((f64::from(log2(x)) - truth).abs() < 2e-5, "{x}");
            let fixed = f64::from(log2_sqrt_fixed(x)) / 256.0;
            assert!((fixed - truth / 2.0).abs() < 0.048, "{x} {fixed}");
            x *= 1.01;
        }
        assert_eq!(log2(8.0), 3.0);
        assert!(log2(f32::NAN) < -99.0 && log2(0.0) < -99.0);
    }
}

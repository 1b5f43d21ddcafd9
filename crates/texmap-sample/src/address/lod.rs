//! Level of detail from derivatives.

use crate::{bound_texture::BoundTexture, sampler::Precision};
use texmap_math::{
    footprint::Footprint,
    simd::{Isa, Scalar, prelude::*},
};

/// Derivatives in texels of level 0 per pixel, all finite.
#[derive(Clone, Copy, Debug)]
pub struct TexelFootprint<I: Isa> {
    pub(crate) ux: I::F32,
    pub(crate) vx: I::F32,
    pub(crate) uy: I::F32,
    pub(crate) vy: I::F32,
}

/// Derivatives are cut at 2^30 texels, so that their fourth powers stay finite.
const LIMIT: f32 = 1_073_741_824.0;

impl TexelFootprint<Scalar> {
    /// Of one look-up.
    #[inline(always)]
    pub(crate) fn of(view: &BoundTexture<'_>, d: Footprint) -> Self {
        Self::new(Scalar, view, d.du_dx, d.dv_dx, d.du_dy, d.dv_dy)
    }
}

impl<I: Isa> TexelFootprint<I> {
    /// From derivatives of uv; NaN reads as 0.
    #[inline(always)]
    pub fn new(
        i: I,
        view: &BoundTexture<'_>,
        ux: I::F32,
        vx: I::F32,
        uy: I::F32,
        vy: I::F32,
    ) -> Self {
        let (w, h) = view.size();
        let (w, h) = (w as f32, h as f32);
        let (ux, vx, uy, vy) = (ux * w, vx * h, uy * w, vy * h);
        // One test for all four: the sum is NaN or large where any of them is.
        let sum = (ux * ux + vx * vx) + (uy * uy + vy * vy);
        if sum.simd_lt(LIMIT).all_true() {
            return Self { ux, vx, uy, vy };
        }
        Self {
            ux: tame(i, ux),
            vx: tame(i, vx),
            uy: tame(i, uy),
            vy: tame(i, vy),
        }
    }

    /// All derivatives times a number of at most 2, whose powers stay finite too.
    #[inline(always)]
    pub(crate) fn times(&self, by: f32) -> Self {
        Self {
            ux: self.ux * by,
            vx: self.vx * by,
            uy: self.uy * by,
            vy: self.vy * by,
        }
    }

    /// The larger of the squared lengths of the two columns (Vulkan 1.4, "Scale Factor Operation").
    #[inline(always)]
    pub(crate) fn rho_max_squared(&self) -> I::F32 {
        let x = self.ux * self.ux + self.vx * self.vx;
        let y = self.uy * self.uy + self.vy * self.vy;
        x.above(y)
    }
}

/// NaN to 0, the rest to +-2^30.
#[inline(always)]
pub(crate) fn tame<I: Isa>(i: I, x: I::F32) -> I::F32 {
    let x = x.simd_eq(x).select(x, i.f32(0.0));
    let x = x.simd_gt(LIMIT).select(i.f32(LIMIT), x);
    x.simd_lt(-LIMIT).select(i.f32(-LIMIT), x)
}

/// Bias and limits of levels of detail.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LodRange {
    pub(crate) bias: f32,
    pub(crate) min: f32,
    pub(crate) max: f32,
}

impl LodRange {
    /// A level that is a number, with bias and limits; those that are NaN limit nothing.
    #[inline(always)]
    pub(crate) fn limit<I: Isa>(&self, i: I, lod: I::F32) -> I::F32 {
        let lod = lod + self.bias;
        let lod = lod.simd_lt(self.min).select(i.f32(self.min), lod);
        lod.simd_gt(self.max).select(i.f32(self.max), lod)
    }
}

/// The level of detail of a footprint by the view's precision, limited.
#[inline(always)]
pub fn lod<I: Isa>(i: I, view: &BoundTexture<'_>, d: &TexelFootprint<I>) -> I::F32 {
    view.lod_range.limit(i, unlimited_lod(i, view, d))
}

/// The level of detail of a footprint by the view's precision.
#[inline(always)]
pub(crate) fn unlimited_lod<I: Isa>(
    i: I,
    view: &BoundTexture<'_>,
    d: &TexelFootprint<I>,
) -> I::F32 {
    let rho2 = d.rho_max_squared();
    match view.precision {
        Precision::Exact => log2(i, rho2) * 0.5,
        Precision::Fast => log2_sqrt_fixed(i, rho2).to_f32() * (1.0 / 256.0),
    }
}

/// A squared length that is below 1 by more than the errors of both logarithms.
const SURELY_MAGNIFIED: f32 = 0.99;

/// True if [`lod`] is surely 0 or less in all lanes.
#[inline(always)]
pub(crate) fn is_magnified<I: Isa>(view: &BoundTexture<'_>, d: &TexelFootprint<I>) -> bool {
    view.plain_lod && d.rho_max_squared().simd_lt(SURELY_MAGNIFIED).all_true()
}

/// Below 2^-100 the logarithm stops: such a footprint is magnified by any measure.
const TINY: f32 = 7.888_609e-31;

/// log2 of a positive finite number within 1e-5: the exponent plus a polynomial of the mantissa.
#[inline(always)]
pub(crate) fn log2<I: Isa>(i: I, x: I::F32) -> I::F32 {
    let bits = x.above(i.f32(TINY)).to_bits();
    let exponent = ((bits >> 23).to_i32() - 127).to_f32();
    let mantissa = ((bits & 0x007f_ffff) | 0x3f80_0000).to_f32_bits();
    let t = mantissa - 1.0;
    let [c0, c1, c2, c3, c4, c5] = LOG2_POLYNOMIAL;
    let q = t * c5 + c4;
    let q = t * q + c3;
    let q = t * q + c2;
    let q = t * q + c1;
    let q = t * q + c0;
    exponent + t * q
}

/// log2(1 + t) / t on [0, 1], interpolated at Chebyshev nodes; error 8e-6.
const LOG2_POLYNOMIAL: [f32; 6] = [
    1.442_681_4,
    -0.720_358_8,
    0.468_658_86,
    -0.301_638,
    0.144_471_1,
    -0.033_822_045,
];

/// 256 log2(sqrt(x)) as an integer by reading the float's bits; error at most 0.043 levels.
#[inline(always)]
pub(crate) fn log2_sqrt_fixed<I: Isa>(i: I, x: I::F32) -> I::I32 {
    (x.above(i.f32(TINY)).to_bits().to_i32() - 0x3f80_0000) >> 16
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn logarithms_keep_their_bounds() {
        let mut x = 1e-20_f32;
        while x < 1e20 {
            let truth = f64::from(x).log2();
            assert!((f64::from(log2(Scalar, x)) - truth).abs() < 2e-5, "{x}");
            let fixed = f64::from(log2_sqrt_fixed(Scalar, x).0) / 256.0;
            assert!((fixed - truth / 2.0).abs() < 0.048, "{x} {fixed}");
            x *= 1.01;
        }
        assert_eq!(log2(Scalar, 8.0), 3.0);
        assert!(log2(Scalar, SURELY_MAGNIFIED) < 0.0);
        assert!(log2_sqrt_fixed(Scalar, SURELY_MAGNIFIED).0 < 0);
        assert!(log2(Scalar, f32::NAN) < -99.0 && log2(Scalar, 0.0) < -99.0);
    }
}

//! Pixels of triangles that f32 planes do not serve.

use texmap_math::simd::{Isa, Scalar, prelude::*};

use super::TriangleSetup;

/// [`TriangleSetup::evaluate`] in f64.
pub(crate) struct WidePixels<'t, I: Isa> {
    i: I,
    setup: &'t TriangleSetup,
    /// Pixel centres from the origin.
    at: [I::F64; 2],
    inv_w: I::F64,
    w: I::F64,
}

impl<'t, I: Isa> WidePixels<'t, I> {
    #[inline(always)]
    pub(crate) fn new(i: I, setup: &'t TriangleSetup, at: [I::F64; 2]) -> Self {
        let inv_w = setup.w.clamp(i, setup.w.at(i, at[0], at[1]));
        Self {
            i,
            setup,
            at,
            inv_w,
            w: i.f64(1.0) / inv_w,
        }
    }

    #[inline(always)]
    pub(crate) fn inv_w(&self) -> I::F32 {
        self.i.narrow(self.inv_w)
    }

    /// An attribute, and if `D` its change to the right and down; `None` for one that the triangle lacks.
    #[inline(always)]
    pub(crate) fn attribute<const D: bool>(&self, k: usize) -> Option<[I::F32; 3]> {
        let (i, setup) = (self.i, self.setup);
        let p = setup.attributes[..setup.count].get(k)?;
        let ([pa, pb, _], [wa, wb, _]) = (p.plane, setup.w.plane);
        let value = p.at(i, self.at[0], self.at[1]);
        if setup.is_linear(k) {
            let [_, _, _, lo, hi] = p.coefficients(i);
            let [dx, dy] = [finite(Scalar, pa) as f32, finite(Scalar, pb) as f32];
            return Some([i.narrow(value).clamp(lo, hi), i.f32(dx), i.f32(dy)]);
        }
        let u = p.clamp(i, value * self.w);
        if !D {
            return Some([i.narrow(u); 3]);
        }
        let dx = finite(i, (i.f64(pa) - u * wa) * self.w);
        let dy = finite(i, (i.f64(pb) - u * wb) * self.w);
        Some([i.narrow(u), i.narrow(dx), i.narrow(dy)])
    }
}

/// Within f32: derivatives may exceed it at a horizon.
#[inline(always)]
pub(super) fn finite<I: Isa>(i: I, v: I::F64) -> I::F64 {
    let largest = i.f64(f64::from(f32::MAX));
    bound(v, -largest, largest)
}

/// `v` within `lo..=hi`; NaN gives `lo`.
#[inline(always)]
pub(super) fn bound<M: Mask + Select<F>, F: Float<f64, M>>(v: F, lo: F, hi: F) -> F {
    let v = v.simd_gt(lo).select(v, lo);
    v.simd_lt(hi).select(v, hi)
}

//! Blocks of one triangle that f32 planes cannot serve.

use texmap_math::fearless_simd::{Simd, f32x16, f64x8, prelude::*};

use super::centres;
use crate::setup::{Ranged, TriangleSetup};

/// [`TriangleSetup::evaluate`] in f64 for a block of one triangle.
pub(super) struct Wide<'t, S: Simd> {
    s: S,
    setup: &'t TriangleSetup,
    x: [f64x8<S>; 2],
    y: [f64x8<S>; 2],
    w: [f64x8<S>; 2],
    r: [f64x8<S>; 2],
}

impl<'t, S: Simd> Wide<'t, S> {
    #[inline(always)]
    pub(super) fn new(s: S, setup: &'t TriangleSetup, block: u16) -> Self {
        let [px, py] = centres(s, block);
        let ((x0, x1), (y0, y1)) = (px.widen(), py.widen());
        let (w, _) = setup.planes();
        let (w0, w1) = (wide_at(s, w, x0, y0), wide_at(s, w, x1, y1));
        let (w0, w1) = (wide_clamp(s, w, w0), wide_clamp(s, w, w1));
        let one = f64x8::splat(s, 1.0);
        Self {
            s,
            setup,
            x: [x0, x1],
            y: [y0, y1],
            w: [w0, w1],
            r: [one / w0, one / w1],
        }
    }

    #[inline(always)]
    pub(super) fn inv_w(&self) -> f32x16<S> {
        self.s.narrow_f64x8(self.w[0], self.w[1])
    }

    /// An attribute, and if `D` its change to the right and down; `None` for one that the triangle lacks.
    #[inline(always)]
    pub(super) fn attribute<const D: bool>(&self, k: usize) -> Option<[f32x16<S>; 3]> {
        let (s, [x0, x1], [y0, y1], [r0, r1]) = (self.s, self.x, self.y, self.r);
        let (w, attributes) = self.setup.planes();
        let p = attributes.get(k)?;
        let u0 = wide_clamp(s, p, wide_at(s, p, x0, y0) * r0);
        let u1 = wide_clamp(s, p, wide_at(s, p, x1, y1) * r1);
        let u = s.narrow_f64x8(u0, u1);
        if !D {
            return Some([u; 3]);
        }
        let (pa, pb, wa, wb) = (p.plane.a, p.plane.b, w.plane.a, w.plane.b);
        let dx = s.narrow_f64x8(wide_slope(s, pa, wa, u0, r0), wide_slope(s, pa, wa, u1, r1));
        let dy = s.narrow_f64x8(wide_slope(s, pb, wb, u0, r0), wide_slope(s, pb, wb, u1, r1));
        Some([u, dx, dy])
    }
}

#[inline(always)]
fn wide_at<S: Simd>(s: S, p: &Ranged, x: f64x8<S>, y: f64x8<S>) -> f64x8<S> {
    let (a, b, c) = (
        f64x8::splat(s, p.plane.a),
        f64x8::splat(s, p.plane.b),
        f64x8::splat(s, p.plane.c),
    );
    (c + b * y) + a * x
}

#[inline(always)]
fn wide_clamp<S: Simd>(s: S, p: &Ranged, v: f64x8<S>) -> f64x8<S> {
    bound(
        v,
        f64x8::splat(s, f64::from(p.lo)),
        f64x8::splat(s, f64::from(p.hi)),
    )
}

#[inline(always)]
fn wide_slope<S: Simd>(s: S, a: f64, w: f64, u: f64x8<S>, r: f64x8<S>) -> f64x8<S> {
    let largest = f64x8::splat(s, f64::from(f32::MAX));
    bound(
        (f64x8::splat(s, a) - u * f64x8::splat(s, w)) * r,
        -largest,
        largest,
    )
}

#[inline(always)]
fn bound<S: Simd>(v: f64x8<S>, lo: f64x8<S>, hi: f64x8<S>) -> f64x8<S> {
    let v = v.simd_gt(lo).select(v, lo);
    v.simd_lt(hi).select(v, hi)
}

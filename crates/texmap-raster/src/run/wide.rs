//! Blocks of one triangle that f32 planes cannot serve.

use texmap_math::fearless_simd::{Simd, f64x8, prelude::*};

use super::{BlockValues, centres};
use crate::setup::{Ranged, TriangleSetup};

/// [`TriangleSetup::evaluate`] in f64 for a block of one triangle.
#[inline(always)]
pub(super) fn wide<S: Simd, const N: usize, const D: bool>(
    s: S,
    setup: &TriangleSetup,
    block: u16,
    wanted: &[usize; N],
    out: &mut BlockValues<S, N>,
) {
    let (px, py) = centres(s, block);
    let ((x0, x1), (y0, y1)) = (px.widen(), py.widen());
    let (w, attributes) = setup.planes();
    let (w0, w1) = (wide_at(s, w, x0, y0), wide_at(s, w, x1, y1));
    let (w0, w1) = (wide_clamp(s, w, w0), wide_clamp(s, w, w1));
    let one = f64x8::splat(s, 1.0);
    let (r0, r1) = (one / w0, one / w1);
    out.inv_w = s.narrow_f64x8(w0, w1);
    for (i, &k) in wanted.iter().enumerate() {
        let Some(p) = attributes.get(k) else {
            continue;
        };
        let u0 = wide_clamp(s, p, wide_at(s, p, x0, y0) * r0);
        let u1 = wide_clamp(s, p, wide_at(s, p, x1, y1) * r1);
        out.value[i] = s.narrow_f64x8(u0, u1);
        if !D {
            continue;
        }
        out.ddx[i] = s.narrow_f64x8(
            wide_slope(s, p.plane.a, w.plane.a, u0, r0),
            wide_slope(s, p.plane.a, w.plane.a, u1, r1),
        );
        out.ddy[i] = s.narrow_f64x8(
            wide_slope(s, p.plane.b, w.plane.b, u0, r0),
            wide_slope(s, p.plane.b, w.plane.b, u1, r1),
        );
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

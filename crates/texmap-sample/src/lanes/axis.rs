//! Wraps of sixteen coordinates; the scalar twins are in `wrap.rs`.

use super::View;
use crate::wrap::{Axis, BELOW_ONE, Wrap};
use texmap_math::{
    fearless_simd::{f32x16, i32x16, prelude::*},
    lanes::floor_to_i32,
};

/// Scalar [`Axis::place`] for sixteen.
#[inline(always)]
pub(crate) fn place<S: Simd>(
    s: S,
    view: &View<'_>,
    axis: Axis,
    u: f32x16<S>,
    units: f32x16<S>,
) -> f32x16<S> {
    match axis.wrap {
        Wrap::Repeat if axis.scaled_first => {
            let x = u * units;
            let inside = x.abs().simd_lt(f32x16::splat(s, view.reach));
            inside.select(x, fraction(s, u) * units)
        }
        Wrap::Repeat => fraction(s, u) * units,
        Wrap::MirroredRepeat => centred(s, u) * units,
        Wrap::ClampToEdge | Wrap::ClampToBorder | Wrap::MirrorClampToEdge => {
            let (low, high) = (f32x16::splat(s, -64.0), f32x16::splat(s, 65.0));
            let u = u.simd_eq(u).select(u, f32x16::splat(s, 0.0));
            let u = u.simd_gt(high).select(high, u);
            u.simd_gt(low).select(u, low) * units
        }
    }
}

/// Scalar [`Axis::index`] for sixteen, for indices that [`place`] leads to.
#[inline(always)]
pub(crate) fn index<S: Simd>(s: S, axis: Axis, i: i32x16<S>, n: i32x16<S>) -> i32x16<S> {
    let zero = i32x16::splat(s, 0);
    match axis.wrap {
        Wrap::Repeat if axis.scaled_first => i & (n - 1),
        // Fractions keep the index within a texel of 0..n.
        Wrap::Repeat => {
            let i = i.simd_lt(zero).select(i + n, i);
            i.simd_ge(n).select(i - n, i)
        }
        // Two indices beyond -n..n, which cubics reach, come back as well.
        Wrap::MirroredRepeat => {
            let i = i.simd_lt(zero).select(-1 - i, i);
            let back = n + n - 1 - i;
            let i = i.simd_lt(back).select(i, back);
            let i = i.simd_lt(zero).select(-1 - i, i);
            i.simd_lt(n).select(i, n - 1)
        }
        Wrap::ClampToEdge => {
            let i = at_least_zero(s, i);
            i.simd_lt(n).select(i, n - 1)
        }
        Wrap::ClampToBorder => {
            let inside = i.simd_lt(n) & i.simd_ge(zero);
            inside.select(i, i32x16::splat(s, crate::wrap::OUTSIDE))
        }
        Wrap::MirrorClampToEdge => {
            let i = i.simd_lt(zero).select(-1 - i, i);
            i.simd_lt(n).select(i, n - 1)
        }
    }
}

/// [`index`] of any index, however far outside.
#[inline(always)]
pub(crate) fn far_index<S: Simd>(s: S, axis: Axis, i: i32x16<S>, n: i32x16<S>) -> i32x16<S> {
    match axis.wrap {
        Wrap::Repeat if !axis.scaled_first => remainder(s, i, n),
        Wrap::MirroredRepeat => {
            let m = remainder(s, i, n + n);
            m.simd_lt(n).select(m, n + n - 1 - m)
        }
        _ => index(s, axis, i, n),
    }
}

/// `i` modulo `n`, from 0 on. Below 2^17 the quotient in f32 is on the right side of every integer.
#[inline(always)]
fn remainder<S: Simd>(s: S, i: i32x16<S>, n: i32x16<S>) -> i32x16<S> {
    i - n * floor_to_i32(s, i.to_float::<f32x16<S>>() / n.to_float::<f32x16<S>>())
}

#[inline(always)]
fn at_least_zero<S: Simd>(s: S, i: i32x16<S>) -> i32x16<S> {
    let zero = i32x16::splat(s, 0);
    i.simd_gt(zero).select(i, zero)
}

/// Scalar `centred` for sixteen.
#[inline(always)]
fn centred<S: Simd>(s: S, u: f32x16<S>) -> f32x16<S> {
    let zero = f32x16::splat(s, 0.0);
    let half = u * 0.5;
    let near = half.abs().simd_lt(f32x16::splat(s, 8_388_608.0));
    let (u, half) = (near.select(u, zero), near.select(half, zero));
    let whole = floor_to_i32(s, half).to_float::<f32x16<S>>();
    let upper = (half - whole).simd_ge(f32x16::splat(s, 0.5));
    u - upper.select(whole + 1.0, whole) * 2.0
}

#[inline(always)]
pub(super) fn fraction<S: Simd>(s: S, u: f32x16<S>) -> f32x16<S> {
    let zero = f32x16::splat(s, 0.0);
    let whole = f32x16::splat(s, 8_388_608.0);
    let u = u.abs().simd_lt(whole).select(u, zero);
    let f = u - floor_to_i32(s, u).to_float::<f32x16<S>>();
    let f = f.simd_gt(zero).select(f, zero);
    let top = f32x16::splat(s, BELOW_ONE);
    f.simd_gt(top).select(top, f)
}

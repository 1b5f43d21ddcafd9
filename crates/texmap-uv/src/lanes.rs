//! Sphere and cylinder coordinates of many vectors at once, sixteen lanes at a time.
//!
//! The f64 forms in [`crate::solid`] are the reference; scalar and lanes here give one set of bits on every SIMD
//! level, within 2e-7 of it (u by way of `atan2` of [`texmap_math::det32`]).

use core::f32::consts::{FRAC_1_PI, TAU};

use texmap_math::fearless_simd::prelude::*;
use texmap_math::fearless_simd::{dispatch, f32x16};
use texmap_math::lanes::LANES;
use texmap_math::{Level, det32, float};

use crate::{Origin, UvError};

/// Longitude and latitude of each direction, as [`crate::Shape::Sphere`]: u in (0, 1], v in [0, 1]. The lengths do
/// not matter; (0.5, 0.5) for a zero direction, u = 0.5 on the axis; NaN gives NaN.
///
/// # Errors
/// `out` of another length than `directions`.
pub fn sphere_slice(
    level: Level,
    directions: &[[f32; 3]],
    origin: Origin,
    out: &mut [[f32; 2]],
) -> Result<(), UvError> {
    check(directions, out)?;
    dispatch!(level, s => run::<_, true>(s, directions, origin, out));
    Ok(())
}

/// Longitude and height of each point, as the side of [`crate::Shape::Cylinder`]: u in (0, 1] and 0.5 on the axis,
/// v = 0.5 - y from the top or 0.5 + y from the bottom.
///
/// # Errors
/// `out` of another length than `points`.
pub fn cylinder_slice(
    level: Level,
    points: &[[f32; 3]],
    origin: Origin,
    out: &mut [[f32; 2]],
) -> Result<(), UvError> {
    check(points, out)?;
    dispatch!(level, s => run::<_, false>(s, points, origin, out));
    Ok(())
}

fn check(vectors: &[[f32; 3]], out: &[[f32; 2]]) -> Result<(), UvError> {
    if vectors.len() == out.len() {
        return Ok(());
    }
    Err(UvError::WrongLength {
        what: "the list of results",
        found: out.len(),
        expected: vectors.len(),
    })
}

#[inline(always)]
fn run<S: Simd, const SPHERE: bool>(
    s: S,
    vectors: &[[f32; 3]],
    origin: Origin,
    out: &mut [[f32; 2]],
) {
    for (vectors, out) in vectors.chunks(LANES).zip(out.chunks_mut(LANES)) {
        let (mut x, mut y, mut z) = ([1.0; LANES], [0.0; LANES], [0.0; LANES]);
        for (i, v) in vectors.iter().enumerate() {
            [x[i], y[i], z[i]] = *v;
        }
        let (x, y, z) = (
            f32x16::from_slice(s, &x),
            f32x16::from_slice(s, &y),
            f32x16::from_slice(s, &z),
        );
        let u = around_x16(s, x, z);
        let h = if SPHERE { latitude_x16(s, x, y, z) } else { y };
        let half = f32x16::splat(s, 0.5);
        let v = match origin {
            Origin::TopLeft => half - h,
            Origin::BottomLeft => half + h,
        };
        let (mut us, mut vs) = ([0.0; LANES], [0.0; LANES]);
        u.store_slice(&mut us);
        v.store_slice(&mut vs);
        for (out, (u, v)) in out.iter_mut().zip(us.into_iter().zip(vs)) {
            *out = [u, v];
        }
    }
}

/// [`crate::solid::around`] for sixteen lanes.
#[inline(always)]
fn around_x16<S: Simd>(s: S, x: f32x16<S>, z: f32x16<S>) -> f32x16<S> {
    let zero = f32x16::splat(s, 0.0);
    let turn = det32::atan2_x16(s, z, x) * f32x16::splat(s, 1.0 / TAU);
    let u = turn
        .simd_lt(zero)
        .select(zero - turn, f32x16::splat(s, 1.0) - turn);
    (x.simd_eq(zero) & z.simd_eq(zero)).select(f32x16::splat(s, 0.5), u)
}

/// [`around_x16`] for one lane.
#[inline(always)]
fn around(x: f32, z: f32) -> f32 {
    let turn = det32::atan2(z, x) * (1.0 / TAU);
    let u = if turn < 0.0 { 0.0 - turn } else { 1.0 - turn };
    if x == 0.0 && z == 0.0 { 0.5 } else { u }
}

/// Latitude over pi. The distance from the axis is scaled by its larger component: x * x alone would overflow.
#[inline(always)]
fn latitude_x16<S: Simd>(s: S, x: f32x16<S>, y: f32x16<S>, z: f32x16<S>) -> f32x16<S> {
    let (x, z) = (x.abs(), z.abs());
    let x_larger = x.simd_gt(z);
    let (large, small) = (x_larger.select(x, z), x_larger.select(z, x));
    let ratio = small
        / large
            .simd_gt(f32x16::splat(s, 0.0))
            .select(large, f32x16::splat(s, 1.0));
    let out = large * (f32x16::splat(s, 1.0) + ratio * ratio).sqrt();
    det32::atan2_x16(s, y, out) * f32x16::splat(s, FRAC_1_PI)
}

/// [`latitude_x16`] for one lane.
#[inline(always)]
fn latitude(x: f32, y: f32, z: f32) -> f32 {
    let (x, z) = (x.abs(), z.abs());
    let (large, small) = if x > z { (x, z) } else { (z, x) };
    let ratio = small / if large > 0.0 { large } else { 1.0 };
    let out = large * float::sqrt_f32(1.0 + ratio * ratio);
    det32::atan2(y, out) * FRAC_1_PI
}

/// One vector of [`sphere_slice`], the same bits.
#[must_use]
pub fn sphere_one(d: [f32; 3], origin: Origin) -> [f32; 2] {
    from_height(around(d[0], d[2]), latitude(d[0], d[1], d[2]), origin)
}

/// One point of [`cylinder_slice`], the same bits.
#[must_use]
pub fn cylinder_one(p: [f32; 3], origin: Origin) -> [f32; 2] {
    from_height(around(p[0], p[2]), p[1], origin)
}

fn from_height(u: f32, h: f32, origin: Origin) -> [f32; 2] {
    match origin {
        Origin::TopLeft => [u, 0.5 - h],
        Origin::BottomLeft => [u, 0.5 + h],
    }
}

//! Sphere and cylinder coordinates of many vectors at once, sixteen lanes at a time.
//!
//! The f64 forms in [`crate::solid`] are the reference; scalar and lanes here give one set of bits on every SIMD
//! level, within 2e-7 of it. All is f32: an arc tangent in turns needs no more, and f64 halves the lanes.

use texmap_math::fearless_simd::prelude::*;
use texmap_math::fearless_simd::{f32x4, f32x16};
use texmap_math::lanes::LANES;
use texmap_math::{Level, float, on_level};

use crate::{Origin, UvError};

/// Longitude and latitude of each direction, as [`crate::Shape::Sphere`]: u in (0, 1], v in [0, 1]. The lengths do
/// not matter; (0.5, 0.5) for a zero direction, u = 0.5 on the axis; NaN and two infinities give NaN.
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
    on_level!(level, s => run::<_, true>(s, directions, origin, out), else each(directions, origin, out, sphere_one));
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
    on_level!(level, s => run::<_, false>(s, points, origin, out), else each(points, origin, out, cylinder_one));
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

fn each(
    vectors: &[[f32; 3]],
    origin: Origin,
    out: &mut [[f32; 2]],
    one: fn([f32; 3], Origin) -> [f32; 2],
) {
    for (vector, uv) in vectors.iter().zip(out) {
        *uv = one(*vector, origin);
    }
}

#[inline(always)]
fn run<S: Simd, const SPHERE: bool>(
    s: S,
    vectors: &[[f32; 3]],
    origin: Origin,
    out: &mut [[f32; 2]],
) {
    let (full, rest) = vectors.as_chunks::<LANES>();
    let (full_out, rest_out) = out.as_chunks_mut::<LANES>();
    for (vectors, out) in full.iter().zip(full_out) {
        block::<S, SPHERE>(s, vectors, origin, out);
    }
    let (mut vectors, mut uvs) = ([[1.0, 0.0, 0.0]; LANES], [[0.0; 2]; LANES]);
    vectors[..rest.len()].copy_from_slice(rest);
    block::<S, SPHERE>(s, &vectors, origin, &mut uvs);
    rest_out.copy_from_slice(&uvs[..rest.len()]);
}

#[inline(always)]
fn block<S: Simd, const SPHERE: bool>(
    s: S,
    vectors: &[[f32; 3]; LANES],
    origin: Origin,
    out: &mut [[f32; 2]; LANES],
) {
    let [x, y, z] = components(s, vectors);
    let around = around_x16(s, x, z);
    let h = if SPHERE {
        latitude_x16(s, y, around)
    } else {
        y
    };
    let half = f32x16::splat(s, 0.5);
    let v = match origin {
        Origin::TopLeft => half - h,
        Origin::BottomLeft => half + h,
    };
    let (low, high) = s.interleave_f32x16(around.u, v);
    let (out_low, out_high) = out.as_flattened_mut().split_at_mut(LANES);
    low.store_slice(out_low);
    high.store_slice(out_high);
}

/// All x, all y and all z of sixteen vectors. Scalar stores before wide loads would stall for longer than the
/// formulae take.
#[inline(always)]
pub(crate) fn components<S: Simd>(s: S, vectors: &[[f32; 3]; LANES]) -> [f32x16<S>; 3] {
    let words = vectors.as_flattened();
    let (x0, y0, z0) = four(s, &words[..12]);
    let (x1, y1, z1) = four(s, &words[12..24]);
    let (x2, y2, z2) = four(s, &words[24..36]);
    let (x3, y3, z3) = four(s, &words[36..]);
    [
        join(s, x0, x1, x2, x3),
        join(s, y0, y1, y2, y3),
        join(s, z0, z1, z2, z3),
    ]
}

#[inline(always)]
fn join<S: Simd>(s: S, a: f32x4<S>, b: f32x4<S>, c: f32x4<S>, d: f32x4<S>) -> f32x16<S> {
    s.combine_f32x8(s.combine_f32x4(a, b), s.combine_f32x4(c, d))
}

/// The components of four vectors.
#[inline(always)]
fn four<S: Simd>(s: S, words: &[f32]) -> (f32x4<S>, f32x4<S>, f32x4<S>) {
    let a = f32x4::from_slice(s, &words[..4]);
    let b = f32x4::from_slice(s, &words[4..8]);
    let c = f32x4::from_slice(s, &words[8..12]);
    // Each round doubles the distance between what stood side by side; four words need two rounds.
    let (a, b, c) = spread(s, a, b, c);
    spread(s, a, b, c)
}

#[inline(always)]
fn spread<S: Simd>(s: S, a: f32x4<S>, b: f32x4<S>, c: f32x4<S>) -> (f32x4<S>, f32x4<S>, f32x4<S>) {
    (
        s.zip_low_f32x4(a, s.slide_f32x4::<2>(b, b)),
        s.zip_low_f32x4(s.slide_f32x4::<2>(a, a), c),
        s.zip_low_f32x4(b, s.slide_f32x4::<2>(c, c)),
    )
}

/// What longitude and latitude share.
#[derive(Clone, Copy)]
pub(crate) struct Around<T> {
    /// Longitude in turns.
    pub(crate) u: T,
    /// The larger of |x| and |z|.
    large: T,
    /// The smaller over the larger.
    ratio: T,
}

/// `atan(q) / tau` for `q` in [0, 1] is `q (C0 + C1 q^2 + ...)` within 2.5e-8 of a turn and 4.2e-7 of itself:
/// least squares reweighted until the largest error is least (Lawson 1961), exact at q = 1.
const ATAN: [f32; 8] = [
    0.159_154_89,
    -0.053_047_936,
    0.031_764_14,
    -0.022_217_924,
    0.015_535_486,
    -0.009_135_002,
    0.003_629_953_1,
    -0.000_683_608_6,
];

#[inline(always)]
fn atan_x16<S: Simd>(s: S, q: f32x16<S>) -> f32x16<S> {
    let square = q * q;
    let mut sum = f32x16::splat(s, ATAN[7]);
    for c in ATAN[..7].iter().rev() {
        sum = sum * square + f32x16::splat(s, *c);
    }
    q * sum
}

/// [`atan_x16`] for one lane.
#[inline(always)]
fn atan(q: f32) -> f32 {
    let square = q * q;
    let mut sum = ATAN[7];
    for c in ATAN[..7].iter().rev() {
        sum = sum * square + c;
    }
    q * sum
}

/// [`crate::solid::around`] for sixteen lanes.
#[inline(always)]
pub(crate) fn around_x16<S: Simd>(s: S, x: f32x16<S>, z: f32x16<S>) -> Around<f32x16<S>> {
    let splat = |c: f32| f32x16::splat(s, c);
    let zero = splat(0.0);
    let (ax, az) = (x.abs(), z.abs());
    let steep = az.simd_gt(ax);
    let (large, small) = (steep.select(az, ax), steep.select(ax, az));
    let on_axis = large.simd_eq(zero);
    let ratio = small / on_axis.select(splat(1.0), large);
    let turn = atan_x16(s, ratio);
    let turn = steep.select(splat(0.25) - turn, turn);
    let turn = x.simd_lt(zero).select(splat(0.5) - turn, turn);
    // u falls as the angle rises: 1 - turn in front, where z > 0, and the turn itself behind.
    let behind = z.simd_lt(zero) & turn.simd_gt(zero);
    let u = behind.select(turn, splat(1.0) - turn);
    Around {
        u: on_axis.select(splat(0.5), u),
        large,
        ratio,
    }
}

/// [`around_x16`] for one lane.
#[inline(always)]
pub(crate) fn around(x: f32, z: f32) -> Around<f32> {
    let (ax, az) = (x.abs(), z.abs());
    let steep = az > ax;
    let (large, small) = if steep { (az, ax) } else { (ax, az) };
    let on_axis = large == 0.0;
    let ratio = small / if on_axis { 1.0 } else { large };
    let turn = atan(ratio);
    let turn = if steep { 0.25 - turn } else { turn };
    let turn = if x < 0.0 { 0.5 - turn } else { turn };
    let behind = z < 0.0 && turn > 0.0;
    let u = if behind { turn } else { 1.0 - turn };
    Around {
        u: if on_axis { 0.5 } else { u },
        large,
        ratio,
    }
}

/// Above this a diagonal could overflow; what is lost by making such vectors smaller is far below their rounding.
const HUGE: f32 = 1e30;

/// Latitude over pi. The distance from the axis comes from the ratio that the longitude has: x * x could overflow.
#[inline(always)]
pub(crate) fn latitude_x16<S: Simd>(s: S, y: f32x16<S>, around: Around<f32x16<S>>) -> f32x16<S> {
    let splat = |c: f32| f32x16::splat(s, c);
    let Around { large, ratio, .. } = around;
    let scale = large.simd_gt(splat(HUGE)).select(splat(0.25), splat(1.0));
    let out = large * scale * (splat(1.0) + ratio * ratio).sqrt();
    let up = y.abs() * scale;
    let steep = up.simd_gt(out);
    let (large, small) = (steep.select(up, out), steep.select(out, up));
    let half_turns = atan_x16(
        s,
        small / large.simd_eq(splat(0.0)).select(splat(1.0), large),
    ) * 2.0;
    let half_turns = steep.select(splat(0.5) - half_turns, half_turns);
    y.simd_lt(splat(0.0))
        .select(splat(0.0) - half_turns, half_turns)
}

/// [`latitude_x16`] for one lane.
#[inline(always)]
pub(crate) fn latitude(y: f32, around: Around<f32>) -> f32 {
    let Around { large, ratio, .. } = around;
    let scale = if large > HUGE { 0.25 } else { 1.0 };
    let out = large * scale * float::sqrt_f32(1.0 + ratio * ratio);
    let up = y.abs() * scale;
    let steep = up > out;
    let (large, small) = if steep { (up, out) } else { (out, up) };
    let half_turns = atan(small / if large == 0.0 { 1.0 } else { large }) * 2.0;
    let half_turns = if steep { 0.5 - half_turns } else { half_turns };
    if y < 0.0 {
        0.0 - half_turns
    } else {
        half_turns
    }
}

/// One vector of [`sphere_slice`], the same bits.
#[must_use]
pub fn sphere_one(d: [f32; 3], origin: Origin) -> [f32; 2] {
    let around = around(d[0], d[2]);
    from_height(around.u, latitude(d[1], around), origin)
}

/// One point of [`cylinder_slice`], the same bits.
#[must_use]
pub fn cylinder_one(p: [f32; 3], origin: Origin) -> [f32; 2] {
    from_height(around(p[0], p[2]).u, p[1], origin)
}

fn from_height(u: f32, h: f32, origin: Origin) -> [f32; 2] {
    match origin {
        Origin::TopLeft => [u, 0.5 - h],
        Origin::BottomLeft => [u, 0.5 + h],
    }
}

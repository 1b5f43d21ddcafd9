//! Sphere and cylinder coordinates of many vectors at once.
//!
//! The f64 forms in [`crate::solid`] are the reference; all lane widths give the same bits, within 2e-7 of it. All is f32: an arc
//! tangent in turns needs no more, and f64 halves the lanes.

use texmap_math::simd::{Isa, Scalar, prelude::*};
use texmap_math::{Level, dispatch_simd};

use crate::{Origin, UvError};

/// Longitude and latitude of each direction, as [`crate::Shape::Sphere`]: u in (0, 1], v in [0, 1]. The lengths do
/// not matter; (0.5, 0.5) for a zero direction, u = 0.5 on the axis; NaN and two infinities give NaN.
///
/// # Errors
/// `out` of another length than `directions`.
pub fn sphere_uv_batch(
    level: Level,
    directions: &[[f32; 3]],
    origin: Origin,
    out: &mut [[f32; 2]],
) -> Result<(), UvError> {
    check(directions, out)?;
    dispatch_simd!(level, wide i => run::<_, true>(i, directions, origin, out));
    Ok(())
}

/// Longitude and height of each point, as the side of [`crate::Shape::Cylinder`]: u in (0, 1] and 0.5 on the axis,
/// v = 0.5 - y from the top or 0.5 + y from the bottom.
///
/// # Errors
/// `out` of another length than `points`.
pub fn cylinder_uv_batch(
    level: Level,
    points: &[[f32; 3]],
    origin: Origin,
    out: &mut [[f32; 2]],
) -> Result<(), UvError> {
    check(points, out)?;
    dispatch_simd!(level, wide i => run::<_, false>(i, points, origin, out));
    Ok(())
}

/// One vector of [`sphere_uv_batch`], the same bits.
#[must_use]
pub fn sphere_uv_at(d: [f32; 3], origin: Origin) -> [f32; 2] {
    coordinates::<Scalar, true>(Scalar, d, origin)
}

/// One point of [`cylinder_uv_batch`], the same bits.
#[must_use]
pub fn cylinder_uv_at(p: [f32; 3], origin: Origin) -> [f32; 2] {
    coordinates::<Scalar, false>(Scalar, p, origin)
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

/// Most lanes of an [`Isa`].
pub(crate) const MAX_LANES: usize = 16;

#[inline(always)]
fn run<I: Isa, const SPHERE: bool>(
    i: I,
    vectors: &[[f32; 3]],
    origin: Origin,
    out: &mut [[f32; 2]],
) {
    let full = vectors.len() / I::LANES * I::LANES;
    let ((vectors, rest), (out, rest_out)) = (vectors.split_at(full), out.split_at_mut(full));
    for (vectors, out) in vectors
        .chunks_exact(I::LANES)
        .zip(out.chunks_exact_mut(I::LANES))
    {
        batch::<I, SPHERE>(i, vectors, origin, out);
    }
    let (mut vectors, mut uvs) = ([[1.0, 0.0, 0.0]; MAX_LANES], [[0.0; 2]; MAX_LANES]);
    vectors[..rest.len()].copy_from_slice(rest);
    batch::<I, SPHERE>(i, &vectors, origin, &mut uvs);
    rest_out.copy_from_slice(&uvs[..rest.len()]);
}

/// The first [`LANES`](Isa::LANES) vectors.
#[inline(always)]
fn batch<I: Isa, const SPHERE: bool>(
    i: I,
    vectors: &[[f32; 3]],
    origin: Origin,
    out: &mut [[f32; 2]],
) {
    let [u, v] = coordinates::<I, SPHERE>(i, i.load_xyz(vectors), origin);
    let [low, high] = i.interleave(u.to_bits(), v.to_bits());
    let (out_low, out_high) = out.as_flattened_mut().split_at_mut(I::LANES);
    low.to_f32_bits().store(out_low);
    high.to_f32_bits().store(out_high);
}

#[inline(always)]
fn coordinates<I: Isa, const SPHERE: bool>(
    i: I,
    [x, y, z]: [I::F32; 3],
    origin: Origin,
) -> [I::F32; 2] {
    let longitude = Longitude::of(i, x, z);
    let height = if SPHERE { longitude.latitude(i, y) } else { y };
    let v = match origin {
        Origin::TopLeft => i.f32(0.5) - height,
        Origin::BottomLeft => i.f32(0.5) + height,
    };
    [longitude.turns, v]
}

/// Longitude, and the part of it that latitude shares.
#[derive(Clone, Copy)]
pub(crate) struct Longitude<I: Isa> {
    /// In (0, 1], 0.5 on the axis.
    pub(crate) turns: I::F32,
    /// The larger of |x| and |z|.
    large: I::F32,
    /// The smaller over the larger.
    ratio: I::F32,
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
fn atan_turns<I: Isa>(i: I, q: I::F32) -> I::F32 {
    let square = q * q;
    let mut sum = i.f32(ATAN[7]);
    for c in ATAN[..7].iter().rev() {
        sum = sum * square + *c;
    }
    q * sum
}

/// Above this a diagonal could overflow; what is lost by making such vectors smaller is far below their rounding.
const HUGE: f32 = 1e30;

impl<I: Isa> Longitude<I> {
    /// [`crate::solid::around`] in f32.
    #[inline(always)]
    pub(crate) fn of(i: I, x: I::F32, z: I::F32) -> Self {
        let (ax, az) = (x.abs(), z.abs());
        let steep = az.simd_gt(ax);
        let (large, small) = (steep.select(az, ax), steep.select(ax, az));
        let on_axis = large.simd_eq(0.0);
        let ratio = small / on_axis.select(i.f32(1.0), large);
        let turn = atan_turns(i, ratio);
        let turn = steep.select(i.f32(0.25) - turn, turn);
        let turn = x.simd_lt(0.0).select(i.f32(0.5) - turn, turn);
        // u falls as the angle rises: 1 - turn in front, where z > 0, and the turn itself behind.
        let behind = z.simd_lt(0.0) & turn.simd_gt(0.0);
        let u = behind.select(turn, i.f32(1.0) - turn);
        Self {
            turns: on_axis.select(i.f32(0.5), u),
            large,
            ratio,
        }
    }

    /// Latitude over pi. The distance from the axis comes from the ratio that the longitude has: x * x could overflow.
    #[inline(always)]
    pub(crate) fn latitude(&self, i: I, y: I::F32) -> I::F32 {
        let Self { large, ratio, .. } = *self;
        let scale = large.simd_gt(HUGE).select(i.f32(0.25), i.f32(1.0));
        let out = large * scale * (ratio * ratio + 1.0).sqrt();
        let up = y.abs() * scale;
        let steep = up.simd_gt(out);
        let (large, small) = (steep.select(up, out), steep.select(out, up));
        let divisor = large.simd_eq(0.0).select(i.f32(1.0), large);
        let half_turns = atan_turns(i, small / divisor) * 2.0;
        let half_turns = steep.select(i.f32(0.5) - half_turns, half_turns);
        y.simd_lt(0.0).select(i.f32(0.0) - half_turns, half_turns)
    }
}

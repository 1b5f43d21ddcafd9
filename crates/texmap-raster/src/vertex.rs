//! Object space to homogeneous pixels and to 1/256 pixel, one vertex or sixteen at a time.
use alloc::vec::Vec;

use texmap_math::Level;
use texmap_math::fearless_simd::{Simd, f32x16, f64x8, i32x16, mask64x8, prelude::*, u32x16};
use texmap_math::glam::DMat4;
use texmap_math::lanes::{LANES, Words, gather_triples, iota};
use texmap_math::on_level;

use crate::clip::{GUARD_BAND, Hom};
use crate::edge::{Snapped, snap};
use crate::{Draw, TargetSize};

/// Stands for a vertex that cannot be taken as it is: behind the eye, outside the depth range or the guard band, not finite,
/// or with a w so extreme that only the whole triangle can tell.
pub(crate) const SPECIAL: Snapped = [i32::MIN; 2];

/// Between these the ratio of two w stays below what a triangle is cut for.
const W_RANGE: [f64; 2] = [1.0 / (1 << 20) as f64, (1 << 20) as f64];

/// Vertices a unit of work.
pub(crate) const CHUNK: usize = 4096;

/// A draw's matrix with the target's size folded in.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Transform {
    /// Rows of the clip matrix.
    rows: [[f64; 4]; 4],
    half: [f64; 2],
}

impl Transform {
    pub(crate) fn new(clip_from_object: &DMat4, size: TargetSize) -> Self {
        Self {
            rows: clip_from_object.transpose().to_cols_array_2d(),
            half: [
                0.5 * f64::from(size.width()),
                0.5 * f64::from(size.height()),
            ],
        }
    }

    pub(crate) fn apply(&self, position: [f32; 3]) -> Hom {
        let [x, y, z] = position.map(f64::from);
        let row = |m: &[f64; 4]| (m[0] * x + m[1] * y) + (m[2] * z + m[3]);
        let [cx, cy, cz, cw] = [0, 1, 2, 3].map(|i| row(&self.rows[i]));
        Hom {
            x: (cx + cw) * self.half[0],
            y: (cw - cy) * self.half[1],
            z: cz,
            w: cw,
        }
    }

    /// [`apply`](Self::apply) for eight positions.
    #[inline(always)]
    pub(crate) fn apply_x8<S: Simd>(&self, s: S, [x, y, z]: [f64x8<S>; 3]) -> [f64x8<S>; 4] {
        let [cx, cy, cz, cw] = [
            row_x8(s, &self.rows[0], x, y, z),
            row_x8(s, &self.rows[1], x, y, z),
            row_x8(s, &self.rows[2], x, y, z),
            row_x8(s, &self.rows[3], x, y, z),
        ];
        [(cx + cw) * self.half[0], (cw - cy) * self.half[1], cz, cw]
    }
}

#[inline(always)]
fn row_x8<S: Simd>(s: S, m: &[f64; 4], x: f64x8<S>, y: f64x8<S>, z: f64x8<S>) -> f64x8<S> {
    let m = [
        f64x8::splat(s, m[0]),
        f64x8::splat(s, m[1]),
        f64x8::splat(s, m[2]),
        f64x8::splat(s, m[3]),
    ];
    (m[0] * x + m[1] * y) + (m[2] * z + m[3])
}

/// The snapped position of a vertex that can be taken as it is, else [`SPECIAL`].
fn snap_or_special(p: Hom) -> Snapped {
    let limit = GUARD_BAND * p.w;
    let plain = p.w >= W_RANGE[0]
        && p.w <= W_RANGE[1]
        && p.z >= 0.0
        && p.z <= p.w
        && p.x + limit >= 0.0
        && limit - p.x >= 0.0
        && p.y + limit >= 0.0
        && limit - p.y >= 0.0;
    if plain { snap(p) } else { SPECIAL }
}

/// Snapped positions of `positions`, the plain way.
pub(crate) fn snap_all_scalar(positions: &[[f32; 3]], transform: &Transform, out: &mut [Snapped]) {
    for (slot, &position) in out.iter_mut().zip(positions) {
        *slot = snap_or_special(transform.apply(position));
    }
}

/// [`snap_all_scalar`], sixteen at a time.
pub(crate) fn snap_all(
    level: Level,
    positions: &[[f32; 3]],
    transform: &Transform,
    out: &mut [Snapped],
) {
    on_level!(level, s => snap_lanes(s, positions, transform, out), else snap_all_scalar(positions, transform, out));
}

#[inline(always)]
fn snap_lanes<S: Simd>(s: S, positions: &[[f32; 3]], transform: &Transform, out: &mut [Snapped]) {
    let Some(words) = Words::new(bytemuck::cast_slice(positions)) else {
        return;
    };
    let mut snapped = [[0; 2]; LANES];
    for (k, chunk) in out.chunks_mut(LANES).enumerate() {
        let base: u32x16<S> = ((iota(s) + (k * LANES) as i32) * 3).bitcast();
        let [x, y, z] = gather_triples(s, words, base);
        let position = [
            x.bitcast::<f32x16<S>>().widen(),
            y.bitcast::<f32x16<S>>().widen(),
            z.bitcast::<f32x16<S>>().widen(),
        ];
        let low = transform.apply_x8(s, [position[0].0, position[1].0, position[2].0]);
        let high = transform.apply_x8(s, [position[0].1, position[1].1, position[2].1]);
        let (lx, ly) = snap_x8(s, low);
        let (hx, hy) = snap_x8(s, high);
        // Integers below 2^24 pass through f32 unchanged.
        let (low, high) = s.interleave_i32x16(to_i32(s, lx, hx), to_i32(s, ly, hy));
        let (low_of, high_of) = snapped.as_flattened_mut().split_at_mut(LANES);
        low.store_slice(low_of);
        high.store_slice(high_of);
        chunk.copy_from_slice(&snapped[..chunk.len()]);
    }
}

/// Sixteen integers in f64; below -2^24 stands for [`SPECIAL`].
#[inline(always)]
fn to_i32<S: Simd>(s: S, low: f64x8<S>, high: f64x8<S>) -> i32x16<S> {
    let v = s.narrow_f64x8(low, high).to_int::<i32x16<S>>();
    v.simd_lt(-(1 << 24)).select(i32x16::splat(s, i32::MIN), v)
}

/// The snapped position as whole numbers in f64, below -2^24 where special.
#[inline(always)]
fn snap_x8<S: Simd>(s: S, [x, y, z, w]: [f64x8<S>; 4]) -> (f64x8<S>, f64x8<S>) {
    let limit = w * GUARD_BAND;
    let plain: mask64x8<S> = w.simd_ge(W_RANGE[0])
        & w.simd_le(W_RANGE[1])
        & z.simd_ge(0.0)
        & z.simd_le(w)
        & (x + limit).simd_ge(0.0)
        & (limit - x).simd_ge(0.0)
        & (y + limit).simd_ge(0.0)
        & (limit - y).simd_ge(0.0);
    // The divisor of special lanes is replaced, so that no lane holds a NaN.
    let one = f64x8::splat(s, 1.0);
    let divisor = plain.select(w, one);
    let special = f64x8::splat(s, -(1_i64 << 30) as f64);
    let (x, y) = (round_x8(s, x / divisor), round_x8(s, y / divisor));
    (plain.select(x, special), plain.select(y, special))
}

/// Pixels to the nearest 1/256, halves up, as whole numbers.
#[inline(always)]
fn round_x8<S: Simd>(s: S, v: f64x8<S>) -> f64x8<S> {
    // Adding and taking away 1.5 * 2^52 rounds to a whole number, to the even one at a half; then down where that went up.
    const WHOLE: f64 = 1.5 * (1u64 << 52) as f64;
    let shifted = v * 256.0 + 0.5;
    let near = (shifted + WHOLE) - WHOLE;
    let zero = f64x8::splat(s, 0.0);
    near - near.simd_gt(shifted).select(f64x8::splat(s, 1.0), zero)
}

/// Marks the vertices that have a NaN or infinite attribute.
pub(crate) fn mark_bad_attributes(level: Option<Level>, draw: &Draw<'_>, snapped: &mut [Snapped]) {
    let n = draw.attribute_count;
    if n == 0 {
        return;
    }
    let all_finite = match level {
        Some(level) => {
            on_level!(level, s => all_finite(s, draw.attributes), else draw.attributes.iter().all(|v| v.is_finite()))
        }
        None => draw.attributes.iter().all(|v| v.is_finite()),
    };
    if all_finite {
        return;
    }
    for (slot, values) in snapped.iter_mut().zip(draw.attributes.chunks_exact(n)) {
        if !values.iter().all(|v| v.is_finite()) {
            *slot = SPECIAL;
        }
    }
}

#[inline(always)]
fn all_finite<S: Simd>(s: S, values: &[f32]) -> bool {
    let (chunks, rest) = values.as_chunks::<LANES>();
    // A finite value times zero is zero; a NaN or an infinity is not, and stays in the sum.
    let mut sum = f32x16::splat(s, 0.0);
    for chunk in chunks {
        sum += f32x16::from_slice(s, chunk) * 0.0;
    }
    sum.simd_eq(0.0).all_true() && rest.iter().all(|v| v.is_finite())
}

/// Room for the snapped vertices of a draw.
pub(crate) fn room(draw: &Draw<'_>) -> Vec<Snapped> {
    alloc::vec![SPECIAL; draw.positions.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lanes_snap_as_the_scalar_does() {
        let size = TargetSize::new(640, 480).unwrap();
        let mut state = 1u32;
        let mut next = || {
            state = state.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
            (state >> 8) as f32 / (1 << 24) as f32 - 0.5
        };
        let mut positions: Vec<[f32; 3]> = (0..4001)
            .map(|i| {
                let size = [1.0, 30.0, 1e4, 1e9, 0.01][i % 5];
                [next() * size, next() * size, next() * size]
            })
            .collect();
        positions[7] = [f32::NAN, 0.0, 1.0];
        positions[8] = [f32::INFINITY, 0.0, 1.0];
        positions[9] = [f32::MAX; 3];
        let mut matrix = DMat4::from_diagonal((1.3, 1.7, 0.0, 0.0).into());
        matrix.z_axis = (0.1, 0.2, 0.0, 1.0).into();
        matrix.w_axis = (0.0, 0.0, 0.01, 0.3).into();
        let transform = Transform::new(&matrix, size);
        let (mut plain, mut lanes) = (alloc::vec![[0; 2]; 4001], alloc::vec![[0; 2]; 4001]);
        snap_all_scalar(&positions, &transform, &mut plain);
        snap_all(Level::new(), &positions, &transform, &mut lanes);
        assert_eq!(plain, lanes);
        let special = plain.iter().filter(|&&p| p == SPECIAL).count();
        assert!(
            special > 500 && special < 3500,
            "{special} special vertices"
        );
    }
}

//! Object space to homogeneous pixels and to 1/256 pixel.
use alloc::vec::Vec;

use texmap_math::glam::DMat4;
use texmap_math::simd::{GatherTable, Isa, Scalar, prelude::*};
use texmap_math::{Level, dispatch_simd};

use crate::coverage::edge::{Snapped, to_units};
use crate::front_end::clip::{GUARD_BAND, Hom};
use crate::{DrawCall, TargetSize};

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
        self.apply_lanes(Scalar, position.map(f64::from))
    }

    /// A vertex of a draw.
    pub(crate) fn vertex(&self, draw: &DrawCall<'_>, index: u32) -> Hom {
        let mut at = self.apply(draw.positions[index as usize]);
        if let Some(z) = draw.clip_z.get(index as usize) {
            at.z = f64::from(*z);
        }
        at
    }

    #[inline(always)]
    pub(crate) fn apply_lanes<I: Isa>(&self, i: I, position: [I::F64; 3]) -> Hom<I> {
        let [cx, cy, cz, cw] = [
            row(i, &self.rows[0], position),
            row(i, &self.rows[1], position),
            row(i, &self.rows[2], position),
            row(i, &self.rows[3], position),
        ];
        Hom {
            x: (cx + cw) * self.half[0],
            y: (cw - cy) * self.half[1],
            z: cz,
            w: cw,
        }
    }
}

#[inline(always)]
fn row<I: Isa>(_: I, m: &[f64; 4], [x, y, z]: [I::F64; 3]) -> I::F64 {
    (x * m[0] + y * m[1]) + (z * m[2] + m[3])
}

/// Snapped positions of `positions`, [`SPECIAL`] for vertices that cannot be taken as they are. `clip_z` is empty, or the clip z
/// of each.
pub(crate) fn snap_all(
    level: Level,
    positions: &[[f32; 3]],
    clip_z: &[f32],
    transform: &Transform,
    out: &mut [Snapped],
) {
    dispatch_simd!(level, wide i => snap_lanes(i, positions, clip_z, transform, out));
}

#[inline(always)]
fn snap_lanes<I: Isa>(
    i: I,
    positions: &[[f32; 3]],
    clip_z: &[f32],
    transform: &Transform,
    out: &mut [Snapped],
) {
    let Some(words) = GatherTable::new(bytemuck::cast_slice(positions)) else {
        return;
    };
    let mut snapped = [[0; 2]; 16];
    for (k, chunk) in out.chunks_mut(I::LANES).enumerate() {
        let base = ((i.iota() + (k * I::LANES) as i32) * 3).to_u32();
        let [x, y, z] = i.gather_triples(words, base);
        let mut at = transform.apply_lanes(
            i,
            [
                i.widen(x.to_f32_bits()),
                i.widen(y.to_f32_bits()),
                i.widen(z.to_f32_bits()),
            ],
        );
        if let Some(given) = clip_z.get(k * I::LANES..).filter(|z| !z.is_empty()) {
            let mut lanes = [0.0; 16];
            let count = given.len().min(I::LANES);
            lanes[..count].copy_from_slice(&given[..count]);
            at.z = i.widen(i.load_f32(&lanes[..I::LANES]));
        }
        let [x, y] = snap(i, at);
        let [low, high] = i.interleave(x.to_u32(), y.to_u32());
        let words: &mut [u32] = bytemuck::cast_slice_mut(&mut snapped);
        let (low_out, high_out) = words.split_at_mut(I::LANES);
        low.store(low_out);
        high.store(high_out);
        chunk.copy_from_slice(&snapped[..chunk.len()]);
    }
}

/// The snapped position, [`SPECIAL`] where special.
#[inline(always)]
fn snap<I: Isa>(i: I, Hom { x, y, z, w }: Hom<I>) -> [I::I32; 2] {
    let limit = w * GUARD_BAND;
    let in_range = w.simd_ge(W_RANGE[0])
        & w.simd_le(W_RANGE[1])
        & z.simd_ge(0.0)
        & z.simd_le(w)
        & (x + limit).simd_ge(0.0)
        & (limit - x).simd_ge(0.0)
        & (y + limit).simd_ge(0.0)
        & (limit - y).simd_ge(0.0);
    // The divisor of special lanes is replaced, so that no lane holds a NaN.
    let divisor = in_range.select(w, i.f64(1.0));
    let special = i.f64(-(1_i64 << 30) as f64);
    let (x, y) = (to_units(i, x / divisor), to_units(i, y / divisor));
    [
        to_i32(i, in_range.select(x, special)),
        to_i32(i, in_range.select(y, special)),
    ]
}

/// Integers in f64, those below -2^24 as those of [`SPECIAL`]. Integers below 2^24 pass through f32 unchanged.
#[inline(always)]
fn to_i32<I: Isa>(i: I, v: I::F64) -> I::I32 {
    let v = i.narrow(v).to_i32();
    v.simd_lt(-(1 << 24)).select(i.i32(i32::MIN), v)
}

/// Marks the vertices that have a NaN or infinite attribute.
pub(crate) fn mark_bad_attributes(level: Level, draw: &DrawCall<'_>, snapped: &mut [Snapped]) {
    let n = draw.attribute_count;
    if n == 0 {
        return;
    }
    let all_finite = dispatch_simd!(level, wide i => all_finite(i, draw.attributes));
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
fn all_finite<I: Isa>(i: I, values: &[f32]) -> bool {
    let chunks = values.chunks_exact(I::LANES);
    let rest = chunks.remainder();
    // A finite value times zero is zero; a NaN or an infinity is not, and stays in the sum.
    let mut sum = i.f32(0.0);
    for chunk in chunks {
        sum = sum + i.load_f32(chunk) * 0.0;
    }
    sum.simd_eq(0.0).all_true() && rest.iter().all(|v| v.is_finite())
}

/// Buffer for the snapped vertices of a draw.
pub(crate) fn snapped_buffer(draw: &DrawCall<'_>) -> Vec<Snapped> {
    alloc::vec![SPECIAL; draw.positions.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_level_snaps_alike() {
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
        let (mut one, mut lanes) = (alloc::vec![[0; 2]; 4001], alloc::vec![[0; 2]; 4001]);
        snap_lanes(Scalar, &positions, &[], &transform, &mut one);
        snap_all(Level::new(), &positions, &[], &transform, &mut lanes);
        assert_eq!(one, lanes);
        // A vertex that is not special has the same position as by the formula for pieces.
        for (&position, &found) in positions.iter().zip(&one) {
            if found != SPECIAL {
                assert_eq!(
                    found,
                    crate::coverage::edge::snap(transform.apply(position))
                );
            }
        }
        let special = one.iter().filter(|&&p| p == SPECIAL).count();
        assert!(
            special > 500 && special < 3500,
            "{special} special vertices"
        );
    }
}

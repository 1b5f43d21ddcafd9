//! Small triangles that no plane cuts: which are dropped, and which pixels the others may cover.

use texmap_math::simd::{Isa, prelude::*};

use super::Submission;
use crate::Cull;
use crate::front_end::arrays::Arrays;
use crate::front_end::transform::SPECIAL;
use crate::setup::group::{GROUP, area_of, edges_of, extremes, least_inside};

/// A snapped extent below this keeps i32 edge products exact.
const SMALL: i32 = 1 << 15;

/// Sorted triangles: bit masks and pixel boxes.
#[derive(Debug, Default)]
pub(super) struct Sorted {
    pub(super) care: u32,
    pub(super) degenerate: u32,
    pub(super) culled: u32,
    pub(super) outside: u32,
    pub(super) seen: u32,
    pub(super) x0: [i32; GROUP],
    pub(super) y0: [i32; GROUP],
    pub(super) x1: [i32; GROUP],
    pub(super) y1: [i32; GROUP],
}

impl Submission<'_, '_> {
    /// Triangles from `base` on, of which `count` exist: which are dropped and why, which need a look of their own,
    /// and the pixel boxes of those that are seen.
    #[inline(always)]
    pub(super) fn sort<I: Isa>(
        &self,
        i: I,
        arrays: &Arrays<'_>,
        base: usize,
        count: usize,
        group: &mut Sorted,
    ) {
        let [first, second, third] = arrays.corners(i, i.iota() + base as i32);
        let v = [
            arrays.snapped(i, first),
            arrays.snapped(i, second),
            arrays.snapped(i, third),
        ];
        let exists = i.mask_from_bits((1 << count) - 1);
        let special =
            v[0][0].simd_eq(SPECIAL[0]) | v[1][0].simd_eq(SPECIAL[0]) | v[2][0].simd_eq(SPECIAL[0]);
        let (lo_x, hi_x) = extremes(i, [v[0][0], v[1][0], v[2][0]]);
        let (lo_y, hi_y) = extremes(i, [v[0][1], v[1][1], v[2][1]]);
        let large = (hi_x - lo_x).simd_ge(SMALL) | (hi_y - lo_y).simd_ge(SMALL);
        let care = exists & (special | large);
        let whole = exists & !care;

        let area = area_of(i, v);
        let flat = area.simd_eq(0);
        let front = area.simd_lt(0);
        let dropped = match self.draw.cull {
            Cull::None => i.mask(false),
            Cull::Back => !front,
            Cull::Front => front,
        };
        let faced = whole & !flat & !dropped;
        group.care = care.to_bitmask();
        group.degenerate = (whole & flat).to_bitmask();
        group.culled = (whole & !flat & dropped).to_bitmask();
        (group.outside, group.seen) = (0, 0);
        // Neighbours in a mesh mostly face the same way.
        if !faced.any_true() {
            return;
        }
        let [last_x, last_y] = [self.size.width(), self.size.height()].map(|side| side as i32 - 1);
        let x0 = ((lo_x + (127 - self.margin)) >> 8).max(i.i32(0));
        let y0 = ((lo_y + (127 - self.margin)) >> 8).max(i.i32(0));
        let x1 = ((hi_x - (128 - self.margin)) >> 8).min(i.i32(last_x));
        let y1 = ((hi_y - (128 - self.margin)) >> 8).min(i.i32(last_y));
        let empty = x0.simd_gt(x1) | y0.simd_gt(y1);
        let tiny = (x1 - x0).simd_lt(2) & (y1 - y0).simd_lt(2);
        let mut missed = i.mask(self.margin == 0) & faced & tiny & !empty;
        if missed.any_true() {
            missed = missed & !tiny_hit(i, v, front, [x0, y0, x1, y1]);
        }
        group.outside = (faced & (empty | missed)).to_bitmask();
        group.seen = (faced & !(empty | missed)).to_bitmask();
        x0.store(&mut group.x0);
        y0.store(&mut group.y0);
        x1.store(&mut group.x1);
        y1.store(&mut group.y1);
    }
}

/// True if any of the (up to 2x2) centres of the box is inside. Only for small triangles; other lanes hold no meaning.
#[inline(always)]
fn tiny_hit<I: Isa>(
    i: I,
    v: [[I::I32; 2]; 3],
    front: I::Mask,
    [x0, y0, x1, y1]: [I::I32; 4],
) -> I::Mask {
    let (ex0, ey0) = ((x0 << 8) + 128, (y0 << 8) + 128);
    let (ex1, ey1) = ((x1 << 8) + 128, (y1 << 8) + 128);
    let mut hit = [i.mask(true); 4];
    for [p, q] in &edges_of(i, v, front) {
        let (a, b) = (p[1] - q[1], q[0] - p[0]);
        let least = least_inside(i, a, b);
        let (ax0, ax1) = (a * (ex0 - p[0]), a * (ex1 - p[0]));
        let (by0, by1) = (b * (ey0 - p[1]), b * (ey1 - p[1]));
        hit[0] = hit[0] & (ax0 + by0).simd_ge(least);
        hit[1] = hit[1] & (ax1 + by0).simd_ge(least);
        hit[2] = hit[2] & (ax0 + by1).simd_ge(least);
        hit[3] = hit[3] & (ax1 + by1).simd_ge(least);
    }
    hit[0] | hit[1] | hit[2] | hit[3]
}

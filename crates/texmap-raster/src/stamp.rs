//! Triangles to 4x4 blocks of pixels: which of the sixteen are covered, and their depth.
use texmap_math::fearless_simd::{Simd, f32x16, f64x8, i32x16, mask32x16, prelude::*, u32x16};
use texmap_math::lanes::{LANES, clamp};

use crate::group::Group;
use crate::planes::Plane;
use crate::setup::TILE;

/// 4x4 blocks across a tile.
pub(crate) const BLOCKS: usize = TILE as usize / 4;

/// Boxes of more pixels than this are looked at in 16x16 blocks first.
const HIERARCHY: i32 = 500;

/// Where a tile's pixel (x, y) lies in buffers of 4x4 blocks: block by block in rows, each block row by row.
#[must_use]
#[inline(always)]
pub fn block_index(x: u32, y: u32) -> usize {
    let (x, y) = (x as usize, y as usize);
    ((y >> 2) * BLOCKS + (x >> 2)) * LANES + (y & 3) * 4 + (x & 3)
}

/// Takes covered pixels, in submitted order.
pub(crate) trait Sink<S: Simd> {
    /// Sixteen pixels of block `block`; `lane` names the triangle in its group.
    fn block(&mut self, s: S, lane: usize, block: usize, covered: mask32x16<S>, depth: f32x16<S>);
    /// Sixteen pixels, all covered.
    #[inline(always)]
    fn full_block(&mut self, s: S, lane: usize, block: usize, depth: f32x16<S>) {
        self.block(s, lane, block, mask32x16::splat(s, true), depth);
    }
    /// One pixel at `index` of the block order.
    fn pixel(&mut self, lane: usize, index: usize, depth: f32);
    /// Whether the pixels of a triangle cost less one by one than as parts of blocks where they are few, though they may be more
    /// than four.
    fn takes_pixels(&self) -> bool;
}

/// Numbers that every stamp needs: the lanes' places in a block.
#[derive(Debug, Clone, Copy)]
struct Places<S: Simd> {
    x: i32x16<S>,
    y: i32x16<S>,
    /// Pixel centres of block 0, from the tile's centre.
    px: f32x16<S>,
    py: f32x16<S>,
}

impl<S: Simd> Places<S> {
    #[inline(always)]
    fn new(s: S, offset: [i32; 2]) -> Self {
        let x = i32x16::from_slice(s, &[0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3]);
        let y = i32x16::from_slice(s, &[0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3]);
        let half = TILE as f32 / 2.0 - 0.5;
        Self {
            x,
            y,
            px: x.to_float::<f32x16<S>>() - half + offset[0] as f32 / 256.0,
            py: y.to_float::<f32x16<S>>() - half + offset[1] as f32 / 256.0,
        }
    }
}

/// A depth plane spread over lanes.
#[derive(Debug, Clone, Copy)]
struct Depth<'g, S: Simd> {
    a: f32x16<S>,
    b: f32x16<S>,
    c: f32x16<S>,
    lo: f32x16<S>,
    hi: f32x16<S>,
    /// The plane in f64, of a wide lane. Where it lies: were it part of this, all of this would lie in memory.
    wide: Option<&'g Plane>,
}

impl<'g, S: Simd> Depth<'g, S> {
    #[inline(always)]
    fn new(s: S, group: &'g Group, lane: usize) -> Self {
        let wide = group.wide >> lane & 1 == 1;
        Self {
            a: f32x16::splat(s, group.z[0][lane]),
            b: f32x16::splat(s, group.z[1][lane]),
            c: f32x16::splat(s, group.z[2][lane]),
            lo: f32x16::splat(s, group.z_lo[lane]),
            hi: f32x16::splat(s, group.z_hi[lane]),
            wide: wide.then_some(&group.z_wide[lane]),
        }
    }

    /// The part that the blocks of a row share.
    #[inline(always)]
    fn row(&self, py: f32x16<S>) -> DepthRow<'_, 'g, S> {
        DepthRow {
            depth: self,
            py,
            start: self.c + self.b * py,
        }
    }
}

/// A depth plane on a row of blocks.
#[derive(Debug, Clone, Copy)]
struct DepthRow<'d, 'g, S: Simd> {
    depth: &'d Depth<'g, S>,
    py: f32x16<S>,
    start: f32x16<S>,
}

impl<S: Simd> DepthRow<'_, '_, S> {
    #[inline(always)]
    fn at(&self, s: S, px: f32x16<S>) -> f32x16<S> {
        let z = match self.depth.wide {
            None => self.start + self.depth.a * px,
            Some(plane) => wide_at(s, plane, px, self.py),
        };
        clamp(z, self.depth.lo, self.depth.hi)
    }
}

/// A plane in f64. Out of line: a compiler moves the steps of an inlined form before the question whether the lane is wide, where
/// what they read holds no meaning and, taken for a subnormal number, costs a hundred cycles a step.
#[cold]
#[inline(never)]
fn wide_at<S: Simd>(s: S, plane: &Plane, px: f32x16<S>, py: f32x16<S>) -> f32x16<S> {
    s.vectorize(
        #[inline(always)]
        || {
            let (a, b, c) = (
                f64x8::splat(s, plane.a),
                f64x8::splat(s, plane.b),
                f64x8::splat(s, plane.c),
            );
            let ((x0, x1), (y0, y1)) = (px.widen(), py.widen());
            s.narrow_f64x8((c + b * y0) + a * x0, (c + b * y1) + a * x1)
        },
    )
}

/// Stamps the live triangles of a group, one after the other; the last first if `backwards`.
#[inline(always)]
pub(crate) fn stamp_group<S: Simd, K: Sink<S>>(s: S, group: &Group, backwards: bool, sink: &mut K) {
    let places = Places::new(s, group.offset);
    let mut small = Small::default();
    let boxes = if sink.takes_pixels() {
        group.small
    } else {
        group.tiny
    };
    let by_pixels = boxes & group.live;
    if by_pixels != 0 {
        small.fill(s, group, by_pixels);
    }
    let mut live = group.live;
    while live != 0 {
        let lane = if backwards {
            live.ilog2() as usize
        } else {
            live.trailing_zeros() as usize
        };
        live &= !(1 << lane);
        if by_pixels >> lane & 1 == 1 && small.covered[lane].count_ones() <= FEW {
            small.commit::<S, K>(group, lane, sink);
        } else {
            stamp(s, &places, group, lane, sink);
        }
    }
}

/// Pixels of a triangle up to which they are taken one by one.
const FEW: u32 = 6;

/// The pixels of boxes of up to 4x4 of sixteen triangles at once: lanes across triangles.
#[derive(Debug, Default)]
struct Small {
    /// Of each triangle, a bit per pixel of its box, in rows of four.
    covered: [u32; LANES],
    /// Of each pixel of a box, that of each triangle.
    depth: [[f32; LANES]; 16],
}

impl Small {
    /// Of the triangles `asked` for, a bit each. Out of line: compiled once a level.
    #[inline(never)]
    fn fill<S: Simd>(&mut self, s: S, group: &Group, asked: u32) {
        s.vectorize(
            #[inline(always)]
            || self.fill_lanes(s, group, asked),
        );
    }

    #[inline(always)]
    fn fill_lanes<S: Simd>(&mut self, s: S, group: &Group, asked: u32) {
        let (x0, y0) = (
            i32x16::from_slice(s, &group.x0),
            i32x16::from_slice(s, &group.y0),
        );
        let last = [
            i32x16::from_slice(s, &group.x1) - x0,
            i32x16::from_slice(s, &group.y1) - y0,
        ];
        let zero = i32x16::splat(s, 0);
        let (mut right, mut down, mut row) = ([zero; 3], [zero; 3], [zero; 3]);
        for k in 0..3 {
            right[k] = i32x16::from_slice(s, &group.a[k]);
            down[k] = i32x16::from_slice(s, &group.b[k]);
            row[k] = (i32x16::from_slice(s, &group.q[k]) + down[k] * y0) + right[k] * x0;
        }
        let half = TILE as f32 / 2.0 - 0.5;
        let left = x0.to_float::<f32x16<S>>() - half + group.offset[0] as f32 / 256.0;
        let mut py = y0.to_float::<f32x16<S>>() - half + group.offset[1] as f32 / 256.0;
        let a = f32x16::from_slice(s, &group.z[0]);
        let b = f32x16::from_slice(s, &group.z[1]);
        let c = f32x16::from_slice(s, &group.z[2]);
        let (lo, hi) = (
            f32x16::from_slice(s, &group.z_lo),
            f32x16::from_slice(s, &group.z_hi),
        );
        let asked = mask32x16::<S>::from_bitmask(s, u64::from(asked));
        let mut covered = zero;
        for y in 0..4 {
            let in_row = asked & last[1].simd_ge(y);
            if !in_row.any_true() {
                break;
            }
            let (mut e, mut px, start) = (row, left, c + b * py);
            for x in 0..4 {
                let there = in_row & last[0].simd_ge(x);
                if !there.any_true() {
                    break;
                }
                let k = 4 * y + x;
                let inside = there & (e[0] | e[1] | e[2]).simd_ge(0);
                covered = inside.select(covered | (1 << k), covered);
                clamp(start + a * px, lo, hi).store_slice(&mut self.depth[k as usize]);
                e = [e[0] + right[0], e[1] + right[1], e[2] + right[2]];
                px += 1.0;
            }
            row = [row[0] + down[0], row[1] + down[1], row[2] + down[2]];
            py += 1.0;
        }
        covered
            .bitcast::<u32x16<S>>()
            .store_slice(&mut self.covered);
    }

    #[inline(always)]
    fn commit<S: Simd, K: Sink<S>>(&self, group: &Group, lane: usize, sink: &mut K) {
        let (x, y) = (group.x0[lane] as u32, group.y0[lane] as u32);
        let mut left = self.covered[lane];
        while left != 0 {
            let k = left.trailing_zeros() & 15;
            left &= left - 1;
            let index = block_index(x + k % 4, y + k / 4);
            sink.pixel(lane, index, self.depth[k as usize][lane]);
        }
    }
}

/// One triangle in 4x4 blocks.
#[inline(always)]
fn stamp<S: Simd, K: Sink<S>>(s: S, places: &Places<S>, group: &Group, lane: usize, sink: &mut K) {
    let (x0, y0, x1, y1) = (
        group.x0[lane],
        group.y0[lane],
        group.x1[lane],
        group.y1[lane],
    );
    let depth = Depth::new(s, group, lane);
    let whole = (x1 - x0 + 1) * (y1 - y0 + 1) <= HIERARCHY;
    // A small triangle is one part; a larger one is seen in 16x16 blocks.
    let shift = if whole { 6 } else { 4 };
    let reach = (1 << shift) - 1;
    for by in y0 >> shift..=y1 >> shift {
        for bx in x0 >> shift..=x1 >> shift {
            let (x, y) = (bx << shift, by << shift);
            let part = [
                x.max(x0),
                y.max(y0),
                (x + reach).min(x1),
                (y + reach).min(y1),
            ];
            let covered = if whole {
                Part::Some
            } else {
                quarter(group, lane, x, y)
            };
            match covered {
                Part::None => {}
                Part::All if part == [x, y, x + 15, y + 15] => {
                    fill(s, places, lane, &depth, x, y, sink);
                }
                _ => scan(s, places, group, lane, &depth, part, sink),
            }
        }
    }
}

/// How much of a 16x16 block a triangle covers.
enum Part {
    None,
    Some,
    All,
}

#[inline(always)]
fn quarter(group: &Group, lane: usize, x: i32, y: i32) -> Part {
    let mut all = true;
    for k in 0..3 {
        let (a, b) = (group.a[k][lane], group.b[k][lane]);
        let e = group.q[k][lane] + b * y + a * x;
        // The extremes over the block's 16x16 centres; they lie in the tile, so they fit.
        if e + 15 * (a.max(0) + b.max(0)) < 0 {
            return Part::None;
        }
        all &= e + 15 * (a.min(0) + b.min(0)) >= 0;
    }
    if all { Part::All } else { Part::Some }
}

/// The blocks of a box, each tested. The box may end within a block: the box of a triangle holds all it covers in the tile.
#[inline(always)]
fn scan<S: Simd, K: Sink<S>>(
    s: S,
    places: &Places<S>,
    group: &Group,
    lane: usize,
    depth: &Depth<'_, S>,
    [x0, y0, x1, y1]: [i32; 4],
    sink: &mut K,
) {
    let (bx0, by0) = (x0 >> 2, y0 >> 2);
    let mut row = [i32x16::splat(s, 0); 3];
    let mut right = row;
    let mut down = row;
    for k in 0..3 {
        let (a, b) = (group.a[k][lane], group.b[k][lane]);
        let start = group.q[k][lane] + b * (by0 * 4) + a * (bx0 * 4);
        row[k] = (places.x * a + places.y * b) + start;
        right[k] = i32x16::splat(s, a.wrapping_mul(4));
        down[k] = i32x16::splat(s, b.wrapping_mul(4));
    }
    // Steps of four between small multiples of 1/256 are exact.
    let mut py = places.py + (by0 * 4) as f32;
    let left = places.px + (bx0 * 4) as f32;
    for by in by0..=y1 >> 2 {
        let (mut e, mut px) = (row, left);
        let depths = depth.row(py);
        for bx in bx0..=x1 >> 2 {
            let covered = (e[0] | e[1] | e[2]).simd_ge(0);
            if covered.any_true() {
                let z = depths.at(s, px);
                sink.block(s, lane, by as usize * BLOCKS + bx as usize, covered, z);
            }
            e = [e[0] + right[0], e[1] + right[1], e[2] + right[2]];
            px += 4.0;
        }
        row = [row[0] + down[0], row[1] + down[1], row[2] + down[2]];
        py += 4.0;
    }
}

/// A 16x16 block that lies inside: no edges, no masks.
#[inline(always)]
fn fill<S: Simd, K: Sink<S>>(
    s: S,
    places: &Places<S>,
    lane: usize,
    depth: &Depth<'_, S>,
    x: i32,
    y: i32,
    sink: &mut K,
) {
    // Steps of four, as in `scan`.
    let mut py = places.py + y as f32;
    let left = places.px + x as f32;
    for by in y >> 2..(y >> 2) + 4 {
        let row = depth.row(py);
        let mut px = left;
        for bx in x >> 2..(x >> 2) + 4 {
            sink.full_block(s, lane, by as usize * BLOCKS + bx as usize, row.at(s, px));
            px += 4.0;
        }
        py += 4.0;
    }
}

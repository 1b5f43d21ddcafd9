//! Triangles to 4x4 blocks of pixels: which of the sixteen are covered, and their depth.
use texmap_math::simd::{Isa, prelude::*};

use crate::setup::group::{GROUP, Group};
use crate::setup::{Depth, DepthRow, TILE};

/// 4x4 blocks across a tile.
pub(crate) const BLOCKS: usize = TILE as usize / 4;

/// Pixels of a 4x4 block.
pub(crate) const BLOCK_PIXELS: usize = 16;

/// Boxes of more pixels than this are looked at in 16x16 blocks first.
const HIERARCHY: i32 = 500;

/// Index of a tile's pixel (x, y) in buffers of 4x4 blocks: block by block in rows, each block row by row.
#[must_use]
#[inline(always)]
pub fn block_index(x: u32, y: u32) -> usize {
    let (x, y) = (x as usize, y as usize);
    ((y >> 2) * BLOCKS + (x >> 2)) * BLOCK_PIXELS + (y & 3) * 4 + (x & 3)
}

/// Column and row in a 4x4 block of its pixels from pixel `at` on.
#[inline(always)]
pub(crate) fn block_lanes<I: Isa>(i: I, at: usize) -> [I::I32; 2] {
    let pixel = i.iota() + at as i32;
    [pixel & 3, pixel >> 2]
}

/// Takes covered pixels, in submitted order.
pub(crate) trait Sink<I: Isa> {
    /// Pixels of a 4x4 block from `index` of the block order on, one in each lane. `triangle` is its index in the group.
    fn pixels(&mut self, i: I, triangle: usize, index: usize, covered: I::Mask, depth: I::F32);
    /// [`pixels`](Self::pixels) that are all covered.
    #[inline(always)]
    fn all_pixels(&mut self, i: I, triangle: usize, index: usize, depth: I::F32) {
        self.pixels(i, triangle, index, i.mask(true), depth);
    }
    /// One pixel at `index` of the block order.
    fn pixel(&mut self, triangle: usize, index: usize, depth: f32);
    /// True if a triangle's few pixels cost less one by one than as parts of blocks. Also for more than four pixels.
    fn takes_pixels(&self) -> bool;
}

/// Covers pixels by the live triangles of a group, one after the other; the last first if `backwards`.
#[inline(always)]
pub(crate) fn stamp_group<I: Isa, K: Sink<I>>(i: I, group: &Group, backwards: bool, sink: &mut K) {
    let places = Places::new(i, group.offset);
    let mut small = Small::default();
    let boxes = if sink.takes_pixels() {
        group.small
    } else {
        group.tiny
    };
    let by_pixels = boxes & group.live;
    if by_pixels != 0 {
        small.fill(i, group, by_pixels);
    }
    let mut live = group.live;
    while live != 0 {
        let triangle = if backwards {
            live.ilog2() as usize
        } else {
            live.trailing_zeros() as usize
        };
        live &= !(1 << triangle);
        if by_pixels >> triangle & 1 == 1 && small.covered[triangle].count_ones() <= FEW {
            small.commit::<I, K>(group, triangle, sink);
        } else {
            Stamp::new(i, places, group, triangle).stamp(sink);
        }
    }
}

/// Pixels of a triangle up to which they are taken one by one.
const FEW: u32 = 6;

/// Coordinates of pixel 0 of a tile from the tile's centre.
const CORNER: f32 = 0.5 - TILE as f32 / 2.0;

/// The pixels of boxes of up to 4x4 of a group's triangles: a triangle in each lane.
#[derive(Debug, Default)]
struct Small {
    /// Of each triangle, a bit per pixel of its box, in rows of four.
    covered: [u32; GROUP],
    /// Of each pixel of a box, that of each triangle.
    depth: [[f32; GROUP]; 16],
}

impl Small {
    /// Of the triangles `asked` for, a bit each. Out of line: compiled once a level.
    #[inline(never)]
    fn fill<I: Isa>(&mut self, i: I, group: &Group, asked: u32) {
        i.vectorize(
            #[inline(always)]
            || {
                for at in (0..GROUP).step_by(I::LANES) {
                    self.fill_lanes(i, at, group, i.mask_from_bits(asked >> at));
                }
            },
        );
    }

    #[inline(always)]
    fn fill_lanes<I: Isa>(&mut self, i: I, at: usize, group: &Group, asked: I::Mask) {
        let (x0, y0) = (i.load_i32(&group.x0[at..]), i.load_i32(&group.y0[at..]));
        let last = [
            i.load_i32(&group.x1[at..]) - x0,
            i.load_i32(&group.y1[at..]) - y0,
        ];
        let zero = i.i32(0);
        let (mut right, mut down, mut row) = ([zero; 3], [zero; 3], [zero; 3]);
        for k in 0..3 {
            right[k] = i.load_i32(&group.a[k][at..]);
            down[k] = i.load_i32(&group.b[k][at..]);
            row[k] = (i.load_i32(&group.q[k][at..]) + down[k] * y0) + right[k] * x0;
        }
        let [left, mut py] = [
            x0.to_f32() + CORNER + group.offset[0] as f32 / 256.0,
            y0.to_f32() + CORNER + group.offset[1] as f32 / 256.0,
        ];
        let depth = Depth {
            coefficients: [
                i.load_f32(&group.z[0][at..]),
                i.load_f32(&group.z[1][at..]),
                i.load_f32(&group.z[2][at..]),
                i.load_f32(&group.z_lo[at..]),
                i.load_f32(&group.z_hi[at..]),
            ],
            wide: None,
        };
        let mut covered = zero;
        for y in 0..4 {
            let in_row = asked & last[1].simd_ge(y);
            if !in_row.any_true() {
                break;
            }
            let (mut e, mut px, depths) = (row, left, depth.row(py));
            for x in 0..4 {
                let there = in_row & last[0].simd_ge(x);
                if !there.any_true() {
                    break;
                }
                let k = 4 * y + x;
                let inside = there & (e[0] | e[1] | e[2]).simd_ge(0);
                covered = inside.select(covered | (1 << k), covered);
                depths.at(i, px).store(&mut self.depth[k as usize][at..]);
                e = [e[0] + right[0], e[1] + right[1], e[2] + right[2]];
                px = px + 1.0;
            }
            row = [row[0] + down[0], row[1] + down[1], row[2] + down[2]];
            py = py + 1.0;
        }
        covered.to_u32().store(&mut self.covered[at..]);
    }

    #[inline(always)]
    fn commit<I: Isa, K: Sink<I>>(&self, group: &Group, triangle: usize, sink: &mut K) {
        let (x, y) = (group.x0[triangle] as u32, group.y0[triangle] as u32);
        let mut left = self.covered[triangle];
        while left != 0 {
            let k = left.trailing_zeros() & 15;
            left &= left - 1;
            let index = block_index(x + k % 4, y + k / 4);
            sink.pixel(triangle, index, self.depth[k as usize][triangle]);
        }
    }
}

/// The pixels of the first part of a block.
#[derive(Clone, Copy)]
struct Places<I: Isa> {
    /// Column and row in the block.
    lanes: [I::I32; 2],
    /// Centres in block 0, from the tile's centre.
    centres: [I::F32; 2],
}

impl<I: Isa> Places<I> {
    #[inline(always)]
    fn new(i: I, offset: [i32; 2]) -> Self {
        let lanes = block_lanes(i, 0);
        Self {
            lanes,
            centres: [
                lanes[0].to_f32() + CORNER + offset[0] as f32 / 256.0,
                lanes[1].to_f32() + CORNER + offset[1] as f32 / 256.0,
            ],
        }
    }
}

/// One triangle of a group in 4x4 blocks.
struct Stamp<'g, I: Isa> {
    i: I,
    group: &'g Group,
    triangle: usize,
    depth: Depth<'g, I>,
    places: Places<I>,
}

impl<'g, I: Isa> Stamp<'g, I> {
    #[inline(always)]
    fn new(i: I, places: Places<I>, group: &'g Group, triangle: usize) -> Self {
        let wide = group.wide >> triangle & 1 == 1;
        Self {
            i,
            group,
            triangle,
            depth: Depth {
                coefficients: [
                    i.f32(group.z[0][triangle]),
                    i.f32(group.z[1][triangle]),
                    i.f32(group.z[2][triangle]),
                    i.f32(group.z_lo[triangle]),
                    i.f32(group.z_hi[triangle]),
                ],
                wide: wide.then_some(&group.z_wide[triangle]),
            },
            places,
        }
    }

    #[inline(always)]
    fn stamp<K: Sink<I>>(&self, sink: &mut K) {
        let (group, k) = (self.group, self.triangle);
        let [x0, y0, x1, y1] = [group.x0[k], group.y0[k], group.x1[k], group.y1[k]];
        if (x1 - x0 + 1) * (y1 - y0 + 1) <= HIERARCHY {
            self.scan([x0, y0, x1, y1], sink);
        } else {
            self.quarters([x0, y0, x1, y1], sink);
        }
    }

    /// A large triangle in 16x16 blocks. Out of line: small ones, which are more, have the registers for themselves.
    #[inline(never)]
    fn quarters<K: Sink<I>>(&self, [x0, y0, x1, y1]: [i32; 4], sink: &mut K) {
        self.i.vectorize(
            #[inline(always)]
            || {
                for by in y0 >> 4..=y1 >> 4 {
                    for bx in x0 >> 4..=x1 >> 4 {
                        let (x, y) = (bx << 4, by << 4);
                        let part = [x.max(x0), y.max(y0), (x + 15).min(x1), (y + 15).min(y1)];
                        match quarter(self.group, self.triangle, x, y) {
                            Part::None => {}
                            Part::All if part == [x, y, x + 15, y + 15] => self.fill(x, y, sink),
                            _ => self.scan(part, sink),
                        }
                    }
                }
            },
        );
    }

    /// The blocks of a box, each tested. The box may end within a block: the box of a triangle holds all it covers in the tile.
    #[inline(always)]
    fn scan<K: Sink<I>>(&self, [x0, y0, x1, y1]: [i32; 4], sink: &mut K) {
        let (i, group, triangle) = (self.i, self.group, self.triangle);
        let (bx0, by0) = (x0 >> 2, y0 >> 2);
        let mut row = [i.i32(0); 3];
        let mut right = row;
        let mut down = row;
        let mut edges = [[0; 2]; 3];
        for k in 0..3 {
            let (a, b) = (group.a[k][triangle], group.b[k][triangle]);
            let start = group.q[k][triangle] + b * (by0 * 4) + a * (bx0 * 4);
            row[k] = (self.places.lanes[0] * a + self.places.lanes[1] * b) + start;
            right[k] = i.i32(a.wrapping_mul(4));
            down[k] = i.i32(b.wrapping_mul(4));
            edges[k] = [a, b];
        }
        // Steps of four between small multiples of 1/256 are exact.
        let mut py = self.places.centres[1] + (by0 * 4) as f32;
        let left = self.places.centres[0] + (bx0 * 4) as f32;
        for by in by0..=y1 >> 2 {
            let (mut e, mut px) = (row, left);
            let depths = self.depth.row(py);
            for bx in bx0..=x1 >> 2 {
                let index = (by as usize * BLOCKS + bx as usize) * BLOCK_PIXELS;
                for at in (0..BLOCK_PIXELS).step_by(I::LANES) {
                    let e = if at == 0 { e } else { moved(e, &edges, at) };
                    let covered = (e[0] | e[1] | e[2]).simd_ge(0);
                    if covered.any_true() {
                        let z = self.depth_at(&depths, [px, py], at);
                        sink.pixels(i, triangle, index + at, covered, z);
                    }
                }
                e = [e[0] + right[0], e[1] + right[1], e[2] + right[2]];
                px = px + 4.0;
            }
            row = [row[0] + down[0], row[1] + down[1], row[2] + down[2]];
            py = py + 4.0;
        }
    }

    /// A 16x16 block that lies inside: no edges, no masks.
    #[inline(always)]
    fn fill<K: Sink<I>>(&self, x: i32, y: i32, sink: &mut K) {
        // Steps of four, as in `scan`.
        let mut py = self.places.centres[1] + y as f32;
        let left = self.places.centres[0] + x as f32;
        for by in y >> 2..(y >> 2) + 4 {
            let depths = self.depth.row(py);
            let mut px = left;
            for bx in x >> 2..(x >> 2) + 4 {
                let index = (by as usize * BLOCKS + bx as usize) * BLOCK_PIXELS;
                for at in (0..BLOCK_PIXELS).step_by(I::LANES) {
                    let z = self.depth_at(&depths, [px, py], at);
                    sink.all_pixels(self.i, self.triangle, index + at, z);
                }
                px = px + 4.0;
            }
            py = py + 4.0;
        }
    }

    /// Depth at the pixels of a block from pixel `at` on. `px`, `py` and `first` are those of the first part.
    #[inline(always)]
    fn depth_at(&self, first: &DepthRow<'g, I>, [px, py]: [I::F32; 2], at: usize) -> I::F32 {
        if at == 0 {
            return first.at(self.i, px);
        }
        let row = self.depth.row(py + (at / 4) as f32);
        row.at(self.i, px + (at % 4) as f32)
    }
}

/// Edges' values at the pixels of a block from pixel `at` on, from those at the first.
#[inline(always)]
fn moved<N: Number<i32>>(e: [N; 3], edges: &[[i32; 2]; 3], at: usize) -> [N; 3] {
    let (x, y) = ((at % 4) as i32, (at / 4) as i32);
    let step = |[a, b]: [i32; 2]| a.wrapping_mul(x).wrapping_add(b.wrapping_mul(y));
    [
        e[0] + step(edges[0]),
        e[1] + step(edges[1]),
        e[2] + step(edges[2]),
    ]
}

/// Part of a 16x16 block that a triangle covers.
enum Part {
    None,
    Some,
    All,
}

#[inline(always)]
fn quarter(group: &Group, triangle: usize, x: i32, y: i32) -> Part {
    let mut all = true;
    for k in 0..3 {
        let (a, b) = (group.a[k][triangle], group.b[k][triangle]);
        let e = group.q[k][triangle] + b * y + a * x;
        // The extremes over the block's 16x16 centres; they lie in the tile, so they fit.
        if e + 15 * (a.max(0) + b.max(0)) < 0 {
            return Part::None;
        }
        all &= e + 15 * (a.min(0) + b.min(0)) >= 0;
    }
    if all { Part::All } else { Part::Some }
}

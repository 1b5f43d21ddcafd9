//! Attribute planes of a tile's triangles, and their values sixteen pixels at a time.
use alloc::vec::Vec;

use texmap_math::Level;
use texmap_math::fearless_simd::{Simd, f32x16, f64x8, mask64x8, prelude::*, u32x16};
use texmap_math::lanes::{LANES, Words, clamp, gather};

use crate::blocks::{Runs, TileBlocks, pixel_of};
use crate::dispatch::on_level;
use crate::group::{Ids, extent_x8, hull_x16, solve_x16};
use crate::setup::{Fragment, LARGEST, Ranged, SMALLEST, TILE, TriangleSetup, W_RATIO, origin};
use crate::visible::NONE;
use crate::{Interp, MAX_ATTRIBUTES, Prepared};

/// Coefficients of a plane with its hull: a, b, c, lo, hi.
const COEFFICIENTS: usize = 5;

/// Planes of 1/w and of every attribute for each slot of a tile (see [`TileBlocks::slot`](crate::TileBlocks)),
/// coefficient by coefficient in groups of sixteen slots.
#[derive(Debug, Clone, Default)]
pub struct TilePlanes {
    words: Vec<f32>,
    /// Coefficients a group.
    per_group: usize,
    /// Slots that f32 planes cannot serve, by the index of their set-up; [`NONE`] for the others.
    odd: Vec<u32>,
    setups: Vec<TriangleSetup>,
    /// The tile's corner.
    corner: [u32; 2],
}

/// Sixteen pixels' values: attribute k, its change per pixel to the right and down.
#[derive(Debug, Clone, Copy)]
pub struct LaneValues<S: Simd, const N: usize> {
    /// Values.
    pub value: [f32x16<S>; N],
    /// Change per pixel to the right.
    pub ddx: [f32x16<S>; N],
    /// Change per pixel down.
    pub ddy: [f32x16<S>; N],
    /// 1 / clip w.
    pub inv_w: f32x16<S>,
}

/// One block of a run: which 4x4 block of the tile and which of its pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BlockMask {
    /// Block, row by row in the tile.
    pub block: u16,
    /// Bit per pixel, row by row in the block.
    pub mask: u16,
}

/// Pixels a run holds at most.
pub const RUN: usize = 256;

/// Two attributes over a run of up to sixteen blocks: sixteen pixels a block, in the order of the run.
#[derive(Debug, Clone, PartialEq)]
pub struct PairRun {
    /// Values.
    pub value: [[f32; RUN]; 2],
    /// Change per pixel to the right.
    pub ddx: [[f32; RUN]; 2],
    /// Change per pixel down.
    pub ddy: [[f32; RUN]; 2],
    /// 1 / clip w.
    pub inv_w: [f32; RUN],
}

impl Default for PairRun {
    fn default() -> Self {
        let zero = [[0.0; RUN]; 2];
        Self {
            value: zero,
            ddx: zero,
            ddy: zero,
            inv_w: [0.0; RUN],
        }
    }
}

impl TilePlanes {
    /// Values of attributes `wanted` over up to sixteen blocks of `blocks`; pixels outside a mask hold no meaning. The bits
    /// are those of [`Prepared::evaluate`], at every level.
    pub fn pair(
        &self,
        level: Level,
        blocks: &TileBlocks,
        run: &[BlockMask],
        wanted: [usize; 2],
        out: &mut PairRun,
    ) {
        on_level!(
            level,
            s => self.pair_lanes(s, blocks, run, wanted, out),
            else self.pair_plain(blocks, run, wanted, out)
        );
    }

    #[inline(always)]
    fn pair_lanes<S: Simd>(
        &self,
        s: S,
        blocks: &TileBlocks,
        run: &[BlockMask],
        wanted: [usize; 2],
        out: &mut PairRun,
    ) {
        for (i, &at) in run.iter().take(RUN / LANES).enumerate() {
            let block = at.block as usize * LANES;
            let Some(slots) = blocks
                .slot
                .get(block..)
                .and_then(|s| s.first_chunk::<LANES>())
            else {
                continue;
            };
            if at.mask == 0 {
                continue;
            }
            let lanes = self.lanes(s, slots, at, wanted);
            let place = i * LANES..(i + 1) * LANES;
            lanes.inv_w.store_slice(&mut out.inv_w[place.clone()]);
            for k in 0..2 {
                lanes.value[k].store_slice(&mut out.value[k][place.clone()]);
                lanes.ddx[k].store_slice(&mut out.ddx[k][place.clone()]);
                lanes.ddy[k].store_slice(&mut out.ddy[k][place.clone()]);
            }
        }
    }

    /// The scalar twin of [`pair_lanes`](Self::pair_lanes), pixel by pixel.
    fn pair_plain(
        &self,
        blocks: &TileBlocks,
        run: &[BlockMask],
        wanted: [usize; 2],
        out: &mut PairRun,
    ) {
        let mut fragment = Fragment::default();
        for (i, &at) in run.iter().take(RUN / LANES).enumerate() {
            for bit in (0..LANES).filter(|bit| at.mask >> bit & 1 == 1) {
                let slot = blocks
                    .slot
                    .get(at.block as usize * LANES + bit)
                    .copied()
                    .unwrap_or(NONE);
                let (x, y) = pixel_of(at.block as usize, bit as u32);
                let place = i * LANES + bit;
                if let Some(setup) = self.odd_setup(slot) {
                    setup.evaluate(self.corner[0] + x, self.corner[1] + y, &mut fragment);
                    out.inv_w[place] = fragment.inv_w;
                    for (k, &from) in wanted.iter().enumerate() {
                        out.value[k][place] = fragment.values[from];
                        out.ddx[k][place] = fragment.ddx[from];
                        out.ddy[k][place] = fragment.ddy[from];
                    }
                } else {
                    self.pixel(slot, [x, y], wanted, place, out);
                }
            }
        }
    }

    /// One pixel of a slot that f32 planes serve.
    fn pixel(&self, slot: u32, at: [u32; 2], wanted: [usize; 2], place: usize, out: &mut PairRun) {
        let [px, py] = at.map(|v| (v as i32 - TILE as i32 / 2) as f32 + 0.5);
        let plane = |k: usize| -> [f32; COEFFICIENTS] {
            core::array::from_fn(|c| {
                let word = self.start_of(slot) + (k * COEFFICIENTS + c) * LANES;
                self.words.get(word).copied().unwrap_or(0.0)
            })
        };
        let clamp = |v: f32, lo: f32, hi: f32| {
            let v = if v > lo { v } else { lo };
            if v < hi { v } else { hi }
        };
        let [wa, wb, wc, lo, hi] = plane(0);
        let w = clamp((wc + wb * py) + wa * px, lo, hi);
        let r = 1.0 / w;
        out.inv_w[place] = w;
        for (k, &from) in wanted.iter().enumerate() {
            let [a, b, c, lo, hi] = plane(1 + from);
            let u = clamp(((c + b * py) + a * px) * r, lo, hi);
            out.value[k][place] = u;
            out.ddx[k][place] = (a - u * wa) * r;
            out.ddy[k][place] = (b - u * wb) * r;
        }
    }

    /// Without planes.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Coefficient `c` of plane `k` (0 is 1/w, attribute i is 1 + i) of sixteen slots.
    #[inline(always)]
    fn coefficient<S: Simd>(&self, s: S, slots: &Slots<'_, S>, k: usize, c: usize) -> f32x16<S> {
        let at = (k * COEFFICIENTS + c) * LANES;
        match slots {
            Slots::One(start) => {
                f32x16::splat(s, self.words.get(start + at).copied().unwrap_or(0.0))
            }
            Slots::Many { start, words } => gather(s, *words, *start + at as u32).bitcast(),
        }
    }

    #[inline(always)]
    fn plane<S: Simd>(&self, s: S, slots: &Slots<'_, S>, k: usize) -> PlaneX16<S> {
        PlaneX16 {
            a: self.coefficient(s, slots, k, 0),
            b: self.coefficient(s, slots, k, 1),
            c: self.coefficient(s, slots, k, 2),
            lo: self.coefficient(s, slots, k, 3),
            hi: self.coefficient(s, slots, k, 4),
        }
    }

    /// Values of attributes `wanted` at the pixels of `block` whose slots are given; lanes outside `mask` hold no meaning but
    /// are finite. The bits are those of [`Prepared::evaluate`].
    #[doc(hidden)]
    #[inline(always)]
    pub fn lanes<S: Simd, const N: usize>(
        &self,
        s: S,
        slots: &[u32; LANES],
        at: BlockMask,
        wanted: [usize; N],
    ) -> LaneValues<S, N> {
        let lead = at.mask.trailing_zeros().min(15) as usize;
        let first = slots[lead];
        let mine = u32x16::from_slice(s, slots);
        // Lanes that are not asked for take the first one's triangle.
        let asked = texmap_math::fearless_simd::mask32x16::from_bitmask(s, u64::from(at.mask));
        let mine = asked.select(mine, u32x16::splat(s, first));
        let (px, py) = centres(s, at.block);
        let one = mine.simd_eq(first).all_true();
        let lanes = if one {
            Slots::One(self.start_of(first))
        } else {
            let Some(words) = Words::new(bytemuck::cast_slice(&self.words)) else {
                return LaneValues::zero(s);
            };
            let start = (mine >> 4) * (self.per_group * LANES) as u32 + (mine & 15);
            Slots::Many { start, words }
        };
        let w = self.plane(s, &lanes, 0);
        let inv_w = clamp((w.c + w.b * py) + w.a * px, w.lo, w.hi);
        let r = f32x16::splat(s, 1.0) / inv_w;
        let mut out = LaneValues::zero(s);
        out.inv_w = inv_w;
        for (i, &k) in wanted.iter().enumerate() {
            let p = self.plane(s, &lanes, 1 + k);
            let u = clamp(((p.c + p.b * py) + p.a * px) * r, p.lo, p.hi);
            out.value[i] = u;
            out.ddx[i] = (p.a - u * w.a) * r;
            out.ddy[i] = (p.b - u * w.b) * r;
        }
        if !self.setups.is_empty() {
            self.mend(s, slots, at, one, first, &wanted, &mut out);
        }
        out
    }

    fn start_of(&self, slot: u32) -> usize {
        (slot as usize / LANES) * self.per_group * LANES + slot as usize % LANES
    }

    /// Replaces the lanes of odd slots.
    #[inline(always)]
    fn mend<S: Simd, const N: usize>(
        &self,
        s: S,
        slots: &[u32; LANES],
        at: BlockMask,
        one: bool,
        first: u32,
        wanted: &[usize; N],
        out: &mut LaneValues<S, N>,
    ) {
        if one {
            if let Some(setup) = self.odd_setup(first) {
                if setup.is_wide_perspective() {
                    setup_lanes_f64(s, setup, at.block, wanted, out);
                } else {
                    self.mend_pixels(s, slots, at, wanted, out);
                }
            }
        } else {
            self.mend_pixels(s, slots, at, wanted, out);
        }
    }

    fn odd_setup(&self, slot: u32) -> Option<&TriangleSetup> {
        let index = *self.odd.get(slot as usize)?;
        self.setups.get(index as usize)
    }

    /// Pixel by pixel.
    #[inline(never)]
    fn mend_pixels<S: Simd, const N: usize>(
        &self,
        s: S,
        slots: &[u32; LANES],
        at: BlockMask,
        wanted: &[usize; N],
        out: &mut LaneValues<S, N>,
    ) {
        let mut fragment = Fragment::default();
        for (bit, &slot) in slots.iter().enumerate() {
            if at.mask >> bit & 1 == 0 {
                continue;
            }
            let Some(setup) = self.odd_setup(slot) else {
                continue;
            };
            let (x, y) = pixel_of(at.block as usize, bit as u32);
            setup.evaluate(self.corner[0] + x, self.corner[1] + y, &mut fragment);
            set_lane(s, &mut out.inv_w, bit, fragment.inv_w);
            for (i, &k) in wanted.iter().enumerate() {
                set_lane(s, &mut out.value[i], bit, fragment.values[k]);
                set_lane(s, &mut out.ddx[i], bit, fragment.ddx[k]);
                set_lane(s, &mut out.ddy[i], bit, fragment.ddy[k]);
            }
        }
    }

    /// Room for `groups` groups with `attributes` attributes.
    fn reset(&mut self, groups: usize, attributes: usize, corner: [u32; 2]) {
        self.per_group = (1 + attributes) * COEFFICIENTS;
        self.words.clear();
        self.words.resize(groups * self.per_group * LANES, 0.0);
        self.odd.clear();
        self.odd.resize(groups * LANES, NONE);
        self.setups.clear();
        self.corner = corner;
    }

    fn slot_of(&mut self, group: usize, k: usize, c: usize) -> &mut [f32] {
        let at = (group * self.per_group + k * COEFFICIENTS + c) * LANES;
        &mut self.words[at..at + LANES]
    }

    fn set(&mut self, slot: usize, k: usize, plane: &Ranged) {
        let (group, lane) = (slot / LANES, slot % LANES);
        for (c, v) in [
            plane.near[0],
            plane.near[1],
            plane.near[2],
            plane.lo,
            plane.hi,
        ]
        .into_iter()
        .enumerate()
        {
            self.slot_of(group, k, c)[lane] = v;
        }
    }

    /// A triangle that came the plain way.
    fn set_triangle(&mut self, slot: usize, setup: &TriangleSetup) {
        let (w, attributes) = setup.planes();
        self.set(slot, 0, w);
        for (k, plane) in attributes.iter().enumerate() {
            self.set(slot, 1 + k, plane);
        }
        if setup.is_odd() {
            self.odd[slot] = self.setups.len() as u32;
            self.setups.push(*setup);
        }
    }
}

impl<S: Simd, const N: usize> LaneValues<S, N> {
    #[inline(always)]
    fn zero(s: S) -> Self {
        let zero = f32x16::splat(s, 0.0);
        Self {
            value: [zero; N],
            ddx: [zero; N],
            ddy: [zero; N],
            inv_w: zero,
        }
    }
}

/// Sixteen slots in the table.
enum Slots<'a, S: Simd> {
    /// All the same: coefficients are spread.
    One(usize),
    /// Coefficients are gathered.
    Many { start: u32x16<S>, words: Words<'a> },
}

struct PlaneX16<S: Simd> {
    a: f32x16<S>,
    b: f32x16<S>,
    c: f32x16<S>,
    lo: f32x16<S>,
    hi: f32x16<S>,
}

/// Pixel centres of a block from the tile's middle.
#[inline(always)]
fn centres<S: Simd>(s: S, block: u16) -> (f32x16<S>, f32x16<S>) {
    let (x, y) = pixel_of(block as usize, 0);
    let half = TILE as f32 / 2.0 - 0.5;
    let column = f32x16::from_slice(
        s,
        &[
            0., 1., 2., 3., 0., 1., 2., 3., 0., 1., 2., 3., 0., 1., 2., 3.,
        ],
    );
    let row = f32x16::from_slice(
        s,
        &[
            0., 0., 0., 0., 1., 1., 1., 1., 2., 2., 2., 2., 3., 3., 3., 3.,
        ],
    );
    (column + (x as f32 - half), row + (y as f32 - half))
}

#[inline(always)]
fn set_lane<S: Simd>(s: S, v: &mut f32x16<S>, lane: usize, value: f32) {
    let mut all = [0.0; LANES];
    v.store_slice(&mut all);
    all[lane] = value;
    *v = f32x16::from_slice(s, &all);
}

/// [`TriangleSetup::evaluate`] in f64 for a block of one triangle.
#[inline(always)]
fn setup_lanes_f64<S: Simd, const N: usize>(
    s: S,
    setup: &TriangleSetup,
    block: u16,
    wanted: &[usize; N],
    out: &mut LaneValues<S, N>,
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

impl Prepared<'_> {
    /// Sets up the attribute planes of every triangle in a tile's bin.
    pub fn planes(&self, tile: usize, out: &mut TilePlanes) {
        let bounds = self.tile(tile);
        let mut runs = Runs::new(self, tile);
        let (mut groups, mut attributes) = (0, 0);
        while let Some(run) = runs.next() {
            groups += 1;
            attributes = attributes.max(self.draw(run.draw as u32).attribute_count);
        }
        out.reset(groups, attributes, [bounds.x0, bounds.y0]);
        match self.level() {
            Some(level) => {
                on_level!(level, s => self.planes_lanes(s, tile, out), else self.planes_plain(tile, out));
            }
            None => self.planes_plain(tile, out),
        }
    }

    fn planes_plain(&self, tile: usize, out: &mut TilePlanes) {
        let bounds = self.tile(tile);
        let mut runs = Runs::new(self, tile);
        while let Some(run) = runs.next() {
            for (lane, &id) in run.ids.iter().enumerate() {
                out.set_triangle(
                    run.first_slot + lane,
                    &self.setup(id, bounds.x0 / TILE, bounds.y0 / TILE),
                );
            }
        }
    }

    #[inline(always)]
    fn planes_lanes<S: Simd>(&self, s: S, tile: usize, out: &mut TilePlanes) {
        let bounds = self.tile(tile);
        let mut runs = Runs::new(self, tile);
        while let Some(run) = runs.next() {
            let mut care = (1u32 << run.ids.len()) - 1;
            if self.is_plain_perspective(run.draw) {
                let named = Ids::new(run.ids, self.first(run.draw), self.whole());
                care &= named.pieces
                    | self.planes_x16(s, run.draw, &named, run.first_slot / LANES, out);
            }
            while care != 0 {
                let lane = care.trailing_zeros() as usize;
                care &= care - 1;
                let setup = self.setup(run.ids[lane], bounds.x0 / TILE, bounds.y0 / TILE);
                out.set_triangle(run.first_slot + lane, &setup);
            }
        }
    }

    /// Draws whose attributes are all exact per pixel.
    fn is_plain_perspective(&self, draw: usize) -> bool {
        let d = self.draw(draw as u32);
        let used = (1u64 << d.attribute_count.min(MAX_ATTRIBUTES)) - 1;
        d.interp == Interp::Perspective && u64::from(d.screen_linear) & used == 0
    }

    /// A group in lanes; returns the lanes that need the plain way.
    #[inline(always)]
    fn planes_x16<S: Simd>(
        &self,
        s: S,
        draw: usize,
        ids: &Ids,
        group: usize,
        out: &mut TilePlanes,
    ) -> u32 {
        let d = self.draw(draw as u32);
        let n = d.attribute_count;
        let (Some(arrays), limit) = (self.arrays(draw), i32::MAX as usize) else {
            return u32::MAX;
        };
        let values = Words::new(bytemuck::cast_slice(d.attributes));
        if (n > 0 && values.is_none()) || d.attributes.len() > limit {
            return u32::MAX;
        }
        let vertex = arrays.corners(s, ids.lanes(s));
        let middle = origin(out.corner[0] / TILE, out.corner[1] / TILE).map(f64::from);
        let [low, high] = solve_x16(s, &arrays, &vertex, self.transform(draw), middle);
        let one = f64x8::splat(s, 1.0);
        let (low_w, high_w) = (low.plane([one; 3]), high.plane([one; 3]));
        let hull = hull_x16([
            s.narrow_f64x8(one / low.w[0], one / high.w[0]),
            s.narrow_f64x8(one / low.w[1], one / high.w[1]),
            s.narrow_f64x8(one / low.w[2], one / high.w[2]),
        ]);
        let lo = hull.0.widen();
        let mut fine = [
            low.solvable & w_is_even(low_w, lo.0),
            high.solvable & w_is_even(high_w, lo.1),
        ];
        fine = store(s, low_w, high_w, hull, fine, group, 0, out);
        if let Some(values) = values {
            let n = n as i32;
            for k in 0..n {
                let v = [
                    gather(s, values, (vertex[0] * n + k).bitcast()).bitcast::<f32x16<S>>(),
                    gather(s, values, (vertex[1] * n + k).bitcast()).bitcast::<f32x16<S>>(),
                    gather(s, values, (vertex[2] * n + k).bitcast()).bitcast::<f32x16<S>>(),
                ];
                let (v0, v1, v2) = (v[0].widen(), v[1].widen(), v[2].widen());
                let (low_plane, high_plane) = (
                    low.plane([v0.0, v1.0, v2.0]),
                    high.plane([v0.1, v1.1, v2.1]),
                );
                fine = store(
                    s,
                    low_plane,
                    high_plane,
                    hull_x16(v),
                    fine,
                    group,
                    1 + k as usize,
                    out,
                );
            }
        }
        !((fine[0].to_bitmask() | fine[1].to_bitmask() << 8) as u32)
    }
}

/// As [`TriangleSetup`] decides where f32 planes of 1/w will do.
#[inline(always)]
fn w_is_even<S: Simd>(plane: [f64x8<S>; 3], lo: f64x8<S>) -> mask64x8<S> {
    let (largest, smallest) = extent_x8(plane);
    let lowest = smallest.simd_gt(lo).select(smallest, lo);
    largest.simd_le(lowest * W_RATIO)
}

/// Stores a plane with its hull; returns the lanes of `fine` whose values are neither too large nor too small for f32.
#[inline(always)]
fn store<S: Simd>(
    s: S,
    low: [f64x8<S>; 3],
    high: [f64x8<S>; 3],
    hull: (f32x16<S>, f32x16<S>),
    fine: [mask64x8<S>; 2],
    group: usize,
    k: usize,
    out: &mut TilePlanes,
) -> [mask64x8<S>; 2] {
    for c in 0..3 {
        s.narrow_f64x8(low[c], high[c])
            .store_slice(out.slot_of(group, k, c));
    }
    hull.0.store_slice(out.slot_of(group, k, 3));
    hull.1.store_slice(out.slot_of(group, k, 4));
    let (lo, hi) = (hull.0.abs(), hull.1.abs());
    let size = lo.simd_gt(hi).select(lo, hi).widen();
    [
        fine[0] & is_moderate(low, size.0),
        fine[1] & is_moderate(high, size.1),
    ]
}

#[inline(always)]
fn is_moderate<S: Simd>(plane: [f64x8<S>; 3], size: f64x8<S>) -> mask64x8<S> {
    let in_range = size.simd_eq(0.0) | (size.simd_ge(SMALLEST) & size.simd_le(LARGEST));
    in_range & extent_x8(plane).0.simd_le(LARGEST)
}

//! Values over a run of pixels: attributes, their derivatives and 1/w, sixteen pixels at a time.
use alloc::vec::Vec;

use texmap_math::Level;
use texmap_math::fearless_simd::{Simd, f32x16, i32x16, mask32x16, prelude::*, u32x16};
use texmap_math::lanes::{LANES, Words, clamp_scalar, gather, has_octets};
use texmap_math::on_level;

use crate::blocks::{TileBlocks, pixel_of};
use crate::plane_table::{COEFFICIENTS, TilePlanes};
use crate::setup::{Fragment, TILE, TriangleSetup};
use crate::visible::NONE;

mod planes;
mod values;
mod wide;

use planes::{OnePlanes, Planes, plane};
pub use values::{BlockSink, BlockValues};
use values::{Columns, Spilt};
use wide::wide;

/// Pixels a run holds at most.
pub const RUN: usize = 256;

/// Triangles of a block that are taken one by one.
const FEW: usize = 5;

/// Room of a run's arrays: their distance in memory is no multiple of 4096 bytes, or stores to one would stall loads of another.
pub const RUN_ROOM: usize = RUN + 16;

/// One block of a run: which 4x4 block of the tile and which of its pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RunBlock {
    /// Block, row by row in the tile.
    pub block: u16,
    /// Bit per pixel, row by row in the block.
    pub mask: u16,
    /// The slot of all pixels, or [`NONE`]: each pixel's own, as the tile's blocks have it.
    pub slot: u32,
}

/// Attributes over a run of up to sixteen blocks: sixteen pixels a block, in the order of the run.
#[derive(Debug, Clone, PartialEq)]
pub struct RunValues {
    /// 1 / clip w.
    pub inv_w: [f32; RUN_ROOM],
    /// What was asked for, in that order.
    pub columns: Vec<Column>,
}

/// One attribute over a run.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    /// Values.
    pub value: [f32; RUN_ROOM],
    /// Change per pixel to the right.
    pub ddx: [f32; RUN_ROOM],
    /// Change per pixel down.
    pub ddy: [f32; RUN_ROOM],
}

impl Default for RunValues {
    fn default() -> Self {
        Self {
            inv_w: [0.0; RUN_ROOM],
            columns: Vec::new(),
        }
    }
}

impl Column {
    /// Nothing but zeros.
    pub const ZERO: Self = Self {
        value: [0.0; RUN_ROOM],
        ddx: [0.0; RUN_ROOM],
        ddy: [0.0; RUN_ROOM],
    };
}

impl TilePlanes {
    /// Attributes `wanted` over up to sixteen blocks; pixels outside the masks hold no meaning. The bits are those of
    /// [`Prepared::evaluate`](crate::Prepared::evaluate), at every level. Without `derivatives` these keep what they held.
    pub fn values(
        &self,
        level: Level,
        blocks: &TileBlocks,
        run: &[RunBlock],
        wanted: &[usize],
        derivatives: bool,
        out: &mut RunValues,
    ) {
        if out.columns.len() < wanted.len() {
            out.columns.resize(wanted.len(), Column::ZERO);
        }
        let run = &run[..run.len().min(RUN / LANES)];
        on_level!(
            level,
            s => if derivatives {
                self.all_lanes::<_, true>(s, blocks, run, wanted, out);
            } else {
                self.all_lanes::<_, false>(s, blocks, run, wanted, out);
            },
            else self.plain(blocks, run, wanted, out)
        );
    }

    /// Four attributes at a time, then two, then one: the triangles of a block and their 1/w are found anew each time.
    #[inline(always)]
    fn all_lanes<S: Simd, const D: bool>(
        &self,
        s: S,
        blocks: &TileBlocks,
        run: &[RunBlock],
        wanted: &[usize],
        out: &mut RunValues,
    ) {
        let RunValues { inv_w, columns } = out;
        if wanted.is_empty() {
            return self.lanes::<S, 0, D>(s, blocks, run, [], inv_w, []);
        }
        let (fours, rest) = wanted.as_chunks::<4>();
        let (pairs, last) = rest.as_chunks::<2>();
        let mut columns = columns.iter_mut();
        for four in fours {
            if let Some(columns) = next(&mut columns) {
                self.lanes::<S, 4, D>(s, blocks, run, *four, inv_w, columns);
            }
        }
        for pair in pairs {
            if let Some(columns) = next(&mut columns) {
                self.lanes::<S, 2, D>(s, blocks, run, *pair, inv_w, columns);
            }
        }
        if let ([k], Some(columns)) = (last, next(&mut columns)) {
            self.lanes::<S, 1, D>(s, blocks, run, [*k], inv_w, columns);
        }
    }

    #[inline(always)]
    fn lanes<S: Simd, const N: usize, const D: bool>(
        &self,
        s: S,
        blocks: &TileBlocks,
        run: &[RunBlock],
        wanted: [usize; N],
        inv_w: &mut [f32; RUN_ROOM],
        columns: [&mut Column; N],
    ) {
        let mut sink = Columns::<N, D> { inv_w, columns };
        self.each_block::<S, N, D, _>(s, blocks, run, wanted, &mut sink);
    }

    /// Shows `sink` the values of attributes `wanted` in each block of `run` that has pixels, in registers; derivatives only where
    /// `D` asks for them. For stages that are generic over the SIMD level; outside semantic versioning.
    #[inline(always)]
    pub fn each_block<S: Simd, const N: usize, const D: bool, K: BlockSink<S, N>>(
        &self,
        s: S,
        blocks: &TileBlocks,
        run: &[RunBlock],
        wanted: [usize; N],
        sink: &mut K,
    ) {
        let Some(words) = Words::new(bytemuck::cast_slice(&self.words)) else {
            return;
        };
        let mut spread = OnePlanes::NONE;
        let mut spread_slot = NONE;
        for (i, &at) in run.iter().enumerate() {
            if at.mask == 0 {
                continue;
            }
            let (px, py) = centres(s, at.block);
            let (slots, first, one) = self.slots_of(s, blocks, at);
            let mut values;
            if one {
                if first != spread_slot {
                    spread = self.one(first, &wanted);
                    spread_slot = first;
                }
                values = spread.lanes(s).values::<D>(s, px, py);
                if self.has_linear {
                    spread.straighten::<S, D>(
                        s,
                        [px, py],
                        self.linear(first),
                        &wanted,
                        &mut values,
                    );
                }
            } else {
                let planes = self.own(s, words, slots, at.mask, &wanted);
                values = planes.values::<D>(s, px, py);
            }
            if !self.is_plain() {
                self.mend::<S, N, D>(s, slots, at, one, &wanted, &mut values);
            }
            sink.block(s, i, at, &values);
        }
    }

    /// [`each_block`](Self::each_block) for pixels that lie anywhere in the tile: block k of `run` is the pixels from 16 k on of
    /// `pixels`, by their places in the tile's blocks (see [`block_index`](crate::block_index)), each of its own slot. Only where
    /// [`is_plain`](Self::is_plain).
    #[inline(always)]
    pub fn each_sixteen<S: Simd, const N: usize, const D: bool, K: BlockSink<S, N>>(
        &self,
        s: S,
        [pixels, slots]: [&[u32]; 2],
        run: &[RunBlock],
        wanted: [usize; N],
        sink: &mut K,
    ) {
        let Some(words) = Words::new(bytemuck::cast_slice(&self.words)) else {
            return;
        };
        let half = TILE as f32 / 2.0 - 0.5;
        for (i, &at) in run.iter().enumerate() {
            let of = at.block as usize * LANES..(at.block as usize + 1) * LANES;
            let (Some(pixels), Some(slots)) = (pixels.get(of.clone()), slots.get(of)) else {
                return;
            };
            let pixels = i32x16::from_slice(s, bytemuck::cast_slice(pixels));
            let x = ((pixels >> 2) & 60) | (pixels & 3);
            let y = ((pixels >> 6) & 60) | ((pixels >> 2) & 3);
            let slots = u32x16::from_slice(s, slots);
            let planes = self.own(s, words, slots, u16::MAX, &wanted);
            let (px, py) = (
                x.to_float::<f32x16<S>>() - half,
                y.to_float::<f32x16<S>>() - half,
            );
            sink.block(s, i, at, &planes.values::<D>(s, px, py));
        }
    }

    /// Whether f32 planes serve all slots, and all attributes are exact.
    #[must_use]
    pub fn is_plain(&self) -> bool {
        self.plain
    }

    /// The slots of a block's lanes, that of its first pixel, and whether all are that one. Lanes outside the mask take the first
    /// pixel's.
    #[inline(always)]
    pub(crate) fn slots_of<S: Simd>(
        &self,
        s: S,
        blocks: &TileBlocks,
        at: RunBlock,
    ) -> (u32x16<S>, u32, bool) {
        if at.slot != NONE {
            return (u32x16::splat(s, at.slot), at.slot, true);
        }
        let start = at.block as usize * LANES;
        let Some(slots) = blocks
            .slot
            .get(start..)
            .and_then(|slots| slots.first_chunk::<LANES>())
        else {
            return (u32x16::splat(s, 0), 0, true);
        };
        let first = slots[at.mask.trailing_zeros() as usize & 15];
        let asked = mask32x16::from_bitmask(s, u64::from(at.mask));
        let mine = asked.select(u32x16::from_slice(s, slots), u32x16::splat(s, first));
        (mine, first, mine.simd_eq(first).all_true())
    }

    /// The planes of one slot.
    #[inline(always)]
    pub(crate) fn one<const N: usize>(&self, slot: u32, wanted: &[usize; N]) -> OnePlanes<'_, N> {
        let words = self.group_of(slot);
        let mut planes = OnePlanes {
            w: plane(words, 0),
            lane: slot as usize % LANES,
            ..OnePlanes::NONE
        };
        for (attribute, &k) in planes.attribute.iter_mut().zip(wanted) {
            *attribute = plane(words, 1 + k);
        }
        let [a, b, c, lo, hi] = planes.own(planes.w);
        if a == 0.0 && b == 0.0 {
            let w = clamp_scalar((c + b * 0.0) + a * 0.0, lo, hi);
            planes.level = Some([w, 1.0 / w]);
        }
        planes
    }

    /// The planes of each lane's own slot.
    #[inline(always)]
    fn own<S: Simd, const N: usize>(
        &self,
        s: S,
        words: Words<'_>,
        slots: u32x16<S>,
        mask: u16,
        wanted: &[usize; N],
    ) -> Planes<S, N> {
        // Many planes do not stay in registers between octets.
        if has_octets(s) && N <= 6 {
            return self.by_octets(s, slots, wanted);
        }
        let Some(parts) = few(slots, mask) else {
            return self.many(s, words, slots, wanted);
        };
        // Cheaper than sixteen gathers.
        let mut planes = Planes::zero(s);
        for (slot, pixels) in parts.into_iter().flatten() {
            planes.put(pixels, &self.one(slot, wanted).lanes(s));
        }
        planes
    }

    /// By gathers.
    #[inline(always)]
    fn many<S: Simd, const N: usize>(
        &self,
        s: S,
        words: Words<'_>,
        slots: u32x16<S>,
        wanted: &[usize; N],
    ) -> Planes<S, N> {
        let start = (slots >> 4) * (self.per_group * LANES) as u32 + (slots & 15);
        let mut planes = Planes::zero(s);
        for (c, word) in planes.w.iter_mut().enumerate() {
            *word = gather(s, words, start + (c * LANES) as u32).bitcast();
        }
        for (plane, &k) in planes.attribute.iter_mut().zip(wanted) {
            for (c, word) in plane.iter_mut().enumerate() {
                let at = ((1 + k) * COEFFICIENTS + c) * LANES;
                *word = gather(s, words, start + at as u32).bitcast();
            }
        }
        planes
    }

    /// Eight slots at a time, which share a register, as long as any are left.
    #[inline(always)]
    fn by_octets<S: Simd, const N: usize>(
        &self,
        s: S,
        slots: u32x16<S>,
        wanted: &[usize; N],
    ) -> Planes<S, N> {
        let (octets, within) = (slots >> 3, slots & 7);
        let mut lanes = [0; LANES];
        slots.store_slice(&mut lanes);
        let table = |slot: u32| (self.group_of(slot), slot as usize / 8 % 2);
        let mut planes = Planes::zero(s);
        planes.put_octet(s, table(lanes[0]), within, wanted, None);
        let mut left = !octets.simd_eq(lanes[0] >> 3).to_bitmask() as u16;
        while left != 0 {
            let slot = lanes[left.trailing_zeros() as usize & 15];
            let pixels = octets.simd_eq(slot >> 3);
            left &= !(pixels.to_bitmask() as u16);
            planes.put_octet(s, table(slot), within, wanted, Some(pixels));
        }
        planes
    }

    /// Replaces the values of slots that f32 planes cannot serve, and, where a block has several, those that are linear on the screen.
    #[inline(always)]
    fn mend<S: Simd, const N: usize, const D: bool>(
        &self,
        s: S,
        slots: u32x16<S>,
        at: RunBlock,
        one: bool,
        wanted: &[usize; N],
        values: &mut BlockValues<S, N>,
    ) {
        if one {
            match self.odd_setup(slots[0]) {
                None => return,
                Some(setup) if setup.is_wide_perspective() => {
                    return wide::<S, N, D>(s, setup, at.block, wanted, values);
                }
                Some(_) => {}
            }
        }
        let mut lanes = [0; LANES];
        slots.store_slice(&mut lanes);
        let mut odd = 0u16;
        if !self.setups.is_empty() {
            for (bit, &slot) in lanes.iter().enumerate() {
                odd |= u16::from(self.odd_setup(slot).is_some()) << bit;
            }
        }
        if odd & at.mask != 0 || self.has_linear {
            let mut spilt = values.spill();
            self.repair(s, &lanes, odd & at.mask, at.block, wanted, &mut spilt);
            *values = BlockValues::load(s, &spilt);
        }
    }

    /// What [`mend`](Self::mend) replaces, out of its way.
    #[inline(never)]
    fn repair<S: Simd, const N: usize>(
        &self,
        s: S,
        lanes: &[u32; LANES],
        odd: u16,
        block: u16,
        wanted: &[usize; N],
        out: &mut Spilt<N>,
    ) {
        if self.has_linear {
            self.straighten(s, lanes, block, wanted, out);
        }
        self.evaluate(lanes, odd, block, wanted, out);
    }

    /// The attributes of a block's lanes that are linear on the screen.
    fn straighten<S: Simd, const N: usize>(
        &self,
        s: S,
        lanes: &[u32; LANES],
        block: u16,
        wanted: &[usize; N],
        out: &mut Spilt<N>,
    ) {
        s.vectorize(
            #[inline(always)]
            || {
                let Some(words) = Words::new(bytemuck::cast_slice(&self.words)) else {
                    return;
                };
                let slots = u32x16::from_slice(s, lanes);
                let planes = self.own(s, words, slots, u16::MAX, wanted);
                let flags = lanes.map(|slot| self.linear(slot));
                let alike = flags.iter().all(|of| *of == flags[0]);
                let (px, py) = centres(s, block);
                for (i, &k) in wanted.iter().enumerate() {
                    let mut mine = mask32x16::splat(s, flags[0] >> k & 1 == 1);
                    if !alike {
                        let bits = flags
                            .iter()
                            .rev()
                            .fold(0, |bits, of| bits << 1 | of >> k & 1);
                        mine = mask32x16::from_bitmask(s, u64::from(bits));
                    }
                    let straight = planes.straight(i, px, py);
                    for (column, value) in out.columns[i].iter_mut().zip(straight) {
                        let exact = f32x16::from_slice(s, column);
                        mine.select(value, exact).store_slice(column);
                    }
                }
            },
        );
    }

    /// The pixels `odd` of a block by their triangles' full set-ups.
    fn evaluate<const N: usize>(
        &self,
        slots: &[u32; LANES],
        odd: u16,
        block: u16,
        wanted: &[usize; N],
        out: &mut Spilt<N>,
    ) {
        let mut fragment = Fragment::default();
        for bit in (0..LANES).filter(|bit| odd >> bit & 1 == 1) {
            let Some(setup) = self.odd_setup(slots[bit]) else {
                continue;
            };
            self.fragment(setup, block, bit, &mut fragment);
            out.inv_w[bit] = fragment.inv_w;
            for (column, &k) in out.columns.iter_mut().zip(wanted) {
                column[0][bit] = fragment.values[k];
                column[1][bit] = fragment.ddx[k];
                column[2][bit] = fragment.ddy[k];
            }
        }
    }

    fn fragment(&self, setup: &TriangleSetup, block: u16, bit: usize, out: &mut Fragment) {
        let (x, y) = pixel_of(block as usize, bit as u32);
        setup.evaluate(self.corner[0] + x, self.corner[1] + y, out);
    }

    /// The scalar twin of the lanes, pixel by pixel.
    fn plain(&self, blocks: &TileBlocks, run: &[RunBlock], wanted: &[usize], out: &mut RunValues) {
        let RunValues { inv_w, columns } = out;
        let mut columns: Vec<&mut Column> = columns.iter_mut().collect();
        let mut fragment = Fragment::default();
        for (i, &at) in run.iter().enumerate() {
            for bit in (0..LANES).filter(|bit| at.mask >> bit & 1 == 1) {
                let own = blocks.slot.get(at.block as usize * LANES + bit);
                let slot = if at.slot == NONE {
                    own.copied().unwrap_or(NONE)
                } else {
                    at.slot
                };
                let place = i * LANES + bit;
                if let Some(setup) = self.odd_setup(slot) {
                    self.fragment(setup, at.block, bit, &mut fragment);
                    inv_w[place] = fragment.inv_w;
                    for (column, &k) in columns.iter_mut().zip(wanted) {
                        column.value[place] = fragment.values[k];
                        column.ddx[place] = fragment.ddx[k];
                        column.ddy[place] = fragment.ddy[k];
                    }
                } else {
                    let (x, y) = pixel_of(at.block as usize, bit as u32);
                    self.pixel(slot, [x, y], wanted, place, inv_w, &mut columns);
                }
            }
        }
    }

    /// One pixel of a slot that f32 planes serve.
    fn pixel(
        &self,
        slot: u32,
        at: [u32; 2],
        wanted: &[usize],
        place: usize,
        inv_w: &mut [f32; RUN_ROOM],
        columns: &mut [&mut Column],
    ) {
        let [px, py] = at.map(|v| (v as i32 - TILE as i32 / 2) as f32 + 0.5);
        let plane = |k: usize| -> [f32; COEFFICIENTS] {
            core::array::from_fn(|c| {
                let word = self.start_of(slot) + (k * COEFFICIENTS + c) * LANES;
                self.words.get(word).copied().unwrap_or(0.0)
            })
        };
        let [wa, wb, wc, lo, hi] = plane(0);
        let w = clamp_scalar((wc + wb * py) + wa * px, lo, hi);
        let r = 1.0 / w;
        inv_w[place] = w;
        for (column, &k) in columns.iter_mut().zip(wanted) {
            let [a, b, c, lo, hi] = plane(1 + k);
            if self.linear(slot) >> k & 1 == 1 {
                column.value[place] = clamp_scalar((c + b * py) + a * px, lo, hi);
                (column.ddx[place], column.ddy[place]) = (a, b);
                continue;
            }
            let u = clamp_scalar(((c + b * py) + a * px) * r, lo, hi);
            column.value[place] = u;
            column.ddx[place] = (a - u * wa) * r;
            column.ddy[place] = (b - u * wb) * r;
        }
    }
}

/// The next `N` columns.
#[inline(always)]
fn next<'a, const N: usize>(
    columns: &mut core::slice::IterMut<'a, Column>,
) -> Option<[&'a mut Column; N]> {
    let (first, rest) = core::mem::take(columns)
        .into_slice()
        .split_first_chunk_mut::<N>()?;
    *columns = rest.iter_mut();
    Some(first.each_mut())
}

/// A slot and its pixels.
type Part<S> = (u32, mask32x16<S>);

/// Up to [`FEW`] slots with the pixels of each; `None` where a block has more.
#[inline(always)]
fn few<S: Simd>(slots: u32x16<S>, mask: u16) -> Option<[Option<Part<S>>; FEW]> {
    let mut lanes = [0; LANES];
    slots.store_slice(&mut lanes);
    let mut parts = [None; FEW];
    let mut left = mask;
    for part in &mut parts {
        if left != 0 {
            let slot = lanes[left.trailing_zeros() as usize & 15];
            let pixels = slots.simd_eq(slot);
            left &= !(pixels.to_bitmask() as u16);
            *part = Some((slot, pixels));
        }
    }
    (left == 0).then_some(parts)
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

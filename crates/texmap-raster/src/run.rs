//! Values over a run of pixels: attributes, their derivatives and 1/w, sixteen pixels at a time.
use alloc::vec::Vec;

use texmap_math::Level;
use texmap_math::fearless_simd::{Simd, f32x16, i32x16, mask32x16, prelude::*, u32x16};
use texmap_math::lanes::{LANES, Words, clamp_scalar};
use texmap_math::on_level;

use crate::blocks::{TileBlocks, pixel_of};
use crate::plane_table::{COEFFICIENTS, TilePlanes};
use crate::setup::{Fragment, TILE};
use crate::visible::NONE;

mod planes;
mod repair;
mod values;
mod wide;

use crate::stamp::BLOCKS;
pub(crate) use planes::One;
use planes::{OnRow, OnePair, Own, Plane, three_planes};
use values::Columns;
pub use values::{BlockSink, BlockValues};

/// Blocks across a tile.
const ROW: u16 = BLOCKS as u16;

/// Pixels a run holds at most.
pub const RUN: usize = 256;

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
    /// [`Prepared::evaluate`](crate::Prepared::evaluate), at every level. Without `derivatives` these hold no meaning either.
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
                self.each_column::<_, true>(s, blocks, run, wanted, 0, out);
            } else {
                self.each_column::<_, false>(s, blocks, run, wanted, 0, out);
            },
            else self.plain(blocks, run, wanted, out)
        );
    }

    /// Stores the values of attributes `wanted` in each block of `run` that has pixels, one attribute a column from column `first` on (nothing where these are missing);
    /// derivatives only where `D` asks for them. For stages that are generic over the SIMD level; outside semantic versioning.
    #[inline(never)]
    pub fn each_column<S: Simd, const D: bool>(
        &self,
        s: S,
        blocks: &TileBlocks,
        run: &[RunBlock],
        wanted: &[usize],
        first: usize,
        out: &mut RunValues,
    ) {
        s.vectorize(
            #[inline(always)]
            || self.columns_lanes::<S, D>(s, blocks, run, wanted, first, out),
        );
    }

    #[inline(always)]
    fn columns_lanes<S: Simd, const D: bool>(
        &self,
        s: S,
        blocks: &TileBlocks,
        run: &[RunBlock],
        wanted: &[usize],
        first: usize,
        out: &mut RunValues,
    ) {
        let Some(words) = Words::new(bytemuck::cast_slice(&self.words)) else {
            return;
        };
        let columns = out.columns.get_mut(first..);
        let Some(columns) = columns.and_then(|columns| columns.get_mut(..wanted.len())) else {
            return;
        };
        let inv_w = &mut out.inv_w;
        let mut out = Columns { inv_w, columns };
        let (mut spread, mut spread_slot) = (One::NONE, NONE);
        for (i, &at) in run.iter().enumerate().take(RUN / LANES) {
            if at.mask == 0 {
                continue;
            }
            let centres = centres(s, at.block);
            let (slots, first, one) = self.slots_of(s, blocks, at);
            if one {
                if first != spread_slot {
                    (spread, spread_slot) = (One::new(self, first), first);
                }
                out.put::<S, _, D>(s, i, &spread, centres, wanted);
            } else {
                let own = Own::new(s, self, words, slots);
                out.put::<S, _, D>(s, i, &own, centres, wanted);
            }
            if !self.is_plain() {
                self.mend_columns::<S, D>(s, (i, at), slots, one, wanted, &mut out);
            }
        }
    }

    /// Shows `sink` the values of two attributes in each block of `run` that has pixels, in registers; derivatives only where
    /// `D` asks for them. For stages that are generic over the SIMD level; outside semantic versioning.
    #[inline(always)]
    pub fn each_block<S: Simd, const D: bool, K: BlockSink<S>>(
        &self,
        s: S,
        blocks: &TileBlocks,
        run: &[RunBlock],
        wanted: [usize; 2],
        sink: &mut K,
    ) {
        let Some(words) = Words::new(bytemuck::cast_slice(&self.words)) else {
            return;
        };
        let (mut spread, mut spread_slot) = (OnePair::NONE, NONE);
        for (i, &at) in run.iter().enumerate() {
            if at.mask == 0 {
                continue;
            }
            let centres = centres(s, at.block);
            let (slots, first, one) = self.slots_of(s, blocks, at);
            let mut values;
            if one {
                if first != spread_slot {
                    (spread, spread_slot) = (OnePair::new(self, first, wanted), first);
                }
                values = spread.on_row(s, centres[1]).values::<D>(s, centres[0]);
            } else {
                let planes = three_planes(s, self, words, slots, [0, 1 + wanted[0], 1 + wanted[1]]);
                values = pair_of::<S, D>(s, planes, centres);
            }
            if !self.is_plain() {
                self.mend::<S, D>(s, slots, at, one, wanted, &mut values);
            }
            sink.block(s, i, at, &values);
        }
    }

    /// [`each_block`](Self::each_block) for blocks that all name their slot, where the table [is plain](Self::is_plain): what the
    /// blocks of a row share stays in registers.
    #[inline(always)]
    pub fn each_named<S: Simd, const D: bool, K: BlockSink<S>>(
        &self,
        s: S,
        run: &[RunBlock],
        wanted: [usize; 2],
        sink: &mut K,
    ) {
        let same = |a: &RunBlock, b: &RunBlock| (a.slot, a.block / ROW) == (b.slot, b.block / ROW);
        let mut first = 0;
        for part in run.chunk_by(same) {
            let pair = OnePair::new(self, part[0].slot, wanted);
            let [_, py] = centres(s, part[0].block);
            let on_row = pair.on_row(s, py);
            for (i, &at) in part.iter().enumerate() {
                let [px, _] = centres(s, at.block);
                sink.block(s, first + i, at, &on_row.values::<D>(s, px));
            }
            first += part.len();
        }
    }

    /// [`each_block`](Self::each_block) for pixels that lie anywhere in the tile: block k of `run` is the pixels from 16 k on of
    /// `pixels`, by their places in the tile's blocks (see [`block_index`](crate::block_index)), each of its own slot. Only where
    /// [`is_plain`](Self::is_plain).
    #[inline(always)]
    pub fn each_sixteen<S: Simd, const D: bool, K: BlockSink<S>>(
        &self,
        s: S,
        [pixels, slots]: [&[u32]; 2],
        run: &[RunBlock],
        wanted: [usize; 2],
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
            let centres = [
                x.to_float::<f32x16<S>>() - half,
                y.to_float::<f32x16<S>>() - half,
            ];
            let slots = u32x16::from_slice(s, slots);
            let planes = three_planes(s, self, words, slots, [0, 1 + wanted[0], 1 + wanted[1]]);
            sink.block(s, i, at, &pair_of::<S, D>(s, planes, centres));
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

/// Two attributes of pixels by their planes of 1/w and both.
#[inline(always)]
fn pair_of<S: Simd, const D: bool>(
    s: S,
    [w, first, second]: [Plane<S>; 3],
    [px, py]: [f32x16<S>; 2],
) -> BlockValues<S> {
    let planes = [
        &OnRow::new(w, py),
        &OnRow::new(first, py),
        &OnRow::new(second, py),
    ];
    BlockValues::new::<D>(s, planes, None, px)
}

/// The centres of the first pixels of a tile's rows of blocks, and of its columns, from the tile's middle.
static CENTRES: [f32; BLOCKS] = {
    let mut centres = [0.0; BLOCKS];
    let mut i = 0;
    while i < BLOCKS {
        centres[i] = (4 * i) as f32 - (TILE as f32 / 2.0 - 0.5);
        i += 1;
    }
    centres
};

/// Pixel centres of a block from the tile's middle.
#[inline(always)]
fn centres<S: Simd>(s: S, block: u16) -> [f32x16<S>; 2] {
    let block = usize::from(block);
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
    [
        column + CENTRES[block % BLOCKS],
        row + CENTRES[block / BLOCKS % BLOCKS],
    ]
}

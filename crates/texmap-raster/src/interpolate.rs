//! Values over a run of pixels: attributes, their derivatives and 1/w.
use alloc::vec::Vec;

use texmap_math::simd::{GatherTable, Isa, prelude::*};
use texmap_math::{Level, dispatch_simd};

use crate::coverage::stamp::{BLOCK_PIXELS, BLOCKS, block_lanes};
use crate::setup::TILE;
use crate::setup::plane_table::AttributePlanes;
use crate::setup::planes::{COEFFICIENTS, RowPlane};
use crate::visibility::blocks::TileVisibility;
use crate::visibility::visible::NO_PRIMITIVE;

mod f64_fallback;
mod planes;
mod steepest;
mod values;

use f64_fallback::RowCache;
pub(crate) use planes::One;
use planes::{OnePair, Own, three_planes};
use values::Columns;
pub use values::{BlockSink, BlockValues};

/// Blocks across a tile.
const ROW: u16 = BLOCKS as u16;

/// Pixels a run holds at most.
pub const BATCH_PIXELS: usize = 256;

/// Length of a run's arrays. Their distance in memory is no multiple of 4096 bytes, or stores to one would stall loads of
/// another.
pub const BATCH_STRIDE: usize = BATCH_PIXELS + 16;

/// One block of a run: which 4x4 block of the tile and which of its pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FragmentBlock {
    /// Block, row by row in the tile.
    pub block: u16,
    /// Bit per pixel, row by row in the block.
    pub mask: u16,
    /// The slot of all pixels, or [`NO_PRIMITIVE`]: each pixel's own, as the tile's blocks have it.
    pub slot: u32,
}

/// Attributes over a run of up to sixteen blocks: sixteen pixels a block, in the order of the run.
#[derive(Debug, Clone, PartialEq)]
pub struct Varyings {
    /// 1 / clip w.
    pub inv_w: [f32; BATCH_STRIDE],
    /// The varyings that were asked for, in that order.
    pub varyings: Vec<Varying>,
}

/// One attribute over a run.
#[derive(Debug, Clone, PartialEq)]
pub struct Varying {
    /// Values.
    pub value: [f32; BATCH_STRIDE],
    /// Change per pixel to the right.
    pub ddx: [f32; BATCH_STRIDE],
    /// Change per pixel down.
    pub ddy: [f32; BATCH_STRIDE],
}

impl Default for Varyings {
    fn default() -> Self {
        Self {
            inv_w: [0.0; BATCH_STRIDE],
            varyings: Vec::new(),
        }
    }
}

impl Varying {
    /// Nothing but zeros.
    pub const ZERO: Self = Self {
        value: [0.0; BATCH_STRIDE],
        ddx: [0.0; BATCH_STRIDE],
        ddy: [0.0; BATCH_STRIDE],
    };
}

impl AttributePlanes {
    /// Attributes `wanted` over up to sixteen blocks; pixels outside the masks hold no meaning. The bits are those of
    /// [`BinnedDraws::evaluate`](crate::BinnedDraws::evaluate), at every level. Without `derivatives` these hold no meaning either.
    pub fn values(
        &self,
        level: Level,
        blocks: &TileVisibility,
        run: &[FragmentBlock],
        wanted: &[usize],
        derivatives: bool,
        out: &mut Varyings,
    ) {
        if out.varyings.len() < wanted.len() {
            out.varyings.resize(wanted.len(), Varying::ZERO);
        }
        dispatch_simd!(level, wide i => if derivatives {
            self.each_column::<_, true>(i, blocks, run, wanted, 0, out);
        } else {
            self.each_column::<_, false>(i, blocks, run, wanted, 0, out);
        });
    }

    /// Stores the values of attributes `wanted` in each block of `run` that has pixels, one attribute a column from column
    /// `first` on. Nothing is stored where columns are missing; derivatives only if `D` asks for them. For stages that are
    /// generic over the lane width; outside semantic versioning.
    #[inline(never)]
    pub fn each_column<I: Isa, const D: bool>(
        &self,
        i: I,
        blocks: &TileVisibility,
        run: &[FragmentBlock],
        wanted: &[usize],
        first: usize,
        out: &mut Varyings,
    ) {
        i.vectorize(
            #[inline(always)]
            || self.columns_lanes::<I, D>(i, blocks, run, wanted, first, out),
        );
    }

    #[inline(always)]
    fn columns_lanes<I: Isa, const D: bool>(
        &self,
        i: I,
        blocks: &TileVisibility,
        run: &[FragmentBlock],
        wanted: &[usize],
        first: usize,
        out: &mut Varyings,
    ) {
        let Some(words) = GatherTable::new(bytemuck::cast_slice(&self.words)) else {
            return;
        };
        let columns = out.varyings.get_mut(first..);
        let Some(columns) = columns.and_then(|columns| columns.get_mut(..wanted.len())) else {
            return;
        };
        let inv_w = &mut out.inv_w;
        let mut out = Columns { inv_w, columns };
        let (mut shared, mut shared_slot) = (One::NONE, NO_PRIMITIVE);
        let mut rows = None::<RowCache>;
        for (k, &block) in run.iter().enumerate().take(BATCH_PIXELS / BLOCK_PIXELS) {
            for at in (0..BLOCK_PIXELS).step_by(I::LANES) {
                let part = Part { block, at };
                if part.mask(i) == 0 {
                    continue;
                }
                let (place, centres) = (k * BLOCK_PIXELS + at, part.centres(i));
                let slots = self.slots_of(i, blocks, part);
                if slots.one {
                    if slots.first != shared_slot {
                        (shared, shared_slot) = (One::new(self, slots.first), slots.first);
                    }
                    out.put::<I, _, D>(i, place, &shared, centres, wanted);
                } else {
                    let own = Own::new(i, self, words, slots.each);
                    out.put::<I, _, D>(i, place, &own, centres, wanted);
                }
                if !self.is_branch_free() {
                    let rows = rows.get_or_insert_default();
                    self.mend_columns::<I, D>(i, (place, part), &slots, wanted, rows, &mut out);
                }
            }
        }
    }

    /// Shows `sink` the values of two attributes in each block of `run` that has pixels, in registers. Derivatives only where
    /// `D` asks for them. For stages that are generic over the lane width; outside semantic versioning.
    #[inline(always)]
    pub fn each_block<I: Isa, const D: bool, K: BlockSink<I>>(
        &self,
        i: I,
        blocks: &TileVisibility,
        run: &[FragmentBlock],
        wanted: [usize; 2],
        sink: &mut K,
    ) {
        let Some(words) = GatherTable::new(bytemuck::cast_slice(&self.words)) else {
            return;
        };
        let (mut shared, mut shared_slot) = (OnePair::NONE, NO_PRIMITIVE);
        let mut rows = None::<RowCache>;
        for (k, &block) in run.iter().enumerate() {
            for at in (0..BLOCK_PIXELS).step_by(I::LANES) {
                let part = Part { block, at };
                if part.mask(i) == 0 {
                    continue;
                }
                let centres = part.centres(i);
                let slots = self.slots_of(i, blocks, part);
                let mut values;
                if slots.one {
                    if slots.first != shared_slot {
                        let pair = OnePair::new(self, slots.first, wanted);
                        (shared, shared_slot) = (pair, slots.first);
                    }
                    values = shared.on_row(i, centres[1]).values::<D>(i, centres[0]);
                } else {
                    let of = [0, 1 + wanted[0], 1 + wanted[1]];
                    let planes = three_planes(i, self, words, slots.each, of);
                    values = pair_of::<I, D>(i, planes, centres);
                }
                if !self.is_branch_free() {
                    let rows = rows.get_or_insert_default();
                    self.mend::<I, D>(i, part, &slots, wanted, rows, &mut values);
                }
                sink.pixels(i, k * BLOCK_PIXELS + at, block, &values);
            }
        }
    }

    /// [`each_block`](Self::each_block) for blocks that all name their slot. Only if the table [is plain](Self::is_branch_free):
    /// what the blocks of a row share stays in registers.
    #[inline(always)]
    pub fn each_named<I: Isa, const D: bool, K: BlockSink<I>>(
        &self,
        i: I,
        run: &[FragmentBlock],
        wanted: [usize; 2],
        sink: &mut K,
    ) {
        let same = |a: &FragmentBlock, b: &FragmentBlock| {
            (a.slot, a.block / ROW) == (b.slot, b.block / ROW)
        };
        let mut first = 0;
        for blocks in run.chunk_by(same) {
            let pair = OnePair::new(self, blocks[0].slot, wanted);
            let [_, py] = centres(i, blocks[0].block, 0);
            let on_row = pair.on_row(i, py);
            for (k, &block) in blocks.iter().enumerate() {
                for at in (0..BLOCK_PIXELS).step_by(I::LANES) {
                    let [px, py] = centres(i, block.block, at);
                    let values = if at == 0 {
                        on_row.values::<D>(i, px)
                    } else {
                        pair.on_row(i, py).values::<D>(i, px)
                    };
                    sink.pixels(i, (first + k) * BLOCK_PIXELS + at, block, &values);
                }
            }
            first += blocks.len();
        }
    }

    /// [`each_block`](Self::each_block) for pixels that lie anywhere in the tile. Block k of `run` is the pixels from 16 k on of
    /// `pixels`, by their indices in the tile's blocks (see [`block_index`](crate::block_index)), each of its own slot. Only
    /// where [`is_branch_free`](Self::is_branch_free).
    #[inline(always)]
    pub fn each_sixteen<I: Isa, const D: bool, K: BlockSink<I>>(
        &self,
        i: I,
        [pixels, slots]: [&[u32]; 2],
        run: &[FragmentBlock],
        wanted: [usize; 2],
        sink: &mut K,
    ) {
        let Some(words) = GatherTable::new(bytemuck::cast_slice(&self.words)) else {
            return;
        };
        let half = TILE as f32 / 2.0 - 0.5;
        for (k, &block) in run.iter().enumerate() {
            for at in (0..BLOCK_PIXELS).step_by(I::LANES) {
                let of = block.block as usize * BLOCK_PIXELS + at;
                let of = of..of + I::LANES;
                let (Some(pixels), Some(slots)) = (pixels.get(of.clone()), slots.get(of)) else {
                    return;
                };
                let pixels = i.load_u32(pixels).to_i32();
                let x = ((pixels >> 2) & 60) | (pixels & 3);
                let y = ((pixels >> 6) & 60) | ((pixels >> 2) & 3);
                let centres = [x.to_f32() - half, y.to_f32() - half];
                let of = [0, 1 + wanted[0], 1 + wanted[1]];
                let planes = three_planes(i, self, words, i.load_u32(slots), of);
                let values = pair_of::<I, D>(i, planes, centres);
                sink.pixels(i, k * BLOCK_PIXELS + at, block, &values);
            }
        }
    }

    /// True if f32 planes serve all slots, and all attributes are exact.
    #[must_use]
    pub fn is_branch_free(&self) -> bool {
        self.plain
    }

    /// The slots of a part's pixels. Lanes outside the mask take the first pixel's.
    #[inline(always)]
    pub(crate) fn slots_of<I: Isa>(&self, i: I, blocks: &TileVisibility, part: Part) -> Slots<I> {
        let all = |slot| Slots {
            each: i.u32(slot),
            first: slot,
            one: true,
        };
        if part.block.slot != NO_PRIMITIVE {
            return all(part.block.slot);
        }
        let start = part.block.block as usize * BLOCK_PIXELS + part.at;
        let Some(slots) = blocks.slot.get(start..start + I::LANES) else {
            return all(0);
        };
        let mask = part.mask(i);
        let first = slots[mask.trailing_zeros() as usize % I::LANES];
        let each = i
            .mask_from_bits(mask)
            .select(i.load_u32(slots), i.u32(first));
        Slots {
            each,
            first,
            one: each.simd_eq(first).all_true(),
        }
    }
}

/// Pixels of a block from pixel `at` on, as many as there are lanes.
#[derive(Clone, Copy)]
pub(crate) struct Part {
    pub(crate) block: FragmentBlock,
    pub(crate) at: usize,
}

impl Part {
    /// Pixels of the part in the block's mask.
    #[inline(always)]
    pub(crate) fn mask<I: Isa>(self, _: I) -> u32 {
        u32::from(self.block.mask) >> self.at & ((1 << I::LANES) - 1)
    }

    #[inline(always)]
    fn centres<I: Isa>(self, i: I) -> [I::F32; 2] {
        centres(i, self.block.block, self.at)
    }
}

/// The slots of a part's pixels.
pub(crate) struct Slots<I: Isa> {
    pub(crate) each: I::U32,
    /// Slot of the first pixel in the mask.
    pub(crate) first: u32,
    /// True if all slots are the first.
    pub(crate) one: bool,
}

/// Two attributes of pixels by their planes of 1/w and both.
#[inline(always)]
fn pair_of<I: Isa, const D: bool>(
    i: I,
    [w, first, second]: [[I::F32; COEFFICIENTS]; 3],
    [px, py]: [I::F32; 2],
) -> BlockValues<I> {
    let planes = [
        &RowPlane::new(w, py),
        &RowPlane::new(first, py),
        &RowPlane::new(second, py),
    ];
    BlockValues::new::<D>(i, planes, None, px)
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

/// Pixel centres of a block from pixel `at` on, from the tile's middle.
#[inline(always)]
fn centres<I: Isa>(i: I, block: u16, at: usize) -> [I::F32; 2] {
    let block = usize::from(block);
    let [column, row] = block_lanes(i, at);
    [
        column.to_f32() + CENTRES[block % BLOCKS],
        row.to_f32() + CENTRES[block / BLOCKS % BLOCKS],
    ]
}

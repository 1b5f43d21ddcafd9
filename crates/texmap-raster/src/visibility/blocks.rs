//! Visibility of a tile in 4x4 blocks.
use alloc::vec::Vec;

use texmap_math::dispatch_simd;
use texmap_math::simd::Isa;

use crate::coverage::hierarchical_z::Floor;
use crate::coverage::stamp::{BLOCK_PIXELS, BLOCKS, stamp_group};
use crate::front_end::prepared::{Tile, decides_visibility};
use crate::interpolate::FragmentBlock;
use crate::setup::TILE;
use crate::setup::group::{GROUP, Group, Known, Sharing};
use crate::visibility::runs::{Run, Runs};
use crate::visibility::sinks::{Alone, CutOut, Forward, Last, Visible};
use crate::visibility::visible::{AlphaTest, NO_PRIMITIVE};
use crate::{BinnedDraws, DepthTest, DrawCall, Pass};

/// The four samples of a pixel, in 1/256 pixel to the right of its centre and below it: the standard locations of Vulkan 1.4,
/// section Multisampling (also those of Direct3D and, turned over with its rows, of OpenGL on llvmpipe).
pub const SAMPLES_4: [[i32; 2]; 4] = [[-32, -96], [96, -32], [-96, 32], [32, 96]];

/// Pixels of a tile.
pub(crate) const PIXELS: usize = (TILE * TILE) as usize;

/// Depth and fragment of a tile's pixels in 4x4 blocks: see [`block_index`](crate::block_index).
#[derive(Debug, Clone)]
pub struct TileVisibility {
    /// Reversed depth: 0 where nothing was drawn.
    pub depth: Vec<f32>,
    /// Slot of the triangle that is seen, [`NO_PRIMITIVE`] where nothing was drawn; `ids` names it.
    pub slot: Vec<u32>,
    /// Of each 4x4 block, a bit per pixel where something was drawn.
    pub masks: Vec<u16>,
    /// The id of each slot, [`NO_PRIMITIVE`] for slots that are not used.
    pub ids: Vec<u32>,
    /// The draw of each sixteen slots: slot k belongs to draw `draws[k / 16]`.
    pub draws: Vec<u32>,
    /// Blocks whose depth and slots are those of this tile.
    touched: Vec<bool>,
    group: Group,
}

/// Buffers for what [`BinnedDraws::visible_samples`] sets up once for all samples.
#[derive(Debug, Clone, Default)]
pub struct SampleSetup {
    known: Vec<Known>,
}

impl Default for TileVisibility {
    fn default() -> Self {
        Self {
            depth: alloc::vec![0.0; PIXELS],
            slot: alloc::vec![NO_PRIMITIVE; PIXELS],
            masks: alloc::vec![0; PIXELS / BLOCK_PIXELS],
            ids: Vec::new(),
            draws: Vec::new(),
            touched: alloc::vec![true; PIXELS / BLOCK_PIXELS],
            group: Group::default(),
        }
    }
}

impl TileVisibility {
    /// Cleared blocks.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Without buffers: the value that remains while the blocks are lent out.
    pub(crate) fn empty() -> Self {
        Self {
            depth: Vec::new(),
            slot: Vec::new(),
            masks: Vec::new(),
            ids: Vec::new(),
            draws: Vec::new(),
            touched: Vec::new(),
            group: Group::default(),
        }
    }

    /// Far depth and no fragment everywhere.
    pub fn clear(&mut self) {
        self.depth.clear();
        self.depth.resize(PIXELS, 0.0);
        self.slot.clear();
        self.slot.resize(PIXELS, NO_PRIMITIVE);
        self.masks.clear();
        self.masks.resize(PIXELS / BLOCK_PIXELS, 0);
    }

    /// Forgets a tile; [`settle`](Self::settle) clears what the next one has not touched.
    fn forget(&mut self) {
        self.depth.resize(PIXELS, 0.0);
        self.slot.resize(PIXELS, NO_PRIMITIVE);
        self.masks.clear();
        self.masks.resize(PIXELS / BLOCK_PIXELS, 0);
        self.touched.clear();
        self.touched.resize(PIXELS / BLOCK_PIXELS, false);
    }

    fn settle(&mut self) {
        let blocks = self.depth.chunks_exact_mut(BLOCK_PIXELS);
        let blocks = blocks.zip(self.slot.chunks_exact_mut(BLOCK_PIXELS));
        for ((depth, slots), touched) in blocks.zip(&mut self.touched) {
            if !*touched {
                depth.fill(0.0);
                slots.fill(NO_PRIMITIVE);
                *touched = true;
            }
        }
    }

    /// Takes back what reached over the target's right and lower edge.
    fn trim(&mut self, tile: Tile) {
        if tile.is_whole() {
            return;
        }
        for y in 0..TILE {
            let first = if y < tile.height { tile.width } else { 0 };
            for x in first..TILE {
                let index = crate::block_index(x, y);
                self.depth[index] = 0.0;
                self.slot[index] = NO_PRIMITIVE;
                self.masks[index / BLOCK_PIXELS] &= !(1 << (index % BLOCK_PIXELS));
            }
        }
    }
}

impl BinnedDraws<'_> {
    /// [`visible`](Self::visible) in blocks of 4x4, at the level that this was prepared with.
    pub fn visible_blocks(&self, tile: usize, alpha: &dyn AlphaTest, out: &mut TileVisibility) {
        self.visible_sample(tile, [0; 2], alpha, out);
    }

    /// [`visible_blocks`](Self::visible_blocks) at one sample a pixel, `offset` from its centre. In 1/256 pixel to the
    /// right and down, each in -128..=127 (see [`SAMPLES_4`](crate::SAMPLES_4)). Only for what was prepared
    /// [`with_samples`](Self::with_samples); without, triangles between the centres are missing. Cut-outs are asked at the
    /// centre, so that all samples of a pixel get one answer.
    pub fn visible_sample(
        &self,
        tile: usize,
        offset: [i32; 2],
        alpha: &dyn AlphaTest,
        out: &mut TileVisibility,
    ) {
        self.visible_shared(tile, offset, alpha, None, out);
    }

    /// [`visible_sample`](Self::visible_sample) at each of `samples`: what they share of the triangles is set up once.
    pub fn visible_samples<'b>(
        &self,
        tile: usize,
        alpha: &dyn AlphaTest,
        shared: &mut SampleSetup,
        samples: impl IntoIterator<Item = ([i32; 2], &'b mut TileVisibility)>,
    ) {
        let known = &mut shared.known;
        known.clear();
        let mut first = true;
        for (offset, out) in samples {
            self.visible_shared(tile, offset, alpha, Some((&mut *known, first)), out);
            first = false;
        }
    }

    /// The flag of `known` says that it is to be filled.
    fn visible_shared(
        &self,
        tile: usize,
        offset: [i32; 2],
        alpha: &dyn AlphaTest,
        known: Option<(&mut Vec<Known>, bool)>,
        out: &mut TileVisibility,
    ) {
        self.name_slots(tile, out);
        out.group.offset = offset;
        dispatch_simd!(self.level(), wide i => self.visible_lanes(i, tile, alpha, known, out));
        out.group.offset = [0; 2];
    }

    /// Covers a tile that one opaque triangle has for itself, with every depth test passed: its pixels, as the `masks` of `out`;
    /// all are of slot 0, and `slot` and `depth` hold nothing. False, with nothing done, for other tiles.
    pub fn covering_primitive(&self, tile: usize, out: &mut TileVisibility) -> bool {
        let [id] = self.bin_of(tile) else {
            return false;
        };
        let draw = self.source(*id).0 as usize;
        if self.draw(draw as u32).pass != Pass::Opaque {
            return false;
        }
        dispatch_simd!(self.level(), wide i => self.alone_lanes(i, tile, draw, out))
    }

    #[inline(always)]
    fn alone_lanes<I: Isa>(
        &self,
        i: I,
        tile: usize,
        draw: usize,
        out: &mut TileVisibility,
    ) -> bool {
        self.setup_group(
            i,
            draw,
            self.bin_of(tile),
            tile as u32,
            Sharing::Nothing,
            &mut out.group,
        );
        // Depth is clamped to the triangle's, and 0 where nothing was drawn.
        let nearer = out.group.z_lo[0] > 0.0;
        if !nearer && self.draw(draw as u32).depth_test != DepthTest::Always {
            return false;
        }
        self.name_slots(tile, out);
        let TileVisibility { masks, group, .. } = out;
        masks.clear();
        if group.live != 0 && group.covers_tile(0) {
            masks.resize(PIXELS / BLOCK_PIXELS, u16::MAX);
        } else {
            masks.resize(PIXELS / BLOCK_PIXELS, 0);
            stamp_group(i, group, false, &mut Alone { masks });
        }
        out.trim(self.tile(tile));
        true
    }

    fn name_slots(&self, tile: usize, out: &mut TileVisibility) {
        out.ids.clear();
        out.draws.clear();
        let mut runs = Runs::new(self, tile);
        while let Some(run) = runs.next() {
            out.ids.extend_from_slice(run.ids);
            out.ids.resize(run.first_slot + GROUP, NO_PRIMITIVE);
            out.draws.push(run.draw as u32);
        }
    }

    #[inline(always)]
    fn visible_lanes<I: Isa>(
        &self,
        i: I,
        tile: usize,
        alpha: &dyn AlphaTest,
        mut known: Option<(&mut Vec<Known>, bool)>,
        out: &mut TileVisibility,
    ) {
        out.forget();
        let bounds = self.tile(tile);
        let mut group = core::mem::take(&mut out.group);
        if self.last_is_seen(out) {
            self.last_lanes(i, tile, &mut group, out);
            out.group = group;
            out.settle();
            out.trim(bounds);
            return;
        }
        let mut runs = Runs::new(self, tile);
        let mut group_index = 0;
        let mut floor = Floor::default();
        while let Some(run) = runs.next() {
            let draw = self.draw(run.draw as u32);
            if !decides_visibility(draw.pass) {
                continue;
            }
            let sharing = match &mut known {
                None => Sharing::Nothing,
                Some((known, true)) => {
                    known.push(Known::default());
                    known.last_mut().map_or(Sharing::Nothing, Sharing::Keep)
                }
                Some((known, false)) => known
                    .get(group_index)
                    .map_or(Sharing::Nothing, Sharing::Use),
            };
            group_index += 1;
            self.setup_group(i, run.draw, run.ids, tile as u32, sharing, &mut group);
            floor.drop_hidden(i, draw, &mut group);
            let plain =
                draw.pass == Pass::Opaque && draw.depth_test == DepthTest::Less && draw.depth_write;
            if plain {
                self.stamp_visible::<I, true>(i, bounds, &run, &group, alpha, out);
            } else {
                self.stamp_visible::<I, false>(i, bounds, &run, &group, alpha, out);
            }
            floor.rise(draw, &group);
        }
        out.group = group;
        out.settle();
        out.trim(bounds);
    }

    /// Out of line: compiled once a level, with the registers for itself.
    #[inline(never)]
    fn stamp_visible<I: Isa, const PLAIN: bool>(
        &self,
        i: I,
        tile: Tile,
        run: &Run<'_>,
        group: &Group,
        alpha: &dyn AlphaTest,
        out: &mut TileVisibility,
    ) {
        let (Some(depth), Some(slots), Some(masks), Some(touched)) = (
            out.depth.first_chunk_mut(),
            out.slot.first_chunk_mut(),
            out.masks.first_chunk_mut(),
            out.touched.first_chunk_mut(),
        ) else {
            return;
        };
        let draw = self.draw(run.draw as u32);
        let mut sink = Visible::<PLAIN> {
            depth,
            slots,
            masks,
            touched,
            first_slot: run.first_slot as u32,
            test: draw.depth_test,
            write: draw.depth_write,
            cut: (draw.pass == Pass::CutOut).then_some(CutOut {
                prepared: self,
                ids: run.ids,
                tile,
                draw: run.draw as u32,
                alpha,
                setup: None,
            }),
        };
        i.vectorize(
            #[inline(always)]
            || stamp_group(i, group, false, &mut sink),
        );
    }

    /// True if the last fragment of each pixel is seen, with its depth: none is tested, none cut out.
    fn last_is_seen(&self, out: &TileVisibility) -> bool {
        let all = out.draws.iter().map(|draw| self.draw(*draw));
        let mut deciding = all.filter(|d| decides_visibility(d.pass));
        let Some(first) = deciding.clone().next() else {
            return false;
        };
        deciding.all(|d| {
            d.depth_test == DepthTest::Always
                && d.pass == Pass::Opaque
                && d.depth_write == first.depth_write
        })
    }

    /// Draws triangles from the last to the first, each only at pixels that are still free, until all are covered.
    #[inline(always)]
    fn last_lanes<I: Isa>(&self, i: I, tile: usize, group: &mut Group, out: &mut TileVisibility) {
        let mut last = Last {
            depth: &mut out.depth,
            slots: &mut out.slot,
            masks: &mut out.masks,
            touched: &mut out.touched,
            full: 0,
            first_slot: 0,
            write: false,
        };
        let bin = self.bin_of(tile);
        let mut end = bin.len();
        for (group_index, draw) in out.draws.iter().enumerate().rev() {
            let used = out.ids[group_index * GROUP..].iter().take(GROUP);
            let count = used.take_while(|id| **id != NO_PRIMITIVE).count();
            let ids = &bin[end - count..end];
            end -= count;
            let state = self.draw(*draw);
            if !decides_visibility(state.pass) {
                continue;
            }
            last.write = state.depth_write;
            self.setup_group(i, *draw as usize, ids, tile as u32, Sharing::Nothing, group);
            last.first_slot = (group_index * GROUP) as u32;
            stamp_group(i, group, true, &mut last);
            if last.full == PIXELS / BLOCK_PIXELS {
                return;
            }
        }
    }

    /// Lists each 4x4 block of the draws `wanted` picks: slot, block, and a bit for each pixel that
    /// passes the depth test against `blocks`, in submitted order, with the slots of [`visible_blocks`](Self::visible_blocks).
    /// Draws that write depth do so before the next block.
    pub fn forward_blocks(
        &self,
        tile: usize,
        blocks: &mut TileVisibility,
        wanted: &dyn Fn(&DrawCall<'_>) -> bool,
        out: &mut Vec<FragmentBlock>,
    ) {
        self.forward_sample(tile, [0; 2], blocks, wanted, out);
    }

    /// [`forward_blocks`](Self::forward_blocks) at a sample, as [`visible_sample`](Self::visible_sample).
    pub fn forward_sample(
        &self,
        tile: usize,
        offset: [i32; 2],
        blocks: &mut TileVisibility,
        wanted: &dyn Fn(&DrawCall<'_>) -> bool,
        out: &mut Vec<FragmentBlock>,
    ) {
        self.name_slots(tile, blocks);
        blocks.group.offset = offset;
        dispatch_simd!(self.level(), wide i => self.forward_lanes(i, tile, blocks, wanted, out));
        blocks.group.offset = [0; 2];
    }

    #[inline(always)]
    fn forward_lanes<I: Isa>(
        &self,
        i: I,
        tile: usize,
        blocks: &mut TileVisibility,
        wanted: &dyn Fn(&DrawCall<'_>) -> bool,
        out: &mut Vec<FragmentBlock>,
    ) {
        let bounds = self.tile(tile);
        let mut group = core::mem::take(&mut blocks.group);
        let mut runs = Runs::new(self, tile);
        while let Some(run) = runs.next() {
            let draw = self.draw(run.draw as u32);
            if !wanted(draw) {
                continue;
            }
            self.setup_group(
                i,
                run.draw,
                run.ids,
                tile as u32,
                Sharing::Nothing,
                &mut group,
            );
            let mut forward = Forward {
                depth: &mut blocks.depth,
                first_slot: run.first_slot as u32,
                test: draw.depth_test,
                write: draw.depth_write && draw.pass != Pass::Blended,
                tile: bounds,
                whole: bounds.is_whole(),
                out,
            };
            stamp_group(i, &group, false, &mut forward);
        }
        blocks.group = group;
    }
}

/// A pixel of a block, from the tile's corner.
pub(crate) fn pixel_of(block: usize, bit: u32) -> (u32, u32) {
    let (bx, by) = ((block % BLOCKS) as u32, (block / BLOCKS) as u32);
    (bx * 4 + bit % 4, by * 4 + bit / 4)
}

//! Visibility: per pixel the nearest depth and the fragment that has it.
use alloc::vec::Vec;

use crate::coverage::stamp::BLOCK_PIXELS;
use crate::front_end::prepared::decides_visibility;
use crate::setup::{Fragment, TILE};
use crate::visibility::blocks::{TileVisibility, pixel_of};
use crate::{BinnedDraws, block_index};

/// The id of a pixel where nothing was drawn.
pub const NO_PRIMITIVE: u32 = u32::MAX;

/// Depth and fragment id of a tile's pixels: 64x64 values, row by row from the top. The row length is 64 for narrow tiles too.
#[derive(Debug, Clone)]
pub struct VisibilityBuffer {
    /// Reversed depth: 0 where nothing was drawn.
    pub depth: Vec<f32>,
    /// Fragment id, [`NO_PRIMITIVE`] where nothing was drawn.
    pub id: Vec<u32>,
    blocks: TileVisibility,
}

impl Default for VisibilityBuffer {
    fn default() -> Self {
        let pixels = (TILE * TILE) as usize;
        Self {
            depth: alloc::vec![0.0; pixels],
            id: alloc::vec![NO_PRIMITIVE; pixels],
            blocks: TileVisibility::new(),
        }
    }
}

impl VisibilityBuffer {
    /// Cleared buffers.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Far depth and no fragment everywhere.
    pub fn clear(&mut self) {
        let pixels = (TILE * TILE) as usize;
        self.depth.clear();
        self.depth.resize(pixels, 0.0);
        self.id.clear();
        self.id.resize(pixels, NO_PRIMITIVE);
    }
}

/// Decides which fragments of a [`Pass::CutOut`](crate::Pass::CutOut) draw exist.
pub trait AlphaTest {
    /// True if the fragment is kept.
    fn keep(&self, draw: u32, triangle: u32, fragment: &Fragment) -> bool;

    /// [`keep`](Self::keep) for those of sixteen fragments that are `asked` for, a bit each, by the first two attributes. `None`
    /// if these do not decide: the fragments are asked about one by one then.
    fn keep_by_uv(&self, _draw: u32, _at: &UvBlock, _asked: u16) -> Option<u16> {
        None
    }
}

/// The first two attributes of the sixteen pixels of a block.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct UvBlock {
    /// Values.
    pub value: [[f32; BLOCK_PIXELS]; 2],
    /// Change per pixel to the right.
    pub ddx: [[f32; BLOCK_PIXELS]; 2],
    /// Change per pixel down.
    pub ddy: [[f32; BLOCK_PIXELS]; 2],
}

/// Keeps everything: for scenes without cut-outs.
#[derive(Debug, Clone, Copy, Default)]
pub struct NoAlphaTest;

impl AlphaTest for NoAlphaTest {
    #[inline(always)]
    fn keep(&self, _draw: u32, _triangle: u32, _fragment: &Fragment) -> bool {
        true
    }
}

impl BinnedDraws<'_> {
    /// Clears `out` and finds what is visible of the opaque and cut-out draws: the nearest fragment, of equals the first
    /// submitted ([`DepthTest::LessOrEqual`](crate::DepthTest::LessOrEqual): the last).
    pub fn visible<A: AlphaTest>(&self, tile: usize, alpha: &A, out: &mut VisibilityBuffer) {
        let mut blocks = core::mem::replace(&mut out.blocks, TileVisibility::empty());
        self.visible_blocks(tile, alpha, &mut blocks);
        out.clear();
        for y in 0..TILE {
            for x in 0..TILE {
                let (from, to) = (block_index(x, y), (y * TILE + x) as usize);
                out.depth[to] = blocks.depth[from];
                out.id[to] = blocks
                    .ids
                    .get(blocks.slot[from] as usize)
                    .copied()
                    .unwrap_or(NO_PRIMITIVE);
            }
        }
        out.blocks = blocks;
    }

    /// Calls `sink` with each fragment (id, x, y) of the blended draws that passes the depth test. The test is against
    /// `buffers`; fragments come in submitted order, within a triangle in 4x4 blocks.
    pub fn blended(
        &self,
        tile: usize,
        buffers: &VisibilityBuffer,
        sink: &mut dyn FnMut(u32, u32, u32),
    ) {
        let bounds = self.tile(tile);
        let (mut blocks, mut list) = (TileVisibility::new(), Vec::new());
        for (y, row) in (0..TILE).zip(buffers.depth.chunks_exact(TILE as usize)) {
            for (x, depth) in (0..TILE).zip(row) {
                blocks.depth[block_index(x, y)] = *depth;
            }
        }
        let is_blended = |draw: &crate::DrawCall<'_>| !decides_visibility(draw.pass);
        self.forward_blocks(tile, &mut blocks, &is_blended, &mut list);
        for at in list {
            for bit in (0..16).filter(|bit| at.mask >> bit & 1 == 1) {
                let (x, y) = pixel_of(usize::from(at.block), bit);
                sink(blocks.ids[at.slot as usize], bounds.x0 + x, bounds.y0 + y);
            }
        }
    }
}

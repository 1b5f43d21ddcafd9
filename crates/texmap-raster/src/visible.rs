//! Visibility: per pixel the nearest depth and the fragment that has it.
use alloc::vec::Vec;

use texmap_math::lanes::LANES;

use crate::blocks::{Runs, TileBlocks};
use crate::edge::{Edge, PixelBox, cover};
use crate::prepared::decides_visibility;
use crate::setup::{Fragment, TILE, TriangleSetup};
use crate::{DepthTest, Draw, Pass, Prepared, block_index};

/// The id of a pixel where nothing was drawn.
pub const NONE: u32 = u32::MAX;

/// Depth and fragment id of a tile's pixels: 64x64 values, row by row from the top; the row length is 64 for narrow tiles too.
#[derive(Debug, Clone)]
pub struct TileBuffers {
    /// Reversed depth: 0 where nothing was drawn.
    pub depth: Vec<f32>,
    /// Fragment id, [`NONE`] where nothing was drawn.
    pub id: Vec<u32>,
    blocks: TileBlocks,
}

impl Default for TileBuffers {
    fn default() -> Self {
        let pixels = (TILE * TILE) as usize;
        Self {
            depth: alloc::vec![0.0; pixels],
            id: alloc::vec![NONE; pixels],
            blocks: TileBlocks::new(),
        }
    }
}

impl TileBuffers {
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
        self.id.resize(pixels, NONE);
    }
}

/// Decides which fragments of a [`Pass::CutOut`] draw exist.
pub trait AlphaTest {
    /// Whether the fragment is kept.
    fn keep(&self, draw: u32, triangle: u32, fragment: &Fragment) -> bool;

    /// [`keep`](Self::keep) for those of sixteen fragments that are `asked` for, a bit each, where the first two attributes decide;
    /// `None` where they do not: the fragments are asked about one by one then.
    fn keep_by_uv(&self, _draw: u32, _at: &UvBlock, _asked: u16) -> Option<u16> {
        None
    }
}

/// The first two attributes of the sixteen pixels of a block.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct UvBlock {
    /// Values.
    pub value: [[f32; LANES]; 2],
    /// Change per pixel to the right.
    pub ddx: [[f32; LANES]; 2],
    /// Change per pixel down.
    pub ddy: [[f32; LANES]; 2],
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

impl Prepared<'_> {
    /// Clears `out` and finds what is visible of the opaque and cut-out draws: the nearest fragment, of equals the first
    /// submitted ([`DepthTest::LessOrEqual`]: the last).
    pub fn visible<A: AlphaTest>(&self, tile: usize, alpha: &A, out: &mut TileBuffers) {
        let mut blocks = core::mem::replace(&mut out.blocks, TileBlocks::empty());
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
                    .unwrap_or(NONE);
            }
        }
        out.blocks = blocks;
    }

    /// The plain form, pixel by pixel. `at(x, y, depth, slot)` writes what is given at a pixel of the tile and returns the
    /// depth there.
    pub(crate) fn visible_plain(
        &self,
        tile: usize,
        alpha: &dyn AlphaTest,
        offset: [i32; 2],
        mut at: impl FnMut(u32, u32, Option<f32>, Option<u32>) -> f32,
    ) {
        let mut fragment = Fragment::default();
        let bounds = self.tile(tile);
        self.for_each(
            tile,
            &|d| decides_visibility(d.pass),
            offset,
            |of, setup, edges, pixels| {
                let draw = self.draw(of.draw);
                let (_, triangle) = self.source(of.id);
                cover(edges, pixels, |x, y| {
                    let (x, y) = (x as u32, y as u32);
                    let (tx, ty) = (x - bounds.x0, y - bounds.y0);
                    let depth = setup.depth_at(x, y, offset);
                    if !passes(draw.depth_test, depth, at(tx, ty, None, None)) {
                        return;
                    }
                    if draw.pass == Pass::CutOut {
                        setup.evaluate(x, y, &mut fragment);
                        if !alpha.keep(of.draw, triangle, &fragment) {
                            return;
                        }
                    }
                    at(tx, ty, draw.depth_write.then_some(depth), Some(of.slot));
                });
            },
        );
    }

    /// Calls `sink` with each fragment (id, x, y) of the blended draws that passes the depth test against `buffers`, in
    /// submitted order.
    pub fn blended(&self, tile: usize, buffers: &TileBuffers, sink: &mut dyn FnMut(u32, u32, u32)) {
        let bounds = self.tile(tile);
        self.for_each(
            tile,
            &|d| !decides_visibility(d.pass),
            [0; 2],
            |of, setup, edges, pixels| {
                let draw = self.draw(of.draw);
                cover(edges, pixels, |x, y| {
                    let (x, y) = (x as u32, y as u32);
                    let index = ((y - bounds.y0) * TILE + (x - bounds.x0)) as usize;
                    if passes(draw.depth_test, setup.depth(x, y), buffers.depth[index]) {
                        sink(of.id, x, y);
                    }
                });
            },
        );
    }

    /// Visits the tile's triangles of some draws, in submitted order: what it is, set-up, edges, pixels.
    pub(crate) fn for_each(
        &self,
        tile_index: usize,
        wanted: &dyn Fn(&Draw<'_>) -> bool,
        offset: [i32; 2],
        mut visit: impl FnMut(Fragmented, &TriangleSetup, &[Edge; 3], PixelBox),
    ) {
        let tile = self.tile(tile_index);
        let bounds = PixelBox {
            x0: tile.x0 as i32,
            y0: tile.y0 as i32,
            x1: (tile.x0 + tile.width) as i32 - 1,
            y1: (tile.y0 + tile.height) as i32 - 1,
        };
        let mut runs = Runs::new(self, tile_index);
        while let Some(run) = runs.next() {
            let draw_index = run.draw as u32;
            if !wanted(self.draw(draw_index)) {
                continue;
            }
            for (lane, &id) in run.ids.iter().enumerate() {
                let (shape, pixels) = self.shape_at(id, offset);
                if let Some(pixels) = pixels.and_then(|p| p.intersect(bounds)) {
                    let setup = TriangleSetup::new(&shape, tile.x0 / TILE, tile.y0 / TILE);
                    let fragment = Fragmented {
                        slot: (run.first_slot + lane) as u32,
                        id,
                        draw: draw_index,
                    };
                    visit(fragment, &setup, &shape.edges, pixels);
                }
            }
        }
    }
}

/// A triangle of a tile.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Fragmented {
    pub slot: u32,
    pub id: u32,
    pub draw: u32,
}

/// The depth test; depth is reversed, so nearer is larger.
pub(crate) fn passes(test: DepthTest, depth: f32, stored: f32) -> bool {
    match test {
        DepthTest::Less => depth > stored,
        DepthTest::LessOrEqual => depth >= stored,
        DepthTest::Always => true,
    }
}

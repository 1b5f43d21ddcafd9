//! Visibility: per pixel the nearest depth and the fragment that has it.
use alloc::vec::Vec;

use crate::edge::{Edge, PixelBox, cover};
use crate::prepared::{Tile, decides_visibility};
use crate::setup::{Fragment, TILE, TriangleSetup};
use crate::{DepthTest, Draw, Pass, Prepared};

/// The id of a pixel where nothing was drawn.
pub const NONE: u32 = u32::MAX;

/// Depth and fragment id of a tile's pixels: 64x64 values, row by row from the top; the row length is 64 for narrow tiles too.
#[derive(Debug, Clone, PartialEq)]
pub struct TileBuffers {
    /// Reversed depth: 0 where nothing was drawn.
    pub depth: Vec<f32>,
    /// Fragment id, [`NONE`] where nothing was drawn.
    pub id: Vec<u32>,
}

impl Default for TileBuffers {
    fn default() -> Self {
        let pixels = (TILE * TILE) as usize;
        Self {
            depth: alloc::vec![0.0; pixels],
            id: alloc::vec![NONE; pixels],
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
        out.clear();
        let mut fragment = Fragment::default();
        self.for_each(
            tile,
            decides_visibility,
            |id, draw_index, draw, setup, edges, pixels, tile| {
                let (_, triangle) = self.source(id);
                cover(edges, pixels, |x, y| {
                    let (x, y) = (x as u32, y as u32);
                    let slot = ((y - tile.y0) * TILE + (x - tile.x0)) as usize;
                    let depth = setup.depth(x, y);
                    if !passes(draw.depth_test, depth, out.depth[slot]) {
                        return;
                    }
                    if draw.pass == Pass::CutOut {
                        setup.evaluate(x, y, &mut fragment);
                        if !alpha.keep(draw_index, triangle, &fragment) {
                            return;
                        }
                    }
                    if draw.depth_write {
                        out.depth[slot] = depth;
                    }
                    out.id[slot] = id;
                });
            },
        );
    }

    /// Calls `sink` with each fragment (id, x, y) of the blended draws that passes the depth test against `buffers`, in
    /// submitted order.
    pub fn blended(&self, tile: usize, buffers: &TileBuffers, sink: &mut dyn FnMut(u32, u32, u32)) {
        self.for_each(
            tile,
            |pass| !decides_visibility(pass),
            |id, _, draw, setup, edges, pixels, tile| {
                cover(edges, pixels, |x, y| {
                    let (x, y) = (x as u32, y as u32);
                    let slot = ((y - tile.y0) * TILE + (x - tile.x0)) as usize;
                    if passes(draw.depth_test, setup.depth(x, y), buffers.depth[slot]) {
                        sink(id, x, y);
                    }
                });
            },
        );
    }

    /// Visits the tile's triangles of some passes, in submitted order.
    fn for_each(
        &self,
        tile_index: usize,
        wanted: impl Fn(Pass) -> bool,
        mut visit: impl FnMut(u32, u32, &Draw<'_>, &TriangleSetup, &[Edge; 3], PixelBox, Tile),
    ) {
        let tile = self.tile(tile_index);
        let bounds = PixelBox {
            x0: tile.x0 as i32,
            y0: tile.y0 as i32,
            x1: (tile.x0 + tile.width) as i32 - 1,
            y1: (tile.y0 + tile.height) as i32 - 1,
        };
        for &id in self.bin(tile_index) {
            let (draw_index, _) = self.source(id);
            let draw = self.draw(draw_index);
            if !wanted(draw.pass) {
                continue;
            }
            let (shape, pixels) = self.shape(id);
            if let Some(pixels) = pixels.and_then(|p| p.intersect(bounds)) {
                let setup = TriangleSetup::new(&shape, tile.x0 / TILE, tile.y0 / TILE);
                visit(id, draw_index, draw, &setup, &shape.edges, pixels, tile);
            }
        }
    }
}

/// The depth test; depth is reversed, so nearer is larger.
pub(crate) fn passes(test: DepthTest, depth: f32, stored: f32) -> bool {
    match test {
        DepthTest::Less => depth > stored,
        DepthTest::LessOrEqual => depth >= stored,
        DepthTest::Always => true,
    }
}

//! The depth-only pass: shadow maps and occlusion. No fragments, no attributes.
use alloc::vec::Vec;

use texmap_math::dispatch_simd;
use texmap_math::simd::{Isa, Scalar, prelude::*};

use crate::coverage::hierarchical_z::Floor;
use crate::coverage::stamp::{BLOCK_PIXELS, BLOCKS, Sink, stamp_group};
use crate::front_end::prepared::{decides_visibility, for_all};
use crate::setup::TILE;
use crate::setup::group::{Group, Sharing};
use crate::visibility::runs::Runs;
use crate::visibility::sinks::passes;
use crate::{AlphaTest, BinnedDraws, DepthTest, TileVisibility};

impl BinnedDraws<'_> {
    /// Depth of the whole target, row by row from the top: the nearest of all draws that decide visibility and write depth
    /// (cut-outs count as solid), 0 where nothing is. Reversed: 1 at the near plane. With the feature `rayon` rows of tiles
    /// are spread over the current pool when `threads` is above 1; the bits are the same.
    #[must_use]
    pub fn depth_map(&self, threads: usize) -> Vec<f32> {
        let mut map = Vec::new();
        self.depth_map_into(threads, &mut map);
        map
    }

    /// [`depth_map`](Self::depth_map) in the buffer of an earlier one.
    pub fn depth_map_into(&self, threads: usize, map: &mut Vec<f32>) {
        self.depth_strips(threads, None, 0.0, map, &|_| {});
    }

    /// [`depth_map_into`](Self::depth_map_into), without the pixels of cut-outs that `alpha` does not keep. Tiles that no
    /// triangle reaches hold `empty`. Each strip of finished rows is lent to `done` while it is at hand.
    pub fn depth_strips(
        &self,
        threads: usize,
        alpha: Option<&(dyn AlphaTest + Sync)>,
        empty: f32,
        map: &mut Vec<f32>,
        done: &(dyn Fn(DepthStrip<'_>) + Sync),
    ) {
        match alpha {
            None => self.fill_map(threads, empty, map, done, |index, tile: &mut DepthTile| {
                self.depth_tile(index, tile);
                &tile.depth
            }),
            Some(alpha) => {
                self.fill_map(
                    threads,
                    empty,
                    map,
                    done,
                    |index, blocks: &mut TileVisibility| {
                        self.visible_blocks(index, alpha, blocks);
                        &blocks.depth
                    },
                );
            }
        }
    }

    /// Fills a map with the depths in 4x4 blocks that `depths` gives for each tile that is not empty.
    fn fill_map<T: Default>(
        &self,
        threads: usize,
        empty: f32,
        map: &mut Vec<f32>,
        done: &(dyn Fn(DepthStrip<'_>) + Sync),
        depths: impl Fn(usize, &mut T) -> &[f32] + Sync,
    ) {
        let width = self.size().width() as usize;
        let across = width.div_ceil(TILE as usize);
        map.resize(width * self.size().height() as usize, 0.0);
        let rows = map.chunks_mut(width * TILE as usize).enumerate().collect();
        for_all(threads, rows, |(row, out): (usize, &mut [f32])| {
            let mut tile = T::default();
            let reached = |column| !self.is_empty(row * across + column);
            let reached: Vec<bool> = (0..across).map(reached).collect();
            for (column, reached) in reached.iter().enumerate() {
                let (index, x0) = (row * across + column, column * TILE as usize);
                if *reached {
                    copy_blocks(depths(index, &mut tile), out, width, x0);
                } else {
                    for row in out.chunks_mut(width) {
                        row[x0..width.min(x0 + TILE as usize)].fill(empty);
                    }
                }
            }
            done(DepthStrip {
                first_row: row * TILE as usize,
                rows: out,
                reached: &reached,
            });
        });
    }

    fn depth_tile(&self, index: usize, out: &mut DepthTile) {
        out.depth.clear();
        out.depth.resize((TILE * TILE) as usize, 0.0);
        dispatch_simd!(self.level(), wide i => self.depth_lanes(i, index, out));
    }

    #[inline(always)]
    fn depth_lanes<I: Isa>(&self, i: I, index: usize, out: &mut DepthTile) {
        let mut runs = Runs::new(self, index);
        let mut floor = Floor::default();
        while let Some(run) = runs.next() {
            let draw = self.draw(run.draw as u32);
            if !decides_visibility(draw.pass) || !draw.depth_write {
                continue;
            }
            self.setup_group(
                i,
                run.draw,
                run.ids,
                index as u32,
                Sharing::Nothing,
                &mut out.group,
            );
            floor.drop_hidden(i, draw, &mut out.group);
            stamp_group(
                i,
                &out.group,
                false,
                &mut Nearest {
                    depth: &mut out.depth,
                    test: draw.depth_test,
                },
            );
            floor.rise(draw, &out.group);
        }
    }
}

/// Finished rows of a depth map, a row of tiles high.
#[derive(Debug)]
pub struct DepthStrip<'a> {
    /// Of the whole map.
    pub first_row: usize,
    /// One after the other.
    pub rows: &'a mut [f32],
    /// True for each tile that some triangle reaches.
    pub reached: &'a [bool],
}

/// Depth of a tile in 4x4 blocks.
#[derive(Debug, Default)]
struct DepthTile {
    depth: Vec<f32>,
    group: Group,
}

/// A tile's depths in 4x4 blocks into rows of `width` pixels, from column `x0` on.
fn copy_blocks(depths: &[f32], out: &mut [f32], width: usize, x0: usize) {
    let side = (TILE as usize).min(width - x0);
    for (y, row) in out.chunks_mut(width).enumerate() {
        let blocks = depths[(y >> 2) * BLOCKS * BLOCK_PIXELS + (y & 3) * 4..].chunks(BLOCK_PIXELS);
        // Four at a time are one move, not a call.
        let (fours, rest) = row[x0..x0 + side].as_chunks_mut::<4>();
        let last = blocks.clone().nth(fours.len()).unwrap_or(&[]);
        for (four, block) in fours.iter_mut().zip(blocks) {
            if let Some(depths) = block.first_chunk() {
                *four = *depths;
            }
        }
        rest.iter_mut().zip(last).for_each(|(to, d)| *to = *d);
    }
}

/// Keeps the nearest depth.
struct Nearest<'b> {
    depth: &'b mut [f32],
    test: DepthTest,
}

impl<I: Isa> Sink<I> for Nearest<'_> {
    #[inline(always)]
    fn pixels(&mut self, i: I, _: usize, index: usize, covered: I::Mask, depth: I::F32) {
        if let Some(stored) = self.depth.get_mut(index..index + I::LANES) {
            let old = i.load_f32(stored);
            let pass = covered & passes(i, self.test, depth, old);
            pass.select(depth, old).store(stored);
        }
    }

    #[inline(always)]
    fn pixel(&mut self, _: usize, index: usize, depth: f32) {
        let stored = &mut self.depth[index];
        if passes(Scalar, self.test, depth, *stored) {
            *stored = depth;
        }
    }

    #[inline(always)]
    fn takes_pixels(&self) -> bool {
        true
    }
}

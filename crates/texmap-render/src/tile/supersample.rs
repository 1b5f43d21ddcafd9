//! Supersampling: the mean, in linear light, of n x n tiles of samples.

use texmap_raster::{TILE, block_index};

use super::job::{Block, ColorRows, Job, Scratch};
use crate::resolve::encode::encode;
use crate::resolve::rows::AovRows;

/// Pixels of a block of the frame.
const PIXELS: usize = (TILE * TILE) as usize;

/// Sums over the samples of each pixel of a block.
#[derive(Default)]
pub(super) struct Sums {
    light: Vec<[f32; 4]>,
    covered: Vec<bool>,
}

impl Job<'_> {
    /// Draws a block and returns the number of its covered pixels.
    pub(super) fn draw_supersampled(
        &self,
        block: Block<'_, '_>,
        mut color: ColorRows<'_, '_>,
        scratch: &mut Scratch,
    ) -> u64 {
        let n = self.samples;
        let Sums { light, covered } = &mut scratch.sums;
        light.clear();
        light.resize(PIXELS, [0.0; 4]);
        covered.clear();
        covered.resize(PIXELS, false);
        for y in block.row * n..(block.row + 1) * n {
            for x in block.column * n..(block.column + 1) * n {
                let index = (y * self.tiles_across + x) as usize;
                if x < self.tiles_across && index < self.context.prepared.tiles() {
                    self.add_tile(index, &block, scratch);
                }
            }
        }
        let Sums { light, covered } = &scratch.sums;
        let samples = (n * n) as f32;
        for (y, row) in block.rgba.iter_mut().enumerate() {
            for (x, pixel) in row.chunks_exact_mut(4).enumerate() {
                let mean = light[y * TILE as usize + x].map(|sum| sum / samples);
                pixel.copy_from_slice(&encode(self.context.mode, mean).to_le_bytes());
                if let Some(AovRows::F32(rows)) = &mut color {
                    rows[y][4 * x..4 * x + 4].copy_from_slice(&mean);
                }
            }
        }
        covered.iter().filter(|covered| **covered).count() as u64
    }

    fn add_tile(&self, index: usize, block: &Block<'_, '_>, scratch: &mut Scratch) {
        let Scratch { painter, sums } = scratch;
        painter.see(&self.context, index, true);
        painter.paint(&self.context, index, None);
        let tile = self.context.prepared.tile(index);
        let (buffer, masks) = (&painter.samples[0].buffer, &painter.covered);
        for y in 0..tile.height {
            for x in 0..tile.width {
                let at = block_index(x, y);
                let pixel_x = (tile.x0 + x) / self.samples - block.column * TILE;
                let pixel_y = (tile.y0 + y) / self.samples - block.row * TILE;
                let pixel = (pixel_y * TILE + pixel_x) as usize;
                for (sum, value) in sums.light[pixel].iter_mut().zip(buffer.light_at(at)) {
                    *sum += value;
                }
                sums.covered[pixel] |= masks[at / 16] >> (at % 16) & 1 == 1;
            }
        }
    }
}

//! From the blocks of a tile to the rows of the frame.

use texmap_math::fearless_simd::{Simd, prelude::*, u8x16, u8x64, u32x4, u32x16};
use texmap_math::{Level, on_wide_level};
use texmap_raster::{FragmentBlock, TILE};

use super::tile_buffer::TileBuffer;
use texmap_shade::batch::{LANES, set_bits};

/// Bytes of a tile's row.
const ROW: usize = 4 * TILE as usize;
/// Words of a row of blocks.
const BAND: usize = 4 * TILE as usize;
/// Bytes of a cache line, and of a block's row.
const LINE: usize = 64;
const QUAD: usize = 16;

impl TileBuffer {
    /// Finished pixels to the tile's rows of the frame.
    pub(crate) fn copy_to(&self, level: Level, rows: &mut [&mut [u8]]) {
        let whole = cfg!(target_endian = "little") && rows.iter().all(|row| row.len() == ROW);
        let bands = if whole { rows.len() / 4 } else { 0 };
        let (fours, rest) = rows.split_at_mut(4 * bands);
        on_wide_level!(
            level,
            s => for (band, rows) in self.words.chunks_exact(BAND).zip(fours.chunks_exact_mut(4)) {
                for (y, row) in rows.iter_mut().enumerate() {
                    lines(s, band, y, row);
                }
            },
            else for (y, row) in fours.iter_mut().enumerate() {
                self.copy_row(y, row);
            }
        );
        for (y, row) in rest.iter_mut().enumerate() {
            self.copy_row(4 * bands + y, row);
        }
    }

    /// A row of finished pixels of the tile, up to 64 of them.
    fn copy_row(&self, y: usize, row: &mut [u8]) {
        let start = (y >> 2) * 16 * LANES + (y & 3) * 4;
        let (fours, rest) = row.as_chunks_mut::<16>();
        let (quads, _) = self.words[start..].as_chunks::<4>();
        // A whole row, without branches: every fourth four words.
        if let (Some(fours), Some(quads)) = (
            fours.first_chunk_mut::<16>(),
            quads.first_chunk::<{ 15 * 4 + 1 }>(),
        ) {
            for (i, four) in fours.iter_mut().enumerate() {
                *four = bytes(&quads[4 * i]);
            }
            return;
        }
        let blocks = self.words[start..].chunks(LANES);
        let mut last = blocks.clone().nth(fours.len()).unwrap_or(&[]).iter();
        for (to, block) in fours.iter_mut().zip(blocks) {
            if let Some(words) = block.first_chunk::<4>() {
                *to = bytes(words);
            }
        }
        for pixel in rest.chunks_exact_mut(4) {
            if let Some(word) = last.next() {
                pixel.copy_from_slice(&word.to_le_bytes());
            }
        }
    }
}

/// One finished pixel all over rows of the frame.
pub(crate) fn fill_rows(level: Level, rows: &mut [&mut [u8]], word: u32) {
    for row in rows {
        let (lines, rest) = row.as_chunks_mut::<64>();
        on_wide_level!(
            level,
            s => {
                let line: u8x64<_> = u32x16::splat(s, word.to_le()).bitcast();
                for out in lines.iter_mut() {
                    line.store_slice(out);
                }
            },
            else for pixel in lines.as_flattened_mut().as_chunks_mut().0 {
                *pixel = word.to_le_bytes();
            }
        );
        for pixel in rest.as_chunks_mut().0 {
            *pixel = word.to_le_bytes();
        }
    }
}

/// True if these are all rows of a tile, and words in memory have the byte order of blocks.
pub(crate) fn rows_fit(rows: &[&mut [u8]]) -> bool {
    cfg!(target_endian = "little")
        && rows.len() == TILE as usize
        && rows.iter().all(|row| row.len() == ROW)
}

/// Stores the encoded colors of a block in the rows of the tile.
#[inline(always)]
pub(crate) fn put_block_rows(rows: &mut [&mut [u8]], at: FragmentBlock, words: &[u32; LANES]) {
    let (x, y) = (usize::from(at.block) % 16, usize::from(at.block) / 16);
    let Some(rows) = rows.get_mut(4 * y..4 * y + 4) else {
        return;
    };
    for (k, (row, four)) in rows.iter_mut().zip(words.as_chunks().0).enumerate() {
        let Some(to) = row.get_mut(x * QUAD..(x + 1) * QUAD) else {
            return;
        };
        let from = halves(four);
        if at.mask == u16::MAX {
            to.copy_from_slice(&from);
            continue;
        }
        for bit in set_bits(at.mask >> (4 * k) & 15) {
            to[4 * bit..4 * bit + 4].copy_from_slice(&from[4 * bit..4 * bit + 4]);
        }
    }
}

/// Stores the encoded colors of pixels of a block, from `pixel` on, in the rows of the tile.
#[inline(always)]
pub(crate) fn put_pixels_rows(
    rows: &mut [&mut [u8]],
    at: FragmentBlock,
    pixel: usize,
    words: &[u32],
) {
    if let Some(block) = words.first_chunk() {
        return put_block_rows(rows, at, block);
    }
    let mut block = [0; LANES];
    block[pixel..pixel + words.len()].copy_from_slice(words);
    let mask = at.mask & ((1 << words.len()) - 1) << pixel;
    put_block_rows(rows, FragmentBlock { mask, ..at }, &block);
}

/// Row `y` of a row of blocks. A store over the border of two cache lines takes the time of two, so that what lies before the first
/// border, and behind the last, goes four pixels at a time.
#[inline(always)]
fn lines<S: Simd>(s: S, band: &[u32], y: usize, row: &mut [u8]) {
    let ahead = row.as_ptr().align_offset(LINE);
    let head = if ahead.is_multiple_of(QUAD) {
        ahead / QUAD
    } else {
        0
    };
    let (front, rest) = row.split_at_mut_checked(head * QUAD).unwrap_or_default();
    let (middle, back) = rest.as_chunks_mut::<LINE>();
    for (block, to) in front.as_chunks_mut::<QUAD>().0.iter_mut().enumerate() {
        put_quad(s, band, block, y, to);
    }
    for (i, to) in middle.iter_mut().enumerate() {
        let block = head + 4 * i;
        let left = s.combine_u32x4(quad(s, band, block, y), quad(s, band, block + 1, y));
        let right = s.combine_u32x4(quad(s, band, block + 2, y), quad(s, band, block + 3, y));
        let line: u8x64<S> = s.combine_u32x8(left, right).bitcast();
        line.store_slice(to);
    }
    let first = head + 4 * middle.len();
    for (i, to) in back.as_chunks_mut::<QUAD>().0.iter_mut().enumerate() {
        put_quad(s, band, first + i, y, to);
    }
}

#[inline(always)]
fn quad<S: Simd>(s: S, blocks: &[u32], block: usize, y: usize) -> u32x4<S> {
    let at = block * LANES + 4 * y;
    u32x4::from_slice(s, &blocks[at..at + 4])
}

#[inline(always)]
fn put_quad<S: Simd>(s: S, blocks: &[u32], block: usize, y: usize, to: &mut [u8; QUAD]) {
    let four: u8x16<S> = quad(s, blocks, block, y).bitcast();
    four.store_slice(to);
}

/// Four pixels in memory: one move where the machine is little-endian.
#[inline(always)]
fn bytes([a, b, c, d]: &[u32; 4]) -> [u8; 16] {
    bytemuck::cast([a.to_le(), b.to_le(), c.to_le(), d.to_le()])
}

/// Four pixels in memory, made in two halves: words that come out of registers one by one would stall the load of all sixteen bytes.
#[inline(always)]
fn halves(&[a, b, c, d]: &[u32; 4]) -> [u8; 16] {
    let half = |a: u32, b: u32| u64::from(a) | u64::from(b) << 32;
    bytemuck::cast([half(a, b).to_le(), half(c, d).to_le()])
}

#[cfg(test)]
mod tests {
    use super::*;
    use texmap_raster::block_index;

    #[test]
    fn every_pixel_of_a_row_is_filled() {
        for width in [64, 63, 16, 1] {
            for level in [Level::new(), Level::baseline()] {
                let mut bytes = vec![0; 4 * width * 3];
                let mut rows: Vec<&mut [u8]> = bytes.chunks_mut(4 * width).collect();
                fill_rows(level, &mut rows, 0x0403_0201);
                assert!(
                    bytes.chunks(4).all(|pixel| pixel == [1, 2, 3, 4]),
                    "{width}"
                );
            }
        }
    }

    #[test]
    fn blocks_go_to_rows_as_they_go_through_the_buffer() {
        let level = Level::new();
        let mut buffer = TileBuffer::new();
        let (mut straight, mut copied) = (vec![7; ROW * 64], vec![7; ROW * 64]);
        for word in buffer.words.iter_mut() {
            *word = u32::from_le_bytes([7; 4]);
        }
        for (i, mask) in [u16::MAX, 0x00f0, 0x8421, 1, 0].into_iter().enumerate() {
            let at = FragmentBlock {
                block: (i * 61) as u16,
                mask,
                slot: 0,
            };
            let front: [u32; LANES] = std::array::from_fn(|k| 0x0403_0201 * (k + i) as u32);
            buffer.put_block(at, &front);
            let mut rows: Vec<&mut [u8]> = straight.chunks_mut(ROW).collect();
            assert!(rows_fit(&rows));
            put_block_rows(&mut rows, at, &front);
        }
        let mut rows: Vec<&mut [u8]> = copied.chunks_mut(ROW).collect();
        buffer.copy_to(level, &mut rows);
        assert_eq!(straight, copied);
    }

    #[test]
    fn rows_of_whole_and_cut_tiles_hold_their_pixels() {
        let mut buffer = TileBuffer::new();
        for (i, word) in buffer.words.iter_mut().enumerate() {
            *word = 0x0301_0500 + i as u32;
        }
        for (width, height) in [(64, 64), (64, 7), (64, 3), (50, 64), (17, 9), (1, 1)] {
            // Rows at any offset in their cache lines.
            let places = [0, 4, 16, 32, 48].map(|ahead| (Level::new(), ahead));
            for (level, ahead) in places.into_iter().chain([(Level::baseline(), 0)]) {
                let mut memory = vec![0; 64 + ahead + 4 * width * height];
                let start = memory.as_ptr().align_offset(64) + ahead;
                let bytes = &mut memory[start..start + 4 * width * height];
                let mut rows: Vec<&mut [u8]> = bytes.chunks_mut(4 * width).collect();
                buffer.copy_to(level, &mut rows);
                for (i, pixel) in bytes.chunks(4).enumerate() {
                    let at = block_index((i % width) as u32, (i / width) as u32);
                    let word = 0x0301_0500 + at as u32;
                    assert_eq!(
                        pixel,
                        word.to_le_bytes(),
                        "{width} x {height} from {ahead} on: {i}"
                    );
                }
            }
        }
    }
}

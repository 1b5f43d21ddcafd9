//! The frame's buffers cut into blocks that threads can own.

use texmap_raster::TILE;

/// A block's rows of one AOV.
pub(crate) enum AovRows<'a> {
    F32(Vec<&'a mut [f32]>),
    U32(Vec<&'a mut [u32]>),
}

/// The rows of every block, blocks counted row by row from the top left.
pub(crate) fn split<T>(
    data: &mut [T],
    channels: usize,
    width: u32,
    height: u32,
) -> Vec<Vec<&mut [T]>> {
    let (tile, width) = (TILE as usize, width as usize);
    let across = width.div_ceil(tile);
    let mut blocks = Vec::with_capacity(across * height.div_ceil(TILE) as usize);
    // Block by block: the rows of each are put down in one go.
    for band in data.chunks_mut(width * channels * tile) {
        let mut left: Vec<&mut [T]> = band.chunks_mut(width * channels).collect();
        for column in 0..across {
            let part = (width - column * tile).min(tile) * channels;
            let rows = left.iter_mut().filter_map(|row| row.split_off_mut(..part));
            let mut block = Vec::with_capacity(tile);
            block.extend(rows);
            blocks.push(block);
        }
    }
    blocks
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_value_belongs_to_its_block() {
        let (width, height) = (130, 70);
        let mut data = vec![usize::MAX; 130 * 70 * 2];
        for (index, rows) in split(&mut data, 2, width, height).into_iter().enumerate() {
            rows.into_iter().for_each(|row| row.fill(index));
        }
        for y in 0..70 {
            for x in 0..130 {
                let index = (y / 64) * 3 + x / 64;
                assert_eq!(data[(y * 130 + x) * 2..][..2], [index, index]);
            }
        }
    }
}

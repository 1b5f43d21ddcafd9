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
    let tile = TILE as usize;
    let across = width.div_ceil(TILE) as usize;
    let mut blocks: Vec<Vec<&mut [T]>> = Vec::new();
    blocks.resize_with(across * height.div_ceil(TILE) as usize, || {
        Vec::with_capacity(tile)
    });
    for (y, row) in data.chunks_mut(width as usize * channels).enumerate() {
        for (column, part) in row.chunks_mut(tile * channels).enumerate() {
            blocks[y / tile * across + column].push(part);
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

//! The frame's buffers cut into blocks that threads can own.

use texmap_raster::TILE;

use crate::AovData;

/// A block's rows of one AOV.
pub(crate) enum AovRows<'r, 'a> {
    F32(&'r mut [&'a mut [f32]]),
    U32(&'r mut [&'a mut [u32]]),
}

/// The rows of all blocks of one AOV.
pub(crate) enum AovParts<'a> {
    F32(Vec<&'a mut [f32]>),
    U32(Vec<&'a mut [u32]>),
}

impl<'a> AovParts<'a> {
    pub(crate) fn new(data: &'a mut AovData, channels: usize, width: u32, height: u32) -> Self {
        match data {
            AovData::F32(values) => Self::F32(split(values, channels, width, height)),
            AovData::U32(values) => Self::U32(split(values, channels, width, height)),
        }
    }

    pub(crate) fn blocks<'r>(&'r mut self, width: u32, height: u32) -> Vec<AovRows<'r, 'a>> {
        match self {
            Self::F32(rows) => blocks(rows, width, height).map(AovRows::F32).collect(),
            Self::U32(rows) => blocks(rows, width, height).map(AovRows::U32).collect(),
        }
    }
}

/// The rows of every block, one block after the other, blocks counted row by row from the top left: see [`blocks`].
pub(crate) fn split<T>(data: &mut [T], channels: usize, width: u32, height: u32) -> Vec<&mut [T]> {
    let (tile, width) = (TILE as usize, width as usize);
    let across = width.div_ceil(tile);
    let mut rows = Vec::with_capacity(across * height as usize);
    // Block by block, with the rows of each one after the other.
    for band in data.chunks_mut(width * channels * tile) {
        let mut left: Vec<&mut [T]> = band.chunks_mut(width * channels).collect();
        for column in 0..across {
            let part = (width - column * tile).min(tile) * channels;
            rows.extend(left.iter_mut().filter_map(|row| row.split_off_mut(..part)));
        }
    }
    rows
}

/// The rows of [`split`], block by block.
pub(crate) fn blocks<'r, 'a, T>(
    mut rows: &'r mut [&'a mut [T]],
    width: u32,
    height: u32,
) -> impl Iterator<Item = &'r mut [&'a mut [T]]> {
    let across = width.div_ceil(TILE);
    let heights = (0..height.div_ceil(TILE)).map(move |y| (height - y * TILE).min(TILE));
    let heights = heights.flat_map(move |rows| (0..across).map(move |_| rows as usize));
    heights.map_while(move |count| rows.split_off_mut(..count))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_value_belongs_to_its_block() {
        let (width, height) = (130, 70);
        let mut data = vec![usize::MAX; 130 * 70 * 2];
        let mut rows = split(&mut data, 2, width, height);
        for (index, rows) in blocks(&mut rows, width, height).enumerate() {
            rows.iter_mut().for_each(|row| row.fill(index));
        }
        for y in 0..70 {
            for x in 0..130 {
                let index = (y / 64) * 3 + x / 64;
                assert_eq!(data[(y * 130 + x) * 2..][..2], [index, index]);
            }
        }
    }
}

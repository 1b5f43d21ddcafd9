//! Block-compressed textures: BC1 to BC5 and BC7 stay as they are in memory, and each look-up decodes the texels that it reads.
//!
//! Texels of such a chain are counted in block order at every level: 16 of one block, then those of the next block of the row.

mod bc1;
mod bc4;
mod bc7;
pub(crate) mod partitions;
mod view;

pub(crate) use view::BlockView;

use crate::{
    encoded::Encoded,
    error::SampleError,
    texel_data::{Chain, Format, Level, Words},
    texture::{Alpha, ColorSpace, Origin, Texture2d, check_length, check_size},
};
use alloc::{sync::Arc, vec::Vec};
use texmap_math::{color, simd::Scalar};

/// Layout of the 4 x 4 texels of a block. Source: Khronos Data Format Specification 1.3, sections 18 to 20; Direct3D 11.3, section 19.5.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum BlockFormat {
    /// Two 5:6:5 colours and 2-bit indices in 8 bytes; alpha is 0 or 1 (DXT1).
    Bc1,
    /// As [`Bc1`](Self::Bc1) without alpha: its holes are black.
    Bc1Opaque,
    /// The colours of BC1 and 4-bit alphas in 16 bytes (DXT3).
    Bc2,
    /// The colours of BC1 and alphas between two ends in 16 bytes (DXT5).
    Bc3,
    /// One channel between two ends in 8 bytes, read as (x, x, x, 1). Linear values keep 16 bits: those between the ends are no whole codes.
    Bc4,
    /// Two channels in 16 bytes: a normal map, read as (x, y, z, 1) with the z of a unit vector, all of them (n + 1) / 2. Never sRGB.
    Bc5,
    /// Colour and alpha in one of eight modes in 16 bytes; 8 bits, exact.
    Bc7,
}

impl BlockFormat {
    /// All of them.
    pub const ALL: [Self; 7] = [
        Self::Bc1,
        Self::Bc1Opaque,
        Self::Bc2,
        Self::Bc3,
        Self::Bc4,
        Self::Bc5,
        Self::Bc7,
    ];

    /// Bytes of a block.
    #[must_use]
    pub const fn block_bytes(self) -> usize {
        match self {
            Self::Bc1 | Self::Bc1Opaque | Self::Bc4 => 8,
            Self::Bc2 | Self::Bc3 | Self::Bc5 | Self::Bc7 => 16,
        }
    }

    /// Bytes of a level: whole blocks, so that a level of one texel has as many as a block; the largest number where there are more.
    #[must_use]
    pub const fn level_bytes(self, width: u32, height: u32) -> usize {
        let blocks = (width.div_ceil(4) as usize).saturating_mul(height.div_ceil(4) as usize);
        blocks.saturating_mul(self.block_bytes())
    }
}

/// A block-compressed image to make a texture of.
#[derive(Clone, Copy, Debug)]
pub struct BlockImage<'a> {
    /// Columns of level 0.
    pub width: u32,
    /// Rows of level 0.
    pub height: u32,
    /// Layout of the blocks.
    pub format: BlockFormat,
    /// Blocks of each level, row by row, [`BlockFormat::level_bytes`] each; sides halve rounding down. One level or more.
    pub levels: &'a [&'a [u8]],
    /// Encoding of the colours.
    pub color: ColorSpace,
    /// Meaning of alpha.
    pub alpha: Alpha,
    /// The row that `v = 0` touches.
    pub origin: Origin,
}

impl Texture2d<'static> {
    /// From the blocks of a compressed image, which are copied and never unpacked: half a byte to a byte a texel in place of eight. Look-ups
    /// give the bits of the same texels as [`TexelData::U16`](crate::TexelData::U16) (8-bit codes in sRGB), on every SIMD level, and take longer.
    ///
    /// [`with_mips`](Self::with_mips) keeps level 0 compressed and adds levels of 16 bits; [`with_coverage_mips`](Self::with_coverage_mips)
    /// unpacks everything.
    ///
    /// ```
    /// use texmap_sample::{Alpha, BlockFormat, BlockImage, ColorSpace, Origin, Texture2d};
    ///
    /// // White and black, and in each row the four indices.
    /// let block = [0xff, 0xff, 0, 0, 0xe4, 0xe4, 0xe4, 0xe4];
    /// let t = Texture2d::from_blocks(&BlockImage {
    ///     width: 4,
    ///     height: 4,
    ///     format: BlockFormat::Bc1,
    ///     levels: &[&block],
    ///     color: ColorSpace::Linear,
    ///     alpha: Alpha::Straight,
    ///     origin: Origin::TopLeft,
    /// })?;
    /// let red = [0, 1, 2, 3].map(|x| (t.texel(0, x, 0).unwrap()[0] * 255.0).round());
    /// assert_eq!(red, [255.0, 0.0, 170.0, 85.0]);
    /// # Ok::<(), texmap_sample::SampleError>(())
    /// ```
    ///
    /// # Errors
    /// A side out of range, no level, more levels than halving gives, a level of the wrong length.
    pub fn from_blocks(image: &BlockImage<'_>) -> Result<Self, SampleError> {
        let BlockImage { width, height, .. } = *image;
        check_size(width, height)?;
        let most = width.max(height).ilog2() as usize + 1;
        if !(1..=most).contains(&image.levels.len()) {
            return Err(SampleError::Levels {
                levels: image.levels.len(),
                most,
            });
        }
        let mut levels = Vec::with_capacity(image.levels.len());
        let (mut bytes, mut texels) = (0, 0);
        for (k, level) in image.levels.iter().enumerate() {
            let (width, height) = ((width >> k).max(1), (height >> k).max(1));
            check_length(image.format.level_bytes(width, height), level.len())?;
            levels.push(Level {
                offset: texels,
                width: width as i32,
                height: height as i32,
                depth: 1,
            });
            texels += stored_texels(width, height);
            bytes += level.len();
        }
        if texels > 1 << 30 {
            return Err(SampleError::TooLarge { width, height });
        }
        let mut words = Vec::with_capacity(bytes / 4 + 1);
        for level in image.levels {
            let chunks = level.as_chunks::<4>().0.iter();
            words.extend(chunks.map(|word| u32::from_le_bytes(*word)));
        }
        // Fields are read as pairs of words.
        words.push(0);
        let blocks = Blocks {
            words: Arc::new(words),
            light: Arc::new(light(image.color)),
            format: image.format,
            texels,
            straight: image.alpha == Alpha::Straight,
            linear: image.color == ColorSpace::Linear,
        };
        let opaque = blocks.opaque(&levels);
        Ok(Self {
            chain: Chain {
                words: Words::Owned(Arc::new(Vec::new())),
                encoded: Some(Encoded::Blocks(blocks)),
                format: Format::Rgba16,
                levels,
                flip: image.origin == Origin::BottomLeft,
                opaque,
                sums: None,
            },
        })
    }
}

impl Texture2d<'_> {
    /// The layout of the blocks that level 0 is sampled from; `None` where texels are not compressed.
    #[must_use]
    pub fn block_format(&self) -> Option<BlockFormat> {
        match &self.chain.encoded {
            Some(Encoded::Blocks(blocks)) => Some(blocks.format),
            _ => None,
        }
    }
}

/// Texels of a level in whole blocks.
pub(crate) const fn stored_texels(width: u32, height: u32) -> usize {
    16 * width.div_ceil(4) as usize * height.div_ceil(4) as usize
}

/// Index of a texel in block order, from the first of its level.
#[inline(always)]
pub(crate) fn block_order(width: i32, x: i32, y: i32) -> usize {
    let blocks = (width as usize).div_ceil(4);
    let (x, y) = (x as usize, y as usize);
    ((y / 4) * blocks + x / 4) * 16 + (y % 4) * 4 + x % 4
}

/// Light of the codes, as the bits of f32.
fn light(space: ColorSpace) -> [u32; 256] {
    core::array::from_fn(|code| {
        let light = match space {
            ColorSpace::Srgb => color::srgb8_to_linear(code as u8),
            ColorSpace::Linear => code as f32 / 255.0,
        };
        light.to_bits()
    })
}

/// The compressed levels of a chain.
#[derive(Clone, Debug)]
pub(crate) struct Blocks {
    /// The blocks of all levels, and one word.
    words: Arc<Vec<u32>>,
    light: Arc<[u32; 256]>,
    format: BlockFormat,
    /// Texels in blocks. Those of levels that were made from them come after.
    texels: usize,
    /// Alpha is not yet multiplied into the colour.
    straight: bool,
    /// Codes are proportional to light.
    linear: bool,
}

impl Blocks {
    pub(crate) fn view(&self) -> Option<BlockView<'_>> {
        BlockView::new(self)
    }

    /// Unscaled texel `i` in block order, which is among the blocks.
    #[inline(never)]
    pub(crate) fn fetch(&self, i: usize) -> [f32; 4] {
        match self.view() {
            Some(view) => view.decoded(Scalar, texmap_math::simd::One(i as i32)),
            None => [0.0; 4],
        }
    }

    /// Unscaled texel `i` in block order of a chain with these blocks.
    pub(crate) fn fetch_in(&self, words: &[u32], i: usize) -> [f32; 4] {
        match i.checked_sub(self.texels) {
            None => self.fetch(i),
            Some(i) => Format::Rgba16.fetch(words, 2 * i),
        }
    }

    /// These blocks without those behind level 0.
    pub(crate) fn base(mut self, base: &Level) -> Self {
        self.texels = stored_texels(base.width as u32, base.height as u32);
        let words = self.texels / 16 * self.format.block_bytes() / 4 + 1;
        if self.words.len() > words {
            let mut kept = self.words[..words].to_vec();
            kept.shrink_to_fit();
            self.words = Arc::new(kept);
        }
        self
    }

    /// Levels of 16-bit texels, made from level 0 and in rows, put in block order behind the blocks.
    pub(crate) fn append(&self, levels: &mut [Level], words: &[u32]) -> Vec<u32> {
        let mut ordered = Vec::new();
        for level in levels.iter_mut().skip(1) {
            let (start, first) = (level.offset, ordered.len());
            level.offset = self.texels + first / 2;
            ordered.resize(
                first + 2 * stored_texels(level.width as u32, level.height as u32),
                0,
            );
            for y in 0..level.height {
                for x in 0..level.width {
                    let from = start + 2 * (y * level.width + x) as usize;
                    let to = first + 2 * block_order(level.width, x, y);
                    ordered[to..to + 2].copy_from_slice(&words[from..from + 2]);
                }
            }
        }
        ordered
    }

    /// True if no texel of the levels has an alpha below one. Those that only fill their block do not count.
    fn opaque(&self, levels: &[Level]) -> bool {
        if matches!(
            self.format,
            BlockFormat::Bc1Opaque | BlockFormat::Bc4 | BlockFormat::Bc5
        ) {
            return true;
        }
        levels.iter().all(|level| {
            let blocks =
                (level.offset / 16..).zip(0..(level.height + 3) / 4 * ((level.width + 3) / 4));
            let across = (level.width + 3) / 4;
            blocks.into_iter().all(|(block, k)| {
                self.is_opaque_by_header(block)
                    || (0..16).all(|t| {
                        let (x, y) = (k % across * 4 + t % 4, k / across * 4 + t / 4);
                        x >= level.width
                            || y >= level.height
                            || self.fetch(block * 16 + t as usize)[3] >= 65535.0
                    })
            })
        })
    }

    /// True if the mode of a block leaves no room for alpha.
    fn is_opaque_by_header(&self, block: usize) -> bool {
        let word = |i: usize| self.words[block * self.format.block_bytes() / 4 + i];
        match self.format {
            BlockFormat::Bc1 => word(0) & 0xffff > word(0) >> 16,
            BlockFormat::Bc2 => (word(0), word(1)) == (u32::MAX, u32::MAX),
            // Indices of zero: the sixth is 0 whatever the ends.
            BlockFormat::Bc3 => (word(0), word(1)) == (0xffff, 0),
            BlockFormat::Bc7 => word(0) & 15 != 0,
            _ => true,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_of_levels_end_at_the_largest_number() {
        assert_eq!(BlockFormat::Bc1.level_bytes(5, 1), 16);
        assert_eq!(BlockFormat::Bc7.level_bytes(u32::MAX, u32::MAX), usize::MAX);
    }
}

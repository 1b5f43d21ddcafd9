//! Images that stay as their files hold them: decoded at each look-up instead of once.

use crate::{
    blocks::{Blocks, block_order},
    error::SampleError,
    texel_data::{Chain, Format, Level, TexelData, Words, floats},
    texture::{Alpha, ColorSpace, Image, Origin, Texture2d},
    upload::{choose_format, rgba, texel16, upload},
};
use alloc::{sync::Arc, vec, vec::Vec};

/// Levels that are not among the words of their chain.
#[derive(Clone, Debug)]
pub(crate) enum Encoded {
    /// Level 0.
    Bytes(EncodedBytes),
    /// Level 0, or all levels of a file.
    Blocks(Blocks),
}

/// Bytes of a picture as level 0 of a chain of 16-bit levels.
#[derive(Clone, Debug)]
pub(crate) struct EncodedBytes {
    bytes: Arc<Vec<u8>>,
    /// 1 to 4 a texel; the alpha of two and four is straight.
    channels: usize,
    color: ColorSpace,
}

impl Encoded {
    /// Unscaled texel of level 0.
    pub(crate) fn base_texel(&self, width: i32, x: i32, y: i32) -> [f32; 4] {
        match self {
            Self::Bytes(bytes) => bytes.fetch(y as usize * width as usize + x as usize),
            Self::Blocks(blocks) => blocks.fetch(block_order(width, x, y)),
        }
    }
}

impl EncodedBytes {
    /// [`decode`](Self::decode) out of line: every filter fetches texels.
    #[inline(never)]
    pub(crate) fn fetch(&self, i: usize) -> [f32; 4] {
        self.decode(i)
    }

    /// Unscaled texel `i`, as [`Format::Rgba16`] would hold it.
    #[inline(always)]
    pub(crate) fn decode(&self, i: usize) -> [f32; 4] {
        let bytes = &self.bytes[..];
        let texel = match self.channels {
            1 => rgba::<1>(bytes.as_chunks().0[i]),
            2 => rgba::<2>(bytes.as_chunks().0[i]),
            3 => rgba::<3>(bytes.as_chunks().0[i]),
            _ => rgba::<4>(bytes.as_chunks().0[i]),
        };
        floats(texel16(texel, self.color, true))
    }
}

impl Texture2d<'static> {
    /// As [`Texture2d::new`], with the same values, in less memory. 8-bit colours that would take 16 bits a channel are kept as
    /// they are: 1 to 4 bytes a texel instead of 8. Each look-up decodes its texels, which takes several times as long; for large
    /// pictures that are read about once. Straight alpha, rows top to bottom.
    ///
    /// # Errors
    /// As [`Texture2d::new`].
    pub fn from_encoded8(
        (width, height): (u32, u32),
        channels: u32,
        texels: Vec<u8>,
        color: ColorSpace,
        origin: Origin,
    ) -> Result<Self, SampleError> {
        let given = Image {
            width,
            height,
            channels,
            texels: TexelData::U8(&texels),
            color,
            alpha: Alpha::Straight,
            origin,
        };
        given.check(1)?;
        if choose_format(&given) != Format::Rgba16 {
            return Ok(Self {
                chain: upload(&given, 1)?,
            });
        }
        let n = channels as usize;
        let opaque = n % 2 == 1 || texels.chunks_exact(n).all(|texel| texel[n - 1] == 255);
        let level = Level {
            offset: Level::ENCODED,
            width: width as i32,
            height: height as i32,
            depth: 1,
        };
        let encoded = EncodedBytes {
            bytes: Arc::new(texels),
            channels: n,
            color,
        };
        Ok(Self {
            chain: Chain {
                words: Words::Owned(Arc::new(Vec::new())),
                encoded: Some(Encoded::Bytes(encoded)),
                format: Format::Rgba16,
                levels: vec![level],
                flip: origin == Origin::BottomLeft,
                opaque,
                sums: None,
            },
        })
    }
}

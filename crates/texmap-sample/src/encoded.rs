//! Images that stay as their files hold them: decoded at each look-up instead of once.

use crate::{
    error::SampleError,
    texels::{Chain, Format, Level, Texels, Words},
    texture::{Alpha, ColorSpace, Image, Origin, Texture2d, choose_format, read_texel, upload},
};
use alloc::{sync::Arc, vec, vec::Vec};
use texmap_math::color;

/// Bytes of a picture as level 0 of a chain of 16-bit levels.
#[derive(Clone, Debug)]
pub(crate) struct Encoded {
    bytes: Arc<Vec<u8>>,
    /// All but the bytes.
    shape: Image<'static>,
}

impl Encoded {
    /// Unscaled texel `i`, as [`Format::Rgba16`] would hold it. Out of line: every filter fetches texels.
    #[inline(never)]
    pub(crate) fn fetch(&self, i: usize) -> [f32; 4] {
        let n = self.shape.channels as usize;
        let light = |c: u8| f32::from(color::srgb8_to_linear16(c));
        // What photographs hold needs no more than a table.
        match self.bytes[i * n..(i + 1) * n] {
            [r, g, b] | [r, g, b, 255] if self.shape.color == ColorSpace::Srgb => {
                [light(r), light(g), light(b), 65535.0]
            }
            _ => {
                let image = Image {
                    texels: Texels::U8(&self.bytes),
                    ..self.shape
                };
                Format::Rgba16.rounded(read_texel(&image, i))
            }
        }
    }
}

impl Texture2d<'static> {
    /// As [`Texture2d::new`], with the same values, but 8-bit colours that would take 16 bits a channel are kept as they are: 1 to 4
    /// bytes a texel instead of 8. Each look-up decodes its texels, one place at a time, which takes several times as long; for large
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
        let shape = Image {
            width,
            height,
            channels,
            texels: Texels::U8(&[]),
            color,
            alpha: Alpha::Straight,
            origin,
        };
        let given = Image {
            texels: Texels::U8(&texels),
            ..shape
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
        let encoded = Encoded {
            bytes: Arc::new(texels),
            shape,
        };
        Ok(Self {
            chain: Chain {
                words: Words::Owned(Arc::new(Vec::new())),
                encoded: Some(encoded),
                format: Format::Rgba16,
                levels: vec![level],
                flip: origin == Origin::BottomLeft,
                opaque,
            },
        })
    }
}

//! A decoded image in the depth of its file.

use image::DynamicImage;
use texmap_math::color;
use texmap_sample::{Alpha, ColorSpace};

/// A decoded image: RGBA, rows from top to bottom.
#[derive(Debug, Clone, PartialEq)]
pub struct Rgba {
    /// Columns, 1 or more.
    pub width: u32,
    /// Rows, 1 or more.
    pub height: u32,
    /// Channels that the file has: 1 grey, 2 grey and alpha, 3 colours, 4 colours and alpha.
    pub channels: u32,
    /// Four values a texel.
    pub texels: Depth,
}

/// The values of an image in the depth of its file.
#[derive(Debug, Clone, PartialEq)]
pub enum Depth {
    /// 8 bits a channel: sRGB codes, straight alpha.
    U8(Vec<u8>),
    /// 16 bits a channel (PNG, TIFF): sRGB codes, straight alpha.
    U16(Vec<u16>),
    /// Floats (HDR, EXR, TIFF): linear light, premultiplied alpha. NaN and infinities are as the file has them.
    F32(Vec<f32>),
}

impl Depth {
    /// Bits a channel; 32 for floats, half floats too.
    pub fn bits(&self) -> u32 {
        match self {
            Self::U8(_) => 8,
            Self::U16(_) => 16,
            Self::F32(_) => 32,
        }
    }
}

impl Rgba {
    /// The texels as floats, four a texel, with the meaning of their alpha. They are linear light, or for [`ColorSpace::Linear`] the
    /// codes over their largest. Floats are as they are.
    #[must_use]
    pub fn into_floats(self, color: ColorSpace) -> (Vec<f32>, Alpha) {
        let light = match (&self.texels, color) {
            (Depth::U16(_), ColorSpace::Srgb) => {
                (0..=u16::MAX).map(color::srgb16_to_linear).collect()
            }
            _ => Vec::new(),
        };
        let texels = match self.texels {
            Depth::F32(texels) => return (texels, Alpha::Premultiplied),
            Depth::U8(texels) => floats(&texels, |c, is_alpha| match color {
                ColorSpace::Srgb if !is_alpha => color::srgb8_to_linear(c),
                _ => f32::from(c) / 255.0,
            }),
            Depth::U16(texels) => floats(&texels, |c, is_alpha| match color {
                ColorSpace::Srgb if !is_alpha => light[usize::from(c)],
                _ => f32::from(c) / 65535.0,
            }),
        };
        (texels, Alpha::Straight)
    }
}

fn floats<T: Copy>(texels: &[T], value: impl Fn(T, bool) -> f32) -> Vec<f32> {
    let texels = texels.iter().enumerate();
    texels.map(|(i, c)| value(*c, i % 4 == 3)).collect()
}

impl Rgba {
    pub(super) fn of(decoded: DynamicImage) -> Self {
        let (width, height) = (decoded.width(), decoded.height());
        let color = decoded.color();
        let texels = match color.bytes_per_pixel() / color.channel_count() {
            1 => Depth::U8(decoded.into_rgba8().into_raw()),
            2 => Depth::U16(decoded.into_rgba16().into_raw()),
            _ => Depth::F32(decoded.into_rgba32f().into_raw()),
        };
        Self {
            width,
            height,
            channels: u32::from(color.channel_count()),
            texels,
        }
    }
}

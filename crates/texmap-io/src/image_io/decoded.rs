//! A decoded image with the channels of its file, and its texture.

use std::path::Path;

use image::DynamicImage;
use texmap_sample::{Alpha, ColorSpace, TexelData, Texture2d};

use super::{Depth, unfit, upload};
use crate::{IoError, SourceLocation};

/// A decoded image with the channels and the depth of its file.
#[derive(Debug)]
pub(crate) struct Decoded {
    /// Columns and rows.
    pub(crate) size: (u32, u32),
    channels: u32,
    /// As many values a texel as there are channels.
    pub(crate) texels: Depth,
}

impl Decoded {
    pub(super) fn new(image: DynamicImage) -> Self {
        let size = (image.width(), image.height());
        let (channels, texels) = match image {
            DynamicImage::ImageLuma8(t) => (1, Depth::U8(t.into_raw())),
            DynamicImage::ImageLumaA8(t) => (2, Depth::U8(t.into_raw())),
            DynamicImage::ImageRgb8(t) => (3, Depth::U8(t.into_raw())),
            DynamicImage::ImageRgba8(t) => (4, Depth::U8(t.into_raw())),
            DynamicImage::ImageLuma16(t) => (1, Depth::U16(t.into_raw())),
            DynamicImage::ImageLumaA16(t) => (2, Depth::U16(t.into_raw())),
            DynamicImage::ImageRgb16(t) => (3, Depth::U16(t.into_raw())),
            DynamicImage::ImageRgba16(t) => (4, Depth::U16(t.into_raw())),
            DynamicImage::ImageRgb32F(t) => (3, Depth::F32(t.into_raw())),
            other => (4, Depth::F32(other.into_rgba32f().into_raw())),
        };
        Self {
            size,
            channels,
            texels,
        }
    }

    /// The texture of one level: whole numbers are of `color`, with straight alpha, floats are linear light. If it is to be `opaque`, the
    /// alpha of the file is left out.
    pub(crate) fn texture(
        &self,
        path: &Path,
        named_by: Option<&SourceLocation>,
        color: ColorSpace,
        opaque: bool,
    ) -> Result<Texture2d<'static>, IoError> {
        if opaque && self.channels.is_multiple_of(2) {
            return self.without_alpha().texture(path, named_by, color, false);
        }
        let (texels, color, alpha) = match &self.texels {
            Depth::U8(t) => (TexelData::U8(t), color, Alpha::Straight),
            Depth::U16(t) => (TexelData::U16(t), color, Alpha::Straight),
            Depth::F32(t) => (TexelData::F32(t), ColorSpace::Linear, Alpha::Premultiplied),
        };
        upload(self.size, self.channels, texels, color, alpha)
            .map_err(|e| unfit(path, named_by, &e))
    }

    /// The same colours, opaque.
    fn without_alpha(&self) -> Self {
        let channels = self.channels;
        Self {
            size: self.size,
            channels: channels - 1,
            texels: match &self.texels {
                Depth::U8(t) => Depth::U8(without_alpha(t, channels)),
                Depth::U16(t) => Depth::U16(without_alpha(t, channels)),
                Depth::F32(t) => Depth::F32(without_alpha(t, channels)),
            },
        }
    }
}

/// The channels before the last.
fn without_alpha<T: Copy>(texels: &[T], channels: u32) -> Vec<T> {
    if channels == 2 {
        texels.iter().step_by(2).copied().collect()
    } else {
        let (texels, _) = texels.as_chunks();
        let texels: Vec<[T; 3]> = texels.iter().map(|&[r, g, b, _]| [r, g, b]).collect();
        texels.into_flattened()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image_io::Rgba;

    /// Every kind of image: the texels of one of four channels, and without alpha those of an opaque one.
    #[test]
    fn textures_are_those_of_four_channels() {
        let byte = |i: usize| (i * 37 % 256) as u8;
        let wide = |i: usize| (i * 9_377 % 65_536) as u16;
        let float = |i: usize| i as f32 * 0.25 - 0.5;
        let bytes = |n: usize| (0..6 * n).map(byte).collect::<Vec<_>>();
        let words = |n: usize| (0..6 * n).map(wide).collect::<Vec<_>>();
        let floats = |n: usize| (0..6 * n).map(float).collect::<Vec<_>>();
        let from = "the right length";
        let all = [
            DynamicImage::ImageLuma8(image::ImageBuffer::from_raw(3, 2, bytes(1)).expect(from)),
            DynamicImage::ImageLumaA8(image::ImageBuffer::from_raw(3, 2, bytes(2)).expect(from)),
            DynamicImage::ImageRgb8(image::ImageBuffer::from_raw(3, 2, bytes(3)).expect(from)),
            DynamicImage::ImageRgba8(image::ImageBuffer::from_raw(3, 2, bytes(4)).expect(from)),
            DynamicImage::ImageLuma16(image::ImageBuffer::from_raw(3, 2, words(1)).expect(from)),
            DynamicImage::ImageLumaA16(image::ImageBuffer::from_raw(3, 2, words(2)).expect(from)),
            DynamicImage::ImageRgb16(image::ImageBuffer::from_raw(3, 2, words(3)).expect(from)),
            DynamicImage::ImageRgba16(image::ImageBuffer::from_raw(3, 2, words(4)).expect(from)),
            DynamicImage::ImageRgb32F(image::ImageBuffer::from_raw(3, 2, floats(3)).expect(from)),
            DynamicImage::ImageRgba32F(image::ImageBuffer::from_raw(3, 2, floats(4)).expect(from)),
        ];
        let path = Path::new("a.png");
        let mut translucent = 0;
        for image in all {
            let mut four = Rgba::of(image.clone());
            let decoded = Decoded::new(image);
            assert_eq!(decoded.texels.bits(), four.texels.bits());
            for opaque in [false, true] {
                if opaque {
                    match &mut four.texels {
                        Depth::U8(t) => t.iter_mut().skip(3).step_by(4).for_each(|a| *a = 255),
                        Depth::U16(t) => t.iter_mut().skip(3).step_by(4).for_each(|a| *a = 65_535),
                        Depth::F32(t) => t.iter_mut().skip(3).step_by(4).for_each(|a| *a = 1.0),
                    }
                }
                for color in [ColorSpace::Srgb, ColorSpace::Linear] {
                    let texture = decoded.texture(path, None, color, opaque).unwrap();
                    let expected = match &four.texels {
                        Depth::U8(t) => upload((3, 2), 4, TexelData::U8(t), color, Alpha::Straight),
                        Depth::U16(t) => {
                            upload((3, 2), 4, TexelData::U16(t), color, Alpha::Straight)
                        }
                        Depth::F32(t) => upload(
                            (3, 2),
                            4,
                            TexelData::F32(t),
                            ColorSpace::Linear,
                            Alpha::Premultiplied,
                        ),
                    };
                    let expected = expected.unwrap();
                    for (x, y) in (0..6).map(|i| (i % 3, i / 3)) {
                        let texel = texture.texel(0, x, y).unwrap();
                        assert_eq!(texel, expected.texel(0, x, y).unwrap());
                        translucent += u32::from(texel[3] < 1.0);
                        assert!(!opaque || texel[3] == 1.0);
                    }
                }
            }
        }
        assert!(translucent > 20, "{translucent}");
    }
}

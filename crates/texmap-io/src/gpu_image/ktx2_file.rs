//! KTX2: Khronos textures, opened by the crate `ktx2`, with or without Zstandard.

use std::borrow::Cow;
use std::io::Read;

use exr::prelude::f16;
use image::{DynamicImage, ImageBuffer};
use ktx2::{Format, Level, Reader, SupercompressionScheme};
use texmap_sample::{Alpha, BlockFormat};

use super::dds_file::premultiply;
use super::{Content, GpuImage};

pub(super) fn open(bytes: &[u8]) -> Result<GpuImage<'_>, String> {
    let reader = Reader::new(bytes).map_err(|e| e.to_string())?;
    let header = reader.header();
    let several = match (header.pixel_depth, header.layer_count, header.face_count) {
        (0 | 1, 0 | 1, 0 | 1) => None,
        (_, _, 6) => Some("six faces of a cube"),
        (2.., ..) => Some("the slices of a volume"),
        _ => Some("an array of images"),
    };
    if let Some(what) = several {
        return Err(format!(
            "it holds {what}, and one image is needed: write each to a file of its own"
        ));
    }
    let Some(format) = header.format else {
        return Err(
            "Basis Universal (ETC1S or UASTC) is not read: transcode it to BC7 first, such as by `ktx transcode --target bc7`"
                .into(),
        );
    };
    let size = (header.pixel_width, header.pixel_height.max(1));
    let scheme = header.supercompression_scheme;
    let premultiplied = reader.is_alpha_premultiplied().unwrap_or(false);
    let content = if let Some(format) = blocks(format) {
        let most = size.0.max(size.1).max(1).ilog2() as usize + 1;
        let mut levels = Vec::new();
        for (k, found) in (0..).zip(reader.levels().take(most)) {
            let needed = format.level_bytes((size.0 >> k).max(1), (size.1 >> k).max(1));
            let whole = level_bytes(scheme, k, &found, needed)?;
            levels.push(Cow::Owned(whole.into_owned()));
        }
        Content::Blocks {
            format,
            alpha: match premultiplied {
                true => Alpha::Premultiplied,
                false => Alpha::Straight,
            },
            levels,
        }
    } else {
        let layout = Layout::of(format).ok_or_else(|| {
            format!(
                "{format:?} is not read: convert it to BC7, or to 8-bit, 16-bit or float channels"
            )
        })?;
        let needed = size.0 as usize * size.1 as usize * layout.bytes();
        let found = reader.levels().next().ok_or("it has no level")?;
        let whole = level_bytes(scheme, 0, &found, needed)?;
        Content::Pixels(layout.decode(size, &whole)?)
    };
    let turned = reader.key_value_data().any(|(key, value)| {
        key == "KTXorientation" && value.get(1).is_some_and(|down| *down == b'u')
    });
    Ok(GpuImage {
        size,
        content,
        bottom_up: turned,
    })
}

/// The first `needed` bytes of level `k`, inflated.
fn level_bytes<'a>(
    scheme: Option<SupercompressionScheme>,
    k: u32,
    level: &Level<'a>,
    needed: usize,
) -> Result<Cow<'a, [u8]>, String> {
    let whole: Cow<'a, [u8]> = match scheme {
        None => Cow::Borrowed(&level.data[..level.data.len().min(needed)]),
        Some(SupercompressionScheme::Zstandard) => {
            let decoder =
                ruzstd::decoding::StreamingDecoder::new(level.data).map_err(|e| e.to_string())?;
            let mut whole = Vec::new();
            let read = decoder.take(needed as u64).read_to_end(&mut whole);
            read.map_err(|e| e.to_string())?;
            Cow::Owned(whole)
        }
        Some(other) => {
            return Err(format!(
                "supercompression {other:?} is not read: write the file with Zstandard or without"
            ));
        }
    };
    match whole.len() {
        n if n == needed => Ok(whole),
        n => Err(format!("level {k} has {n} bytes, {needed} are needed")),
    }
}

fn blocks(format: Format) -> Option<BlockFormat> {
    Some(match format {
        Format::BC1_RGB_UNORM_BLOCK | Format::BC1_RGB_SRGB_BLOCK => BlockFormat::Bc1Opaque,
        Format::BC1_RGBA_UNORM_BLOCK | Format::BC1_RGBA_SRGB_BLOCK => BlockFormat::Bc1,
        Format::BC2_UNORM_BLOCK | Format::BC2_SRGB_BLOCK => BlockFormat::Bc2,
        Format::BC3_UNORM_BLOCK | Format::BC3_SRGB_BLOCK => BlockFormat::Bc3,
        Format::BC4_UNORM_BLOCK => BlockFormat::Bc4,
        Format::BC5_UNORM_BLOCK => BlockFormat::Bc5,
        Format::BC7_UNORM_BLOCK | Format::BC7_SRGB_BLOCK => BlockFormat::Bc7,
        _ => return None,
    })
}

/// Kind of a channel.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Byte,
    Word,
    Half,
    Float,
}

/// Uncompressed texels.
struct Layout {
    channels: usize,
    kind: Kind,
    /// Blue comes first.
    swapped: bool,
}

impl Layout {
    fn of(format: Format) -> Option<Self> {
        use Kind::{Byte, Float, Half, Word};
        let (channels, kind, swapped) = match format {
            Format::R8_UNORM | Format::R8_SRGB => (1, Byte, false),
            Format::R8G8_UNORM | Format::R8G8_SRGB => (2, Byte, false),
            Format::R8G8B8_UNORM | Format::R8G8B8_SRGB => (3, Byte, false),
            Format::R8G8B8A8_UNORM | Format::R8G8B8A8_SRGB => (4, Byte, false),
            Format::B8G8R8_UNORM | Format::B8G8R8_SRGB => (3, Byte, true),
            Format::B8G8R8A8_UNORM | Format::B8G8R8A8_SRGB => (4, Byte, true),
            Format::R16_UNORM => (1, Word, false),
            Format::R16G16_UNORM => (2, Word, false),
            Format::R16G16B16_UNORM => (3, Word, false),
            Format::R16G16B16A16_UNORM => (4, Word, false),
            Format::R16_SFLOAT => (1, Half, false),
            Format::R16G16_SFLOAT => (2, Half, false),
            Format::R16G16B16_SFLOAT => (3, Half, false),
            Format::R16G16B16A16_SFLOAT => (4, Half, false),
            Format::R32_SFLOAT => (1, Float, false),
            Format::R32G32_SFLOAT => (2, Float, false),
            Format::R32G32B32_SFLOAT => (3, Float, false),
            Format::R32G32B32A32_SFLOAT => (4, Float, false),
            _ => return None,
        };
        Some(Self {
            channels,
            kind,
            swapped,
        })
    }

    /// Bytes of a texel.
    fn bytes(&self) -> usize {
        self.channels
            * match self.kind {
                Kind::Byte => 1,
                Kind::Word | Kind::Half => 2,
                Kind::Float => 4,
            }
    }

    /// One channel is grey, two are red and green.
    fn decode(&self, (width, height): (u32, u32), bytes: &[u8]) -> Result<DynamicImage, String> {
        let whole = || "a buffer of another size".to_owned();
        let words = bytes.as_chunks::<2>().0;
        Ok(match self.kind {
            Kind::Byte => {
                let texels = self.spread(bytes.iter().copied(), 0, u8::MAX);
                let image = ImageBuffer::from_raw(width, height, texels);
                DynamicImage::ImageRgba8(image.ok_or_else(whole)?)
            }
            Kind::Word => {
                let words = words.iter().map(|c| u16::from_le_bytes(*c));
                let image = ImageBuffer::from_raw(width, height, self.spread(words, 0, u16::MAX));
                DynamicImage::ImageRgba16(image.ok_or_else(whole)?)
            }
            Kind::Half | Kind::Float => {
                let floats: Vec<f32> = match self.kind {
                    Kind::Half => {
                        let halves = words.iter().map(|c| f16::from_le_bytes(*c));
                        halves.map(f16::to_f32).collect()
                    }
                    _ => {
                        let words = bytes.as_chunks::<4>().0.iter();
                        words.map(|c| f32::from_le_bytes(*c)).collect()
                    }
                };
                let mut texels = self.spread(floats.into_iter(), 0.0, 1.0);
                premultiply(&mut texels);
                let image = ImageBuffer::from_raw(width, height, texels);
                DynamicImage::ImageRgba32F(image.ok_or_else(whole)?)
            }
        })
    }

    /// Four values a texel.
    fn spread<T: Copy>(&self, values: impl Iterator<Item = T>, none: T, most: T) -> Vec<T> {
        let values: Vec<T> = values.collect();
        let texels = values.chunks_exact(self.channels);
        texels
            .flat_map(|texel| match *texel {
                [x] => [x, x, x, most],
                [x, y] => [x, y, none, most],
                [b, g, r] if self.swapped => [r, g, b, most],
                [r, g, b] => [r, g, b, most],
                [b, g, r, a] if self.swapped => [r, g, b, a],
                [r, g, b, a] => [r, g, b, a],
                _ => [none; 4],
            })
            .collect()
    }
}

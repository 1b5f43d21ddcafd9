//! KTX2: Khronos textures, with or without Zstandard. Source: Khronos, "KTX File Format Specification", version 2.0.

use std::borrow::Cow;
use std::io::Read;

use exr::prelude::f16;
use image::{DynamicImage, ImageBuffer};
use texmap_sample::{Alpha, BlockFormat};

use super::dds_file::premultiply;
use super::{Content, GpuImage};

pub(super) const MAGIC: &[u8] = b"\xABKTX 20\xBB\r\n\x1A\n";

/// The head of a file and its levels, largest first. Every range lies within the file.
struct Ktx2<'a> {
    /// A VkFormat; 0 for textures that are transcoded first.
    format: u32,
    size: (u32, u32),
    depth: u32,
    layers: u32,
    faces: u32,
    scheme: u32,
    levels: Vec<&'a [u8]>,
    descriptor: &'a [u8],
    key_values: &'a [u8],
}

impl<'a> Ktx2<'a> {
    fn read(bytes: &'a [u8]) -> Result<Self, String> {
        let word = |at: usize| -> Result<u32, String> {
            let found = bytes.get(at..).and_then(|rest| rest.first_chunk());
            found
                .map(|word| u32::from_le_bytes(*word))
                .ok_or_else(|| "the file ends within its head".to_owned())
        };
        let long =
            |at: usize| Ok::<u64, String>(u64::from(word(at)?) | u64::from(word(at + 4)?) << 32);
        let part = |what: &str, start: u64, length: u64| -> Result<&'a [u8], String> {
            let end = start.checked_add(length);
            let range = usize::try_from(start)
                .ok()
                .zip(end.and_then(|end| usize::try_from(end).ok()));
            let found = range.and_then(|(start, end)| bytes.get(start..end));
            found.ok_or_else(|| format!("{what} is not within the file"))
        };
        let count = word(40)?.clamp(1, 32);
        let levels = (0..count as usize).map(|k| {
            let at = 80 + 24 * k;
            part(&format!("level {k}"), long(at)?, long(at + 8)?)
        });
        Ok(Self {
            format: word(12)?,
            size: (word(20)?, word(24)?.max(1)),
            depth: word(28)?,
            layers: word(32)?,
            faces: word(36)?,
            scheme: word(44)?,
            levels: levels.collect::<Result<_, _>>()?,
            descriptor: part("the descriptor", word(48)?.into(), word(52)?.into())?,
            key_values: part("the list of keys", word(56)?.into(), word(60)?.into())?,
        })
    }

    /// The flag of the basic descriptor.
    fn is_premultiplied(&self) -> bool {
        self.descriptor.get(15).is_some_and(|flags| flags & 1 == 1)
    }

    /// True if the first row is the bottom one.
    fn is_bottom_up(&self) -> bool {
        let key = b"KTXorientation\0";
        let found = self
            .key_values
            .windows(key.len() + 2)
            .find(|part| part.starts_with(key));
        found.is_some_and(|part| part[key.len() + 1] == b'u')
    }
}

pub(super) fn open(bytes: &[u8]) -> Result<GpuImage<'_>, String> {
    let file = Ktx2::read(bytes)?;
    let several = match (file.depth, file.layers, file.faces) {
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
    if file.format == 0 {
        return Err(
            "Basis Universal (ETC1S or UASTC) is not read: transcode it to BC7 first, such as by `ktx transcode --target bc7`"
                .into(),
        );
    }
    let (size, scheme) = (file.size, file.scheme);
    let content = if let Some(format) = blocks(file.format) {
        let most = size.0.max(size.1).max(1).ilog2() as usize + 1;
        let mut levels = Vec::new();
        for (k, data) in (0..).zip(file.levels.iter().take(most)) {
            let needed = format.level_bytes((size.0 >> k).max(1), (size.1 >> k).max(1));
            let whole = level_bytes(scheme, k, data, needed)?;
            levels.push(whole);
        }
        Content::Blocks {
            format,
            alpha: match file.is_premultiplied() {
                true => Alpha::Premultiplied,
                false => Alpha::Straight,
            },
            levels,
        }
    } else {
        let layout = Layout::of(file.format).ok_or_else(|| {
            format!(
                "{} is not read: convert it to BC7, or to 8-bit, 16-bit or float channels",
                name(file.format)
            )
        })?;
        let needed = size.0 as usize * size.1 as usize * layout.bytes();
        let data = file.levels.first().ok_or("it has no level")?;
        let whole = level_bytes(scheme, 0, data, needed)?;
        Content::Pixels(layout.decode(size, &whole)?)
    };
    Ok(GpuImage {
        size,
        content,
        bottom_up: file.is_bottom_up(),
    })
}

/// Kinds of formats that are refused, by their numbers in Vulkan.
fn name(format: u32) -> String {
    let kind = match format {
        140 | 142 => "signed BC4 or BC5",
        143 | 144 => "BC6H",
        147..=156 => "ETC2 or EAC",
        157..=184 => "ASTC",
        _ => "this format",
    };
    format!("{kind} (VkFormat {format})")
}

/// The first `needed` bytes of level `k`, inflated.
fn level_bytes<'a>(
    scheme: u32,
    k: u32,
    data: &'a [u8],
    needed: usize,
) -> Result<Cow<'a, [u8]>, String> {
    let whole: Cow<'a, [u8]> = match scheme {
        0 => Cow::Borrowed(&data[..data.len().min(needed)]),
        2 => {
            let decoder =
                ruzstd::decoding::StreamingDecoder::new(data).map_err(|e| e.to_string())?;
            let mut whole = Vec::new();
            let read = decoder.take(needed as u64).read_to_end(&mut whole);
            read.map_err(|e| e.to_string())?;
            Cow::Owned(whole)
        }
        other => {
            return Err(format!(
                "supercompression {other} (1 is BasisLZ, 3 ZLIB) is not read: write the file with Zstandard or without"
            ));
        }
    };
    match whole.len() {
        n if n == needed => Ok(whole),
        n => Err(format!("level {k} has {n} bytes, {needed} are needed")),
    }
}

/// Numbers of VkFormat: linear and sRGB of each kind.
fn blocks(format: u32) -> Option<BlockFormat> {
    Some(match format {
        131 | 132 => BlockFormat::Bc1Opaque,
        133 | 134 => BlockFormat::Bc1,
        135 | 136 => BlockFormat::Bc2,
        137 | 138 => BlockFormat::Bc3,
        139 => BlockFormat::Bc4,
        141 => BlockFormat::Bc5,
        145 | 146 => BlockFormat::Bc7,
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
    /// By the number of VkFormat.
    fn of(format: u32) -> Option<Self> {
        use Kind::{Byte, Float, Half, Word};
        let (channels, kind, swapped) = match format {
            9 | 15 => (1, Byte, false),
            16 | 22 => (2, Byte, false),
            23 | 29 => (3, Byte, false),
            37 | 43 => (4, Byte, false),
            30 | 36 => (3, Byte, true),
            44 | 50 => (4, Byte, true),
            70 => (1, Word, false),
            77 => (2, Word, false),
            84 => (3, Word, false),
            91 => (4, Word, false),
            76 => (1, Half, false),
            83 => (2, Half, false),
            90 => (3, Half, false),
            97 => (4, Half, false),
            100 => (1, Float, false),
            103 => (2, Float, false),
            106 => (3, Float, false),
            109 => (4, Float, false),
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

//! Images in (PNG, JPEG, GIF) and out (PNG).

use std::io::{self, Cursor};
use std::path::Path;

use image::codecs::png::PngEncoder;
use image::{DynamicImage, ExtendedColorType, ImageDecoder, ImageEncoder, ImageReader, Limits};
use texmap_math::MemoryBudget;
use texmap_sample::{Alpha, ColorSpace, Image, Origin, SampleError, Texels, Texture2d};

use crate::{IoError, Place, atomic, files};

/// The largest width and height of an image.
pub const MAX_SIDE: u32 = Texture2d::MAX_SIDE;

/// The most texels of an image: 2^28, 16384 x 16384.
pub const MAX_TEXELS: u64 = 1 << 28;

/// A decoded image: RGBA with straight alpha, rows from top to bottom.
#[derive(Debug, Clone, PartialEq, Eq)]
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
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Depth {
    /// 8 bits a channel.
    U8(Vec<u8>),
    /// 16 bits a channel (PNG).
    U16(Vec<u16>),
}

impl Depth {
    /// Bits a channel.
    pub fn bits(&self) -> u32 {
        match self {
            Self::U8(_) => 8,
            Self::U16(_) => 16,
        }
    }
}

/// Decodes a PNG, JPEG or GIF file; its content decides which, not its name.
///
/// Grey images become RGB, images without alpha opaque. The transparent index of a GIF becomes alpha 0; of an animated
/// GIF the first picture is taken. Embedded colour profiles and orientations are not applied.
///
/// # Errors
/// File errors, [`IoError::BrokenImage`], [`IoError::ImageSize`], [`IoError::Memory`].
pub fn read_image(path: &Path) -> Result<Rgba, IoError> {
    read_named(path, None, MemoryBudget::of_process())
}

/// Decodes an image file to a texture of one level, top-left origin. Colours are sRGB or taken as they are. The bytes of 8-bit files stay
/// what they are in memory ([`Texture2d::from_encoded8`]).
///
/// # Errors
/// As [`read_image`].
pub fn read_texture(path: &Path, color: ColorSpace) -> Result<Texture2d<'static>, IoError> {
    let decoded = decode(path, None, MemoryBudget::of_process())?;
    let (width, height) = (decoded.width(), decoded.height());
    let origin = Origin::TopLeft;
    let kept = |channels: u32, texels: Vec<u8>| {
        Texture2d::from_encoded8((width, height), channels, texels, color, origin)
    };
    let wide =
        |channels: u32, texels: &[u16]| upload(width, height, channels, Texels::U16(texels), color);
    match decoded {
        DynamicImage::ImageLuma8(t) => kept(1, t.into_raw()),
        DynamicImage::ImageLumaA8(t) => kept(2, t.into_raw()),
        DynamicImage::ImageRgb8(t) => kept(3, t.into_raw()),
        DynamicImage::ImageRgba8(t) => kept(4, t.into_raw()),
        DynamicImage::ImageLuma16(t) => wide(1, &t),
        DynamicImage::ImageLumaA16(t) => wide(2, &t),
        DynamicImage::ImageRgb16(t) => wide(3, &t),
        DynamicImage::ImageRgba16(t) => wide(4, &t),
        other => kept(4, other.into_rgba8().into_raw()),
    }
    .map_err(|e| unfit(path, None, &e))
}

fn upload(
    width: u32,
    height: u32,
    channels: u32,
    texels: Texels<'_>,
    color: ColorSpace,
) -> Result<Texture2d<'static>, SampleError> {
    Texture2d::new(&Image {
        width,
        height,
        channels,
        texels,
        color,
        alpha: Alpha::Straight,
        origin: Origin::TopLeft,
    })
}

fn unfit(path: &Path, named_by: Option<&Place>, e: &SampleError) -> IoError {
    IoError::BrokenImage {
        path: path.to_path_buf(),
        named_by: named_by.cloned(),
        problem: e.to_string(),
    }
}

pub(crate) fn read_named(
    path: &Path,
    named_by: Option<&Place>,
    memory: MemoryBudget,
) -> Result<Rgba, IoError> {
    let decoded = decode(path, named_by, memory)?;
    let (width, height) = (decoded.width(), decoded.height());
    let channels = u32::from(decoded.color().channel_count());
    let texels = match decoded {
        deep @ (DynamicImage::ImageLuma16(_)
        | DynamicImage::ImageLumaA16(_)
        | DynamicImage::ImageRgb16(_)
        | DynamicImage::ImageRgba16(_)) => Depth::U16(deep.into_rgba16().into_raw()),
        other => Depth::U8(other.into_rgba8().into_raw()),
    };
    Ok(Rgba {
        width,
        height,
        channels,
        texels,
    })
}

/// Asks for `bytes` bytes for each of an image's texels.
pub(crate) fn ask_for_texels(
    memory: MemoryBudget,
    path: &Path,
    named_by: Option<&Place>,
    (width, height): (u32, u32),
    bytes: u64,
) -> Result<(), IoError> {
    let asked = memory.ask(
        u64::from(width) * u64::from(height) * bytes,
        format_args!("the {width} x {height} texels of {}", path.display()),
        "take a smaller image",
    );
    asked.map_err(|refused| IoError::memory(refused, named_by))
}

fn decode(
    path: &Path,
    named_by: Option<&Place>,
    memory: MemoryBudget,
) -> Result<DynamicImage, IoError> {
    let bytes = files::read(path, named_by)?;
    let broken = |problem: String| IoError::BrokenImage {
        path: path.to_path_buf(),
        named_by: named_by.cloned(),
        // Some decoders end their messages with a line feed.
        problem: problem.trim_end().replace('\n', " "),
    };
    let size_error = |(width, height)| IoError::ImageSize {
        path: path.to_path_buf(),
        named_by: named_by.cloned(),
        width,
        height,
    };
    let size_allowed = |(width, height): (u32, u32)| {
        let side = 1..=MAX_SIDE;
        side.contains(&width)
            && side.contains(&height)
            && u64::from(width) * u64::from(height) <= MAX_TEXELS
    };
    // Decoders call a size of zero "broken"; say what it is.
    if let Some(size) = header_size(&bytes).filter(|size| !size_allowed(*size)) {
        return Err(size_error(size));
    }
    let reader = || {
        let mut reader = ImageReader::new(Cursor::new(&bytes))
            .with_guessed_format()
            .map_err(|e| broken(e.to_string()))?;
        let mut limits = Limits::default();
        limits.max_alloc = Some(8 * MAX_TEXELS);
        reader.limits(limits);
        Ok(reader)
    };
    let size = reader()?
        .into_dimensions()
        .map_err(|e| broken(e.to_string()))?;
    if !size_allowed(size) {
        return Err(size_error(size));
    }
    let decoder = reader()?
        .into_decoder()
        .map_err(|e| broken(e.to_string()))?;
    // As it is decoded, then with four channels of the same depth.
    let color = decoder.color_type();
    let bytes = color.bytes_per_pixel() + 4 * (color.bytes_per_pixel() / color.channel_count());
    ask_for_texels(memory, path, named_by, size, u64::from(bytes))?;
    DynamicImage::from_decoder(decoder).map_err(|e| broken(e.to_string()))
}

pub(crate) fn texture(
    path: &Path,
    named_by: Option<&Place>,
    image: &Rgba,
    color: ColorSpace,
) -> Result<Texture2d<'static>, IoError> {
    let texels = match &image.texels {
        Depth::U8(t) => Texels::U8(t),
        Depth::U16(t) => Texels::U16(t),
    };
    upload(image.width, image.height, 4, texels, color).map_err(|e| unfit(path, named_by, &e))
}

/// Writes RGBA bytes (straight alpha, rows from top to bottom) as PNG, whole or not at all.
///
/// # Errors
/// [`IoError::Write`], also when `rgba` does not hold `4 * width * height` bytes or a side is zero.
pub fn write_png(path: &Path, width: u32, height: u32, rgba: &[u8]) -> Result<(), IoError> {
    // The encoder holds all filtered rows and all compressed bytes.
    let asked = MemoryBudget::of_process().ask(
        2 * rgba.len() as u64,
        format_args!("a PNG of {width} x {height} pixels"),
        "write a smaller picture",
    );
    asked.map_err(|refused| IoError::memory(refused, None))?;
    atomic::write(path, |out| {
        if width == 0
            || height == 0
            || rgba.len() as u64 != 4 * u64::from(width) * u64::from(height)
        {
            let problem = format!("{} bytes for {width} x {height} RGBA pixels", rgba.len());
            return Err(io::Error::new(io::ErrorKind::InvalidInput, problem));
        }
        PngEncoder::new(out)
            .write_image(rgba, width, height, ExtendedColorType::Rgba8)
            .map_err(io::Error::other)
    })
}

/// As [`write_png`] for pictures that are never whole in memory: `rows` writes the same bytes, in order and
/// any number at a time, to what it is given.
///
/// # Errors
/// [`IoError::Write`], also when bytes are missing or left over, or when `rows` fails.
pub fn write_png_rows(
    path: &Path,
    width: u32,
    height: u32,
    rows: impl FnOnce(&mut dyn io::Write) -> io::Result<()>,
) -> Result<(), IoError> {
    atomic::write(path, |out| {
        let mut encoder = png::Encoder::new(out, width, height);
        encoder.set_color(png::ColorType::Rgba);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_compression(png::Compression::Fast);
        encoder.set_filter(png::Filter::Adaptive);
        let mut writer = encoder.write_header()?;
        let mut stream = writer.stream_writer()?;
        rows(&mut stream)?;
        stream.finish()?;
        Ok(writer.finish()?)
    })
}

/// Width and height as the header of a PNG or GIF file states them.
fn header_size(bytes: &[u8]) -> Option<(u32, u32)> {
    if bytes.starts_with(b"\x89PNG\r\n\x1a\n") {
        let side = |at: usize| {
            bytes
                .get(at..at + 4)?
                .try_into()
                .ok()
                .map(u32::from_be_bytes)
        };
        Some((side(16)?, side(20)?))
    } else if bytes.starts_with(b"GIF8") {
        let side = |at: usize| {
            bytes
                .get(at..at + 2)?
                .try_into()
                .ok()
                .map(u16::from_le_bytes)
                .map(u32::from)
        };
        Some((side(6)?, side(8)?))
    } else {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn png_round_trip_keeps_every_byte() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.png");
        let texels: Vec<u8> = (0..3 * 2 * 4).map(|i| (i * 10) as u8).collect();
        write_png(&path, 3, 2, &texels).unwrap();
        assert_eq!(
            read_image(&path).unwrap(),
            Rgba {
                width: 3,
                height: 2,
                channels: 4,
                texels: Depth::U8(texels)
            }
        );
        assert_eq!(
            write_png(&path, 3, 3, &[0; 4]).unwrap_err().code(),
            "write-failed"
        );
        assert_eq!(read_image(&path).unwrap().height, 2, "the old file is left");
    }

    #[test]
    fn rows_make_the_same_picture() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.png");
        let texels: Vec<u8> = (0..5 * 3 * 4).map(|i| (i * 4) as u8).collect();
        write_png_rows(&path, 5, 3, |out| {
            texels.chunks(7).try_for_each(|part| out.write_all(part))
        })
        .unwrap();
        let read = read_image(&path).unwrap();
        assert_eq!((read.width, read.height, read.channels), (5, 3, 4));
        assert_eq!(read.texels, Depth::U8(texels));
        let missing = write_png_rows(&path, 5, 3, |out| out.write_all(&[0; 20]));
        assert_eq!(missing.unwrap_err().code(), "write-failed");
        assert_eq!(read_image(&path).unwrap(), read, "the old file is left");
    }

    #[test]
    fn sixteen_bits_stay_sixteen() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.png");
        let deep =
            image::ImageBuffer::<image::Luma<u16>, _>::from_raw(2, 1, vec![257_u16, 513]).unwrap();
        deep.save(&path).unwrap();
        let Depth::U16(texels) = read_image(&path).unwrap().texels else {
            panic!("16-bit PNG")
        };
        assert_eq!(texels, [257, 257, 257, 65535, 513, 513, 513, 65535]);
    }

    #[test]
    fn every_truncation_is_an_error_not_a_panic() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.png");
        write_png(&path, 4, 4, &[77; 64]).unwrap();
        let whole = fs::read(&path).unwrap();
        for cut in 0..whole.len() - 12 {
            fs::write(&path, &whole[..cut]).unwrap();
            assert_eq!(
                read_image(&path).unwrap_err().code(),
                "broken-image",
                "cut at {cut}"
            );
        }
    }

    #[test]
    fn zero_sizes_are_named() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.png");
        write_png(&path, 4, 4, &[77; 64]).unwrap();
        let mut bytes = fs::read(&path).unwrap();
        bytes[16..20].fill(0);
        fs::write(&path, bytes).unwrap();
        assert_eq!(read_image(&path).unwrap_err().code(), "image-size");
        fs::write(&path, b"GIF89a\0\0\x04\0\0\0\0;").unwrap();
        assert_eq!(read_image(&path).unwrap_err().code(), "image-size");
    }
}

//! Images in (PNG, JPEG, WebP, GIF, BMP, TGA, TIFF, QOI, Radiance HDR, OpenEXR) and out (PNG; [`PictureFormat`](crate::PictureFormat) has the others).

mod decode;
mod decoded;
mod rgba;
mod source;

use std::io;
use std::path::Path;

use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{DynamicImage, ExtendedColorType, ImageEncoder};
use texmap_math::MemoryBudget;
use texmap_sample::{Alpha, ColorSpace, Image, Origin, SampleError, TexelData, Texture2d};

use decode::{decode_bytes, size_allowed};

use crate::files::FileSource;
#[cfg(feature = "gpu-images")]
use crate::gpu_image;
use crate::{IoError, SourceLocation, atomic};

pub(crate) use decode::{ask_for_texels, decode, stated_size};
pub(crate) use decoded::Decoded;
pub use rgba::{Depth, Rgba};
pub(crate) use source::ImageSource;

/// The largest width and height of an image.
pub const MAX_SIDE: u32 = Texture2d::MAX_SIDE;

/// The most texels of an image: 2^28, 16384 x 16384.
pub const MAX_TEXELS: u64 = 1 << 28;

/// Endings of the names of images that are read. The content of a file decides its format.
pub const ENDINGS: &[&str] = &[
    "png",
    "jpg",
    "jpeg",
    "webp",
    "gif",
    "bmp",
    "tga",
    #[cfg(feature = "tiff")]
    "tif",
    #[cfg(feature = "tiff")]
    "tiff",
    "qoi",
    #[cfg(feature = "gpu-images")]
    "dds",
    #[cfg(feature = "gpu-images")]
    "ktx2",
    "hdr",
    "exr",
];

/// Decodes a PNG, JPEG, WebP, GIF, BMP, TGA, TIFF (feature `tiff`), QOI, HDR or EXR file; its content decides which, not its name (but for
/// TGA, which only its name tells).
///
/// Grey images become RGB, images without alpha opaque. The transparent index of a GIF becomes alpha 0; of an animated
/// GIF or WebP the first picture is taken; of an EXR the first part with red, green and blue (of a layer, if need be) or with
/// luminance. Pictures are turned as their Exif orientation says; embedded colour profiles are not applied.
///
/// # Errors
/// File errors, [`IoError::BrokenImage`], [`IoError::ImageSize`], [`IoError::Memory`].
pub fn read_image(path: &Path) -> Result<Rgba, IoError> {
    let files = FileSource::anywhere();
    let image = decode(&files, path, None, &|size| size_allowed(path, None, size))?;
    with_four_channels(&files, path, image)
}

fn with_four_channels(
    files: &FileSource,
    path: &Path,
    image: DynamicImage,
) -> Result<Rgba, IoError> {
    let (size, color) = ((image.width(), image.height()), image.color());
    let bytes = 4 * color.bytes_per_pixel() / color.channel_count();
    ask_for_texels(files, path, None, size, bytes.into())?;
    Ok(Rgba::of(image))
}

/// Decodes an image file to a texture of one level, top-left origin, and gives its bits a channel. The colours of whole numbers
/// are sRGB or taken as they are; floats (HDR, EXR) are linear light. The bytes of 8-bit files are kept in memory
/// ([`Texture2d::from_encoded8`]); those of 16 bits become floats, which keep each of their codes apart.
///
/// # Errors
/// As [`read_image`]; [`IoError::BrokenImage`] also for floats that no texture may have (NaN, infinities, beyond 2^120).
pub fn read_texture(path: &Path, color: ColorSpace) -> Result<(Texture2d<'static>, u32), IoError> {
    let files = FileSource::anywhere();
    #[cfg(feature = "gpu-images")]
    if let Some(texture) = block_texture(&files, path, None, color)? {
        return Ok((texture, 8));
    }
    let decoded = decode(&files, path, None, &|size| size_allowed(path, None, size))?;
    let (width, height) = (decoded.width(), decoded.height());
    let kept = |channels: u32, texels: Vec<u8>| {
        let origin = Origin::TopLeft;
        Texture2d::from_encoded8((width, height), channels, texels, color, origin)
    };
    let texture = match decoded {
        DynamicImage::ImageLuma8(t) => kept(1, t.into_raw()),
        DynamicImage::ImageLumaA8(t) => kept(2, t.into_raw()),
        DynamicImage::ImageRgb8(t) => kept(3, t.into_raw()),
        DynamicImage::ImageRgba8(t) => kept(4, t.into_raw()),
        other => {
            let image = with_four_channels(&files, path, other)?;
            let bits = image.texels.bits();
            let (texels, alpha) = image.into_floats(color);
            return linear((width, height), &texels, alpha)
                .map(|texture| (texture, bits))
                .map_err(|e| unfit(path, None, &e));
        }
    };
    texture
        .map(|texture| (texture, 8))
        .map_err(|e| unfit(path, None, &e))
}

/// The texture of a block-compressed file, with the mip levels of the file; `None` of any other.
#[cfg(feature = "gpu-images")]
pub(crate) fn block_texture(
    files: &FileSource,
    path: &Path,
    named_by: Option<&SourceLocation>,
    color: ColorSpace,
) -> Result<Option<Texture2d<'static>>, IoError> {
    if gpu_image::head(files, path).is_none() {
        return Ok(None);
    }
    let bytes = files.read_named(path, named_by, crate::files::MAX_TEXT)?;
    let file = gpu_image::GpuFile {
        files,
        path,
        named_by,
        bytes: &bytes,
    };
    file.texture(color, &|size| size_allowed(path, named_by, size))
}

/// A texture of linear RGBA floats.
fn linear(
    (width, height): (u32, u32),
    texels: &[f32],
    alpha: Alpha,
) -> Result<Texture2d<'static>, SampleError> {
    let texels = TexelData::F32(texels);
    upload((width, height), 4, texels, ColorSpace::Linear, alpha)
}

fn upload(
    (width, height): (u32, u32),
    channels: u32,
    texels: TexelData<'_>,
    color: ColorSpace,
    alpha: Alpha,
) -> Result<Texture2d<'static>, SampleError> {
    Texture2d::new(&Image {
        width,
        height,
        channels,
        texels,
        color,
        alpha,
        origin: Origin::TopLeft,
    })
}

fn unfit(path: &Path, named_by: Option<&SourceLocation>, e: &SampleError) -> IoError {
    IoError::BrokenImage {
        path: path.to_path_buf(),
        named_by: named_by.cloned(),
        problem: e.to_string(),
    }
}

pub(crate) fn read_named(
    files: &FileSource,
    path: &Path,
    named_by: Option<&SourceLocation>,
) -> Result<Decoded, IoError> {
    decode(files, path, named_by, &|size| {
        size_allowed(path, named_by, size)
    })
    .map(Decoded::new)
}

/// Decodes the bytes of an image that messages call `path`.
pub(crate) fn read_bytes(
    files: &FileSource,
    path: &Path,
    bytes: &[u8],
) -> Result<Decoded, IoError> {
    decode_bytes(files, path, None, bytes, &|size| {
        size_allowed(path, None, size)
    })
    .map(Decoded::new)
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
    atomic::write(path, |out| encode_png(out, width, height, rgba))
}

/// Writes the bytes of [`write_png`]'s file to `out`: for pictures that go elsewhere than into a file.
///
/// # Errors
/// Those of `out`; [`io::ErrorKind::InvalidInput`] when `rgba` does not hold `4 * width * height` bytes or a side is zero.
pub fn encode_png(out: impl io::Write, width: u32, height: u32, rgba: &[u8]) -> io::Result<()> {
    if width == 0 || height == 0 || rgba.len() as u64 != 4 * u64::from(width) * u64::from(height) {
        let problem = format!("{} bytes for {width} x {height} RGBA pixels", rgba.len());
        return Err(io::Error::new(io::ErrorKind::InvalidInput, problem));
    }
    // One filter for all rows: it takes 3 ms for 1024 x 768 pixels, the best of five 20 ms. Files have 2 % more bytes.
    PngEncoder::new_with_quality(out, CompressionType::Fast, FilterType::Paeth)
        .write_image(rgba, width, height, ExtendedColorType::Rgba8)
        .map_err(io::Error::other)
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

    /// Linear light above 1 and below 0, and premultiplied alpha, come in as the file has them.
    #[test]
    fn floats_stay_floats() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.exr");
        let texels = vec![200.0, 3.0, -0.5, 0.25, 0.1, 0.2, 0.3, 1.0];
        let write = |path: &Path, texels: &[f32]| {
            exr::prelude::write_rgba_file(path, 2, 1, |x, _| {
                let t = &texels[4 * x..];
                (t[0], t[1], t[2], t[3])
            })
            .unwrap();
        };
        write(&path, &texels);
        let image = read_image(&path).unwrap();
        assert_eq!((image.channels, image.texels.bits()), (4, 32));
        assert_eq!(image.texels, Depth::F32(texels.clone()));
        for color in [ColorSpace::Srgb, ColorSpace::Linear] {
            let (texture, bits) = read_texture(&path, color).unwrap();
            assert_eq!(bits, 32);
            assert_eq!(texture.texel(0, 0, 0).unwrap()[..], texels[..4]);
            let named = read_named(&FileSource::anywhere(), &path, None).unwrap();
            let named = named.texture(&path, None, color, false).unwrap();
            assert_eq!(named.texel(0, 1, 0).unwrap()[..], texels[4..]);
        }
        let path = dir.path().join("nan.exr");
        write(&path, &[1.0, 1.0, 1.0, 1.0, 1.0, f32::NAN, 1.0, 1.0]);
        let error = read_texture(&path, ColorSpace::Srgb).unwrap_err();
        assert_eq!(error.code(), "broken-image");
        assert!(error.to_string().contains("texel (1, 0)"), "{error}");
    }

    /// 16-bit sRGB codes are all apart in linear light, whose 16 bits would merge the dark ones.
    #[test]
    fn every_code_of_sixteen_bits_is_another_value() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.png");
        image::ImageBuffer::<image::Luma<u16>, _>::from_fn(256, 256, |x, y| {
            image::Luma([(y * 256 + x) as u16])
        })
        .save(&path)
        .unwrap();
        let (texture, bits) = read_texture(&path, ColorSpace::Srgb).unwrap();
        assert_eq!(bits, 16);
        let red = |i: u32| texture.texel(0, i % 256, i / 256).unwrap()[0];
        assert!((1..65536).all(|i| red(i) > red(i - 1)));
        assert_eq!((red(0), red(65535)), (0.0, 1.0));
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

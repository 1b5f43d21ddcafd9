//! Decoding: the size is known and allowed, and the memory asked for, before the first texel.

use std::path::Path;

use image::metadata::Orientation;
use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits};

use super::source::ImageSource;
use super::{MAX_SIDE, MAX_TEXELS};
use crate::files::{FileSource, MAX_TEXT, is_called};
#[cfg(feature = "gpu-images")]
use crate::gpu_image;
use crate::open_exr::{self, ExrFile};
use crate::{IoError, SourceLocation};

pub(super) fn size_allowed(
    path: &Path,
    named_by: Option<&SourceLocation>,
    (width, height): (u32, u32),
) -> Result<(), IoError> {
    let side = 1..=MAX_SIDE;
    if side.contains(&width)
        && side.contains(&height)
        && u64::from(width) * u64::from(height) <= MAX_TEXELS
    {
        return Ok(());
    }
    Err(IoError::ImageSize {
        path: path.to_path_buf(),
        named_by: named_by.cloned(),
        width,
        height,
    })
}

/// Asks for `bytes` bytes for each of an image's texels.
pub(crate) fn ask_for_texels(
    files: &FileSource,
    path: &Path,
    named_by: Option<&SourceLocation>,
    (width, height): (u32, u32),
    bytes: u64,
) -> Result<(), IoError> {
    files.ask(
        u64::from(width) * u64::from(height) * bytes,
        format_args!("the {width} x {height} texels of {}", path.display()),
        "take a smaller image",
        named_by,
    )
}

/// Decodes an image file of a size that `fits`.
pub(crate) fn decode(
    files: &FileSource,
    path: &Path,
    named_by: Option<&SourceLocation>,
    fits: &dyn Fn((u32, u32)) -> Result<(), IoError>,
) -> Result<DynamicImage, IoError> {
    let bytes = files.read_named(path, named_by, MAX_TEXT)?;
    decode_bytes(files, path, named_by, &bytes, fits)
}

pub(super) fn decode_bytes(
    files: &FileSource,
    path: &Path,
    named_by: Option<&SourceLocation>,
    bytes: &[u8],
    fits: &dyn Fn((u32, u32)) -> Result<(), IoError>,
) -> Result<DynamicImage, IoError> {
    let broken = |problem: String| IoError::BrokenImage {
        path: path.to_path_buf(),
        named_by: named_by.cloned(),
        // Some decoders end their messages with a line feed.
        problem: problem.trim_end().replace('\n', " "),
    };
    #[cfg(feature = "gpu-images")]
    if gpu_image::is_one(bytes) {
        let file = gpu_image::GpuFile {
            files,
            path,
            named_by,
            bytes,
        };
        return file.decode(fits);
    }
    if let Some((format, feature)) = left_out(bytes) {
        return Err(IoError::ImageLeftOut {
            path: path.to_path_buf(),
            named_by: named_by.cloned(),
            format,
            feature,
        });
    }
    // Decoders call a size of zero "broken"; say what it is.
    if let Some(size) = header_size(bytes) {
        fits(size)?;
    }
    if bytes.starts_with(open_exr::MAGIC) {
        let file = ExrFile::open(ImageSource::bytes(bytes)).map_err(broken)?;
        fits(file.size())?;
        let texel = 4 * file.floats() as u64;
        ask_for_texels(files, path, named_by, file.size(), texel)?;
        return file.decode().map_err(broken);
    }
    let mut reader = ImageReader::new(ImageSource::bytes(bytes))
        .with_guessed_format()
        .map_err(|e| broken(e.to_string()))?;
    // TGA files begin with nothing of their own.
    if reader.format().is_none() && is_called(path, "tga") {
        reader.set_format(ImageFormat::Tga);
    }
    let mut limits = Limits::default();
    // Four floats a texel.
    limits.max_alloc = Some(16 * MAX_TEXELS);
    reader.limits(limits);
    let mut decoder = reader.into_decoder().map_err(|e| broken(e.to_string()))?;
    let (width, height) = decoder.dimensions();
    let orientation = decoder.orientation().unwrap_or(Orientation::NoTransforms);
    let turned = match orientation {
        Orientation::Rotate90
        | Orientation::Rotate270
        | Orientation::Rotate90FlipH
        | Orientation::Rotate270FlipH => (height, width),
        _ => (width, height),
    };
    fits(turned)?;
    // As it is decoded, and turned where it has to be.
    let kept = match orientation {
        Orientation::NoTransforms => 1,
        _ => 2,
    };
    let texel = kept * decoder.color_type().bytes_per_pixel();
    ask_for_texels(files, path, named_by, turned, u64::from(texel))?;
    let mut image = DynamicImage::from_decoder(decoder).map_err(|e| broken(e.to_string()))?;
    image.apply_orientation(orientation);
    Ok(image)
}

/// The format of a file that this build does not read, and the feature that reads it.
fn left_out(bytes: &[u8]) -> Option<(&'static str, &'static str)> {
    let begins = |magic: &[u8]| bytes.starts_with(magic);
    if cfg!(not(feature = "gpu-images")) && begins(b"DDS ") {
        Some(("DDS", "gpu-images"))
    } else if cfg!(not(feature = "gpu-images")) && begins(b"\xabKTX 20\xbb") {
        Some(("KTX2", "gpu-images"))
    } else if cfg!(not(feature = "tiff")) && (begins(b"II*\0") || begins(b"MM\0*")) {
        Some(("TIFF", "tiff"))
    } else {
        None
    }
}

/// Width and height that a file states before anything is decoded, if that is clear.
pub(crate) fn stated_size(files: &FileSource, path: &Path) -> Option<(u32, u32)> {
    let opened = files.open(path, None, MAX_TEXT).ok()?;
    #[cfg(feature = "gpu-images")]
    if let Some(head) = gpu_image::head(files, path) {
        return gpu_image::stated_size(&head);
    }
    let mut source = ImageSource::opened(opened.file);
    if source.begins_with(open_exr::MAGIC) {
        return Some(ExrFile::open(source).ok()?.size());
    }
    let reader = ImageReader::new(source);
    reader.with_guessed_format().ok()?.into_dimensions().ok()
}

/// Width and height as the head of a PNG, GIF or QOI file states them.
fn header_size(bytes: &[u8]) -> Option<(u32, u32)> {
    let wide = |at: usize| {
        bytes
            .get(at..)?
            .first_chunk()
            .map(|b| u32::from_be_bytes(*b))
    };
    let short = |at: usize| {
        bytes
            .get(at..)?
            .first_chunk()
            .map(|b| u16::from_le_bytes(*b))
    };
    if bytes.starts_with(b"\x89PNG\r\n\x1a\n") {
        Some((wide(16)?, wide(20)?))
    } else if bytes.starts_with(b"qoif") {
        Some((wide(4)?, wide(8)?))
    } else if bytes.starts_with(b"GIF8") {
        Some((short(6)?.into(), short(8)?.into()))
    } else {
        None
    }
}

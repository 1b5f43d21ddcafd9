//! Images in the containers of GPUs, DDS and KTX2: block-compressed ones stay compressed, others are decoded.
//!
//! Colours are sRGB codes or numbers as the use of a map says, as for every image: most files state neither or state it wrongly.

mod compress;
mod dds_file;
mod ktx2_file;

use std::borrow::Cow;
use std::io::Read;
use std::path::Path;

use image::{DynamicImage, ImageBuffer, Rgb, Rgba};
use texmap_sample::{Alpha, BlockFormat, BlockImage, ColorSpace, Origin, SampleError, Texture2d};

use crate::files::{FileSource, MAX_TEXT};
use crate::image_io::ask_for_texels;
use crate::{IoError, SourceLocation};

pub use compress::{Compression, CompressionQuality, compress, compress_texture};

/// A file of one surface, whose first level has `size`.
struct GpuImage<'a> {
    size: (u32, u32),
    content: Content<'a>,
    /// Rows from bottom to top.
    bottom_up: bool,
}

enum Content<'a> {
    Blocks {
        format: BlockFormat,
        alpha: Alpha,
        /// Largest first.
        levels: Vec<Cow<'a, [u8]>>,
    },
    Pixels(DynamicImage),
}

/// True for the first bytes of a DDS or KTX2 file.
pub(crate) fn is_one(bytes: &[u8]) -> bool {
    bytes.starts_with(dds_file::MAGIC) || bytes.starts_with(ktx2_file::MAGIC)
}

/// Width and height that such a file states.
pub(crate) fn stated_size(bytes: &[u8]) -> Option<(u32, u32)> {
    if bytes.starts_with(dds_file::MAGIC) {
        return dds_file::stated_size(bytes);
    }
    let side = |at: usize| Some(u32::from_le_bytes(*bytes.get(at..)?.first_chunk()?));
    Some((side(20)?, side(24)?.max(1)))
}

/// The first bytes of such a file; `None` of any other.
pub(crate) fn head(files: &FileSource, path: &Path) -> Option<Vec<u8>> {
    let opened = files.open(path, None, MAX_TEXT).ok()?;
    let mut head = Vec::new();
    opened.file.take(32).read_to_end(&mut head).ok()?;
    is_one(&head).then_some(head)
}

/// A source of bytes that is one of these files, and the way to its errors.
pub(crate) struct GpuFile<'a> {
    pub(crate) files: &'a FileSource,
    pub(crate) path: &'a Path,
    pub(crate) named_by: Option<&'a SourceLocation>,
    pub(crate) bytes: &'a [u8],
}

impl GpuFile<'_> {
    /// The image unpacked: 8 bits a channel, those of floats and of BC4 and BC5 more. `fits` is asked before anything is decoded.
    pub(crate) fn decode(
        &self,
        fits: &dyn Fn((u32, u32)) -> Result<(), IoError>,
    ) -> Result<DynamicImage, IoError> {
        let image = self.open(fits)?;
        let decoded = match &image.content {
            Content::Blocks { .. } => {
                ask_for_texels(self.files, self.path, self.named_by, image.size, 8)?;
                let texture = self.of_blocks(&image, ColorSpace::Linear, Some(Alpha::Data))?;
                unpacked(&texture)
            }
            Content::Pixels(pixels) => pixels.clone(),
        };
        Ok(match image.bottom_up {
            true => decoded.flipv(),
            false => decoded,
        })
    }

    /// The texture of a block-compressed image with the levels of its file; `None` of any other.
    pub(crate) fn texture(
        &self,
        color: ColorSpace,
        fits: &dyn Fn((u32, u32)) -> Result<(), IoError>,
    ) -> Result<Option<Texture2d<'static>>, IoError> {
        let image = self.open(fits)?;
        match &image.content {
            Content::Blocks { .. } if !image.bottom_up => {
                self.of_blocks(&image, color, None).map(Some)
            }
            _ => Ok(None),
        }
    }

    fn open(
        &self,
        fits: &dyn Fn((u32, u32)) -> Result<(), IoError>,
    ) -> Result<GpuImage<'_>, IoError> {
        if let Some(size) = stated_size(self.bytes) {
            fits(size)?;
            // Floats at most; blocks are of the size of their file.
            ask_for_texels(self.files, self.path, self.named_by, size, 1)?;
        }
        let opened = match self.bytes.starts_with(dds_file::MAGIC) {
            true => dds_file::open(self.bytes),
            false => ktx2_file::open(self.bytes),
        };
        opened.map_err(|problem| self.broken(problem))
    }

    fn of_blocks(
        &self,
        image: &GpuImage<'_>,
        color: ColorSpace,
        alpha: Option<Alpha>,
    ) -> Result<Texture2d<'static>, IoError> {
        let Content::Blocks {
            format,
            alpha: stated,
            levels,
        } = &image.content
        else {
            return Err(self.broken("no blocks".into()));
        };
        let levels: Vec<&[u8]> = levels.iter().map(AsRef::as_ref).collect();
        Texture2d::from_blocks(&BlockImage {
            width: image.size.0,
            height: image.size.1,
            format: *format,
            levels: &levels,
            color,
            alpha: alpha.unwrap_or(*stated),
            origin: Origin::TopLeft,
        })
        .map_err(|e: SampleError| self.broken(e.to_string()))
    }

    fn broken(&self, problem: String) -> IoError {
        IoError::BrokenImage {
            path: self.path.to_path_buf(),
            named_by: self.named_by.cloned(),
            problem,
        }
    }
}

/// Codes of level 0 of a texture of numbers.
fn unpacked(texture: &Texture2d<'_>) -> DynamicImage {
    let (width, height) = (texture.width(), texture.height());
    let code = |x: u32, y: u32, most: f32| {
        let texel = texture.texel(0, x, y).unwrap_or_default();
        texel.map(|c| c * most + 0.5)
    };
    match texture.block_format() {
        Some(BlockFormat::Bc4 | BlockFormat::Bc5) => ImageBuffer::from_fn(width, height, |x, y| {
            let [r, g, b, _] = code(x, y, 65535.0);
            Rgb([r as u16, g as u16, b as u16])
        })
        .into(),
        _ => ImageBuffer::from_fn(width, height, |x, y| {
            Rgba(code(x, y, 255.0).map(|c| c as u8))
        })
        .into(),
    }
}

/// The slices of a chain whose levels stand one after the other, as many as a chain of this size has.
fn levels_of(
    format: BlockFormat,
    (width, height): (u32, u32),
    count: u32,
    mut bytes: &[u8],
) -> Result<Vec<Cow<'_, [u8]>>, String> {
    // More levels than halving gives are left out: some programs count on.
    let most = width.max(height).max(1).ilog2() + 1;
    let mut levels = Vec::new();
    for k in 0..count.clamp(1, most) {
        let size = format.level_bytes((width >> k).max(1), (height >> k).max(1));
        let Some((level, rest)) = bytes.split_at_checked(size) else {
            return Err(format!(
                "level {k} has {} bytes, {size} are needed",
                bytes.len()
            ));
        };
        levels.push(Cow::Borrowed(level));
        bytes = rest;
    }
    Ok(levels)
}

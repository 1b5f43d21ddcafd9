//! Images to blocks, by the encoder of the crate `dds`.

use std::io::Write;
use std::path::Path;

use dds::header::Header;
use dds::{ColorFormat, Encoder, Format, ImageView, Size};
use texmap_sample::{BlockFormat, ColorSpace, Texture2d};

use super::GpuFile;
use crate::{FileSource, IoError, PixelCode};

/// The effort of the encoder. Times grow tenfold from one to the next.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CompressionQuality {
    /// For looking at.
    Fast,
    /// For most uses.
    #[default]
    Normal,
    /// Within a few tenths of a decibel of the best.
    High,
}

/// The work of [`compress`].
#[derive(Clone, Copy, Debug)]
pub struct Compression {
    /// Layout of the blocks.
    pub format: BlockFormat,
    /// Effort.
    pub quality: CompressionQuality,
    /// Encoding of the codes that are compressed, that of the texture's colours as they shall be read.
    pub color: ColorSpace,
}

/// Writes the levels of a texture as a DDS file of blocks, which [`read_image`](crate::image_io::read_image) and scenes read.
///
/// Blocks are chosen by arithmetic of floats whose order the processor may choose: the file may differ between machines, pictures of one
/// file do not. One channel (BC4) is red, two (BC5) are red and green.
///
/// # Errors
/// Of `out`, and of the encoder.
pub fn compress(
    texture: &Texture2d<'_>,
    compression: &Compression,
    out: &mut dyn Write,
) -> std::io::Result<()> {
    let format = match compression.format {
        BlockFormat::Bc1 | BlockFormat::Bc1Opaque => Format::BC1_UNORM,
        BlockFormat::Bc2 => Format::BC2_UNORM,
        BlockFormat::Bc3 => Format::BC3_UNORM,
        BlockFormat::Bc4 => Format::BC4_UNORM,
        BlockFormat::Bc5 => Format::BC5_UNORM,
        _ => Format::BC7_UNORM,
    };
    let header = Header::new_image(texture.width(), texture.height(), format)
        .with_mipmap_count(texture.levels());
    let failed = |e: dds::EncodingError| std::io::Error::other(e.to_string());
    let mut encoder = Encoder::new(out, format, &header).map_err(failed)?;
    encoder.encoding.quality = match compression.quality {
        CompressionQuality::Fast => dds::CompressionQuality::Fast,
        CompressionQuality::Normal => dds::CompressionQuality::Normal,
        CompressionQuality::High => dds::CompressionQuality::High,
    };
    for level in 0..texture.levels() {
        let Some((width, height)) = texture.level_size(level) else {
            break;
        };
        let mut codes = level_codes(texture, level, compression.color);
        if compression.format == BlockFormat::Bc4 {
            // The encoder takes the mean of the three.
            for [r, g, b, a] in codes.as_chunks_mut::<4>().0 {
                (*g, *b, *a) = (*r, *r, 255);
            }
        }
        let size = Size::new(width, height);
        let view = ImageView::new(&codes, size, ColorFormat::RGBA_U8)
            .ok_or_else(|| std::io::Error::other("a level of another size"))?;
        encoder.write_surface(view).map_err(failed)?;
    }
    encoder.finish().map_err(failed)
}

/// A texture as the blocks that [`compress`] writes, without a file.
///
/// # Errors
/// [`IoError::BrokenImage`] for what the encoder refuses.
pub fn compress_texture(
    texture: &Texture2d<'_>,
    compression: &Compression,
) -> Result<Texture2d<'static>, IoError> {
    let path = Path::new("compressed texture");
    let refused = |problem: String| IoError::BrokenImage {
        path: path.to_path_buf(),
        named_by: None,
        problem,
    };
    let mut bytes = Vec::new();
    compress(texture, compression, &mut bytes).map_err(|e| refused(e.to_string()))?;
    let file = GpuFile {
        files: &FileSource::anywhere(),
        path,
        named_by: None,
        bytes: &bytes,
    };
    let blocks = file.texture(compression.color, &|_| Ok(()))?;
    blocks.ok_or_else(|| refused("no blocks".into()))
}

/// Straight RGBA codes of a level.
fn level_codes(texture: &Texture2d<'_>, level: u32, color: ColorSpace) -> Vec<u8> {
    let (width, height) = texture.level_size(level).unwrap_or_default();
    let code = PixelCode::Png8(color);
    let mut codes = vec![0; 4 * width as usize * height as usize];
    for (y, row) in (0..height).zip(codes.chunks_exact_mut(4 * width.max(1) as usize)) {
        let texels = (0..width).filter_map(|x| texture.texel(level, x, y));
        code.encode(&texels.collect::<Vec<_>>(), row);
    }
    codes
}

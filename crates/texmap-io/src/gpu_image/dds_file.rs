//! DDS: DirectDraw surfaces, read by the crate `dds`.

use std::io::Cursor;

use dds::header::{AlphaMode, Header, ParseOptions};
use dds::{
    Channels, ColorFormat, DataLayout, DataRegion, Decoder, Format, ImageViewMut, Precision,
};
use image::{DynamicImage, ImageBuffer};
use texmap_sample::{Alpha, BlockFormat};

use super::{Content, GpuImage, levels_of};

pub(super) const MAGIC: &[u8] = b"DDS ";

pub(super) fn stated_size(bytes: &[u8]) -> Option<(u32, u32)> {
    let side = |at: usize| Some(u32::from_le_bytes(*bytes.get(at..)?.first_chunk()?));
    Some((side(16)?, side(12)?))
}

pub(super) fn open(bytes: &[u8]) -> Result<GpuImage<'_>, String> {
    let mut reader = Cursor::new(bytes);
    let header = match Header::read(&mut reader, &ParseOptions::default()) {
        Ok(header) => header,
        Err(_) => {
            // Heads of old programs have wrong numbers; the length of the file tells the right ones.
            reader.set_position(0);
            let options = ParseOptions::new_permissive(Some(bytes.len() as u64));
            Header::read(&mut reader, &options).map_err(|e| e.to_string())?
        }
    };
    let format = Format::from_header(&header).map_err(|e| e.to_string())?;
    let layout = DataLayout::from_header_with(&header, format.into()).map_err(|e| e.to_string())?;
    let Some(texture) = layout.texture() else {
        return Err(several(&layout));
    };
    let size = (texture.main().width(), texture.main().height());
    let stated = match &header {
        Header::Dx10(header) => header.alpha_mode,
        Header::Dx9(_) => AlphaMode::Unknown,
    };
    let premultiplied = stated == AlphaMode::Premultiplied
        || matches!(
            format,
            Format::BC2_UNORM_PREMULTIPLIED_ALPHA | Format::BC3_UNORM_PREMULTIPLIED_ALPHA
        );
    let content = match blocks(format) {
        Some(format) => {
            let start = reader.position() + texture.data_offset();
            let data = usize::try_from(start).ok().and_then(|at| bytes.get(at..));
            let count = u32::from(texture.mipmaps());
            Content::Blocks {
                format,
                alpha: match (stated, premultiplied) {
                    (_, true) => Alpha::Premultiplied,
                    _ => Alpha::Straight,
                },
                levels: levels_of(format, size, count, data.unwrap_or_default())?,
            }
        }
        None if is_refused(format) => {
            return Err(format!(
                "{format:?} is not read: convert it to BC1, BC3, BC4, BC5, BC7 or to no compression"
            ));
        }
        None => Content::Pixels(pixels(reader, &header, format, size)?),
    };
    Ok(GpuImage {
        size,
        content,
        bottom_up: false,
    })
}

fn several(layout: &DataLayout) -> String {
    let what = match layout {
        _ if layout.is_cube_map() => "six faces of a cube",
        DataLayout::Volume(_) => "the slices of a volume",
        _ => "an array of images",
    };
    format!("it holds {what}, and one image is needed: write each to a file of its own")
}

fn blocks(format: Format) -> Option<BlockFormat> {
    Some(match format {
        Format::BC1_UNORM => BlockFormat::Bc1,
        Format::BC2_UNORM | Format::BC2_UNORM_PREMULTIPLIED_ALPHA => BlockFormat::Bc2,
        Format::BC3_UNORM | Format::BC3_UNORM_PREMULTIPLIED_ALPHA => BlockFormat::Bc3,
        Format::BC4_UNORM => BlockFormat::Bc4,
        Format::BC5_UNORM => BlockFormat::Bc5,
        Format::BC7_UNORM => BlockFormat::Bc7,
        _ => return None,
    })
}

/// Signed and other compressed formats, whose meaning a decoded picture would change.
fn is_refused(format: Format) -> bool {
    let name = format!("{format:?}");
    name.starts_with("BC") || name.starts_with("ASTC") || name.contains("SNORM")
}

/// Level 0 of an uncompressed image.
fn pixels(
    reader: Cursor<&[u8]>,
    header: &Header,
    format: Format,
    (width, height): (u32, u32),
) -> Result<DynamicImage, String> {
    let mut decoder =
        Decoder::from_header_with(reader, header.clone(), format).map_err(|e| e.to_string())?;
    let size = decoder.main_size();
    let count = width as usize * height as usize;
    let color = |precision| ColorFormat::new(Channels::Rgba, precision);
    let mut read = |bytes: &mut [u8], precision| {
        let view = ImageViewMut::new(bytes, size, color(precision)).ok_or("a size of zero")?;
        decoder.read_surface(view).map_err(|e| e.to_string())
    };
    let whole = || "a buffer of another size".to_owned();
    match format.precision() {
        Precision::U8 => {
            let mut texels = vec![0_u8; 4 * count];
            read(&mut texels, Precision::U8)?;
            let image = ImageBuffer::from_raw(width, height, texels).ok_or_else(whole)?;
            Ok(DynamicImage::ImageRgba8(image))
        }
        Precision::U16 => {
            let mut bytes = vec![0_u8; 8 * count];
            read(&mut bytes, Precision::U16)?;
            let words = bytes.as_chunks::<2>().0.iter();
            let texels = words.map(|c| u16::from_ne_bytes(*c)).collect();
            let image = ImageBuffer::from_raw(width, height, texels).ok_or_else(whole)?;
            Ok(DynamicImage::ImageRgba16(image))
        }
        Precision::F32 => {
            let mut bytes = vec![0_u8; 16 * count];
            read(&mut bytes, Precision::F32)?;
            let words = bytes.as_chunks::<4>().0.iter();
            let mut texels: Vec<f32> = words.map(|c| f32::from_ne_bytes(*c)).collect();
            premultiply(&mut texels);
            let image = ImageBuffer::from_raw(width, height, texels).ok_or_else(whole)?;
            Ok(DynamicImage::ImageRgba32F(image))
        }
    }
}

/// Floats of images are premultiplied in this crate.
pub(super) fn premultiply(texels: &mut [f32]) {
    for [r, g, b, a] in texels.as_chunks_mut::<4>().0 {
        (*r, *g, *b) = (*r * *a, *g * *a, *b * *a);
    }
}

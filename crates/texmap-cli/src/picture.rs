//! Pictures of 8 bits a channel as files of any format.

use std::path::Path;

use texmap_io::{Lost, PictureFormat, PixelCode, image_io, write_pixels};
use texmap_math::color::srgb8_to_linear;
use texmap_sample::ColorSpace;
use texmap_scene::ColorMode;
use texmap_truth::picture::Picture;

use crate::failure::Failure;
use crate::formats;

/// Writes a picture of sRGB colours with straight alpha.
pub(crate) fn write(
    path: &Path,
    format: PictureFormat,
    picture: &Picture,
) -> Result<Lost, Failure> {
    let size = (picture.width(), picture.height());
    write_rgba8(path, format, ColorMode::Srgb, size, picture.rgba())
}

/// Writes pixels of four bytes with straight alpha. PNG and WebP hold them as they are, HDR and EXR their linear light.
pub(crate) fn write_rgba8(
    path: &Path,
    format: PictureFormat,
    color: ColorMode,
    size: (u32, u32),
    rgba: &[u8],
) -> Result<Lost, Failure> {
    match format {
        PictureFormat::Png => {
            image_io::write_png(path, size.0, size.1, rgba)?;
            Ok(Lost::default())
        }
        PictureFormat::WebP => {
            let code = PixelCode::WebP(ColorSpace::Linear);
            write_pixels(path, code, size, |out| out.write_all(rgba))?;
            Ok(Lost::default())
        }
        _ => {
            let colors = decoded(rgba, color);
            let alpha = colors.iter().any(|color| color[3] < 1.0);
            let code = formats::pixel_code(format, 8, color, alpha);
            write_colors(path, code, size, &colors)
        }
    }
}

/// Writes linear, premultiplied colours, row by row.
pub(crate) fn write_colors(
    path: &Path,
    code: PixelCode,
    size: (u32, u32),
    colors: &[[f32; 4]],
) -> Result<Lost, Failure> {
    let mut lost = Lost::default();
    write_pixels(path, code, size, |out| {
        let mut row = vec![0; code.bytes() * size.0 as usize];
        colors
            .chunks(size.0.max(1) as usize)
            .try_for_each(|colors| {
                lost += code.encode(colors, &mut row);
                out.write_all(&row)
            })
    })?;
    Ok(lost)
}

/// Linear, premultiplied colours of bytes.
fn decoded(rgba: &[u8], mode: ColorMode) -> Vec<[f32; 4]> {
    let pixels = rgba.as_chunks::<4>().0.iter();
    pixels
        .map(|[r, g, b, a]| {
            let alpha = f32::from(*a) / 255.0;
            let [r, g, b] = [*r, *g, *b].map(|c| {
                alpha
                    * match mode {
                        ColorMode::Srgb => srgb8_to_linear(c),
                        ColorMode::Raw => f32::from(c) / 255.0,
                    }
            });
            [r, g, b, alpha]
        })
        .collect()
}

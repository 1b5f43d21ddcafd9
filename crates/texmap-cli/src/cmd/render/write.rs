//! A finished frame as a file, in the format of the file's name.

use std::path::Path;

use texmap_io::npy::Values;
use texmap_io::{ExrLayer, Lost, PictureFormat, PixelCode, image_io, write_exr, write_pixels};
use texmap_math::color::srgb8_to_linear;
use texmap_render::{Aov, AovData, Frame};
use texmap_sample::ColorSpace;
use texmap_scene::ColorMode;

use crate::failure::Failure;
use crate::formats;

/// A format, the bits of a channel, and the encoding of colours.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Store {
    pub(crate) format: PictureFormat,
    /// 8 or 16; floats have 32.
    pub(crate) bits: u32,
    pub(crate) color: ColorMode,
}

impl Store {
    /// True if the frame must have [`Aov::Color`], as eight bits do not hold the values of the file.
    pub(crate) fn reads_light(self) -> bool {
        matches!(self.format, PictureFormat::Hdr | PictureFormat::Exr) || self.bits == 16
    }

    /// True if arrays lie in the file and not beside it.
    pub(crate) fn holds_arrays(self) -> bool {
        self.format == PictureFormat::Exr
    }

    /// Writes a frame; `arrays` are the names of its first arrays, which an EXR holds.
    pub(crate) fn write(
        self,
        path: &Path,
        frame: &Frame,
        arrays: &[&str],
    ) -> Result<Lost, Failure> {
        let size = (frame.width, frame.height);
        if self.format == PictureFormat::Png && self.bits == 8 {
            image_io::write_png(path, frame.width, frame.height, &frame.rgba)?;
            return Ok(Lost::default());
        }
        if self.format == PictureFormat::WebP {
            let code = PixelCode::WebP(ColorSpace::Linear);
            write_pixels(path, code, size, |out| out.write_all(&frame.rgba))?;
            return Ok(Lost::default());
        }
        let colors = match self.reads_light() {
            true => linear(frame)?,
            false => decoded(frame, self.color),
        };
        let alpha = colors.iter().any(|color| color[3] < 1.0);
        if self.format == PictureFormat::Exr {
            let layers = arrays.iter().zip(&frame.aovs);
            let layers: Vec<ExrLayer<'_>> = layers
                .map(|(name, (_, channels, data))| ExrLayer {
                    name,
                    channels: *channels,
                    values: values(data),
                })
                .collect();
            write_exr(path, size, &colors, alpha, &layers)?;
            return Ok(Lost::default());
        }
        let code = formats::pixel_code(self.format, self.bits, self.color, alpha);
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
        // A picture of whole numbers always cuts light above white off, as the 8-bit PNG does.
        if self.format != PictureFormat::Hdr {
            (lost.above, lost.below) = (0, 0);
        }
        Ok(lost)
    }
}

/// The values of an array.
pub(crate) fn values(data: &AovData) -> Values<'_> {
    match data {
        AovData::F32(v) => Values::F32(v),
        AovData::U32(v) => Values::U32(v),
    }
}

fn linear(frame: &Frame) -> Result<Vec<[f32; 4]>, Failure> {
    let color = frame.aovs.iter().find(|(aov, ..)| *aov == Aov::Color);
    match color {
        Some((_, _, AovData::F32(values))) => Ok(values.as_chunks::<4>().0.to_vec()),
        _ => Err(Failure::internal("a frame without its light")),
    }
}

/// Linear, premultiplied colours of the bytes of a frame.
fn decoded(frame: &Frame, mode: ColorMode) -> Vec<[f32; 4]> {
    let pixels = frame.rgba.as_chunks::<4>().0.iter();
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

//! A finished frame as a file, in the format of the file's name.

use std::path::Path;

use texmap_io::npy::Values;
use texmap_io::{ExrLayer, Lost, PictureFormat, write_exr};
use texmap_render::{Aov, AovData, Frame};
use texmap_scene::ColorMode;

use crate::failure::Failure;
use crate::formats;
use crate::picture;

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
        if !self.reads_light() {
            return picture::write_rgba8(path, self.format, self.color, size, &frame.rgba);
        }
        let colors = linear(frame)?;
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
        let mut lost = picture::write_colors(path, code, size, &colors)?;
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

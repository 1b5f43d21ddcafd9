//! The colours of an OpenEXR file: red, green and blue of the first part that has them, or its luminance.

use exr::block::reader::{ChunksReader as _, Reader};
use exr::block::{UncompressedBlock, chunk::Chunk};
use exr::meta::attribute::{ChannelList, SampleType};
use exr::meta::header::Header;
use exr::prelude::f16;
use image::{DynamicImage, Rgb32FImage, Rgba32FImage};
use texmap_math::parallel;

use super::header::fault;
use crate::image_io::ImageSource;

/// The first bytes of every OpenEXR file.
pub(crate) const MAGIC: &[u8] = b"\x76\x2f\x31\x01";

/// Bytes of the blocks that are decompressed side by side, as long as one alone does not have more: as many are held.
const BYTES_AT_ONCE: usize = 16 << 20;

/// A file of which the headers are read.
pub(crate) struct ExrFile<'a> {
    reader: Reader<ImageSource<'a>>,
    part: usize,
    channels: Channels,
}

/// The channels that are read, by their number in the part.
struct Channels {
    /// The same one three times for luminance.
    colors: [usize; 3],
    alpha: Option<usize>,
}

impl<'a> ExrFile<'a> {
    /// Reads the headers of a file that begins with [`MAGIC`].
    ///
    /// # Errors
    /// Says why a file cannot be read: a broken header, sizes beyond all pictures, no colours.
    pub(crate) fn open(source: ImageSource<'a>) -> Result<Self, String> {
        let reader = exr::block::read(source, false).map_err(|e| e.to_string())?;
        let headers = reader.headers();
        if let Some(problem) = headers.iter().find_map(fault) {
            return Err(problem);
        }
        let found = headers
            .iter()
            .enumerate()
            .find_map(|(part, header)| Some((part, Channels::of(header)?)));
        let (part, channels) = found.ok_or_else(|| no_colours(headers))?;
        Ok(Self {
            reader,
            part,
            channels,
        })
    }

    fn header(&self) -> &Header {
        &self.reader.headers()[self.part]
    }

    /// Width and height of the display window.
    pub(crate) fn size(&self) -> (u32, u32) {
        let size = self.header().shared_attributes.display_window.size;
        let side = |s: usize| u32::try_from(s).unwrap_or(u32::MAX);
        (side(size.0), side(size.1))
    }

    /// Column and row of the first pixel with data, in the display window.
    fn offset(&self) -> (i64, i64) {
        let data = self.header().own_attributes.layer_position;
        let display = self.header().shared_attributes.display_window.position;
        let between = |a: i32, b: i32| i64::from(a) - i64::from(b);
        (between(data.0, display.0), between(data.1, display.1))
    }

    /// Floats of a pixel: 3 or 4.
    pub(crate) fn floats(&self) -> usize {
        3 + usize::from(self.channels.alpha.is_some())
    }

    /// The pixels of the display window; those without data are zero.
    ///
    /// # Errors
    /// Says what is wrong with a block.
    pub(crate) fn decode(self) -> Result<DynamicImage, String> {
        let (width, height) = self.size();
        let mut pixels = Pixels {
            values: vec![0.0; width as usize * height as usize * self.floats()],
            width: width as usize,
            floats: self.floats(),
            offset: self.offset(),
        };
        let part = self.part;
        let list = self.header().channels.clone();
        let block = self.header().max_block_byte_size().max(1);
        let at_once = (BYTES_AT_ONCE / block).clamp(1, 64);
        let chunks = self
            .reader
            .filter_chunks(false, |_, _, block| {
                block.layer == part && block.level.0 == 0 && block.level.1 == 0
            })
            .map_err(|e| e.to_string())?;
        let meta = chunks.meta_data().clone();
        let mut chunks = chunks.map(|chunk| chunk.map_err(|e| e.to_string()));
        loop {
            let batch: Vec<Chunk> = chunks.by_ref().take(at_once).collect::<Result<_, _>>()?;
            if batch.is_empty() {
                break;
            }
            let blocks = parallel::map(batch.into_iter(), |chunk| {
                UncompressedBlock::decompress_chunk(chunk, &meta, false).map_err(|e| e.to_string())
            });
            for block in blocks {
                pixels.take(&block?, &list, &self.channels);
            }
        }
        let image = match self.channels.alpha {
            Some(_) => Rgba32FImage::from_raw(width, height, pixels.values).map(Into::into),
            None => Rgb32FImage::from_raw(width, height, pixels.values).map(Into::into),
        };
        image.ok_or_else(|| "a size of zero".to_owned())
    }
}

impl Channels {
    /// `R`, `G` and `B` with `A`, else those of the first layer that has them (`view.R`), else the luminance `Y`.
    fn of(header: &Header) -> Option<Self> {
        let list = &header.channels.list;
        if header.deep || list.iter().any(|c| (c.sampling.0, c.sampling.1) != (1, 1)) {
            return None;
        }
        let named = |layer: &str, channel: &str| {
            let name = format!("{layer}{channel}");
            list.iter().position(|c| c.name.eq(&name))
        };
        let of_layer = |layer: &str, names: [&str; 3]| {
            let [r, g, b] = names.map(|name| named(layer, name));
            let alpha = named(layer, "A");
            let colors = [r?, g?, b?];
            Some(Self { colors, alpha })
        };
        let rgb = ["R", "G", "B"];
        let layers = list.iter().filter_map(|channel| {
            let name = channel.name.to_string();
            name.ends_with(".R")
                .then(|| name[..name.len() - 1].to_owned())
        });
        of_layer("", rgb)
            .or_else(|| layers.into_iter().find_map(|layer| of_layer(&layer, rgb)))
            .or_else(|| of_layer("", ["Y"; 3]))
    }
}

/// The pixels of the display window, as they are filled.
struct Pixels {
    values: Vec<f32>,
    width: usize,
    floats: usize,
    /// Column and row of the first pixel with data.
    offset: (i64, i64),
}

impl Pixels {
    /// Takes what lies within the window of the lines of a block.
    fn take(&mut self, block: &UncompressedBlock, list: &ChannelList, channels: &Channels) {
        for line in block.lines(list) {
            let at = line.location;
            let row = at.position.1 as i64 + self.offset.1;
            let mut rows = self.values.chunks_exact_mut(self.width * self.floats);
            let Some(row) = usize::try_from(row).ok().and_then(|row| rows.nth(row)) else {
                continue;
            };
            let left = at.position.0 as i64 + self.offset.0;
            // Samples left of the window are cut off.
            let cut = usize::try_from(-left).unwrap_or(0);
            let first = usize::try_from(left).unwrap_or(0);
            let [r, g, b] = channels.colors;
            let slots = [Some(r), Some(g), Some(b), channels.alpha];
            for (slot, channel) in slots.into_iter().enumerate() {
                if channel != Some(at.channel) {
                    continue;
                }
                let to = row.chunks_exact_mut(self.floats).skip(first);
                let to = to.map(|pixel| &mut pixel[slot]);
                let kind = list.list[at.channel].sample_type;
                fill(to, line.value, cut, kind);
            }
        }
    }
}

/// Fills pixels with the samples of a line after the first `cut`.
fn fill<'a>(to: impl Iterator<Item = &'a mut f32>, line: &[u8], cut: usize, kind: SampleType) {
    let halves = line.as_chunks().0.iter().skip(cut);
    let words = line.as_chunks().0.iter().skip(cut);
    match kind {
        SampleType::F16 => to
            .zip(halves)
            .for_each(|(to, b)| *to = f16::from_ne_bytes(*b).to_f32()),
        SampleType::F32 => to
            .zip(words)
            .for_each(|(to, b)| *to = f32::from_ne_bytes(*b)),
        SampleType::U32 => to
            .zip(words)
            .for_each(|(to, b)| *to = u32::from_ne_bytes(*b) as f32),
    }
}

/// The message of a file without colours.
fn no_colours(headers: &[Header]) -> String {
    let deep = headers.iter().all(|header| header.deep);
    let channels = headers.iter().flat_map(|header| &header.channels.list);
    if deep {
        return "its pixels are deep; flatten them".to_owned();
    }
    let sampled = channels
        .clone()
        .any(|c| (c.sampling.0, c.sampling.1) != (1, 1));
    let names: Vec<String> = channels.take(12).map(|c| c.name.to_string()).collect();
    let names = names.join(", ");
    if sampled {
        format!(
            "its channels ({names}) have fewer pixels than the picture; write R, G and B of full size"
        )
    } else {
        format!("it has no channels R, G and B, and no Y, but {names}")
    }
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use exr::prelude::{
        AnyChannel, AnyChannels, Encoding, FlatSamples, Image, ImageAttributes, IntegerBounds,
        Layer, LayerAttributes, Vec2, WritableImage as _,
    };

    use super::*;

    /// A file of 3 x 2 data from column 1, row -1 of a display window of 3 x 2; a channel's values are its number times 10, plus 0 to 5.
    fn file(channels: &[&str], encoding: Encoding) -> Vec<u8> {
        let channel = |(k, name): (usize, &&str)| {
            let values = (0..6).map(|i| (10 * k + i) as f32);
            let samples = match k % 3 {
                0 => FlatSamples::F32(values.collect()),
                1 => FlatSamples::F16(values.map(f16::from_f32).collect()),
                _ => FlatSamples::U32(values.map(|v| v as u32).collect()),
            };
            AnyChannel::new(*name, samples)
        };
        let list = channels.iter().enumerate().map(channel).collect();
        let attributes = LayerAttributes {
            layer_position: Vec2(6, 4),
            ..LayerAttributes::default()
        };
        let layer = Layer::new((3, 2), attributes, encoding, AnyChannels::sort(list));
        let window = IntegerBounds::new((5, 5), (3, 2));
        let image = Image::empty(ImageAttributes::new(window)).with_layer(layer);
        let mut file = Cursor::new(Vec::new());
        image.write().non_parallel().to_buffered(&mut file).unwrap();
        file.into_inner()
    }

    fn decoded(bytes: &[u8]) -> Result<DynamicImage, String> {
        ExrFile::open(ImageSource::bytes(bytes))?.decode()
    }

    #[test]
    fn pixels_without_data_are_zero_and_data_beyond_the_window_is_left_out() {
        for encoding in [
            Encoding::UNCOMPRESSED,
            Encoding::SMALL_LOSSLESS,
            Encoding::FAST_LOSSLESS,
        ] {
            let image = decoded(&file(&["R", "G", "B", "A"], encoding)).unwrap();
            let image = image.as_rgba32f().unwrap();
            assert_eq!(image.dimensions(), (3, 2));
            // The second row of the data is the first of the window, one column to the right.
            let expected = [[0.0; 4], [3.0, 13.0, 23.0, 33.0], [4.0, 14.0, 24.0, 34.0]];
            for x in 0..3 {
                assert_eq!(image.get_pixel(x, 0).0, expected[x as usize]);
                assert_eq!(image.get_pixel(x, 1).0, [0.0; 4]);
            }
        }
    }

    #[test]
    fn layers_and_luminance_are_colours_where_there_are_no_others() {
        let color = |names: &[&str]| {
            let image = decoded(&file(names, Encoding::SMALL_LOSSLESS)).unwrap();
            image.to_rgba32f().get_pixel(1, 0).0
        };
        assert_eq!(color(&["B", "G", "R"]), [23.0, 13.0, 3.0, 1.0]);
        assert_eq!(color(&["Y"]), [3.0, 3.0, 3.0, 1.0]);
        assert_eq!(color(&["A", "Y"]), [13.0, 13.0, 13.0, 3.0]);
        let names = ["Depth.Z", "view.A", "view.B", "view.G", "view.R"];
        assert_eq!(color(&names), [43.0, 33.0, 23.0, 13.0]);
        // The colours of the picture go before those of its layers.
        assert_eq!(
            color(&["a.R", "a.G", "a.B", "R", "G", "B"])[..3],
            [33.0, 43.0, 53.0]
        );
    }

    #[test]
    fn a_file_without_colours_says_its_channels() {
        let problem = decoded(&file(&["R", "G", "Z"], Encoding::UNCOMPRESSED)).unwrap_err();
        assert_eq!(
            problem,
            "it has no channels R, G and B, and no Y, but G, R, Z"
        );
    }
}

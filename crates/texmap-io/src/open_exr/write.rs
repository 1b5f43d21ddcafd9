//! OpenEXR pictures with arrays beside the colour: one part, a channel for each value.

use std::io::{self, Cursor, Write};
use std::path::Path;

use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, LayerAttributes, WritableImage,
};

use crate::npy::Values;
use crate::{IoError, atomic};

/// An array of a picture: `channels` values a pixel, rows from top to bottom. Its channels are called `NAME.X` and so on in the file, which
/// other programs show as a layer.
#[derive(Debug, Clone, Copy)]
pub struct ExrLayer<'a> {
    /// Without a dot.
    pub name: &'a str,
    /// 1 to 4.
    pub channels: usize,
    /// As many as pixels times channels. Whole numbers stay whole numbers.
    pub values: Values<'a>,
}

/// Names of the channels of a colour.
const COLORS: [&str; 4] = ["R", "G", "B", "A"];

/// Names of the channels of a layer by their number; a single one is a depth.
const NAMES: [&[&str]; 4] = [&["Z"], &["U", "V"], &["X", "Y", "Z"], &COLORS];

/// Writes linear, premultiplied colours and layers as OpenEXR, 32 bits a value, whole or not at all. `alpha` adds the fourth channel.
///
/// # Errors
/// [`IoError::Write`], also when values are missing or left over or a side is zero.
pub fn write_exr(
    path: &Path,
    (width, height): (u32, u32),
    colors: &[[f32; 4]],
    alpha: bool,
    layers: &[ExrLayer<'_>],
) -> Result<(), IoError> {
    atomic::write(path, |out| {
        let pixels = width as usize * height as usize;
        let wrong = |what: &str| {
            let problem = format!("{what} of {width} x {height} pixels");
            io::Error::new(io::ErrorKind::InvalidInput, problem)
        };
        if pixels == 0 || colors.len() != pixels {
            return Err(wrong("not the colours"));
        }
        let mut channels = Vec::new();
        for (k, name) in COLORS.into_iter().enumerate().take(3 + usize::from(alpha)) {
            let values = colors.iter().map(|color| color[k]).collect();
            channels.push(AnyChannel::new(name, FlatSamples::F32(values)));
        }
        for layer in layers {
            let names = layer.channels.checked_sub(1).and_then(|n| NAMES.get(n));
            let names = names.ok_or_else(|| wrong("a layer of no or too many channels"))?;
            for (k, name) in names.iter().enumerate() {
                let samples = match layer.values {
                    Values::F32(v) if v.len() == pixels * layer.channels => FlatSamples::F32(
                        v.iter().skip(k).step_by(layer.channels).copied().collect(),
                    ),
                    Values::U32(v) if v.len() == pixels * layer.channels => FlatSamples::U32(
                        v.iter().skip(k).step_by(layer.channels).copied().collect(),
                    ),
                    _ => return Err(wrong("not the values of a layer")),
                };
                let name = format!("{}.{name}", layer.name);
                channels.push(AnyChannel::new(name.as_str(), samples));
            }
        }
        encode(out, (width, height), channels, Encoding::SMALL_LOSSLESS)
    })
}

/// Writes pixels of 3 or 4 floats, in the byte order of this machine, with the fast compression. `pixels` has the bytes of all pixels.
pub(crate) fn write_floats(
    out: &mut dyn Write,
    size: (u32, u32),
    pixels: &[u8],
    channels: usize,
) -> io::Result<()> {
    let (values, _) = pixels.as_chunks::<4>();
    let channel = |(k, name): (usize, &'static str)| {
        let values = values.iter().skip(k).step_by(channels);
        let values = values.map(|bytes| f32::from_ne_bytes(*bytes)).collect();
        AnyChannel::new(name, FlatSamples::F32(values))
    };
    let channels = COLORS.into_iter().enumerate().take(channels);
    let channels = channels.map(channel).collect();
    encode(out, size, channels, Encoding::FAST_LOSSLESS)
}

/// The encoder is compiled once.
fn encode(
    out: &mut dyn Write,
    (width, height): (u32, u32),
    channels: Vec<AnyChannel<FlatSamples>>,
    encoding: Encoding,
) -> io::Result<()> {
    let layer = Layer::new(
        (width as usize, height as usize),
        LayerAttributes::default(),
        encoding,
        AnyChannels::sort(channels.into()),
    );
    // The encoder seeks.
    let mut file = Cursor::new(Vec::new());
    let image = Image::from_layer(layer);
    let written = image.write().non_parallel().to_buffered(&mut file);
    written.map_err(io::Error::other)?;
    out.write_all(file.get_ref())
}

#[cfg(test)]
mod tests {
    use super::*;
    use exr::prelude::{ReadChannels, ReadLayers, read};

    #[test]
    fn colours_and_layers_come_back_as_they_were() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.exr");
        let colors: Vec<[f32; 4]> = (0..6).map(|i| [i as f32, -0.5, 7.25, 0.5]).collect();
        let normal: Vec<f32> = (0..18).map(|i| i as f32 * 0.1).collect();
        let ids: Vec<u32> = (0..6).map(|i| u32::MAX - i).collect();
        let layers = [
            ExrLayer {
                name: "normal",
                channels: 3,
                values: Values::F32(&normal),
            },
            ExrLayer {
                name: "face",
                channels: 1,
                values: Values::U32(&ids),
            },
        ];
        write_exr(&path, (3, 2), &colors, true, &layers).unwrap();
        let image = read()
            .no_deep_data()
            .largest_resolution_level()
            .all_channels()
            .first_valid_layer()
            .all_attributes()
            .from_file(&path)
            .unwrap();
        let channel = |name: &str| {
            let list = &image.layer_data.channel_data.list;
            let found = list.iter().find(|c| c.name.eq(name));
            &found.unwrap_or_else(|| panic!("{name}")).sample_data
        };
        assert_eq!(image.layer_data.channel_data.list.len(), 8);
        let FlatSamples::F32(red) = channel("R") else {
            panic!("floats")
        };
        assert_eq!(red[..], [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]);
        let FlatSamples::F32(y) = channel("normal.Y") else {
            panic!("floats")
        };
        assert_eq!(y[1], normal[4]);
        let FlatSamples::U32(face) = channel("face.Z") else {
            panic!("whole numbers")
        };
        assert_eq!(*face, ids);
        // The picture is one that other readers take.
        let (texture, bits) =
            crate::image_io::read_texture(&path, texmap_sample::ColorSpace::Srgb).unwrap();
        assert_eq!((bits, texture.texel(0, 2, 1).unwrap()), (32, colors[5]));
    }

    #[test]
    fn wrong_counts_leave_no_file() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.exr");
        let layer = |channels, values| ExrLayer {
            name: "x",
            channels,
            values,
        };
        let colors = [[0.0; 4]; 2];
        for (size, layers) in [
            ((3, 1), vec![]),
            ((0, 2), vec![]),
            ((2, 1), vec![layer(2, Values::F32(&[0.0; 3]))]),
            ((2, 1), vec![layer(5, Values::F32(&[0.0; 10]))]),
            ((2, 1), vec![layer(0, Values::F32(&[]))]),
        ] {
            assert_eq!(
                write_exr(&path, size, &colors, false, &layers)
                    .unwrap_err()
                    .code(),
                "write-failed"
            );
            assert!(!path.exists());
        }
    }
}

//! `texmap compress`: an image as the blocks that a GPU and texmap sample.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use serde::Serialize;
use texmap_io::{Compression, CompressionQuality, atomic, compress, image_io};
use texmap_sample::{BlockFormat, ColorSpace, Texture2d};
use texmap_scene::ColorMode;

use crate::cmd::written::one_stdout;
use crate::failure::{self, Exit, Failure, say};
use crate::levels::ask_for_levels;
use crate::output::{Destination, Stage, distinct};
use crate::{formats, values};

/// Compress an image to blocks with its mip levels, and tell the error
///
/// Scenes and models read the file as any other texture and sample it without unpacking: half a byte (bc1, bc4) or a byte a texel in memory.
#[derive(Args, Debug)]
#[command(after_help = "A photo:       texmap compress brick.png -o brick.dds\n\
                  A normal map:  texmap compress normals.png -o normals.dds --format bc5\n\
                  A height map:  texmap compress height.png -o height.dds --format bc4 --color raw")]
pub(crate) struct CompressArgs {
    /// The image: any that a scene reads
    image: PathBuf,
    /// The file to write, .dds
    #[arg(short, long, value_name = "OUT.dds")]
    output: PathBuf,
    /// bc1: colour and holes, 4 bits a texel; bc3: colour and alpha, 8; bc4: one channel, 4; bc5: x and y of normals, 8; bc7: colour and alpha, 8
    #[arg(long, value_name = "FORMAT", default_value = "bc7")]
    format: Format,
    /// Effort of the search
    #[arg(long, value_name = "QUALITY", default_value = "normal")]
    quality: Quality,
    /// srgb averages mip levels in linear light; raw takes codes as numbers, as bc4 and bc5 always do
    #[arg(long, value_name = "SPACE", value_parser = values::color, default_value = "srgb")]
    color: ColorMode,
    /// Write level 0 alone
    #[arg(long)]
    no_mips: bool,
    /// Print a report as JSON to standard output
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Format {
    Bc1,
    Bc3,
    Bc4,
    Bc5,
    Bc7,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Quality {
    Fast,
    Normal,
    High,
}

/// The report.
#[derive(Debug, Serialize)]
struct Compressed {
    texmap: &'static str,
    verb: &'static str,
    exit: u8,
    file: String,
    format: String,
    size: [u32; 2],
    levels: u32,
    bytes: u64,
    /// Root mean square of the difference of level 0 in codes of 8 bits, over the channels that the format keeps.
    rmse: f64,
    /// In decibels; absent where nothing differs.
    psnr: Option<f64>,
    largest: f64,
}

pub(crate) fn run(args: &CompressArgs) -> Result<Exit, Failure> {
    formats::ending("-o", &args.output, &["dds"])?;
    one_stdout(args.json, &args.output)?;
    distinct([&args.output], [&args.image])?;
    let format = match args.format {
        Format::Bc1 => BlockFormat::Bc1,
        Format::Bc3 => BlockFormat::Bc3,
        Format::Bc4 => BlockFormat::Bc4,
        Format::Bc5 => BlockFormat::Bc5,
        Format::Bc7 => BlockFormat::Bc7,
    };
    let color = match (args.format, args.color) {
        (Format::Bc4 | Format::Bc5, _) | (_, ColorMode::Raw) => ColorSpace::Linear,
        (_, ColorMode::Srgb) => ColorSpace::Srgb,
    };
    let (base, _) = image_io::read_texture(&args.image, color)?;
    if !args.no_mips {
        ask_for_levels(&base, &args.image)?;
    }
    let texture = match (args.no_mips, args.format) {
        (true, _) => base.clone(),
        // Means of normals are shorter than one.
        (false, Format::Bc5) => base.clone().with_normal_mips(),
        (false, _) => base.clone().with_mips(),
    };
    let compression = Compression {
        format,
        quality: match args.quality {
            Quality::Fast => CompressionQuality::Fast,
            Quality::Normal => CompressionQuality::Normal,
            Quality::High => CompressionQuality::High,
        },
        color,
    };
    let destination = Destination::new(&args.output)?;
    let mut stage = Stage::new(&destination)?;
    let path = stage.add(destination, "dds");
    atomic::write(&path, |out| compress(&texture, &compression, out))?;
    let bytes = std::fs::metadata(&path).map_or(0, |m| m.len());
    let (written, _) = image_io::read_texture(&path, color)?;
    let (rmse, largest) = difference(&base, &written, args.format, color);
    stage.commit()?;
    let psnr = (rmse > 0.0).then(|| 20.0 * (255.0 / rmse).log10());
    say(&format!(
        "{}: {} x {}, {} levels, {bytes} bytes, error {rmse:.3} of 255 in the mean, {largest:.0} at most\n",
        args.output.display(),
        texture.width(),
        texture.height(),
        texture.levels(),
    ));
    if args.json {
        failure::print_json(&Compressed {
            texmap: env!("CARGO_PKG_VERSION"),
            verb: "compress",
            exit: Exit::Done as u8,
            file: args.output.display().to_string(),
            format: format!("{:?}", args.format).to_lowercase(),
            size: [texture.width(), texture.height()],
            levels: texture.levels(),
            bytes,
            rmse,
            psnr,
            largest,
        })?;
    }
    Ok(Exit::Done)
}

/// Root mean square and largest difference of the straight codes of two pictures of one size, over the channels of a format.
fn difference(
    a: &Texture2d<'_>,
    b: &Texture2d<'_>,
    format: Format,
    color: ColorSpace,
) -> (f64, f64) {
    let channels = match format {
        Format::Bc4 => 0..1,
        Format::Bc5 => 0..2,
        Format::Bc1 | Format::Bc3 | Format::Bc7 => 0..4,
    };
    let (mut sum, mut largest) = (0.0, 0.0_f64);
    for (x, y) in (0..a.height()).flat_map(|y| (0..a.width()).map(move |x| (x, y))) {
        let [a, b] = [a, b].map(|t| codes(t.texel(0, x, y).unwrap_or_default(), color));
        for k in channels.clone() {
            // The colour of a texel that is not there is none.
            let seen = if k < 3 && a[3] == 0.0 && b[3] == 0.0 {
                0.0
            } else {
                1.0
            };
            let d = (a[k] - b[k]).abs() * seen;
            sum += d * d;
            largest = largest.max(d);
        }
    }
    let count = f64::from(a.width()) * f64::from(a.height()) * channels.len() as f64;
    ((sum / count).sqrt(), largest)
}

/// Straight codes from 0 to 255 of a linear, premultiplied texel.
fn codes([r, g, b, a]: [f32; 4], color: ColorSpace) -> [f64; 4] {
    let straight = |c: f32| if a > 0.0 { c / a } else { c };
    let code = |c: f32| match color {
        ColorSpace::Srgb => f64::from(texmap_math::color::linear_to_srgb8(straight(c))),
        ColorSpace::Linear => f64::from(straight(c)) * 255.0,
    };
    [code(r), code(g), code(b), f64::from(a) * 255.0]
}

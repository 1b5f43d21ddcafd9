//! `texmap mip`: the mip chain of an image as files.

use std::path::PathBuf;

use clap::Args;
use texmap_io::{Lost, image_io, write_pixels};
use texmap_math::MemoryBudget;
use texmap_sample::{ColorSpace, Texture2d};
use texmap_scene::ColorMode;

use crate::cmd::render::plan::numbered;
use crate::cmd::written::Written;
use crate::failure::{Exit, Failure};
use crate::formats;
use crate::levels::ask_for_levels;
use crate::output::{Destination, Stage, distinct};
use crate::values;

/// Write every mip level of an image: area-weighted, in linear light, premultiplied.
///
/// Levels of a 16-bit PNG are 16-bit PNGs. HDR and EXR are linear light, read and written as floats.
#[derive(Args, Debug)]
#[command(after_help = "All levels:  texmap mip brick.png -o 'brick%02d.png'\n\
                  A cut-out:   texmap mip leaf.png --keep-coverage 0.5 -o 'leaf%d.png'")]
pub(crate) struct MipArgs {
    /// The image: PNG, JPEG, WebP, GIF, BMP, TGA, TIFF, QOI, HDR or EXR
    image: PathBuf,
    /// Name of the files with %d or %02d for the level; their ending is .png, .jpg, .webp, .hdr or .exr
    #[arg(short, long, value_name = "OUT%02d.png")]
    output: PathBuf,
    /// srgb decodes before averaging; raw averages the codes. Floats are averaged as they are
    #[arg(long, value_name = "SPACE", value_parser = values::color, default_value = "srgb")]
    color: ColorMode,
    /// For cut-outs: scale the alpha of each level, no more than needed, so that as much passes this threshold as in the image
    #[arg(long, value_name = "ALPHA")]
    keep_coverage: Option<f32>,
    /// Print a report as JSON to standard output
    #[arg(long)]
    pub(crate) json: bool,
}

pub(crate) fn run(args: &MipArgs) -> Result<Exit, Failure> {
    let name = |level| {
        numbered(&args.output, level).ok_or_else(|| {
            Failure::usage(
                format!("-o {}: no place for the level", args.output.display()),
                "name the files with %d or %02d, such as out%02d.png",
            )
        })
    };
    let first = name(0)?;
    let format = formats::picture("-o", &args.output)?;
    let space = match args.color {
        ColorMode::Srgb => ColorSpace::Srgb,
        ColorMode::Raw => ColorSpace::Linear,
    };
    if let Some(k) = args.keep_coverage
        && !(k > 0.0 && k < 1.0)
    {
        return Err(Failure::usage(
            format!("--keep-coverage {k} is not a threshold"),
            "give a number between 0 and 1, such as 0.5",
        ));
    }
    let names: Vec<_> = (0..=Texture2d::MAX_SIDE.ilog2())
        .map(&name)
        .collect::<Result<_, _>>()?;
    distinct(&names, [&args.image])?;
    let (texture, bits) = image_io::read_texture(&args.image, space)?;
    ask_for_levels(&texture, &args.image)?;
    if args.keep_coverage.is_some() {
        // Coverage is measured on decoded texels, and level by level in floats.
        MemoryBudget::of_process().ask(
            12 * u64::from(texture.width()) * u64::from(texture.height()),
            format_args!("the coverage of {}", args.image.display()),
            "take a smaller image",
        )?;
    }
    let texture = match args.keep_coverage {
        Some(threshold) => texture.with_coverage_mips(threshold),
        None => texture.with_mips(),
    };
    let first = Destination::new(&first)?;
    let mut stage = Stage::new(&first)?;
    let code = formats::pixel_code(format, bits, args.color, texture.has_alpha());
    let mut lost = Lost::default();
    let mut written = Written::new("mip");
    for level in 0..texture.levels() {
        let Some((width, height)) = texture.level_size(level) else {
            break;
        };
        let output = name(level)?;
        written.picture(&output, (width, height));
        let destination = Destination::new(&output)?;
        let path = stage.add(destination, format.ending());
        write_pixels(&path, code, (width, height), |out| {
            let mut row = vec![0; code.bytes() * width as usize];
            (0..height).try_for_each(|y| {
                let texels = (0..width).filter_map(|x| texture.texel(level, x, y));
                lost += code.encode(&texels.collect::<Vec<_>>(), &mut row);
                out.write_all(&row)
            })
        })?;
    }
    stage.commit()?;
    written.warn(formats::warn(&args.output, format, lost));
    written.tell(args.json)
}

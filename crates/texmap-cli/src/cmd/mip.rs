//! `texmap mip`: the mip chain of an image as files.

use std::path::{Path, PathBuf};

use clap::Args;
use texmap_io::image_io;
use texmap_math::MemoryBudget;
use texmap_render::ColorMode;
use texmap_sample::{ColorSpace, Texture2d};

use crate::cmd::warp::encode;
use crate::failure::{Exit, Failure};
use crate::output::{Destination, Stage, distinct};
use crate::values;

/// Write every mip level of an image: area-weighted, in linear light, premultiplied.
#[derive(Args, Debug)]
pub(crate) struct MipArgs {
    /// The image: PNG, JPEG or GIF
    image: PathBuf,
    /// Name of the PNGs with %d or %02d for the level
    #[arg(short, long, value_name = "OUT%02d.png")]
    output: String,
    /// srgb decodes before averaging; raw averages the bytes
    #[arg(long, value_name = "SPACE", value_parser = values::color, default_value = "srgb")]
    color: ColorMode,
    /// For cut-outs: scale the alpha of each level so that as much passes this threshold as in the image
    #[arg(long, value_name = "ALPHA")]
    keep_coverage: Option<f32>,
}

pub(crate) fn run(args: &MipArgs) -> Result<Exit, Failure> {
    let names = Pattern::new(&args.output)?;
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
    distinct(
        (0..=Texture2d::MAX_SIDE.ilog2()).map(|level| names.of(level)),
        [&args.image],
    )?;
    let texture = image_io::read_texture(&args.image, space)?;
    let texture = match args.keep_coverage {
        Some(threshold) => texture.with_coverage_mips(threshold),
        None => texture.with_mips(),
    };
    let first = Destination::new(Path::new(&names.of(0)))?;
    let mut stage = Stage::new(&first)?;
    for level in 0..texture.levels() {
        let Some((width, height)) = texture.level_size(level) else {
            break;
        };
        // A vector that doubles while it grows.
        MemoryBudget::of_process().ask(
            u64::from(width) * u64::from(height) * 8,
            format_args!("a level of {width} x {height} texels"),
            "take a smaller image",
        )?;
        let rgba: Vec<u8> = (0..height)
            .flat_map(|y| (0..width).map(move |x| (x, y)))
            .filter_map(|(x, y)| texture.texel(level, x, y))
            .flat_map(|c| encode(c, args.color))
            .collect();
        let destination = Destination::new(Path::new(&names.of(level)))?;
        image_io::write_png(&stage.add(destination, "png"), width, height, &rgba)?;
    }
    stage.commit()?;
    Ok(Exit::Done)
}

/// A name around a number.
struct Pattern<'a> {
    before: &'a str,
    digits: usize,
    after: &'a str,
}

impl<'a> Pattern<'a> {
    fn new(text: &'a str) -> Result<Self, Failure> {
        let refused = || {
            Failure::usage(
                format!("-o {text}: no place for the level"),
                "name the files with %d or %02d, such as out%02d.png",
            )
        };
        let (before, rest) = text.split_once('%').ok_or_else(refused)?;
        let (digits, after) = rest.split_once('d').ok_or_else(refused)?;
        let digits = match digits {
            "" => 1,
            d => d
                .strip_prefix('0')
                .and_then(|d| d.parse().ok())
                .filter(|d| (1..=9).contains(d))
                .ok_or_else(refused)?,
        };
        Ok(Self {
            before,
            digits,
            after,
        })
    }

    fn of(&self, level: u32) -> String {
        format!(
            "{}{level:0digits$}{}",
            self.before,
            self.after,
            digits = self.digits
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_count_the_levels() {
        assert_eq!(Pattern::new("a%02d.png").unwrap().of(7), "a07.png");
        assert_eq!(Pattern::new("a%d.png").unwrap().of(11), "a11.png");
        for bad in ["a.png", "a%.png", "a%2d.png", "a%0xd.png"] {
            assert_eq!(
                Pattern::new(bad).err().map(|f| f.exit),
                Some(Exit::Usage),
                "{bad}"
            );
        }
    }
}

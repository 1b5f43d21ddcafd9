//! `texmap slice`: a cut through a grid or a pattern as a picture.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use texmap_io::{image_io, write_pixels};
use texmap_sample::{ColorSpace, Filter, Pattern, Sampler, Wrap};
use texmap_scene::ColorMode;

use crate::cmd::written::{Written, one_stdout};
use crate::failure::{Exit, Failure, say};
use crate::formats;
use crate::output::{Destination, Stage, distinct};
use crate::values;

/// Write a cut through a volume across one of its axes.
#[derive(Args, Debug)]
#[command(
    after_help = "Grids are .npy arrays of shape (slices, rows, columns) or that and 1 to 4 channels, u8, u16 or f32.\n\
    Across z the picture shows columns and rows as they lie; across y columns and slices; across x slices and rows.\n\n\
    The middle of a scan: texmap slice head.npy --axis y -o middle.png\n\
    A pattern:            texmap slice marble --units 6 --size 512 -o marble.png"
)]
pub(crate) struct SliceArgs {
    /// The grid (.npy), or the pattern: marble, wood, noise
    volume: PathBuf,
    /// The file to write; its ending (.png, .jpg, .webp, .hdr, .exr) sets the format
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,
    /// The axis that the cut stands across
    #[arg(long, value_enum, default_value_t = Axis::Z)]
    axis: Axis,
    /// Position along the axis, 0 to 1
    #[arg(
        long,
        value_name = "T",
        default_value_t = 0.5,
        allow_negative_numbers = true
    )]
    at: f64,
    /// Pixels of the longer side [default: one a voxel; 256 for patterns]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=16384))]
    size: Option<u32>,
    /// nearest, or bilinear between voxels and slices
    #[arg(long, value_name = "FILTER", default_value = "bilinear")]
    filter: Filter,
    /// A row of texels that the first channel is looked up along
    #[arg(long, value_name = "IMAGE")]
    ramp: Option<PathBuf>,
    /// Units of a pattern across the picture
    #[arg(long, value_name = "N", default_value_t = 4.0)]
    units: f64,
    /// PNG: srgb takes values as light and encodes them; raw stores them as they are
    #[arg(long, value_name = "SPACE", value_parser = values::color, default_value = "raw")]
    color: ColorMode,
    /// Print a report as JSON to standard output
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Axis {
    X,
    Y,
    Z,
}

pub(crate) fn run(args: &SliceArgs) -> Result<Exit, Failure> {
    if !(0.0..=1.0).contains(&args.at) {
        return Err(Failure::usage(
            format!("--at {} lies outside of the volume", args.at),
            "give 0 to 1: 0.5 is the middle",
        ));
    }
    if !(args.units.is_finite() && args.units > 0.0) {
        return Err(Failure::usage(
            format!("--units {} is no width", args.units),
            "give a number above 0, such as 4",
        ));
    }
    if !matches!(args.filter, Filter::Nearest | Filter::Bilinear) {
        return Err(Failure::usage(
            "--filter: a slice has no level of detail",
            "choose nearest or bilinear",
        ));
    }
    one_stdout(args.json, &args.output)?;
    let ramp = args.ramp.as_ref().map(|ramp| ramp.as_os_str());
    distinct(
        [&args.output],
        ramp.into_iter().chain([args.volume.as_ref()]),
    )?;
    let destination = Destination::new(&args.output)?;
    let format = formats::picture("-o", &args.output)?;
    let ramp = match &args.ramp {
        None => None,
        Some(path) => {
            let space = match args.color {
                ColorMode::Srgb => ColorSpace::Srgb,
                ColorMode::Raw => ColorSpace::Linear,
            };
            Some(image_io::read_texture(path, space)?.0)
        }
    };
    let sampler = Sampler {
        filter: args.filter,
        wrap_u: Wrap::ClampToEdge,
        wrap_v: Wrap::ClampToEdge,
        ..Sampler::default()
    };
    let pattern = match args.volume.to_str().unwrap_or_default() {
        "marble" => Some(Pattern::Marble {
            octaves: 4,
            turbulence: 1.0,
        }),
        "wood" => Some(Pattern::Wood { grain: 0.2 }),
        "noise" => Some(Pattern::Noise { octaves: 4 }),
        _ => None,
    };
    let grid = match pattern {
        Some(_) => None,
        None => Some(texmap_io::read_grid(&args.volume)?),
    };
    let [columns, rows, slices] = grid
        .as_ref()
        .and_then(|g| g.level_size(0))
        .unwrap_or([256; 3]);
    let (across, down) = match args.axis {
        Axis::X => (slices, rows),
        Axis::Y => (columns, slices),
        Axis::Z => (columns, rows),
    };
    let longer = across.max(down);
    let scale = f64::from(args.size.unwrap_or(longer)) / f64::from(longer);
    let pixels = |n: u32| ((f64::from(n) * scale).round() as u32).max(1);
    let (width, height) = (pixels(across), pixels(down));
    texmap_math::MemoryBudget::of_process().ask(
        u64::from(width) * u64::from(height) * 16,
        format_args!("a picture of {width} x {height} pixels"),
        "give a smaller --size",
    )?;
    let mut colors = Vec::with_capacity(width as usize * height as usize);
    for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
        let place = |i: u32, n: u32| (f64::from(i) + 0.5) / f64::from(n);
        let (s, t) = (place(x, width), place(y, height));
        let at = match args.axis {
            Axis::X => [args.at, t, s],
            Axis::Y => [s, args.at, t],
            Axis::Z => [s, t, args.at],
        };
        let mut color = match (&grid, pattern) {
            (Some(grid), _) => {
                sampler.sample_3d(grid, at.map(|c| c as f32), Wrap::ClampToEdge, 0.0)
            }
            (None, pattern) => {
                let p = at.map(|c| ((c - 0.5) * args.units) as f32);
                let wide = (args.units / f64::from(width)) as f32;
                let v = pattern.map_or(0.0, |pattern| pattern.value(p, wide));
                [v, v, v, 1.0]
            }
        };
        if let Some(ramp) = &ramp {
            color = sampler.sample_lod(ramp, [color[0], 0.5], 0.0);
        }
        colors.push(color);
    }
    let mut stage = Stage::new(&destination)?;
    let alpha = match &ramp {
        Some(ramp) => ramp.has_alpha(),
        None => grid.as_ref().is_some_and(|grid| grid.has_alpha()),
    };
    let code = formats::pixel_code(format, 8, args.color, alpha);
    let mut pixels = vec![0; code.bytes() * colors.len()];
    let lost = code.encode(&colors, &mut pixels);
    let path = stage.add(destination, format.ending());
    write_pixels(&path, code, (width, height), |out| out.write_all(&pixels))?;
    stage.commit()?;
    let mut written = Written::new("slice");
    written.picture(&args.output, (width, height));
    written.warn(formats::warn(&args.output, format, lost));
    say(&format!(
        "{}: {width} x {height} pixels\n",
        args.output.display()
    ));
    written.tell(args.json)
}

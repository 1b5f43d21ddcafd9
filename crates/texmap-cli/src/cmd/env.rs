//! `texmap env`: environments from layout to layout, and blurred to specular maps.

use std::path::PathBuf;

use clap::Args;
use texmap_light::{Environment, EnvironmentLayout};

use crate::cmd::written::{Written, one_stdout};
use crate::failure::{Exit, Failure, say};
use crate::formats;
use crate::output::{Destination, Stage, distinct};

/// Convert an environment from one layout to another, or blur it to a specular map.
#[derive(Args, Debug)]
#[command(
    after_help = "Layouts: cube, tan-cube, lat-long, octahedron, equal-area-octahedron, dual-paraboloid, sphere-map.\n\
    Several faces stand below each other: +X -X +Y -Y +Z -Z of a cube, +Z -Z of the paraboloids.\n\
    PNG holds sRGB from 0 to 1, HDR linear light from 0, EXR all of it. docs/generated/charts.md tells which layout is best.\n\n\
    Six faces:      texmap env sky.hdr --to cube -o sky-cube.exr\n\
    A specular map: texmap env sky.hdr --to octahedron --blur 50 -o glossy.hdr"
)]
pub(crate) struct EnvArgs {
    /// The environment: PNG, JPEG, HDR or EXR
    image: PathBuf,
    /// The file to write; its ending (.png, .jpg, .webp, .hdr, .exr) says what it becomes
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,
    /// The layout of the image
    #[arg(long, value_name = "LAYOUT", default_value = "lat-long")]
    from: EnvironmentLayout,
    /// The layout to write
    #[arg(long, value_name = "LAYOUT")]
    to: EnvironmentLayout,
    /// Height of a face in texels [default: as many texels in all as the image has]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=8192))]
    size: Option<u32>,
    /// Gather the light of a highlight with this exponent around each direction: a specular map
    #[arg(long, value_name = "EXPONENT")]
    blur: Option<f32>,
    /// Print a report as JSON to standard output
    #[arg(long)]
    pub(crate) json: bool,
}

pub(crate) fn run(args: &EnvArgs) -> Result<Exit, Failure> {
    if let Some(exponent) = args.blur
        && !(exponent.is_finite() && exponent >= 0.0)
    {
        return Err(Failure::usage(
            format!("--blur {exponent}: no exponent of a highlight"),
            "give 0 or more: 1 is all but diffuse, 1000 nearly a mirror",
        ));
    }
    one_stdout(args.json, &args.output)?;
    distinct([&args.output], [&args.image])?;
    let destination = Destination::new(&args.output)?;
    let format = formats::picture("-o", &args.output)?;
    let source = texmap_io::read_environment(&args.image, args.from)?;
    let texels = |e: &Environment| {
        let (width, height) = e.size();
        u64::from(width) * u64::from(height) * e.layout().faces() as u64
    };
    // As many texels as there are, or as the lobe needs.
    let enough = match args.blur {
        None => texels(&source),
        Some(exponent) => 6 * u64::from(Environment::blurred_size(exponent)).pow(2),
    };
    let faces = args.to.faces() as u64 * u64::from(args.to.aspect());
    let enough = ((enough / faces) as f64).sqrt().max(1.0) as u32;
    let size = args.size.unwrap_or(enough);
    let refused = |e: texmap_light::LightError| {
        Failure::usage(format!("--size {size}: {e}"), "choose another size")
    };
    let result = match args.blur {
        None => source.convert(args.to, size).map_err(refused)?,
        Some(exponent) => {
            if size > 64.max(2 * enough) {
                return Err(Failure::usage(
                    format!("--size {size} for --blur {exponent}: the work has no end and no use"),
                    format!("a blurred map is smooth: {enough} are enough"),
                ));
            }
            source
                .specular_map(args.to, size, exponent)
                .map_err(refused)?
        }
    };
    let mut stage = Stage::new(&destination)?;
    let path = stage.add(destination, format.ending());
    let lost = texmap_io::write_environment(&path, &result)?;
    stage.commit()?;
    let (width, height) = result.size();
    say(&format!(
        "{}: {}, {width} x {height} texels a face\n",
        args.output.display(),
        args.to.name()
    ));
    let mut written = Written::new("env");
    let faces = args.to.faces() as u32;
    written.picture(&args.output, (width, height * faces));
    written.warn(formats::warn(&args.output, format, lost));
    written.tell(args.json)
}

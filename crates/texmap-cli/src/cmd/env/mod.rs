//! `texmap env`: environments from layout to layout or seen from a point of a scene, blurred to specular maps, and prefiltered for
//! image-based light.

mod capture;
mod faces;
mod prefilter;

use std::path::{Path, PathBuf};

use clap::Args;
use texmap_io::PictureFormat;
use texmap_light::{Environment, EnvironmentLayout, LightError};

use crate::cmd::Root;
use crate::cmd::written::{Written, one_stdout};
use crate::failure::{Exit, Failure, say};
use crate::formats;
use crate::output::{Destination, Stage, distinct};
use crate::values::Triple;
use faces::{Faces, Picture, with_suffix};
use prefilter::Lobe;

/// Convert an environment from one layout to another or see it from a point of a scene, blur it to a specular map, or prefilter it for
/// image-based light.
#[derive(Args, Debug)]
#[command(
    after_help = "Layouts: cube, tan-cube, lat-long, octahedron, equal-area-octahedron, dual-paraboloid, sphere-map.\n\
    Several faces stand below each other: +X -X +Y -Y +Z -Z of a cube, +Z -Z of the paraboloids.\n\
    PNG holds sRGB from 0 to 1, HDR linear light from 0, EXR all of it. docs/generated/charts.md tells which layout is best.\n\n\
    From a scene:      texmap env --from-scene room.scene --object cow -o cow.exr\n\
    Six faces:         texmap env sky.hdr --to cube --faces files -o sky.exr\n\
    A specular map:    texmap env sky.hdr --to octahedron --blur 50 -o glossy.hdr\n\
    A prefiltered map: texmap env sky.hdr --prefilter ggx --size 256 -o sky.exr\n\
    writes sky.level0.exr (256 texels a face, roughness 0), sky.level1.exr (128) .. sky.level6.exr (4, roughness 1),\n\
    sky.irradiance.exr (over pi) and sky.brdf.exr, the table of the split sum."
)]
pub(crate) struct EnvArgs {
    /// The environment: PNG, JPEG, HDR or EXR
    #[arg(required_unless_present = "from_scene", conflicts_with = "from_scene")]
    image: Option<PathBuf>,
    /// Take the six views of this scene from a point, --at or --object, in linear light; .exr and .hdr keep it as it is
    #[arg(long, value_name = "SCENE", conflicts_with = "from")]
    from_scene: Option<PathBuf>,
    /// The point in the world
    #[arg(
        long,
        value_name = "X,Y,Z",
        allow_hyphen_values = true,
        requires = "from_scene",
        conflicts_with = "object"
    )]
    at: Option<Triple>,
    /// The middle of the mesh or model of this name, which is left out
    #[arg(long, value_name = "NAME", requires = "from_scene")]
    object: Option<String>,
    /// The file to write; its ending (.png, .jpg, .webp, .hdr, .exr) sets the format
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,
    /// The layout of the image
    #[arg(long, value_name = "LAYOUT", default_value = "lat-long")]
    from: EnvironmentLayout,
    /// The layout to write [default with --prefilter and --from-scene: cube]
    #[arg(long, value_name = "LAYOUT", required_unless_present_any = ["prefilter", "from_scene"])]
    to: Option<EnvironmentLayout>,
    /// Arrangement of the faces of a cube in pictures
    #[arg(long, value_name = "HOW", default_value = "strip")]
    faces: Faces,
    /// Height of a face in texels [default: as many texels in all as the image has; a power of two of at most so many for
    /// --prefilter; 256 for --from-scene]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=8192))]
    size: Option<u32>,
    /// Gather the light of a highlight with this exponent around each direction: a specular map
    #[arg(long, value_name = "EXPONENT")]
    blur: Option<f32>,
    /// Gather the light of rising roughnesses: a level for each, the irradiance and the table of the split sum. Files of .exr or .hdr
    #[arg(long, value_name = "LOBE", conflicts_with = "blur")]
    prefilter: Option<Lobe>,
    /// Levels of --prefilter: roughness 0 to 1 in even steps [default: down to 4 texels a face]
    #[arg(long, value_name = "N", requires = "prefilter", value_parser = clap::value_parser!(u32).range(2..=14))]
    levels: Option<u32>,
    #[command(flatten)]
    root: Root,
    /// Print a report as JSON to standard output
    #[arg(long)]
    pub(crate) json: bool,
}

/// Pictures by the middles of their names; an empty one for the only picture of a conversion.
type Pictures = Vec<(String, Vec<Picture>)>;

pub(crate) fn run(args: &EnvArgs) -> Result<Exit, Failure> {
    if let Some(exponent) = args.blur
        && !(exponent.is_finite() && exponent >= 0.0)
    {
        return Err(Failure::usage(
            format!("--blur {exponent}: no exponent of a highlight"),
            "give 0 or more: 1 is all but diffuse, 1000 nearly a mirror",
        ));
    }
    let to = args.to.unwrap_or(EnvironmentLayout::Cube);
    if !args.faces.fit(to) {
        return Err(Failure::usage(
            format!("--to {}: it has no six faces", to.name()),
            "--faces files and --faces cross are of cube and tan-cube",
        ));
    }
    one_stdout(args.json, &args.output)?;
    let several = args.prefilter.is_some() || args.faces == Faces::Files;
    if several && args.output == Path::new("-") {
        return Err(Failure::usage(
            "-o -: several files do not go to standard output",
            "name a file",
        ));
    }
    let given: Vec<&PathBuf> = args.image.iter().chain(&args.from_scene).collect();
    distinct([&args.output], &given)?;
    let format = match args.prefilter {
        None => formats::picture("-o", &args.output)?,
        Some(_) => match formats::ending("-o", &args.output, &["exr", "hdr"])? {
            "hdr" => PictureFormat::Hdr,
            _ => PictureFormat::Exr,
        },
    };
    let files = args.root.files()?;
    let (source, point) = match (&args.image, &args.from_scene) {
        (Some(image), _) => (texmap_io::read_environment(image, args.from)?, None),
        (None, Some(scene)) => {
            let (seen, point) = capture::captured(args, scene, &files)?;
            (seen, Some(point))
        }
        (None, None) => return Err(Failure::internal("no environment")),
    };
    let mut inputs = files.recorded();
    inputs.extend(given.into_iter().cloned());
    let (pictures, size) = match args.prefilter {
        None => converted(args, &source, to)?,
        Some(Lobe::Ggx) => prefiltered(args, &source, to)?,
    };
    let mut written = Written::new("env");
    let mut stage = Stage::new(&Destination::new(&args.output)?)?;
    for (middle, faces) in pictures {
        let path = match middle.as_str() {
            "" => args.output.clone(),
            middle => with_suffix(&args.output, middle),
        };
        for picture in faces {
            let name = picture.name(&path);
            distinct([&name], &inputs)?;
            let place = stage.add(Destination::new(&name)?, format.ending());
            let (width, height) = (picture.width, picture.height);
            let lost = texmap_io::write_light(&place, width, height, &picture.texels)?;
            written.picture(&name, (width, height));
            written.warn(formats::warn(&name, format, lost));
        }
    }
    stage.commit()?;
    let (width, height) = size;
    let seen = point.map_or_else(String::new, |point| format!(", seen from {point}"));
    say(&format!(
        "{}: {}, {width} x {height} texels a face{seen}\n",
        args.output.display(),
        to.name()
    ));
    written.tell(args.json)
}

/// One environment in another layout, blurred where that is asked for, and the size of its faces.
fn converted(
    args: &EnvArgs,
    source: &Environment,
    to: EnvironmentLayout,
) -> Result<(Pictures, (u32, u32)), Failure> {
    let enough = match args.blur {
        None => texels(source),
        Some(exponent) => 6 * u64::from(Environment::blurred_size(exponent)).pow(2),
    };
    let enough = height_of(to, enough);
    let size = args.size.unwrap_or(enough);
    let result = match args.blur {
        // Another format is no other picture.
        None if source.layout() == to && source.size().1 == size => source.clone(),
        None => source.convert(to, size).map_err(refused(size))?,
        Some(exponent) => {
            if size > 64.max(2 * enough) {
                return Err(Failure::usage(
                    format!("--size {size} for --blur {exponent}: the work has no end and no use"),
                    format!("a blurred map is smooth: {enough} are enough"),
                ));
            }
            source
                .specular_map(to, size, exponent)
                .map_err(refused(size))?
        }
    };
    let pictures = args.faces.pictures(&result);
    Ok((vec![(String::new(), pictures)], result.size()))
}

/// The levels of a prefiltered environment with what goes with them, and the size of the first.
fn prefiltered(
    args: &EnvArgs,
    source: &Environment,
    to: EnvironmentLayout,
) -> Result<(Pictures, (u32, u32)), Failure> {
    let enough = height_of(to, texels(source)).clamp(16, MOST);
    let size = args.size.unwrap_or(1 << enough.ilog2());
    if !size.is_power_of_two() || size > MOST {
        return Err(Failure::usage(
            format!("--size {size}: no power of two up to {MOST}"),
            "the levels are halves of each other: 256 serves most",
        ));
    }
    let levels = args.levels.unwrap_or_else(|| prefilter::levels(size));
    if size >> (levels - 1) == 0 {
        return Err(Failure::usage(
            format!("--levels {levels}: {size} texels have not so many halves"),
            format!("{} are the most", size.ilog2() + 1),
        ));
    }
    let all = prefilter::chain(source, to, (size, levels), args.faces).map_err(refused(size))?;
    Ok((all, (size * to.aspect(), size)))
}

/// Largest face of a prefiltered map.
const MOST: u32 = 2048;

fn texels(e: &Environment) -> u64 {
    let (width, height) = e.size();
    u64::from(width) * u64::from(height) * e.layout().faces() as u64
}

/// Height of the faces of a layout that has about so many texels.
fn height_of(layout: EnvironmentLayout, texels: u64) -> u32 {
    let faces = layout.faces() as u64 * u64::from(layout.aspect());
    ((texels / faces) as f64).sqrt().max(1.0) as u32
}

fn refused(size: u32) -> impl Fn(LightError) -> Failure {
    move |e| Failure::usage(format!("--size {size}: {e}"), "choose another size")
}

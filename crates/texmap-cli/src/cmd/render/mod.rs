//! `texmap render`: scenes and models to pictures.

use std::path::PathBuf;

use clap::Args;
use texmap_io::CameraPath;
use texmap_io::framing::View;
use texmap_raster::Interp;
use texmap_sample::{Filter, Wrap};
use texmap_scene::ColorMode;

use crate::cmd::Root;
use crate::cmd::render::budget::{MaxError, Quality};
use crate::cmd::render::report::{ItemReport, Report};
use crate::failure::{self, Exit, Failure};
use crate::values::{self, AovArg, Background, LevelName, Resolution, Triple};

mod budget;
mod draw;
pub(crate) mod plan;
mod report;
mod sheet;

/// Draw scenes and models: .scene, .obj, .ply or .stl in, .png out.
#[derive(Args, Debug)]
#[command(
    after_help = "Several inputs: -o is a folder, or a name with {model} (the input's name without its ending). \
    One bad input does not stop the others; the exit code is then 3."
)]
pub(crate) struct RenderArgs {
    /// .scene, .obj, .ply and .stl files; a model alone gets an automatic camera and light
    #[arg(required = true, value_name = "IN")]
    inputs: Vec<PathBuf>,
    /// The PNG to write; `-` is standard output; with --frames a name with %04d
    #[arg(short, long, value_name = "OUT", required_unless_present = "dry_run")]
    output: Option<PathBuf>,
    /// Size of the picture (of each cell with --views)
    #[arg(long, value_name = "WxH", default_value = "1024x768")]
    resolution: Resolution,
    /// Interpolation instead of the scene's: perspective, affine, subdivided:N, span:N, within:TOLERANCE
    #[arg(long, value_name = "METHOD", value_parser = values::interp)]
    interp: Option<Interp>,
    /// Texture filter instead of the scene's: nearest, bilinear, bicubic:mitchell, mip-nearest,
    /// bilinear-mip-nearest, trilinear, anisotropic:16, ewa:16, ewa:16:0.75
    #[arg(long, value_name = "METHOD", value_parser = values::filter)]
    filter: Option<Filter>,
    /// Wrap in both directions instead of the scene's: repeat, mirrored-repeat, clamp-to-edge,
    /// clamp-to-border, mirror-clamp-to-edge
    #[arg(long, value_name = "MODE", value_parser = values::wrap)]
    wrap: Option<Wrap>,
    /// Let the planner choose interpolation and filter of each mesh, and the samples of a pixel: the cheapest whose
    /// predicted error is at most this many texels and this colour RMSE (of 1; 0.02 if not given)
    #[arg(long, value_name = "TEXELS[,RMSE]", conflicts_with_all = ["interp", "filter", "quality"])]
    max_error: Option<MaxError>,
    /// The same by name
    #[arg(long, value_name = "NAME", conflicts_with_all = ["interp", "filter"])]
    quality: Option<Quality>,
    /// Print what the planner chose, why, and what it left out
    #[arg(long)]
    explain: bool,
    /// Compute the f64 reference too (slow; 6 x 6 samples a pixel, hard shadows by rays) and report the true error outside of outlines
    /// and of the edges of shadows; room.png gives room.heat.png. Exit code 1 where it is over a budget that the plan promised
    #[arg(long, conflicts_with_all = ["views", "supersample", "dry_run"])]
    verify: bool,
    /// N x N samples per pixel, averaged in linear light [default: 1, or the planner's choice]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=16))]
    supersample: Option<u32>,
    /// Samples of coverage and depth per pixel, shaded once for each triangle: 1 or 4
    #[arg(long, value_name = "N", default_value_t = 1, conflicts_with = "supersample", value_parser = values::msaa)]
    msaa: u32,
    /// Worker threads; default: as many as the machine gives. Does not change the picture
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    /// Instruction set: auto, avx512, avx2, sse4.2, sse2 or fallback. Does not change the picture
    #[arg(
        long,
        value_name = "LEVEL",
        default_value = "auto",
        hide_possible_values = true
    )]
    level: LevelName,
    /// Background colour in sRGB: #rrggbb, #rrggbbaa, r,g,b[,a] or transparent
    #[arg(long, value_name = "COLOR", allow_hyphen_values = true)]
    background: Option<Background>,
    /// srgb, or raw: no colour is converted, neither in nor out
    #[arg(long, value_name = "MODE", value_parser = values::color)]
    color: Option<ColorMode>,
    /// Where the camera stands
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    camera_eye: Option<Triple>,
    /// The point that the camera looks at
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    camera_look: Option<Triple>,
    /// The direction that is up in the picture
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    camera_up: Option<Triple>,
    /// Horizontal field of view in degrees
    #[arg(long, value_name = "DEGREES", allow_hyphen_values = true, value_parser = values::fov)]
    fov: Option<f64>,
    /// A walk: key positions of the camera, [{"eye":[x,y,z],"look":[x,y,z],"up":..,"fov":..}, ...]
    #[arg(long, value_name = "CAMERA.json", requires = "frames", conflicts_with_all = ["views", "camera_eye", "camera_look", "camera_up", "fov"])]
    path: Option<PathBuf>,
    /// Pictures along the walk, numbered from 0
    #[arg(long, value_name = "N", requires = "path", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    frames: Option<u32>,
    /// A captioned contact sheet: front, back, left, right, top, bottom, iso
    #[arg(long, value_name = "LIST", value_delimiter = ',', conflicts_with_all = ["aov", "camera_eye", "camera_look", "camera_up"])]
    views: Vec<View>,
    /// Arrays beside the picture: depth, inv_w, uv, lod, face, normal, position, shadow:LIGHT (its name or number);
    /// room.png gives room.uv.npy of shape (height, width, channels)
    #[arg(long, value_name = "LIST", value_delimiter = ',')]
    aov: Vec<AovArg>,
    #[command(flatten)]
    root: Root,
    /// Print a report as JSON to standard output
    #[arg(long)]
    pub(crate) json: bool,
    /// Check everything and print the plan; write nothing
    #[arg(long)]
    dry_run: bool,
}

pub(crate) fn run(args: &RenderArgs) -> Result<Exit, Failure> {
    let level = args.level.level()?;
    let items = plan::items(args)?;
    let files = args.root.files()?;
    let walk = args
        .path
        .as_deref()
        .map(|path| CameraPath::read_from(path, &files))
        .transpose()?;
    let mut reports: Vec<ItemReport> = Vec::new();
    let mut failures = Vec::new();
    for item in &items {
        match draw::item(args, item, level, walk.as_ref(), &files) {
            Ok(done) => reports.extend(done),
            // Alone, a bad input is the whole answer; among others it is one line of the report.
            Err(failure) if items.len() == 1 => return Err(failure),
            Err(failure) => {
                failure.report(false);
                reports.push(ItemReport::failed(&item.input, &failure));
                failures.push(failure);
            }
        }
    }
    let over = reports.iter().any(ItemReport::over_budget);
    // What was promised and is not true.
    let broken = reports.iter().any(ItemReport::breaks_budget);
    let exit = match failures.first() {
        None if over => Exit::OverBudget,
        None if broken => Exit::Differs,
        None => Exit::Done,
        Some(first) if failures.len() == items.len() => first.exit,
        Some(_) => Exit::Partial,
    };
    if args.json {
        failure::print_json(&Report::new(args, level, reports, exit))?;
    }
    Ok(exit)
}

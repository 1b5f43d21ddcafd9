//! `texmap render`: scenes and models to pictures.

use std::path::PathBuf;

use clap::Args;
use texmap_raster::{Interp, TILE};
use texmap_sample::{Filter, Wrap};
use texmap_scene::ColorMode;

use crate::cmd::Root;
use crate::cmd::render::budget::{MaxError, Quality};
use crate::cmd::render::camera::CameraArgs;
use crate::cmd::render::inputs::Inputs;
use crate::cmd::render::light::LightArgs;
use crate::cmd::render::look::LookArgs;
use crate::cmd::render::mirror::MirrorArg;
use crate::cmd::render::rays::Compare;
use crate::cmd::render::report::{ItemReport, Report};
use crate::failure::{self, Exit, Failure};
use crate::observe;
use crate::values::{self, AovArg, Background, LevelName, Part, Ranges, Resolution};

mod budget;
pub(crate) mod camera;
mod draw;
mod files;
pub(crate) mod inputs;
mod item;
mod light;
mod look;
mod mirror;
pub(crate) mod plan;
mod rays;
mod report;
mod seen;
mod sheet;
mod write;

/// Draw scenes and models as pictures.
///
/// A model without a camera is seen from the front, right and above, fills 90 % of the picture, and has four samples a pixel.
/// A scene has its own camera and samples.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub(crate) struct RenderArgs {
    /// Scenes (.scene) and models (.obj, .gltf, .glb, .ply, .stl); a model gets an automatic camera, and light where it has none. `-` is
    /// standard input, @LIST a file that names one input a line
    #[arg(required = true, value_name = "IN")]
    inputs: Vec<PathBuf>,
    /// The picture to write: .png, .jpg, .webp, .exr (linear light, --aov as layers), .hdr; `-` is standard output, PNG. Several pictures:
    /// a name with %04d or {view}, or .gif or .apng. Several inputs: a folder, or a name with {model} or {dir}. Folders are made
    #[arg(short, long, value_name = "OUT", required_unless_present = "dry_run")]
    output: Option<PathBuf>,
    /// Size of the picture (of each cell with --views)
    #[arg(long, value_name = "WxH", default_value = "1024x768")]
    resolution: Resolution,
    /// Interpolation instead of the scene's: perspective, affine, subdivided:N, span:N, within:TOLERANCE
    #[arg(long, value_name = "METHOD", value_parser = values::interp)]
    interp: Option<Interp>,
    /// Texture filter instead of the scene's: nearest, bilinear, bicubic:mitchell, mip-nearest,
    /// bilinear-mip-nearest, trilinear, anisotropic:16, ewa:16, ewa:16:0.75, summed-area
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
    /// The error budget by name
    #[arg(long, value_name = "NAME", conflicts_with_all = ["interp", "filter"])]
    quality: Option<Quality>,
    /// Print the planner's choices with their reasons, and the things that it left out
    #[arg(long)]
    explain: bool,
    /// Compute the f64 reference too (slow; 6 x 6 samples a pixel, hard shadows by rays) and report the true error outside of outlines
    /// and of the edges of shadows; room.png gives room.heat.png. Exit code 1 where it is over a budget that the plan promised
    #[arg(long, conflicts_with_all = ["views", "supersample", "dry_run", "wireframe"])]
    verify: bool,
    /// A flat mesh that mirrors the scene: its name, and the share of mirrored light in what is seen (0 to 1; the rest is its own). Several
    /// times for several; each shows the others as they are without
    #[arg(long, value_name = "NAME[=SHARE]", conflicts_with_all = ["verify", "compare", "max_error", "quality"])]
    mirror: Vec<MirrorArg>,
    /// Draw the picture with ray-traced mirrors too (slow; room.png gives room.rays.png) and tell the error of mapped reflections by the
    /// distance from the middle of each mirror
    #[arg(long, value_name = "WHAT", conflicts_with_all = ["views", "dry_run", "wireframe"])]
    compare: Option<Compare>,
    /// N x N samples per pixel, averaged in linear light [default: 1, or the planner's choice]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=16))]
    supersample: Option<u32>,
    /// Samples of coverage and depth per pixel, shaded once for each triangle: 1 or 4. Arrays of --aov describe pixel centres whatever
    /// this is [default: 4 for models, 1 for scenes]
    #[arg(long, value_name = "N", conflicts_with = "supersample", value_parser = values::msaa)]
    msaa: Option<u32>,
    /// Bits of a channel of a PNG: 8 or 16
    #[arg(long, value_name = "N", default_value_t = 8, value_parser = values::bits)]
    bits: u32,
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
    /// Background colour in sRGB: #rrggbb, #rrggbbaa, r,g,b[,a] or transparent; or env, the light from all around as --env, --env-rotate
    /// and --exposure make it
    #[arg(long, value_name = "COLOR|env", allow_hyphen_values = true)]
    background: Option<Background>,
    /// srgb, or raw: no colour is converted, neither in nor out
    #[arg(long, value_name = "MODE", value_parser = values::color)]
    color: Option<ColorMode>,
    /// Seconds into an animation of a glTF model [default: at rest]
    #[arg(long, value_name = "SECONDS", allow_hyphen_values = true, value_parser = values::seconds)]
    time: Option<f64>,
    /// The animation, by its name or number [default: the first]
    #[arg(long, value_name = "NAME|N")]
    animation: Option<String>,
    /// Arrays beside the picture: depth, inv_w, uv, lod, face, mesh, normal, position, color (the picture in linear light),
    /// shadow:LIGHT (its name or number); room.png gives room.uv.npy of shape (height, width, channels), room.exr holds them
    #[arg(
        long,
        value_name = "LIST",
        value_delimiter = ',',
        conflicts_with = "views"
    )]
    aov: Vec<AovArg>,
    /// Pictures of a series that are drawn, by their numbers from 0 (a task of `texmap batch`)
    #[arg(long, value_name = "LIST", hide = true)]
    only: Option<Ranges>,
    /// Band I of N, rows of tiles from the top (a task of `texmap batch`); the picture has its rows alone
    #[arg(long, value_name = "I/N", hide = true, conflicts_with_all = ["views", "turntable", "frames", "cameras", "verify", "wireframe", "aov", "only"])]
    band: Option<Part>,
    #[command(flatten)]
    root: Root,
    /// Print a report as JSON to standard output
    #[arg(long)]
    pub(crate) json: bool,
    /// Check everything and print the plan; write nothing
    #[arg(long)]
    dry_run: bool,
    /// Warnings are errors: nothing is written of an input that has one, and the exit code is 4
    #[arg(long)]
    strict: bool,
    // Last: their headings would continue over later arguments.
    #[command(flatten)]
    camera: CameraArgs,
    #[command(flatten)]
    look: LookArgs,
    #[command(flatten)]
    light: LightArgs,
}

impl RenderArgs {
    pub(crate) fn camera(&self) -> &CameraArgs {
        &self.camera
    }

    /// Refuses bands of pictures that are not drawn tile by tile, and more bands than rows of tiles.
    pub(crate) fn check_bands(&self, bands: u32) -> Result<(), Failure> {
        let camera = &self.camera;
        let clash = [
            ("--views", !camera.views.is_empty()),
            ("--turntable", camera.turntable.is_some()),
            ("--frames", camera.frames.is_some()),
            ("--cameras", camera.cameras.is_some()),
            ("--verify", self.verify),
            ("--wireframe", self.look.wireframe),
            ("--aov", !self.aov.is_empty()),
        ];
        if let Some((flag, _)) = clash.iter().find(|(_, given)| *given) {
            return Err(Failure::usage(
                format!("--bands and {flag} do not go together"),
                "bands are of one picture without arrays",
            ));
        }
        let rows = self.resolution.height.div_ceil(TILE);
        match bands <= rows {
            true => Ok(()),
            false => Err(Failure::usage(
                format!("--bands {bands}: the picture has {rows} rows of tiles of {TILE} pixels"),
                format!("at most {rows} bands"),
            )),
        }
    }
}

const EXAMPLES: &str = "\
A first look:       texmap render model.obj -o model.png
From all sides:     texmap render model.obj --views front,right,top,iso -o sheet.png
A turntable:        texmap render model.obj --turntable 48 -o spin.gif
An animation:       texmap render model.glb --frames 50 -o walk.gif
A folder of models: texmap render *.obj -o 'out/{model}.jpg' --resolution 512x512
Linear light:       texmap render room.scene --aov depth,normal -o room.exr
Calibrated cameras: texmap render model.obj --cameras poses.json -o view-%02d.png
One bad input does not stop the others; the exit code is then 3.";

impl RenderArgs {
    /// True if somebody reads the report.
    fn reports(&self) -> bool {
        self.json || observe::is_on()
    }
}

pub(crate) fn run(args: &RenderArgs) -> Result<Exit, Failure> {
    let level = args.level.level()?;
    let files = args.root.files()?;
    let cameras = args.camera.list(&files)?;
    let inputs = Inputs::read(&args.inputs, &files, args.root.folder())?;
    let names = args.camera.names(&cameras);
    let items = plan::items(args, &inputs.names, &files.recorded(), names.as_deref())?;
    let cameras = args.camera.walk(&files, cameras)?;
    let mut reports: Vec<ItemReport> = Vec::new();
    let mut failures = Vec::new();
    let sources: Vec<_> = items
        .iter()
        .map(|item| (item, inputs.file(&item.input, &files)))
        .collect();
    item::keep_apart(args, &sources)?;
    for (item, (file, files)) in sources {
        match item::item(args, item, file, level, &cameras, files) {
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
    // Budgets that a plan promised and the true error exceeds.
    let broken = reports.iter().any(ItemReport::breaks_budget);
    let exit = match failures.first() {
        None if over => Exit::OverBudget,
        None if broken => Exit::Differs,
        None => Exit::Done,
        Some(first) if failures.len() == items.len() => first.exit,
        Some(_) => Exit::Partial,
    };
    if args.reports() {
        failure::print_json(&Report::new(args, level, reports, exit))?;
    }
    Ok(exit)
}

//! `texmap render`: scenes and models to pictures.

use std::path::PathBuf;

use clap::Args;

use crate::failure::{Exit, Failure};
use crate::values::{self, Background, Resolution, Triple};

/// Draw scenes and models: .scene or .obj in, .png out.
#[derive(Args, Debug)]
pub(crate) struct RenderArgs {
    /// .scene and .obj files
    #[arg(required = true, value_name = "IN")]
    inputs: Vec<PathBuf>,
    /// The PNG to write; `-` is standard output; with several inputs a directory or a name with
    /// {model}; with --frames a name with %04d
    #[arg(short, long, value_name = "OUT", required_unless_present = "dry_run")]
    output: Option<PathBuf>,
    /// Size of the picture (of each cell with --views)
    #[arg(long, value_name = "WxH", default_value = "1024x768")]
    resolution: Resolution,
    /// Samples per axis and pixel, averaged in linear light
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=16))]
    supersample: u32,
    /// Worker threads; default: as many as the machine gives
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    /// Background colour: #rrggbb, #rrggbbaa, r,g,b[,a] or transparent
    #[arg(long, value_name = "COLOR")]
    background: Option<Background>,
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
    #[arg(long, value_name = "DEGREES", value_parser = values::fov)]
    fov: Option<f64>,
    /// Print a report as JSON to standard output
    #[arg(long)]
    pub(crate) json: bool,
    /// Check everything and print the plan; write nothing
    #[arg(long)]
    dry_run: bool,
}

pub(crate) fn run(args: &RenderArgs) -> Result<Exit, Failure> {
    Err(Failure::new(
        Exit::Input,
        "file.read",
        format!("{}: cannot be read yet", args.inputs[0].display()),
        "the renderer is not joined to the program yet",
    ))
}

//! `texmap info`: what a scene or model holds, and what it misses.

use std::path::PathBuf;

use clap::Args;

use crate::failure::{Exit, Failure};

/// Show meshes, maps, uv ranges and missing files of a scene or model.
#[derive(Args, Debug)]
pub(crate) struct InfoArgs {
    /// A .scene or .obj file
    file: PathBuf,
    /// Print the same as JSON to standard output
    #[arg(long)]
    pub(crate) json: bool,
}

pub(crate) fn run(args: &InfoArgs) -> Result<Exit, Failure> {
    Err(Failure::new(
        Exit::Input,
        "file.read",
        format!("{}: cannot be read yet", args.file.display()),
        "the loaders are not joined to the program yet",
    ))
}

//! `texmap compress` in a program without the feature `gpu-images`: refused by name.

use clap::Args;

use crate::failure::{Exit, Failure};

/// Compress an image to blocks: left out of this program
#[derive(Args, Debug)]
pub(crate) struct CompressArgs {
    #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
    rest: Vec<String>,
}

pub(crate) fn run(args: &CompressArgs) -> Result<Exit, Failure> {
    Err(Failure::usage(
        format!(
            "compress {}: this program is built without the verb",
            args.rest.join(" ")
        ),
        "build the program with `--features gpu-images`",
    ))
}

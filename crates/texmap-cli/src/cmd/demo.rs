//! `texmap demo`: the captioned pictures that prove their claims.

use std::path::PathBuf;

use clap::Args;

use crate::failure::{Exit, Failure};

/// Draw a captioned side-by-side picture and check the numbers it claims.
#[derive(Args, Debug)]
#[command(after_help = "Exit code 1 when a claim fails.")]
pub(crate) struct DemoArgs {
    /// Which demo; --list names them
    #[arg(required_unless_present = "list")]
    name: Option<String>,
    /// The PNG to write
    #[arg(short, long, value_name = "OUT", required_unless_present = "list")]
    output: Option<PathBuf>,
    /// List the demos
    #[arg(long, conflicts_with_all = ["name", "output"])]
    list: bool,
    /// Print the claims as JSON to standard output
    #[arg(long)]
    pub(crate) json: bool,
}

pub(crate) fn run(args: &DemoArgs) -> Result<Exit, Failure> {
    let _ = (&args.name, &args.output, args.list);
    Err(Failure::usage(
        "no demos yet",
        "the demos are not joined to the program yet",
    ))
}

//! `texmap demo`: the captioned pictures that prove their claims.

use std::path::PathBuf;

use clap::Args;
use serde::Serialize;
use texmap_lab::demos::{self, Claim};

use crate::failure::{self, Exit, Failure, say};
use crate::output::{Destination, Stage};

/// Draw a captioned side-by-side picture and check the numbers it claims.
#[derive(Args, Debug)]
#[command(after_help = "Exit code 1 when a claim fails; the picture is written all the same.")]
pub(crate) struct DemoArgs {
    /// Which demo; --list names them
    #[arg(required_unless_present = "list")]
    name: Option<String>,
    /// The PNG to write; `-` is standard output
    #[arg(short, long, value_name = "OUT", required_unless_present = "list")]
    output: Option<PathBuf>,
    /// List the demos
    #[arg(long, conflicts_with_all = ["name", "output"])]
    list: bool,
    /// Print the list or the claims as JSON to standard output
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Serialize)]
struct DemoReport<'a> {
    demo: &'a str,
    output: String,
    captions: &'a [String],
    claims: Vec<ClaimReport<'a>>,
}

#[derive(Serialize)]
struct ClaimReport<'a> {
    claim: &'a str,
    measured: f64,
    expected: f64,
    tolerance: f64,
    holds: bool,
}

impl<'a> From<&'a Claim> for ClaimReport<'a> {
    fn from(claim: &'a Claim) -> Self {
        Self {
            claim: &claim.text,
            measured: claim.measured,
            expected: claim.expected,
            tolerance: claim.tolerance,
            holds: claim.holds(),
        }
    }
}

#[derive(Serialize)]
struct Listed {
    name: &'static str,
    shows: &'static str,
}

pub(crate) fn run(args: &DemoArgs) -> Result<Exit, Failure> {
    let (Some(name), Some(output)) = (&args.name, &args.output) else {
        list(args.json);
        return Ok(Exit::Done);
    };
    if args.json && output.as_os_str() == "-" {
        return Err(Failure::usage(
            "-o - and --json do not go together",
            "name a file",
        ));
    }
    if !demos::list().any(|(known, _)| known == name) {
        let known: Vec<&str> = demos::list().map(|(known, _)| known).collect();
        return Err(Failure::usage(
            format!("unknown demo `{name}`"),
            format!("choose from {}", known.join(", ")),
        ));
    }
    let destination = Destination::new(output)?;
    let mut stage = Stage::new(&destination)?;
    let demo =
        demos::demo(name, demos::DEFAULT_SIZE).map_err(|e| Failure::internal(e.to_string()))?;
    let picture = &demo.image;
    texmap_io::image_io::write_png(
        &stage.add(destination, "png"),
        picture.width(),
        picture.height(),
        picture.rgba(),
    )?;
    stage.commit()?;
    for claim in &demo.claims {
        say(&format!("{claim}\n"));
    }
    let failed = demo.claims.iter().filter(|c| !c.holds()).count();
    say(&format!(
        "{}: {} x {} pixels, {} of {} claims hold\n",
        output.display(),
        picture.width(),
        picture.height(),
        demo.claims.len() - failed,
        demo.claims.len(),
    ));
    if args.json {
        failure::print_json(&DemoReport {
            demo: name,
            output: output.display().to_string(),
            captions: &demo.captions,
            claims: demo.claims.iter().map(ClaimReport::from).collect(),
        });
    }
    Ok(if failed == 0 {
        Exit::Done
    } else {
        Exit::Differs
    })
}

fn list(json: bool) {
    if json {
        let all: Vec<Listed> = demos::list()
            .map(|(name, shows)| Listed { name, shows })
            .collect();
        failure::print_json(&all);
    } else {
        let width = demos::list().map(|(name, _)| name.len()).max().unwrap_or(0);
        for (name, shows) in demos::list() {
            failure::print(&format!("{name:width$}  {shows}\n"));
        }
    }
}

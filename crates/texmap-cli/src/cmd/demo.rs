//! `texmap demo`: the captioned pictures that prove their claims.

use std::path::{Path, PathBuf};

use clap::Args;
use serde::Serialize;
use texmap_io::PictureFormat;
use texmap_lab::demos::{self, Claim, MovingSpot};

use crate::cmd::render::plan::numbered;
use crate::failure::{self, Exit, Failure, say};
use crate::formats;
use crate::output::{Destination, Stage};
use crate::picture;

/// Draw a captioned side-by-side picture and check the numbers it claims.
#[derive(Args, Debug)]
#[command(after_help = "Exit code 1 when a claim fails; the picture is written all the same.")]
pub(crate) struct DemoArgs {
    /// Name of the demo; --list prints all names
    #[arg(required_unless_present = "list")]
    name: Option<String>,
    /// The picture to write: the ending says its format; `-` is a PNG on standard output
    #[arg(short, long, value_name = "OUT", required_unless_present = "list")]
    output: Option<PathBuf>,
    /// Write the demo as so many numbered pictures, each checked: `-o spot%02d.png` (light-maps has frames)
    #[arg(long, value_name = "N", conflicts_with = "list", value_parser = clap::value_parser!(u32).range(1..=10_000))]
    frames: Option<u32>,
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
        list(args.json)?;
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
    let format = formats::picture("-o", output)?;
    if let Some(count) = args.frames {
        return frames(args, name, output, count, format);
    }
    let destination = Destination::new(output)?;
    let mut stage = Stage::new(&destination)?;
    let demo = demos::demo(name, demos::DEFAULT_SIZE).map_err(Failure::from)?;
    let image = &demo.image;
    let file = stage.add(destination, format.ending());
    let lost = picture::write(&file, format, image)?;
    stage.commit()?;
    formats::warn(output, format, lost);
    let exit = tell(args, name, output, &demo.captions, &demo.claims)?;
    say(&format!(
        "{}: {} x {} pixels\n",
        output.display(),
        image.width(),
        image.height(),
    ));
    Ok(exit)
}

/// Prints each claim; true if all hold.
fn tell(
    args: &DemoArgs,
    name: &str,
    output: &Path,
    captions: &[String],
    claims: &[Claim],
) -> Result<Exit, Failure> {
    for claim in claims {
        say(&format!("{claim}\n"));
    }
    let held = claims.iter().filter(|c| c.holds()).count();
    say(&format!("{held} of {} claims hold\n", claims.len()));
    if args.json {
        failure::print_json(&DemoReport {
            demo: name,
            output: output.display().to_string(),
            captions,
            claims: claims.iter().map(ClaimReport::from).collect(),
        })?;
    }
    Ok(if held == claims.len() {
        Exit::Done
    } else {
        Exit::Differs
    })
}

/// A demo that moves: numbered pictures, all or none.
fn frames(
    args: &DemoArgs,
    name: &str,
    output: &Path,
    count: u32,
    format: PictureFormat,
) -> Result<Exit, Failure> {
    if name != "light-maps" {
        return Err(Failure::usage(
            format!("the demo `{name}` has no frames"),
            "light-maps has: a spotlight that moves over a baked room",
        ));
    }
    let names: Option<Vec<PathBuf>> = (0..count).map(|n| numbered(output, n)).collect();
    let Some(names) = names else {
        return Err(Failure::usage(
            format!("{}: no place for the number of a frame", output.display()),
            "put %02d into the name: -o spot%02d.png",
        ));
    };
    let places: Vec<Destination> = names
        .iter()
        .map(|path| Destination::new(path))
        .collect::<Result<_, _>>()?;
    let mut stage = Stage::new(&places[0])?;
    let internal = |e: texmap_lab::LabError| Failure::from(e);
    let round = MovingSpot::new(demos::DEFAULT_SIZE).map_err(internal)?;
    let mut claims = Vec::new();
    for (number, place) in (0..count).zip(places) {
        let (image, claim) = round.frame(number, count).map_err(internal)?;
        let path = stage.add(place, format.ending());
        picture::write(&path, format, &image)?;
        claims.push(claim);
    }
    stage.commit()?;
    tell(args, name, output, &[], &claims)
}

fn list(json: bool) -> Result<(), Failure> {
    if json {
        let all: Vec<Listed> = demos::list()
            .map(|(name, shows)| Listed { name, shows })
            .collect();
        failure::print_json(&all)?;
    } else {
        let width = demos::list().map(|(name, _)| name.len()).max().unwrap_or(0);
        for (name, shows) in demos::list() {
            failure::print(&format!("{name:width$}  {shows}\n"))?;
        }
    }
    Ok(())
}

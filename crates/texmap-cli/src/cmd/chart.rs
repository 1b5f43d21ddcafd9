//! `texmap chart`: speed against accuracy, measured on this machine.

use std::path::{Path, PathBuf};

use clap::Args;
use texmap_lab::LabError;
use texmap_lab::cases::{self, Outcome};
use texmap_lab::chart::time::Effort;
use texmap_lab::chart::{self, Machine, Panel};

use crate::cmd::Root;
use crate::cmd::written::{Written, one_stdout};
use crate::failure::{Exit, Failure, say};
use crate::formats;
use crate::output::{Destination, Stage, distinct};
use crate::progress::Progress;
use crate::values::Resolution;

/// Chart speed against accuracy: every method, or your own scene with every filter.
#[derive(Args, Debug)]
#[command(
    after_help = "Writes one HTML page that needs nothing else, with the picture behind each point and the stability table. Times are of \
                  one thread; leave the machine alone meanwhile.\n\n\
                  All methods: texmap chart --quick -o chart.html\n\
                  Own scene:   texmap chart room.scene -o room.html"
)]
pub(crate) struct ChartArgs {
    /// A scene or model to chart instead of the six panels
    scene: Option<PathBuf>,
    /// The .html page, or the .csv of all points
    #[arg(short, long, value_name = "OUT", required = true)]
    output: Vec<PathBuf>,
    /// A folder for an .svg of each chart
    #[arg(long, value_name = "FOLDER")]
    svg: Option<PathBuf>,
    /// The table of prices that the planner reads, to be committed
    #[arg(long, value_name = "OUT.csv", conflicts_with = "scene")]
    prices: Option<PathBuf>,
    /// Fewer runs and samples: under a minute
    #[arg(long)]
    quick: bool,
    /// Size of the scene's picture
    #[arg(
        short,
        long,
        value_name = "WxH",
        default_value = "320x240",
        requires = "scene"
    )]
    resolution: Resolution,
    #[command(flatten)]
    root: Root,
    /// Print a report as JSON to standard output
    #[arg(long)]
    pub(crate) json: bool,
}

pub(crate) fn run(args: &ChartArgs) -> Result<Exit, Failure> {
    let internal = |e: LabError| Failure::from(e);
    for output in &args.output {
        one_stdout(args.json, output)?;
    }
    let chart = args.svg.iter().map(|folder| folder.join("chart.svg"));
    let outputs = args.output.iter().chain(&args.prices).cloned();
    let named: Vec<PathBuf> = outputs.chain(chart).collect();
    distinct(&named, &args.scene)?;
    let mut outputs = Vec::new();
    for path in &args.output {
        outputs.push((Kind::of(path)?, Destination::new(path)?));
    }
    if let Some(path) = &args.prices {
        formats::ending("--prices", path, &["csv"])?;
    }
    // Outputs that cannot be written are refused before anything is measured.
    let charts = args.svg.as_ref().map(|folder| folder.join("chart.svg"));
    for path in charts.iter().chain(&args.prices) {
        Stage::new(&Destination::new(path)?)?;
    }
    let first = outputs[0].1.clone();
    let mut stage = Stage::new(&first)?;
    let effort = if args.quick {
        Effort::QUICK
    } else {
        Effort::FULL
    };
    let progress = Progress::new("chart");
    let mut report = |done: usize, of: usize, _: &str| progress.update(done, of);
    let panels: Vec<Panel> = match &args.scene {
        Some(path) => {
            let files = args.root.files()?;
            let options = texmap_io::LoadOptions {
                files: files.clone(),
                ..texmap_io::LoadOptions::default()
            };
            let scene = texmap_io::load(path, &options)?;
            distinct(&named, files.recorded())?;
            let size = (args.resolution.width, args.resolution.height);
            let panel = chart::scene_panel(&scene, size, effort, &mut report).map_err(|e| {
                Failure::new(
                    Exit::Input,
                    "scene",
                    format!("{}: {e}", path.display()),
                    "`texmap render` says more about a scene that it refuses",
                )
            })?;
            vec![panel]
        }
        None => chart::panels(effort, &mut report).map_err(internal)?,
    };
    drop(progress);
    let text = |kind: Kind| match kind {
        Kind::Csv => Ok(chart::csv(&panels)),
        Kind::Html => {
            let all = cases::all().map_err(internal)?;
            let outcomes: Vec<Outcome> = all
                .iter()
                .map(Outcome::of)
                .collect::<Result<_, _>>()
                .map_err(internal)?;
            let how = format!(
                "Each method ran {} times, in turns, at least {} microseconds each{}",
                effort.rounds,
                effort.run.as_micros(),
                if args.quick {
                    " (quick: figures for a first look)."
                } else {
                    "."
                },
            );
            chart::page(&panels, &outcomes, &Machine::here(), &how).map_err(internal)
        }
    };
    for (kind, destination) in outputs {
        let ending = if kind == Kind::Csv { "csv" } else { "html" };
        write(&stage.add(destination, ending), &text(kind)?)?;
    }
    if let Some(folder) = &args.svg {
        for chart in panels.iter().flat_map(|p| &p.charts) {
            let destination = Destination::new(&folder.join(format!("{}.svg", chart.id)))?;
            let picture = chart::svg(chart).map_err(internal)?;
            write(&stage.add(destination, "svg"), &picture)?;
        }
    }
    if let Some(path) = &args.prices {
        let destination = Destination::new(path)?;
        write(&stage.add(destination, "csv"), &chart::prices(&panels))?;
    }
    stage.commit()?;
    let points: usize = panels
        .iter()
        .flat_map(|p| &p.charts)
        .map(|c| c.points.len())
        .sum();
    say(&format!("{points} points written\n"));
    let mut written = Written::new("chart");
    for path in args.output.iter().chain(&args.prices) {
        written.text(path);
    }
    if let Some(folder) = &args.svg {
        for chart in panels.iter().flat_map(|p| &p.charts) {
            written.text(&folder.join(format!("{}.svg", chart.id)));
        }
    }
    written.tell(args.json)
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Html,
    Csv,
}

impl Kind {
    fn of(path: &Path) -> Result<Self, Failure> {
        Ok(match formats::ending("-o", path, &["html", "csv"])? {
            "csv" => Self::Csv,
            _ => Self::Html,
        })
    }
}

fn write(path: &Path, text: &str) -> Result<(), Failure> {
    std::fs::write(path, text).map_err(|e| {
        Failure::new(
            Exit::Input,
            "write-failed",
            format!("{}: {e}", path.display()),
            "check the permissions and the free space",
        )
    })
}

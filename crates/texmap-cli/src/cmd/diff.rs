//! `texmap diff`: the figures of two images, and whether they are equal enough.

use std::path::PathBuf;

use clap::Args;
use serde::Serialize;
use texmap_lab::buffer::Buffer;
use texmap_lab::metrics::{Metrics, Place};

use crate::failure::{self, Exit, Failure};
use crate::output::{Destination, Stage, distinct};

/// Compare two images or .npy arrays: figures, PASS or FAIL.
#[derive(Args, Debug)]
#[command(
    after_help = "Without a limit every difference fails. Values of images are 0 to 1. Exit code 1 on FAIL."
)]
pub(crate) struct DiffArgs {
    /// What is expected
    expected: PathBuf,
    /// What is compared with it
    actual: PathBuf,
    /// Fail when a value differs by more; 0.004 is one code value of an 8-bit image
    #[arg(long, value_name = "X", value_parser = limit)]
    fail_max: Option<f64>,
    /// Fail when the root of the mean squared difference is more
    #[arg(long, value_name = "X", value_parser = limit)]
    fail_rms: Option<f64>,
    /// Write the differences as a heat picture, white at the largest
    #[arg(long, value_name = "OUT")]
    heat: Option<PathBuf>,
    /// Print the figures as JSON to standard output
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Serialize)]
struct Report {
    pass: bool,
    expected: String,
    actual: String,
    width: usize,
    height: usize,
    channels: usize,
    mean: f64,
    rms: f64,
    /// Absent for equal images, whose ratio is infinite.
    psnr: Option<f64>,
    p999: f64,
    max: f64,
    max_at: Option<At>,
    /// Absent when no single value can fail.
    limit: Option<f64>,
    over_limit: usize,
    non_finite: usize,
    non_finite_at: Option<At>,
}

#[derive(Serialize)]
struct At {
    x: usize,
    y: usize,
    channel: usize,
}

impl From<Place> for At {
    fn from(place: Place) -> Self {
        Self {
            x: place.x,
            y: place.y,
            channel: place.channel,
        }
    }
}

fn limit(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value >= 0.0 => Ok(value),
        _ => Err("give a number of at least 0".to_owned()),
    }
}

pub(crate) fn run(args: &DiffArgs) -> Result<Exit, Failure> {
    distinct(&args.heat, [&args.expected, &args.actual])?;
    let heat = args.heat.as_deref().map(Destination::new).transpose()?;
    if args.json && heat == Some(Destination::Stdout) {
        return Err(Failure::usage(
            "--heat - and --json do not go together",
            "name a file",
        ));
    }
    let (expected, actual) = (Buffer::read(&args.expected)?, Buffer::read(&args.actual)?);
    let (e, a) = (expected.shape, actual.shape);
    if e != a {
        let words = "the images differ in size";
        let size = |s: texmap_lab::metrics::Shape| {
            format!("{} x {} with {} channels", s.width, s.height, s.channels)
        };
        let why = format!(
            "{} is {}, {} is {}",
            args.expected.display(),
            size(e),
            args.actual.display(),
            size(a)
        );
        return Err(Failure::new(Exit::Differs, "size", words, why));
    }
    // With a limit on the root mean square alone, no single value fails.
    let limit = args.fail_max.unwrap_or(if args.fail_rms.is_some() {
        f64::INFINITY
    } else {
        0.0
    });
    let metrics = actual.compare(&expected, limit).map_err(|error| {
        Failure::new(
            Exit::Input,
            "empty",
            error.to_string(),
            "name files that hold values",
        )
    })?;
    let pass = metrics.passes() && args.fail_rms.is_none_or(|most| metrics.rmse <= most);
    if let Some(destination) = heat {
        texmap_math::MemoryBudget::of_process().ask(
            (e.width as u64)
                .saturating_mul(e.height as u64)
                .saturating_mul(4),
            format_args!("a heat map of {} x {} pixels", e.width, e.height),
            "leave --heat out",
        )?;
        let white = if metrics.max > 0.0 { metrics.max } else { 1.0 };
        let picture = actual.heat(&expected, white).ok_or_else(|| {
            Failure::new(
                Exit::Input,
                "size",
                "the arrays are too large for a picture",
                "leave --heat out",
            )
        })?;
        let mut stage = Stage::new(&destination)?;
        let file = stage.add(destination, "png");
        texmap_io::image_io::write_png(&file, picture.width(), picture.height(), picture.rgba())?;
        stage.commit()?;
    }
    let peak = expected.peak.max(actual.peak);
    if args.json {
        failure::print_json(&report(args, &expected, &metrics, peak, limit, pass))?;
    } else {
        failure::print(&words(&expected, &actual, &metrics, peak, limit, pass))?;
    }
    Ok(if pass { Exit::Done } else { Exit::Differs })
}

fn words(
    expected: &Buffer,
    actual: &Buffer,
    m: &Metrics,
    peak: f64,
    limit: f64,
    pass: bool,
) -> String {
    let at = |place: Option<Place>| {
        place.map_or_else(String::new, |p| {
            let index = (p.y * expected.shape.width + p.x) * expected.shape.channels + p.channel;
            let (e, a) = (expected.value(index), actual.value(index));
            format!(
                " at x {}, y {}, channel {}: {e} against {a}",
                p.x, p.y, p.channel
            )
        })
    };
    let mut text = format!(
        "mean  {}\nRMS   {}\nPSNR  {:.2} dB\n99.9% {}\nmax   {}{}\n",
        m.mean,
        m.rmse,
        m.psnr(peak),
        m.p999,
        m.max,
        at(m.max_at),
    );
    if limit.is_finite() {
        text.push_str(&format!(
            "over  {} of {} values differ by more than {limit}\n",
            m.over_limit, m.compared
        ));
    }
    if m.non_finite > 0 {
        text.push_str(&format!(
            "holes {} values are finite in one only{}\n",
            m.non_finite,
            at(m.non_finite_at)
        ));
    }
    text + if pass { "PASS\n" } else { "FAIL\n" }
}

fn report(
    args: &DiffArgs,
    expected: &Buffer,
    m: &Metrics,
    peak: f64,
    limit: f64,
    pass: bool,
) -> Report {
    let psnr = m.psnr(peak);
    Report {
        pass,
        expected: args.expected.display().to_string(),
        actual: args.actual.display().to_string(),
        width: expected.shape.width,
        height: expected.shape.height,
        channels: expected.shape.channels,
        mean: m.mean,
        rms: m.rmse,
        psnr: psnr.is_finite().then_some(psnr),
        p999: m.p999,
        max: m.max,
        max_at: m.max_at.map(At::from),
        limit: limit.is_finite().then_some(limit),
        over_limit: m.over_limit,
        non_finite: m.non_finite,
        non_finite_at: m.non_finite_at.map(At::from),
    }
}

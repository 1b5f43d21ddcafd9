//! `texmap diff`: the differences of two images, and their judgement by limits.

use std::path::PathBuf;

use clap::Args;
use serde::Serialize;
use texmap_truth::buffer::{Buffer, Comparison, Meaning};
use texmap_truth::metrics::{Metrics, Place, Shape};

use crate::digits::digits;
use crate::failure::{self, Exit, Failure};
use crate::formats;
use crate::output::{Destination, Stage, distinct};
use crate::picture;

/// Compare two images or .npy arrays: figures, PASS or FAIL.
///
/// Figures of images are those of red, green and blue; alpha has its own, and must pass as well. SSIM is the mean structural
/// similarity in windows of 11 x 11 pixels (1 for equal images).
#[derive(Args, Debug)]
#[command(
    after_help = "Without a limit every difference fails. Values of images are 0 to 1; those of HDR and EXR are their linear light, \
                  and PSNR and SSIM take the largest of both images as the range. A NaN in one of the two fails; one in both is a hole. \
                  Exit code 1 on FAIL."
)]
pub(crate) struct DiffArgs {
    /// The expected image or array
    expected: PathBuf,
    /// The image or array to judge
    actual: PathBuf,
    /// Fail when a value differs by more; 0.004 is one code value of an 8-bit image
    #[arg(long, value_name = "X", value_parser = limit)]
    fail_max: Option<f64>,
    /// Fail when the root of the mean squared difference is more
    #[arg(long, value_name = "X", value_parser = limit)]
    fail_rms: Option<f64>,
    /// Write the differences as a heat picture, white at the largest; the ending says the format
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
    /// Channels of the files; the figures of images are those of three.
    channels: usize,
    #[serde(flatten)]
    values: Figures,
    /// Absent for equal images, whose ratio is infinite.
    psnr: Option<f64>,
    /// Absent for images smaller than its window.
    ssim: Option<f64>,
    /// Absent when no single value can fail.
    limit: Option<f64>,
    /// Absent for arrays, and where both images are opaque.
    alpha: Option<Figures>,
    /// About the heat picture.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    warnings: Vec<String>,
}

#[derive(Serialize)]
struct Figures {
    mean: f64,
    rms: f64,
    p999: f64,
    max: f64,
    max_at: Option<At>,
    over_limit: usize,
    non_finite: usize,
    non_finite_at: Option<At>,
    holes: usize,
}

impl From<&Metrics> for Figures {
    fn from(m: &Metrics) -> Self {
        Self {
            mean: m.mean,
            rms: m.rmse,
            p999: m.p999,
            max: m.max,
            max_at: m.max_at.map(At::from),
            over_limit: m.over_limit,
            non_finite: m.non_finite,
            non_finite_at: m.non_finite_at.map(At::from),
            holes: m.holes,
        }
    }
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
    let format = args
        .heat
        .as_deref()
        .map(|path| formats::picture("--heat", path))
        .transpose()?;
    distinct(&args.heat, [&args.expected, &args.actual])?;
    let heat = args.heat.as_deref().map(Destination::new).transpose()?;
    if args.json && heat == Some(Destination::Stdout) {
        return Err(Failure::usage(
            "--heat - and --json do not go together",
            "name a file",
        ));
    }
    let (expected, actual) = (Buffer::read(&args.expected)?, Buffer::read(&args.actual)?);
    comparable(args, &expected, &actual)?;
    // With a limit on the root mean square alone, no single value fails.
    let limit = args.fail_max.unwrap_or(if args.fail_rms.is_some() {
        f64::INFINITY
    } else {
        0.0
    });
    let found = actual.compare(&expected, limit).map_err(|error| {
        Failure::new(
            Exit::Input,
            "empty",
            error.to_string(),
            "name files that hold values",
        )
    })?;
    let parts = || [Some(found.values), found.alpha].into_iter().flatten();
    let rms_fits = |part: Metrics| args.fail_rms.is_none_or(|most| part.rmse <= most);
    let pass = found.passes() && parts().all(rms_fits);
    let mut warnings = Vec::new();
    if let Some((destination, format)) = heat.zip(format) {
        texmap_math::MemoryBudget::of_process().ask(
            (expected.shape.width as u64)
                .saturating_mul(expected.shape.height as u64)
                .saturating_mul(4),
            format_args!(
                "a heat map of {} x {} pixels",
                expected.shape.width, expected.shape.height
            ),
            "leave --heat out",
        )?;
        let most = parts().map(|part| part.max).fold(0.0, f64::max);
        let white = if most > 0.0 { most } else { 1.0 };
        let picture = actual.heat(&expected, white).ok_or_else(|| {
            Failure::new(
                Exit::Input,
                "size",
                "the arrays are too large for a picture",
                "leave --heat out",
            )
        })?;
        let mut stage = Stage::new(&destination)?;
        let file = stage.add(destination, format.ending());
        let lost = picture::write(&file, format, &picture)?;
        stage.commit()?;
        if let Some(path) = &args.heat {
            warnings = formats::warn(path, format, lost);
        }
    }
    let psnr = found.values.psnr(expected.peak.max(actual.peak));
    if args.json {
        failure::print_json(&Report {
            pass,
            expected: args.expected.display().to_string(),
            actual: args.actual.display().to_string(),
            width: expected.shape.width,
            height: expected.shape.height,
            channels: expected.shape.channels,
            values: Figures::from(&found.values),
            psnr: psnr.is_finite().then_some(psnr),
            ssim: found.ssim,
            limit: limit.is_finite().then_some(limit),
            alpha: found.alpha.as_ref().map(Figures::from),
            warnings,
        })?;
    } else {
        failure::print(&words(&expected, &actual, &found, psnr, limit, pass))?;
    }
    Ok(if pass { Exit::Done } else { Exit::Differs })
}

/// Refuses files without common values: other sizes, codes against light.
fn comparable(args: &DiffArgs, expected: &Buffer, actual: &Buffer) -> Result<(), Failure> {
    let names = (args.expected.display(), args.actual.display());
    let (e, a) = (expected.shape, actual.shape);
    if e != a {
        let size = |s: Shape| format!("{} x {} with {} channels", s.width, s.height, s.channels);
        return Err(Failure::new(
            Exit::Differs,
            "size",
            "the images differ in size",
            format!("{} is {}, {} is {}", names.0, size(e), names.1, size(a)),
        ));
    }
    // An axis of one tells nothing apart.
    let long = |buffer: &Buffer| -> Vec<usize> {
        let axes = buffer.axes().iter().copied();
        axes.filter(|length| *length != 1).collect()
    };
    if long(expected) != long(actual) {
        let axes = |buffer: &Buffer| {
            let axes: Vec<String> = buffer.axes().iter().map(usize::to_string).collect();
            format!("({})", axes.join(", "))
        };
        return Err(Failure::new(
            Exit::Differs,
            "size",
            "the arrays differ in shape",
            format!(
                "{} is {}, {} is {}",
                names.0,
                axes(expected),
                names.1,
                axes(actual)
            ),
        ));
    }
    let holds = |meaning| match meaning {
        Meaning::Codes => Some("sRGB codes"),
        Meaning::Light => Some("linear light"),
        Meaning::Array => None,
    };
    match (holds(expected.meaning()), holds(actual.meaning())) {
        (Some(e), Some(a)) if e != a => Err(Failure::new(
            Exit::Differs,
            "kind",
            "the images hold values of unlike kinds",
            format!(
                "{} holds {e}, {} {a}; write both in one format, for instance with `texmap warp IN -o OUT.exr --filter nearest`",
                names.0, names.1
            ),
        )),
        _ => Ok(()),
    }
}

fn words(
    expected: &Buffer,
    actual: &Buffer,
    found: &Comparison,
    psnr: f64,
    limit: f64,
    pass: bool,
) -> String {
    let at = |place: Option<Place>| {
        place.map_or_else(String::new, |p| {
            let index = (p.y * expected.shape.width + p.x) * expected.shape.channels + p.channel;
            let (e, a) = (expected.value(index), actual.value(index));
            format!(
                " at x {}, y {}, channel {}: {} against {}",
                p.x,
                p.y,
                p.channel,
                digits(e),
                digits(a)
            )
        })
    };
    let m = &found.values;
    let ssim = found.ssim.map_or_else(
        || "none: it needs 11 x 11 pixels without holes".to_owned(),
        digits,
    );
    let mut text = format!(
        "mean  {}\nRMS   {}\nPSNR  {} dB\nSSIM  {ssim}\n99.9% {}\nmax   {}{}\n",
        digits(m.mean),
        digits(m.rmse),
        digits(psnr),
        digits(m.p999),
        digits(m.max),
        at(m.max_at),
    );
    if let Some(alpha) = &found.alpha {
        text.push_str(&format!(
            "alpha mean {}, RMS {}, 99.9% {}, max {}{}\n",
            digits(alpha.mean),
            digits(alpha.rmse),
            digits(alpha.p999),
            digits(alpha.max),
            at(alpha.max_at),
        ));
    }
    let parts = [Some(m), found.alpha.as_ref()];
    for (part, of) in parts.into_iter().flatten().zip(["", " of alpha"]) {
        if limit.is_finite() {
            text.push_str(&format!(
                "over  {} of {} values{of} differ by more than {limit}\n",
                part.over_limit, part.compared
            ));
        }
        if part.holes > 0 {
            text.push_str(&format!(
                "NaN   {} values{of} are not finite in both\n",
                part.holes
            ));
        }
        if part.non_finite > 0 {
            text.push_str(&format!(
                "NaN   {} values{of} are not finite in one of the two{}\n",
                part.non_finite,
                at(part.non_finite_at)
            ));
        }
    }
    text + if pass { "PASS\n" } else { "FAIL\n" }
}

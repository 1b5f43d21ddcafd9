//! The words of environments: `env`, and the file, chart and number that `specmap` shares with it.

use texmap_light::Chart;

use super::{Effect, none};
use crate::IoError;
use crate::scene_file::args::Args;
use crate::scene_file::print::{floats, texture_name, word};

/// An `env` line.
#[derive(Debug, Clone, PartialEq)]
pub struct EnvironmentLine {
    /// The picture.
    pub file: String,
    /// How it shows all directions.
    pub chart: Chart,
    /// Share of the mirrored light, 0 to 1.
    pub share: f32,
    /// With smaller levels for small pictures of large parts of it.
    pub mips: bool,
}

pub(super) fn parse(args: &Args<'_>) -> Result<Effect, IoError> {
    if args.len() == 1 && none(args) {
        return Ok(Effect::Environment(None));
    }
    args.within(3, 4, "none, or FILE CHART share [mips]")?;
    let mips = args.len() == 4;
    if mips && args.text(3) != "mips" {
        return Err(args.unknown(3, "mips"));
    }
    let share = |x| (0.0..=1.0).contains(&x);
    let (file, chart, share) = chart_values(args, "a share of 0 to 1", share)?;
    Ok(Effect::Environment(Some(EnvironmentLine {
        file,
        chart,
        share,
        mips,
    })))
}

pub(in crate::scene_file) const CHARTS: &str =
    "cube, tan-cube, lat-long, octahedron, equal-area-octahedron, dual-paraboloid, sphere-map";

/// `FILE CHART number`.
pub(super) fn chart_values(
    args: &Args<'_>,
    allowed: &'static str,
    valid: impl Fn(f32) -> bool,
) -> Result<(String, Chart, f32), IoError> {
    args.check(0, !args.text(0).is_empty(), "a file name that is not empty")?;
    let chart = args.text(1).parse().map_err(|_| args.unknown(1, CHARTS))?;
    let [x] = args.floats(2)?;
    args.check(2, valid(x), allowed)?;
    Ok((args.text(0).to_owned(), chart, x))
}

/// The values after the word.
pub(super) fn print(out: &mut String, line: &EnvironmentLine) {
    chart_words(out, &line.file, line.chart, line.share);
    if line.mips {
        word(out, "mips");
    }
}

pub(super) fn chart_words(out: &mut String, file: &str, chart: Chart, x: f32) {
    texture_name(out, file);
    word(out, chart.name());
    floats(out, &[x]);
}

#[cfg(test)]
mod tests {
    use crate::scene_file::Command;
    use crate::scene_file::parse::{assert_faults, assert_reads_back};

    #[test]
    fn every_environment_reads_back() {
        assert_reads_back(
            |c| matches!(c, Command::Effect(_)),
            &[
                "env sky.hdr lat-long 0.5 mips\n",
                "env sky.hdr lat-long 0.5\n",
                "env none\n",
            ],
        );
    }

    #[test]
    fn faults_have_their_columns() {
        assert_faults(&[
            ("env a.png cube 1 levels", "unknown-word", 18),
            ("env a.png cube", "argument-count", 1),
            ("env a.png ball 1", "unknown-word", 11),
            ("env a.png cube 2", "out-of-range", 16),
        ]);
    }
}

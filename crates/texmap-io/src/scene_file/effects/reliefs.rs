//! The words of bumps that no height map brings: `offsetmap carve emboss`.

use texmap_light::Green;

use super::{file, none};
use crate::IoError;
use crate::scene_file::args::Args;
use crate::scene_file::print::{floats, number, numbers, texture_name, word};

/// A line about bumps.
#[derive(Debug, Clone, PartialEq)]
pub enum ReliefLine {
    /// `offsetmap FILE slope [up|down]`.
    Offsets {
        /// The map.
        file: String,
        /// Change of the height over the picture where a channel is 1.
        slope: f32,
        /// Which way the height rises where green is more than half.
        green: Green,
    },
    /// `carve waves|noise|marble|wood height x y z sx sy sz [around N] [octaves N] [fold X]`.
    Carve(CarveLine),
    /// `emboss WORDS height`.
    Emboss {
        /// What is written, over all of the coordinates.
        words: String,
        /// Of the letters.
        height: f32,
    },
}

/// A `carve` line.
#[derive(Debug, Clone, PartialEq)]
pub struct CarveLine {
    /// The formula.
    pub formula: Formula,
    /// Height of 1 over 0.
    pub height: f32,
    /// The origin of the formula.
    pub origin: [f64; 3],
    /// Width, height and depth of its unit; none is 0.
    pub size: [f64; 3],
    /// `around N`: waves around.
    pub around: u16,
    /// `octaves N`, 1 to 16: of noise and marble.
    pub octaves: u8,
    /// `fold X`: of waves as a share of one, turbulence of marble, grain of wood.
    pub fold: Option<f32>,
}

/// The first value of a `carve` line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Formula {
    /// `waves`, in cylindrical space.
    Waves,
    /// `noise`.
    Noise,
    /// `marble`.
    Marble,
    /// `wood`.
    Wood,
}

const FORMULAS: [(&str, Formula); 4] = [
    ("waves", Formula::Waves),
    ("noise", Formula::Noise),
    ("marble", Formula::Marble),
    ("wood", Formula::Wood),
];

/// Where a line names none.
const AROUND: u16 = 12;
const OCTAVES: u8 = 4;

/// The values of `offsetmap`, `carve` or `emboss`; `None` for `none`.
pub(super) fn parse(args: &Args<'_>) -> Result<Option<ReliefLine>, IoError> {
    if args.len() == 1 && none(args) {
        return Ok(None);
    }
    match args.command {
        "offsetmap" => {
            args.within(2, 3, "none, or FILE slope [up|down]")?;
            let [slope] = args.floats(1)?;
            let green = match args.text(2) {
                "" | "up" => Green::Up,
                "down" => Green::Down,
                _ => return Err(args.unknown(2, "up, down")),
            };
            let offsets = |file| ReliefLine::Offsets { file, slope, green };
            Ok(file(args)?.map(offsets))
        }
        "emboss" => {
            args.exactly(
                2,
                "none, or WORDS (in quotes if there are several) and height",
            )?;
            let written = !args.text(0).trim().is_empty();
            args.check(0, written, "words that are not blank")?;
            let [height] = args.floats(1)?;
            let words = args.text(0).to_owned();
            Ok(Some(ReliefLine::Emboss { words, height }))
        }
        _ => carve(args).map(|line| Some(ReliefLine::Carve(line))),
    }
}

fn carve(args: &Args<'_>) -> Result<CarveLine, IoError> {
    const ALLOWED: &str = "none; or waves, noise, marble or wood with height, x y z, sx sy sz [around N] [octaves N] [fold X]";
    if args.len() < 8 || !args.len().is_multiple_of(2) {
        return Err(args.count_error(ALLOWED));
    }
    let formula = FORMULAS.iter().find(|(name, _)| *name == args.text(0));
    let Some((_, formula)) = formula else {
        return Err(args.unknown(0, "waves, noise, marble, wood"));
    };
    let size: [f64; 3] = args.numbers(5)?;
    for (i, side) in size.iter().enumerate() {
        args.check(5 + i, *side != 0.0, "a number that is not 0")?;
    }
    let [height] = args.floats(1)?;
    let mut line = CarveLine {
        formula: *formula,
        height,
        origin: args.numbers(2)?,
        size,
        around: AROUND,
        octaves: OCTAVES,
        fold: None,
    };
    let whole = |i: usize, most: f64, allowed| -> Result<f64, IoError> {
        let [x] = args.numbers(i)?;
        args.check(i, x.fract() == 0.0 && (1.0..=most).contains(&x), allowed)?;
        Ok(x)
    };
    for i in (8..args.len()).step_by(2) {
        match args.text(i) {
            "around" => line.around = whole(i + 1, 65_535.0, "a whole number, 1 to 65535")? as u16,
            "octaves" => line.octaves = whole(i + 1, 16.0, "a whole number, 1 to 16")? as u8,
            "fold" => {
                let [fold] = args.floats(i + 1)?;
                line.fold = Some(fold);
            }
            _ => return Err(args.unknown(i, "around N, octaves N, fold X")),
        }
    }
    Ok(line)
}

impl ReliefLine {
    pub(super) fn word(&self) -> &'static str {
        match self {
            Self::Offsets { .. } => "offsetmap",
            Self::Carve(_) => "carve",
            Self::Emboss { .. } => "emboss",
        }
    }
}

/// The values after the word.
pub(super) fn print(out: &mut String, line: &ReliefLine) {
    match line {
        ReliefLine::Offsets { file, slope, green } => {
            texture_name(out, file);
            floats(out, &[*slope]);
            if *green == Green::Down {
                word(out, "down");
            }
        }
        ReliefLine::Emboss { words, height } => {
            word(out, &format!("\"{words}\""));
            floats(out, &[*height]);
        }
        ReliefLine::Carve(line) => {
            let named = FORMULAS.iter().find(|(_, f)| *f == line.formula);
            word(out, named.map_or("waves", |(name, _)| name));
            floats(out, &[line.height]);
            numbers(out, &line.origin);
            numbers(out, &line.size);
            if line.around != AROUND {
                word(out, "around");
                number(out, f64::from(line.around));
            }
            if line.octaves != OCTAVES {
                word(out, "octaves");
                number(out, f64::from(line.octaves));
            }
            if let Some(fold) = line.fold {
                word(out, "fold");
                floats(out, &[fold]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::scene_file::parse::{assert_faults, assert_reads_back};
    use crate::scene_file::{Command, Effect, parse, print};
    use std::path::Path;

    #[test]
    fn every_relief_reads_back() {
        assert_reads_back(
            |c| matches!(c, Command::Effect(Effect::Relief(_))),
            &[
                "offsetmap dudv.png 0.5\n",
                "offsetmap dudv.png -0.5 down\n",
                "offsetmap \"none\" 1\n",
                "carve waves 0.02 0 1 0 1 0.25 1\n",
                "carve waves 0.02 0 1 0 1 0.25 1 around 20 fold 0.2\n",
                "carve noise -0.1 0 0 0 1 1 1 octaves 7\n",
                "carve marble 0.1 0 0 0 1 1 1 fold 2\n",
                "carve wood 0.1 0 0 0 1 1 1\n",
                "emboss \"CS 184\" 0.01\n",
            ],
        );
        for word in ["offsetmap", "carve", "emboss"] {
            let file = parse(Path::new("a.scene"), &format!("{word} none")).unwrap();
            assert_eq!(print(&file), "bump none\n");
        }
    }

    #[test]
    fn faults_have_their_columns() {
        assert_faults(&[
            ("offsetmap a.png", "argument-count", 1),
            ("offsetmap a.png 1 left", "unknown-word", 19),
            ("carve dots 1 0 0 0 1 1 1", "unknown-word", 7),
            ("carve waves 1 0 0 0 1 0 1", "out-of-range", 23),
            ("carve waves 1 0 0 0 1 1", "argument-count", 1),
            ("carve waves 1 0 0 0 1 1 1 around 0", "out-of-range", 34),
            ("carve noise 1 0 0 0 1 1 1 octaves 2.5", "out-of-range", 35),
            ("carve noise 1 0 0 0 1 1 1 bend 2", "unknown-word", 27),
            ("emboss \" \" 1", "out-of-range", 8),
            ("emboss A", "argument-count", 1),
        ]);
    }
}

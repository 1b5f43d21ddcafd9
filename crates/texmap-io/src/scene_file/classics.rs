//! The words of the small classics: `solid ramp cel decal font text sky volume`.

use texmap_light::Chart;

use super::args::Args;
use super::effects::{CHARTS, file, none};
use super::print::{floats, number, numbers, path, texture_name, word};
use crate::IoError;

/// A line about textures beyond pictures on faces.
#[derive(Debug, Clone, PartialEq)]
pub enum Classic {
    /// `solid marble|wood|noise|FILE x y z sx sy sz [octaves N] [fold X]`, or `solid none`.
    Solid(Option<SolidLine>),
    /// `ramp FILE`, or `ramp none`.
    Ramp(Option<String>),
    /// `cel FILE`, or `cel none`.
    Cel(Option<String>),
    /// `decal FILE [u v width height]`, or `decal none`.
    Decal(Option<(String, [f32; 4])>),
    /// `font FILE columns rows first`, or `font none`: the built-in one.
    Font(Option<(String, [u32; 3])>),
    /// `text WORDS x y z rx ry rz ux uy uz`.
    Text {
        /// What is written.
        words: String,
        /// Lower left corner of the first character.
        origin: [f64; 3],
        /// Its step to the next.
        right: [f64; 3],
        /// Its height.
        up: [f64; 3],
    },
    /// `sky FILE [CHART]`, or `sky none`.
    Sky(Option<(String, Option<Chart>)>),
    /// `volume FILE x y z sx sy sz density [step S]`.
    Volume {
        /// The grid.
        file: String,
        /// Middle of its box.
        middle: [f64; 3],
        /// Width, height and depth; none is 0.
        size: [f64; 3],
        /// Extinction of density 1 per unit of length.
        density: f32,
        /// Between look-ups; `None` is half a voxel.
        step: Option<f32>,
    },
}

/// A `solid` line.
#[derive(Debug, Clone, PartialEq)]
pub struct SolidLine {
    /// What it is made of.
    pub source: SolidSource,
    /// Middle of the box, or the origin of the pattern.
    pub middle: [f64; 3],
    /// Width, height and depth of the box, or of the pattern's unit; none is 0.
    pub size: [f64; 3],
    /// `octaves N`, 1 to 16: of noise and marble.
    pub octaves: u8,
    /// `fold X`: turbulence of marble, grain of wood, in units of the pattern.
    pub fold: Option<f32>,
}

/// The first value of a `solid` line.
#[derive(Debug, Clone, PartialEq)]
pub enum SolidSource {
    /// `marble`.
    Marble,
    /// `wood`.
    Wood,
    /// `noise`.
    Noise,
    /// A grid.
    File(String),
}

/// Octaves where a line names none.
const OCTAVES: u8 = 4;

/// `None` for words of others.
pub(super) fn parse(args: &Args<'_>) -> Result<Option<Classic>, IoError> {
    Ok(Some(match args.command {
        "solid" => Classic::Solid(solid(args)?),
        "ramp" | "cel" => {
            args.exactly(1, "none, or 1 file name")?;
            let file = file(args)?;
            match args.command {
                "ramp" => Classic::Ramp(file),
                _ => Classic::Cel(file),
            }
        }
        "decal" => {
            args.within(1, 5, "none, or FILE [u v width height]")?;
            let rect = match args.len() {
                1 => [0.0, 0.0, 1.0, 1.0],
                5 => args.floats(1)?,
                _ => return Err(args.count_error("none, or FILE [u v width height]")),
            };
            for i in 3..args.len() {
                args.check(i, rect[i - 1] != 0.0, "a number that is not 0")?;
            }
            Classic::Decal(file(args)?.map(|file| (file, rect)))
        }
        "font" if args.len() == 1 && none(args) => Classic::Font(None),
        "font" => {
            args.exactly(4, "none, or FILE columns rows first")?;
            let cells = [1, 2, 3].map(|i| whole(args, i, if i == 3 { 0 } else { 1 }));
            let [columns, rows, first] = cells;
            let cells = [columns?, rows?, first?];
            let count = u64::from(cells[0]) * u64::from(cells[1]);
            args.check(2, count <= 1 << 20, "at most 1048576 cells")?;
            Classic::Font(file(args)?.map(|file| (file, cells)))
        }
        "text" => text(args)?,
        "sky" => {
            args.within(1, 2, "none, or FILE [CHART]")?;
            let chart = match args.len() {
                2 => Some(args.text(1).parse().map_err(|_| args.unknown(1, CHARTS))?),
                _ => None,
            };
            Classic::Sky(file(args)?.map(|file| (file, chart)))
        }
        "volume" => volume(args)?,
        _ => return Ok(None),
    }))
}

fn whole(args: &Args<'_>, i: usize, least: u32) -> Result<u32, IoError> {
    let [x] = args.numbers::<1>(i)?;
    let fits = x.fract() == 0.0 && (f64::from(least)..=1_114_111.0).contains(&x);
    args.check(i, fits, "a whole number; of cells at least 1")?;
    Ok(x as u32)
}

fn size(args: &Args<'_>, first: usize) -> Result<[f64; 3], IoError> {
    let size = args.numbers(first)?;
    for (i, side) in size.iter().enumerate() {
        args.check(first + i, *side != 0.0, "a number that is not 0")?;
    }
    Ok(size)
}

fn solid(args: &Args<'_>) -> Result<Option<SolidLine>, IoError> {
    const ALLOWED: &str =
        "none; or marble, wood, noise or FILE with x y z sx sy sz [octaves N] [fold X]";
    if args.len() == 1 && none(args) {
        return Ok(None);
    }
    if !matches!(args.len(), 7 | 9 | 11) {
        return Err(args.count_error(ALLOWED));
    }
    let mut line = SolidLine {
        source: match args.text(0) {
            name if args.quoted(0) => SolidSource::File(name.to_owned()),
            "marble" => SolidSource::Marble,
            "wood" => SolidSource::Wood,
            "noise" => SolidSource::Noise,
            name => SolidSource::File(name.to_owned()),
        },
        middle: args.numbers(1)?,
        size: size(args, 4)?,
        octaves: OCTAVES,
        fold: None,
    };
    for i in (7..args.len()).step_by(2) {
        match args.text(i) {
            "octaves" => {
                let octaves = whole(args, i + 1, 1)?;
                args.check(i + 1, octaves <= 16, "1 to 16")?;
                line.octaves = octaves as u8;
            }
            "fold" => {
                let [fold] = args.floats(i + 1)?;
                line.fold = Some(fold);
            }
            _ => return Err(args.unknown(i, "octaves N, fold X")),
        }
    }
    Ok(Some(line))
}

fn text(args: &Args<'_>) -> Result<Classic, IoError> {
    args.exactly(
        10,
        "the words (in quotes if there are several), then origin, right and up (9 numbers)",
    )?;
    let (right, up) = (args.numbers::<3>(4)?, args.numbers::<3>(7)?);
    args.check(4, right != [0.0; 3], "a direction that is not zero")?;
    args.check(7, up != [0.0; 3], "a direction that is not zero")?;
    Ok(Classic::Text {
        words: args.text(0).to_owned(),
        origin: args.numbers(1)?,
        right,
        up,
    })
}

fn volume(args: &Args<'_>) -> Result<Classic, IoError> {
    const NEEDED: &str = "FILE, x y z, sx sy sz, density [step S]";
    if !matches!(args.len(), 8 | 10) {
        return Err(args.count_error(NEEDED));
    }
    args.check(0, !args.text(0).is_empty(), "a file name that is not empty")?;
    let [density] = args.positive_floats(7)?;
    let step = match args.len() {
        8 => None,
        _ if args.text(8) != "step" => return Err(args.unknown(8, "step S")),
        _ => {
            let [step] = args.floats(9)?;
            args.check(9, step > 0.0, "a length above 0")?;
            Some(step)
        }
    };
    Ok(Classic::Volume {
        file: args.text(0).to_owned(),
        middle: args.numbers(1)?,
        size: size(args, 4)?,
        density,
        step,
    })
}

impl Classic {
    /// The word that begins its line.
    pub fn word(&self) -> &'static str {
        match self {
            Self::Solid(_) => "solid",
            Self::Ramp(_) => "ramp",
            Self::Cel(_) => "cel",
            Self::Decal(_) => "decal",
            Self::Font(_) => "font",
            Self::Text { .. } => "text",
            Self::Sky(_) => "sky",
            Self::Volume { .. } => "volume",
        }
    }
}

/// The values after the word.
pub(super) fn print(out: &mut String, classic: &Classic) {
    match classic {
        Classic::Solid(Some(line)) => {
            match &line.source {
                SolidSource::Marble => word(out, "marble"),
                SolidSource::Wood => word(out, "wood"),
                SolidSource::Noise => word(out, "noise"),
                SolidSource::File(name)
                    if matches!(name.as_str(), "marble" | "wood" | "noise" | "none") =>
                {
                    word(out, &format!("\"{name}\""));
                }
                SolidSource::File(name) => path(out, name),
            }
            numbers(out, &line.middle);
            numbers(out, &line.size);
            if line.octaves != OCTAVES {
                word(out, "octaves");
                number(out, f64::from(line.octaves));
            }
            if let Some(fold) = line.fold {
                word(out, "fold");
                floats(out, &[fold]);
            }
        }
        Classic::Ramp(Some(name)) | Classic::Cel(Some(name)) => texture_name(out, name),
        Classic::Decal(Some((name, rect))) => {
            texture_name(out, name);
            if *rect != [0.0, 0.0, 1.0, 1.0] {
                floats(out, rect);
            }
        }
        Classic::Font(Some((name, cells))) => {
            texture_name(out, name);
            numbers(out, &cells.map(f64::from));
        }
        Classic::Text {
            words,
            origin,
            right,
            up,
        } => {
            word(out, &format!("\"{words}\""));
            for triple in [origin, right, up] {
                numbers(out, triple);
            }
        }
        Classic::Sky(Some((name, chart))) => {
            texture_name(out, name);
            if let Some(chart) = chart {
                word(out, chart.name());
            }
        }
        Classic::Volume {
            file,
            middle,
            size,
            density,
            step,
        } => {
            path(out, file);
            numbers(out, middle);
            numbers(out, size);
            floats(out, &[*density]);
            if let Some(step) = step {
                word(out, "step");
                floats(out, &[*step]);
            }
        }
        Classic::Solid(None)
        | Classic::Ramp(None)
        | Classic::Cel(None)
        | Classic::Decal(None)
        | Classic::Font(None)
        | Classic::Sky(None) => word(out, "none"),
    }
}

#[cfg(test)]
mod tests {
    use super::super::Command;
    use super::super::parse::{assert_faults, assert_reads_back};

    #[test]
    fn every_classic_reads_back() {
        assert_reads_back(
            |c| matches!(c, Command::Classic(_)),
            &[
                "solid marble 0 0 0 1 1 1\n",
                "solid wood 0 1 0 0.5 0.5 2 fold 0.25\n",
                "solid noise 0 0 0 1 1 1 octaves 7\n",
                "solid grid.npy 0 0 0 2 2 2\n",
                "solid \"wood\" 0 0 0 2 2 2\n",
                "solid none\n",
                "ramp heat.png\n",
                "ramp none\n",
                "cel bands.png\n",
                "cel \"none\"\n",
                "decal label.png\n",
                "decal label.png 0.25 0.5 0.5 0.25\n",
                "decal none\n",
                "font letters.png 16 6 32\n",
                "font none\n",
                "text \"No. 7\" 0 1 0 0.2 0 0 0 0.4 0\n",
                "text \"\" 0 1 0 0.2 0 0 0 0.4 0\n",
                "sky clouds.png\n",
                "sky clouds.png lat-long\n",
                "sky none\n",
                "volume fog.npy 0 0 0 2 2 2 1.5\n",
                "volume fog.npy 0 0 0 2 -2 2 1.5 step 0.01\n",
            ],
        );
    }

    #[test]
    fn faults_have_their_columns() {
        assert_faults(&[
            ("solid", "argument-count", 1),
            ("solid marble 0 0 0 1 1", "argument-count", 1),
            ("solid marble 0 0 0 1 0 1", "out-of-range", 22),
            ("solid marble 0 0 0 1 1 1 octaves 0", "out-of-range", 34),
            ("solid marble 0 0 0 1 1 1 octaves 17", "out-of-range", 34),
            ("solid marble 0 0 0 1 1 1 veins 3", "unknown-word", 26),
            ("solid marble 0 0 0 1 1 1 fold nan", "not-finite", 31),
            ("ramp a.png 3", "argument-count", 12),
            ("cel", "argument-count", 1),
            ("decal a.png 0 0 1", "argument-count", 1),
            ("decal a.png 0 0 0 1", "out-of-range", 17),
            ("font a.png 16 6", "argument-count", 1),
            ("font a.png 0 6 32", "out-of-range", 12),
            ("font a.png 2048 2048 32", "out-of-range", 17),
            ("text A B 0 0 0 1 0 0 0 1 0", "argument-count", 26),
            ("text A 0 0 0 0 0 0 0 1 0", "out-of-range", 14),
            ("sky a.png ball", "unknown-word", 11),
            ("volume a.npy 0 0 0 1 1 1", "argument-count", 1),
            ("volume a.npy 0 0 0 1 0 1 1", "out-of-range", 22),
            ("volume a.npy 0 0 0 1 1 1 -1", "out-of-range", 26),
            ("volume a.npy 0 0 0 1 1 1 1 step 0", "out-of-range", 33),
            ("volume a.npy 0 0 0 1 1 1 1 every 1", "unknown-word", 28),
        ]);
    }
}

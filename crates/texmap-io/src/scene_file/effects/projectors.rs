//! The words of slide projectors: `projector`.

use texmap_light::SlideBorder;

use super::Effect;
use super::shadows::{named, texels};
use crate::IoError;
use crate::scene_file::args::Args;
use crate::scene_file::print::{floats, number, numbers, texture_name, word};

/// A `projector` line.
#[derive(Debug, Clone, PartialEq)]
pub struct ProjectorLine {
    /// The slide.
    pub file: String,
    /// Paint, or light.
    pub paint: bool,
    /// Where it stands.
    pub position: [f64; 3],
    /// The point it looks at.
    pub look: [f64; 3],
    /// What is up.
    pub up: [f64; 3],
    /// Horizontal field of view, degrees.
    pub fov: f64,
    /// What lies beyond the slide.
    pub border: SlideBorder,
    /// `soft S`: part of the slide over which its edge fades.
    pub softness: f32,
    /// `color r g b`: of the lamp.
    pub color: [f32; 3],
    /// `shadow N`: texels of the map that keeps it from shining through things.
    pub shadow: Option<u32>,
}

pub(super) fn parse(args: &Args<'_>) -> Result<Effect, IoError> {
    const NEEDED: &str =
        "FILE, light or paint, position, look, up (3 numbers each), degrees; then options";
    const OPTIONS: &str = "black, clamp, repeat, soft S, color r g b, shadow N";
    if args.len() < 12 {
        return Err(args.count_error(NEEDED));
    }
    let paint = match args.text(1) {
        "light" => false,
        "paint" => true,
        _ => return Err(args.unknown(1, "light, paint")),
    };
    let [fov] = args.numbers(11)?;
    args.check(
        11,
        fov > 0.0 && fov < 180.0,
        "more than 0 and less than 180 degrees",
    )?;
    let mut line = ProjectorLine {
        file: args.text(0).to_owned(),
        paint,
        position: args.numbers(2)?,
        look: args.numbers(5)?,
        up: args.numbers(8)?,
        fov,
        border: SlideBorder::Black,
        softness: 0.0,
        color: [1.0; 3],
        shadow: None,
    };
    let mut i = 12;
    while i < args.len() {
        match args.text(i) {
            "black" => line.border = SlideBorder::Black,
            "clamp" => line.border = SlideBorder::Clamp,
            "repeat" => line.border = SlideBorder::Repeat,
            "soft" => {
                [line.softness] = args.floats(i + 1)?;
                args.check(i + 1, (0.0..=0.5).contains(&line.softness), "0 to 0.5")?;
                i += 1;
            }
            "color" => {
                line.color = args.positive_floats(i + 1)?;
                i += 3;
            }
            "shadow" => {
                line.shadow = Some(texels(args, i + 1)?);
                i += 1;
            }
            _ => return Err(args.unknown(i, OPTIONS)),
        }
        i += 1;
    }
    Ok(Effect::Projector(Box::new(line)))
}

/// The values after the word.
pub(super) fn print(out: &mut String, line: &ProjectorLine) {
    texture_name(out, &line.file);
    word(out, if line.paint { "paint" } else { "light" });
    for triple in [&line.position, &line.look, &line.up] {
        numbers(out, triple);
    }
    number(out, line.fov);
    word(
        out,
        match line.border {
            SlideBorder::Black => "black",
            SlideBorder::Clamp => "clamp",
            SlideBorder::Repeat => "repeat",
        },
    );
    word(out, "soft");
    floats(out, &[line.softness]);
    word(out, "color");
    floats(out, &line.color);
    if let Some(size) = line.shadow {
        named(out, "shadow", f64::from(size));
    }
}

#[cfg(test)]
mod tests {
    use crate::scene_file::Command;
    use crate::scene_file::parse::{assert_faults, assert_reads_back};

    #[test]
    fn every_projector_reads_back() {
        assert_reads_back(
            |c| matches!(c, Command::Effect(_)),
            &[
                "projector slide.png light 0 1 2 0 0 0 0 1 0 40 black soft 0.1 color 1 1 0.5 shadow 512\n",
                "projector \"my slide.png\" paint 0 1 2 0 0 0 0 1 0 40 repeat soft 0 color 1 1 1\n",
            ],
        );
    }

    #[test]
    fn faults_have_their_columns() {
        assert_faults(&[
            (
                "projector a.png beam 0 0 0 0 0 1 0 1 0 40",
                "unknown-word",
                17,
            ),
            (
                "projector a.png light 0 0 0 0 0 1 0 1 0 180",
                "out-of-range",
                41,
            ),
            ("projector a.png light 0 0 0", "argument-count", 1),
            (
                "projector a.png light 0 0 0 0 0 1 0 1 0 40 soft 2",
                "out-of-range",
                49,
            ),
        ]);
    }
}

//! The words of lighting effects: `ls name shadow shadowless projector highlight env specmap lightmap lightmapuv bump normalmap
//! horizon`, and those of `reliefs`.

use texmap_light::{Chart, Green, Highlight, SlideBorder};

use super::args::Args;
use super::print::{floats, number, numbers, texture_name, word};
use super::reliefs::{self, ReliefLine};
use crate::IoError;

/// A line about light beyond `la`, `ld` and `lp`.
#[derive(Debug, Clone, PartialEq)]
pub enum Effect {
    /// `ls r g b x y z dx dy dz inner outer`: a spot light.
    SpotLight {
        /// Linear factors.
        color: [f32; 3],
        /// World position.
        position: [f32; 3],
        /// Away from the light; not zero.
        direction: [f32; 3],
        /// Half the angle of the full cone, degrees.
        inner: f32,
        /// Half the angle beyond which there is no light, degrees.
        outer: f32,
    },
    /// `name NAME`: of the light above.
    LightName(String),
    /// `shadow [SIZE|auto] [taps K] [slope X|constant X|normal-offset X] [area x y z half]`: the light above throws shadows.
    Shadow {
        /// Texels a side; `None` fits the picture.
        size: Option<u32>,
        /// Comparisons a side.
        taps: u32,
        /// What keeps surfaces from shadowing themselves.
        bias: Option<Bias>,
        /// Middle and half a side of what the map shows.
        area: Option<([f64; 3], f64)>,
    },
    /// `shadowless yes|no`: later faces and models throw no shadow.
    Shadowless(bool),
    /// `projector FILE light|paint x y z lx ly lz ux uy uz fov ...`: a slide projector.
    Projector(Box<ProjectorLine>),
    /// `highlight phong|blinn`.
    Highlight(Highlight),
    /// `env FILE CHART share [mips]`, or `env none`.
    Environment(Option<EnvironmentLine>),
    /// `specmap FILE CHART exponent`, or `specmap none`.
    SpecularMap(Option<(String, Chart, f32)>),
    /// `lightmap FILE [scale]`, or `lightmap none`.
    LightMap(Option<(String, f32)>),
    /// `lightmapuv FILE`, or `lightmapuv none`.
    LightMapUv(Option<String>),
    /// `bump FILE height`, or `bump none`, which ends any relief.
    Bump(Option<(String, f32)>),
    /// `offsetmap`, `carve` or `emboss`; their `none` is that of `bump`.
    Relief(ReliefLine),
    /// `normalmap FILE [tangent|object] [up|down] [xyz|xy]`, or `normalmap none`.
    NormalMap(Option<NormalMapLine>),
    /// `horizon clamp|open`: whether normals that a relief turns away from the eye are brought back.
    Horizon {
        /// They are.
        clamp: bool,
    },
}

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

/// The bias of a `shadow` line, with its number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Bias {
    /// The receiver's slope, and this constant in world units.
    Slope(f64),
    /// A constant in world units.
    Constant(f64),
    /// Along the normal, in texels.
    NormalOffset(f64),
}

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

/// A `normalmap` line.
#[derive(Debug, Clone, PartialEq)]
pub struct NormalMapLine {
    /// The map.
    pub file: String,
    /// Normals of the object, not of its tangent frames.
    pub object_space: bool,
    /// Which way green points.
    pub green: Green,
    /// Only red and green are read.
    pub rebuild_z: bool,
}

/// `None` for words of others.
pub(super) fn parse(args: &Args<'_>) -> Result<Option<Effect>, IoError> {
    Ok(Some(match args.command {
        "ls" => spot(args)?,
        "name" => {
            const ALLOWED: &str = "letters, digits, - and _, not digits alone";
            let name = args.single_word("1 name")?;
            args.check(0, texmap_render::is_light_name(name), ALLOWED)?;
            Effect::LightName(name.to_owned())
        }
        "shadow" => shadow(args)?,
        "projector" => projector(args)?,
        "highlight" => {
            let table = [("phong", Highlight::Phong), ("blinn", Highlight::Blinn)];
            Effect::Highlight(args.one_of(&table, "phong, blinn")?)
        }
        "shadowless" => {
            Effect::Shadowless(args.one_of(&[("yes", true), ("no", false)], "yes, no")?)
        }
        "horizon" => {
            let clamp = args.one_of(&[("clamp", true), ("open", false)], "clamp, open")?;
            Effect::Horizon { clamp }
        }
        "env" if args.len() == 1 && none(args) => Effect::Environment(None),
        "env" => {
            args.within(3, 4, "none, or FILE CHART share [mips]")?;
            let mips = args.len() == 4;
            if mips && args.text(3) != "mips" {
                return Err(args.unknown(3, "mips"));
            }
            let share = |x| (0.0..=1.0).contains(&x);
            let (file, chart, share) = chart_values(args, "a share of 0 to 1", share)?;
            Effect::Environment(Some(EnvironmentLine {
                file,
                chart,
                share,
                mips,
            }))
        }
        "specmap" if args.len() == 1 && none(args) => Effect::SpecularMap(None),
        "specmap" => {
            args.exactly(3, "none, or FILE CHART exponent")?;
            let line = chart_values(args, "an exponent of 0 or more", |x| x >= 0.0)?;
            Effect::SpecularMap(Some(line))
        }
        "lightmap" => {
            args.within(1, 2, "none, or FILE [scale]")?;
            let scale = || -> Result<f32, IoError> {
                let [scale] = args.positive_floats(1)?;
                Ok(scale)
            };
            let scale = if args.len() == 2 { scale()? } else { 1.0 };
            Effect::LightMap(file(args)?.map(|file| (file, scale)))
        }
        "lightmapuv" => {
            args.exactly(1, "none, or 1 file name")?;
            Effect::LightMapUv(file(args)?)
        }
        "bump" if args.len() == 1 && none(args) => Effect::Bump(None),
        "bump" => {
            args.exactly(2, "none, or FILE height")?;
            let [height] = args.floats(1)?;
            Effect::Bump(file(args)?.map(|file| (file, height)))
        }
        "normalmap" => normal_map(args)?,
        "offsetmap" | "carve" | "emboss" => {
            reliefs::parse(args)?.map_or(Effect::Bump(None), Effect::Relief)
        }
        _ => return Ok(None),
    }))
}

pub(super) fn none(args: &Args<'_>) -> bool {
    args.text(0) == "none" && !args.quoted(0)
}

pub(super) fn file(args: &Args<'_>) -> Result<Option<String>, IoError> {
    args.check(0, !args.text(0).is_empty(), "a file name that is not empty")?;
    Ok((!none(args)).then(|| args.text(0).to_owned()))
}

fn spot(args: &Args<'_>) -> Result<Effect, IoError> {
    args.exactly(11, "11 numbers (r g b, x y z, dx dy dz, inner outer)")?;
    let direction = args.floats(6)?;
    args.check(6, direction != [0.0; 3], "a direction that is not zero")?;
    let [inner, outer] = args.floats(9)?;
    args.check(9, (0.0..=180.0).contains(&inner), "0 to 180 degrees")?;
    args.check(
        10,
        outer >= inner && outer <= 180.0,
        "an angle of at least the inner one, up to 180 degrees",
    )?;
    Ok(Effect::SpotLight {
        color: args.positive_floats(0)?,
        position: args.floats(3)?,
        direction,
        inner,
        outer,
    })
}

fn shadow(args: &Args<'_>) -> Result<Effect, IoError> {
    const ALLOWED: &str =
        "[SIZE|auto] [taps K] [slope X|constant X|normal-offset X] [area x y z half]";
    let (mut size, mut taps, mut bias, mut area) = (None, 3, None, None);
    let mut i = 0;
    if args.len() > 0 && args.text(0) == "auto" {
        i = 1;
    } else if args.len() > 0 && args.text(0).starts_with(|c: char| c.is_ascii_digit()) {
        size = Some(texels(args, 0)?);
        i = 1;
    }
    while i < args.len() {
        let value = |least: f64| -> Result<f64, IoError> {
            let [x] = args.numbers(i + 1)?;
            args.check(i + 1, x >= least, "0 or more")?;
            Ok(x)
        };
        match args.text(i) {
            "taps" => {
                let x = value(1.0)?;
                let odd = x.fract() == 0.0 && x as u32 % 2 == 1 && x <= 15.0;
                args.check(i + 1, odd, "an odd number, 1 to 15")?;
                taps = x as u32;
            }
            "slope" => bias = Some(Bias::Slope(value(0.0)?)),
            "constant" => bias = Some(Bias::Constant(value(0.0)?)),
            "normal-offset" => bias = Some(Bias::NormalOffset(value(0.0)?)),
            "area" => {
                let [x, y, z, half] = args.numbers(i + 1)?;
                args.check(i + 4, half > 0.0, "more than 0")?;
                area = Some(([x, y, z], half));
                i += 3;
            }
            _ => return Err(args.unknown(i, ALLOWED)),
        }
        i += 2;
    }
    Ok(Effect::Shadow {
        size,
        taps,
        bias,
        area,
    })
}

fn texels(args: &Args<'_>, i: usize) -> Result<u32, IoError> {
    let [x] = args.numbers::<1>(i)?;
    let fits = x.fract() == 0.0 && (1.0..=16_384.0).contains(&x);
    args.check(i, fits, "a whole number of texels, 1 to 16384")?;
    Ok(x as u32)
}

fn projector(args: &Args<'_>) -> Result<Effect, IoError> {
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

pub(super) const CHARTS: &str =
    "cube, tan-cube, lat-long, octahedron, equal-area-octahedron, dual-paraboloid, sphere-map";

/// `FILE CHART number`.
fn chart_values(
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

fn normal_map(args: &Args<'_>) -> Result<Effect, IoError> {
    if args.len() == 1 && none(args) {
        return Ok(Effect::NormalMap(None));
    }
    args.within(1, 4, "none, or FILE [tangent|object] [up|down] [xyz|xy]")?;
    let mut line = NormalMapLine {
        file: args.text(0).to_owned(),
        object_space: false,
        green: Green::Up,
        rebuild_z: false,
    };
    for i in 1..args.len() {
        match args.text(i) {
            "tangent" => line.object_space = false,
            "object" => line.object_space = true,
            "up" => line.green = Green::Up,
            "down" => line.green = Green::Down,
            "xyz" => line.rebuild_z = false,
            "xy" => line.rebuild_z = true,
            _ => return Err(args.unknown(i, "tangent, object, up, down, xyz, xy")),
        }
    }
    Ok(Effect::NormalMap(Some(line)))
}

impl Effect {
    /// The word that begins its line.
    pub fn word(&self) -> &'static str {
        match self {
            Self::SpotLight { .. } => "ls",
            Self::LightName(_) => "name",
            Self::Shadow { .. } => "shadow",
            Self::Shadowless(_) => "shadowless",
            Self::Horizon { .. } => "horizon",
            Self::Projector(_) => "projector",
            Self::Highlight(_) => "highlight",
            Self::Environment(_) => "env",
            Self::SpecularMap(_) => "specmap",
            Self::LightMap(_) => "lightmap",
            Self::LightMapUv(_) => "lightmapuv",
            Self::Bump(_) => "bump",
            Self::Relief(line) => line.word(),
            Self::NormalMap(_) => "normalmap",
        }
    }
}

/// The values after the word.
pub(super) fn print(out: &mut String, effect: &Effect) {
    match effect {
        Effect::SpotLight {
            color,
            position,
            direction,
            inner,
            outer,
        } => {
            for triple in [color, position, direction] {
                floats(out, triple);
            }
            floats(out, &[*inner, *outer]);
        }
        Effect::LightName(name) => word(out, name),
        Effect::Relief(line) => reliefs::print(out, line),
        Effect::Shadow {
            size,
            taps,
            bias,
            area,
        } => {
            match size {
                Some(size) => number(out, f64::from(*size)),
                None => word(out, "auto"),
            }
            word(out, "taps");
            number(out, f64::from(*taps));
            match bias {
                Some(Bias::Slope(x)) => named(out, "slope", *x),
                Some(Bias::Constant(x)) => named(out, "constant", *x),
                Some(Bias::NormalOffset(x)) => named(out, "normal-offset", *x),
                None => {}
            }
            if let Some((middle, half)) = area {
                word(out, "area");
                numbers(out, middle);
                number(out, *half);
            }
        }
        Effect::Shadowless(shadowless) => word(out, if *shadowless { "yes" } else { "no" }),
        Effect::Horizon { clamp } => word(out, if *clamp { "clamp" } else { "open" }),
        Effect::Projector(line) => {
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
        Effect::Highlight(Highlight::Phong) => word(out, "phong"),
        Effect::Highlight(Highlight::Blinn) => word(out, "blinn"),
        Effect::Environment(Some(line)) => {
            chart_words(out, &line.file, line.chart, line.share);
            if line.mips {
                word(out, "mips");
            }
        }
        Effect::SpecularMap(Some((file, chart, x))) => chart_words(out, file, *chart, *x),
        Effect::LightMap(Some((file, x))) | Effect::Bump(Some((file, x))) => {
            texture_name(out, file);
            floats(out, &[*x]);
        }
        Effect::LightMapUv(Some(file)) => texture_name(out, file),
        Effect::NormalMap(Some(line)) => {
            texture_name(out, &line.file);
            word(
                out,
                if line.object_space {
                    "object"
                } else {
                    "tangent"
                },
            );
            word(
                out,
                if line.green == Green::Up {
                    "up"
                } else {
                    "down"
                },
            );
            word(out, if line.rebuild_z { "xy" } else { "xyz" });
        }
        Effect::Environment(None)
        | Effect::SpecularMap(None)
        | Effect::LightMap(None)
        | Effect::LightMapUv(None)
        | Effect::Bump(None)
        | Effect::NormalMap(None) => word(out, "none"),
    }
}

fn chart_words(out: &mut String, file: &str, chart: Chart, x: f32) {
    texture_name(out, file);
    word(out, chart.name());
    floats(out, &[x]);
}

fn named(out: &mut String, name: &str, x: f64) {
    word(out, name);
    number(out, x);
}

#[cfg(test)]
mod tests {
    use super::super::parse::assert_faults;
    use super::super::{Command, SceneFile, parse, print};
    use std::path::Path;

    fn read(text: &str) -> Result<SceneFile, crate::IoError> {
        parse(Path::new("a.scene"), text)
    }

    #[test]
    fn every_effect_reads_back() {
        for text in [
            "ls 1 0.5 0 1 2 3 0 -1 0 20 30\n",
            "name sun-2\n",
            "shadow auto taps 3\n",
            "shadow 512 taps 5 slope 0.001\n",
            "shadow 512 taps 1 constant 0.01\n",
            "shadow auto taps 1 normal-offset 1.5\n",
            "projector slide.png light 0 1 2 0 0 0 0 1 0 40 black soft 0.1 color 1 1 0.5 shadow 512\n",
            "projector \"my slide.png\" paint 0 1 2 0 0 0 0 1 0 40 repeat soft 0 color 1 1 1\n",
            "shadow auto taps 1 normal-offset 1.5 area 0 1 -2 3.5\n",
            "shadowless yes\n",
            "shadowless no\n",
            "horizon clamp\n",
            "horizon open\n",
            "highlight blinn\n",
            "env sky.hdr lat-long 0.5 mips\n",
            "env sky.hdr lat-long 0.5\n",
            "env none\n",
            "specmap lamps.exr tan-cube 40\n",
            "specmap none\n",
            "lightmap room.png 2\n",
            "lightmap none\n",
            "lightmapuv room2.obj\n",
            "lightmapuv none\n",
            "bump bricks.png 0.02\n",
            "bump none\n",
            "bump \"none\" 0.02\n",
            "normalmap n.png object down xy\n",
            "normalmap none\n",
        ] {
            let file = read(text).unwrap_or_else(|e| panic!("{text}: {e}"));
            assert!(
                matches!(file.statements[0].command, Command::Effect(_)),
                "{text}"
            );
            assert_eq!(print(&file), text);
        }
    }

    #[test]
    fn faults_have_their_columns() {
        assert_faults(&[
            ("ls 1 1 1 0 0 0 0 0 0 10 20", "out-of-range", 16),
            ("ls 1 1 1 0 0 0 0 1 0 30 20", "out-of-range", 25),
            ("ls 1 1 1", "argument-count", 1),
            ("name 12", "out-of-range", 6),
            ("name a/b", "out-of-range", 6),
            ("name", "argument-count", 1),
            ("shadow 0", "out-of-range", 8),
            ("shadow 512 taps 4", "out-of-range", 17),
            ("shadow 512 soft 4", "unknown-word", 12),
            ("shadow auto taps", "not-a-number", 1),
            ("shadow auto area 0 0 0 0", "out-of-range", 24),
            ("shadow area 0 0 x 1", "not-a-number", 17),
            ("shadowless maybe", "unknown-word", 12),
            ("shadowless", "argument-count", 1),
            ("horizon far", "unknown-word", 9),
            ("env a.png cube 1 levels", "unknown-word", 18),
            ("env a.png cube", "argument-count", 1),
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
            ("env a.png ball 1", "unknown-word", 11),
            ("env a.png cube 2", "out-of-range", 16),
            ("specmap a.png cube -1", "out-of-range", 20),
            ("lightmap a.png -1", "out-of-range", 16),
            ("bump a.png", "argument-count", 1),
            ("normalmap a.png left", "unknown-word", 17),
            ("highlight shiny", "unknown-word", 11),
        ]);
    }
}

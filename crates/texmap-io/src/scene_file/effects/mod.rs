//! The words of lighting effects: `ls name shadow shadowless projector highlight env specmap lightmap lightmapuv emission bump
//! normalmap horizon`, and those of `reliefs`.

mod environments;
mod normal_maps;
mod projectors;
mod reliefs;
mod shadows;

use texmap_light::{Chart, Highlight};

use super::args::Args;
use super::print::{floats, texture_name, word};
use crate::IoError;
use environments::{chart_values, chart_words};

pub(super) use environments::CHARTS;
pub use environments::EnvironmentLine;
pub use normal_maps::NormalMapLine;
pub use projectors::ProjectorLine;
pub use reliefs::{CarveLine, Formula, ReliefLine};
pub use shadows::Bias;

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
    /// `emission r g b [FILE]`, or `emission none`: sRGB up to 1, a linear factor above.
    Emission(Option<([f32; 3], Option<String>)>),
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

/// `None` for words of others.
pub(super) fn parse(args: &Args<'_>) -> Result<Option<Effect>, IoError> {
    Ok(Some(match args.command {
        "ls" => spot(args)?,
        "name" => {
            const ALLOWED: &str = "letters, digits, - and _, not digits alone";
            let name = args.single_word("1 name")?;
            args.check(0, texmap_scene::is_light_name(name), ALLOWED)?;
            Effect::LightName(name.to_owned())
        }
        "shadow" => shadows::parse(args)?,
        "projector" => projectors::parse(args)?,
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
        "env" => environments::parse(args)?,
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
        "emission" if args.len() == 1 && none(args) => Effect::Emission(None),
        "emission" => {
            args.within(3, 4, "none, or r g b [FILE]")?;
            let named = args.len() == 4;
            args.check(
                3,
                !named || !args.text(3).is_empty(),
                "a file name that is not empty",
            )?;
            let file = named.then(|| args.text(3).to_owned());
            Effect::Emission(Some((args.positive_floats(0)?, file)))
        }
        "bump" if args.len() == 1 && none(args) => Effect::Bump(None),
        "bump" => {
            args.exactly(2, "none, or FILE height")?;
            let [height] = args.floats(1)?;
            Effect::Bump(file(args)?.map(|file| (file, height)))
        }
        "normalmap" => normal_maps::parse(args)?,
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
            Self::Emission(_) => "emission",
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
        } => shadows::print(out, *size, *taps, *bias, *area),
        Effect::Shadowless(shadowless) => word(out, if *shadowless { "yes" } else { "no" }),
        Effect::Horizon { clamp } => word(out, if *clamp { "clamp" } else { "open" }),
        Effect::Projector(line) => projectors::print(out, line),
        Effect::Highlight(Highlight::Phong) => word(out, "phong"),
        Effect::Highlight(Highlight::Blinn) => word(out, "blinn"),
        Effect::Environment(Some(line)) => environments::print(out, line),
        Effect::SpecularMap(Some((file, chart, x))) => chart_words(out, file, *chart, *x),
        Effect::LightMap(Some((file, x))) | Effect::Bump(Some((file, x))) => {
            texture_name(out, file);
            floats(out, &[*x]);
        }
        Effect::Emission(Some((color, file))) => {
            floats(out, color);
            if let Some(file) = file {
                texture_name(out, file);
            }
        }
        Effect::LightMapUv(Some(file)) => texture_name(out, file),
        Effect::NormalMap(Some(line)) => normal_maps::print(out, line),
        Effect::Environment(None)
        | Effect::SpecularMap(None)
        | Effect::LightMap(None)
        | Effect::LightMapUv(None)
        | Effect::Emission(None)
        | Effect::Bump(None)
        | Effect::NormalMap(None) => word(out, "none"),
    }
}

#[cfg(test)]
mod tests {
    use crate::scene_file::Command;
    use crate::scene_file::parse::{assert_faults, assert_reads_back};

    #[test]
    fn every_effect_reads_back() {
        assert_reads_back(
            |c| matches!(c, Command::Effect(_)),
            &[
                "ls 1 0.5 0 1 2 3 0 -1 0 20 30\n",
                "name sun-2\n",
                "shadowless yes\n",
                "shadowless no\n",
                "horizon clamp\n",
                "horizon open\n",
                "highlight blinn\n",
                "specmap lamps.exr tan-cube 40\n",
                "specmap none\n",
                "lightmap room.png 2\n",
                "lightmap none\n",
                "lightmapuv room2.obj\n",
                "lightmapuv none\n",
                "emission 0.5 2 0\n",
                "emission 1 1 1 glow.png\n",
                "emission 1 1 1 \"none\"\n",
                "emission none\n",
                "bump bricks.png 0.02\n",
                "bump none\n",
                "bump \"none\" 0.02\n",
            ],
        );
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
            ("shadowless maybe", "unknown-word", 12),
            ("shadowless", "argument-count", 1),
            ("horizon far", "unknown-word", 9),
            ("specmap a.png cube -1", "out-of-range", 20),
            ("lightmap a.png -1", "out-of-range", 16),
            ("bump a.png", "argument-count", 1),
            ("highlight shiny", "unknown-word", 11),
            ("emission 1 1", "argument-count", 1),
            ("emission 1 -1 0", "out-of-range", 12),
            ("emission 1 1 0 a.png b.png", "argument-count", 22),
            ("emission 1 1 0 \"\"", "out-of-range", 16),
        ]);
    }
}

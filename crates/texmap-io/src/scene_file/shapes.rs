//! The words of shapes that move, bend or turn: `displace terrain billboard bone skin`.

use texmap_mesh::SkinBlend;
use texmap_scene::{Displacement, EdgeBudget};

use super::args::Args;
use super::print::{floats, number, numbers, texture_name, word};
use crate::IoError;

/// A line about shape beyond faces and models.
#[derive(Debug, Clone, PartialEq)]
pub enum Shape {
    /// `displace FILE height [middle M] [texels N|pixels N] [triangles MAX]`, or `displace none`.
    Displace(Option<DisplaceLine>),
    /// `terrain FILE x y z width height depth [step N]`: a height field.
    Terrain(TerrainLine),
    /// `billboard x y z width height [axis x y z]`: a picture that faces the camera.
    Billboard {
        /// Its middle.
        position: [f64; 3],
        /// Width and height, above 0.
        size: [f64; 2],
        /// What it turns about; `None` is parallel to the picture.
        axis: Option<[f64; 3]>,
    },
    /// `bone x y z x y z [parent N] [turn degrees x y z]`.
    Bone(BoneLine),
    /// `skin rigid`, `skin smooth WIDTH` or `skin none`: how later faces and models follow the bones.
    Skin(Option<SkinBlend>),
}

/// A `displace` line.
#[derive(Debug, Clone, PartialEq)]
pub struct DisplaceLine {
    /// The height map.
    pub file: String,
    /// How far white moves over black, in the units of the model.
    pub height: f32,
    /// The value that stays.
    pub middle: f32,
    /// The longest edge.
    pub budget: EdgeBudget,
    /// The most triangles.
    pub triangles: u32,
}

/// A `terrain` line.
#[derive(Debug, Clone, PartialEq)]
pub struct TerrainLine {
    /// The height map.
    pub file: String,
    /// The middle of the ground, where black is.
    pub position: [f64; 3],
    /// Width, height of white over black, depth; width and depth above 0.
    pub size: [f32; 3],
    /// Texels from vertex to vertex.
    pub step: u32,
}

/// A `bone` line.
#[derive(Debug, Clone, PartialEq)]
pub struct BoneLine {
    /// What it turns about.
    pub head: [f64; 3],
    /// Its other end.
    pub tail: [f64; 3],
    /// The bone above that it follows.
    pub parent: Option<u32>,
    /// Degrees, and the axis through the head; not zero.
    pub turn: Option<(f64, [f64; 3])>,
}

/// `None` for words of others.
pub(super) fn parse(args: &Args<'_>) -> Result<Option<Shape>, IoError> {
    Ok(Some(match args.command {
        "displace" => displace(args)?,
        "terrain" => terrain(args)?,
        "billboard" => billboard(args)?,
        "bone" => bone(args)?,
        "skin" => skin(args)?,
        _ => return Ok(None),
    }))
}

fn displace(args: &Args<'_>) -> Result<Shape, IoError> {
    const EXPECTED: &str = "none, or FILE height [middle M] [texels N|pixels N] [triangles MAX]";
    if args.len() == 1 && args.text(0) == "none" && !args.quoted(0) {
        return Ok(Shape::Displace(None));
    }
    args.within(2, 8, EXPECTED)?;
    let [height] = args.floats(1)?;
    let mut line = DisplaceLine {
        file: file(args)?,
        height,
        middle: 0.0,
        budget: EdgeBudget::Pixels(2.0),
        triangles: Displacement::MAX_TRIANGLES,
    };
    for i in (2..args.len()).step_by(2) {
        let edge = || -> Result<f32, IoError> {
            let [edge] = args.floats(i + 1)?;
            args.check(i + 1, edge > 0.0, "a length above 0")?;
            Ok(edge)
        };
        match args.text(i) {
            "middle" => [line.middle] = args.floats(i + 1)?,
            "texels" => line.budget = EdgeBudget::Texels(edge()?),
            "pixels" => line.budget = EdgeBudget::Pixels(edge()?),
            "triangles" => line.triangles = whole(args, i + 1, 1)?,
            _ => return Err(args.unknown(i, EXPECTED)),
        }
    }
    Ok(Shape::Displace(Some(line)))
}

fn terrain(args: &Args<'_>) -> Result<Shape, IoError> {
    const EXPECTED: &str = "FILE, middle (3 numbers), width height depth [step N]";
    args.within(7, 9, EXPECTED)?;
    let size: [f32; 3] = args.floats(4)?;
    for i in [0, 2] {
        args.check(4 + i, size[i] > 0.0, "a width and a depth above 0")?;
    }
    let step = match (args.len(), args.text(7)) {
        (7, _) => 1,
        (9, "step") => whole(args, 8, 1)?,
        _ => return Err(args.unknown(7, "step N")),
    };
    Ok(Shape::Terrain(TerrainLine {
        file: file(args)?,
        position: args.numbers(1)?,
        size,
        step,
    }))
}

fn billboard(args: &Args<'_>) -> Result<Shape, IoError> {
    const EXPECTED: &str = "5 numbers (x y z width height) [axis x y z]";
    if ![5, 9].contains(&args.len()) {
        return Err(args.count_error(EXPECTED));
    }
    let size: [f64; 2] = args.numbers(3)?;
    for (i, side) in size.iter().enumerate() {
        args.check(3 + i, *side > 0.0, "a width and a height above 0")?;
    }
    let axis = match args.len() {
        5 => None,
        _ if args.text(5) == "axis" => Some(args.numbers(6)?),
        _ => return Err(args.unknown(5, "axis x y z")),
    };
    args.check(6, axis != Some([0.0; 3]), "an axis that is not zero")?;
    Ok(Shape::Billboard {
        position: args.numbers(0)?,
        size,
        axis,
    })
}

fn bone(args: &Args<'_>) -> Result<Shape, IoError> {
    const EXPECTED: &str = "6 numbers (from, to) [parent N] [turn degrees x y z]";
    args.within(6, 13, EXPECTED)?;
    let mut line = BoneLine {
        head: args.numbers(0)?,
        tail: args.numbers(3)?,
        parent: None,
        turn: None,
    };
    let mut i = 6;
    while i < args.len() {
        match args.text(i) {
            "parent" => {
                line.parent = Some(whole(args, i + 1, 0)?);
                i += 2;
            }
            "turn" => {
                let [degrees] = args.numbers(i + 1)?;
                let axis = args.numbers(i + 2)?;
                args.check(i + 2, axis != [0.0; 3], "an axis that is not zero")?;
                line.turn = Some((degrees, axis));
                i += 5;
            }
            _ => return Err(args.unknown(i, EXPECTED)),
        }
    }
    Ok(Shape::Bone(line))
}

fn skin(args: &Args<'_>) -> Result<Shape, IoError> {
    const EXPECTED: &str = "none, rigid, or smooth WIDTH";
    args.within(1, 2, EXPECTED)?;
    Ok(Shape::Skin(match (args.text(0), args.len()) {
        ("none", 1) => None,
        ("rigid", 1) => Some(SkinBlend::Rigid),
        ("smooth", 2) => {
            let [width] = args.numbers(1)?;
            args.check(1, width > 0.0, "a width above 0")?;
            Some(SkinBlend::Smooth(width))
        }
        _ => return Err(args.unknown(0, EXPECTED)),
    }))
}

fn file(args: &Args<'_>) -> Result<String, IoError> {
    args.check(0, !args.text(0).is_empty(), "a file name that is not empty")?;
    Ok(args.text(0).to_owned())
}

fn whole(args: &Args<'_>, i: usize, least: u32) -> Result<u32, IoError> {
    let [x] = args.numbers::<1>(i)?;
    let fits = x.fract() == 0.0 && x >= f64::from(least) && x <= f64::from(u32::MAX);
    let allowed = match least {
        0 => "a whole number, 0 or more",
        _ => "a whole number, 1 or more",
    };
    args.check(i, fits, allowed)?;
    Ok(x as u32)
}

impl Shape {
    /// The word that begins its line.
    pub fn word(&self) -> &'static str {
        match self {
            Self::Displace(_) => "displace",
            Self::Terrain(_) => "terrain",
            Self::Billboard { .. } => "billboard",
            Self::Bone(_) => "bone",
            Self::Skin(_) => "skin",
        }
    }
}

/// The values after the word.
pub(super) fn print(out: &mut String, shape: &Shape) {
    match shape {
        Shape::Displace(None) | Shape::Skin(None) => word(out, "none"),
        Shape::Displace(Some(line)) => {
            texture_name(out, &line.file);
            floats(out, &[line.height]);
            word(out, "middle");
            floats(out, &[line.middle]);
            let (name, edge) = match line.budget {
                EdgeBudget::Texels(edge) => ("texels", edge),
                EdgeBudget::Pixels(edge) => ("pixels", edge),
            };
            word(out, name);
            floats(out, &[edge]);
            word(out, "triangles");
            number(out, f64::from(line.triangles));
        }
        Shape::Terrain(line) => {
            texture_name(out, &line.file);
            numbers(out, &line.position);
            floats(out, &line.size);
            word(out, "step");
            number(out, f64::from(line.step));
        }
        Shape::Billboard {
            position,
            size,
            axis,
        } => {
            numbers(out, position);
            numbers(out, size);
            if let Some(axis) = axis {
                word(out, "axis");
                numbers(out, axis);
            }
        }
        Shape::Bone(line) => {
            numbers(out, &line.head);
            numbers(out, &line.tail);
            if let Some(parent) = line.parent {
                word(out, "parent");
                number(out, f64::from(parent));
            }
            if let Some((degrees, axis)) = line.turn {
                word(out, "turn");
                number(out, degrees);
                numbers(out, &axis);
            }
        }
        Shape::Skin(Some(SkinBlend::Rigid)) => word(out, "rigid"),
        Shape::Skin(Some(SkinBlend::Smooth(width))) => {
            word(out, "smooth");
            number(out, *width);
        }
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use crate::scene_file::parse::assert_faults;
    use crate::scene_file::{parse, print};

    #[test]
    fn lines_print_back_and_faults_are_placed() {
        let text = "displace h.png 0.5 middle 0.25 texels 2 triangles 5000\ndisplace none\n\
                    displace \"none\" -1 middle 0 pixels 4 triangles 4000000\n\
                    terrain h.png 1 2 3 40 5 60 step 2\nbillboard 0 1 2 3 4\nbillboard 0 1 2 3 4 axis 0 1 0\n\
                    bone 0 0 0 1 0 0\nbone 1 0 0 2 0 0 parent 0 turn 30 0 0 1\nskin rigid\nskin smooth 0.5\nskin none\n";
        let read = |text: &str| parse(Path::new("a.scene"), text);
        assert_eq!(print(&read(text).unwrap()), text);
        assert_faults(&[
            ("displace h.png", "argument-count", 1),
            ("displace h.png 1 texels 0", "out-of-range", 25),
            ("displace h.png 1 pixels nan", "not-finite", 25),
            ("displace h.png 1 inches 2", "unknown-word", 18),
            ("displace h.png 1 triangles 0", "out-of-range", 28),
            ("displace h.png 1 texels", "not-a-number", 1),
            ("terrain h.png 0 0 0 1 1", "argument-count", 1),
            ("terrain h.png 0 0 0 1 1 0", "out-of-range", 25),
            ("terrain h.png 0 0 0 1 1 1 step 0.5", "out-of-range", 32),
            ("billboard 0 0 0 1", "argument-count", 1),
            ("billboard 0 0 0 1 0", "out-of-range", 19),
            ("billboard 0 0 0 1 1 axis 0 0 0", "out-of-range", 26),
            ("bone 0 0 0 1 0", "argument-count", 1),
            ("bone 0 0 0 1 0 0 turn 3 0 0 0", "out-of-range", 25),
            ("bone 0 0 0 1 0 0 parent -1", "out-of-range", 25),
            ("skin smooth 0", "out-of-range", 13),
            ("skin stiff", "unknown-word", 6),
        ]);
    }
}

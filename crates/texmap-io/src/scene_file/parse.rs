//! Text to statements: every check that needs no other file.

use std::path::Path;

use texmap_math::frame::TextureFrame;
use texmap_math::glam::DVec3;
use texmap_raster::Cull;
use texmap_render::{ColorMode, Gouraud};
use texmap_uv::Round;

use super::args::Args;
use super::classics;
use super::effects;
use super::shapes;
use super::token::{self, Token};
use super::{
    Alpha, Command, Missing, Rate, Role, RoundShape, SceneFile, Shade, Statement, Surf,
    TexturedCorner, words,
};
use crate::{IoError, Place};

/// Reads a scene file's text; `file` is only named in errors.
///
/// # Errors
/// The first thing that is wrong, with its line and column: a word that is no command, a wrong count of values, a
/// number that is none, not finite or out of range, an index without a vertex above, a face of fewer than three
/// corners, an unbalanced `push` or `pop`.
pub fn parse(file: &Path, text: &str) -> Result<SceneFile, IoError> {
    let mut parser = Parser {
        scene: SceneFile::default(),
        vertices: 0,
        open: Vec::new(),
    };
    let mut args: Option<Args<'_>> = None;
    for (content, line) in text.lines().zip(1..) {
        let tokens = token::words(content).map_err(|column| IoError::StrayQuote {
            place: Place::new(file, line, column),
        })?;
        let Some((&first, rest)) = tokens.split_first() else {
            continue;
        };
        if first.begins_number() {
            let Some(args) = &mut args else {
                return Err(IoError::StrayNumber {
                    place: Place::new(file, line, first.column),
                    text: first.text.into(),
                });
            };
            args.extend(line, &tokens);
            continue;
        }
        if let Some(complete) = args.take() {
            parser.statement(&complete)?;
        }
        let word = known_word(file, line, first)?;
        let mut next = Args::new(file, word, line, first.column);
        next.extend(line, rest);
        args = Some(next);
    }
    if let Some(complete) = args {
        parser.statement(&complete)?;
    }
    match parser.open.pop() {
        Some(place) => Err(IoError::OpenPush { place }),
        None => Ok(parser.scene),
    }
}

/// The word of every command.
pub const COMMANDS: [&str; 64] = [
    "eye",
    "look",
    "up",
    "fov",
    "near",
    "far",
    "background",
    "color",
    "la",
    "ld",
    "lp",
    "surf",
    "v",
    "f",
    "texture",
    "tf",
    "frame",
    "ff",
    "round",
    "filter",
    "wrap",
    "border",
    "interp",
    "cull",
    "alpha",
    "shade",
    "gouraud",
    "translate",
    "rotate",
    "scale",
    "push",
    "pop",
    "missing",
    "obj",
    "include",
    "ls",
    "name",
    "shadow",
    "shadowless",
    "projector",
    "highlight",
    "env",
    "specmap",
    "lightmap",
    "lightmapuv",
    "bump",
    "offsetmap",
    "carve",
    "emboss",
    "normalmap",
    "horizon",
    "solid",
    "ramp",
    "cel",
    "decal",
    "font",
    "text",
    "sky",
    "volume",
    "displace",
    "terrain",
    "billboard",
    "bone",
    "skin",
];

struct Parser {
    scene: SceneFile,
    vertices: usize,
    /// The `push` lines that wait for their `pop`.
    open: Vec<Place>,
}

impl Parser {
    fn statement(&mut self, args: &Args<'_>) -> Result<(), IoError> {
        let command = self.command(args)?;
        match command {
            Command::Vertex(_) => self.vertices += 1,
            Command::Push => self.open.push(args.word_place()),
            Command::Pop if self.open.pop().is_none() => {
                return Err(IoError::NeedsAbove {
                    place: args.word_place(),
                    command: "pop",
                    needs: "push",
                });
            }
            _ => {}
        }
        self.scene.statements.push(Statement {
            command,
            line: args.line,
            column: args.column,
        });
        Ok(())
    }

    fn command(&self, args: &Args<'_>) -> Result<Command, IoError> {
        if let Some(effect) = effects::parse(args)? {
            return Ok(Command::Effect(effect));
        }
        if let Some(classic) = classics::parse(args)? {
            return Ok(Command::Classic(classic));
        }
        if let Some(shape) = shapes::parse(args)? {
            return Ok(Command::Shape(shape));
        }
        Ok(match args.command {
            "eye" => Command::Eye(args.point()?),
            "look" => Command::Look(args.point()?),
            "up" => Command::Up(args.direction()?),
            "fov" => Command::Fov(args.one_number(
                |x| x > 0.0 && x < 180.0,
                "more than 0 and less than 180 degrees",
            )?),
            "near" => Command::Near(args.one_number(|x| x > 0.0, "a distance above 0")?),
            "far" if args.single_word("1 distance")? == "infinite" => Command::Far(f64::INFINITY),
            "far" => {
                Command::Far(args.one_number(|x| x > 0.0, "a distance above 0, or `infinite`")?)
            }
            "background" if args.len() == 3 => {
                let [r, g, b] = args.unit_floats::<3>(0, "3 or 4 numbers (r g b [a])")?;
                Command::Background([r, g, b, 1.0])
            }
            "background" => Command::Background(args.unit_floats(0, "3 or 4 numbers (r g b [a])")?),
            "color" => Command::Color(args.one_of(
                &[("srgb", ColorMode::Srgb), ("raw", ColorMode::Raw)],
                "srgb, raw",
            )?),
            "la" => {
                args.exactly(3, "3 numbers (r g b)")?;
                Command::AmbientLight(args.positive_floats(0)?)
            }
            "ld" => {
                args.exactly(6, "6 numbers (r g b x y z)")?;
                let direction = args.floats(3)?;
                args.check(3, direction != [0.0; 3], "a direction that is not zero")?;
                Command::DirectionalLight {
                    color: args.positive_floats(0)?,
                    direction,
                }
            }
            "lp" => {
                args.exactly(6, "6 numbers (r g b x y z)")?;
                Command::PointLight {
                    color: args.positive_floats(0)?,
                    position: args.floats(3)?,
                }
            }
            "surf" => surf(args)?,
            "v" => Command::Vertex(args.point()?),
            "f" => Command::Face(self.face(args)?),
            "ff" => Command::FramedFace(self.face(args)?),
            "tf" => Command::TexturedFace(self.textured_face(args)?),
            "texture" => texture(args)?,
            "frame" => frame(args)?,
            "round" => round(args)?,
            "filter" => {
                let name = args.single_word("1 method")?;
                Command::Filter(name.parse().map_err(|_| args.unknown(0, words::FILTERS))?)
            }
            "wrap" => {
                let count = args.len();
                args.within(1, 2, "1 or 2 modes (U [V])")?;
                let wrap = |i| {
                    args.text(i)
                        .parse()
                        .map_err(|_| args.unknown(i, words::WRAPS))
                };
                Command::Wrap(wrap(0)?, wrap(count - 1)?)
            }
            "border" => Command::Border(args.unit_floats(0, "4 numbers (r g b a)")?),
            "interp" => {
                let name = args.single_word("1 method")?;
                Command::Interp(
                    words::parse_interp(name).ok_or_else(|| args.unknown(0, words::INTERPS))?,
                )
            }
            "cull" => {
                let table = [
                    ("none", Cull::None),
                    ("back", Cull::Back),
                    ("front", Cull::Front),
                ];
                Command::Cull(args.one_of(&table, "none, back, front")?)
            }
            "alpha" => alpha(args)?,
            "shade" => shade(args)?,
            "gouraud" => {
                let table = [
                    ("screen", Gouraud::ScreenLinear),
                    ("perspective", Gouraud::Perspective),
                ];
                Command::Gouraud(args.one_of(&table, "screen, perspective")?)
            }
            "translate" => Command::Translate(args.point()?),
            "rotate" => {
                args.exactly(4, "4 numbers (degrees, x y z of the axis)")?;
                let axis = args.numbers(1)?;
                args.check(1, axis != [0.0; 3], "an axis that is not zero")?;
                let [angle] = args.numbers(0)?;
                Command::Rotate { angle, axis }
            }
            "scale" => scale(args)?,
            "push" | "pop" => {
                args.exactly(0, "no values")?;
                if args.command == "push" {
                    Command::Push
                } else {
                    Command::Pop
                }
            }
            "missing" => Command::Missing(args.one_of(
                &[("error", Missing::Error), ("warn", Missing::Warn)],
                "error, warn",
            )?),
            "obj" => Command::Obj(args.path()?),
            // `known_word` lets no other word through.
            _ => Command::Include(args.path()?),
        })
    }

    fn face(&self, args: &Args<'_>) -> Result<Vec<u32>, IoError> {
        if args.len() < 3 {
            return Err(args.too_few_corners(args.len()));
        }
        (0..args.len())
            .map(|i| args.index(i, self.vertices))
            .collect()
    }

    fn textured_face(&self, args: &Args<'_>) -> Result<Vec<TexturedCorner>, IoError> {
        if !args.len().is_multiple_of(3) {
            return Err(args.count_error("3 numbers a corner (i u v)"));
        }
        if args.len() < 9 {
            return Err(args.too_few_corners(args.len() / 3));
        }
        (0..args.len())
            .step_by(3)
            .map(|i| {
                Ok(TexturedCorner {
                    vertex: args.index(i, self.vertices)?,
                    uv: args.floats(i + 1)?,
                })
            })
            .collect()
    }
}

fn surf(args: &Args<'_>) -> Result<Command, IoError> {
    args.exactly(7, "7 numbers (r g b ka kd ks ns)")?;
    let [ka, kd, ks, ns] = args.positive_floats(3)?;
    let color = args.floats(0)?;
    for (i, c) in color.iter().enumerate() {
        args.check(i, (0.0..=1.0).contains(c), "0 to 1")?;
    }
    Ok(Command::Surf(Surf {
        color,
        ka,
        kd,
        ks,
        ns,
    }))
}

fn texture(args: &Args<'_>) -> Result<Command, IoError> {
    let path = args.path()?;
    let none = path == "none" && !args.quoted(0);
    Ok(Command::Texture((!none).then_some(path)))
}

fn frame(args: &Args<'_>) -> Result<Command, IoError> {
    args.exactly(9, "9 numbers (O, U, V)")?;
    let (o, u, v) = (args.numbers(0)?, args.numbers(3)?, args.numbers(6)?);
    TextureFrame::new(DVec3::from(o), DVec3::from(u), DVec3::from(v)).map_err(|e| {
        IoError::DegenerateFrame {
            place: args.word_place(),
            problem: e.to_string(),
        }
    })?;
    Ok(Command::Frame { o, u, v })
}

fn round(args: &Args<'_>) -> Result<Command, IoError> {
    const ALLOWED: &str =
        "none; or sphere or cylinder with position, angles and size (9 numbers) [and repeat u v]";
    args.within(1, 12, ALLOWED)?;
    let shape = match (args.text(0), args.len()) {
        ("none", 1) => return Ok(Command::Round(None)),
        ("sphere", 10 | 12) => Round::Sphere,
        ("cylinder", 10 | 12) => Round::Cylinder,
        ("none" | "sphere" | "cylinder", _) => return Err(args.count_error(ALLOWED)),
        _ => return Err(args.unknown(0, ALLOWED)),
    };
    let (position, angles, size) = (args.numbers(1)?, args.numbers(4)?, args.numbers(7)?);
    let repeat = match args.len() {
        12 => args.numbers(10)?,
        _ => [1.0; 2],
    };
    for i in 7..args.len() {
        let [value] = args.numbers(i)?;
        args.check(i, value != 0.0, "a number that is not 0")?;
    }
    Ok(Command::Round(Some(RoundShape {
        shape,
        position,
        angles,
        size,
        repeat,
    })))
}

fn alpha(args: &Args<'_>) -> Result<Command, IoError> {
    const ALLOWED: &str = "auto, opaque, test [threshold], blend";
    args.within(1, 2, ALLOWED)?;
    let threshold = || {
        let [t] = args.floats(1)?;
        args.check(1, t > 0.0 && t <= 1.0, "a threshold above 0, up to 1")?;
        Ok(t)
    };
    Ok(Command::Alpha(match (args.text(0), args.len()) {
        ("auto", 1) => Alpha::Auto,
        ("opaque", 1) => Alpha::Opaque,
        ("blend", 1) => Alpha::Blend,
        ("test", 1) => Alpha::Test(None),
        ("test", _) => Alpha::Test(Some(threshold()?)),
        _ => return Err(args.unknown(0, ALLOWED)),
    }))
}

fn shade(args: &Args<'_>) -> Result<Command, IoError> {
    const ALLOWED: &str = "decal or modulate, and vertex or pixel; each at most once";
    args.within(1, 2, "1 or 2 words")?;
    let mut shade = Shade::default();
    for i in 0..args.len() {
        let unset = match args.text(i) {
            "decal" => shade.role.replace(Role::Decal).is_none(),
            "modulate" => shade.role.replace(Role::Modulate).is_none(),
            "vertex" => shade.rate.replace(Rate::Vertex).is_none(),
            "pixel" => shade.rate.replace(Rate::Pixel).is_none(),
            _ => false,
        };
        if !unset {
            return Err(args.unknown(i, ALLOWED));
        }
    }
    Ok(Command::Shade(shade))
}

fn scale(args: &Args<'_>) -> Result<Command, IoError> {
    let factors = if args.len() == 1 {
        [args.numbers::<1>(0)?[0]; 3]
    } else {
        args.exactly(3, "1 or 3 numbers")
            .and_then(|()| args.numbers(0))?
    };
    for (i, f) in factors.iter().enumerate() {
        args.check(i.min(args.len() - 1), *f != 0.0, "any number but 0")?;
    }
    Ok(Command::Scale(factors))
}

fn known_word(file: &Path, line: u32, token: Token<'_>) -> Result<&'static str, IoError> {
    if let Some(word) = COMMANDS.iter().find(|w| **w == token.text && !token.quoted) {
        return Ok(word);
    }
    let distance = |word: &&str| edit_distance(&token.text.to_lowercase(), word);
    let nearest = COMMANDS.iter().copied().min_by_key(distance);
    // One slip in a short word, two in a longer one.
    let allowed = if token.text.len() <= 4 { 1 } else { 2 };
    Err(IoError::UnknownCommand {
        place: Place::new(file, line, token.column),
        word: token.text.chars().take(40).collect(),
        nearest: nearest.filter(|word| token.text.len() < 40 && distance(word) <= allowed),
    })
}

/// Insertions, deletions and replacements that make `a` from `b` (Levenshtein).
fn edit_distance(a: &str, b: &str) -> usize {
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.bytes().enumerate() {
        let mut diagonal = i;
        row[0] = i + 1;
        for (j, y) in b.bytes().enumerate() {
            let replaced = diagonal + usize::from(x != y);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(diagonal + 1).min(row[j] + 1);
        }
    }
    row[b.len()]
}

impl Command {
    /// The word that begins its line.
    pub fn word(&self) -> &'static str {
        match self {
            Self::Eye(_) => "eye",
            Self::Look(_) => "look",
            Self::Up(_) => "up",
            Self::Fov(_) => "fov",
            Self::Near(_) => "near",
            Self::Far(_) => "far",
            Self::Background(_) => "background",
            Self::Color(_) => "color",
            Self::AmbientLight(_) => "la",
            Self::DirectionalLight { .. } => "ld",
            Self::PointLight { .. } => "lp",
            Self::Surf(_) => "surf",
            Self::Vertex(_) => "v",
            Self::Face(_) => "f",
            Self::Texture(_) => "texture",
            Self::TexturedFace(_) => "tf",
            Self::Frame { .. } => "frame",
            Self::Round(_) => "round",
            Self::FramedFace(_) => "ff",
            Self::Filter(_) => "filter",
            Self::Wrap(..) => "wrap",
            Self::Border(_) => "border",
            Self::Interp(_) => "interp",
            Self::Cull(_) => "cull",
            Self::Alpha(_) => "alpha",
            Self::Shade(_) => "shade",
            Self::Gouraud(_) => "gouraud",
            Self::Translate(_) => "translate",
            Self::Rotate { .. } => "rotate",
            Self::Scale(_) => "scale",
            Self::Push => "push",
            Self::Pop => "pop",
            Self::Missing(_) => "missing",
            Self::Obj(_) => "obj",
            Self::Include(_) => "include",
            Self::Effect(effect) => effect.word(),
            Self::Classic(classic) => classic.word(),
            Self::Shape(shape) => shape.word(),
        }
    }
}

/// Each line of text is refused, by this code at this column.
#[cfg(test)]
pub(super) fn assert_faults(cases: &[(&str, &str, u32)]) {
    for (text, code, column) in cases {
        let error = parse(Path::new("a.scene"), text).unwrap_err();
        let place = error.place().unwrap();
        assert_eq!(
            (error.code(), place.column),
            (*code, *column),
            "{text}: {error}"
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scene(text: &str) -> Result<SceneFile, IoError> {
        parse(Path::new("a.scene"), text)
    }

    fn error(text: &str) -> (&'static str, u32, u32) {
        let error = scene(text).unwrap_err();
        let place = error.place().expect("every parse error has a place");
        (error.code(), place.line, place.column)
    }

    #[test]
    fn lines_that_begin_with_a_number_continue_the_command_above() {
        let a = scene(
            "v 0 0 0\nv 1 0 0 # corner\n\nv 1\n  1 0\ntf 0 0 0\n   1 1 0\n# between\n   2 1 1\n",
        )
        .unwrap();
        let b = scene("v 0 0 0\nv 1 0 0\nv 1 1 0\ntf 0 0 0 1 1 0 2 1 1").unwrap();
        assert!(a.commands().eq(b.commands()));
        assert_eq!((a.statements[3].line, a.statements[3].column), (6, 1));
        assert_eq!(error("# nothing\n 1 2 3"), ("stray-number", 2, 2));
        assert_eq!(error("eye 0 0\n\n 1 2"), ("argument-count", 3, 4));
    }

    #[test]
    fn exponents_paths_and_underscores_are_read() {
        let s = scene("eye 1e-3 -2E2 .5\ntexture tex/wall_1.gif\ntexture 2nd.png\ntexture \"a b.png\"\ntexture none\ntexture \"none\"\nfar infinite").unwrap();
        let commands: Vec<_> = s.commands().cloned().collect();
        assert_eq!(commands[0], Command::Eye([1e-3, -200.0, 0.5]));
        let names: Vec<_> = commands[1..6]
            .iter()
            .map(|c| match c {
                Command::Texture(name) => name.as_deref(),
                _ => Some("not a texture"),
            })
            .collect();
        assert_eq!(
            names,
            [
                Some("tex/wall_1.gif"),
                Some("2nd.png"),
                Some("a b.png"),
                None,
                Some("none")
            ]
        );
        assert_eq!(commands[6], Command::Far(f64::INFINITY));
    }

    #[test]
    fn errors_stand_where_the_fault_is() {
        let three = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
        let cases = [
            ("eye 0 0 6\nlok 0 1 6", "unknown-command", 2, 1),
            ("eye 0 0", "argument-count", 1, 1),
            ("eye 0 0 6 7", "argument-count", 1, 11),
            ("eye 0 zero 6", "not-a-number", 1, 7),
            ("eye 0 1e-3- 6", "not-a-number", 1, 7),
            ("v 0 nan 0", "not-finite", 1, 5),
            ("v 0 0 1e400", "not-finite", 1, 7),
            ("v inf 0 0", "not-finite", 1, 3),
            ("fov 180", "out-of-range", 1, 5),
            ("near 0", "out-of-range", 1, 6),
            ("up 0 0 0", "out-of-range", 1, 4),
            ("ld 1 1 1 0 0 0", "out-of-range", 1, 10),
            ("la -1 0 0", "out-of-range", 1, 4),
            ("surf 2 0 0 1 1 1 5", "out-of-range", 1, 6),
            ("surf 1 0 0 1 1 1 -5", "out-of-range", 1, 18),
            ("scale 1 0 1", "out-of-range", 1, 9),
            ("rotate 30 0 0 0", "out-of-range", 1, 11),
            ("frame 0 0 0 1 0 0 2 0 0", "degenerate-frame", 1, 1),
            ("round torus 0 0 0 0 0 0 1 1 1", "unknown-word", 1, 7),
            ("round sphere 0 0 0 0 0 0 1 1", "argument-count", 1, 1),
            ("round cylinder 0 0 0 0 0 0 1 0 1", "out-of-range", 1, 30),
            ("round sphere 0 0 0 0 0 0 1 1 1 2 0", "out-of-range", 1, 34),
            ("filter blurry", "unknown-word", 1, 8),
            ("filter anisotropic:99", "unknown-word", 1, 8),
            ("wrap repeat sideways", "unknown-word", 1, 13),
            ("interp span:0", "unknown-word", 1, 8),
            ("cull left", "unknown-word", 1, 6),
            ("alpha test 2", "out-of-range", 1, 12),
            ("alpha test 0", "out-of-range", 1, 12),
            ("shade decal modulate", "unknown-word", 1, 13),
            ("color rgb", "unknown-word", 1, 7),
            ("texture \"open.png", "stray-quote", 1, 9),
            ("texture my wall.png", "argument-count", 1, 12),
            ("texture", "argument-count", 1, 1),
            ("pop", "needs-line-above", 1, 1),
            ("v 0 0 0\n  push\nv 0 0 1", "open-push", 2, 3),
        ];
        for (text, code, line, column) in cases {
            assert_eq!(error(text), (code, line, column), "{text}");
        }
        for (text, code, line, column) in [
            ("f 0 1", "too-few-corners", 4, 1),
            ("f 0 1 3", "bad-index", 4, 7),
            ("f 0 1 -1", "bad-index", 4, 7),
            ("f 0 1 2.5", "bad-index", 4, 7),
            ("f 0 1 1000000000", "bad-index", 4, 7),
            ("f 0 1 99999999999999999999", "bad-index", 4, 7),
            ("f 0 1 x", "not-a-number", 4, 7),
            ("tf 0 0 0 1 1 0", "too-few-corners", 4, 1),
            ("tf 0 0 0 1 1 0 2 1", "argument-count", 4, 1),
            ("tf 0 0 0 1 1 0 2 1 nan", "not-finite", 4, 20),
        ] {
            assert_eq!(
                error(&format!("{three}{text}")),
                (code, line, column),
                "{text}"
            );
        }
    }

    #[test]
    fn a_slip_of_the_pen_gets_a_suggestion() {
        let nearest = |text| match scene(text).unwrap_err() {
            IoError::UnknownCommand { nearest, .. } => nearest,
            other => panic!("{other}"),
        };
        assert_eq!(nearest("textrue a.png"), Some("texture"));
        assert_eq!(nearest("Eye 0 0 0"), Some("eye"));
        assert_eq!(nearest("hello"), None);
        assert_eq!(nearest("translte 1 2 3"), Some("translate"));
    }
}

//! Text to statements: every check that needs no other file.

use std::path::Path;

use texmap_scene::ColorMode;

use super::args::Args;
use super::classics;
use super::commands::known_word;
use super::effects;
use super::settings;
use super::shapes;
use super::token;
use super::{Command, SceneFile, Statement, TexturedCorner};
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
                }
                .without_words());
            };
            args.extend(line, &tokens);
            continue;
        }
        if let Some(complete) = args.take() {
            parser.statement(&complete)?;
        }
        // A file that does not begin like a scene may be anything: nothing of it is quoted.
        let foreign = parser.scene.statements.is_empty();
        let word = known_word(file, line, first).map_err(|error| match foreign {
            true => error.without_words(),
            false => error,
        })?;
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
        if let Some(setting) = settings::parse(args)? {
            return Ok(setting);
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
            "v" => Command::Vertex(args.point()?),
            "f" => Command::Face(self.face(args)?),
            "ff" => Command::FramedFace(self.face(args)?),
            "tf" => Command::TexturedFace(self.textured_face(args)?),
            "push" | "pop" => {
                args.exactly(0, "no values")?;
                if args.command == "push" {
                    Command::Push
                } else {
                    Command::Pop
                }
            }
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

/// Each line of text is a command of this kind, printed as it was read.
#[cfg(test)]
pub(super) fn assert_reads_back(is: fn(&Command) -> bool, cases: &[&str]) {
    for text in cases {
        let file = parse(Path::new("a.scene"), text).unwrap_or_else(|e| panic!("{text}: {e}"));
        assert!(is(&file.statements[0].command), "{text}");
        assert_eq!(super::print(&file), *text);
    }
}

/// Each line of text is refused, by this code at this column of the first line.
#[cfg(test)]
pub(super) fn assert_faults(cases: &[(&str, &str, u32)]) {
    for (text, code, column) in cases {
        let error = parse(Path::new("a.scene"), text).unwrap_err();
        let place = error.place().unwrap();
        assert_eq!(
            (error.code(), place.line, place.column),
            (*code, 1, *column),
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
            ("color rgb", "unknown-word", 1, 7),
            ("texture \"open.png", "stray-quote", 1, 9),
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
}

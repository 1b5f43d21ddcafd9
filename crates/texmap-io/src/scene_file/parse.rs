//! Text to statements: every check that needs no other file.

use std::path::Path;

use super::args::Args;
use super::token::{self, Token};
use super::{SceneFile, Statement};
use crate::scene::{Spec, command, nearest};
use crate::{IoError, SourceLocation};

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
            location: SourceLocation::new(file, line, column),
        })?;
        let Some((&first, rest)) = tokens.split_first() else {
            continue;
        };
        if first.begins_number() {
            let Some(args) = &mut args else {
                return Err(IoError::StrayNumber {
                    location: SourceLocation::new(file, line, first.column),
                    text: first.text.into(),
                }
                .without_words());
            };
            args.extend(line, &tokens);
            continue;
        }
        if let Some(complete) = args.take() {
            parser.statement(complete)?;
        }
        // A file that does not begin like a scene may be anything: no word of the file is quoted.
        let foreign = parser.scene.statements.is_empty();
        let spec = spec(file, line, first).map_err(|error| match foreign {
            true => error.without_words(),
            false => error,
        })?;
        let mut next = Args::new(file, spec, line, first.column);
        next.extend(line, rest);
        args = Some(next);
    }
    if let Some(complete) = args {
        parser.statement(complete)?;
    }
    match parser.open.pop() {
        Some(location) => Err(IoError::OpenPush { location }),
        None => Ok(parser.scene),
    }
}

/// The row of the table for the word that begins a line.
fn spec(file: &Path, line: u32, token: Token<'_>) -> Result<&'static Spec, IoError> {
    let known = command(token.text).filter(|_| !token.quoted);
    known.ok_or_else(|| IoError::UnknownCommand {
        location: SourceLocation::new(file, line, token.column),
        word: token.text.chars().take(40).collect(),
        nearest: nearest(token.text),
    })
}

struct Parser {
    scene: SceneFile,
    vertices: usize,
    /// The `push` lines that wait for their `pop`.
    open: Vec<SourceLocation>,
}

impl Parser {
    fn statement(&mut self, args: Args<'_>) -> Result<(), IoError> {
        let (line, column, location) = (args.line, args.column, args.word_location());
        let command = args.read(self.vertices)?;
        match command.word() {
            "v" => self.vertices += 1,
            "push" => self.open.push(location),
            "pop" if self.open.pop().is_none() => {
                return Err(IoError::NeedsAbove {
                    location,
                    command: "pop",
                    needs: "a `push` line",
                });
            }
            _ => {}
        }
        self.scene.statements.push(Statement {
            command,
            line,
            column,
        });
        Ok(())
    }
}

/// Each line of text is printed as it was read.
#[cfg(test)]
pub(crate) fn assert_reads_back(cases: &[&str]) {
    for text in cases {
        let file = parse(Path::new("a.scene"), text).unwrap_or_else(|e| panic!("{text}: {e}"));
        assert_eq!(super::print(&file), *text);
    }
}

/// Each line of text is refused, by this code at this column of the first line.
#[cfg(test)]
pub(crate) fn assert_faults(cases: &[(&str, &str, u32)]) {
    for (text, code, column) in cases {
        let error = parse(Path::new("a.scene"), text).unwrap_err();
        let location = error.location().unwrap();
        assert_eq!(
            (error.code(), location.line, location.column),
            (*code, 1, *column),
            "{text}: {error}"
        );
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Command, Value};
    use super::*;

    fn scene(text: &str) -> Result<SceneFile, IoError> {
        parse(Path::new("a.scene"), text)
    }

    fn error(text: &str) -> (&'static str, u32, u32) {
        let error = scene(text).unwrap_err();
        let location = error.location().expect("every parse error has a place");
        (error.code(), location.line, location.column)
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
        let values: Vec<_> = s.commands().map(Command::values).collect();
        let numbers = [1e-3, -200.0, 0.5].map(Value::Number);
        assert_eq!(values[0], numbers);
        let files = ["tex/wall_1.gif", "2nd.png", "a b.png"].map(|name| [Value::File(name.into())]);
        assert_eq!(values[1..4], files);
        assert_eq!(values[4], [Value::Word("none")]);
        assert_eq!(values[5], [Value::File("none".into())]);
        assert_eq!(values[6], [Value::Word("infinite")]);
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

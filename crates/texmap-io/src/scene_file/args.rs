//! The words after a command, read by the arguments that its row of the table has.

use std::path::Path;
use std::str::FromStr;

use texmap_math::glam::DVec3;
use texmap_math::texture_frame::TextureFrame;

use super::grammar::{Arg, Check, range, usage, words};
use super::token::Token;
use super::value::{Command, Value};
use crate::scene::Spec;
use crate::{IoError, SourceLocation};

/// The most numbers of one argument.
const MOST_NUMBERS: usize = 9;

/// A command's word and the words after it, which may stand on several lines.
#[derive(Debug)]
pub(super) struct Args<'a> {
    spec: &'static Spec,
    pub(super) line: u32,
    pub(super) column: u32,
    file: &'a Path,
    tokens: Vec<(u32, Token<'a>)>,
    /// Vertices above it.
    vertices: usize,
    /// The values that were read.
    values: Vec<Value>,
}

impl<'a> Args<'a> {
    pub(super) fn new(file: &'a Path, spec: &'static Spec, line: u32, column: u32) -> Self {
        Self {
            spec,
            line,
            column,
            file,
            tokens: Vec::new(),
            vertices: 0,
            values: Vec::new(),
        }
    }

    pub(super) fn extend(&mut self, line: u32, tokens: &[Token<'a>]) {
        self.tokens.extend(tokens.iter().map(|t| (line, *t)));
    }

    /// The command with its values, below so many vertices.
    pub(super) fn read(mut self, vertices: usize) -> Result<Command, IoError> {
        self.vertices = vertices;
        self.values.reserve_exact(self.tokens.len());
        self.list(self.spec.args, 0, true)?;
        Ok(Command {
            spec: self.spec,
            values: self.values,
        })
    }

    /// Reads a list of arguments from word `at` on; `last`, if the line ends with it. Returns the word after it.
    fn list(&mut self, args: &[Arg], mut at: usize, last: bool) -> Result<usize, IoError> {
        if last {
            self.count(at, range(args))?;
        }
        for (i, arg) in args.iter().enumerate() {
            at = self.arg(arg, at, last && i + 1 == args.len())?;
        }
        Ok(at)
    }

    fn arg(&mut self, arg: &Arg, at: usize, last: bool) -> Result<usize, IoError> {
        let end = at + arg.range().0;
        match arg {
            Arg::Numbers(_, check) => {
                let mut numbers = [0.0; MOST_NUMBERS];
                for (i, x) in (at..end).zip(&mut numbers) {
                    *x = self.number(i)?;
                    self.values.push(Value::Number(*x));
                }
                self.check(at, &numbers[..end - at], *check)?;
            }
            Arg::Floats(_, check) => {
                let mut numbers = [0.0; MOST_NUMBERS];
                for (i, x) in (at..end).zip(&mut numbers) {
                    let value = self.float(i)?;
                    self.values.push(Value::Float(value));
                    *x = f64::from(value);
                }
                self.check(at, &numbers[..end - at], *check)?;
            }
            Arg::Frame => {
                for i in at..end {
                    let x = self.number(i)?;
                    self.values.push(Value::Number(x));
                }
                self.frame()?;
            }
            Arg::OneOf(words) => {
                let found = words.iter().find(|word| **word == self.text(at)).copied();
                let word = found.ok_or_else(|| self.unknown(at, words.join(", ")))?;
                self.values.push(Value::Word(word));
            }
            Arg::Method(_, allowed, is) => {
                if !is(self.text(at)) {
                    return Err(self.unknown(at, allowed()));
                }
                self.values.push(Value::Name(self.text(at).into()));
            }
            Arg::Name(problem) | Arg::Text(problem) => {
                let text = self.text(at);
                if let Some(allowed) = problem(text) {
                    return Err(self.out_of_range(at, allowed));
                }
                self.values.push(match arg {
                    Arg::Text(_) => Value::Text(text.into()),
                    _ => Value::Name(text.into()),
                });
            }
            Arg::File => {
                if self.text(at).is_empty() {
                    return Err(self.out_of_range(at, "a file name that is not empty"));
                }
                self.values.push(Value::File(self.text(at).into()));
            }
            Arg::Corners => return self.corners(at, 1),
            Arg::TexturedCorners => return self.corners(at, 3),
            Arg::Optional(args) => {
                let begins = match last {
                    true => at < self.tokens.len(),
                    false => self.tokens.get(at).is_some_and(|(_, token)| {
                        token.begins_number() || words(args).contains(&token.text)
                    }),
                };
                return match begins {
                    true => self.list(args, at, last),
                    false => Ok(at),
                };
            }
            Arg::Options(options) => {
                let mut at = at;
                while at < self.tokens.len() {
                    let option = options
                        .iter()
                        .find(|args| leading(args).contains(&self.text(at)));
                    let option = option.ok_or_else(|| {
                        let all = options.iter().map(|args| usage(args, ""));
                        self.unknown(at, all.collect::<Vec<_>>().join(", "))
                    })?;
                    if self.tokens.len() - at < range(option).0 {
                        return Err(self.count_error(usize::MAX, usage_or_none(self.spec.args)));
                    }
                    at = self.list(option, at, false)?;
                }
                return Ok(at);
            }
            Arg::Either(alternatives) => {
                let args = self.alternative(alternatives, at, last)?;
                return self.list(args, at, last);
            }
        }
        Ok(end)
    }

    /// The alternative that the words from `at` on are: by its first word, or else by their number.
    fn alternative<'b>(
        &self,
        alternatives: &[&'b [Arg]],
        at: usize,
        last: bool,
    ) -> Result<&'b [Arg], IoError> {
        let left = self.tokens.len() - at.min(self.tokens.len());
        let fits = |args: &[Arg]| {
            let (least, most) = range(args);
            !last || (least..=most).contains(&left)
        };
        let (worded, other): (Vec<_>, Vec<_>) = alternatives
            .iter()
            .copied()
            .partition(|args| !leading(args).is_empty());
        let quoted = self.tokens.get(at).is_some_and(|(_, token)| token.quoted);
        let named = worded.iter().find(|args| {
            // A file may have the name of a word.
            leading(args).contains(&self.text(at)) && (other.is_empty() || !quoted && fits(args))
        });
        if let Some(args) = named {
            return Ok(args);
        }
        let found = other.iter().find(|args| fits(args)).or(other.last());
        found.copied().ok_or_else(|| {
            let words: Vec<_> = worded
                .iter()
                .flat_map(|args| leading(args))
                .copied()
                .collect();
            self.unknown(at, words.join(", "))
        })
    }

    /// Faces: corners of so many values, the first an index.
    fn corners(&mut self, at: usize, values: usize) -> Result<usize, IoError> {
        let found = self.tokens.len() - at;
        if !found.is_multiple_of(values) {
            return Err(self.count_error(usize::MAX, "3 numbers a corner (i u v)".into()));
        }
        if found < 3 * values {
            return Err(IoError::TooFewCorners {
                location: self.word_location(),
                command: self.spec.word,
                found: found / values,
            });
        }
        for i in 0..found {
            let value = match i % values {
                0 => Value::Index(self.index(at + i)?),
                _ => Value::Float(self.float(at + i)?),
            };
            self.values.push(value);
        }
        Ok(self.tokens.len())
    }

    fn count(&self, at: usize, (least, most): (usize, usize)) -> Result<(), IoError> {
        let found = self.tokens.len().saturating_sub(at);
        if (least..=most).contains(&found) {
            return Ok(());
        }
        // The first value too many, or the command that lacks one.
        let i = if found > most { at + most } else { usize::MAX };
        Err(self.count_error(i, usage_or_none(self.spec.args)))
    }

    fn count_error(&self, i: usize, expected: String) -> IoError {
        IoError::ArgumentCount {
            location: self.location(i),
            command: self.spec.word,
            expected: expected.into(),
            found: self.tokens.len(),
        }
    }

    fn number(&self, i: usize) -> Result<f64, IoError> {
        let value = self.parse::<f64>(i)?;
        // Positions become 32-bit floats, so that is the limit for all.
        if value.is_nan() || value.abs() > f64::from(f32::MAX) {
            return Err(self.not_finite(i));
        }
        Ok(value)
    }

    fn float(&self, i: usize) -> Result<f32, IoError> {
        let value = self.parse::<f32>(i)?;
        match value.is_finite() {
            true => Ok(value),
            false => Err(self.not_finite(i)),
        }
    }

    /// An index of a vertex above.
    fn index(&self, i: usize) -> Result<u32, IoError> {
        match self.text(i).parse::<u32>() {
            Ok(index) if (index as usize) < self.vertices => Ok(index),
            _ if self.text(i).parse::<f64>().is_err() => Err(self.not_a_number(i)),
            _ => Err(IoError::BadIndex {
                location: self.location(i),
                of: "vertex",
                index: self.text(i).into(),
                count: self.vertices,
            }),
        }
    }

    fn parse<T: FromStr>(&self, i: usize) -> Result<T, IoError> {
        let quoted = self.tokens.get(i).is_some_and(|(_, token)| token.quoted);
        match self.text(i).parse() {
            Ok(value) if !quoted => Ok(value),
            _ => Err(self.not_a_number(i)),
        }
    }

    fn check(&self, at: usize, numbers: &[f64], check: Check) -> Result<(), IoError> {
        let problem = (0..numbers.len()).find_map(|i| Some((i, check(numbers, i)?)));
        problem.map_or(Ok(()), |(i, allowed)| {
            Err(self.out_of_range(at + i, allowed))
        })
    }

    /// U and V of a frame that was read must span a plane.
    fn frame(&self) -> Result<(), IoError> {
        let number = |i: usize| match self.values[i] {
            Value::Number(x) => x,
            _ => 0.0,
        };
        let [o, u, v] = [0, 3, 6].map(|i| DVec3::new(number(i), number(i + 1), number(i + 2)));
        TextureFrame::new(o, u, v)
            .map(|_| ())
            .map_err(|e| IoError::DegenerateFrame {
                location: self.word_location(),
                problem: e.to_string(),
            })
    }

    fn text(&self, i: usize) -> &'a str {
        self.tokens.get(i).map_or("", |(_, token)| token.text)
    }

    pub(super) fn word_location(&self) -> SourceLocation {
        SourceLocation::new(self.file, self.line, self.column)
    }

    /// Location of value `i`, or of the command where there is none.
    fn location(&self, i: usize) -> SourceLocation {
        match self.tokens.get(i) {
            Some((line, token)) => SourceLocation::new(self.file, *line, token.column),
            None => self.word_location(),
        }
    }

    fn out_of_range(&self, i: usize, allowed: &'static str) -> IoError {
        IoError::OutOfRange {
            location: self.location(i),
            command: self.spec.word,
            text: self.text(i).into(),
            allowed,
        }
    }

    fn unknown(&self, i: usize, allowed: String) -> IoError {
        IoError::UnknownWord {
            location: self.location(i),
            command: self.spec.word,
            word: self.text(i).into(),
            allowed: allowed.into(),
        }
    }

    fn not_a_number(&self, i: usize) -> IoError {
        IoError::NotANumber {
            location: self.location(i),
            command: self.spec.word,
            text: self.text(i).into(),
        }
    }

    fn not_finite(&self, i: usize) -> IoError {
        IoError::NotFinite {
            location: self.location(i),
            command: self.spec.word,
            text: self.text(i).into(),
        }
    }
}

/// The words that may begin a list of arguments; none if other values may begin it.
fn leading(args: &[Arg]) -> &'static [&'static str] {
    match args.first() {
        Some(Arg::OneOf(words)) => words,
        _ => &[],
    }
}

fn usage_or_none(args: &[Arg]) -> String {
    match args {
        [] => "no values".into(),
        _ => usage(args, ""),
    }
}

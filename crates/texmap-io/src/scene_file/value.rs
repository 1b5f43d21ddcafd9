//! Commands as they were read: a row of the table and its values.

use std::fmt;

use super::grammar;
use crate::scene::Spec;
use crate::{IoError, SourceLocation};

/// One value of a command.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    /// A number of 64 bits.
    Number(f64),
    /// A number of 32 bits.
    Float(f32),
    /// The index of a vertex, from 0.
    Index(u32),
    /// A word of the language.
    Word(&'static str),
    /// A method with its parameters, or a name.
    Name(Box<str>),
    /// The name of a file, as the line has it.
    File(Box<str>),
    /// Words for people.
    Text(Box<str>),
}

/// One command: its row of the table, and the values of the line.
///
/// `Display` writes the line: numbers in their shortest exact form, without blanks at the end.
#[derive(Clone, PartialEq)]
pub struct Command {
    pub(super) spec: &'static Spec,
    pub(super) values: Vec<Value>,
}

impl Command {
    /// The word that begins the line.
    pub fn word(&self) -> &'static str {
        self.spec.word
    }

    /// The values in the order of the line.
    pub fn values(&self) -> &[Value] {
        &self.values
    }

    pub(crate) fn spec(&self) -> &'static Spec {
        self.spec
    }

    /// The values for the row's `set`.
    pub(crate) fn line(&self, location: SourceLocation) -> Line<'_> {
        Line {
            command: self.spec.word,
            location,
            values: self.values.iter(),
        }
    }
}

impl fmt::Debug for Command {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "`{self}`")
    }
}

impl fmt::Display for Command {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.spec.word)?;
        for value in &self.values {
            f.write_str(" ")?;
            match value {
                Value::Number(x) if exponent(x.abs()) => write!(f, "{x:e}"),
                Value::Number(x) => write!(f, "{x}"),
                Value::Float(x) if exponent(f64::from(x.abs())) => write!(f, "{x:e}"),
                Value::Float(x) => write!(f, "{x}"),
                Value::Index(i) => write!(f, "{i}"),
                Value::Word(word) => f.write_str(word),
                Value::Name(name) => f.write_str(name),
                Value::Text(text) => write!(f, "\"{text}\""),
                Value::File(name) => {
                    let blank = |c: char| c.is_whitespace() || c == '#';
                    // A file called `none` is not the word `none`.
                    let word = || grammar::words(self.spec.args).contains(&&**name);
                    if name.is_empty() || name.contains(blank) || word() {
                        write!(f, "\"{name}\"")
                    } else {
                        f.write_str(name)
                    }
                }
            }?;
        }
        Ok(())
    }
}

/// True for a magnitude that is shorter with an exponent.
fn exponent(magnitude: f64) -> bool {
    magnitude != 0.0 && !(1e-5..1e16).contains(&magnitude)
}

/// The values of a command one after the other, in the order of its row's arguments, and its position.
#[derive(Debug, Clone)]
pub(crate) struct Line<'a> {
    pub(crate) command: &'static str,
    pub(crate) location: SourceLocation,
    values: std::slice::Iter<'a, Value>,
}

impl<'a> Line<'a> {
    pub(crate) fn number(&mut self) -> f64 {
        match self.values.next() {
            Some(Value::Number(x)) => *x,
            other => self.unexpected(other),
        }
    }

    pub(crate) fn numbers<const N: usize>(&mut self) -> [f64; N] {
        std::array::from_fn(|_| self.number())
    }

    /// A number that the arguments say is whole.
    pub(crate) fn whole(&mut self) -> u32 {
        self.number() as u32
    }

    pub(crate) fn float(&mut self) -> f32 {
        match self.values.next() {
            Some(Value::Float(x)) => *x,
            other => self.unexpected(other),
        }
    }

    pub(crate) fn floats<const N: usize>(&mut self) -> [f32; N] {
        std::array::from_fn(|_| self.float())
    }

    /// The next value, if it is a number.
    pub(crate) fn optional_number(&mut self) -> Option<f64> {
        matches!(self.values.as_slice(), [Value::Number(_), ..]).then(|| self.number())
    }

    /// The next value, if it is a number of 32 bits.
    pub(crate) fn optional_float(&mut self) -> Option<f32> {
        matches!(self.values.as_slice(), [Value::Float(_), ..]).then(|| self.float())
    }

    /// All corners of a face, with their coordinates where they have some.
    pub(crate) fn corners(&mut self) -> Vec<(u32, [f32; 2])> {
        let mut corners = Vec::with_capacity(self.values.len());
        while let Some(Value::Index(index)) = self.values.next() {
            let uv = matches!(self.values.as_slice(), [Value::Float(_), ..]);
            corners.push((*index, if uv { self.floats() } else { [0.0; 2] }));
        }
        corners
    }

    /// A method in the type that reads it.
    pub(crate) fn parsed<T: std::str::FromStr>(&mut self) -> T {
        let name = self.name();
        match name.parse() {
            Ok(method) => method,
            Err(_) => self.unexpected(Some(&Value::Name(name.into()))),
        }
    }

    pub(crate) fn name(&mut self) -> &'a str {
        match self.values.next() {
            Some(Value::Name(text) | Value::File(text) | Value::Text(text)) => text,
            other => self.unexpected(other),
        }
    }

    /// The next value, if it is a word.
    pub(crate) fn word(&mut self) -> Option<&'static str> {
        match self.values.as_slice().first() {
            Some(Value::Word(word)) => {
                self.values.next();
                Some(word)
            }
            _ => None,
        }
    }

    /// Passes over this word, if it is next.
    pub(crate) fn takes(&mut self, word: &str) -> bool {
        let next = self.values.as_slice().first();
        let found = matches!(next, Some(Value::Word(next)) if *next == word);
        if found {
            self.values.next();
        }
        found
    }

    /// Number of values that are left.
    pub(crate) fn left(&self) -> usize {
        self.values.len()
    }

    /// The error of a line that needs another one above it.
    pub(crate) fn needs(&self, needs: &'static str) -> IoError {
        IoError::NeedsAbove {
            location: self.location.clone(),
            command: self.command,
            needs,
        }
    }

    fn unexpected(&self, found: Option<&Value>) -> ! {
        unreachable!("the arguments of `{}` allow {found:?} here", self.command)
    }
}

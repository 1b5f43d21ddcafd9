//! The values after a command's word, with checks that know their places.

use std::path::Path;
use std::str::FromStr;

use super::token::Token;
use crate::{IoError, SourceLocation};

/// A command's word and the values after it, which may stand on several lines.
#[derive(Debug)]
pub(super) struct Args<'a> {
    pub(super) command: &'static str,
    pub(super) line: u32,
    pub(super) column: u32,
    file: &'a Path,
    tokens: Vec<(u32, Token<'a>)>,
}

impl<'a> Args<'a> {
    pub(super) fn new(file: &'a Path, command: &'static str, line: u32, column: u32) -> Self {
        Self {
            command,
            line,
            column,
            file,
            tokens: Vec::new(),
        }
    }

    pub(super) fn extend(&mut self, line: u32, tokens: &[Token<'a>]) {
        self.tokens.extend(tokens.iter().map(|t| (line, *t)));
    }

    pub(super) fn len(&self) -> usize {
        self.tokens.len()
    }

    pub(super) fn word_location(&self) -> SourceLocation {
        SourceLocation::new(self.file, self.line, self.column)
    }

    /// SourceLocation of value `i`, or of the command where there is none.
    fn location(&self, i: usize) -> SourceLocation {
        match self.tokens.get(i) {
            Some((line, token)) => SourceLocation::new(self.file, *line, token.column),
            None => self.word_location(),
        }
    }

    pub(super) fn text(&self, i: usize) -> &'a str {
        self.tokens.get(i).map_or("", |(_, token)| token.text)
    }

    pub(super) fn quoted(&self, i: usize) -> bool {
        self.tokens.get(i).is_some_and(|(_, token)| token.quoted)
    }

    pub(super) fn count_error(&self, expected: &'static str) -> IoError {
        IoError::ArgumentCount {
            location: self.word_location(),
            command: self.command,
            expected: expected.into(),
            found: self.len(),
        }
    }

    pub(super) fn within(
        &self,
        least: usize,
        most: usize,
        expected: &'static str,
    ) -> Result<(), IoError> {
        if (least..=most).contains(&self.len()) {
            return Ok(());
        }
        Err(IoError::ArgumentCount {
            // The first value too many, or the command that lacks one.
            location: self.location(if self.len() > most { most } else { usize::MAX }),
            command: self.command,
            expected: expected.into(),
            found: self.len(),
        })
    }

    pub(super) fn exactly(&self, count: usize, expected: &'static str) -> Result<(), IoError> {
        self.within(count, count, expected)
    }

    /// Three numbers.
    pub(super) fn point(&self) -> Result<[f64; 3], IoError> {
        self.exactly(3, "3 numbers (x y z)")?;
        self.numbers(0)
    }

    /// Three numbers, not all zero.
    pub(super) fn direction(&self) -> Result<[f64; 3], IoError> {
        let direction = self.point()?;
        self.check(0, direction != [0.0; 3], "a direction that is not zero")?;
        Ok(direction)
    }

    pub(super) fn one_number(
        &self,
        valid: impl Fn(f64) -> bool,
        allowed: &'static str,
    ) -> Result<f64, IoError> {
        self.exactly(1, "1 number")?;
        let [x] = self.numbers(0)?;
        self.check(0, valid(x), allowed)?;
        Ok(x)
    }

    /// `N` numbers from value `first` on; the caller has checked the count.
    pub(super) fn numbers<const N: usize>(&self, first: usize) -> Result<[f64; N], IoError> {
        let mut values = [0.0; N];
        for (i, value) in values.iter_mut().enumerate() {
            *value = self.parse::<f64>(first + i)?;
            // Positions become 32-bit floats, so that is the limit for all.
            if value.is_nan() || value.abs() > f64::from(f32::MAX) {
                return Err(self.not_finite(first + i));
            }
        }
        Ok(values)
    }

    /// As [`Args::numbers`], rounded once to 32 bits.
    pub(super) fn floats<const N: usize>(&self, first: usize) -> Result<[f32; N], IoError> {
        let mut values = [0.0; N];
        for (i, value) in values.iter_mut().enumerate() {
            *value = self.parse::<f32>(first + i)?;
            if !value.is_finite() {
                return Err(self.not_finite(first + i));
            }
        }
        Ok(values)
    }

    pub(super) fn positive_floats<const N: usize>(
        &self,
        first: usize,
    ) -> Result<[f32; N], IoError> {
        let values = self.floats(first)?;
        for (i, value) in values.iter().enumerate() {
            self.check(first + i, *value >= 0.0, "0 or more")?;
        }
        Ok(values)
    }

    /// All values, `N` of them, each 0 to 1.
    pub(super) fn unit_floats<const N: usize>(
        &self,
        first: usize,
        expected: &'static str,
    ) -> Result<[f32; N], IoError> {
        self.exactly(first + N, expected)?;
        let values = self.floats(first)?;
        for (i, value) in values.iter().enumerate() {
            self.check(first + i, (0.0..=1.0).contains(value), "0 to 1")?;
        }
        Ok(values)
    }

    /// An index below `count`.
    pub(super) fn index(&self, i: usize, count: usize) -> Result<u32, IoError> {
        match self.text(i).parse::<u32>() {
            Ok(index) if (index as usize) < count => Ok(index),
            _ if self.text(i).parse::<f64>().is_err() => Err(self.not_a_number(i)),
            _ => Err(IoError::BadIndex {
                location: self.location(i),
                of: "vertex",
                index: self.text(i).into(),
                count,
            }),
        }
    }

    pub(super) fn single_word(&self, expected: &'static str) -> Result<&'a str, IoError> {
        self.exactly(1, expected)?;
        Ok(self.text(0))
    }

    pub(super) fn one_of<T: Copy>(
        &self,
        table: &[(&str, T)],
        allowed: &'static str,
    ) -> Result<T, IoError> {
        let word = self.single_word("1 word")?;
        let found = table.iter().find(|(name, _)| *name == word);
        found
            .map(|(_, value)| *value)
            .ok_or_else(|| self.unknown(0, allowed))
    }

    pub(super) fn path(&self) -> Result<String, IoError> {
        let path = self.single_word("1 file name (in quotes if it has blanks)")?;
        self.check(0, !path.is_empty(), "a file name that is not empty")?;
        Ok(path.into())
    }

    pub(super) fn check(
        &self,
        i: usize,
        valid: bool,
        allowed: &'static str,
    ) -> Result<(), IoError> {
        if valid {
            return Ok(());
        }
        Err(IoError::OutOfRange {
            location: self.location(i),
            command: self.command,
            text: self.text(i).into(),
            allowed,
        })
    }

    pub(super) fn unknown(&self, i: usize, allowed: &'static str) -> IoError {
        IoError::UnknownWord {
            location: self.location(i),
            command: self.command,
            word: self.text(i).into(),
            allowed: allowed.into(),
        }
    }

    pub(super) fn too_few_corners(&self, found: usize) -> IoError {
        IoError::TooFewCorners {
            location: self.word_location(),
            command: self.command,
            found,
        }
    }

    fn parse<T: FromStr>(&self, i: usize) -> Result<T, IoError> {
        match self.text(i).parse() {
            Ok(value) if !self.quoted(i) => Ok(value),
            _ => Err(self.not_a_number(i)),
        }
    }

    fn not_a_number(&self, i: usize) -> IoError {
        IoError::NotANumber {
            location: self.location(i),
            command: self.command,
            text: self.text(i).into(),
        }
    }

    fn not_finite(&self, i: usize) -> IoError {
        IoError::NotFinite {
            location: self.location(i),
            command: self.command,
            text: self.text(i).into(),
        }
    }
}

//! The text of an OBJ file in statements and words, and errors that know their places.

use std::ops::{Range, RangeInclusive};
use std::path::Path;

use crate::{IoError, SourceLocation};

/// A range of bytes; texts have at most 2 GiB.
#[derive(Debug, Clone, Copy)]
pub(super) struct Span {
    pub(super) start: u32,
    pub(super) end: u32,
}

impl Span {
    pub(super) fn range(self) -> Range<usize> {
        self.start as usize..self.end as usize
    }
}

/// The text, and the statement that is read.
#[derive(Debug)]
pub(super) struct Source<'a> {
    file: &'a Path,
    text: &'a str,
    /// The statement with its line ends.
    pub(super) statement: Span,
    /// Line of its start.
    first_line: u32,
    /// Line after its end.
    next_line: u32,
}

impl<'a> Source<'a> {
    pub(super) fn new(file: &'a Path, text: &'a str) -> Self {
        Self {
            file,
            text,
            statement: Span { start: 0, end: 0 },
            first_line: 1,
            next_line: 1,
        }
    }

    /// Goes on to the next statement and finds its words; `false` at the end. A backslash at the end of a line joins the next one.
    pub(super) fn next(&mut self, words: &mut Vec<Span>) -> bool {
        let text = self.text;
        words.clear();
        self.first_line = self.next_line;
        self.statement.start = self.statement.end;
        let mut at = self.statement.end as usize;
        while at < text.len() {
            let end = text[at..].find('\n').map_or(text.len(), |n| at + n);
            let content = text[at..end].trim_end();
            let joined = content.strip_suffix('\\');
            push_words(text, at..at + joined.unwrap_or(content).len(), words);
            at = (end + 1).min(text.len());
            self.next_line += 1;
            if joined.is_none() {
                break;
            }
        }
        self.statement.end = at as u32;
        self.statement.start < self.statement.end
    }

    pub(super) fn of(&self, word: Span) -> &'a str {
        &self.text[word.range()]
    }

    pub(super) fn joined(&self, words: &[Span]) -> String {
        let texts: Vec<_> = words.iter().map(|w| self.of(*w)).collect();
        texts.join(" ")
    }

    pub(super) fn three(
        &self,
        command: &'static str,
        values: &[Span],
    ) -> Result<[f32; 3], IoError> {
        let mut three = [0.0; 3];
        for (x, value) in three.iter_mut().zip(values) {
            *x = self.number(command, *value)?;
        }
        Ok(three)
    }

    pub(super) fn number(&self, command: &'static str, word: Span) -> Result<f32, IoError> {
        finite(|| self.location(word), command, self.of(word))
    }

    pub(super) fn name(
        &self,
        command: &'static str,
        word: Span,
        values: &[Span],
    ) -> Result<String, IoError> {
        self.count(command, word, values, 1..=usize::MAX, "1 name")?;
        Ok(self.joined(values))
    }

    pub(super) fn count(
        &self,
        command: &'static str,
        word: Span,
        values: &[Span],
        allowed: RangeInclusive<usize>,
        expected: &'static str,
    ) -> Result<(), IoError> {
        match allowed.contains(&values.len()) {
            true => Ok(()),
            false => Err(self.count_error(command, word, values, expected)),
        }
    }

    pub(super) fn count_error(
        &self,
        command: &'static str,
        word: Span,
        values: &[Span],
        expected: &'static str,
    ) -> IoError {
        IoError::ArgumentCount {
            location: self.location(word),
            command,
            expected: expected.into(),
            found: values.len(),
        }
    }

    pub(super) fn out_of_range(
        &self,
        command: &'static str,
        word: Span,
        allowed: &'static str,
    ) -> IoError {
        IoError::OutOfRange {
            location: self.location(word),
            command,
            text: self.of(word).into(),
            allowed,
        }
    }

    pub(super) fn line(&self, word: Span) -> u32 {
        let before = &self.text.as_bytes()[self.statement.start as usize..word.start as usize];
        self.first_line + before.iter().filter(|b| **b == b'\n').count() as u32
    }

    pub(super) fn location(&self, word: Span) -> SourceLocation {
        let before = &self.text[..word.start as usize];
        let in_line = &before[before.rfind('\n').map_or(0, |n| n + 1)..];
        let column = in_line.chars().count() as u32 + 1;
        SourceLocation::new(self.file, self.line(word), column)
    }
}

/// Blanks separate words; a word that begins with `#` begins a comment.
fn push_words(text: &str, line: Range<usize>, words: &mut Vec<Span>) {
    let bytes = text.as_bytes();
    let mut at = line.start;
    // Length of the blank at a byte.
    let blank = |at: usize| match bytes[at] {
        b' ' | b'\t'..=b'\r' => Some(1),
        byte if byte.is_ascii() => None,
        _ => text[at..]
            .chars()
            .next()
            .filter(|c| c.is_whitespace())
            .map(char::len_utf8),
    };
    while at < line.end {
        if let Some(length) = blank(at) {
            at += length;
            continue;
        }
        if bytes[at] == b'#' {
            break;
        }
        let start = at;
        while at < line.end && (bytes[at] & 0xc0 == 0x80 || blank(at).is_none()) {
            at += 1;
        }
        words.push(Span {
            start: start as u32,
            end: at as u32,
        });
    }
}

/// A finite 32-bit number.
pub(super) fn finite(
    location: impl Fn() -> SourceLocation,
    command: &'static str,
    text: &str,
) -> Result<f32, IoError> {
    match text.parse::<f32>() {
        Ok(x) if x.is_finite() => Ok(x),
        Ok(_) => Err(IoError::NotFinite {
            location: location(),
            command,
            text: text.into(),
        }),
        Err(_) => Err(IoError::NotANumber {
            location: location(),
            command,
            text: text.into(),
        }),
    }
}

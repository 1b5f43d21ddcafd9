//! The text of an OBJ file in statements and words, and errors with their positions.

use std::ops::{Range, RangeInclusive};
use std::path::Path;

use memchr::memchr;

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

/// A piece of the text, and the statement in it that is read.
#[derive(Debug)]
pub(super) struct Source<'a> {
    file: &'a Path,
    text: &'a str,
    /// End of the piece.
    end: usize,
    /// The statement with its line ends.
    pub(super) statement: Span,
    /// Line of its start.
    first_line: u32,
    /// Line after its end.
    next_line: u32,
}

impl<'a> Source<'a> {
    /// The statements that begin in `piece`, whose first byte begins the line `line` and a statement.
    pub(super) fn new(file: &'a Path, text: &'a str, piece: Range<usize>, line: u32) -> Self {
        let start = piece.start as u32;
        Self {
            file,
            text,
            end: piece.end,
            statement: Span { start, end: start },
            first_line: line,
            next_line: line,
        }
    }

    /// Goes on to the next statement and finds its words, up to `most` of them; `false` at the end. A backslash at the end of a line
    /// joins the next one.
    pub(super) fn next(&mut self, words: &mut Vec<Span>, most: usize) -> bool {
        words.clear();
        self.first_line = self.next_line;
        self.statement.start = self.statement.end;
        let mut at = self.statement.end as usize;
        while at < self.end {
            let joined;
            (at, joined) = self.read_line(at, words, most);
            self.next_line += 1;
            if !joined {
                break;
            }
        }
        self.statement.end = at as u32;
        self.statement.start < self.statement.end
    }

    /// All words of the statement.
    pub(super) fn again(&mut self, words: &mut Vec<Span>) {
        self.statement.end = self.statement.start;
        self.next_line = self.first_line;
        self.next(words, usize::MAX);
    }

    /// The line after the statement.
    pub(super) fn line_after(&self) -> u32 {
        self.next_line
    }

    /// Words of the line at `at`: blanks separate them; one that begins with `#` begins a comment. Gives the start of the next line, and
    /// true if this line is joined to the next.
    fn read_line(&self, mut at: usize, words: &mut Vec<Span>, most: usize) -> (usize, bool) {
        let bytes = &self.text.as_bytes()[..self.end];
        let known = words.len();
        while at < bytes.len() {
            match CLASSES[usize::from(bytes[at])] {
                Class::Blank => at += 1,
                Class::LineEnd => return (at + 1, self.ends_with_backslash(known, words)),
                class => {
                    if let Some(blank) = self.wide_blank(class, at) {
                        at += blank;
                        continue;
                    }
                    if bytes[at] == b'#' || words.len() == most {
                        return self.rest(at);
                    }
                    let start = at;
                    loop {
                        let rest = &bytes[at..];
                        let ends = |b: &u8| CLASSES[usize::from(*b)] != Class::Word;
                        at += rest.iter().position(ends).unwrap_or(rest.len());
                        let wide = at < bytes.len() && bytes[at] >= 0x80;
                        if !wide || self.wide_blank(Class::Wide, at).is_some() {
                            break;
                        }
                        at += 1;
                    }
                    words.push(Span {
                        start: start as u32,
                        end: at as u32,
                    });
                }
            }
        }
        (at, self.ends_with_backslash(known, words))
    }

    /// Length of the blank of several bytes that begins at `at`; within a character there is none.
    fn wide_blank(&self, class: Class, at: usize) -> Option<usize> {
        if class != Class::Wide {
            return None;
        }
        let next = self.text.get(at..)?.chars().next()?;
        next.is_whitespace().then(|| next.len_utf8())
    }

    /// Takes the backslash off the last word of a line, if it ends with one.
    fn ends_with_backslash(&self, known: usize, words: &mut Vec<Span>) -> bool {
        match words[known..].last_mut() {
            Some(last) if self.text.as_bytes()[last.end as usize - 1] == b'\\' => {
                last.end -= 1;
                if last.start == last.end {
                    words.pop();
                }
                true
            }
            _ => false,
        }
    }

    /// The end of a line of which nothing more is read.
    fn rest(&self, at: usize) -> (usize, bool) {
        let rest = &self.text[at..self.end];
        let end = memchr(b'\n', rest.as_bytes());
        let content = &rest[..end.unwrap_or(rest.len())];
        let joined = content.trim_end().ends_with('\\');
        (end.map_or(self.end, |n| at + n + 1), joined)
    }

    pub(super) fn of(&self, word: Span) -> &'a str {
        &self.text[word.range()]
    }

    pub(super) fn bytes(&self, word: Span) -> &'a [u8] {
        &self.text.as_bytes()[word.range()]
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
        first_three(values, |value| self.number(command, value))
    }

    /// Three numbers; NaN for each that is not finite.
    pub(super) fn three_or_nan(
        &self,
        command: &'static str,
        values: &[Span],
    ) -> Result<[f32; 3], IoError> {
        first_three(values, |value| self.number_or_nan(command, value))
    }

    /// A number; NaN for one that is not finite.
    pub(super) fn number_or_nan(&self, command: &'static str, word: Span) -> Result<f32, IoError> {
        match self.number(command, word) {
            Err(IoError::NotFinite { .. }) => Ok(f32::NAN),
            other => other,
        }
    }

    pub(super) fn number(&self, command: &'static str, word: Span) -> Result<f32, IoError> {
        match fast_float2::parse(self.bytes(word)) {
            Ok::<f32, _>(x) if x.is_finite() => Ok(x),
            _ => finite(|| self.location(word), command, self.of(word)),
        }
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

fn first_three(
    values: &[Span],
    read: impl Fn(Span) -> Result<f32, IoError>,
) -> Result<[f32; 3], IoError> {
    let mut three = [0.0; 3];
    for (x, value) in three.iter_mut().zip(values) {
        *x = read(*value)?;
    }
    Ok(three)
}

/// True if every number is finite.
pub(crate) fn are_finite(numbers: &[f32]) -> bool {
    numbers.iter().all(|x| x.is_finite())
}

/// A byte of a text, as far as words are concerned.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Class {
    Blank,
    LineEnd,
    Word,
    /// Part of a character of several bytes, which may be a blank.
    Wide,
}

const CLASSES: [Class; 256] = {
    let mut classes = [Class::Word; 256];
    let mut byte = 0;
    while byte < 256 {
        classes[byte] = match byte as u8 {
            b'\n' => Class::LineEnd,
            b' ' | b'\t'..=b'\r' => Class::Blank,
            0x80.. => Class::Wide,
            _ => Class::Word,
        };
        byte += 1;
    }
    classes
};

/// A finite 32-bit number.
pub(super) fn finite(
    location: impl Fn() -> SourceLocation,
    command: &'static str,
    text: &str,
) -> Result<f32, IoError> {
    match text.parse::<f32>() {
        Ok(x) if x.is_finite() => Ok(x),
        Err(_) if !spells_nan(text.as_bytes()) => Err(IoError::NotANumber {
            location: location(),
            command,
            text: text.into(),
        }),
        _ => Err(IoError::NotFinite {
            location: location(),
            command,
            text: text.into(),
        }),
    }
}

/// True for NaN and infinities as runtimes of C print them: `-nan(ind)`, `nan(0x8)`, `1.#QNAN`, `-1.#IND00`, `1.#INF`.
///
/// Sources: ISO C, 7.21.6.1 (`nan(n-char-sequence)`); Microsoft, "Format specification syntax: printf", before and after UCRT.
pub(crate) fn spells_nan(word: &[u8]) -> bool {
    let word = word.strip_prefix(b"-").unwrap_or(word);
    let begins = |start: &[u8]| {
        let own = word.get(..start.len());
        own.is_some_and(|own| own.eq_ignore_ascii_case(start))
    };
    begins(b"1.#") || (begins(b"nan(") && word.ends_with(b")"))
}

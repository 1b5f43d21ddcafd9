//! The words of an ASCII body as the bytes of a little-endian one, so that both are read alike.

use std::path::Path;

use memchr::memchr_iter;

use super::header::Header;
use crate::{IoError, SourceLocation, shortened};

/// A body of bytes, and the positions in the text of each element's records.
#[derive(Debug)]
pub(super) struct Body {
    pub(super) bytes: Vec<u8>,
    pub(super) places: Vec<Vec<u32>>,
}

/// Reads the words after the head.
pub(super) fn body(path: &Path, text: &[u8], header: &Header) -> Result<Body, IoError> {
    let mut words = Words {
        text,
        at: header.end,
    };
    let mut body = Body {
        bytes: Vec::with_capacity(text.len()),
        places: Vec::new(),
    };
    for element in &header.elements {
        let mut places = Vec::new();
        // Records without a property take no memory.
        let count = match element.properties.is_empty() {
            true => 0,
            false => element.count,
        };
        for record in 0..count {
            let mut first = true;
            for property in &element.properties {
                let mut value = |kind: super::values::Kind, bytes: &mut Vec<u8>| {
                    let word = words.next();
                    let start = words.at - word.len();
                    if std::mem::take(&mut first) {
                        places.push(start as u32);
                    }
                    kind.write(word, bytes).ok_or_else(|| {
                        let problem = match word.is_empty() {
                            true => format!(
                                "the file ends within record {record} of the {} of `{}`",
                                element.count,
                                shortened(&element.name)
                            ),
                            false => format!(
                                "`{}` is no {kind:?} for the property `{}`",
                                shortened(&String::from_utf8_lossy(word)),
                                shortened(&property.name)
                            ),
                        };
                        fault(path, text, start, problem)
                    })
                };
                let Some(list) = property.list else {
                    value(property.kind, &mut body.bytes)?;
                    continue;
                };
                let at = body.bytes.len();
                value(list, &mut body.bytes)?;
                // A negative length is refused where the records are found.
                let length = list.read(&body.bytes[at..], false).unwrap_or(0.0);
                for _ in 0..length.max(0.0) as u64 {
                    value(property.kind, &mut body.bytes)?;
                }
            }
        }
        body.places.push(places);
    }
    Ok(body)
}

/// A fault at a byte of a text.
pub(super) fn fault(path: &Path, text: &[u8], at: usize, problem: String) -> IoError {
    let before = &text[..at];
    let (line, start) = memchr_iter(b'\n', before).fold((1, 0), |(line, _), n| (line + 1, n + 1));
    let column = String::from_utf8_lossy(&before[start..]).chars().count() as u32 + 1;
    IoError::BrokenModelLine {
        location: SourceLocation::new(path, line, column),
        problem,
    }
}

struct Words<'a> {
    text: &'a [u8],
    at: usize,
}

impl<'a> Words<'a> {
    /// The next word; none at the end, where `at` is the end of the last one.
    fn next(&mut self) -> &'a [u8] {
        let rest = &self.text[self.at..];
        let Some(start) = rest.iter().position(|b| !b.is_ascii_whitespace()) else {
            return &[];
        };
        let word = &rest[start..];
        let end = word.iter().position(u8::is_ascii_whitespace);
        let word = &word[..end.unwrap_or(word.len())];
        self.at += start + word.len();
        word
    }
}

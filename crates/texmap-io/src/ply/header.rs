//! The head of a PLY file: its encoding, and the elements that its body consists of.
//!
//! Source of the format: Greg Turk, "The PLY Polygon File Format" (1994).

use std::collections::HashSet;
use std::path::Path;

use super::values::Kind;
use crate::{IoError, SourceLocation};

/// Encoding of the body.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Encoding {
    Ascii,
    LittleEndian,
    BigEndian,
}

/// Records of one form.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Element {
    pub(super) name: String,
    /// Number of records.
    pub(super) count: usize,
    pub(super) properties: Vec<Property>,
}

/// A value, or a list of values, of a record.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Property {
    pub(super) name: String,
    pub(super) kind: Kind,
    /// The type of a list's length.
    pub(super) list: Option<Kind>,
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Header {
    pub(super) encoding: Encoding,
    pub(super) elements: Vec<Element>,
    /// Names of `comment TextureFile` lines.
    pub(super) textures: Vec<(SourceLocation, String)>,
    /// Bytes of the head.
    pub(super) end: usize,
}

/// Reads the head of a file.
pub(super) fn parse(path: &Path, bytes: &[u8]) -> Result<Header, IoError> {
    let broken = |line: u32, column: usize, problem: String| IoError::BrokenModelLine {
        location: SourceLocation::new(path, line, column as u32),
        problem,
    };
    let line_end = match bytes.strip_prefix(b"ply") {
        Some([b'\r', b'\n', ..]) => "\r\n",
        Some([b'\r', ..]) => "\r",
        Some([b'\n' | b' ' | b'\t', ..]) => "\n",
        _ => return Err(broken(1, 1, "the first line of a PLY file is `ply`".into())),
    };
    let mut header = Header {
        encoding: Encoding::Ascii,
        elements: Vec::new(),
        textures: Vec::new(),
        end: 0,
    };
    let mut encoding = None;
    // Properties of the last element.
    let mut known = HashSet::new();
    for number in 1.. {
        let rest = &bytes[header.end..];
        let end = memchr::memmem::find(rest, line_end.as_bytes());
        let Some(end) = end else {
            return Err(broken(
                number,
                1,
                "the head has no `end_header` line".into(),
            ));
        };
        header.end += end + line_end.len();
        let text = String::from_utf8_lossy(&rest[..end]);
        let line = Line {
            words: words(&text),
            length: text.trim_end().chars().count(),
        };
        let fault = |(column, problem): Fault| broken(number, column, problem);
        match line.word(0) {
            "ply" | "obj_info" | "" => {}
            "comment" => {
                // Names may hold blanks.
                let rest = text
                    .split_once("comment")
                    .map_or("", |(_, rest)| rest)
                    .trim();
                if let Some(name) = rest.strip_prefix("TextureFile") {
                    let location = SourceLocation::new(path, number, line.column(2) as u32);
                    header.textures.push((location, name.trim().to_owned()));
                }
            }
            "format" => encoding = Some(format(&line).map_err(fault)?),
            "element" => {
                header.elements.push(element(&line).map_err(fault)?);
                known.clear();
            }
            "property" => {
                let Some(element) = header.elements.last_mut() else {
                    return Err(broken(
                        number,
                        1,
                        "a property before the first element".into(),
                    ));
                };
                let property = property(&line).map_err(fault)?;
                if !known.insert(property.name.clone()) {
                    let problem = format!("the property `{}` stands twice", property.name);
                    return Err(broken(number, 1, problem));
                }
                element.properties.push(property);
            }
            "end_header" => {
                let missing = || broken(number, 1, "the head has no `format` line".into());
                header.encoding = encoding.ok_or_else(missing)?;
                return Ok(header);
            }
            word => {
                let known = "comment, obj_info, format, element, property or end_header";
                let problem = format!(
                    "`{}` in the head of a PLY file, which knows {known}",
                    crate::shortened(word)
                );
                return Err(broken(number, line.column(0), problem));
            }
        }
    }
    Err(broken(1, 1, "the head does not end".into()))
}

/// A column, and the description of the fault there.
type Fault = (usize, String);

/// The words of a line with their columns.
struct Line<'a> {
    words: Vec<(usize, &'a str)>,
    length: usize,
}

impl<'a> Line<'a> {
    fn word(&self, index: usize) -> &'a str {
        self.words.get(index).map_or("", |(_, word)| word)
    }

    fn column(&self, index: usize) -> usize {
        self.words
            .get(index)
            .map_or(self.length + 1, |(column, _)| *column)
    }

    fn kind(&self, index: usize) -> Result<Kind, Fault> {
        Kind::of(self.word(index)).ok_or_else(|| {
            let types = "char, uchar, short, ushort, int, uint, float or double";
            (
                self.column(index),
                format!("a property has a type: {types}"),
            )
        })
    }

    fn name(&self, index: usize) -> Result<String, Fault> {
        match self.word(index) {
            "" => Err((self.column(index), "a name is missing".into())),
            name => Ok(name.to_owned()),
        }
    }
}

fn words(text: &str) -> Vec<(usize, &str)> {
    let (mut words, mut column) = (Vec::new(), 1);
    for part in text.split(char::is_whitespace) {
        if !part.is_empty() {
            words.push((column, part));
        }
        column += part.chars().count() + 1;
    }
    words
}

fn format(line: &Line<'_>) -> Result<Encoding, Fault> {
    match (line.word(1), line.word(2)) {
        ("ascii", "1.0") => Ok(Encoding::Ascii),
        ("binary_little_endian", "1.0") => Ok(Encoding::LittleEndian),
        ("binary_big_endian", "1.0") => Ok(Encoding::BigEndian),
        _ => {
            let known = "ascii, binary_little_endian or binary_big_endian, and 1.0";
            Err((line.column(1), format!("the format is {known}")))
        }
    }
}

fn element(line: &Line<'_>) -> Result<Element, Fault> {
    let count = line.word(2).parse::<u32>();
    let count = count.map_err(|_| {
        (
            line.column(2),
            "an element has a name and a count below 2^32".to_owned(),
        )
    })?;
    Ok(Element {
        name: line.name(1)?,
        count: count as usize,
        properties: Vec::new(),
    })
}

fn property(line: &Line<'_>) -> Result<Property, Fault> {
    if line.word(1) != "list" {
        return Ok(Property {
            kind: line.kind(1)?,
            list: None,
            name: line.name(2)?,
        });
    }
    let length = line.kind(2)?;
    if !length.is_whole() {
        return Err((
            line.column(2),
            "the length of a list is a whole number".into(),
        ));
    }
    Ok(Property {
        kind: line.kind(3)?,
        list: Some(length),
        name: line.name(4)?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Header, IoError> {
        parse(Path::new("a.ply"), text.as_bytes())
    }

    const HEAD: &str = "ply\nformat binary_big_endian 1.0\ncomment made by hand\ncomment TextureFile my map.png\nobj_info x\n\
        element vertex 3\nproperty float x\nproperty  uchar red\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n";

    #[test]
    fn elements_and_textures_are_found_with_any_line_end() {
        for line_end in ["\n", "\r\n", "\r"] {
            let text = HEAD.replace('\n', line_end);
            let header = read(&(text.clone() + "\n\n1")).unwrap();
            assert_eq!(
                (header.end, header.encoding),
                (text.len(), Encoding::BigEndian)
            );
            assert_eq!(header.textures[0].1, "my map.png");
            assert_eq!(
                (header.textures[0].0.line, header.textures[0].0.column),
                (4, 21)
            );
            let [vertex, face] = &header.elements[..] else {
                panic!("{header:?}")
            };
            assert_eq!((vertex.count, vertex.properties[1].kind), (3, Kind::U8));
            assert_eq!(face.properties[0].list, Some(Kind::U8));
        }
    }

    #[test]
    fn names_of_properties_are_those_of_an_element() {
        let shared = HEAD.replace("int vertex_indices", "int x");
        assert_eq!(read(&shared).unwrap().elements[1].properties[0].name, "x");
        let twice = HEAD.replace("uchar red", "uchar red\nproperty uchar x");
        assert!(read(&twice).is_err());
    }

    #[test]
    fn faults_have_their_places() {
        for (from, to, line, column) in [
            ("ply\n", "plx\n", 1, 1),
            ("1.0", "2.0", 2, 8),
            ("format binary_big_endian 1.0\n", "", 10, 1),
            ("element vertex 3", "element vertex x", 6, 16),
            ("element vertex 3", "element vertex", 6, 15),
            ("float x", "flat x", 7, 10),
            ("float x", "float", 7, 15),
            ("uchar red", "uchar x", 8, 1),
            ("list uchar", "list float", 10, 15),
            ("element vertex 3\n", "", 6, 1),
            ("comment made", "coment made", 3, 1),
            ("end_header\n", "", 11, 1),
        ] {
            assert!(HEAD.contains(from));
            let error = read(&HEAD.replacen(from, to, 1)).unwrap_err();
            let place = error.location().unwrap();
            assert_eq!((place.line, place.column), (line, column), "{to}: {error}");
        }
    }
}

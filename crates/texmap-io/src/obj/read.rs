//! The one reader of OBJ text: every line is checked where it stands and parsed once.
//!
//! Source of the format: Wavefront, "Advanced Visualizer Manual", appendix B1.

use std::path::Path;

use super::source::{Source, Span};
use crate::{IoError, SourceLocation};

/// The index of what a corner lacks.
pub(super) const NONE: u32 = u32::MAX;

/// The group of faces before the first `s` line: smooth, as most programs show them.
const UNSET_GROUP: u32 = u32::MAX;

/// The contents of an OBJ file, as its lines give them.
#[derive(Debug, Default)]
pub(super) struct Obj {
    /// Positions, divided by their weights.
    pub(super) positions: Vec<[f32; 3]>,
    /// sRGB, one per position; empty where no vertex has a colour.
    pub(super) colors: Vec<[f32; 3]>,
    /// v grows upwards.
    pub(super) uvs: Vec<[f32; 2]>,
    /// Normals of any length.
    pub(super) normals: Vec<[f32; 3]>,
    /// Faces in the order of the file.
    pub(super) faces: Vec<Face>,
    /// Corners of all faces, one face after the other.
    pub(super) corners: Vec<Corner>,
    /// `o`, `g` and `usemtl` lines.
    pub(super) groups: Vec<Group>,
    /// `usemtl` lines.
    pub(super) materials: Vec<(SourceLocation, String)>,
    /// `mtllib` lines.
    pub(super) libraries: Vec<(SourceLocation, String)>,
    /// Lines and points, which are not drawn.
    pub(super) lines_and_points: usize,
    /// The first statement that is not known, and its location.
    pub(super) unknown: Option<(SourceLocation, String)>,
}

/// One corner of a face: indices from 0, or [`NONE`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Corner {
    pub(super) vertex: u32,
    pub(super) uv: u32,
    pub(super) normal: u32,
}

/// One face of the file.
#[derive(Debug, Clone, Copy)]
pub(super) struct Face {
    pub(super) line: u32,
    pub(super) corners: u32,
    pub(super) has_uv: bool,
    /// Faces of one smoothing group share computed normals; 0 is flat.
    pub(super) smoothing: u32,
}

/// A line that later faces belong to.
#[derive(Debug)]
pub(super) struct Group {
    /// Faces above it.
    pub(super) first_face: usize,
    /// The name of an object or group; `None` for the next of `materials`.
    pub(super) name: Option<String>,
}

/// Byte ranges of the text that new texture coordinates replace.
#[derive(Debug, Default)]
pub(super) struct Spans {
    /// Corners of faces, in their order.
    pub(super) corners: Vec<Span>,
    /// Corners of `l` and `p` lines that have a texture index.
    pub(super) others: Vec<Span>,
    /// `vt` statements with their line ends.
    pub(super) uvs: Vec<Span>,
    /// Start of the first face.
    pub(super) first_face: Option<u32>,
}

/// Reads the text of a model.
///
/// With `spans`, the text is read to be given new coordinates: those of the file may be anything, and faces may have them at some
/// corners.
pub(super) fn read(file: &Path, text: &str, spans: Option<&mut Spans>) -> Result<Obj, IoError> {
    let mut reader = Reader {
        source: Source::new(file, text),
        obj: Obj::default(),
        smoothing: UNSET_GROUP,
        spans,
    };
    let mut words = Vec::new();
    while reader.source.next(&mut words) {
        reader.statement(&words)?;
    }
    Ok(reader.obj)
}

struct Reader<'a> {
    source: Source<'a>,
    obj: Obj,
    smoothing: u32,
    spans: Option<&'a mut Spans>,
}

impl<'a> Reader<'a> {
    fn statement(&mut self, words: &[Span]) -> Result<(), IoError> {
        let Some((&word, values)) = words.split_first() else {
            return Ok(());
        };
        match self.source.of(word) {
            "v" => self.vertex(word, values)?,
            "vt" => {
                self.source
                    .count("vt", word, values, 1..=3, "1 to 3 numbers")?;
                let any = self.spans.is_some();
                let mut uv = [0.0; 2];
                for (i, value) in values.iter().enumerate() {
                    let x = match self.source.of(*value).parse::<f32>() {
                        Ok(x) if any || x.is_finite() => x,
                        _ => self.source.number("vt", *value)?,
                    };
                    if let Some(c) = uv.get_mut(i) {
                        *c = x;
                    }
                }
                self.obj.uvs.push(uv);
                if let Some(spans) = &mut self.spans {
                    spans.uvs.push(self.source.statement);
                }
            }
            "vn" => {
                self.source.count("vn", word, values, 3..=3, "3 numbers")?;
                let normal = self.source.three("vn", values)?;
                self.obj.normals.push(normal);
            }
            "f" | "fo" => self.face(word, values)?,
            "o" | "g" => {
                let name = Some(self.source.joined(values));
                self.group(name);
            }
            "usemtl" => {
                let name = self.source.name("usemtl", word, values)?;
                self.obj.materials.push((self.source.location(word), name));
                self.group(None);
            }
            "mtllib" => {
                let name = self.source.name("mtllib", word, values)?;
                self.obj.libraries.push((self.source.location(word), name));
            }
            "s" => {
                let group = values.first().map_or("off", |w| self.source.of(*w));
                self.smoothing = if group == "off" {
                    0
                } else {
                    group.parse().unwrap_or(UNSET_GROUP)
                };
            }
            "l" | "p" => {
                self.obj.lines_and_points += 1;
                if let Some(spans) = &mut self.spans {
                    let indexed = |w: &&Span| self.source.of(**w).contains('/');
                    spans.others.extend(values.iter().filter(indexed));
                }
            }
            other => {
                if self.obj.unknown.is_none() {
                    self.obj.unknown = Some((self.source.location(word), other.into()));
                }
            }
        }
        Ok(())
    }

    fn vertex(&mut self, word: Span, values: &[Span]) -> Result<(), IoError> {
        let expected = "3 numbers (x y z), 4 (with w) or 6 (with r g b)";
        self.source.count("v", word, values, 3..=6, expected)?;
        let mut position = self.source.three("v", values)?;
        match values[3..] {
            [] => {}
            [weight] => {
                let w = self.source.number("v", weight)?;
                position = position.map(|x| x / w);
                if !position.iter().all(|x| x.is_finite()) {
                    return Err(self
                        .source
                        .out_of_range("v", weight, "a weight that is not zero"));
                }
            }
            [_, _, _] => {
                let rgb = self.source.three("v", &values[3..])?;
                if let Some(bad) = rgb.iter().position(|c| !(0.0..=1.0).contains(c)) {
                    return Err(self.source.out_of_range(
                        "v",
                        values[3 + bad],
                        "colours of 0 to 1",
                    ));
                }
                self.obj.colors.resize(self.obj.positions.len(), [1.0; 3]);
                self.obj.colors.push(rgb);
            }
            _ => {
                for value in &values[3..] {
                    self.source.number("v", *value)?;
                }
                return Err(self.source.count_error("v", word, values, expected));
            }
        }
        self.obj.positions.push(position);
        if !self.obj.colors.is_empty() {
            self.obj.colors.resize(self.obj.positions.len(), [1.0; 3]);
        }
        Ok(())
    }

    fn face(&mut self, word: Span, values: &[Span]) -> Result<(), IoError> {
        if values.len() < 3 {
            return Err(IoError::TooFewCorners {
                location: self.source.location(word),
                command: "f",
                found: values.len(),
            });
        }
        let first = self.obj.corners.len();
        for value in values {
            let corner = self.corner(*value)?;
            self.obj.corners.push(corner);
            let has = |c: Corner| (c.uv != NONE, c.normal != NONE);
            let (uv, normal) = has(self.obj.corners[first]);
            if has(corner) != (uv, normal) && self.spans.is_none() {
                return Err(IoError::MixedCorners {
                    location: self.source.location(*value),
                    of: match has(corner).0 == uv {
                        true => "normal",
                        false => "texture coordinate",
                    },
                });
            }
        }
        let corners = &self.obj.corners[first..];
        self.obj.faces.push(Face {
            line: self.source.line(word),
            corners: values.len() as u32,
            has_uv: corners.iter().all(|c| c.uv != NONE),
            smoothing: self.smoothing,
        });
        if let Some(spans) = &mut self.spans {
            spans.corners.extend_from_slice(values);
            spans.first_face.get_or_insert(self.source.statement.start);
        }
        Ok(())
    }

    /// `v`, `v/vt`, `v//vn` or `v/vt/vn`; indices count from 1, or from -1 backwards.
    fn corner(&self, word: Span) -> Result<Corner, IoError> {
        let counts = [
            ("vertex", self.obj.positions.len()),
            ("texture coordinate", self.obj.uvs.len()),
            ("normal", self.obj.normals.len()),
        ];
        let not_a_corner = || IoError::NotANumber {
            location: self.source.location(word),
            command: "f",
            text: self.source.of(word).into(),
        };
        let mut indices = [NONE; 3];
        let mut parts = self.source.of(word).split('/');
        for ((of, count), index) in counts.into_iter().zip(&mut indices) {
            let Some(part) = parts.next() else { break };
            if part.is_empty() {
                continue;
            }
            // More digits than an index can have are one out of range.
            let given = part.parse().map(|i: i64| i128::from(i));
            let given = given
                .or_else(|_| part.parse())
                .map_err(|_| not_a_corner())?;
            let resolved = if given < 0 {
                count as i128 + given
            } else {
                given - 1
            };
            if !(0..count as i128).contains(&resolved) {
                return Err(IoError::BadIndex {
                    location: self.source.location(word),
                    of,
                    index: part.into(),
                    count,
                });
            }
            *index = resolved as u32;
        }
        let [vertex, uv, normal] = indices;
        if vertex == NONE || parts.next().is_some() {
            return Err(not_a_corner());
        }
        Ok(Corner { vertex, uv, normal })
    }

    fn group(&mut self, name: Option<String>) {
        let first_face = self.obj.faces.len();
        self.obj.groups.push(Group { first_face, name });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const QUAD: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvn 0 0 1\n";

    fn error(text: &str) -> (&'static str, u32, u32) {
        let error = read(Path::new("a.obj"), text, None).unwrap_err();
        let location = error.location().unwrap();
        (error.code(), location.line, location.column)
    }

    #[test]
    fn indices_count_from_0_and_groups_name_their_faces() {
        let text = format!(
            "# made by hand\n{QUAD}\ng left wing\nusemtl red # bright\ns 3\nf -4/1 -3/1 \\\n -2/1\ns off\nf 1//1 2//1 3//1 4//1\nl 1 2 3\n"
        );
        let obj = read(Path::new("a.obj"), &text, None).unwrap();
        let corner = |vertex, uv, normal| Corner { vertex, uv, normal };
        assert_eq!(
            obj.corners[..4],
            [
                corner(0, 0, NONE),
                corner(1, 0, NONE),
                corner(2, 0, NONE),
                corner(0, NONE, 0)
            ]
        );
        assert_eq!(obj.groups[0].name.as_deref(), Some("left wing"));
        assert_eq!(
            (obj.groups[1].first_face, obj.materials[0].1.as_str()),
            (0, "red")
        );
        assert_eq!(
            (
                obj.faces[0].line,
                obj.faces[0].smoothing,
                obj.faces[1].smoothing
            ),
            (12, 3, 0)
        );
        assert_eq!((obj.faces[1].has_uv, obj.faces[1].corners), (false, 4));
        assert_eq!(obj.lines_and_points, 1);
    }

    #[test]
    fn faults_are_refused_where_they_stand() {
        for (line, code, column) in [
            ("f 1 2 1000000000", "bad-index", 7),
            ("f 1 2 -5", "bad-index", 7),
            ("f 1 2 0", "bad-index", 7),
            ("f 1 2 99999999999999999999", "bad-index", 7),
            ("f 1/1 2/1 3/2", "bad-index", 11),
            ("f 1//1 2//1 3//-2", "bad-index", 13),
            ("f 1 2", "too-few-corners", 1),
            ("f 1/1 2 3/1", "mixed-corners", 7),
            ("f 1 2 3/1/1/1", "not-a-number", 7),
            ("f 1 2 /1", "not-a-number", 7),
            ("f 1 2 c", "not-a-number", 7),
            ("v 1 nan 0", "not-finite", 5),
            ("v 1 2 1e39", "not-finite", 7),
            ("v 1 2", "argument-count", 1),
            ("v 1 2 3 4 5", "argument-count", 1),
            ("v 1 2 3 0", "out-of-range", 9),
            ("v 1 2 3 2 0 0", "out-of-range", 9),
            ("vt inf 0", "not-finite", 4),
            ("vn 1 0", "argument-count", 1),
            ("vt x", "not-a-number", 4),
            ("usemtl", "argument-count", 1),
        ] {
            assert_eq!(
                error(&format!("{QUAD}{line}\n")),
                (code, 7, column),
                "{line}"
            );
        }
    }

    #[test]
    fn continued_lines_keep_their_places() {
        assert_eq!(error(&format!("{QUAD}f 1 2 \\\n  9")), ("bad-index", 8, 3));
    }
}

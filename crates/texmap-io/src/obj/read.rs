//! The statements of a piece of an OBJ text: every line is checked where it stands.
//!
//! Source of the format: Wavefront, "Advanced Visualizer Manual", appendix B1.

use std::ops::Range;
use std::path::Path;

use super::source::{Source, Span, are_finite};
use crate::{IoError, SourceLocation};

/// The index of data that a corner lacks.
pub(crate) const NONE: u32 = u32::MAX;

/// The group of faces before the first `s` line: smooth, as most programs show them.
const UNSET_GROUP: u32 = u32::MAX;

/// The contents of an OBJ file, as its lines give them.
#[derive(Debug, Default)]
pub(crate) struct Obj {
    /// Positions, divided by their weights.
    pub(crate) positions: Vec<[f32; 3]>,
    /// sRGB, one per position; empty where no vertex has a colour.
    pub(crate) colors: Vec<[f32; 3]>,
    /// v grows upwards.
    pub(crate) uvs: Vec<[f32; 2]>,
    /// Normals of any length.
    pub(crate) normals: Vec<[f32; 3]>,
    /// Faces in the order of the file.
    pub(crate) faces: Vec<Face>,
    /// Corners of all faces, one face after the other.
    pub(crate) corners: Vec<Corner>,
    /// `o`, `g` and `usemtl` lines.
    pub(crate) groups: Vec<Group>,
    /// `usemtl` lines.
    pub(crate) materials: Vec<(SourceLocation, String)>,
    /// `mtllib` lines.
    pub(crate) libraries: Vec<(SourceLocation, String)>,
    /// Lines and points, which are not drawn.
    pub(crate) lines_and_points: usize,
    /// The first statement that is not known, and its location.
    pub(crate) unknown: Option<(SourceLocation, String)>,
    pub(crate) not_finite: NotFinite,
}

/// Counts of lines whose numbers are not finite.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct NotFinite {
    /// NaN; no face may use them.
    pub(crate) positions: usize,
    /// NaN.
    pub(crate) uvs: usize,
    /// Zero.
    pub(crate) normals: usize,
}

impl NotFinite {
    pub(super) fn and(self, next: Self) -> Self {
        Self {
            positions: self.positions + next.positions,
            uvs: self.uvs + next.uvs,
            normals: self.normals + next.normals,
        }
    }
}

/// One corner of a face: indices from 0, or [`NONE`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Corner {
    pub(crate) vertex: u32,
    pub(crate) uv: u32,
    pub(crate) normal: u32,
}

/// One face of the file.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Face {
    pub(crate) line: u32,
    pub(crate) corners: u32,
    pub(crate) has_uv: bool,
    /// Faces of one smoothing group share computed normals; 0 is flat.
    pub(crate) smoothing: u32,
}

/// A line that later faces belong to.
#[derive(Debug)]
pub(crate) struct Group {
    /// Faces above it.
    pub(crate) first_face: usize,
    /// The name of an object or group; `None` for the next of `materials`.
    pub(crate) name: Option<String>,
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
    /// Names in `mtllib` statements.
    pub(super) libraries: Vec<Span>,
    /// Start of the first face.
    pub(super) first_face: Option<u32>,
}

/// Counts of a part of the text: lines, and the data that indices and faces refer to.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Counts {
    pub(super) lines: u32,
    pub(super) positions: usize,
    pub(super) uvs: usize,
    pub(super) normals: usize,
    faces: usize,
    /// The last `s` line.
    pub(super) smoothing: Option<u32>,
}

impl Counts {
    /// Counts the statements of a piece by their first words.
    pub(super) fn of(text: &str, piece: Range<usize>) -> Self {
        let mut source = Source::new(Path::new(""), text, piece.clone(), 0);
        let mut counts = Self::default();
        let mut words = Vec::new();
        while source.next(&mut words, 1) {
            let Some(&word) = words.first() else { continue };
            match source.bytes(word) {
                b"v" => counts.positions += 1,
                b"vt" => counts.uvs += 1,
                b"vn" => counts.normals += 1,
                b"f" | b"fo" => counts.faces += 1,
                b"s" => {
                    source.again(&mut words);
                    counts.smoothing = Some(smoothing(&source, &words[1..]));
                }
                _ => {}
            }
        }
        counts.lines = source.line_after();
        counts
    }

    /// The counts of two pieces, one after the other.
    pub(super) fn and(self, next: Self) -> Self {
        Self {
            lines: self.lines + next.lines,
            positions: self.positions + next.positions,
            uvs: self.uvs + next.uvs,
            normals: self.normals + next.normals,
            faces: self.faces + next.faces,
            smoothing: next.smoothing.or(self.smoothing),
        }
    }
}

/// Reads the statements of a piece of a model, with the counts of all above it, and its own where they are known.
pub(super) fn read_piece(
    file: &Path,
    text: &str,
    piece: Range<usize>,
    (above, own): (Counts, Counts),
    spans: bool,
) -> Result<(Obj, Option<Spans>), IoError> {
    let mut reader = Reader {
        source: Source::new(file, text, piece, above.lines + 1),
        obj: Obj {
            positions: Vec::with_capacity(own.positions),
            uvs: Vec::with_capacity(own.uvs),
            normals: Vec::with_capacity(own.normals),
            faces: Vec::with_capacity(own.faces),
            // Most faces are triangles.
            corners: Vec::with_capacity(3 * own.faces),
            ..Obj::default()
        },
        above,
        smoothing: above.smoothing.unwrap_or(UNSET_GROUP),
        spans: spans.then(Spans::default),
    };
    let mut words = Vec::new();
    while reader.source.next(&mut words, usize::MAX) {
        reader.statement(&words)?;
    }
    Ok((reader.obj, reader.spans))
}

impl Obj {
    /// Takes the coordinates away from faces of which one corner's are not finite.
    pub(super) fn drop_broken_uvs(&mut self) {
        if self.not_finite.uvs == 0 {
            return;
        }
        let mut corners = &mut self.corners[..];
        for face in &mut self.faces {
            let (own, rest) = corners.split_at_mut(face.corners as usize);
            corners = rest;
            let uvs = own.iter().filter_map(|c| self.uvs.get(c.uv as usize));
            if !uvs.flatten().all(|x| x.is_finite()) {
                face.has_uv = false;
                for corner in own {
                    corner.uv = NONE;
                }
            }
        }
    }
}

/// The fault of the vertex of this number, from 0, whose position is not finite.
#[cold]
pub(super) fn vertex_fault(file: &Path, text: &str, vertex: usize) -> IoError {
    let mut source = Source::new(file, text, 0..text.len(), 1);
    let mut words = Vec::new();
    let mut above = 0;
    while source.next(&mut words, usize::MAX) {
        let Some((&word, values)) = words.split_first() else {
            continue;
        };
        if source.bytes(word) != b"v" {
            continue;
        }
        if above == vertex
            && let Err(fault) = source.three("v", values)
        {
            return fault;
        }
        above += 1;
    }
    unreachable!("vertices are those of this text")
}

struct Reader<'a> {
    source: Source<'a>,
    obj: Obj,
    above: Counts,
    smoothing: u32,
    spans: Option<Spans>,
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
                let mut uv = [0.0; 2];
                for (i, value) in values.iter().enumerate() {
                    let x = self.source.number_or_nan("vt", *value)?;
                    if let Some(c) = uv.get_mut(i) {
                        *c = x;
                    }
                }
                self.obj.not_finite.uvs += usize::from(!are_finite(&uv));
                self.obj.uvs.push(uv);
                if let Some(spans) = &mut self.spans {
                    spans.uvs.push(self.source.statement);
                }
            }
            "vn" => {
                self.source.count("vn", word, values, 3..=3, "3 numbers")?;
                let mut normal = self.source.three_or_nan("vn", values)?;
                if !are_finite(&normal) {
                    // None, as for the zero vector.
                    normal = [0.0; 3];
                    self.obj.not_finite.normals += 1;
                }
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
                if let (Some(spans), [first, ..], [.., last]) = (&mut self.spans, values, values) {
                    spans.libraries.push(Span {
                        start: first.start,
                        end: last.end,
                    });
                }
            }
            "s" => self.smoothing = smoothing(&self.source, values),
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
        let mut position = self.source.three_or_nan("v", values)?;
        let is_finite = are_finite(&position);
        self.obj.not_finite.positions += usize::from(!is_finite);
        match values[3..] {
            [] => {}
            [weight] => {
                let w = self.source.number("v", weight)?;
                position = position.map(|x| x / w);
                if is_finite && !are_finite(&position) {
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
            self.above.positions + self.obj.positions.len(),
            self.above.uvs + self.obj.uvs.len(),
            self.above.normals + self.obj.normals.len(),
        ];
        let bytes = self.source.bytes(word);
        let mut indices = [NONE; 3];
        // Another part after these three.
        let (mut at, mut more) = (0, true);
        for (kind, index) in indices.iter_mut().enumerate() {
            let (start, mut value, mut plain) = (at, 0_u32, true);
            while at < bytes.len() && bytes[at] != b'/' {
                let digit = bytes[at].wrapping_sub(b'0');
                plain &= digit < 10;
                value = value.wrapping_mul(10).wrapping_add(u32::from(digit));
                at += 1;
            }
            // Nine digits are below 2^32; 0 becomes the largest index of all.
            let counted = value.wrapping_sub(1);
            if plain && at - start < 10 && (counted as usize) < counts[kind] {
                *index = counted;
            } else if at > start {
                let part = Span {
                    start: word.start + start as u32,
                    end: word.start + at as u32,
                };
                *index = self.index(word, part, kind, counts[kind])?;
            }
            if at == bytes.len() {
                more = false;
                break;
            }
            at += 1;
        }
        let [vertex, uv, normal] = indices;
        if vertex == NONE || more {
            return Err(self.not_a_corner(word));
        }
        Ok(Corner { vertex, uv, normal })
    }

    /// An index that is not a plain number of those that exist, or its error.
    #[cold]
    fn index(&self, word: Span, part: Span, kind: usize, count: usize) -> Result<u32, IoError> {
        let text = self.source.of(part);
        // More digits than an index can have are one out of range.
        let given = text.parse().map_err(|_| self.not_a_corner(word))?;
        let resolved: i128 = match given {
            i128::MIN..0 => count as i128 + given,
            _ => given - 1,
        };
        match (0..count as i128).contains(&resolved) {
            true => Ok(resolved as u32),
            false => Err(IoError::BadIndex {
                location: self.source.location(word),
                of: ["vertex", "texture coordinate", "normal"][kind],
                index: text.into(),
                count,
            }),
        }
    }

    fn not_a_corner(&self, word: Span) -> IoError {
        IoError::NotANumber {
            location: self.source.location(word),
            command: "f",
            text: self.source.of(word).into(),
        }
    }

    fn group(&mut self, name: Option<String>) {
        let first_face = self.obj.faces.len();
        self.obj.groups.push(Group { first_face, name });
    }
}

/// The group of an `s` line with these values; 0 is flat.
fn smoothing(source: &Source<'_>, values: &[Span]) -> u32 {
    match values.first().map_or("off", |word| source.of(*word)) {
        "off" => 0,
        group => group.parse().unwrap_or(UNSET_GROUP),
    }
}

#[cfg(test)]
mod tests {
    use super::super::pieces::{Pieces, read};
    use super::*;

    const QUAD: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvn 0 0 1\n";

    fn error(text: &str) -> (&'static str, u32, u32) {
        let error = read(Path::new("a.obj"), text, None)
            .map(Pieces::join)
            .unwrap_err();
        let location = error.location().unwrap();
        (error.code(), location.line, location.column)
    }

    #[test]
    fn indices_count_from_0_and_groups_name_their_faces() {
        let text = format!(
            "# made by hand\n{QUAD}\ng left wing\nusemtl red # bright\ns 3\nf -4/1 -3/1 \\\n -2/1\ns off\nf 1//1 2//1 3//1 4//1\nl 1 2 3\n"
        );
        let obj = read(Path::new("a.obj"), &text, None).unwrap().join();
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
            ("v 1 nan 0\nf 1 2 -1", "not-finite", 5),
            ("v 1 2 1e39 1\nf 1 2 -1", "not-finite", 7),
            ("v 1 2 -nan(ind)\nf 1 2 -1", "not-finite", 7),
            ("v 1 2 1.#QNAN\nf 1 2 -1", "not-finite", 7),
            ("v 1 2 nana", "not-a-number", 7),
            ("v 1 2", "argument-count", 1),
            ("v 1 2 3 4 5", "argument-count", 1),
            ("v 1 2 3 0", "out-of-range", 9),
            ("v 1 2 3 2 0 0", "out-of-range", 9),
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

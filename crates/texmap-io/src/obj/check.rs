//! Every line of an OBJ file is checked before the reader sees it: the reader's own errors have no place, and it
//! takes NaN, mixed corners and lines as if they were faces.
//!
//! Source of the format: Wavefront, "Advanced Visualizer Manual", appendix B1.

use std::fmt::Write;
use std::path::Path;

use crate::{IoError, SourceLocation};

/// What the check has learned.
#[derive(Debug, Default)]
pub(super) struct Checked {
    /// The statements that make faces and groups, with positive indices and nothing else.
    pub(super) text: String,
    /// Faces in the order of the file.
    pub(super) faces: Vec<Face>,
    /// Vertex of each corner of each face, counted through the file from 0.
    pub(super) corners: Vec<u32>,
    /// `mtllib` lines.
    pub(super) libraries: Vec<(SourceLocation, String)>,
    /// `usemtl` lines.
    pub(super) materials: Vec<(SourceLocation, String)>,
    /// Number of vertices.
    pub(super) vertices: usize,
    /// Some vertex has a colour.
    pub(super) colored: bool,
    /// Lines and points, which are not drawn.
    pub(super) lines_and_points: usize,
    /// The first statement that is not known, and its place.
    pub(super) unknown: Option<(SourceLocation, String)>,
}

/// One face of the file.
#[derive(Debug, Clone, Copy)]
pub(super) struct Face {
    pub(super) line: u32,
    pub(super) corners: u32,
    pub(super) has_uv: bool,
    pub(super) has_normal: bool,
    /// Faces of one smoothing group share computed normals; 0 is flat.
    pub(super) smoothing: u32,
}

/// The group of faces before the first `s` line: smooth, as most programs show them.
const UNSET_GROUP: u32 = u32::MAX;

struct Word<'a> {
    text: &'a str,
    line: u32,
    column: u32,
}

struct Checker<'a> {
    file: &'a Path,
    out: Checked,
    uvs: usize,
    normals: usize,
    smoothing: u32,
}

pub(super) fn check(file: &Path, text: &str) -> Result<Checked, IoError> {
    let mut checker = Checker {
        file,
        out: Checked::default(),
        uvs: 0,
        normals: 0,
        smoothing: UNSET_GROUP,
    };
    let mut words = Vec::new();
    for (content, line) in text.lines().zip(1..) {
        let (content, continues) = match content.trim_end().strip_suffix('\\') {
            Some(rest) => (rest, true),
            None => (content, false),
        };
        words_of(content, line, &mut words);
        if !continues {
            checker.statement(&words)?;
            words.clear();
        }
    }
    checker.statement(&words)?;
    Ok(checker.out)
}

/// Blanks separate words; a word that begins with `#` begins a comment.
fn words_of<'a>(content: &'a str, line: u32, words: &mut Vec<Word<'a>>) {
    let (mut column, mut counted) = (1, 0);
    for text in content.split_whitespace() {
        if text.starts_with('#') {
            break;
        }
        // Words are slices of the line.
        let at = text.as_ptr() as usize - content.as_ptr() as usize;
        column += content[counted..at].chars().count() as u32;
        counted = at;
        words.push(Word { text, line, column });
    }
}

impl Checker<'_> {
    fn statement(&mut self, words: &[Word<'_>]) -> Result<(), IoError> {
        let Some((word, values)) = words.split_first() else {
            return Ok(());
        };
        // Writing to a String cannot fail, here and below.
        match word.text {
            "v" => self.vertex(word, values)?,
            "vt" => {
                self.numbers("vt", word, values, 1..=3, "1 to 3 numbers")?;
                self.uvs += 1;
                let _ = writeln!(
                    self.out.text,
                    "vt {} {}",
                    values[0].text,
                    values.get(1).map_or("0", |w| w.text)
                );
            }
            "vn" => {
                self.numbers("vn", word, values, 3..=3, "3 numbers")?;
                self.normals += 1;
                let _ = writeln!(
                    self.out.text,
                    "vn {} {} {}",
                    values[0].text, values[1].text, values[2].text
                );
            }
            "f" | "fo" => self.face(word, values)?,
            "o" | "g" => {
                let _ = writeln!(self.out.text, "g {}", joined(values));
            }
            "usemtl" => {
                let name = self.name("usemtl", word, values)?;
                let _ = writeln!(self.out.text, "usemtl {name}");
                self.out.materials.push((self.location(word), name));
            }
            "mtllib" => {
                let name = self.name("mtllib", word, values)?;
                self.out.libraries.push((self.location(word), name));
            }
            "s" => {
                let group = values.first().map_or("off", |w| w.text);
                self.smoothing = if group == "off" {
                    0
                } else {
                    group.parse().unwrap_or(UNSET_GROUP)
                };
            }
            "l" | "p" => self.out.lines_and_points += 1,
            other => {
                if self.out.unknown.is_none() {
                    self.out.unknown = Some((self.location(word), other.into()));
                }
            }
        }
        Ok(())
    }

    fn vertex(&mut self, word: &Word<'_>, values: &[Word<'_>]) -> Result<(), IoError> {
        let expected = "3 numbers (x y z), 4 (with w) or 6 (with r g b)";
        let numbers = self.numbers("v", word, values, 3..=6, expected)?;
        let mut xyz = [numbers[0], numbers[1], numbers[2]];
        let mut rgb = [1.0; 3];
        match numbers[3..] {
            [] => {}
            [w] => {
                xyz = xyz.map(|x| x / w);
                if !xyz.iter().all(|x| x.is_finite()) {
                    return Err(self.out_of_range("v", &values[3], "a weight that is not zero"));
                }
            }
            [r, g, b] => {
                rgb = [r, g, b];
                if let Some(bad) = values[3..]
                    .iter()
                    .zip(rgb)
                    .find(|(_, c)| !(0.0..=1.0).contains(c))
                {
                    return Err(self.out_of_range("v", bad.0, "colours of 0 to 1"));
                }
                self.out.colored = true;
            }
            _ => return Err(self.count_error("v", word, values, expected)),
        }
        let _ = writeln!(
            self.out.text,
            "v {:e} {:e} {:e} {} {} {}",
            xyz[0], xyz[1], xyz[2], rgb[0], rgb[1], rgb[2]
        );
        self.out.vertices += 1;
        Ok(())
    }

    fn face(&mut self, word: &Word<'_>, values: &[Word<'_>]) -> Result<(), IoError> {
        if values.len() < 3 {
            return Err(IoError::TooFewCorners {
                location: self.location(word),
                command: "f",
                found: values.len(),
            });
        }
        let mut shape = None;
        self.out.text.push('f');
        for value in values {
            let corner = self.corner(value)?;
            let this = (corner[1].is_some(), corner[2].is_some());
            let (uv, normal) = *shape.get_or_insert(this);
            if this != (uv, normal) {
                let of = if this.0 == uv {
                    "normal"
                } else {
                    "texture coordinate"
                };
                return Err(IoError::MixedCorners {
                    location: self.location(value),
                    of,
                });
            }
            let [vertex, uv, normal] = corner;
            self.out.corners.push(vertex.map_or(0, |v| v - 1));
            let text = |i: Option<u32>| i.map(|i| i.to_string()).unwrap_or_default();
            let _ = write!(
                self.out.text,
                " {}/{}/{}",
                text(vertex),
                text(uv),
                text(normal)
            );
        }
        self.out.text.push('\n');
        let (has_uv, has_normal) = shape.unwrap_or_default();
        self.out.faces.push(Face {
            line: word.line,
            corners: values.len() as u32,
            has_uv,
            has_normal,
            smoothing: self.smoothing,
        });
        Ok(())
    }

    /// `v`, `v/vt`, `v//vn` or `v/vt/vn` as indices from 1.
    fn corner(&self, word: &Word<'_>) -> Result<[Option<u32>; 3], IoError> {
        let counts = [
            ("vertex", self.out.vertices),
            ("texture coordinate", self.uvs),
            ("normal", self.normals),
        ];
        let not_a_corner = || IoError::NotANumber {
            location: self.location(word),
            command: "f",
            text: word.text.into(),
        };
        let mut indices = [None; 3];
        let mut parts = word.text.split('/');
        for ((of, count), index) in counts.into_iter().zip(&mut indices) {
            let Some(part) = parts.next() else { break };
            if part.is_empty() {
                continue;
            }
            let given: i128 = part.parse().map_err(|_| not_a_corner())?;
            let resolved = if given < 0 {
                count as i128 + 1 + given
            } else {
                given
            };
            if resolved < 1 || resolved > count as i128 {
                return Err(IoError::BadIndex {
                    location: self.location(word),
                    of,
                    index: part.into(),
                    count,
                });
            }
            *index = Some(resolved as u32);
        }
        if indices[0].is_none() || parts.next().is_some() {
            return Err(not_a_corner());
        }
        Ok(indices)
    }

    fn numbers(
        &self,
        command: &'static str,
        word: &Word<'_>,
        values: &[Word<'_>],
        counts: std::ops::RangeInclusive<usize>,
        expected: &'static str,
    ) -> Result<Vec<f32>, IoError> {
        if !counts.contains(&values.len()) {
            return Err(self.count_error(command, word, values, expected));
        }
        values
            .iter()
            .map(|value| finite(self.location(value), command, value.text))
            .collect()
    }

    fn name(
        &self,
        command: &'static str,
        word: &Word<'_>,
        values: &[Word<'_>],
    ) -> Result<String, IoError> {
        if values.is_empty() {
            return Err(self.count_error(command, word, values, "1 name"));
        }
        Ok(joined(values))
    }

    fn location(&self, word: &Word<'_>) -> SourceLocation {
        SourceLocation::new(self.file, word.line, word.column)
    }

    fn count_error(
        &self,
        command: &'static str,
        word: &Word<'_>,
        values: &[Word<'_>],
        expected: &'static str,
    ) -> IoError {
        IoError::ArgumentCount {
            location: self.location(word),
            command,
            expected,
            found: values.len(),
        }
    }

    fn out_of_range(
        &self,
        command: &'static str,
        word: &Word<'_>,
        allowed: &'static str,
    ) -> IoError {
        IoError::OutOfRange {
            location: self.location(word),
            command,
            text: word.text.into(),
            allowed,
        }
    }
}

/// A finite 32-bit number.
pub(super) fn finite(
    location: SourceLocation,
    command: &'static str,
    text: &str,
) -> Result<f32, IoError> {
    match text.parse::<f32>() {
        Ok(x) if x.is_finite() => Ok(x),
        Ok(_) => Err(IoError::NotFinite {
            location,
            command,
            text: text.into(),
        }),
        Err(_) => Err(IoError::NotANumber {
            location,
            command,
            text: text.into(),
        }),
    }
}

fn joined(words: &[Word<'_>]) -> String {
    let texts: Vec<_> = words.iter().map(|w| w.text).collect();
    texts.join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    const QUAD: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvn 0 0 1\n";

    fn error(text: &str) -> (&'static str, u32, u32) {
        let error = check(Path::new("a.obj"), text).unwrap_err();
        let location = error.location().unwrap();
        (error.code(), location.line, location.column)
    }

    #[test]
    fn clean_statements_with_positive_indices_are_handed_on() {
        let text = format!(
            "# made by hand\n{QUAD}\ng left wing\nusemtl red # bright\ns 3\nf -4/1 -3/1 \\\n -2/1\ns off\nf 1//1 2//1 3//1 4//1\nl 1 2 3\n"
        );
        let c = check(Path::new("a.obj"), &text).unwrap();
        assert!(
            c.text
                .ends_with("g left wing\nusemtl red\nf 1/1/ 2/1/ 3/1/\nf 1//1 2//1 3//1 4//1\n"),
            "{}",
            c.text
        );
        assert_eq!(c.corners, [0, 1, 2, 0, 1, 2, 3]);
        assert_eq!((c.faces[0].smoothing, c.faces[1].smoothing), (3, 0));
        assert_eq!((c.faces[0].has_uv, c.faces[0].has_normal), (true, false));
        assert_eq!(
            (c.faces[1].has_uv, c.faces[1].has_normal, c.faces[1].corners),
            (false, true, 4)
        );
        assert_eq!(c.lines_and_points, 1);
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

//! An OBJ as text whose texture coordinates are replaced in place: every other byte is kept.

use std::ops::Range;

use texmap_io::shortened;
use texmap_uv::{Faces, UvSet};

/// A fault of the file: line from 1, what, and what to try.
#[derive(Debug, PartialEq)]
pub(in crate::cmd) struct Fault {
    pub(in crate::cmd) line: usize,
    pub(in crate::cmd) what: String,
    pub(in crate::cmd) why: &'static str,
}

/// One corner as it stands in the file.
#[derive(Debug)]
struct Token {
    place: Range<usize>,
    vertex: Range<usize>,
    /// With its slash; empty if there is none.
    normal: Range<usize>,
}

/// What the mapper needs of an OBJ, and where it stood.
#[derive(Debug)]
pub(in crate::cmd) struct Obj {
    text: String,
    pub(in crate::cmd) positions: Vec<[f32; 3]>,
    pub(in crate::cmd) faces: Faces,
    /// The file's coordinates; `None` if a corner has none.
    pub(in crate::cmd) set: Option<UvSet>,
    /// The file's normals, and which of them each corner has; no indices if a corner has none.
    vns: Vec<[f32; 3]>,
    normal_corners: Vec<u32>,
    /// Line of each face.
    pub(in crate::cmd) lines: Vec<usize>,
    tokens: Vec<Token>,
    /// Corners of `l` elements that have a texture index, which is dropped.
    others: Vec<Token>,
    /// Lines of `vt`, with their ends.
    old: Vec<Range<usize>>,
    /// Start of the first `f` line.
    first_face: usize,
}

impl Obj {
    /// `quotes`: whether faults may quote the text.
    pub(in crate::cmd) fn parse(text: String, quotes: bool) -> Result<Self, Fault> {
        let mut reader = Reader {
            text: &text,
            quotes,
            ..Reader::default()
        };
        for (number, statement) in statements(&text) {
            reader.line = number;
            reader.statement(statement)?;
        }
        let Reader {
            positions,
            vts,
            vns,
            faces,
            lines,
            tokens,
            others,
            old,
            first_face,
            uv_corners,
            normal_corners,
            ..
        } = reader;
        let corners = faces.corners().len();
        let set = (uv_corners.len() == corners && corners > 0).then_some(UvSet {
            uvs: vts,
            corners: uv_corners,
        });
        let complete = normal_corners.len() == corners;
        Ok(Self {
            positions,
            set,
            vns,
            normal_corners: if complete { normal_corners } else { Vec::new() },
            lines,
            tokens,
            others,
            old,
            first_face,
            faces,
            text,
        })
    }

    /// A normal per position, of any length: the sum of the file's normals there; empty if a corner has none.
    pub(in crate::cmd) fn normals(&self) -> Vec<[f32; 3]> {
        if self.normal_corners.is_empty() {
            return Vec::new();
        }
        mean_normals(
            &self.positions,
            &self.faces,
            &self.vns,
            &self.normal_corners,
        )
    }

    /// The file's normal of each corner; `None` if a corner has none.
    pub(in crate::cmd) fn corner_normals(&self) -> Option<Vec<[f32; 3]>> {
        let corners = self.normal_corners.iter();
        (!self.normal_corners.is_empty()).then(|| corners.map(|&n| self.vns[n as usize]).collect())
    }

    /// The text with other coordinates: the `vt` lines make way for new ones where the first of them stood (or
    /// before the first face), and each corner names its new index.
    pub(in crate::cmd) fn with(&self, set: &UvSet) -> String {
        let line_end = if self.text.contains("\r\n") {
            "\r\n"
        } else {
            "\n"
        };
        let mut block = String::new();
        for [u, v] in &set.uvs {
            block.push_str(&format!("vt {u} {v}{line_end}"));
        }
        let at = self
            .old
            .first()
            .map_or(self.first_face, |r| r.start.min(self.first_face));
        let mut edits: Vec<(Range<usize>, String)> = vec![(at..at, block)];
        edits.extend(self.old.iter().map(|r| (r.clone(), String::new())));
        edits.extend(self.tokens.iter().zip(&set.corners).map(|(t, index)| {
            (
                t.place.clone(),
                format!(
                    "{}/{}{}",
                    &self.text[t.vertex.clone()],
                    index + 1,
                    &self.text[t.normal.clone()]
                ),
            )
        }));
        edits.extend(
            self.others
                .iter()
                .map(|t| (t.place.clone(), self.text[t.vertex.clone()].to_owned())),
        );
        // The block is the first edit at its place: a stable sort keeps it before the line that it replaces.
        edits.sort_by_key(|(r, _)| r.start);
        let (mut out, mut done) = (String::with_capacity(self.text.len() * 2), 0);
        for (place, new) in edits {
            out.push_str(&self.text[done..place.start]);
            out.push_str(&new);
            done = place.end;
        }
        out.push_str(&self.text[done..]);
        out
    }
}

/// Statements with the number of their first line; a backslash at the end of a line joins the next one.
fn statements(text: &str) -> impl Iterator<Item = (usize, Range<usize>)> + '_ {
    let (mut start, mut line) = (0, 1);
    std::iter::from_fn(move || {
        if start >= text.len() {
            return None;
        }
        let (begin, number) = (start, line);
        let mut end = begin;
        loop {
            let stop = text[end..].find('\n').map_or(text.len(), |n| end + n + 1);
            let joined = text[end..stop]
                .trim_end_matches(['\n', '\r'])
                .ends_with('\\');
            line += 1;
            end = stop;
            if !joined || end >= text.len() {
                break;
            }
        }
        start = end;
        Some((number, begin..end))
    })
}

#[derive(Default)]
struct Reader<'a> {
    text: &'a str,
    quotes: bool,
    line: usize,
    positions: Vec<[f32; 3]>,
    vts: Vec<[f32; 2]>,
    vns: Vec<[f32; 3]>,
    faces: Faces,
    lines: Vec<usize>,
    tokens: Vec<Token>,
    others: Vec<Token>,
    old: Vec<Range<usize>>,
    first_face: usize,
    uv_corners: Vec<u32>,
    normal_corners: Vec<u32>,
}

impl Reader<'_> {
    fn statement(&mut self, range: Range<usize>) -> Result<(), Fault> {
        let text = self.text;
        let body = text[range.clone()].split('#').next().unwrap_or("");
        let words: Vec<Range<usize>> = words(body)
            .map(|w| range.start + w.start..range.start + w.end)
            .collect();
        let Some((head, values)) = words.split_first() else {
            return Ok(());
        };
        match &text[head.clone()] {
            "v" => {
                let p = self.numbers::<3>(values, 3)?;
                self.positions.push(p);
            }
            "vn" => {
                let n = self.numbers::<3>(values, 3)?;
                self.vns.push(n);
            }
            "vt" => {
                let [u, v] = self.numbers::<2>(values, 1)?;
                self.vts.push([u, v]);
                self.old.push(range);
            }
            "f" => self.face(range.start, values)?,
            "l" | "p" => {
                for value in values {
                    let token = self.token(value.clone())?.0;
                    self.others.push(token);
                }
            }
            _ => {}
        }
        Ok(())
    }

    fn face(&mut self, start: usize, values: &[Range<usize>]) -> Result<(), Fault> {
        if self.lines.is_empty() {
            self.first_face = start;
        }
        let mut corners = Vec::with_capacity(values.len());
        for value in values {
            let (token, [v, t, n]) = self.token(value.clone())?;
            let Some(v) = v else {
                return Err(self.fault(
                    "a corner names no vertex".into(),
                    "write v, v/vt, v//vn or v/vt/vn",
                ));
            };
            corners.push(self.index(v, self.positions.len(), "vertex")?);
            if let Some(t) = t {
                let index = self.index(t, self.vts.len(), "texture coordinate")?;
                self.uv_corners.push(index);
            }
            if let Some(n) = n {
                let index = self.index(n, self.vns.len(), "normal")?;
                self.normal_corners.push(index);
            }
            self.tokens.push(token);
        }
        if corners.len() < 3 {
            return Err(self.fault(
                format!("a face of {} corners", corners.len()),
                "a face needs at least 3 corners",
            ));
        }
        self.faces.push(&corners);
        self.lines.push(self.line);
        Ok(())
    }

    /// A corner and its up to three indices.
    fn token(&self, place: Range<usize>) -> Result<(Token, [Option<i64>; 3]), Fault> {
        let text = &self.text[place.clone()];
        let mut parts = text.split('/');
        let (v, t, n) = (
            parts.next().unwrap_or(""),
            parts.next().unwrap_or(""),
            parts.next().unwrap_or(""),
        );
        let read = |part: &str| match part {
            "" => Ok(None),
            _ => part.parse::<i64>().map(Some).map_err(|_| {
                self.fault(
                    format!("`{}` is no corner", self.quoted(text)),
                    "write v, v/vt, v//vn or v/vt/vn",
                )
            }),
        };
        if parts.next().is_some() {
            return Err(self.fault(
                format!("`{}` has too many parts", self.quoted(text)),
                "write v, v/vt, v//vn or v/vt/vn",
            ));
        }
        let indices = [read(v)?, read(t)?, read(n)?];
        let vertex = place.start..place.start + v.len();
        let normal = if n.is_empty() {
            place.end..place.end
        } else {
            place.end - n.len() - 1..place.end
        };
        Ok((
            Token {
                place,
                vertex,
                normal,
            },
            indices,
        ))
    }

    /// From 1, or backwards from the last one, to from 0.
    fn index(&self, index: i64, count: usize, of: &str) -> Result<u32, Fault> {
        let found = if index > 0 {
            index - 1
        } else {
            index.saturating_add(count as i64)
        };
        if index == 0 || found < 0 || found >= count as i64 {
            return Err(self.fault(
                format!("{of} {index} is not there; {count} stand above"),
                "check the index, or the file may be cut off",
            ));
        }
        Ok(found as u32)
    }

    /// At least `least` numbers; missing ones are 0, further ones (w, colours) are left alone.
    fn numbers<const N: usize>(
        &self,
        values: &[Range<usize>],
        least: usize,
    ) -> Result<[f32; N], Fault> {
        if values.len() < least {
            return Err(self.fault(
                format!("{} numbers where {least} are needed", values.len()),
                "the line may be cut off",
            ));
        }
        let mut out = [0.0; N];
        for (slot, value) in out.iter_mut().zip(values) {
            let text = &self.text[value.clone()];
            *slot = text.parse().map_err(|_| {
                self.fault(
                    format!("`{}` is no number", self.quoted(text)),
                    "write a decimal number",
                )
            })?;
        }
        Ok(out)
    }

    /// A word of the file for a message.
    fn quoted(&self, word: &str) -> String {
        match self.quotes {
            true => shortened(word).to_string(),
            false => "...".to_owned(),
        }
    }

    fn fault(&self, what: String, why: &'static str) -> Fault {
        Fault {
            line: self.line,
            what,
            why,
        }
    }
}

/// Ranges of the words of a statement; a backslash before a line's end counts as blank.
fn words(text: &str) -> impl Iterator<Item = Range<usize>> + '_ {
    let blank = |c: char| c.is_whitespace() || c == '\\';
    let mut from = 0;
    std::iter::from_fn(move || {
        let start = from + text[from..].find(|c| !blank(c))?;
        let end = text[start..].find(blank).map_or(text.len(), |n| start + n);
        from = end;
        Some(start..end)
    })
}

fn mean_normals(
    positions: &[[f32; 3]],
    faces: &Faces,
    vns: &[[f32; 3]],
    corners: &[u32],
) -> Vec<[f32; 3]> {
    let mut sums = vec![[0.0f64; 3]; positions.len()];
    for (&v, &n) in faces.corners().iter().zip(corners) {
        for (s, c) in sums[v as usize].iter_mut().zip(vns[n as usize]) {
            *s += f64::from(c);
        }
    }
    sums.into_iter().map(|s| s.map(|c| c as f32)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const QUAD: &str = "# house\r\nmtllib a.mtl\r\no Wall\r\nv 0 0 0\r\nv 1 0 0 # right\r\nv 1 1 0\r\nv 0 1 0\r\nvt 0 0\r\nvn 0 0 1\r\nvt 1 1\r\nusemtl brick\r\ns 1\r\nf  1/1/1 2/2/1 \\\r\n  3/2/1   -1/1/1 # last\r\nl 1/1 2\r\n";

    #[test]
    fn only_vt_and_corners_change() {
        let obj = Obj::parse(QUAD.into(), true).unwrap();
        assert_eq!(
            (obj.positions.len(), obj.faces.len(), obj.lines[0]),
            (4, 1, 13)
        );
        assert_eq!(obj.set.as_ref().unwrap().corners, [0, 1, 1, 0]);
        let set = UvSet {
            uvs: vec![[0.5, 0.25], [1.0, 0.0], [1.5, -1.0]],
            corners: vec![0, 1, 2, 0],
        };
        let new = obj.with(&set);
        let expected = QUAD
            .replace("vt 0 0\r\n", "vt 0.5 0.25\r\nvt 1 0\r\nvt 1.5 -1\r\n")
            .replace("vt 1 1\r\n", "")
            .replace("3/2/1   -1/1/1", "3/3/1   -1/1/1")
            .replace("l 1/1 2", "l 1 2");
        assert_eq!(new, expected);
        // Reading it again gives the same set, writing that the same text.
        let again = Obj::parse(new.clone(), true).unwrap();
        assert_eq!(again.set.as_ref(), Some(&set));
        assert_eq!(again.with(&set), new);
    }

    #[test]
    fn a_file_without_coordinates_gets_them_before_its_first_face() {
        let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\ng a\nf 1 2 3\nf 1//1 2//1 3//1\nvn 0 0 1";
        assert_eq!(Obj::parse(text.into(), true).unwrap_err().line, 6);
        let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\ng a\nf 1 2 3\nf 1//1 2//1 3//1";
        let obj = Obj::parse(text.into(), true).unwrap();
        assert!(obj.set.is_none() && obj.normals().is_empty());
        let set = UvSet {
            uvs: vec![[0.0, 0.5]],
            corners: vec![0; 6],
        };
        assert_eq!(
            obj.with(&set),
            "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\ng a\nvt 0 0.5\nf 1/1 2/1 3/1\nf 1/1/1 2/1/1 3/1/1"
        );
    }

    #[test]
    fn faults_name_their_line() {
        for (text, line) in [
            ("v 0 0\n", 1),
            ("v 0 0 x\n", 1),
            ("v 0 0 0\nf 1 1 2\n", 2),
            ("v 0 0 0\n\nf 1 1\n", 3),
            ("v 0 0 0\nf 1/1 1 1\n", 2),
            ("v 0 0 0\nf 0 1 1\n", 2),
            ("v 0 0 0\nf 1/2/3/4 1 1\n", 2),
            ("v 0 0 0\nf 1000000000000000000000 1 1\n", 2),
        ] {
            assert_eq!(
                Obj::parse(text.into(), true).unwrap_err().line,
                line,
                "{text}"
            );
        }
        assert_eq!(Obj::parse(String::new(), true).unwrap().faces.len(), 0);
    }
}

//! An OBJ as text whose texture coordinates are replaced in place: every other byte is kept.

use std::fmt::Write;
use std::path::Path;

use texmap_uv::{Faces, UvSet};

use super::polygon::Polygons;
use super::read::{NONE, Obj, Spans};
use super::source::Span;
use super::{Model, pieces, written};
use crate::files::{MAX_TEXT, is_called};
use crate::{FileSource, IoError};

/// The text of an OBJ file and the mesh that it describes: vertices as the file counts them, polygons, texture coordinates.
///
/// Coordinates of the file may be missing at some corners, or not finite: [`ObjText::with`] replaces them all.
#[derive(Debug)]
pub struct ObjText {
    text: String,
    obj: Obj,
    spans: Spans,
    faces: Faces,
    /// The first concave face that has too many corners for another cut than a fan.
    uncut: Option<usize>,
    /// The text is that of the file.
    own: bool,
}

impl ObjText {
    /// Reads a file. [`obj_text`](crate::obj_text) reads those of other formats, too.
    ///
    /// # Errors
    /// File errors, a statement that is wrong, with line and column, or [`IoError::Memory`].
    pub fn read(path: &Path, files: &FileSource) -> Result<Self, IoError> {
        // Measured on a grid of a million vertices: its faces, corners and coordinates, and tangents of all corners take 24 times
        // the bytes of the text.
        let text = files.text_for(path, None, MAX_TEXT, (24, "split the model"))?;
        Self::parse(path, text).map_err(|error| match is_called(path, "obj") {
            true => error,
            false => error.without_words(),
        })
    }

    /// The text of a model of another format, without its materials; with its normals, if they are asked for. Equal positions are one
    /// vertex.
    pub(crate) fn of_model(
        path: &Path,
        model: &Model,
        normals: bool,
        files: &FileSource,
    ) -> Result<Self, IoError> {
        let text = written::text(model, normals);
        let what = format_args!("what {} says as an OBJ", path.display());
        files.ask(24 * text.len() as u64, what, "split the model", None)?;
        Self::parse(path, text).map(|obj| Self { own: false, ..obj })
    }

    fn parse(path: &Path, text: String) -> Result<Self, IoError> {
        let mut spans = Spans::default();
        let obj = pieces::read(path, &text, Some(&mut spans))?.join();
        let (mut faces, mut corners) = (Faces::new(), obj.corners.as_slice());
        let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
        let (mut polygons, mut uncut) = (Polygons::default(), None);
        for face in &obj.faces {
            let (own, rest) = corners.split_at(face.corners as usize);
            corners = rest;
            vertices.clear();
            vertices.extend(own.iter().map(|c| c.vertex));
            triangles.clear();
            let points = own.iter().map(|c| obj.positions[c.vertex as usize]);
            let within = polygons.cut(points, |triangle| {
                triangles.push(triangle.map(|k| k as u32));
            });
            if !within {
                uncut.get_or_insert(faces.len());
            }
            faces.push_cut(&vertices, &triangles);
        }
        Ok(Self {
            text,
            obj,
            spans,
            faces,
            uncut,
            own: true,
        })
    }

    /// Positions of the vertices.
    pub fn positions(&self) -> &[[f32; 3]] {
        &self.obj.positions
    }

    /// Polygons over the vertices.
    pub fn faces(&self) -> &Faces {
        &self.faces
    }

    /// Line of a face in the file, from 1; `None` for a face that it does not have, and where the file is no OBJ.
    pub fn line(&self, face: usize) -> Option<u32> {
        let face = self.obj.faces.get(face).filter(|_| self.own);
        face.map(|face| face.line)
    }

    /// The first concave face that has too many corners to be cut within its outline, and a warning of it: its triangles are a fan.
    pub fn drawn_as_fan(&self) -> Option<(usize, String)> {
        let face = self.uncut?;
        let corners = self.faces.face(face).len();
        Some((face, super::drawn_as_fan(corners as u32)))
    }

    /// The file's coordinates; `None` if a corner has none.
    pub fn uv_set(&self) -> Option<UvSet> {
        let corners = &self.obj.corners;
        let complete = !corners.is_empty() && corners.iter().all(|c| c.uv != NONE);
        complete.then(|| UvSet {
            uvs: self.obj.uvs.clone(),
            corners: corners.iter().map(|c| c.uv).collect(),
        })
    }

    /// The file's normal of each corner; `None` if a corner has none.
    pub fn corner_normals(&self) -> Option<Vec<[f32; 3]>> {
        let corners = self.obj.corners.iter();
        let normals = corners.map(|c| self.obj.normals.get(c.normal as usize).copied());
        normals
            .collect::<Option<Vec<_>>>()
            .filter(|n| !n.is_empty())
    }

    /// A normal per vertex, of any length: the sum of the file's normals there; empty if a corner has none.
    pub fn vertex_normals(&self) -> Vec<[f32; 3]> {
        let Some(normals) = self.corner_normals() else {
            return Vec::new();
        };
        let mut sums = vec![[0.0f64; 3]; self.obj.positions.len()];
        for (corner, normal) in self.obj.corners.iter().zip(normals) {
            for (s, c) in sums[corner.vertex as usize].iter_mut().zip(normal) {
                *s += f64::from(c);
            }
        }
        sums.into_iter().map(|s| s.map(|c| c as f32)).collect()
    }

    /// The text with other coordinates: the `vt` lines make way for new ones where the first of them stood (or
    /// before the first face), and each corner names its new index.
    #[must_use]
    pub fn with(&self, set: &UvSet) -> String {
        self.edited(set, |_| None)
    }

    /// [`with`](Self::with) for a file in another folder. `mtllib` names lead from there to the libraries of this file. Both folders
    /// exist; a name that is absolute or cannot be found from there stays as it is.
    #[must_use]
    pub fn with_in(&self, set: &UvSet, file: &Path, folder: &Path) -> String {
        let here = folder_of(file).canonicalize();
        let (Ok(here), Ok(there)) = (here, folder.canonicalize()) else {
            return self.with(set);
        };
        let Some(way) = way(&there, &here).filter(|_| here != there) else {
            return self.with(set);
        };
        let moved = |name: &str| match Path::new(name).is_absolute() {
            true => name.to_owned(),
            false => format!("{way}/{name}"),
        };
        self.edited(set, |line| {
            // As they are read: one name with blanks, or several.
            if here.join(line).exists() {
                return Some(moved(line));
            }
            let names: Vec<String> = line.split_whitespace().map(moved).collect();
            Some(names.join(" "))
        })
    }

    /// `library`: the replacement of the names in a `mtllib` line.
    fn edited(&self, set: &UvSet, library: impl Fn(&str) -> Option<String>) -> String {
        let first_face = self.spans.first_face.unwrap_or(0);
        let first_uv = self.spans.uvs.first();
        let at = first_uv.map_or(first_face, |span| span.start.min(first_face));
        // The block is the first edit at its position: a stable sort keeps it before the line that it replaces.
        let mut edits = vec![(Span { start: at, end: at }, Edit::Block)];
        edits.extend(self.spans.uvs.iter().map(|span| (*span, Edit::Remove)));
        let corners = self.spans.corners.iter().zip(&set.corners);
        edits.extend(corners.map(|(span, index)| (*span, Edit::Corner(*index))));
        edits.extend(self.spans.others.iter().map(|span| (*span, Edit::Vertex)));
        let libraries = self.spans.libraries.iter().zip(&self.obj.libraries);
        edits.extend(libraries.map(|(span, (_, names))| (*span, Edit::Library(names))));
        edits.sort_by_key(|(span, _)| span.start);
        let (mut out, mut done) = (String::with_capacity(self.text.len() * 2), 0);
        for (span, edit) in edits {
            out.push_str(&self.text[done..span.start as usize]);
            let mut parts = self.text[span.range()].split('/');
            let vertex = parts.next().unwrap_or("");
            // Writing to a String cannot fail.
            match edit {
                Edit::Block => self.push_coordinates(&mut out, set),
                Edit::Remove => {}
                Edit::Vertex => out.push_str(vertex),
                Edit::Library(names) => {
                    let kept = &self.text[span.range()];
                    out.push_str(library(names).as_deref().unwrap_or(kept));
                }
                Edit::Corner(index) => {
                    let _ = write!(out, "{vertex}/{}", index + 1);
                    if let Some(normal) = parts.nth(1).filter(|n| !n.is_empty()) {
                        let _ = write!(out, "/{normal}");
                    }
                }
            }
            done = span.end as usize;
        }
        out.push_str(&self.text[done..]);
        out
    }

    fn push_coordinates(&self, out: &mut String, set: &UvSet) {
        let line_end = if self.text.contains("\r\n") {
            "\r\n"
        } else {
            "\n"
        };
        for [u, v] in &set.uvs {
            let _ = write!(out, "vt {u} {v}{line_end}");
        }
    }
}

/// The replacement of a span.
enum Edit<'a> {
    /// The new `vt` lines.
    Block,
    Remove,
    /// The corner with this index of coordinates, from 0.
    Corner(u32),
    /// The corner without coordinates and normal.
    Vertex,
    /// Names of libraries.
    Library(&'a str),
}

/// The folder that a file is in.
fn folder_of(file: &Path) -> &Path {
    match file.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

/// The name of a folder as seen from another, with slashes; both are canonical. `None` where there is none in Unicode.
fn way(from: &Path, to: &Path) -> Option<String> {
    let (from, to): (Vec<_>, Vec<_>) = (from.components().collect(), to.components().collect());
    let shared = from.iter().zip(&to).take_while(|(a, b)| a == b).count();
    if shared == 0 {
        return None;
    }
    let up = from[shared..].iter().map(|_| Some(".."));
    let down = to[shared..].iter().map(|part| part.as_os_str().to_str());
    let parts: Option<Vec<&str>> = up.chain(down).collect();
    Some(parts?.join("/"))
}

#[cfg(test)]
mod tests {
    use super::*;

    const QUAD: &str = "# house\r\nmtllib a.mtl\r\no Wall\r\nv 0 0 0\r\nv 1 0 0 # right\r\nv 1 1 0\r\nv 0 1 0\r\nvt 0 0\r\nvn 0 0 1\r\nvt 1 1\r\nusemtl brick\r\ns 1\r\nf  1/1/1 2/2/1 \\\r\n  3/2/1   -1/1/1 # last\r\nl 1/1 2\r\n";

    fn parse(text: &str) -> Result<ObjText, IoError> {
        ObjText::parse(Path::new("a.obj"), text.into())
    }

    fn fault_line(read: Result<ObjText, IoError>) -> u32 {
        read.unwrap_err().location().unwrap().line
    }

    #[test]
    fn the_memory_budget_is_asked_once_for_what_the_text_says() {
        use std::sync::atomic::{AtomicUsize, Ordering};
        static ASKED: AtomicUsize = AtomicUsize::new(0);
        let used = || {
            ASKED.fetch_add(1, Ordering::Relaxed);
            0
        };
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.obj");
        // Twelve times its bytes are asked for already, the bytes themselves are not.
        std::fs::write(&path, format!("{QUAD}{}", "# \n".repeat(700_000))).unwrap();
        let budget = texmap_math::MemoryBudget::measured(40 << 20, used);
        let files = FileSource::anywhere().with_memory(budget);
        let error = ObjText::read(&path, &files).unwrap_err();
        assert_eq!(error.code(), "over-memory-budget");
        assert_eq!(ASKED.load(Ordering::Relaxed), 1);
        let budget = texmap_math::MemoryBudget::measured(60 << 20, used);
        let files = FileSource::anywhere().with_memory(budget);
        assert_eq!(ObjText::read(&path, &files).unwrap().positions().len(), 4);
        assert_eq!(ASKED.load(Ordering::Relaxed), 2);
    }

    /// Combs of many teeth, after a square: the smaller one is cut, the larger one told.
    #[test]
    fn a_concave_face_of_too_many_corners_is_told() {
        let comb = |corners: usize| {
            let mut text = "v 0 0 -1\nv 1 0 -1\nv 1 1 -1\nv 0 1 -1\nf 1 2 3 4\n".to_owned();
            let end = corners - 2;
            for k in 0..end {
                let _ = writeln!(text, "v {k} {} 0", if k % 2 == 0 { 1.0 } else { 0.1 });
            }
            let _ = writeln!(text, "v {end} 0 0\nv -1 0 0");
            let own: Vec<String> = (5..corners + 5).map(|k| k.to_string()).collect();
            parse(&format!("{text}f {}\n", own.join(" "))).unwrap()
        };
        assert_eq!(comb(16_384).drawn_as_fan(), None);
        let (face, warning) = comb(16_385).drawn_as_fan().unwrap();
        assert_eq!(face, 1);
        assert!(
            warning.starts_with("a concave face of 16385 corners is drawn as a fan"),
            "{warning}"
        );
    }

    #[test]
    fn only_vt_and_corners_change() {
        let obj = parse(QUAD).unwrap();
        assert_eq!(
            (obj.positions().len(), obj.faces().len(), obj.line(0)),
            (4, 1, Some(13))
        );
        assert_eq!(obj.uv_set().unwrap().corners, [0, 1, 1, 0]);
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
        let again = parse(&new).unwrap();
        assert_eq!(again.uv_set().as_ref(), Some(&set));
        assert_eq!(again.with(&set), new);
    }

    #[test]
    fn a_file_without_coordinates_gets_them_before_its_first_face() {
        let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\ng a\nf 1 2 3\nf 1//1 2//1 3//1\nvn 0 0 1";
        assert_eq!(fault_line(parse(text)), 6);
        let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\ng a\nf 1 2 3\nf 1//1 2//1 3//1";
        let obj = parse(text).unwrap();
        assert!(obj.uv_set().is_none() && obj.vertex_normals().is_empty());
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
    fn libraries_are_found_from_another_folder() {
        let dir = tempfile::tempdir().unwrap();
        let at = |name: &str| dir.path().join(name);
        std::fs::create_dir_all(at("in/deep")).unwrap();
        std::fs::create_dir_all(at("out")).unwrap();
        std::fs::write(at("in/two words.mtl"), "").unwrap();
        let text = "# mtllib x\nmtllib a.mtl ../b.mtl # c\n  mtllib two words.mtl\nmtllib /abs.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
        let obj = parse(text).unwrap();
        let set = UvSet {
            uvs: vec![[0.0, 0.5]],
            corners: vec![0; 3],
        };
        let head = |folder: &str| {
            let new = obj.with_in(&set, &at("in/a.obj"), &at(folder));
            new.lines().take(4).collect::<Vec<_>>().join("\n")
        };
        assert_eq!(
            head("in"),
            text.lines().take(4).collect::<Vec<_>>().join("\n")
        );
        assert_eq!(
            head("out"),
            "# mtllib x\nmtllib ../in/a.mtl ../in/../b.mtl # c\n  mtllib ../in/two words.mtl\nmtllib /abs.mtl"
        );
        assert!(head("in/deep").contains("mtllib ../a.mtl ../../b.mtl # c"));
        assert_eq!(
            way(Path::new("/a"), Path::new("/a/b/c")).as_deref(),
            Some("b/c")
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
            assert_eq!(fault_line(parse(text)), line, "{text}");
        }
        assert_eq!(parse("").unwrap().faces().len(), 0);
    }

    #[test]
    fn coordinates_of_the_file_may_be_anything() {
        let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt nan 1e99\nf 1/1 2 3/1\n";
        let obj = parse(text).unwrap();
        assert!(obj.uv_set().is_none());
        let set = UvSet {
            uvs: vec![[0.0, 0.5]],
            corners: vec![0; 3],
        };
        assert!(obj.with(&set).ends_with("vt 0 0.5\nf 1/1 2/1 3/1\n"));
        assert_eq!(fault_line(parse("v 0 0 0\nvt x\n")), 2);
    }
}

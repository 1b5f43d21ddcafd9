//! A mesh as the text of an OBJ, and the messages of its faults.

use std::path::Path;

use texmap_io::{FileSource, IoError, ObjText, obj_text, shown};
use texmap_uv::{Mesh, UvError, UvSet, tangents};

use crate::failure::{Exit, Failure, say};

/// The text and its name.
pub(in crate::cmd) struct Source<'a> {
    path: &'a Path,
    pub(in crate::cmd) obj: ObjText,
}

impl<'a> Source<'a> {
    /// Reads a file, and warns of a face that is drawn beyond its outline.
    pub(in crate::cmd) fn read(path: &'a Path) -> Result<Self, Failure> {
        match obj_text(path, &FileSource::anywhere()) {
            Ok(obj) => {
                let source = Self { path, obj };
                if let Some((face, what)) = source.obj.drawn_as_fan() {
                    let face = match source.obj.line(face) {
                        Some(line) => format!("{line}"),
                        None => format!(" face {}", face + 1),
                    };
                    say(&format!("warning: {}:{face}: {what}\n", shown(path)));
                }
                Ok(source)
            }
            Err(error @ IoError::UnknownFormat { .. }) => Err(Failure::new(
                Exit::Input,
                error.code(),
                format!(
                    "{}: coordinates are given to .obj, .ply and .stl files",
                    shown(path)
                ),
                "write the mesh as an OBJ by the program that made it",
            )),
            Err(error) => Err(error.into()),
        }
    }

    /// The location of a face in messages: its line, or its number from 1.
    pub(in crate::cmd) fn location(&self, face: usize) -> String {
        match self.obj.line(face) {
            Some(line) => format!("line {line}"),
            None => format!("face {}", face + 1),
        }
    }

    /// The locations of some faces in messages.
    pub(in crate::cmd) fn locations(&self, faces: &[usize]) -> String {
        let lines = faces.iter().map(|face| self.obj.line(*face));
        let (kind, mut numbers): (_, Vec<usize>) = match lines.collect::<Option<Vec<_>>>() {
            Some(lines) => (
                "lines",
                lines.into_iter().map(|line| line as usize).collect(),
            ),
            None => ("faces", faces.iter().map(|face| face + 1).collect()),
        };
        numbers.dedup();
        let more = if numbers.len() > 5 { ", ..." } else { "" };
        let first: Vec<String> = numbers.iter().take(5).map(usize::to_string).collect();
        format!("{kind} {}{more}", first.join(", "))
    }

    pub(in crate::cmd) fn mesh(&self) -> Result<Mesh<'_>, Failure> {
        Mesh::new(self.obj.positions(), self.obj.faces()).map_err(|e| self.fault(&e))
    }

    /// The file's coordinates.
    pub(in crate::cmd) fn set(&self, mesh: &Mesh<'_>) -> Result<UvSet, UvError> {
        let set = self.obj.uv_set().ok_or(UvError::WrongLength {
            what: "the list of texture corners",
            found: 0,
            expected: mesh.faces().corners().len(),
        })?;
        set.check(mesh)?;
        Ok(set)
    }

    /// The text with these coordinates, for a file of this name.
    pub(in crate::cmd) fn text(&self, set: &UvSet, output: &Path) -> String {
        let folder = match output.parent() {
            Some(folder) if !folder.as_os_str().is_empty() => folder,
            _ => Path::new("."),
        };
        self.obj.with_in(set, self.path, folder)
    }

    /// Refuses coordinates to be written that are not finite: large positions over small sizes go beyond what floats hold, and
    /// an unused `vt` may be anything.
    pub(in crate::cmd) fn finite(&self, mesh: &Mesh<'_>, set: &UvSet) -> Result<(), Failure> {
        let bad = |uv: &[f32; 2]| !uv.iter().all(|c| c.is_finite());
        if !set.uvs.iter().any(bad) {
            return Ok(());
        }
        let of_face = |face: &usize| {
            let corners = &set.corners[mesh.faces().range(*face)];
            corners.iter().any(|&i| bad(&set.uvs[i as usize]))
        };
        let path = shown(self.path);
        let place = match (0..mesh.faces().len()).find(of_face) {
            Some(face) => match self.obj.line(face) {
                Some(line) => format!("{path}:{line}: a coordinate of this face"),
                None => format!("{path}: a coordinate of face {}", face + 1),
            },
            None => format!("{path}: a coordinate that no face uses"),
        };
        Err(Failure::new(
            Exit::Input,
            "not-finite",
            format!("{place} is NaN or beyond 32-bit floats"),
            "correct the `vt` line, make the model smaller, or give a larger --frame or --tile",
        ))
    }

    pub(in crate::cmd) fn tangents(
        &self,
        mesh: &Mesh<'_>,
        set: &UvSet,
    ) -> Result<Vec<[f32; 4]>, UvError> {
        tangents(mesh, set, &self.corner_normals(mesh))
    }

    /// A normal for every corner: the file's own, else the smooth ones of the surface.
    pub(in crate::cmd) fn corner_normals(&self, mesh: &Mesh<'_>) -> Vec<[f32; 3]> {
        self.obj.corner_normals().unwrap_or_else(|| {
            let smooth = mesh.smooth_normals();
            let corners = mesh.faces().corners();
            corners.iter().map(|&i| smooth[i as usize]).collect()
        })
    }

    /// The failure with file, line and a remedy.
    pub(in crate::cmd) fn fault(&self, error: &UvError) -> Failure {
        let line = match error {
            UvError::NotFinite { face, .. }
            | UvError::BadIndex { face, .. }
            | UvError::TooFewCorners { face, .. }
            | UvError::TooManyCorners { face, .. } => self.obj.line(*face),
            _ => None,
        };
        let place = match line {
            Some(line) => format!("{}:{line}", self.path.display()),
            None => self.path.display().to_string(),
        };
        let (code, what, why) = match error {
            UvError::Empty => (
                "empty-mesh",
                error.to_string(),
                "an OBJ has its faces in `f` lines",
            ),
            UvError::NotFinite { face, index } => (
                "not-finite",
                format!(
                    "face {} uses vertex {}, which is NaN or infinite",
                    face + 1,
                    index + 1
                ),
                "repair the vertex or the coordinate",
            ),
            UvError::WrongLength { found: 0, .. } => (
                "no-coordinates",
                "not every corner has a texture coordinate".to_owned(),
                "make them: `texmap uv IN -o OUT.obj --map unwrap`",
            ),
            UvError::BadFrame { .. } => (
                "bad-frame",
                error.to_string(),
                "every size in --frame must differ from 0",
            ),
            UvError::TooManyCorners { corners, limit, .. } => (
                "unwrap-limit",
                format!(
                    "a face of {corners} corners, of which the unwrapper takes at most {limit}"
                ),
                "divide the face, or give another --map, such as --map auto",
            ),
            UvError::TooManyAround {
                vertex,
                triangles,
                limit,
            } => (
                "unwrap-limit",
                format!(
                    "{triangles} triangles lie around vertex {}, of which the unwrapper takes at most {limit}",
                    vertex + 1
                ),
                "divide them in rings, or give another --map, such as --map auto",
            ),
            UvError::AtlasTooLarge { limit, .. } => {
                let why =
                    format!("give --pack {limit} or less, or another --map, such as --map auto");
                return Failure::new(
                    Exit::Input,
                    "unwrap-limit",
                    format!("{place}: {error}"),
                    why,
                );
            }
            UvError::Unwrap { .. } => (
                "unwrap-failed",
                error.to_string(),
                "give another --map, such as --map auto",
            ),
            UvError::NotAnEdge { a, b } => (
                "not-an-edge",
                format!(
                    "vertices {} and {} are not the ends of an edge between faces",
                    a + 1,
                    b + 1
                ),
                "a cut names edges, a sew edges of two faces",
            ),
            UvError::DoesNotFit { .. } => (
                "does-not-fit",
                error.to_string(),
                "give a larger --pack or a smaller --gutter",
            ),
            _ => ("bad-mapping", error.to_string(), "check the flag's value"),
        };
        Failure::new(Exit::Input, code, format!("{place}: {what}"), why)
    }
}

//! An OBJ file and the words for what is wrong with it.

use std::fs;
use std::path::Path;

use texmap_math::MemoryBudget;
use texmap_uv::{Mesh, UvError, UvSet, tangents};

use super::obj::Obj;
use crate::failure::{Exit, Failure};

/// An OBJ and its name.
pub(in crate::cmd) struct Source<'a> {
    path: &'a Path,
    pub(in crate::cmd) obj: Obj,
}

impl<'a> Source<'a> {
    pub(in crate::cmd) fn read(path: &'a Path) -> Result<Self, Failure> {
        let bytes = fs::read(path).map_err(|e| {
            let why = if path.is_dir() {
                "it is a folder".to_owned()
            } else {
                e.to_string()
            };
            Failure::new(
                Exit::Input,
                "read-failed",
                format!("{}: cannot be read: {why}", path.display()),
                "check the name and its permissions",
            )
        })?;
        // Measured on a grid of a million vertices: the text, its faces, corners and coordinates, and tangents of all corners.
        MemoryBudget::of_process().ask(
            24 * bytes.len() as u64,
            format_args!("what the {} bytes of {} say", bytes.len(), path.display()),
            "split the model",
        )?;
        // OBJ is ASCII; names in other encodings pass through only as UTF-8.
        let text = String::from_utf8(bytes).map_err(|e| {
            let at = e.utf8_error().valid_up_to();
            let line = e.as_bytes()[..at].iter().filter(|b| **b == b'\n').count() + 1;
            Failure::new(
                Exit::Input,
                "not-text",
                format!("{}:{line}: not UTF-8 text", path.display()),
                "is it an OBJ? Save names in UTF-8",
            )
        })?;
        let obj = Obj::parse(text).map_err(|f| {
            Failure::new(
                Exit::Input,
                "bad-obj",
                format!("{}:{}: {}", path.display(), f.line, f.what),
                f.why,
            )
        })?;
        Ok(Self { path, obj })
    }

    pub(in crate::cmd) fn mesh(&self) -> Result<Mesh<'_>, Failure> {
        Mesh::new(&self.obj.positions, &self.obj.faces).map_err(|e| self.fault(&e))
    }

    /// The file's coordinates.
    pub(in crate::cmd) fn set(&self, mesh: &Mesh<'_>) -> Result<UvSet, UvError> {
        let set = self.obj.set.clone().ok_or(UvError::WrongLength {
            what: "the list of texture corners",
            found: 0,
            expected: mesh.faces().corners().len(),
        })?;
        set.check(mesh)?;
        Ok(set)
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

    /// The failure with file and line, and what to try.
    pub(in crate::cmd) fn fault(&self, error: &UvError) -> Failure {
        let line = match error {
            UvError::NotFinite { face, .. }
            | UvError::BadIndex { face, .. }
            | UvError::TooFewCorners { face, .. } => self.obj.lines.get(*face).copied(),
            _ => None,
        };
        let place = match line {
            Some(line) => format!("{}:{line}", self.path.display()),
            None => self.path.display().to_string(),
        };
        let (code, what, why) = match error {
            UvError::Empty => ("empty-mesh", error.to_string(), "the file has no `f` line"),
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
                "give --map, such as --map unwrap",
            ),
            UvError::BadFrame { .. } => (
                "bad-frame",
                error.to_string(),
                "every size in --frame must differ from 0",
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

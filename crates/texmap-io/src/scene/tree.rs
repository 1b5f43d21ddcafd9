//! A scene file with the files it includes.

use std::path::{Path, PathBuf};

use texmap_render::ColorMode;

use crate::scene_file::{self, Command, SceneFile};
use crate::{IoError, Place, files};

/// A parsed file and, in the order of its `include` lines, those below it.
#[derive(Debug)]
pub(crate) struct Tree {
    pub(crate) path: PathBuf,
    pub(crate) file: SceneFile,
    pub(crate) included: Vec<Self>,
}

impl Tree {
    pub(crate) fn read(path: &Path) -> Result<Self, IoError> {
        Self::below(path, None, &mut Vec::new())
    }

    /// `open`: the canonical names of the files that are being read.
    fn below(
        path: &Path,
        named_by: Option<&Place>,
        open: &mut Vec<PathBuf>,
    ) -> Result<Self, IoError> {
        let text = files::read_text(path, named_by)?;
        let canonical = path.canonicalize().unwrap_or_else(|_| path.to_path_buf());
        if let Some(place) = named_by.filter(|_| open.contains(&canonical)) {
            return Err(IoError::IncludeCycle {
                place: place.clone(),
                path: path.to_path_buf(),
            });
        }
        open.push(canonical);
        let file = scene_file::parse(path, &text)?;
        let mut included = Vec::new();
        for statement in &file.statements {
            if let Command::Include(name) = &statement.command {
                let place = Place::new(path, statement.line, statement.column);
                included.push(Self::below(&files::beside(path, name), Some(&place), open)?);
            }
        }
        open.pop();
        Ok(Self {
            path: path.to_path_buf(),
            file,
            included,
        })
    }

    /// The mode of the last `color` line; it holds for the whole scene.
    pub(crate) fn color_mode(&self) -> ColorMode {
        self.last_color().unwrap_or_default()
    }

    fn last_color(&self) -> Option<ColorMode> {
        let mut included = self.included.iter();
        let mut last = None;
        for command in self.file.commands() {
            last = match command {
                Command::Color(mode) => Some(*mode),
                Command::Include(_) => included.next().and_then(Self::last_color).or(last),
                _ => last,
            };
        }
        last
    }
}

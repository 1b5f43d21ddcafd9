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

/// Two `include` lines in each of n files make 2^n files of them; here is the end of that.
const MAX_FILES: u32 = 4096;
const MAX_DEPTH: usize = 32;

impl Tree {
    pub(crate) fn read(path: &Path) -> Result<Self, IoError> {
        Self::below(path, None, &mut Vec::new(), &mut 0)
    }

    /// `open`: the canonical names of the files that are being read; `count`: all that were.
    fn below(
        path: &Path,
        named_by: Option<&Place>,
        open: &mut Vec<PathBuf>,
        count: &mut u32,
    ) -> Result<Self, IoError> {
        let text = files::read_text(path, named_by)?;
        let canonical = path.canonicalize().unwrap_or_else(|_| path.to_path_buf());
        if let Some(place) = named_by.filter(|_| open.contains(&canonical)) {
            return Err(IoError::IncludeCycle {
                place: place.clone(),
                path: path.to_path_buf(),
            });
        }
        *count += 1;
        if let Some(place) = named_by.filter(|_| open.len() > MAX_DEPTH || *count > MAX_FILES) {
            return Err(IoError::OutOfRange {
                place: place.clone(),
                command: "include",
                text: path.display().to_string(),
                allowed: "files within files up to 32 deep, and 4096 in all",
            });
        }
        open.push(canonical);
        let file = scene_file::parse(path, &text)?;
        let mut included = Vec::new();
        for statement in &file.statements {
            if let Command::Include(name) = &statement.command {
                let place = Place::new(path, statement.line, statement.column);
                included.push(Self::below(
                    &files::beside(path, name),
                    Some(&place),
                    open,
                    count,
                )?);
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

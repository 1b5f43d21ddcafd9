//! A scene file with the files it includes.

use std::path::{Path, PathBuf};

use texmap_scene::ColorMode;

use crate::files::{MAX_TEXT, is_called};
use crate::scene_file::{self, SceneFile, Statement, Value};
use crate::{FileSource, IoError, SourceLocation};

/// A parsed file and, in the order of its `include` lines, those below it.
#[derive(Debug)]
pub(crate) struct Tree {
    pub(crate) path: PathBuf,
    pub(crate) file: SceneFile,
    pub(crate) included: Vec<Self>,
}

/// Two `include` lines in each of n files make 2^n files of them, and a hundred lines may name one long file a hundred times;
/// this limit ends that. The file that is loaded itself does not count.
const MAX_FILES: u32 = 4096;
const MAX_DEPTH: usize = 32;
const MAX_BYTES: usize = 1 << 28;
const MAX_LINES: usize = 1 << 22;
const ALLOWED: &str =
    "files within files up to 32 deep; 4096 of them, 256 MiB and 4 million lines in all";

/// State of reading: the files that are open, and totals of the files that were read.
#[derive(Debug, Default)]
struct Progress {
    /// The canonical names of the files that are being read.
    open: Vec<PathBuf>,
    files: u32,
    bytes: usize,
    lines: usize,
}

impl Progress {
    /// Counts an included file; true if it may still be read.
    fn allows(&mut self, text: &str) -> bool {
        self.files += 1;
        self.bytes += text.len();
        self.lines += text.bytes().filter(|b| *b == b'\n').count() + 1;
        self.open.len() <= MAX_DEPTH
            && self.files <= MAX_FILES
            && self.bytes <= MAX_BYTES
            && self.lines <= MAX_LINES
    }
}

impl Tree {
    pub(crate) fn read(path: &Path, files: &FileSource) -> Result<Self, IoError> {
        Self::below(path, None, files, &mut Progress::default())
    }

    fn below(
        path: &Path,
        named_by: Option<&SourceLocation>,
        files: &FileSource,
        progress: &mut Progress,
    ) -> Result<Self, IoError> {
        let text = files.text_named(path, named_by, MAX_TEXT)?;
        let canonical = path.canonicalize().unwrap_or_else(|_| path.to_path_buf());
        if let Some(location) = named_by.filter(|_| progress.open.contains(&canonical)) {
            return Err(IoError::IncludeCycle {
                location: location.clone(),
                path: path.to_path_buf(),
            });
        }
        if let Some(location) = named_by
            && !progress.allows(&text)
        {
            return Err(IoError::OutOfRange {
                location: location.clone(),
                command: "include",
                text: path.display().to_string(),
                allowed: ALLOWED,
            });
        }
        progress.open.push(canonical);
        let file = scene_file::parse(path, &text).map_err(|error| {
            if is_called(path, "scene") {
                error
            } else {
                error.without_words()
            }
        })?;
        drop(text);
        let mut included = Vec::new();
        let includes = |s: &&Statement| s.command.word() == "include";
        for statement in file.statements.iter().filter(includes) {
            let location = SourceLocation::new(path, statement.line, statement.column);
            let mut line = statement.command.line(location);
            let name = files.beside(path, line.name());
            included.push(Self::below(&name, Some(&line.location), files, progress)?);
        }
        progress.open.pop();
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
            last = match command.word() {
                "color" => match command.values() {
                    [Value::Word("raw")] => Some(ColorMode::Raw),
                    _ => Some(ColorMode::Srgb),
                },
                "include" => included.next().and_then(Self::last_color).or(last),
                _ => last,
            };
        }
        last
    }
}

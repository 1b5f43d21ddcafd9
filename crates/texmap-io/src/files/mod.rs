//! Files to read are opened here and nowhere else: only regular files, never more bytes than a limit allows, and within a
//! root, where one is set, nothing outside of it.

mod lost;
mod root;
mod whole;

use std::collections::BTreeSet;
use std::fmt;
use std::fs::{self, File};
use std::io::{self, Cursor};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use texmap_math::MemoryBudget;

pub(crate) use lost::Lost;
use whole::{LARGE, read_at_once, read_whole};

use crate::held::{Held, Input};
use crate::{IoError, SourceLocation};

/// Text files (scenes, OBJ, MTL) and encoded images above this size are refused: 2 GiB.
pub(crate) const MAX_TEXT: u64 = 1 << 31;

/// Source of files: the whole file system, one folder, or memory.
///
/// All files that are read are opened through this type. A pipe, a device or a folder is refused before it is opened. A file that
/// grows meanwhile is read up to the size that it had.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct FileSource {
    /// The folder, canonical; `None` for the whole file system.
    root: Option<Arc<Path>>,
    /// Files in memory, instead of those of the file system.
    held: Option<Arc<Held>>,
    /// Files in memory that come before all others.
    given: Option<Arc<Held>>,
    /// Memory budget, asked before something large is read or made of a file.
    memory: MemoryBudget,
    record: Option<Record>,
}

/// Names of the files that were read, shared by every copy of a source.
#[derive(Debug, Clone, Default)]
struct Record(Arc<Mutex<BTreeSet<PathBuf>>>);

impl PartialEq for Record {
    /// The same record, whatever it holds.
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

impl Eq for Record {}

/// A file that was opened, and its size.
#[derive(Debug)]
pub(crate) struct Opened {
    pub(crate) file: Input,
    pub(crate) bytes: u64,
}

impl FileSource {
    /// Lists (camera paths, hashes, pairs of vertices, rows of coordinates) above this size are refused: 256 MiB.
    pub const MAX_LIST: u64 = 1 << 28;

    /// Every file that the process may read.
    pub fn anywhere() -> Self {
        Self::default()
    }

    /// Files in memory by their names, and none of the file system: for programs without one. Names are compared after `.` and `..`
    /// are taken out of them; a name that is given twice has the last bytes.
    ///
    /// ```
    /// use std::path::Path;
    /// use texmap_io::{FileSource, LoadOptions, load};
    ///
    /// let model = "mtllib gold.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl gold\nf 1 2 3\n";
    /// let files = FileSource::in_memory([
    ///     ("models/a.obj".into(), model.into()),
    ///     ("models/gold.mtl".into(), "newmtl gold\nKd 1 0.8 0.2\n".into()),
    /// ]);
    /// let scene = load(Path::new("models/a.obj"), &LoadOptions { files, ..LoadOptions::default() })?;
    /// assert_eq!(scene.materials[0].name, "gold");
    /// # Ok::<(), texmap_io::IoError>(())
    /// ```
    pub fn in_memory(files: impl IntoIterator<Item = (PathBuf, Vec<u8>)>) -> Self {
        let files = files.into_iter();
        Self::shared(files.map(|(name, bytes)| (name, bytes.into())))
    }

    /// As [`FileSource::in_memory`], of bytes that others hold, too: they are not copied.
    pub fn shared(files: impl IntoIterator<Item = (PathBuf, Arc<[u8]>)>) -> Self {
        Self {
            held: Some(Arc::new(Held::new(files))),
            ..Self::default()
        }
    }

    /// The same files and one more in memory, which hides any other of its name. Its name may be that of a file in a folder: what it names
    /// is looked for there.
    #[must_use]
    pub fn with_file(self, name: PathBuf, bytes: Vec<u8>) -> Self {
        Self {
            given: Some(Arc::new(Held::new([(name, bytes.into())]))),
            ..self
        }
    }

    /// The same files; those of the whole file system only from the folder of `file` and below.
    pub(crate) fn confined(&self, file: &Path) -> Result<Self, IoError> {
        if self.root.is_some() || self.held.is_some() {
            return Ok(self.clone());
        }
        let folder = match file.parent() {
            Some(folder) if !folder.as_os_str().is_empty() => folder,
            _ => Path::new("."),
        };
        Ok(Self {
            record: self.record.clone(),
            given: self.given.clone(),
            ..Self::within(folder)?.with_memory(self.memory)
        })
    }

    /// The same files under another memory budget than that of the process.
    #[must_use]
    pub fn with_memory(self, memory: MemoryBudget) -> Self {
        Self { memory, ..self }
    }

    /// The same files; the names of those that are read from now on, by it and its copies, are kept for [`FileSource::recorded`].
    #[must_use]
    pub fn recording(self) -> Self {
        Self {
            record: Some(Record::default()),
            ..self
        }
    }

    /// Names of the files that were opened to be read since [`FileSource::recording`], as they were asked for; none without it.
    pub fn recorded(&self) -> Vec<PathBuf> {
        let names = |record: &Record| {
            let names = record.0.lock().unwrap_or_else(PoisonError::into_inner);
            names.iter().cloned().collect()
        };
        self.record.as_ref().map(names).unwrap_or_default()
    }

    pub(crate) fn memory(&self) -> MemoryBudget {
        self.memory
    }

    /// Asks the memory budget for bytes that the contents of a file need.
    pub(crate) fn ask(
        &self,
        bytes: u64,
        what: fmt::Arguments<'_>,
        lower: &'static str,
        named_by: Option<&SourceLocation>,
    ) -> Result<(), IoError> {
        let asked = self.memory.ask(bytes, what, lower);
        asked.map_err(|refused| IoError::memory(refused, named_by))
    }

    /// The bytes of a regular file of at most `limit` bytes.
    ///
    /// # Errors
    /// [`IoError::FileMissing`], [`IoError::NotAFile`], [`IoError::FileTooLarge`], [`IoError::OutsideRoot`], [`IoError::Read`].
    pub fn read(&self, path: &Path, limit: u64) -> Result<Vec<u8>, IoError> {
        self.read_named(path, None, limit)
    }

    /// The text of a UTF-8 file of at most `limit` bytes, without a byte order mark.
    ///
    /// # Errors
    /// As [`FileSource::read`], and [`IoError::NotUtf8`] with the position.
    pub fn read_text(&self, path: &Path, limit: u64) -> Result<String, IoError> {
        self.text_named(path, None, limit)
    }

    pub(crate) fn read_named(
        &self,
        path: &Path,
        named_by: Option<&SourceLocation>,
        limit: u64,
    ) -> Result<Vec<u8>, IoError> {
        let Opened { file, bytes: size } = self.open(path, named_by, limit)?;
        let what = format_args!("the {size} bytes of {}", path.display());
        self.ask(size, what, "split the file", named_by)?;
        let bytes = match file {
            Input::File(file) if size >= LARGE => read_at_once(file, size),
            input => read_whole(input, size),
        };
        bytes.map_err(|source| unreadable(path, named_by, source))
    }

    pub(crate) fn text_named(
        &self,
        path: &Path,
        named_by: Option<&SourceLocation>,
        limit: u64,
    ) -> Result<String, IoError> {
        // A parser and the meshes that it makes take eleven times the bytes of an OBJ, measured on a grid of a million vertices.
        self.text_for(path, named_by, limit, (12, "split the file"))
    }

    /// The text of a file of which `times` its bytes are made; that is asked for, with what makes it smaller.
    pub(crate) fn text_for(
        &self,
        path: &Path,
        named_by: Option<&SourceLocation>,
        limit: u64,
        (times, lower): (u64, &'static str),
    ) -> Result<String, IoError> {
        let bytes = self.read_named(path, named_by, limit)?;
        let what = format_args!("what the {} bytes of {} say", bytes.len(), path.display());
        self.ask(times * bytes.len() as u64, what, lower, named_by)?;
        let mut text = String::from_utf8(bytes).map_err(|e| {
            let (good, _) = e.as_bytes().split_at(e.utf8_error().valid_up_to());
            let good = String::from_utf8_lossy(good);
            let line = good.matches('\n').count() as u32 + 1;
            let column = good.rsplit('\n').next().map_or(0, |l| l.chars().count()) as u32 + 1;
            IoError::NotUtf8 {
                location: SourceLocation::new(path, line, column),
            }
        })?;
        if text.starts_with('\u{feff}') {
            text.drain(..'\u{feff}'.len_utf8());
        }
        Ok(text)
    }

    /// Opens a regular file of at most `limit` bytes.
    pub(crate) fn open(
        &self,
        path: &Path,
        named_by: Option<&SourceLocation>,
        limit: u64,
    ) -> Result<Opened, IoError> {
        if let Some(found) = self.in_memory_of(path) {
            let bytes = found.ok_or_else(|| missing(path, named_by))?;
            return within_limit(
                path,
                Input::Held(Cursor::new(bytes.clone())),
                bytes.len() as u64,
                limit,
            );
        }
        let real = self.resolve(path, named_by)?;
        let at = real.as_deref().unwrap_or(path);
        // Opening a pipe would wait for its writer.
        self.size(at, path, named_by)?;
        let file = File::open(at).map_err(|source| unreadable(path, named_by, source))?;
        if let Some(Record(names)) = &self.record {
            let mut names = names.lock().unwrap_or_else(PoisonError::into_inner);
            if !names.contains(path) {
                names.insert(path.to_path_buf());
            }
        }
        let metadata = file
            .metadata()
            .map_err(|source| unreadable(path, named_by, source))?;
        let bytes = metadata.len();
        if !metadata.is_file() {
            return Err(IoError::NotAFile {
                path: path.to_path_buf(),
                named_by: named_by.cloned(),
            });
        }
        within_limit(path, Input::File(file), bytes, limit)
    }

    /// Refuses files that are missing, outside of the root, or not regular.
    pub(crate) fn check(
        &self,
        path: &Path,
        named_by: Option<&SourceLocation>,
    ) -> Result<(), IoError> {
        if let Some(found) = self.in_memory_of(path) {
            return found.map(|_| ()).ok_or_else(|| missing(path, named_by));
        }
        let real = self.resolve(path, named_by)?;
        self.size(real.as_deref().unwrap_or(path), path, named_by)
            .map(|_| ())
    }

    /// `name` as seen from the directory of `file`; a backslash separates folders too.
    pub(crate) fn beside(&self, file: &Path, name: &str) -> PathBuf {
        let directory = file.parent().unwrap_or(Path::new(""));
        let path = directory.join(name);
        if !name.contains('\\') || self.exists(&path) {
            path
        } else {
            directory.join(name.replace('\\', "/"))
        }
    }

    /// True if there is something of this name that may be read.
    pub(crate) fn exists(&self, path: &Path) -> bool {
        if let Some(found) = self.in_memory_of(path) {
            return found.is_some();
        }
        self.resolve(path, None)
            .is_ok_and(|real| real.as_deref().unwrap_or(path).exists())
    }

    /// The bytes of a file in memory, `Some(None)` where there are no others and this is none of them; `None` for the file system.
    fn in_memory_of(&self, path: &Path) -> Option<Option<&Arc<[u8]>>> {
        let given = self.given.as_ref().and_then(|given| given.get(path));
        match (given, &self.held) {
            (Some(bytes), _) => Some(Some(bytes)),
            (None, Some(held)) => Some(held.get(path)),
            (None, None) => None,
        }
    }

    /// Bytes of the regular file `at`, which messages call `path`.
    fn size(
        &self,
        at: &Path,
        path: &Path,
        named_by: Option<&SourceLocation>,
    ) -> Result<u64, IoError> {
        match fs::metadata(at) {
            Ok(metadata) if metadata.is_file() => Ok(metadata.len()),
            Ok(_) => Err(IoError::NotAFile {
                path: path.to_path_buf(),
                named_by: named_by.cloned(),
            }),
            Err(e)
                if matches!(
                    e.kind(),
                    io::ErrorKind::NotFound | io::ErrorKind::NotADirectory
                ) =>
            {
                Err(missing(path, named_by))
            }
            Err(source) => Err(unreadable(path, named_by, source)),
        }
    }
}

/// True if the name of a file has the ending of its expected content. Messages quote nothing of other files: a scene that names a
/// stranger's file must not disclose its words.
pub(crate) fn is_called(path: &Path, ending: &str) -> bool {
    path.extension()
        .is_some_and(|e| e.eq_ignore_ascii_case(ending))
}

fn within_limit(path: &Path, file: Input, bytes: u64, limit: u64) -> Result<Opened, IoError> {
    match bytes <= limit {
        true => Ok(Opened { file, bytes }),
        false => Err(IoError::FileTooLarge {
            path: path.to_path_buf(),
            bytes,
            limit,
        }),
    }
}

pub(crate) fn missing(path: &Path, named_by: Option<&SourceLocation>) -> IoError {
    IoError::FileMissing {
        path: path.to_path_buf(),
        named_by: named_by.cloned(),
    }
}

fn unreadable(path: &Path, named_by: Option<&SourceLocation>, source: io::Error) -> IoError {
    IoError::Read {
        path: path.to_path_buf(),
        named_by: named_by.cloned(),
        source,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(path: &Path) -> Result<Vec<u8>, IoError> {
        FileSource::anywhere().read(path, MAX_TEXT)
    }

    #[test]
    fn names_the_first_byte_that_is_not_text() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.scene");
        let text = || FileSource::anywhere().read_text(&path, MAX_TEXT);
        fs::write(&path, b"eye 0 0 6\n# caf\xe9\n").unwrap();
        let error = text().unwrap_err();
        assert_eq!(error.code(), "not-utf8");
        assert_eq!(error.location().map(|p| (p.line, p.column)), Some((2, 6)));
        fs::write(&path, "\u{feff}eye 0 0 6").unwrap();
        assert_eq!(text().unwrap(), "eye 0 0 6");
    }

    #[test]
    fn a_file_in_memory_stands_before_those_of_a_folder() {
        let dir = tempfile::tempdir().unwrap();
        let at = |name: &str| dir.path().join(name);
        for name in ["a", "b"] {
            fs::write(at(name), name).unwrap();
        }
        let files = FileSource::within(dir.path()).unwrap();
        let files = files.with_file(at("a"), b"given".to_vec());
        assert_eq!(files.read(&at("a"), 9).unwrap(), b"given");
        assert_eq!(files.read(&at("b"), 9).unwrap(), b"b");
        assert_eq!(
            files.read(&at("a"), 4).unwrap_err().code(),
            "file-too-large"
        );
        assert_eq!(files.read(&at("c"), 9).unwrap_err().code(), "file-missing");
        let outside = files.read(&at("../c"), 9).unwrap_err();
        assert_eq!(outside.code(), "outside-root");
        let anywhere = FileSource::anywhere().with_file(at("d"), vec![]);
        assert!(anywhere.confined(&at("a")).unwrap().exists(&at("d")));
    }

    #[test]
    fn a_record_names_what_was_opened_and_nothing_else() {
        let dir = tempfile::tempdir().unwrap();
        let at = |name: &str| dir.path().join(name);
        fs::write(at("a"), "a").unwrap();
        fs::write(at("b"), "b").unwrap();
        let silent = FileSource::anywhere();
        let files = FileSource::anywhere().recording();
        let confined = files.confined(&at("x.gltf")).unwrap();
        for _ in 0..2 {
            silent.read(&at("b"), 9).unwrap();
            files.clone().read(&at("a"), 9).unwrap();
            assert!(files.read(&at("gone"), 9).is_err() && files.exists(&at("b")));
        }
        assert_eq!(files.recorded(), [at("a")]);
        confined.read(&at("b"), 9).unwrap();
        assert_eq!(files.recorded(), [at("a"), at("b")]);
        assert!(silent.recorded().is_empty() && silent != files && files == files.clone());
    }

    #[test]
    fn directories_and_missing_files_have_their_own_errors() {
        let dir = tempfile::tempdir().unwrap();
        assert_eq!(read(dir.path()).unwrap_err().code(), "not-a-file");
        let error = read(&dir.path().join("no.obj")).unwrap_err();
        assert_eq!(error.code(), "file-missing");
    }

    #[cfg(unix)]
    #[test]
    fn devices_are_refused_and_sizes_are_limited() {
        for device in ["/dev/zero", "/dev/null", "/dev/tty"] {
            let code = read(Path::new(device)).unwrap_err().code();
            assert!(
                matches!(code, "not-a-file" | "file-missing"),
                "{device}: {code}"
            );
        }
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.obj");
        fs::write(&path, "0123456789").unwrap();
        let files = FileSource::anywhere();
        assert_eq!(files.read(&path, 10).unwrap().len(), 10);
        assert_eq!(files.read(&path, 9).unwrap_err().code(), "file-too-large");
        // A hole of 3 GiB takes no space on the disk; the file is refused by its size.
        File::options()
            .write(true)
            .open(&path)
            .unwrap()
            .set_len(3 << 30)
            .unwrap();
        assert_eq!(read(&path).unwrap_err().code(), "file-too-large");
    }
}

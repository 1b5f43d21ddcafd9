//! Files to read are opened here and nowhere else: only regular files, never more bytes than a limit allows, and within a
//! root, where one is set, nothing outside of it.

use std::collections::BTreeSet;
use std::fmt;
use std::fs::{self, File};
use std::io::{self, Cursor, Read};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

#[cfg(unix)]
use rayon::prelude::*;
use texmap_math::MemoryBudget;

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

    /// Only files in `folder` and below. Absolute names, `..` and symbolic links may be used as long as the file that they lead
    /// to lies there; anything else is [`IoError::OutsideRoot`], whether it exists or not. Names are followed before the file
    /// is opened, so nobody else should be able to change links in the folder meanwhile.
    ///
    /// # Errors
    /// [`IoError::FileMissing`] and [`IoError::Read`] for a folder that is none.
    pub fn within(folder: &Path) -> Result<Self, IoError> {
        let canonical = folder
            .canonicalize()
            .and_then(|path| match path.is_dir() {
                true => Ok(path),
                false => Err(io::ErrorKind::NotADirectory.into()),
            })
            .map_err(|source| match source.kind() {
                io::ErrorKind::NotFound => IoError::FileMissing {
                    path: folder.to_path_buf(),
                    named_by: None,
                },
                _ => IoError::Read {
                    path: folder.to_path_buf(),
                    named_by: None,
                    source,
                },
            })?;
        Ok(Self {
            root: Some(canonical.into()),
            ..Self::default()
        })
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
        Self {
            held: Some(Arc::new(Held::new(files))),
            ..Self::default()
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
        if let Some(held) = &self.held {
            let bytes = held.get(path).ok_or_else(|| missing(path, named_by))?;
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
        if let Some(held) = &self.held {
            let known = held.get(path).is_some();
            return if known {
                Ok(())
            } else {
                Err(missing(path, named_by))
            };
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
        if let Some(held) = &self.held {
            return held.get(path).is_some();
        }
        self.resolve(path, None)
            .is_ok_and(|real| real.as_deref().unwrap_or(path).exists())
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

    /// The name without links and `..`, if there is a root to hold it against.
    fn resolve(
        &self,
        path: &Path,
        named_by: Option<&SourceLocation>,
    ) -> Result<Option<PathBuf>, IoError> {
        let Some(root) = &self.root else {
            return Ok(None);
        };
        let outside = || IoError::OutsideRoot {
            path: path.to_path_buf(),
            named_by: named_by.cloned(),
        };
        if let Ok(real) = path.canonicalize() {
            return match real.starts_with(root) {
                true => Ok(Some(real)),
                false => Err(outside()),
            };
        }
        // The name leads nowhere. That is only said where its last folder that exists lies within the root, and not of a link,
        // which may lead anywhere: messages must not tell which files there are elsewhere.
        let mut ancestor = path;
        let real = loop {
            if ancestor.is_symlink() {
                return Err(outside());
            }
            ancestor = match ancestor.parent() {
                Some(parent) if !parent.as_os_str().is_empty() => parent,
                _ => break Path::new(".").canonicalize(),
            };
            if let Ok(real) = ancestor.canonicalize() {
                break Ok(real);
            }
        };
        match real {
            Ok(real) if real.starts_with(root) => Ok(Some(path.to_path_buf())),
            _ => Err(outside()),
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

fn missing(path: &Path, named_by: Option<&SourceLocation>) -> IoError {
    IoError::FileMissing {
        path: path.to_path_buf(),
        named_by: named_by.cloned(),
    }
}

/// Files from this size on are read by every thread, a piece of this size each: 4 MiB.
const LARGE: u64 = 1 << 22;

fn read_whole(file: impl Read, size: u64) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    bytes
        .try_reserve_exact(size as usize)
        .map_err(io::Error::other)?;
    file.take(size).read_to_end(&mut bytes)?;
    Ok(bytes)
}

#[cfg(unix)]
fn read_at_once(file: File, size: u64) -> io::Result<Vec<u8>> {
    use std::os::unix::fs::FileExt;

    // The system zeroes memory pages at the first write to each, which is most of the time of reading.
    let mut bytes = vec![0; size as usize];
    let pieces = bytes.par_chunks_mut(LARGE as usize).enumerate();
    pieces.try_for_each(|(number, piece)| file.read_exact_at(piece, number as u64 * LARGE))?;
    Ok(bytes)
}

#[cfg(not(unix))]
fn read_at_once(file: File, size: u64) -> io::Result<Vec<u8>> {
    read_whole(file, size)
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
    fn large_files_are_read_whole() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.obj");
        let bytes: Vec<u8> = (0..3 * LARGE + 7).map(|i| (i / 977) as u8).collect();
        for size in [LARGE - 1, LARGE, LARGE + 1, 3 * LARGE + 7] {
            fs::write(&path, &bytes[..size as usize]).unwrap();
            assert!(read(&path).unwrap() == bytes[..size as usize], "{size}");
        }
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

    #[cfg(unix)]
    #[test]
    fn a_root_confines_links_dots_and_absolute_names() {
        use std::os::unix::fs::symlink;
        let dir = tempfile::tempdir().unwrap();
        let at = |name: &str| dir.path().join(name);
        fs::create_dir_all(at("root/maps")).unwrap();
        fs::create_dir(at("rooted")).unwrap();
        for name in ["secret", "rooted/secret", "root/a", "root/maps/b"] {
            fs::write(at(name), name).unwrap();
        }
        symlink("maps/b", at("root/good")).unwrap();
        symlink("../secret", at("root/bad")).unwrap();
        symlink("../gone", at("root/dangling")).unwrap();
        symlink("..", at("root/up")).unwrap();
        symlink(at("root"), at("alias")).unwrap();
        let files = FileSource::within(&at("alias")).unwrap();
        let code = |name: &str| match files.read(&at(name), MAX_TEXT) {
            Ok(bytes) => String::from_utf8(bytes).unwrap(),
            Err(error) => error.code().to_owned(),
        };
        for (name, expected) in [
            ("root/a", "root/a"),
            ("root/maps/../a", "root/a"),
            ("root/../root/maps/b", "root/maps/b"),
            ("root/good", "root/maps/b"),
            ("alias/a", "root/a"),
            ("root/up/root/a", "root/a"),
            ("root/gone", "file-missing"),
            ("root/no/such/file", "file-missing"),
            ("root/maps", "not-a-file"),
            // Names beside the root that begin like it, and files elsewhere, whether they exist or not.
            ("rooted/secret", "outside-root"),
            ("secret", "outside-root"),
            ("gone", "outside-root"),
            ("root/../secret", "outside-root"),
            ("root/../gone", "outside-root"),
            ("root/up/secret", "outside-root"),
            ("root/up/gone", "outside-root"),
            ("root/bad", "outside-root"),
            ("root/dangling", "outside-root"),
            ("root/bad/x", "outside-root"),
        ] {
            assert_eq!(code(name), expected, "{name}");
        }
        assert!(!files.exists(&at("secret")) && files.exists(&at("root/a")));
        let error = FileSource::within(&at("secret")).unwrap_err();
        assert_eq!(error.code(), "read-failed");
    }
}

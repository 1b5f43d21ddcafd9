//! Files in memory, instead of a file system.

use std::collections::BTreeMap;
use std::fmt;
use std::fs::File;
use std::io::{self, Cursor, Read, Seek, SeekFrom};
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;

/// Files in memory, by their names.
#[derive(Default, PartialEq, Eq)]
pub(crate) struct Held(BTreeMap<PathBuf, Arc<[u8]>>);

impl fmt::Debug for Held {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_set().entries(self.0.keys()).finish()
    }
}

impl Held {
    /// The files of these names; of two with one name the last.
    pub(crate) fn new(files: impl IntoIterator<Item = (PathBuf, Arc<[u8]>)>) -> Self {
        let files = files.into_iter();
        Self(
            files
                .map(|(name, bytes)| (plain_name(&name), bytes))
                .collect(),
        )
    }

    /// The names of files and folders in a folder, some more than once.
    pub(crate) fn names_in(&self, folder: &Path) -> Vec<String> {
        let folder = plain_name(folder);
        let names = self.0.keys().filter_map(|name| {
            let first = name.strip_prefix(&folder).ok()?.components().next()?;
            first.as_os_str().to_str().map(str::to_owned)
        });
        let mut names: Vec<String> = names.collect();
        names.dedup();
        names
    }

    pub(crate) fn get(&self, name: &Path) -> Option<&Arc<[u8]>> {
        self.0.get(&plain_name(name))
    }
}

/// The bytes of a regular file or of one in memory.
#[derive(Debug)]
pub(crate) enum Input {
    File(File),
    Held(Cursor<Arc<[u8]>>),
}

impl Read for Input {
    fn read(&mut self, to: &mut [u8]) -> io::Result<usize> {
        match self {
            Self::File(file) => file.read(to),
            Self::Held(bytes) => bytes.read(to),
        }
    }
}

impl Seek for Input {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        match self {
            Self::File(file) => file.seek(to),
            Self::Held(bytes) => bytes.seek(to),
        }
    }
}

/// A name without `.` and, as far as folders are above, `..`.
fn plain_name(path: &Path) -> PathBuf {
    let mut plain = PathBuf::new();
    for part in path.components() {
        match part {
            Component::CurDir => {}
            Component::ParentDir
                if matches!(plain.components().next_back(), Some(Component::Normal(_))) =>
            {
                plain.pop();
            }
            part => plain.push(part),
        }
    }
    plain
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::FileSource;

    #[test]
    fn files_in_memory_are_all_that_there_is() {
        let files =
            FileSource::in_memory([("a/b.obj".into(), vec![1, 2, 3]), ("c".into(), vec![])]);
        for name in ["a/b.obj", "./a/b.obj", "a/x/../b.obj", "a/../a/./b.obj"] {
            assert_eq!(files.read(Path::new(name), 3).unwrap(), [1, 2, 3], "{name}");
        }
        let code = |name: &str, limit| files.read(Path::new(name), limit).unwrap_err().code();
        assert_eq!(code("a/b.obj", 2), "file-too-large");
        for name in ["b.obj", "../a/b.obj", "/a/b.obj", "a", "/dev/null"] {
            assert_eq!(code(name, 9), "file-missing", "{name}");
        }
        assert!(files.exists(Path::new("c")) && !files.exists(Path::new("/dev/null")));
        assert_eq!(
            format!(
                "{:?}",
                Held::new([
                    ("b".into(), Arc::from([0; 0])),
                    ("a".into(), Arc::from([1]))
                ])
            ),
            r#"{"a", "b"}"#
        );
    }
}

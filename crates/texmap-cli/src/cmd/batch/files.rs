//! Hashes of files and of lists of words.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::SystemTime;

use serde::{Deserialize, Serialize};

/// A file by its contents.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct FileMark {
    pub(crate) path: String,
    pub(crate) bytes: u64,
    /// BLAKE3 of the bytes, the first 128 bits.
    pub(crate) hash: String,
    /// Hash of the decoded pixels, for pictures.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) pixel_hash: Option<String>,
}

impl FileMark {
    /// Reads a regular file. Another kind may have no end, or wait for a writer.
    pub(crate) fn of(path: &Path) -> io::Result<Self> {
        if !fs::metadata(path)?.is_file() {
            return Err(io::Error::new(
                io::ErrorKind::InvalidInput,
                "it is no regular file",
            ));
        }
        let mut hasher = blake3::Hasher::new();
        hasher.update_reader(File::open(path)?)?;
        Ok(Self {
            path: path.to_string_lossy().into_owned(),
            bytes: hasher.count(),
            hash: digits(&hasher),
            pixel_hash: None,
        })
    }
}

/// Hash of words in order; no two lists of words run together.
pub(crate) fn hash_of_parts(parts: impl IntoIterator<Item = impl AsRef<str>>) -> String {
    let mut hasher = blake3::Hasher::new();
    for part in parts {
        let part = part.as_ref();
        hasher.update(&(part.len() as u64).to_le_bytes());
        hasher.update(part.as_bytes());
    }
    digits(&hasher)
}

fn digits(hasher: &blake3::Hasher) -> String {
    let hex = hasher.finalize().to_hex();
    format!("blake3:{}", &hex[..32])
}

/// Size and time of a file when it was read, and its mark.
type Known = (u64, Option<SystemTime>, FileMark);

/// Marks of files that were read before, by their size and time: many items share textures.
#[derive(Debug, Default)]
pub(crate) struct Marks(Mutex<BTreeMap<PathBuf, Known>>);

impl Marks {
    /// The mark of a regular file; `None` for others and those that cannot be read.
    pub(crate) fn of(&self, path: &Path) -> Option<FileMark> {
        let now = fs::metadata(path).ok().filter(fs::Metadata::is_file)?;
        let (bytes, time) = (now.len(), now.modified().ok());
        let known = |all: &BTreeMap<PathBuf, Known>| {
            let (size, then, mark) = all.get(path)?;
            (*size == bytes && time.is_some() && *then == time).then(|| mark.clone())
        };
        if let Some(mark) = known(&self.0.lock().unwrap_or_else(PoisonError::into_inner)) {
            return Some(mark);
        }
        let mark = FileMark::of(path).ok()?;
        let mut all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        all.insert(path.to_owned(), (bytes, time, mark.clone()));
        Some(mark)
    }

    /// True if the file of a mark still has its bytes.
    pub(crate) fn hold(&self, mark: &FileMark) -> bool {
        let path = Path::new(&mark.path);
        let same = |now: &fs::Metadata| now.is_file() && now.len() == mark.bytes;
        fs::metadata(path).is_ok_and(|now| same(&now))
            && self.of(path).is_some_and(|now| now.hash == mark.hash)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_tell_bytes_apart_and_words_too() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a");
        fs::write(&path, "one").unwrap();
        let marks = Marks::default();
        let mark = marks.of(&path).unwrap();
        assert!(marks.hold(&mark));
        fs::write(&path, "two").unwrap();
        assert!(!Marks::default().hold(&mark));
        fs::remove_file(&path).unwrap();
        assert!(!marks.hold(&mark) && marks.of(&path).is_none());
        assert!(FileMark::of(dir.path()).is_err(), "a folder");
        assert_ne!(hash_of_parts(["ab", "c"]), hash_of_parts(["a", "bc"]));
        assert_eq!(hash_of_parts(["ab"]).len(), "blake3:".len() + 32);
    }
}

//! Reading whole files, with errors that name the line which asked for them.

use std::fs::{self, Metadata};
use std::io;
use std::path::{Path, PathBuf};

use texmap_math::MemoryBudget;

use crate::{IoError, Place};

/// Text files (scenes, OBJ, MTL, JSON) above this size are refused: 2 GiB.
pub(crate) const MAX_TEXT: u64 = 1 << 31;

/// Metadata of a regular file that exists.
pub(crate) fn regular(path: &Path, named_by: Option<&Place>) -> Result<Metadata, IoError> {
    let (path, named_by) = (path.to_path_buf(), named_by.cloned());
    match fs::metadata(&path) {
        Ok(metadata) if metadata.is_file() => Ok(metadata),
        Ok(_) => Err(IoError::NotAFile { path, named_by }),
        Err(e)
            if matches!(
                e.kind(),
                io::ErrorKind::NotFound | io::ErrorKind::NotADirectory
            ) =>
        {
            Err(IoError::FileMissing { path, named_by })
        }
        Err(source) => Err(IoError::Read {
            path,
            named_by,
            source,
        }),
    }
}

/// The bytes of a regular file.
pub(crate) fn read(path: &Path, named_by: Option<&Place>) -> Result<Vec<u8>, IoError> {
    let bytes = regular(path, named_by)?.len();
    if bytes > MAX_TEXT {
        return Err(IoError::FileTooLarge {
            path: path.to_path_buf(),
            bytes,
            limit: MAX_TEXT,
        });
    }
    let asked = MemoryBudget::of_process().ask(
        bytes,
        format_args!("the {bytes} bytes of {}", path.display()),
        "split the file",
    );
    asked.map_err(|refused| IoError::memory(refused, named_by))?;
    fs::read(path).map_err(|source| IoError::Read {
        path: path.to_path_buf(),
        named_by: named_by.cloned(),
        source,
    })
}

/// The text of a UTF-8 file, without a byte order mark.
pub(crate) fn read_text(path: &Path, named_by: Option<&Place>) -> Result<String, IoError> {
    let bytes = read(path, named_by)?;
    // A parser and the meshes that it makes take eleven times the bytes of an OBJ, measured on a grid of a million vertices.
    let asked = MemoryBudget::of_process().ask(
        12 * bytes.len() as u64,
        format_args!("what the {} bytes of {} say", bytes.len(), path.display()),
        "split the file",
    );
    asked.map_err(|refused| IoError::memory(refused, named_by))?;
    let mut text = String::from_utf8(bytes).map_err(|e| {
        let (good, _) = e.as_bytes().split_at(e.utf8_error().valid_up_to());
        let good = String::from_utf8_lossy(good);
        let line = good.matches('\n').count() as u32 + 1;
        let column = good.rsplit('\n').next().map_or(0, |l| l.chars().count()) as u32 + 1;
        IoError::NotUtf8 {
            place: Place::new(path, line, column),
        }
    })?;
    if text.starts_with('\u{feff}') {
        text.drain(..'\u{feff}'.len_utf8());
    }
    Ok(text)
}

/// `name` as seen from the directory of `file`; a backslash separates folders too.
pub(crate) fn beside(file: &Path, name: &str) -> PathBuf {
    let directory = file.parent().unwrap_or(Path::new(""));
    let path = directory.join(name);
    if path.exists() || !name.contains('\\') {
        path
    } else {
        directory.join(name.replace('\\', "/"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_the_first_byte_that_is_not_text() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.scene");
        fs::write(&path, b"eye 0 0 6\n# caf\xe9\n").unwrap();
        let error = read_text(&path, None).unwrap_err();
        assert_eq!(error.code(), "not-utf8");
        assert_eq!(error.place().map(|p| (p.line, p.column)), Some((2, 6)));
        fs::write(&path, "\u{feff}eye 0 0 6").unwrap();
        assert_eq!(read_text(&path, None).unwrap(), "eye 0 0 6");
    }

    #[test]
    fn directories_and_missing_files_have_their_own_errors() {
        let dir = tempfile::tempdir().unwrap();
        assert_eq!(read(dir.path(), None).unwrap_err().code(), "not-a-file");
        let error = read(&dir.path().join("no.obj"), None).unwrap_err();
        assert_eq!(error.code(), "file-missing");
    }
}

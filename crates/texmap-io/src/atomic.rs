//! Files that are written whole or not at all.

use std::io::{self, BufWriter, Write};
use std::path::Path;

use crate::IoError;

/// Writes `path` through `write`: into a temporary name in the same directory, renamed when all is written.
///
/// If anything fails, an older file of this name keeps its bytes and the temporary one is removed. A file that is replaced keeps
/// its mode.
///
/// # Errors
/// [`IoError::Write`] when the directory is missing or read-only, when `path` is a directory, or when `write` fails.
pub fn write(
    path: &Path,
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), IoError> {
    try_write(path, &mut once(write)).map_err(|source| IoError::Write {
        path: path.to_path_buf(),
        source,
    })
}

/// A function that can be called by pointer, the first time with effect.
pub(crate) fn once(
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> impl FnMut(&mut dyn Write) -> io::Result<()> {
    let mut write = Some(write);
    move |out| write.take().map_or(Ok(()), |write| write(out))
}

/// Compiled once for all that is written.
fn try_write(
    path: &Path,
    write: &mut dyn FnMut(&mut dyn Write) -> io::Result<()>,
) -> io::Result<()> {
    if path.is_dir() {
        return Err(io::Error::new(
            io::ErrorKind::IsADirectory,
            "the name belongs to a directory",
        ));
    }
    let directory = match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    let old = std::fs::metadata(path).ok().map(|old| old.permissions());
    let mut builder = tempfile::Builder::new();
    builder.prefix(".texmap-").suffix(".part");
    #[cfg(unix)]
    {
        // The mode of an ordinary new file (less the umask), not the private one of temporary files.
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(std::fs::Permissions::from_mode(0o666));
        if let Some(old) = &old {
            builder.permissions(old.clone());
        }
    }
    let file = builder.tempfile_in(directory)?;
    // Errors of the file itself do not show its temporary name.
    let mut out = BufWriter::new(file.as_file());
    write(&mut out)?;
    out.flush()?;
    drop(out);
    if let Some(old) = old {
        // The umask has cleared bits of the mode.
        file.as_file().set_permissions(old)?;
    }
    file.persist(path).map_err(|e| e.error)?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn a_failed_write_leaves_the_old_file_and_no_litter() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.txt");
        write(&path, |w| w.write_all(b"old")).unwrap();
        let error = write(&path, |w| {
            w.write_all(b"half")?;
            Err(io::Error::other("disk full"))
        })
        .unwrap_err();
        assert_eq!(error.code(), "write-failed");
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 1);
        write(&path, |w| w.write_all(b"new")).unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
    }

    #[cfg(unix)]
    #[test]
    fn a_replaced_file_keeps_its_mode() {
        use std::os::unix::fs::PermissionsExt;
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.txt");
        let mode = || fs::metadata(&path).unwrap().permissions().mode() & 0o777;
        write(&path, |w| w.write_all(b"new")).unwrap();
        let plain = dir.path().join("b.txt");
        fs::write(&plain, "").unwrap();
        assert_eq!(
            mode(),
            fs::metadata(&plain).unwrap().permissions().mode() & 0o777
        );
        for kept in [0o600, 0o666, 0o751] {
            fs::set_permissions(&path, fs::Permissions::from_mode(kept)).unwrap();
            write(&path, |w| w.write_all(b"newer")).unwrap();
            assert_eq!(mode(), kept);
        }
    }

    #[test]
    fn directories_are_refused() {
        let dir = tempfile::tempdir().unwrap();
        assert_eq!(
            write(dir.path(), |_| Ok(())).unwrap_err().code(),
            "write-failed"
        );
        let missing = dir.path().join("no/such/dir.png");
        assert_eq!(
            write(&missing, |_| Ok(())).unwrap_err().code(),
            "write-failed"
        );
    }
}

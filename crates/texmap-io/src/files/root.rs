//! One folder as the root: nothing outside of it is read.

use std::io;
use std::path::{Path, PathBuf};

use super::FileSource;
use crate::{IoError, SourceLocation};

impl FileSource {
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

    /// The name without links and `..`, if there is a root to hold it against.
    pub(super) fn resolve(
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

#[cfg(test)]
mod tests {
    use std::fs;

    use super::super::MAX_TEXT;
    use super::*;

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

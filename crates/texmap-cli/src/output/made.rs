//! Folders that are made for outputs, and go again if nothing is written into them.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// Folders that did not exist. Dropped, those that are still empty are removed.
#[derive(Debug, Default)]
pub(super) struct MadeFolders {
    /// From the outermost to the innermost.
    folders: Vec<PathBuf>,
}

impl MadeFolders {
    /// Makes a folder and those around it.
    pub(super) fn new(folder: &Path) -> io::Result<Self> {
        let mut made = Self::default();
        let is_missing = |f: &&Path| !f.as_os_str().is_empty() && !f.exists();
        let missing: Vec<&Path> = folder.ancestors().take_while(is_missing).collect();
        for folder in missing.into_iter().rev() {
            match fs::create_dir(folder) {
                Ok(()) => made.folders.push(folder.to_owned()),
                // Another run may have made it meanwhile.
                Err(e) if e.kind() == io::ErrorKind::AlreadyExists && folder.is_dir() => {}
                Err(e) => return Err(e),
            }
        }
        Ok(made)
    }

    /// Keeps the folders.
    pub(super) fn keep(mut self) {
        self.folders.clear();
    }
}

impl Drop for MadeFolders {
    fn drop(&mut self) {
        for folder in self.folders.iter().rev() {
            // Files of others stay.
            let _ = fs::remove_dir(folder);
        }
    }
}

/// The innermost folder around (or at) a path that exists, as the path spells it; the present folder for a name alone.
pub(super) fn existing(path: &Path) -> &Path {
    let named = path
        .ancestors()
        .find(|part| !part.as_os_str().is_empty() && part.exists());
    named.unwrap_or(Path::new("."))
}

//! Temporary folders beside the outputs. Each holds a locked file, which tells folders in use from those of killed runs.

use std::collections::BTreeSet;
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use tempfile::TempDir;

use crate::interrupt;

/// Prefix of the names of all temporary folders.
pub(super) const PREFIX: &str = ".texmap-";

/// Locked by the run that a folder belongs to, as long as it lives.
const LOCK: &str = "lock";

/// A temporary folder that is removed when it is dropped, when a signal ends the program, or by a later run.
#[derive(Debug)]
pub(crate) struct Folder {
    /// Taken when it is removed.
    folder: Option<TempDir>,
    /// Its full name: a relative one would point elsewhere if the working directory changed.
    path: PathBuf,
    /// Closing the file unlocks it.
    lock: Option<File>,
}

impl Folder {
    /// Makes a folder in `at`, after removing the folders of killed runs there.
    pub(crate) fn new(at: &Path) -> io::Result<Self> {
        sweep_once(at);
        // Locked before a signal can find the folder missing from the list.
        let mut known = interrupt::folders();
        let folder = tempfile::Builder::new().prefix(PREFIX).tempdir_in(at)?;
        let lock = lock(folder.path()).ok();
        let path = std::path::absolute(folder.path())?;
        known.push(path.clone());
        drop(known);
        Ok(Self {
            folder: Some(folder),
            path,
            lock,
        })
    }

    pub(crate) fn path(&self) -> &Path {
        &self.path
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        // Some systems remove no open file.
        self.lock = None;
        self.folder = None;
        // Not before it is gone: a signal would leave it.
        interrupt::forget(&self.path);
    }
}

/// A locked file in the folder. It gets its name when it is locked, so that no other run ever sees it unlocked. Systems without
/// locks have none; then nothing is ever swept.
fn lock(folder: &Path) -> io::Result<File> {
    let fresh = folder.join("lock.new");
    let file = File::create(&fresh)?;
    file.try_lock()?;
    fs::rename(fresh, folder.join(LOCK))?;
    Ok(file)
}

/// [`sweep`], the first time that this process asks for it: a walk may write thousands of files into one folder.
fn sweep_once(at: &Path) {
    static SWEPT: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());
    let mut swept = SWEPT.lock().unwrap_or_else(PoisonError::into_inner);
    if swept.insert(at.to_owned()) {
        sweep(at);
    }
}

/// Removes temporary folders whose lock nobody holds. Folders that cannot be read or removed stay, without a message.
pub(crate) fn sweep(at: &Path) {
    let Ok(entries) = fs::read_dir(at) else {
        return;
    };
    for entry in entries.flatten() {
        let is_ours = entry.file_name().to_string_lossy().starts_with(PREFIX);
        if is_ours && entry.file_type().is_ok_and(|t| t.is_dir()) {
            let _ = remove_stale(&entry.path());
        }
    }
}

/// Removes a folder if its lock is free, and holds the lock meanwhile.
fn remove_stale(folder: &Path) -> io::Result<()> {
    let path = folder.join(LOCK);
    // A pipe of that name would block when it is opened.
    if !path.symlink_metadata()?.is_file() {
        return Ok(());
    }
    let file = File::open(&path)?;
    file.try_lock()?;
    fs::remove_dir_all(folder)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_nobody_holds_is_swept() {
        let dir = tempfile::tempdir().unwrap();
        let living = Folder::new(dir.path()).unwrap();
        // The rest of a killed run: the lock file is there, but free.
        let stale = dir.path().join(".texmap-stale");
        fs::create_dir(&stale).unwrap();
        fs::write(stale.join(LOCK), "").unwrap();
        fs::write(stale.join("0.png"), "half").unwrap();
        // No lock: perhaps of a run that is just starting, or no folder of ours.
        let unknown = dir.path().join(".texmap-unknown");
        fs::create_dir(&unknown).unwrap();
        let other = dir.path().join("texmap-stale");
        fs::create_dir(&other).unwrap();
        fs::write(other.join(LOCK), "").unwrap();
        sweep(dir.path());
        assert!(!stale.exists());
        assert!(living.path().exists() && unknown.exists() && other.exists());
        let path = living.path().to_owned();
        drop(living);
        assert!(!path.exists());
        assert!(interrupt::folders().iter().all(|f| *f != path));
    }

    #[test]
    fn a_folder_is_swept_once() {
        let dir = tempfile::tempdir().unwrap();
        drop(Folder::new(dir.path()).unwrap());
        let stale = dir.path().join(".texmap-later");
        fs::create_dir(&stale).unwrap();
        fs::write(stale.join(LOCK), "").unwrap();
        drop(Folder::new(dir.path()).unwrap());
        assert!(stale.exists());
    }
}

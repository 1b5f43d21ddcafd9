//! Outputs of the verbs. They are checked before anything is drawn, written into a temporary folder
//! beside their final names, and renamed together when all of them are complete.

mod distinct;
mod folder;
mod made;

use std::ffi::OsString;
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use crate::failure::{self, Exit, Failure};
use crate::interrupt;
use crate::observe;
pub(crate) use distinct::distinct;
pub(crate) use folder::{Folder, sweep};
use made::MadeFolders;

/// One output that was found to be writable.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Destination {
    /// `-`.
    Stdout,
    /// A device or pipe, such as /dev/null: written through, never replaced.
    Device(PathBuf),
    /// A file, old or new.
    File(PathBuf),
}

impl Destination {
    /// Refuses folders, names below files, and names without a file part. Folders that do not exist are made with the stage.
    pub(crate) fn new(path: &Path) -> Result<Self, Failure> {
        if path == Path::new("-") {
            return Ok(Self::Stdout);
        }
        if path.file_name().is_none() || path.as_os_str().to_string_lossy().ends_with('/') {
            return Err(unwritable(
                path,
                "the name belongs to a folder",
                "name a file, such as out.png",
            ));
        }
        match fs::metadata(path) {
            Ok(m) if m.is_dir() => Err(unwritable(
                path,
                "the name belongs to a folder",
                "name a file in it, such as out.png",
            )),
            // A symbolic link stays; its target is replaced.
            Ok(m) if m.is_file() => Ok(Self::File(
                fs::canonicalize(path).unwrap_or_else(|_| path.to_owned()),
            )),
            Ok(_) => Ok(Self::Device(path.to_owned())),
            Err(e)
                if matches!(
                    e.kind(),
                    io::ErrorKind::NotFound | io::ErrorKind::NotADirectory
                ) =>
            {
                match made::existing(folder_of(path)) {
                    folder if folder.is_dir() => Ok(Self::File(path.to_owned())),
                    folder => Err(unwritable(
                        path,
                        &format!("{} is no folder", folder.display()),
                        "write elsewhere",
                    )),
                }
            }
            Err(e) => Err(unwritable(
                path,
                &e.to_string(),
                "check the name and its permissions",
            )),
        }
    }
}

/// Outputs that appear together or not at all.
#[derive(Debug)]
pub(crate) struct Stage {
    folder: Folder,
    files: Vec<(PathBuf, Destination)>,
    /// After the folder, which may lie in them; those made last go first.
    made: Vec<MadeFolders>,
}

impl Stage {
    /// A temporary folder on the file system of `main`: making it proves that files can be written there.
    pub(crate) fn new(main: &Destination) -> Result<Self, Failure> {
        let at = match main {
            Destination::Stdout | Destination::Device(_) => std::env::temp_dir(),
            Destination::File(path) => folder_of(path).to_owned(),
        };
        let (folder, made) = proven(&at)?;
        Ok(Self {
            folder,
            files: Vec::new(),
            made: vec![made],
        })
    }

    /// Proves that files can be written beside this one, too, before any output is renamed.
    pub(crate) fn prove(&mut self, other: &Destination) -> Result<(), Failure> {
        if let Destination::File(path) = other {
            let (_, made) = proven(folder_of(path))?;
            self.made.insert(0, made);
        }
        Ok(())
    }

    /// Path of the temporary file that becomes `destination`.
    pub(crate) fn add(&mut self, destination: Destination, ending: &str) -> PathBuf {
        let name = staged_name(self.files.len(), &destination, ending);
        let path = self.folder.path().join(name);
        self.files.push((path.clone(), destination));
        path
    }

    /// Streams outputs to standard output and devices, then renames the rest. No signal comes between two renames.
    pub(crate) fn commit(mut self) -> Result<(), Failure> {
        let refused = |path: &Path, e: &io::Error| {
            let attempt = "check the permissions and the free space";
            unwritable(path, &e.to_string(), attempt)
        };
        for (from, to) in &self.files {
            match to {
                Destination::File(_) => {}
                Destination::Device(path) => {
                    copy_to_device(from, path).map_err(|e| refused(path, &e))?;
                }
                Destination::Stdout => {
                    failure::deliver(|out| io::copy(&mut File::open(from)?, out).map(drop))?;
                }
            }
        }
        let folders = interrupt::folders();
        for (from, to) in &self.files {
            if let Destination::File(path) = to {
                let made = MadeFolders::new(folder_of(path)).map_err(|e| refused(path, &e))?;
                replace(from, path).map_err(|e| refused(path, &e))?;
                made.keep();
                observe::written(path.clone());
            }
        }
        drop(folders);
        let made = std::mem::take(&mut self.made);
        made.into_iter().for_each(MadeFolders::keep);
        Ok(())
    }
}

/// A temporary folder in a folder, which is made if there is none.
fn proven(at: &Path) -> Result<(Folder, MadeFolders), Failure> {
    let refused = |e: io::Error| {
        let attempt = "check the permissions and the free space of the folder";
        unwritable(at, &e.to_string(), attempt)
    };
    let made = MadeFolders::new(at).map_err(refused)?;
    let folder = Folder::new(at).map_err(refused)?;
    Ok((folder, made))
}

/// `0-room.png`: unlike any other name of the stage, and readable in messages.
fn staged_name(number: usize, destination: &Destination, ending: &str) -> OsString {
    let plain = OsString::from(format!("{number}.{ending}"));
    let Destination::File(path) = destination else {
        return plain;
    };
    let same = path.extension().is_some_and(|e| e == ending);
    match path.file_name() {
        // Names have at most 255 bytes.
        Some(name) if same && name.len() < 200 => {
            let mut staged = OsString::from(format!("{number}-"));
            staged.push(name);
            staged
        }
        _ => plain,
    }
}

/// The output that a file of a stage becomes, for messages; other paths are as they are.
pub(crate) fn shown(path: &Path) -> PathBuf {
    let output = || {
        let stage = path.parent()?;
        let name = stage.file_name()?.to_str()?;
        let (number, output) = path.file_name()?.to_str()?.split_once('-')?;
        let ours = name.starts_with(folder::PREFIX) && number.bytes().all(|b| b.is_ascii_digit());
        ours.then(|| stage.with_file_name(output))
    };
    output().unwrap_or_else(|| path.to_owned())
}

fn copy_to_device(from: &Path, device: &Path) -> io::Result<()> {
    let mut out = fs::OpenOptions::new().write(true).open(device)?;
    io::copy(&mut File::open(from)?, &mut out)?;
    out.flush()
}

/// Renames a file over another, which keeps its mode; across file systems it is copied.
fn replace(from: &Path, to: &Path) -> io::Result<()> {
    #[cfg(unix)]
    if let Ok(old) = fs::metadata(to) {
        fs::set_permissions(from, old.permissions())?;
    }
    match fs::rename(from, to) {
        Err(e) if e.kind() == io::ErrorKind::CrossesDevices => {
            let copy = |out: &mut dyn Write| io::copy(&mut File::open(from)?, out).map(drop);
            texmap_io::atomic::write(to, copy).map_err(io::Error::other)
        }
        done => done,
    }
}

fn folder_of(path: &Path) -> &Path {
    path.parent()
        .filter(|p| !p.as_os_str().is_empty())
        .unwrap_or(Path::new("."))
}

fn unwritable(path: &Path, why: &str, attempt: &str) -> Failure {
    Failure::new(
        Exit::Input,
        "write-failed",
        format!("{}: cannot be written: {why}", path.display()),
        format!("{attempt}; an older file of this name was left as it was"),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_appear_together_and_only_on_commit() {
        let dir = tempfile::tempdir().unwrap();
        let (a, b) = (dir.path().join("a.png"), dir.path().join("a.uv.npy"));
        fs::write(&a, "old").unwrap();
        let main = Destination::new(&a).unwrap();
        let mut stage = Stage::new(&main).unwrap();
        fs::write(stage.add(main, "png"), "new").unwrap();
        fs::write(stage.add(Destination::new(&b).unwrap(), "npy"), "uv").unwrap();
        assert_eq!(fs::read_to_string(&a).unwrap(), "old");
        assert!(!b.exists());
        stage.commit().unwrap();
        assert_eq!(fs::read_to_string(&a).unwrap(), "new");
        assert_eq!(fs::read_to_string(&b).unwrap(), "uv");
        assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 2);
    }

    #[cfg(unix)]
    #[test]
    fn an_overwritten_file_keeps_its_mode() {
        use std::os::unix::fs::PermissionsExt;
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.png");
        for mode in [0o600, 0o640, 0o755] {
            fs::write(&path, "old").unwrap();
            fs::set_permissions(&path, fs::Permissions::from_mode(mode)).unwrap();
            let main = Destination::new(&path).unwrap();
            let mut stage = Stage::new(&main).unwrap();
            fs::write(stage.add(main, "png"), "new").unwrap();
            stage.commit().unwrap();
            assert_eq!(fs::read_to_string(&path).unwrap(), "new");
            let kept = fs::metadata(&path).unwrap().permissions().mode();
            assert_eq!(kept & 0o777, mode, "{kept:o}");
        }
    }

    #[test]
    fn messages_name_the_output_and_not_the_stage() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("room-2.png");
        let main = Destination::new(&path).unwrap();
        let mut stage = Stage::new(&main).unwrap();
        let (first, second) = (
            stage.add(main.clone(), "png"),
            stage.add(main.clone(), "png"),
        );
        assert_ne!(first, second);
        // The stage's own path is absolute; so is that of a temporary folder.
        assert_eq!(
            (shown(&first), shown(&second)),
            (path.clone(), path.clone())
        );
        assert_eq!(shown(&path), path);
        let long = dir.path().join("a".repeat(251) + ".png");
        let staged = stage.add(Destination::new(&long).unwrap(), "png");
        fs::write(staged, "").unwrap();
    }

    #[test]
    fn a_dropped_stage_leaves_nothing() {
        let dir = tempfile::tempdir().unwrap();
        let main = Destination::new(&dir.path().join("a.png")).unwrap();
        let mut stage = Stage::new(&main).unwrap();
        fs::write(stage.add(main, "png"), "half").unwrap();
        drop(stage);
        assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 0);
    }

    #[test]
    fn folders_and_lost_names_are_refused() {
        let dir = tempfile::tempdir().unwrap();
        fs::write(dir.path().join("file"), "").unwrap();
        for bad in [
            dir.path().to_owned(),
            dir.path().join("file/such.png"),
            dir.path().join("x/"),
            PathBuf::from(".."),
        ] {
            let failure = Destination::new(&bad).unwrap_err();
            assert_eq!(
                (failure.exit, failure.code.as_str()),
                (Exit::Input, "write-failed"),
                "{}",
                bad.display()
            );
        }
    }

    #[test]
    fn folders_are_made_and_go_again_if_nothing_is_written() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("new/deep/a.png");
        let main = Destination::new(&path).unwrap();
        let mut stage = Stage::new(&main).unwrap();
        fs::write(stage.add(main.clone(), "png"), "half").unwrap();
        drop(stage);
        assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 0);
        let mut stage = Stage::new(&main).unwrap();
        fs::write(stage.add(main, "png"), "whole").unwrap();
        let other = dir.path().join("other/b.png");
        fs::write(stage.add(Destination::new(&other).unwrap(), "png"), "b").unwrap();
        stage.commit().unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), "whole");
        assert_eq!(fs::read_to_string(&other).unwrap(), "b");
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn other_folders_are_proven_before_the_first_file_appears() {
        let dir = tempfile::tempdir().unwrap();
        let main = Destination::new(&dir.path().join("new/a.obj")).unwrap();
        let other = |name: &str| Destination::new(&dir.path().join(name)).unwrap();
        let mut stage = Stage::new(&main).unwrap();
        stage.prove(&other("new/deep/pictures/b.png")).unwrap();
        let refused = stage.prove(&Destination::new(Path::new("/proc/b/b.png")).unwrap());
        assert_eq!(refused.unwrap_err().code, "write-failed");
        drop(stage);
        assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 0);
    }

    #[cfg(unix)]
    #[test]
    fn devices_and_links_are_written_through() {
        assert_eq!(
            Destination::new(Path::new("/dev/null")),
            Ok(Destination::Device("/dev/null".into()))
        );
        let dir = tempfile::tempdir().unwrap();
        let (file, link) = (dir.path().join("file.png"), dir.path().join("link.png"));
        fs::write(&file, "old").unwrap();
        std::os::unix::fs::symlink(&file, &link).unwrap();
        let main = Destination::new(&link).unwrap();
        let mut stage = Stage::new(&main).unwrap();
        fs::write(stage.add(main, "png"), "new").unwrap();
        stage.commit().unwrap();
        assert!(link.is_symlink());
        assert_eq!(fs::read_to_string(&file).unwrap(), "new");
    }
}

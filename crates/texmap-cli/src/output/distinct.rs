//! The check that no output overwrites an input or another output.

use std::collections::BTreeMap;
use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};

use super::folder_of;
use super::made::existing;
use crate::failure::Failure;

/// Identity of a file, whatever the spelling of its name.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Identity {
    /// `-`.
    Stdout,
    /// Device and inode number of a file that exists.
    #[cfg(unix)]
    Inode(u64, u64),
    /// Full path without links; the file may be missing.
    Path(PathBuf),
}

impl Identity {
    /// `None` for devices and pipes, in which nothing is lost.
    fn of(path: &Path) -> Option<Self> {
        if path == Path::new("-") {
            return Some(Self::Stdout);
        }
        match std::fs::metadata(path) {
            Ok(metadata) if !metadata.is_file() => None,
            #[cfg(unix)]
            Ok(metadata) => {
                use std::os::unix::fs::MetadataExt;
                Some(Self::Inode(metadata.dev(), metadata.ino()))
            }
            #[cfg(not(unix))]
            Ok(_) => std::fs::canonicalize(path).ok().map(Self::Path),
            Err(_) => {
                // Folders that are yet to be made are as they are written.
                let there = existing(folder_of(path));
                let rest = path.strip_prefix(there).unwrap_or(path);
                let folder = std::fs::canonicalize(there).ok()?;
                Some(Self::Path(folder.join(rest)))
            }
        }
    }
}

/// Refuses outputs of which one is an input or another output, whatever links and spellings lie between.
///
/// Every verb calls this before it reads anything, and one that reads scenes again with what they name
/// ([`FileSource::recorded`](texmap_io::FileSource::recorded)), before it draws. Inputs that are missing and words that are no files
/// may be named too.
pub(crate) fn distinct<O, I>(
    outputs: impl IntoIterator<Item = O>,
    inputs: impl IntoIterator<Item = I>,
) -> Result<(), Failure>
where
    O: AsRef<OsStr>,
    I: AsRef<OsStr>,
{
    let mut outputs = outputs.into_iter().map(|name| name.as_ref().to_owned());
    let mut inputs = inputs.into_iter().map(|name| name.as_ref().to_owned());
    all_distinct(&mut outputs, &mut inputs)
}

/// [`distinct`], compiled once for all lists.
fn all_distinct(
    outputs: &mut dyn Iterator<Item = OsString>,
    inputs: &mut dyn Iterator<Item = OsString>,
) -> Result<(), Failure> {
    let identified = |name: OsString| Some((Identity::of(Path::new(&name))?, name));
    let inputs: BTreeMap<_, _> = inputs
        .filter_map(identified)
        .filter(|(identity, _)| *identity != Identity::Stdout)
        .collect();
    let mut seen: BTreeMap<Identity, OsString> = BTreeMap::new();
    for (identity, name) in outputs.filter_map(identified) {
        let shown = Path::new(&name).display();
        let named = |other: &OsStr| match other == name {
            true => String::new(),
            false => format!(" {}", Path::new(other).display()),
        };
        if let Some(input) = inputs.get(&identity) {
            return Err(Failure::usage(
                format!("{shown}: the output is the input{}", named(input)),
                "write to another name",
            ));
        }
        if let Some(other) = seen.get(&identity) {
            return Err(Failure::usage(
                format!("{shown}: two outputs are one file{}", named(other)),
                "give each its own name",
            ));
        }
        seen.insert(identity, name);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::failure::Exit;

    #[test]
    fn outputs_differ_from_inputs_and_from_each_other() {
        let dir = tempfile::tempdir().unwrap();
        let at = |name: &str| dir.path().join(name);
        std::fs::write(at("in.png"), "x").unwrap();
        let check = |outputs: &[PathBuf], inputs: &[PathBuf]| {
            distinct(outputs, inputs).map_err(|f| {
                assert_eq!((f.exit, f.code.as_str()), (Exit::Usage, "usage"));
                f.what
            })
        };
        assert_eq!(check(&[at("a.png"), at("b.png")], &[at("in.png")]), Ok(()));
        // A file that does not exist is no input; the output is not there yet either.
        assert_eq!(check(&[at("a.png")], &[at("b.png"), at("no/x")]), Ok(()));
        assert!(check(&[at("in.png")], &[at("in.png")]).is_err());
        let spelled = check(
            &[at("../").join(dir.path()).join("./in.png")],
            &[at("in.png")],
        );
        assert!(spelled.unwrap_err().contains("the output is the input /"));
        assert!(
            check(&[at("new"), at("./new")], &[])
                .unwrap_err()
                .contains("two outputs")
        );
        assert!(check(&["-".into(), "-".into()], &[]).is_err());
        assert_eq!(check(&["-".into()], &["-".into()]), Ok(()));
        #[cfg(unix)]
        {
            std::os::unix::fs::symlink(at("in.png"), at("soft.png")).unwrap();
            std::fs::hard_link(at("in.png"), at("hard.png")).unwrap();
            for other in ["soft.png", "hard.png"] {
                assert!(check(&[at(other)], &[at("in.png")]).is_err(), "{other}");
            }
            let null = PathBuf::from("/dev/null");
            assert_eq!(check(&[null.clone(), null.clone()], &[null]), Ok(()));
        }
    }
}

//! The inputs of `texmap render`: files, lists of files (`@list.txt`), and standard input (`-`).

use std::io::{self, Read};
use std::path::{Path, PathBuf};

use texmap_io::FileSource;

use crate::failure::{Exit, Failure};
use crate::os_name;

/// A model from standard input is refused above this size: 2 GiB, as files are.
const MAX_STDIN: u64 = 1 << 31;

/// The files to read.
#[derive(Debug)]
pub(crate) struct Inputs {
    /// As they are named in reports; `-` for standard input.
    pub(crate) names: Vec<PathBuf>,
    /// Path of the model on standard input, and the files that it may name.
    stdin: Option<(PathBuf, FileSource)>,
}

impl Inputs {
    /// Replaces every `@list` by the files that its lines name, beside the list, and reads standard input for `-`. Empty lines and those
    /// that begin with `#` are skipped. What standard input names is looked for in `root`.
    pub(crate) fn read(
        given: &[PathBuf],
        files: &FileSource,
        root: Option<&Path>,
    ) -> Result<Self, Failure> {
        let mut names = Vec::new();
        for input in given {
            let bytes = os_name::bytes(input.as_os_str());
            match bytes.strip_prefix(b"@") {
                Some(list) if !input.exists() => {
                    let list = PathBuf::from(os_name::of_bytes(list.to_vec()));
                    names.extend(listed(&list, files)?);
                }
                _ => names.push(input.clone()),
            }
        }
        let dashes = names.iter().filter(|n| n.as_os_str() == "-").count();
        if dashes > 1 {
            return Err(Failure::usage(
                "`-` is named twice",
                "standard input is one model",
            ));
        }
        let stdin = match dashes {
            0 => None,
            _ => {
                let bytes = from_stdin()?;
                let name = PathBuf::from(format!("stdin.{}", ending(&bytes)));
                Some(match root {
                    Some(folder) => {
                        let file = folder.join(name);
                        (file.clone(), files.clone().with_file(file, bytes))
                    }
                    // Standard input names no files of this machine.
                    None => (name.clone(), FileSource::in_memory([(name, bytes)])),
                })
            }
        };
        Ok(Self { names, stdin })
    }

    /// The file that an input is read from, and those beside it; `files` but for standard input.
    pub(crate) fn file<'a>(
        &'a self,
        name: &'a Path,
        files: &'a FileSource,
    ) -> (&'a Path, &'a FileSource) {
        match &self.stdin {
            Some((file, files)) if name.as_os_str() == "-" => (file, files),
            _ => (name, files),
        }
    }
}

/// Bytes of a path that systems open.
const LONGEST_NAME: usize = 4096;

/// The files that a list names, one a line, beside it.
pub(crate) fn listed(list: &Path, files: &FileSource) -> Result<Vec<PathBuf>, Failure> {
    let text = files.read_text(list, FileSource::MAX_LIST)?;
    let folder = list.parent().unwrap_or(Path::new(""));
    let mut names = Vec::new();
    for (number, line) in (1..).zip(text.lines().map(str::trim)) {
        if line.is_empty() || line.starts_with('#') {
            continue;
        }
        // Lines of another kind of file are not told: they may be secret.
        if line.len() > LONGEST_NAME || Path::new(line).extension().is_none() {
            return Err(Failure::new(
                Exit::Input,
                "bad-list",
                format!(
                    "{}:{number}: not the name of a file with an ending",
                    list.display()
                ),
                "write one file a line, as room.scene; `#` begins a comment",
            ));
        }
        names.push(folder.join(line));
    }
    match names.is_empty() {
        false => Ok(names),
        true => Err(Failure::new(
            Exit::Input,
            "empty-list",
            format!("{}: the list names no file", list.display()),
            "write one file a line",
        )),
    }
}

/// The bytes of standard input.
fn from_stdin() -> Result<Vec<u8>, Failure> {
    let refused = |e: io::Error| {
        Failure::new(
            Exit::Input,
            "read-failed",
            format!("standard input: cannot be read: {e}"),
            "name a file, or pipe one in: cat model.obj | texmap render - -o model.png",
        )
    };
    let mut bytes = Vec::new();
    let mut stdin = io::stdin().lock().take(MAX_STDIN + 1);
    stdin.read_to_end(&mut bytes).map_err(refused)?;
    if bytes.is_empty() {
        return Err(refused(io::Error::other("it is empty")));
    }
    if bytes.len() as u64 > MAX_STDIN {
        return Err(refused(io::Error::other("it has more than 2 GiB")));
    }
    Ok(bytes)
}

/// The name ending of files with these contents.
fn ending(bytes: &[u8]) -> &'static str {
    let text = bytes.trim_ascii_start();
    let first = text.split(|b| b.is_ascii_whitespace()).next();
    // The size of a binary STL follows from the count behind its header.
    let stl = bytes.get(80..84).and_then(|count| count.try_into().ok());
    let stl = stl
        .is_some_and(|count| bytes.len() as u64 == 84 + 50 * u64::from(u32::from_le_bytes(count)));
    match first {
        _ if bytes.starts_with(b"glTF") => "glb",
        _ if text.starts_with(b"{") => "gltf",
        Some(b"ply") => "ply",
        _ if stl => "stl",
        Some(b"solid") => "stl",
        _ if is_obj(bytes) => "obj",
        _ => "scene",
    }
}

/// An OBJ counts its corners from 1 and joins coordinates with slashes; a scene has lines that no OBJ has.
fn is_obj(bytes: &[u8]) -> bool {
    let words = |line: &[u8]| {
        let line = line.trim_ascii();
        let word = line.split(|b| b.is_ascii_whitespace()).next();
        word.unwrap_or_default().to_vec()
    };
    let mut lines = bytes.split(|b| *b == b'\n').map(words);
    let of_scenes: [&[u8]; 12] = [
        b"eye",
        b"look",
        b"fov",
        b"background",
        b"obj",
        b"texture",
        b"tf",
        b"ff",
        b"surf",
        b"ambient",
        b"light",
        b"include",
    ];
    !lines.any(|word| of_scenes.contains(&&word[..]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_comes_in_is_told_by_how_it_begins() {
        let mut stl = vec![b's'; 80];
        stl.extend(1_u32.to_le_bytes());
        stl.extend([0; 50]);
        for (bytes, expected) in [
            (&b"glTF\x02\0\0\0"[..], "glb"),
            (b"  {\"asset\":{}}", "gltf"),
            (b"ply\nformat ascii 1.0\n", "ply"),
            (b"solid cube\nfacet normal", "stl"),
            (&stl, "stl"),
            (
                b"# a square\nmtllib a.mtl\nv 0 0 0\nvt 0 0\nf 1/1 2/2 3/3\n",
                "obj",
            ),
            (b"eye 0 0 5\nlook 0 0 0\nv 0 0 0\nf 0 1 2\n", "scene"),
        ] {
            assert_eq!(
                ending(bytes),
                expected,
                "{}",
                String::from_utf8_lossy(bytes)
            );
        }
    }

    #[test]
    fn lists_name_files_beside_them() {
        let dir = tempfile::tempdir().unwrap();
        let list = dir.path().join("all.txt");
        std::fs::write(&list, "# models\na.obj\n\n  sub/b.obj \n").unwrap();
        let names = listed(&list, &FileSource::anywhere()).unwrap();
        assert_eq!(
            names,
            [dir.path().join("a.obj"), dir.path().join("sub/b.obj")]
        );
        let long = format!("{}.obj", "Q".repeat(5000));
        for other in ["user password", &long] {
            std::fs::write(&list, format!("a.obj\n{other}\n")).unwrap();
            let error = listed(&list, &FileSource::anywhere()).unwrap_err();
            assert_eq!(error.code, "bad-list");
            assert!(error.what.contains("all.txt:2"), "{}", error.what);
            assert!(!error.what.contains(other), "{}", error.what);
        }
        std::fs::write(&list, "# none\n").unwrap();
        assert_eq!(
            listed(&list, &FileSource::anywhere()).unwrap_err().code,
            "empty-list"
        );
    }
}

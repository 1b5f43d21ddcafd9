//! Files that a model names as another machine has them: by a path of that machine, or in letters of another case.

use std::collections::{BTreeMap, HashMap};
use std::fs;
use std::path::{Path, PathBuf};

use super::FileSource;

/// Folders of more names than this are not searched.
const MOST_NAMES: usize = 1 << 16;

/// Searches for files that are not where models say, and what they found.
#[derive(Debug, Default)]
pub(crate) struct Lost {
    /// The names in a folder by their small letters.
    folders: HashMap<PathBuf, BTreeMap<String, Vec<String>>>,
    /// Results by folder and name.
    known: HashMap<(PathBuf, String), Option<String>>,
}

impl Lost {
    /// A file that `model` names and that is not there: its name, as seen from the folder of the model, in letters of another case; else the
    /// last part of the name in that folder, in any case. `None` for a file that is there, for one that is nowhere, and where several
    /// names differ from it in case alone. Beside it true the first time.
    pub(crate) fn find(
        &mut self,
        files: &FileSource,
        model: &Path,
        name: &str,
    ) -> Option<(String, bool)> {
        let key = key(model, name);
        if let Some(known) = self.known.get(&key) {
            return known.clone().map(|name| (name, false));
        }
        let folder = key.0.as_path();
        let found = if files.exists(&files.beside(model, name)) {
            None
        } else {
            // Some programs put names of blanks into quotes.
            let name = name.trim_matches('"').replace('\\', "/");
            let whole = (!name.starts_with('/')).then(|| self.file(files, folder, &name));
            let last = name.rsplit('/').next().unwrap_or_default();
            whole.flatten().or_else(|| self.file(files, folder, last))
        };
        self.known.insert(key, found.clone());
        found.map(|name| (name, true))
    }

    /// The name that [`find`](Self::find) found before.
    pub(crate) fn found(&self, model: &Path, name: &str) -> Option<&str> {
        self.known.get(&key(model, name))?.as_deref()
    }

    /// The file of a relative name in a folder.
    fn file(&mut self, files: &FileSource, folder: &Path, name: &str) -> Option<String> {
        let mut found = String::new();
        for part in name.split('/').filter(|part| !matches!(*part, "" | ".")) {
            let real = match part {
                ".." => part.to_owned(),
                _ => self.entry(files, folder.join(&found), part)?,
            };
            if !found.is_empty() {
                found.push('/');
            }
            found.push_str(&real);
        }
        files.check(&folder.join(&found), None).ok().map(|()| found)
    }

    /// The name in a folder that a name means.
    fn entry(&mut self, files: &FileSource, folder: PathBuf, name: &str) -> Option<String> {
        let names = self.folders.entry(folder).or_insert_with_key(|folder| {
            let mut names = BTreeMap::<String, Vec<String>>::new();
            for name in files.names_in(folder) {
                names.entry(name.to_lowercase()).or_default().push(name);
            }
            names
        });
        let like = names.get(&name.to_lowercase())?;
        match like.as_slice() {
            [one] => Some(one.clone()),
            several => several.iter().find(|other| *other == name).cloned(),
        }
    }
}

/// The folder of a model, and a name in it.
fn key(model: &Path, name: &str) -> (PathBuf, String) {
    let folder = model.parent().unwrap_or(Path::new(""));
    (folder.to_path_buf(), name.to_owned())
}

impl FileSource {
    /// The names of files and folders in a folder; none of one that may not be read or holds too many.
    fn names_in(&self, folder: &Path) -> Vec<String> {
        if let Some(held) = &self.held {
            return held.names_in(folder);
        }
        let folder = match folder.as_os_str().is_empty() {
            true => Path::new("."),
            false => folder,
        };
        let Ok(real) = self.resolve(folder, None) else {
            return Vec::new();
        };
        let Ok(entries) = fs::read_dir(real.as_deref().unwrap_or(folder)) else {
            return Vec::new();
        };
        let names = entries.flatten().take(MOST_NAMES + 1);
        let names: Vec<_> = names.map(|entry| entry.file_name()).collect();
        if names.len() > MOST_NAMES {
            return Vec::new();
        }
        let names = names.into_iter();
        names.filter_map(|name| name.into_string().ok()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NAMES: [&str; 6] = [
        "a.obj",
        "Wood.PNG",
        "maps/Brick.jpg",
        "two.png",
        "Two.png",
        "wood file.png",
    ];

    /// Names in a model and the files that are found.
    const CASES: [(&str, Option<&str>); 16] = [
        // They are there.
        ("Wood.PNG", None),
        ("maps\\Brick.jpg", None),
        ("two.png", None),
        // Letters of another case.
        ("wood.png", Some("Wood.PNG")),
        ("./MAPS/brick.JPG", Some("maps/Brick.jpg")),
        ("Maps\\Brick.jpg", Some("maps/Brick.jpg")),
        ("maps/../WOOD.png", Some("maps/../Wood.PNG")),
        // Of another machine.
        ("C:\\Users\\me\\wood.png", Some("Wood.PNG")),
        ("/home/me/model/Wood.PNG", Some("Wood.PNG")),
        ("textures/Wood.PNG", Some("Wood.PNG")),
        ("\"wood file.png\"", Some("wood file.png")),
        // Two files differ in case alone: only the very name means one of them.
        ("TWO.png", None),
        ("C:/me/Two.png", Some("Two.png")),
        // Nowhere, and folders.
        ("Brick.jpg", None),
        ("maps", None),
        ("", None),
    ];

    fn check(files: &FileSource, model: &Path) {
        let mut lost = Lost::default();
        for first in [true, false] {
            for (name, right) in CASES {
                let found = lost.find(files, model, name);
                let right = right.map(|right| (right.to_owned(), first));
                assert_eq!(found, right, "{name}");
            }
        }
    }

    #[test]
    fn names_of_other_machines_are_found() {
        let dir = tempfile::tempdir().unwrap();
        fs::create_dir(dir.path().join("maps")).unwrap();
        for name in NAMES {
            fs::write(dir.path().join(name), name).unwrap();
        }
        // A file system that takes both cases for one has no second file.
        if fs::read_dir(dir.path()).unwrap().count() == NAMES.len() {
            check(&FileSource::anywhere(), &dir.path().join("a.obj"));
            let inside = FileSource::within(dir.path()).unwrap();
            check(&inside, &dir.path().join("a.obj"));
        }
        let held = NAMES.map(|name| (PathBuf::from("m").join(name), vec![0]));
        check(&FileSource::in_memory(held), Path::new("m/a.obj"));
        let held = NAMES.map(|name| (PathBuf::from(name), vec![0]));
        check(&FileSource::in_memory(held), Path::new("a.obj"));
    }

    #[test]
    fn nothing_outside_of_a_root_is_found() {
        let dir = tempfile::tempdir().unwrap();
        let root = dir.path().join("root");
        fs::create_dir(&root).unwrap();
        fs::write(dir.path().join("Secret.png"), "x").unwrap();
        let files = FileSource::within(&root).unwrap();
        let model = root.join("a.obj");
        let find = |files: &FileSource| Lost::default().find(files, &model, "../secret.png");
        assert_eq!(find(&files), None);
        let anywhere = find(&FileSource::anywhere());
        assert_eq!(anywhere, Some(("../Secret.png".to_owned(), true)));
    }
}

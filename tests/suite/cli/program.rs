//! A working folder with a small scene and a small model, and the program to run in it.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use tempfile::TempDir;

/// Exit code and output of a run of the program.
#[derive(Debug)]
pub(crate) struct Run {
    pub(crate) code: i32,
    pub(crate) stdout: Vec<u8>,
    pub(crate) stderr: String,
}

impl Run {
    /// The JSON document on standard output.
    pub(crate) fn json(&self) -> serde_json::Value {
        serde_json::from_slice(&self.stdout)
            .unwrap_or_else(|e| panic!("{e}: {}", String::from_utf8_lossy(&self.stdout)))
    }

    /// The same run, if it ended with exit code 0.
    #[track_caller]
    pub(crate) fn ok(self) -> Self {
        assert_eq!(self.code, 0, "{}", self.stderr);
        self
    }
}

/// A folder of its own for each test.
pub(crate) struct Desk {
    folder: TempDir,
}

/// A textured floor and a coloured wall, seen with a roll: along a row w changes, as span methods need to show.
pub(crate) const ROOM: &str = "\
eye 0 1 6
look 0 1 0
up 0.2 1 0
fov 60
la 0.4 0.4 0.4
ld 0.6 0.6 0.6 0.3 -1 -0.5
surf 0.9 0.7 0.5 0.4 0.6 0 1
v -2 0 -2
v 2 0 -2
v 2 0 4
v -2 0 4
v -2 2 -2
v 2 2 -2
v 0 1 0
f 4 5 6
texture check.png
tf 0 0 0 3 0 4 2 4 4 1 4 0
";

/// A quad and a triangle in two groups, one of them textured.
pub(crate) const MODEL: &str = "\
mtllib m.mtl
v -1 -1 0
v 1 -1 0
v 1 1 0
v -1 1 0
v 0 0 1
vt 0 0
vt 2 0
vt 2 1
vt 0 1
o panel
usemtl paper
f 1/1 2/2 3/3 4/4
o spike
usemtl plain
f 1 2 5
";

impl Desk {
    pub(crate) fn new() -> Self {
        let desk = Self {
            folder: tempfile::tempdir().unwrap(),
        };
        desk.put("room.scene", ROOM);
        desk.put("m.obj", MODEL);
        desk.put(
            "m.mtl",
            "newmtl paper\nKd 1 1 1\nmap_Kd check.png\nnewmtl plain\nKd 0.8 0.2 0.2\n",
        );
        let check = image::RgbaImage::from_fn(8, 8, |x, y| {
            image::Rgba(if (x / 2 + y / 2) % 2 == 0 {
                [250, 250, 240, 255]
            } else {
                [40, 60, 90, 255]
            })
        });
        check.save(desk.path("check.png")).unwrap();
        desk
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub(crate) fn put(&self, name: &str, content: impl AsRef<[u8]>) {
        fs::write(self.path(name), content).unwrap();
    }

    pub(crate) fn read(&self, name: &str) -> Vec<u8> {
        fs::read(self.path(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
    }

    /// Names of everything in the folder, hidden files too.
    pub(crate) fn names(&self) -> Vec<String> {
        let mut names: Vec<String> = fs::read_dir(self.folder.path())
            .unwrap()
            .map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned())
            .collect();
        names.sort();
        names
    }

    /// A picture that a run wrote.
    pub(crate) fn picture(&self, name: &str) -> image::RgbaImage {
        image::open(self.path(name)).unwrap().into_rgba8()
    }

    /// Runs the program, which refuses with this exit code and word and writes nothing.
    #[track_caller]
    pub(crate) fn refused(&self, arguments: &str, code: i32, word: &str) {
        let before = self.names();
        let run = self.texmap(arguments);
        assert_eq!(run.code, code, "{arguments}: {}", run.stderr);
        assert!(run.stderr.contains(word), "{arguments}: {}", run.stderr);
        assert_eq!(self.names(), before, "{arguments}");
    }

    /// Runs the program in the folder; the arguments are words separated by spaces.
    pub(crate) fn texmap(&self, arguments: &str) -> Run {
        run(
            self.folder.path(),
            &arguments.split_whitespace().collect::<Vec<_>>(),
        )
    }
}

/// Runs the program in any folder.
pub(crate) fn run(folder: &Path, arguments: &[&str]) -> Run {
    let output = Command::new(env!("CARGO_BIN_EXE_texmap-tested"))
        .args(arguments)
        .current_dir(folder)
        .output()
        .unwrap();
    Run {
        code: output.status.code().unwrap_or(-1),
        stdout: output.stdout,
        stderr: String::from_utf8(output.stderr).unwrap(),
    }
}

/// The folder of the repository.
pub(crate) fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .parent()
        .unwrap()
        .to_owned()
}

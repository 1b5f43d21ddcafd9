//! A directory of small files.

use std::fs;
use std::path::{Path, PathBuf};

use tempfile::TempDir;
use texmap_io::{IoError, LoadOptions, image_io, load};
use texmap_scene::Scene;

pub(crate) struct Files(TempDir);

impl Files {
    pub(crate) fn new() -> Self {
        Self(tempfile::tempdir().expect("a temporary directory"))
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub(crate) fn root(&self) -> &Path {
        self.0.path()
    }

    /// Writes a file; `name` may lie in a folder.
    pub(crate) fn with(self, name: &str, bytes: impl AsRef<[u8]>) -> Self {
        let path = self.path(name);
        fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
        fs::write(path, bytes).expect("a file");
        self
    }

    /// A picture whose texels are all `color`, but black in the top row.
    pub(crate) fn with_png(self, name: &str, width: u32, height: u32, color: [u8; 4]) -> Self {
        let row = 4 * width as usize;
        let mut texels = color.repeat((width * height) as usize);
        texels[..row].copy_from_slice(&[0, 0, 0, 255].repeat(width as usize));
        image_io::write_png(&self.path(name), width, height, &texels).expect("a picture");
        self
    }

    pub(crate) fn load(&self, name: &str) -> Result<Scene, IoError> {
        load(&self.path(name), &LoadOptions::default())
    }

    /// The scene of this text, which must be right.
    pub(crate) fn scene(self, text: &str) -> Scene {
        let files = self.with("a.scene", text);
        files
            .load("a.scene")
            .unwrap_or_else(|e| panic!("{e}; {}", e.help()))
    }
}

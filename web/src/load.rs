//! Files in memory, and scenes from them: prepared as `texmap render` prepares them, so that pictures have the same bytes.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use texmap_io::framing::{Framing, Up, light_as_model};
use texmap_io::scene_file::Missing;
use texmap_io::{FileSource, IoError, LoadOptions};
use texmap_scene::Scene;

/// The files that requests name.
#[derive(Clone, Debug, Default)]
pub struct Files {
    held: BTreeMap<PathBuf, Arc<[u8]>>,
    source: FileSource,
}

impl Files {
    /// No file.
    #[must_use]
    pub fn new() -> Self {
        let mut files = Self::default();
        files.hold();
        files
    }

    /// Adds files, each in place of one of its name.
    pub fn add(&mut self, files: impl IntoIterator<Item = (PathBuf, Vec<u8>)>) {
        let files = files.into_iter();
        self.held
            .extend(files.map(|(name, bytes)| (name, bytes.into())));
        self.hold();
    }

    /// Takes a file away, and gives its memory back.
    pub fn remove(&mut self, name: &Path) {
        self.held.remove(name);
        self.hold();
    }

    fn hold(&mut self) {
        self.source = FileSource::shared(self.held.clone());
    }

    /// Reads a scene or model; `text` stands in for the contents of a file of that name.
    ///
    /// # Errors
    /// The first fault and its remedy, as the program prints them.
    pub(crate) fn scene(
        &self,
        file: &str,
        text: Option<&str>,
        aspect: f64,
    ) -> Result<Scene, String> {
        let path = Path::new(file);
        let mut files = self.source.clone();
        if let Some(text) = text {
            files = files.with_file(path.to_path_buf(), text.as_bytes().to_vec());
        }
        let ending = path.extension().and_then(|e| e.to_str()).unwrap_or("");
        let model = !ending.eq_ignore_ascii_case("scene");
        let up = match ending.eq_ignore_ascii_case("stl") {
            true => Up::Z,
            false => Up::Y,
        };
        let options = LoadOptions {
            aspect,
            framing: Framing {
                up,
                ..Framing::default()
            },
            missing: model.then_some(Missing::Checker),
            files,
            ..LoadOptions::default()
        };
        let mut scene = texmap_io::load(path, &options).map_err(|e| words(&e))?;
        if model {
            light_as_model(&mut scene, up);
        }
        Ok(scene)
    }
}

fn words(error: &IoError) -> String {
    format!("{error}\n{}", error.help())
}

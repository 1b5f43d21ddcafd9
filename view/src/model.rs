//! The scene or model of the window, prepared as `texmap render` prepares it.

use std::path::Path;

use texmap_io::framing::{Framing, Up, light_as_model};
use texmap_io::scene_file::Missing;
use texmap_io::{FileSource, LoadOptions};
use texmap_scene::Scene;

use crate::watch::Watch;

/// A scene, its name and the files that it was read from.
#[derive(Debug)]
pub(crate) struct Model {
    pub(crate) scene: Scene,
    pub(crate) name: String,
    pub(crate) is_scene: bool,
    aspect: f64,
    watch: Watch,
}

impl Model {
    pub(crate) fn read(file: &Path, aspect: f64) -> Result<Self, String> {
        let ending = file
            .extension()
            .and_then(|e| e.to_str())
            .unwrap_or("")
            .to_ascii_lowercase();
        let is_scene = ending == "scene";
        let up = if ending == "stl" { Up::Z } else { Up::Y };
        let files = FileSource::anywhere().recording();
        let options = LoadOptions {
            aspect,
            framing: Framing {
                up,
                ..Framing::default()
            },
            missing: (!is_scene).then_some(Missing::Checker),
            files: files.clone(),
            ..LoadOptions::default()
        };
        let mut scene =
            texmap_io::load(file, &options).map_err(|e| format!("{e}\n  {}", e.help()))?;
        // Chains that lie ready are not rebuilt for each frame.
        scene.textures = scene.textures.into_iter().map(|t| t.with_mips()).collect();
        if !is_scene {
            light_as_model(&mut scene, up);
        }
        for warning in &scene.warnings {
            eprintln!("warning: {warning}");
        }
        Ok(Self {
            scene,
            name: file
                .file_name()
                .map_or_else(String::new, |n| n.to_string_lossy().into_owned()),
            is_scene,
            aspect,
            watch: Watch::new(files.recorded()),
        })
    }

    pub(crate) fn changed(&mut self) -> bool {
        self.watch.changed()
    }

    /// Reads the file again; the old scene stays where that fails.
    pub(crate) fn again(&mut self, file: &Path) -> Result<(), String> {
        *self = Self::read(file, self.aspect)?;
        Ok(())
    }
}

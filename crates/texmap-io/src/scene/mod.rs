//! Files to scenes.

mod build;
mod effects;
mod environments;
mod facets;
mod labels;
mod lights;
mod materials;
mod second_uvs;
mod settings;
mod shapes;
mod table;
mod tree;
mod volumes;

use std::path::Path;

use texmap_light::PhongMaterial;
use texmap_math::camera::Camera;
use texmap_math::glam::DVec3;
use texmap_raster::DepthTest;
use texmap_scene::{ColorMode, Scene};

use crate::framing::{AUTO_FOV, Bounds, View, auto_lights};
use crate::scene_file::Missing;
use crate::textures::Textures;
use crate::{FileSource, IoError, SourceLocation, obj};
use build::Builder;
use settings::Settings;

pub use table::{SECTIONS, Section, Spec, commands};
pub(crate) use table::{command, nearest};
pub(crate) use tree::Tree;

/// What the files do not say.
#[derive(Debug, Clone, PartialEq)]
pub struct LoadOptions {
    /// What a missing map or material library is; `missing` lines of a scene overrule it.
    pub missing: Missing,
    /// Width / height of the picture that an automatic camera has to fill.
    pub aspect: f64,
    /// Whether colours are converted, instead of what the scene says (an OBJ: that they are).
    pub color: Option<ColorMode>,
    /// Where all files are read from, the one that is loaded too.
    pub files: FileSource,
}

impl Default for LoadOptions {
    /// Missing files are errors; pictures of 16 : 9; colours as the scene says; files from anywhere.
    fn default() -> Self {
        Self {
            missing: Missing::Error,
            aspect: 16.0 / 9.0,
            color: None,
            files: FileSource::anywhere(),
        }
    }
}

/// Reads a `.scene` or `.obj` file.
///
/// # Errors
/// Whatever is wrong with it or with a file it names, see [`IoError`]; [`IoError::UnknownFormat`] for other names.
pub fn load(path: &Path, options: &LoadOptions) -> Result<Scene, IoError> {
    match kind(path, &options.files)? {
        Kind::Scene => load_scene(path, options),
        Kind::Obj => load_obj(path, options),
    }
}

/// Reads a scene file and all files that it names.
///
/// # Errors
/// The first fault, see [`IoError`]. [`IoError::EmptyScene`] where nothing would be drawn.
pub fn load_scene(path: &Path, options: &LoadOptions) -> Result<Scene, IoError> {
    let (scene, _) = read_scene(path, options, false)?;
    let bare = scene.effects.volumes.is_empty() && scene.effects.background.is_none();
    if bare && scene.meshes.iter().all(|m| m.triangles.is_empty()) {
        return Err(IoError::EmptyScene {
            path: path.to_path_buf(),
        });
    }
    Ok(scene)
}

/// Reads an OBJ model by itself: the camera shows its bounding sphere from the front, right and above, the light is
/// [`auto_lights`]; faces without a material are light grey.
///
/// # Errors
/// The first fault, see [`IoError`]. [`IoError::EmptyMesh`] where nothing would be drawn.
pub fn load_obj(path: &Path, options: &LoadOptions) -> Result<Scene, IoError> {
    Ok(read_obj(path, options, false)?.0)
}

pub(crate) enum Kind {
    Scene,
    Obj,
}

pub(crate) fn kind(path: &Path, files: &FileSource) -> Result<Kind, IoError> {
    match path.extension().and_then(|e| e.to_str()) {
        Some(e) if e.eq_ignore_ascii_case("scene") => Ok(Kind::Scene),
        Some(e) if e.eq_ignore_ascii_case("obj") => Ok(Kind::Obj),
        // A name that does not exist is that, whatever its ending.
        _ => files.check(path, None).and(Err(IoError::UnknownFormat {
            path: path.to_path_buf(),
        })),
    }
}

/// `tolerant`: faults of named files are noted in the textures' list and do not stop.
pub(crate) fn read_scene(
    path: &Path,
    options: &LoadOptions,
    tolerant: bool,
) -> Result<(Scene, Textures), IoError> {
    let tree = Tree::read(path, &options.files)?;
    let color = options.color.unwrap_or(tree.color_mode());
    let textures = Textures::new(options.files.clone(), color == ColorMode::Raw, tolerant);
    let settings = Settings {
        missing: options.missing,
        ..Settings::default()
    };
    let mut builder = Builder::new(empty_scene(color), textures, settings);
    builder.file(&tree)?;
    builder.finish()
}

pub(crate) fn read_obj(
    path: &Path,
    options: &LoadOptions,
    tolerant: bool,
) -> Result<(Scene, Textures), IoError> {
    let color = options.color.unwrap_or_default();
    let mut textures = Textures::new(options.files.clone(), color == ColorMode::Raw, tolerant);
    let model = obj::read(path, None, options.missing, false, &mut textures)?;
    let matte = PhongMaterial {
        color: [0.8; 3],
        ka: 1.0,
        kd: 1.0,
        ks: 0.0,
        ns: 5.0,
    };
    let settings = Settings {
        missing: options.missing,
        surf: Some(matte),
        ..Settings::default()
    };
    let mut builder = Builder::new(empty_scene(color), textures, settings);
    let stem = path
        .file_stem()
        .map_or_else(String::new, |s| s.to_string_lossy().into_owned());
    builder.model(model, &stem, &SourceLocation::new(path, 1, 1));
    let (mut scene, textures) = builder.finish()?;
    // Neither black nor white: dark and light parts stand out.
    scene.background = [0.22, 0.24, 0.27, 1.0];
    if let Some(bounds) = Bounds::of(&scene) {
        scene.camera = bounds.camera(View::Iso, AUTO_FOV, options.aspect);
    }
    scene.lights = auto_lights();
    Ok((scene, textures))
}

/// The defaults of the course loader; near and far as texmap's depth buffer allows.
fn empty_scene(color: ColorMode) -> Scene {
    Scene {
        color,
        depth_test: DepthTest::LessOrEqual,
        ..Scene::new(Camera {
            eye: DVec3::new(0.0, 0.0, -10.0),
            look: DVec3::ZERO,
            up: DVec3::Y,
            fov_x: 30_f64.to_radians(),
            near: 1e-4,
            far: f64::INFINITY,
        })
    }
}

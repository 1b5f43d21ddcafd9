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

use crate::files::is_called;
use crate::framing::{AUTO_FOV, Bounds, View, auto_lights};
use crate::models::{self, Request};
use crate::scene_file::Missing;
use crate::textures::Textures;
use crate::{FileSource, IoError, SourceLocation};
use build::Builder;
use settings::Settings;

pub(crate) use table::nearest;
pub use table::{SECTIONS, Section, Spec, commands};
pub(crate) use tree::Tree;

/// What the files do not say.
#[derive(Debug, Clone, PartialEq)]
pub struct LoadOptions {
    /// What a missing map or material library is; `missing` lines of a scene overrule it.
    pub missing: Missing,
    /// Width / height of the picture that an automatic camera has to fill.
    pub aspect: f64,
    /// Whether colours are converted, instead of what the scene says (a model: that they are).
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

/// A kind of file that holds a scene or a model.
pub(crate) struct Format {
    /// Its name in reports, and the ending of its names.
    pub(crate) name: &'static str,
    /// Whether it may hold lights; a model without them gets [`auto_lights`].
    pub(crate) has_lights: bool,
    pub(crate) read: Read,
}

/// Reads a file; `tolerant`: faults of named files are noted in the textures' list and do not stop.
type Read = fn(&Path, &LoadOptions, tolerant: bool) -> Result<(Scene, Textures), IoError>;

/// Every kind of file that [`load`] reads, in the order in which messages name them.
pub(crate) const FORMATS: [Format; 4] = [
    Format {
        name: "scene",
        has_lights: true,
        read: read_scene,
    },
    model("obj"),
    model("ply"),
    model("stl"),
];

const fn model(name: &'static str) -> Format {
    Format {
        name,
        has_lights: false,
        read: read_model,
    }
}

/// The kind of file that the ending of a name says, in capitals or not.
pub(crate) fn format(path: &Path, files: &FileSource) -> Result<&'static Format, IoError> {
    let found = FORMATS.iter().find(|format| is_called(path, format.name));
    match found {
        Some(format) => Ok(format),
        // A name that does not exist is that, whatever its ending.
        None => files.check(path, None).and(Err(IoError::UnknownFormat {
            path: path.to_path_buf(),
        })),
    }
}

/// Reads a `.scene` file, or a model: `.obj`, `.ply` or `.stl`.
///
/// # Errors
/// Whatever is wrong with it or with a file it names, see [`IoError`]; [`IoError::UnknownFormat`] for other names.
pub fn load(path: &Path, options: &LoadOptions) -> Result<Scene, IoError> {
    let format = format(path, &options.files)?;
    let (scene, _) = (format.read)(path, options, false)?;
    drawable(scene, path)
}

/// Reads a scene file and all files that it names.
///
/// # Errors
/// The first fault, see [`IoError`]. [`IoError::EmptyScene`] where nothing would be drawn.
pub fn load_scene(path: &Path, options: &LoadOptions) -> Result<Scene, IoError> {
    let (scene, _) = read_scene(path, options, false)?;
    drawable(scene, path)
}

/// Refuses a scene in which nothing would be drawn.
fn drawable(scene: Scene, path: &Path) -> Result<Scene, IoError> {
    let bare = scene.effects.volumes.is_empty() && scene.effects.background.is_none();
    if bare && scene.meshes.iter().all(|m| m.triangles.is_empty()) {
        return Err(IoError::EmptyScene {
            path: path.to_path_buf(),
        });
    }
    Ok(scene)
}

/// Reads a model by itself, an OBJ where its ending does not say PLY or STL: the camera shows its bounding sphere from the front, right
/// and above, the light is [`auto_lights`]; faces without a material are light grey.
///
/// # Errors
/// The first fault, see [`IoError`]. [`IoError::EmptyMesh`] where nothing would be drawn.
pub fn load_model(path: &Path, options: &LoadOptions) -> Result<Scene, IoError> {
    Ok(read_model(path, options, false)?.0)
}

fn read_scene(
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

fn read_model(
    path: &Path,
    options: &LoadOptions,
    tolerant: bool,
) -> Result<(Scene, Textures), IoError> {
    let color = options.color.unwrap_or_default();
    let mut textures = Textures::new(options.files.clone(), color == ColorMode::Raw, tolerant);
    let request = Request {
        path,
        named_by: None,
        missing: options.missing,
        textured: false,
    };
    let model = models::read(&request, &mut textures)?;
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

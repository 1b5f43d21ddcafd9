//! Files to scenes.

mod build;
mod coarse;
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
use texmap_scene::{BlendOrder, ColorMode, Scene};

use crate::files::is_called;
use crate::framing::{Framing, auto_lights};
use crate::info::{self, Contents};
use crate::models::{self, Request};
use crate::scene_file::Missing;
use crate::textures::Textures;
use crate::{FileSource, IoError, SourceLocation, gltf};
use build::Builder;
use settings::Settings;

pub use table::{SECTIONS, Section, Spec, commands};
pub(crate) use table::{command, nearest};
pub(crate) use tree::Tree;

/// Options of loading that are not in the files.
#[derive(Debug, Clone, PartialEq)]
pub struct LoadOptions {
    /// Treatment of missing maps and material libraries, whatever a scene says. `None`: an error unless a `missing` line says otherwise.
    pub missing: Option<Missing>,
    /// Width / height of the picture that an automatic camera has to fill.
    pub aspect: f64,
    /// The camera of a model that brings none.
    pub framing: Framing,
    /// Conversion of colours, instead of that of the scene (models: [`ColorMode::Srgb`]).
    pub color: Option<ColorMode>,
    /// Source of all files, also of the one that is loaded. From [`FileSource::anywhere`] a glTF model reads nothing outside of its own
    /// folder.
    pub files: FileSource,
    /// The camera of a glTF model that is taken, by its name or its number from 0; `None`: one that shows the whole model.
    pub camera: Option<String>,
    /// Seconds into an animation of a glTF model; `None`: at rest.
    pub time: Option<f64>,
    /// The animation, by its name or its number from 0; `None`: the first.
    pub animation: Option<String>,
}

impl Default for LoadOptions {
    /// Missing files are errors; pictures of 16 : 9; colours as the scene says; files from anywhere.
    fn default() -> Self {
        Self {
            missing: None,
            aspect: 16.0 / 9.0,
            framing: Framing::default(),
            color: None,
            files: FileSource::anywhere(),
            camera: None,
            time: None,
            animation: None,
        }
    }
}

/// A kind of file that holds a scene or a model.
pub(crate) struct Format {
    /// The ending of its names.
    pub(crate) name: &'static str,
    /// Its name in reports.
    pub(crate) kind: &'static str,
    pub(crate) read: Read,
}

/// Reads a file; `tolerant`: faults of named files are noted in the contents' list and do not stop.
type Read = fn(&Path, &LoadOptions, tolerant: bool) -> Result<(Scene, Contents), IoError>;

/// Every kind of file that [`load`] reads, in the order in which messages name them.
pub(crate) const FORMATS: [Format; 6] = [
    Format {
        name: "scene",
        kind: "scene",
        read: |path, options, tolerant| {
            let (scene, textures) = read_scene(path, options, tolerant)?;
            let lights = scene.lights.len();
            Ok((scene, info::contents(textures, lights)))
        },
    },
    model("obj"),
    gltf("gltf"),
    gltf("glb"),
    model("ply"),
    model("stl"),
];

const fn model(name: &'static str) -> Format {
    Format {
        name,
        kind: name,
        read: |path, options, tolerant| {
            let (scene, textures) = read_model(path, options, tolerant)?;
            Ok((scene, info::contents(textures, 0)))
        },
    }
}

const fn gltf(name: &'static str) -> Format {
    Format {
        name,
        kind: "gltf",
        read: gltf::read,
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

/// Reads a `.scene` file, or a model: `.obj`, `.gltf`, `.glb`, `.ply` or `.stl`.
///
/// # Errors
/// Any fault of the file or of a file that it names, see [`IoError`]; [`IoError::UnknownFormat`] for other names.
pub fn load(path: &Path, options: &LoadOptions) -> Result<Scene, IoError> {
    let format = format(path, &options.files)?;
    if format.kind != "gltf" {
        for (of, asked) in [
            ("camera", &options.camera),
            ("animation", &options.animation),
        ] {
            if let Some(name) = asked.clone() {
                return Err(IoError::UnknownName {
                    path: path.to_path_buf(),
                    of,
                    name,
                    known: String::new(),
                });
            }
        }
    }
    let (mut scene, _) = (format.read)(path, options, false)?;
    if options.time.is_some() && format.kind != "gltf" {
        let warning = "the file has no animation: every time shows the same";
        scene.warnings.push(warning.into());
    }
    drawable(scene, path)
}

/// Reads one file from memory, called `name`, whose ending tells its kind. Files that it names are not there; see
/// [`FileSource::in_memory`] for models of several files.
///
/// # Errors
/// As [`load`].
pub fn load_bytes(name: &Path, bytes: Vec<u8>, options: &LoadOptions) -> Result<Scene, IoError> {
    let files = FileSource::in_memory([(name.to_path_buf(), bytes)]);
    let files = files.with_memory(options.files.memory());
    load(
        name,
        &LoadOptions {
            files,
            ..options.clone()
        },
    )
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

/// Reads a model by itself, an OBJ where its ending does not say glTF, PLY or STL: the camera is that of [`LoadOptions::framing`], the light
/// is [`auto_lights`] unless it brings lights; faces without a material are light grey. `docs/GLTF.md` lists the parts of a glTF that are read.
///
/// # Errors
/// The first fault, see [`IoError`]. [`IoError::EmptyMesh`] where nothing would be drawn.
pub fn load_model(path: &Path, options: &LoadOptions) -> Result<Scene, IoError> {
    let models = FORMATS.iter().filter(|format| format.kind != "scene");
    let format = models
        .into_iter()
        .find(|format| is_called(path, format.name));
    Ok((format.unwrap_or(&model("obj")).read)(path, options, false)?.0)
}

fn read_scene(
    path: &Path,
    options: &LoadOptions,
    tolerant: bool,
) -> Result<(Scene, Textures), IoError> {
    let tree = Tree::read(path, &options.files)?;
    let color = options.color.unwrap_or(tree.color_mode());
    let mut textures = Textures::new(options.files.clone(), color == ColorMode::Raw, tolerant);
    textures.missing = options.missing;
    textures.classic = true;
    let settings = Settings {
        missing: options.missing.unwrap_or_default(),
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
    let missing = options.missing.unwrap_or_default();
    let request = Request {
        path,
        named_by: None,
        missing,
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
        missing,
        matte: Some(matte),
        ..Settings::default()
    };
    let mut builder = Builder::new(empty_scene(color), textures, settings);
    let stem = path
        .file_stem()
        .map_or_else(String::new, |s| s.to_string_lossy().into_owned());
    builder.model(model, &stem, &SourceLocation::new(path, 1, 1));
    let (mut scene, textures) = builder.finish()?;
    present(&mut scene, options);
    let warning = coarse::coarse(&scene);
    scene.warnings.extend(warning);
    Ok((scene, textures))
}

/// Gives a model that stands alone a background, a camera and lights.
pub(crate) fn present(scene: &mut Scene, options: &LoadOptions) {
    scene.blend_order = BlendOrder::FarthestFirst;
    // Neither black nor white: dark and light parts stand out.
    scene.background = [0.22, 0.24, 0.27, 1.0];
    if let Some(camera) = options.framing.camera(scene, options.aspect) {
        scene.camera = camera;
    }
    scene.lights = auto_lights(options.framing.up);
}

/// The defaults of the course loader; near and far as texmap's depth buffer allows.
pub(crate) fn empty_scene(color: ColorMode) -> Scene {
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
            lens: Default::default(),
        })
    }
}

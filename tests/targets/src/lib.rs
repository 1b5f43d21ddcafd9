//! One list of hashes for every machine: random scenes with every effect, the scenes, models and pictures of `assets`, arrays
//! beside the colour, and the functions that are called without a scene.
//!
//! `tests/golden/targets.txt` holds the list. The suite `frame` holds every SIMD level of this machine against it, `.ci/targets` the
//! builds for other machines. `TEXMAP_BLESS=1 cargo test --workspace --test frame targets` rewrites it.
#![forbid(unsafe_code)]

pub mod effects;
mod kernels;
pub mod random;
pub mod scenes;

use std::error::Error;
use std::fmt::Write as _;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use texmap_mesh::tessellate;

pub use effects::Folders;
use texmap_io::framing::{Up, light_as_model};
use texmap_io::{IoError, LoadOptions, image_io, load, read_environment, write_environment};
use texmap_light::{Environment, EnvironmentLayout};
use texmap_math::Level;
use texmap_render::{Aov, AovData, Frame, RenderSettings, hash_pixels, pixel_hash, render};
use texmap_scene::Scene;

/// Random scenes of every effect.
pub const EFFECT_SCENES: u64 = 60;

/// Random scenes of samplers and alpha.
const SAMPLER_SCENES: u64 = 16;

/// The list, a line for each picture: its name, the hash of its pixels or values, and that of all its AOVs if it has some. Of the
/// random scenes of effects it has each `step`-th, from the first on: all with 1.
///
/// # Errors
/// A scene or a picture that is refused, a file that cannot be written.
pub fn hashes(
    folders: &Folders,
    level: Level,
    step: NonZeroUsize,
) -> Result<String, Box<dyn Error>> {
    let mut list = String::new();
    write_skies(folders)?;
    effects::shared(folders)?;
    decoded(folders, &mut list)?;
    for (name, hash) in kernels::results(level) {
        writeln!(list, "{name} {}", digits(&hash))?;
    }
    for seed in 0..SAMPLER_SCENES {
        let frame = render(
            &random::scene(seed),
            &RenderSettings {
                level,
                ..random::settings(seed)
            },
            &texmap_render::no_progress,
        )?;
        writeln!(list, "{}", line(&format!("samplers-{seed:02}"), &frame))?;
    }
    for seed in (0..EFFECT_SCENES).step_by(step.get()) {
        let name = format!("effects-{seed:02}");
        let frame = effect_scene(seed, folders)
            .and_then(|scene| {
                let settings = effect_settings(seed, &scene, level);
                let scene = tessellate(scene, settings.width)?;
                Ok(render(&scene, &settings, &texmap_render::no_progress)?)
            })
            .map_err(|error| format!("{name}: {error}"))?;
        writeln!(list, "{}", line(&name, &frame))?;
    }
    for path in files(&folders.assets.join("scenes"), &["scene"])? {
        let scene = load(&path, &LoadOptions::default())?;
        writeln!(list, "{}", drawn(scene, &name_of(&path), level)?)?;
    }
    for path in files(&folders.assets.join("gltf"), &["glb", "gltf"])? {
        let mut scene = load(&path, &LoadOptions::default())?;
        light_as_model(&mut scene, Up::Y);
        writeln!(list, "{}", drawn(scene.clone(), &name_of(&path), level)?)?;
        scene.effects.environment_shadows = 9;
        let name = format!("{}-shadowed", name_of(&path));
        writeln!(list, "{}", drawn(scene, &name, level)?)?;
    }
    Ok(list)
}

/// The line of a scene, with every array.
fn drawn(scene: Scene, name: &str, level: Level) -> Result<String, Box<dyn Error>> {
    let settings = RenderSettings {
        level,
        aovs: Aov::ALL.to_vec(),
        ..RenderSettings::new(160, 120)
    };
    let scene = tessellate(scene, settings.width)?;
    let frame = render(&scene, &settings, &texmap_render::no_progress)?;
    Ok(line(name, &frame))
}

/// The random scene of a seed, by way of its file.
///
/// # Errors
/// Every fault that the reader finds.
pub fn effect_scene(seed: u64, folders: &Folders) -> Result<Scene, Box<dyn Error>> {
    let path = folders.work.join(format!("effects-{seed:02}.scene"));
    std::fs::write(&path, effects::text(seed, folders))?;
    Ok(load(&path, &LoadOptions::default())?)
}

fn effect_settings(seed: u64, scene: &Scene, level: Level) -> RenderSettings {
    let shadowed = |light: &usize| scene.effects.shadows.iter().any(|s| s.light == *light);
    let lights = (0..scene.lights.len()).filter(shadowed);
    RenderSettings {
        level,
        aovs: Aov::ALL
            .into_iter()
            .chain(lights.map(|i| Aov::Shadow(i as u8)))
            .collect(),
        msaa: if seed % 4 == 1 { 4 } else { 1 },
        supersample: if seed % 4 == 3 { 2 } else { 1 },
        ..RenderSettings::new(97, 67)
    }
}

/// Environments in every chart, as HDR and EXR. Both encoders are part of the proof, since what they write is read again.
fn write_skies(folders: &Folders) -> Result<(), Box<dyn Error>> {
    let sky = read_environment(
        &folders.data.join("half_piz.exr"),
        EnvironmentLayout::LatLong,
    )?;
    let write = |name: &str, sky: &Environment| write_environment(&folders.work.join(name), sky);
    write("sky.hdr", &sky)?;
    for (name, chart, size) in [
        ("cube.hdr", EnvironmentLayout::Cube, 16),
        ("tan.exr", EnvironmentLayout::TanCube, 16),
        ("octahedron.exr", EnvironmentLayout::Octahedron, 24),
        ("equal.exr", EnvironmentLayout::EqualAreaOctahedron, 24),
        ("paraboloid.hdr", EnvironmentLayout::DualParaboloid, 20),
        ("ball.hdr", EnvironmentLayout::SphereMap, 24),
    ] {
        write(name, &sky.convert(chart, size)?)?;
    }
    Ok(())
}

/// Hashes of the decoded pictures.
fn decoded(folders: &Folders, list: &mut String) -> Result<(), Box<dyn Error>> {
    let textures = files(&folders.assets.join("textures"), &["png", "gif", "jpg"])?;
    for path in textures.into_iter().chain(files(&folders.data, &["jpg"])?) {
        // Depths and their names are the reader's affair.
        let image = format!("{:?}", image_io::read_image(&path)?);
        let hash = hash_pixels(image.len() as u32, 1, image.as_bytes());
        writeln!(list, "{} {}", name_of(&path), digits(&hash))?;
    }
    let written = ["sky.hdr"].map(|name| folders.work.join(name));
    for path in files(&folders.data, &["exr"])?.into_iter().chain(written) {
        let sky = read_environment(&path, EnvironmentLayout::LatLong)?;
        let (width, height) = sky.size();
        let texels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        let texels = texels.filter_map(|(x, y)| sky.texel(0, x, y)).flatten();
        let hash = kernels::hash_floats(&mut texels.into_iter());
        writeln!(list, "{} {}", name_of(&path), digits(&hash))?;
    }
    Ok(())
}

fn line(name: &str, frame: &Frame) -> String {
    let mut aovs = Vec::new();
    for (_, _, data) in &frame.aovs {
        match data {
            AovData::F32(values) => {
                aovs.extend(values.iter().flat_map(|v| v.to_bits().to_le_bytes()));
            }
            AovData::U32(values) => aovs.extend(values.iter().flat_map(|v| v.to_le_bytes())),
        }
    }
    let aovs = hash_pixels(frame.width, frame.height, &aovs);
    format!("{name} {} {}", digits(&pixel_hash(frame)), digits(&aovs))
}

fn digits(hash: &str) -> &str {
    hash.rsplit(':').next().unwrap_or(hash)
}

fn name_of(path: &Path) -> String {
    path.file_name()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned()
}

/// The files with one of these endings, in the order of their names.
fn files(folder: &Path, endings: &[&str]) -> Result<Vec<PathBuf>, IoError> {
    let read = |source| IoError::Read {
        path: folder.to_path_buf(),
        named_by: None,
        source,
    };
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(read)? {
        let path = entry.map_err(read)?.path();
        if path
            .extension()
            .is_some_and(|e| endings.iter().any(|ending| e == *ending))
        {
            files.push(path);
        }
    }
    files.sort();
    Ok(files)
}

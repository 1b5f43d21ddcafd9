//! glTF 2.0 models: `.gltf` with its files, and `.glb`.

mod accessor;
mod animation;
mod cameras;
mod container;
mod coverage;
mod extensions;
mod geometry;
mod images;
mod json;
mod json_materials;
mod layers;
mod lights;
mod materials;
mod meshes;
mod meshopt;
mod model;
mod nodes;
mod phong;
mod pointer;
mod slots;
mod topology;
mod uri;

use std::path::Path;

use texmap_scene::{ColorMode, Scene};

use crate::info::{AnimationInfo, Contents};
use crate::scene::{LoadOptions, empty_scene, present};
use crate::{IoError, shortened};
use animation::Pose;
use model::Model;
use nodes::{Tree, Trs};

/// Reads a model as a scene of its own. `tolerant`: files that it names in vain are noted and do not stop.
pub(crate) fn read(
    path: &Path,
    options: &LoadOptions,
    tolerant: bool,
) -> Result<(Scene, Contents), IoError> {
    let mut model = Model::read(path, options.files.clone(), tolerant)?;
    let pose = pose(&mut model, options)?;
    let tree = Tree::new(&model, &places(&model, &pose))?;
    let mut uses = images::Uses::default();
    let mut described = materials::materials(&mut model, &mut uses)?;
    let meshes = meshes::meshes(&mut model, &tree, &pose, &mut described)?;
    if meshes.is_empty() && !tolerant {
        return Err(IoError::EmptyMesh {
            path: path.to_path_buf(),
            named_by: None,
        });
    }
    let color = options.color.unwrap_or_default();
    let mut scene = empty_scene(color);
    scene.textures = images::textures(
        &mut model,
        &uses,
        options.missing.unwrap_or_default(),
        color == ColorMode::Raw,
    )?;
    scene.materials = described.into_iter().map(|d| d.material).collect();
    phong::refine(&mut scene.materials, &scene.textures);
    scene.meshes = meshes;
    coverage::keep_coverage(&mut scene, options.files.memory());
    present(&mut scene, options);
    let lights = lights::lights(&mut model, &tree)?;
    let contents_lights = lights.len();
    lights::illuminate(&mut scene, lights, options.framing.up);
    let placed = cameras::cameras(&model, &tree)?;
    if let Some(wanted) = &options.camera {
        scene.camera = cameras::camera(&mut model, &tree, &placed, wanted, options.aspect)?;
    }
    let scenes = model.document.scenes.len();
    if scenes > 1 {
        let drawn = model.document.scene.unwrap_or(0);
        model.warn(format!(
            "the file has {scenes} scenes; scene {drawn} is drawn"
        ));
    }
    scene.warnings = std::mem::take(&mut model.warnings);
    let contents = Contents {
        cameras: cameras::report(&model, &placed),
        animations: animations(&model),
        extensions: extensions::report(&model.document),
        lights: contents_lights,
        files: model.named,
    };
    Ok((scene, contents))
}

/// The pose at the time that is asked for; at rest without one.
fn pose(model: &mut Model<'_>, options: &LoadOptions) -> Result<Pose, IoError> {
    if options.time.is_none() && options.animation.is_none() {
        return Ok(Pose::default());
    }
    let names: Vec<&str> = model
        .document
        .animations
        .iter()
        .map(|a| a.name.as_str())
        .collect();
    let index = match &options.animation {
        Some(wanted) => model.chosen("animation", wanted, &names)?,
        None if names.is_empty() => {
            model.warn("the model has no animation: every time shows the same");
            return Ok(Pose::default());
        }
        None => 0,
    };
    let time = options.time.unwrap_or(0.0);
    let pose = animation::pose(model, index, time)?;
    if pose.ignored > 0 {
        let ignored = pose.ignored;
        model.warn(format!("/animations/{index}: {ignored} channels move neither nodes nor weights, or nodes with a matrix; they are left out"));
    }
    Ok(pose)
}

/// The matrices of all nodes within their parents.
fn places(model: &Model<'_>, pose: &Pose) -> Vec<texmap_math::glam::DMat4> {
    let nodes = model.document.nodes.iter();
    let mut places: Vec<_> = nodes
        .map(|node| match &node.matrix {
            Some(matrix) => texmap_math::glam::DMat4::from_cols_array(matrix),
            None => Trs::of(node).matrix(),
        })
        .collect();
    for (node, trs) in &pose.places {
        places[*node] = trs.matrix();
    }
    places
}

fn animations(model: &Model<'_>) -> Vec<AnimationInfo> {
    let line = |(i, animation): (usize, &json::Animation)| AnimationInfo {
        name: shortened(&animation.name).to_string(),
        seconds: animation::seconds(model, i),
        channels: animation.channels.len(),
    };
    model
        .document
        .animations
        .iter()
        .enumerate()
        .map(line)
        .collect()
}

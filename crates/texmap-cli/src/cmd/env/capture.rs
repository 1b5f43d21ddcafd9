//! The environment of a point of a scene.

use std::path::Path;

use texmap_bake::{capture_environment_at, center_of};
use texmap_io::{FileSource, LoadOptions, load};
use texmap_light::Environment;
use texmap_math::glam::DVec3;
use texmap_scene::Scene;

use super::EnvArgs;
use crate::failure::{Failure, say};

/// Texels a side of a face where none are asked for.
const SIZE: u32 = 256;

/// The scene seen from the point that the flags name, as a cube, and the words that tell the point.
pub(super) fn captured(
    args: &EnvArgs,
    scene: &Path,
    files: &FileSource,
) -> Result<(Environment, String), Failure> {
    let options = LoadOptions {
        files: files.clone(),
        ..LoadOptions::default()
    };
    let scene = load(scene, &options)?;
    let size = args.size.unwrap_or(SIZE);
    let scene = texmap_mesh::tessellate(&scene, size).map_err(refused)?;
    for warning in &scene.warnings {
        say(&format!("warning: {warning}\n"));
    }
    let (point, hidden) = match (&args.at, &args.object) {
        (Some(at), _) => (DVec3::from(at.0), Vec::new()),
        (None, Some(name)) => {
            let meshes = named(&scene, name)?;
            (center_of(&scene, &meshes).map_err(refused)?, meshes)
        }
        (None, None) => {
            return Err(Failure::usage(
                "--from-scene needs a point",
                "add --at X,Y,Z, or --object NAME for the middle of an object",
            ));
        }
    };
    let seen = capture_environment_at(&scene, point, &hidden, size).map_err(refused)?;
    let [x, y, z] = point.to_array().map(|c| c as f32);
    Ok((seen, format!("{x} {y} {z}")))
}

/// The meshes of a name: those called so, or the parts of a model of that name.
fn named(scene: &Scene, name: &str) -> Result<Vec<usize>, Failure> {
    let part = format!("{name}.");
    let all = scene.meshes.iter().enumerate();
    let found: Vec<usize> = all
        .filter(|(_, mesh)| mesh.name == name || mesh.name.starts_with(&part))
        .map(|(index, _)| index)
        .collect();
    if found.is_empty() {
        let mut names: Vec<&str> = scene.meshes.iter().map(|m| m.name.as_str()).collect();
        names.dedup();
        return Err(Failure::usage(
            format!("--object {name}: no mesh of this name"),
            format!("choose from {}", names.join(", ")),
        ));
    }
    Ok(found)
}

fn refused(error: impl Into<crate::failure::Refusal>) -> Failure {
    Failure::of_render(error, None, "correct the scene, or choose another point")
}

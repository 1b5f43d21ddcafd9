//! The surfaces and the light of a model whose file says little about either, as `texmap render` draws it.

use texmap_scene::{ColorMode, MetallicRoughness, Scene, Shading};

use super::{Up, auto_lights, light_by_studio};

/// Gives every material the metallic-roughness model that has none. Raw colours are no light: leave their scenes as they are.
pub fn metallic_surfaces(scene: &mut Scene) {
    for material in &mut scene.materials {
        if material.metallic_roughness.is_none() {
            material.metallic_roughness = Some(MetallicRoughness::of_classic(material));
        }
    }
}

/// Lights a model by the studio where its surfaces show it, or where it is seen `behind` them. Lights that the file brought
/// stay, and an environment does.
pub fn light_model(scene: &mut Scene, up: Up, behind: bool) {
    let wanted = reads_environment(scene) || behind;
    if wanted && scene.color == ColorMode::Srgb && scene.effects.environment_light.is_none() {
        let brought = std::mem::take(&mut scene.lights);
        light_by_studio(scene, up);
        // Those of the loader stand in for light from all around.
        if brought != auto_lights(up) {
            scene.lights = brought;
        }
    }
}

/// True if some surface shows the light of an environment.
#[must_use]
pub fn reads_environment(scene: &Scene) -> bool {
    let mut materials = scene.materials.iter();
    materials.any(|m| m.metallic_roughness.is_some() && m.shading == Shading::PerPixel)
}

/// True if some surface is dark without lights.
#[must_use]
pub fn needs_lights(scene: &Scene) -> bool {
    let around = scene.effects.environment_light.is_some();
    let mut drawn = scene
        .meshes
        .iter()
        .filter_map(|mesh| scene.materials.get(mesh.material));
    drawn.any(|m| match m.shading {
        Shading::Unlit => false,
        Shading::PerVertex => true,
        Shading::PerPixel => m.metallic_roughness.is_none() || !around,
    })
}

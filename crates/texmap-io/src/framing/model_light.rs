//! The surfaces and the light of a model whose file says little about either, as `texmap render` draws it.

use texmap_scene::{ColorMode, MetallicRoughness, Scene, Shading};

use super::{Up, auto_lights, dim_bright_lights, light_by_studio};

/// Shades and lights a loaded model as `texmap render` does without flags: its surfaces are metallic-roughness under the neutral studio,
/// unless it brings light of its own; lights of the loader, which stand in for light from all around, go, and lights in lumens are
/// dimmed ([`dim_bright_lights`]). In raw colours surfaces stay as they are.
pub fn light_as_model(scene: &mut Scene, up: Up) {
    if scene.color == ColorMode::Srgb {
        metallic_surfaces(scene);
    }
    light_model(scene, up, false);
    dim_bright_lights(scene);
    light_dark_surfaces(scene, up);
}

/// Adds automatic lights where there are none and some surface is dark without: a model is never dark for want of light.
pub fn light_dark_surfaces(scene: &mut Scene, up: Up) {
    if scene.lights.is_empty() && needs_lights(scene) {
        scene.lights = auto_lights(up);
    }
}

/// Gives every material the metallic-roughness model that has none, with a warning on maps that this model does not draw. Raw colours are
/// no light: leave their scenes as they are.
pub fn metallic_surfaces(scene: &mut Scene) {
    let mut lost = 0;
    for material in &mut scene.materials {
        if material.metallic_roughness.is_none() {
            let maps = &material.maps;
            lost += usize::from(maps.ambient.is_some() || maps.exponent.is_some());
            material.metallic_roughness = Some(MetallicRoughness::of_classic(material));
        }
    }
    if lost > 0 {
        let materials = match lost {
            1 => "1 material has".to_owned(),
            _ => format!("{lost} materials have"),
        };
        scene.warnings.push(format!(
            "{materials} maps of ambient colours or exponents (`map_Ka`, `map_Ns`), which metallic-roughness does not draw; --shading classic does"
        ));
    }
}

/// Lights a model by the studio where its surfaces show it, or where it is seen `behind` them. Lights that the file brought
/// stay, and an environment does.
pub fn light_model(scene: &mut Scene, up: Up, behind: bool) {
    let wanted = scene.reads_environment() || behind;
    if wanted && scene.color == ColorMode::Srgb && scene.effects.environment_light.is_none() {
        let brought = std::mem::take(&mut scene.lights);
        light_by_studio(scene, up);
        // Those of the loader stand in for light from all around.
        if brought != auto_lights(up) {
            scene.lights = brought;
        }
    }
}

/// True if some surface is dark without lights.
#[must_use]
fn needs_lights(scene: &Scene) -> bool {
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

#[cfg(test)]
mod tests {
    use super::*;
    use texmap_math::Camera;
    use texmap_scene::{Material, Mesh};

    #[test]
    fn models_are_lit_by_the_studio_and_raw_ones_by_lights() {
        let mut model = Scene::new(Camera::look_at([0.0, 0.0, 3.0], [0.0; 3]));
        model.materials = vec![Material::default()];
        model.meshes = vec![Mesh::cube()];
        model.lights = auto_lights(Up::Y);
        let mut lit = model.clone();
        light_as_model(&mut lit, Up::Y);
        assert!(lit.lights.is_empty() && lit.effects.environment_light.is_some());
        assert!(lit.materials[0].metallic_roughness.is_some() && lit.warnings.is_empty());
        model.materials[0].maps.exponent = Some(texmap_scene::TextureSlot::new(0));
        let mut lost = model.clone();
        light_as_model(&mut lost, Up::Y);
        assert!(
            lost.warnings[0].contains("1 material has maps"),
            "{:?}",
            lost.warnings
        );
        model.color = ColorMode::Raw;
        model.lights.clear();
        light_as_model(&mut model, Up::Y);
        assert!(model.effects.environment_light.is_none());
        assert_eq!(model.lights, auto_lights(Up::Y));
    }
}

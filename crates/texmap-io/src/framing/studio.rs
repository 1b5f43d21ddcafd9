//! The light around a model that is drawn as metallic-roughness.

use std::sync::OnceLock;

use texmap_light::{EnvironmentLight, ToneMap};
use texmap_scene::{ColorMode, Material, MetallicRoughness, Scene, Shading};

use super::{Up, auto_lights};

/// The neutral studio, upright along an axis.
#[must_use]
pub fn studio(up: Up) -> EnvironmentLight {
    // Made once: it takes longer than many a model.
    static STUDIO: OnceLock<EnvironmentLight> = OnceLock::new();
    let studio = STUDIO.get_or_init(EnvironmentLight::studio).clone();
    match up {
        Up::Y => studio,
        Up::Z => studio.upright_on_z(),
    }
}

/// Lights a scene by the neutral studio alone, under PBR Neutral.
pub fn light_by_studio(scene: &mut Scene, up: Up) {
    scene.effects.environment_light = Some(studio(up));
    scene.effects.tone_mapping.map = ToneMap::PbrNeutral;
    scene.lights.clear();
}

/// Shades and lights a loaded model as `texmap render` does without flags: its surfaces are metallic-roughness under the neutral studio,
/// unless it brings light of its own; lights of the loader, which stand in for light from all around, go. In raw colours it
/// stays as it is.
pub fn light_as_model(scene: &mut Scene, up: Up) {
    if scene.color == ColorMode::Srgb {
        for material in &mut scene.materials {
            if material.metallic_roughness.is_none() {
                material.metallic_roughness = Some(MetallicRoughness::of_classic(material));
            }
        }
    }
    let around = |m: &Material| m.metallic_roughness.is_some() && m.shading == Shading::PerPixel;
    if scene.materials.iter().any(around) && scene.effects.environment_light.is_none() {
        let brought = std::mem::take(&mut scene.lights);
        light_by_studio(scene, up);
        if brought != auto_lights(up) {
            scene.lights = brought;
        }
    }
    // A model is never dark for want of light.
    let studio = scene.effects.environment_light.is_some();
    let dark = |m: &Material| match m.shading {
        Shading::Unlit => false,
        Shading::PerVertex => true,
        Shading::PerPixel => m.metallic_roughness.is_none() || !studio,
    };
    let mut drawn = scene
        .meshes
        .iter()
        .filter_map(|mesh| scene.materials.get(mesh.material));
    if scene.lights.is_empty() && drawn.any(dark) {
        scene.lights = auto_lights(up);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use texmap_math::Camera;
    use texmap_scene::Mesh;

    #[test]
    fn models_are_lit_by_the_studio_and_raw_ones_by_lights() {
        let mut model = Scene::new(Camera::look_at([0.0, 0.0, 3.0], [0.0; 3]));
        model.materials = vec![Material::default()];
        model.meshes = vec![Mesh::cube()];
        model.lights = auto_lights(Up::Y);
        let mut lit = model.clone();
        light_as_model(&mut lit, Up::Y);
        assert!(lit.lights.is_empty() && lit.effects.environment_light.is_some());
        assert!(lit.materials[0].metallic_roughness.is_some());
        model.color = ColorMode::Raw;
        model.lights.clear();
        light_as_model(&mut model, Up::Y);
        assert!(model.effects.environment_light.is_none());
        assert_eq!(model.lights, auto_lights(Up::Y));
    }

    #[test]
    fn the_studio_stands_on_the_axis_that_points_up() {
        let (y, z) = (studio(Up::Y), studio(Up::Z));
        for d in [[0.3, 0.9, -0.2], [-0.7, 0.1, 0.6], [0.0, -1.0, 0.1]] {
            let [a, b, c] = d;
            assert_eq!(y.irradiance(d), z.irradiance([a, -c, b]));
            assert_eq!(y.radiance(0.3, d), z.radiance(0.3, [a, -c, b]));
            assert_ne!(y.irradiance(d), z.irradiance(d));
        }
    }
}

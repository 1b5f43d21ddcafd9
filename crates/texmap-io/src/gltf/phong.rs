//! Phong's model instead of metallic-roughness, for renderings that know the older model only.

use texmap_light::PhongMaterial;
use texmap_sample::Texture2d;
use texmap_scene::{Material, MetallicRoughness};

/// Numbers of Phong's model for the mean of a metallic-roughness surface: highlights as wide as its lobe and about as strong, and less
/// diffuse light from metals, which stay visible without an environment to mirror.
pub(super) fn phong(
    color: [f32; 3],
    model: &MetallicRoughness,
    map: Option<&Texture2d<'_>>,
) -> PhongMaterial {
    let [_, green, blue] = map.map_or([1.0; 3], mean);
    let (metallic, roughness) = (model.metallic * blue, (model.roughness * green).max(0.1));
    let width = roughness * roughness;
    // The exponent of Blinn's lobe whose second moment is that of GGX (Walter et al. 2007, for Beckmann).
    let exponent = (2.0 / (width * width) - 2.0).clamp(1.0, 512.0);
    let bright = color.iter().copied().fold(0.0, f32::max);
    let head_on = 0.04 * model.specular * (1.0 - metallic) + bright * metallic;
    PhongMaterial {
        color,
        ka: 1.0,
        kd: 1.0 - 0.4 * metallic,
        ks: (head_on * (exponent + 8.0) / 8.0).min(0.6),
        ns: exponent,
    }
}

/// The mean texel.
fn mean(texture: &Texture2d<'_>) -> [f32; 3] {
    let smallest = texture.levels() - 1;
    let [r, g, b, _] = texture.texel(smallest, 0, 0).unwrap_or([1.0; 4]);
    [r, g, b]
}

/// Refines the numbers of Phong's model by the loaded textures.
pub(super) fn refine(materials: &mut [Material], textures: &[Texture2d<'static>]) {
    for material in materials {
        let Some(model) = &material.metallic_roughness else {
            continue;
        };
        if let Some(map) = &model.map {
            material.phong = phong(material.phong.color, model, textures.get(map.texture));
        }
    }
}

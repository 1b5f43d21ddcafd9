//! The metallic-roughness model of a material: core, specular reflection, coat, sheen.

use texmap_math::deterministic_f64;
use texmap_scene::{Clearcoat, MetallicRoughness, Sheen, Transmission};

use super::images::Use;
use super::json;
use super::materials::Reader;
use crate::IoError;

/// The numbers of the model without its textures.
pub(super) fn metallic_roughness(stated: &json::Material) -> MetallicRoughness {
    let pbr = &stated.pbr_metallic_roughness;
    let unit = |x: f64| x.clamp(0.0, 1.0) as f32;
    let ior = match stated.extensions.ior.as_ref().map_or(1.5, |e| e.ior) {
        // By its extension 0 stands for a surface that mirrors everything.
        0.0 => 1e6,
        ior => ior.clamp(1.0, 1e6) as f32,
    };
    MetallicRoughness {
        metallic: unit(pbr.metallic_factor),
        roughness: unit(pbr.roughness_factor),
        ior,
        ..MetallicRoughness::default()
    }
}

/// Metallic-roughness with its textures and layers.
pub(super) fn lit(
    reader: &mut Reader<'_, '_>,
    stated: &json::Material,
) -> Result<MetallicRoughness, IoError> {
    let pbr = &stated.pbr_metallic_roughness;
    let extensions = &stated.extensions;
    let mut model = metallic_roughness(stated);
    if let Some(old) = &extensions.glossiness {
        let specular = reader.units(
            old.specular_factor,
            "extensions/KHR_materials_pbrSpecularGlossiness/specularFactor",
        );
        if old.specular_glossiness_texture.is_some() {
            let at = &reader.at;
            reader.model.warn(format!(
                "{at}: its map of specular colour and glossiness is left out"
            ));
        }
        model.metallic = 0.0;
        model.roughness = 1.0
            - reader.unit(
                old.glossiness_factor,
                "extensions/KHR_materials_pbrSpecularGlossiness/glossinessFactor",
            );
        // As a factor of the four hundredths that a dielectric of index 1.5 reflects.
        model.specular_color = specular.map(|c| c / 0.04);
    } else {
        reader.unit(pbr.metallic_factor, "pbrMetallicRoughness/metallicFactor");
        reader.unit(pbr.roughness_factor, "pbrMetallicRoughness/roughnessFactor");
        let map = pbr.metallic_roughness_texture.as_ref();
        model.map = reader.slot(
            map,
            Use::OpaqueData,
            "pbrMetallicRoughness/metallicRoughnessTexture",
        )?;
    }
    if let Some(info) = &stated.occlusion_texture {
        let strength = reader.unit(info.strength, "occlusionTexture/strength");
        let slot = reader.slot(Some(info), Use::OpaqueData, "occlusionTexture")?;
        model.occlusion = slot.map(|slot| (slot, strength));
    }
    if let Some(specular) = &extensions.specular {
        let key = |key: &str| format!("extensions/KHR_materials_specular/{key}");
        model.specular = reader.unit(specular.specular_factor, &key("specularFactor"));
        model.specular_color = specular
            .specular_color_factor
            .map(|c| c.clamp(0.0, 1e6) as f32);
        let map = specular.specular_texture.as_ref();
        model.specular_map = reader.slot(map, Use::Data, &key("specularTexture"))?;
        let map = specular.specular_color_texture.as_ref();
        model.specular_color_map =
            reader.slot(map, Use::OpaqueColor, &key("specularColorTexture"))?;
    }
    if let Some(coat) = &extensions.clearcoat {
        let key = |key: &str| format!("extensions/KHR_materials_clearcoat/{key}");
        if coat.clearcoat_normal_texture.is_some() {
            reader.model.warn(format!(
                "{}/{}: the coat is drawn with the normals of the surface",
                reader.at,
                key("clearcoatNormalTexture")
            ));
        }
        let map = coat.clearcoat_texture.as_ref();
        let rough = coat.clearcoat_roughness_texture.as_ref();
        model.clearcoat = Some(Clearcoat {
            factor: reader.unit(coat.clearcoat_factor, &key("clearcoatFactor")),
            map: reader.slot(map, Use::OpaqueData, &key("clearcoatTexture"))?,
            roughness: reader.unit(
                coat.clearcoat_roughness_factor,
                &key("clearcoatRoughnessFactor"),
            ),
            roughness_map: reader.slot(
                rough,
                Use::OpaqueData,
                &key("clearcoatRoughnessTexture"),
            )?,
        })
        .filter(|coat| coat.factor > 0.0);
    }
    if let Some(sheen) = &extensions.sheen {
        let key = |key: &str| format!("extensions/KHR_materials_sheen/{key}");
        let map = sheen.sheen_color_texture.as_ref();
        let rough = sheen.sheen_roughness_texture.as_ref();
        model.sheen = Some(Sheen {
            color: reader.units(sheen.sheen_color_factor, &key("sheenColorFactor")),
            color_map: reader.slot(map, Use::OpaqueColor, &key("sheenColorTexture"))?,
            roughness: reader.unit(sheen.sheen_roughness_factor, &key("sheenRoughnessFactor")),
            roughness_map: reader.slot(rough, Use::Data, &key("sheenRoughnessTexture"))?,
        })
        .filter(|sheen| sheen.color != [0.0; 3]);
    }
    if let Some(sheet) = &extensions.transmission {
        let key = |key: &str| format!("extensions/KHR_materials_transmission/{key}");
        let map = sheet.transmission_texture.as_ref();
        model.transmission = Some(Transmission {
            factor: reader.unit(sheet.transmission_factor, &key("transmissionFactor")),
            map: reader.slot(map, Use::OpaqueData, &key("transmissionTexture"))?,
        })
        .filter(|sheet| sheet.factor > 0.0 && model.metallic < 1.0);
    }
    Ok(model)
}

/// The colour of the inside of a material as that of its surface: light has gone the stated thickness (Beer and Lambert's law).
pub(super) fn attenuation(stated: &json::Material, model: &MetallicRoughness) -> [f32; 3] {
    let (Some(volume), Some(sheet)) = (&stated.extensions.volume, &model.transmission) else {
        return [1.0; 3];
    };
    let way = match volume.attenuation_distance {
        Some(distance) if distance > 0.0 => volume.thickness_factor.max(0.0) / distance,
        _ => return [1.0; 3],
    };
    volume.attenuation_color.map(|color| {
        let passing = deterministic_f64::pow(color.clamp(0.0, 1.0), way) as f32;
        1.0 + (passing - 1.0) * sheet.factor
    })
}

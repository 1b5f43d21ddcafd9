//! Materials of a document: metallic-roughness, and the numbers of Phong's model that look most like it.

use texmap_light::{NormalMapGreen, SpecularModel};
use texmap_raster::Cull;
use texmap_scene::{
    AlphaMode, Emission, Material, NormalDetail, Shading, TextureSlot, VertexColorInterp,
};

use super::images::{Use, Uses};
use super::json::{self, TextureInfo};
use super::layers::{attenuation, lit, metallic_roughness};
use super::model::Model;
use super::phong::phong;
use super::slots::{Sets, slot};
use crate::{IoError, shortened};

/// A material, and the coordinates that its textures read.
#[derive(Debug)]
pub(super) struct Described {
    pub(super) material: Material,
    pub(super) sets: Sets,
}

/// The material of primitives that name none.
pub(super) fn standard() -> Described {
    let standard = json::Material::default();
    let model = metallic_roughness(&standard);
    Described {
        material: Material {
            name: "default".into(),
            phong: phong([1.0; 3], &model, None),
            metallic_roughness: Some(model),
            cull: Cull::Back,
            specular_model: SpecularModel::Blinn,
            vertex_color_interp: VertexColorInterp::Perspective,
            ..Material::default()
        },
        sets: Sets::of(&[]),
    }
}

/// Reads all materials; their textures get their indices from `uses`.
pub(super) fn materials(model: &mut Model<'_>, uses: &mut Uses) -> Result<Vec<Described>, IoError> {
    // Taken out for a while: reading it adds warnings to the model.
    let stated = std::mem::take(&mut model.document.materials);
    let read = stated
        .iter()
        .enumerate()
        .map(|(i, m)| material(model, uses, i, m))
        .collect();
    model.document.materials = stated;
    read
}

/// Reads the slots of one material.
pub(super) struct Reader<'r, 'm> {
    pub(super) model: &'r mut Model<'m>,
    uses: &'r mut Uses,
    sets: Sets,
    pub(super) at: String,
}

impl Reader<'_, '_> {
    pub(super) fn slot(
        &mut self,
        info: Option<&TextureInfo>,
        used: Use,
        key: &str,
    ) -> Result<Option<TextureSlot>, IoError> {
        let Some(info) = info else { return Ok(None) };
        slot(
            self.model,
            self.uses,
            info,
            self.sets,
            used,
            &format!("{}/{key}", self.at),
        )
    }

    /// A factor clamped to 0 to 1, with a warning if it is beyond.
    pub(super) fn unit(&mut self, value: f64, key: &str) -> f32 {
        if !(0.0..=1.0).contains(&value) {
            self.model.warn(format!(
                "{}/{key}: {value} is not within 0 to 1 and was cut",
                self.at
            ));
        }
        value.clamp(0.0, 1.0) as f32
    }

    pub(super) fn units<const N: usize>(&mut self, values: [f64; N], key: &str) -> [f32; N] {
        values.map(|value| self.unit(value, key))
    }
}

fn material(
    model: &mut Model<'_>,
    uses: &mut Uses,
    index: usize,
    stated: &json::Material,
) -> Result<Described, IoError> {
    let sets = Sets::of(&infos(stated));
    let at = format!("/materials/{index}");
    if let Some(third) = sets.third {
        model.warn(format!(
            "{at} reads more than two sets of coordinates: TEXCOORD_{third} is read as TEXCOORD_{}",
            sets.first
        ));
    }
    let mut reader = Reader {
        model,
        uses,
        sets,
        at,
    };
    let extensions = &stated.extensions;
    let (alpha, cutoff) = alpha(&reader, stated)?;
    let has_alpha = alpha != AlphaMode::Opaque;
    let used = if has_alpha {
        Use::Color
    } else {
        Use::OpaqueColor
    };
    let (factor, texture, key) = match &extensions.glossiness {
        Some(old) => (
            old.diffuse_factor,
            old.diffuse_texture.as_ref(),
            "extensions/KHR_materials_pbrSpecularGlossiness/diffuse",
        ),
        None => {
            let pbr = &stated.pbr_metallic_roughness;
            (
                pbr.base_color_factor,
                pbr.base_color_texture.as_ref(),
                "pbrMetallicRoughness/baseColor",
            )
        }
    };
    let base_color = reader.slot(texture, used, &format!("{key}Texture"))?;
    let [r, g, b, a] = reader.units(factor, &format!("{key}Factor"));
    let unlit = extensions.unlit.is_some();
    let (model_of_light, normal_detail) = if unlit {
        (None, None)
    } else {
        (
            Some(lit(&mut reader, stated)?),
            normal_map(&mut reader, stated)?,
        )
    };
    let emission = emission(&mut reader, stated, unlit)?;
    let name = match stated.name.as_str() {
        "" => format!("material {index}"),
        name => shortened(name).to_string(),
    };
    // Nothing reaches a cutoff above 1; a material that ignores alpha needs no test.
    let hidden = cutoff > 1.0;
    if hidden {
        reader.model.warn(format!(
            "{}/alphaCutoff: {cutoff} hides the whole surface",
            reader.at
        ));
    }
    let described = model_of_light.clone().unwrap_or_default();
    let inside = attenuation(stated, &described);
    // Light passes surfaces that are blended.
    let alpha = match alpha {
        AlphaMode::Opaque if described.transmission.is_some() => AlphaMode::Blend,
        alpha => alpha,
    };
    Ok(Described {
        material: Material {
            name,
            phong: phong(
                [r * inside[0], g * inside[1], b * inside[2]],
                &described,
                None,
            ),
            metallic_roughness: model_of_light,
            opacity: match (hidden, has_alpha) {
                (true, _) => 0.0,
                (_, true) => a,
                (_, false) => 1.0,
            },
            base_color: base_color.filter(|_| !hidden),
            shading: if unlit {
                Shading::Unlit
            } else {
                Shading::PerPixel
            },
            alpha,
            cull: if stated.double_sided {
                Cull::None
            } else {
                Cull::Back
            },
            specular_model: SpecularModel::Blinn,
            vertex_color_interp: VertexColorInterp::Perspective,
            emission,
            normal_detail,
            ..Material::default()
        },
        sets,
    })
}

/// Every reference to a texture that is read.
fn infos(stated: &json::Material) -> Vec<&TextureInfo> {
    let extensions = &stated.extensions;
    let pbr = &stated.pbr_metallic_roughness;
    let own = match &extensions.glossiness {
        Some(old) => [old.diffuse_texture.as_ref(), None],
        None => [
            pbr.base_color_texture.as_ref(),
            pbr.metallic_roughness_texture.as_ref(),
        ],
    };
    let lit = [
        stated.normal_texture.as_ref(),
        stated.occlusion_texture.as_ref(),
    ];
    let specular = extensions.specular.as_ref();
    let specular = specular.map(|s| {
        [
            s.specular_texture.as_ref(),
            s.specular_color_texture.as_ref(),
        ]
    });
    let coat = extensions.clearcoat.as_ref();
    let coat = coat.map(|c| {
        [
            c.clearcoat_texture.as_ref(),
            c.clearcoat_roughness_texture.as_ref(),
        ]
    });
    let sheen = extensions.sheen.as_ref();
    let sheen = sheen.map(|s| {
        [
            s.sheen_color_texture.as_ref(),
            s.sheen_roughness_texture.as_ref(),
        ]
    });
    let transmission = extensions.transmission.as_ref();
    let transmission = transmission.map(|t| [t.transmission_texture.as_ref(), None]);
    let layers = [specular, coat, sheen, transmission];
    let layers = layers.into_iter().flatten().flatten();
    let first = own[0].into_iter();
    if extensions.unlit.is_some() {
        return first.collect();
    }
    let rest = lit
        .into_iter()
        .chain([own[1], stated.emissive_texture.as_ref()])
        .chain(layers);
    first.chain(rest.flatten()).collect()
}

/// The alpha mode and the stated cutoff.
fn alpha(reader: &Reader<'_, '_>, stated: &json::Material) -> Result<(AlphaMode, f64), IoError> {
    let cutoff = stated.alpha_cutoff.unwrap_or(0.5);
    Ok(match stated.alpha_mode.as_deref() {
        None | Some("OPAQUE") => (AlphaMode::Opaque, 0.0),
        Some("BLEND") => (AlphaMode::Blend, 0.0),
        Some("MASK") if cutoff > 0.0 => (AlphaMode::Test(cutoff.min(1.0) as f32), cutoff),
        Some("MASK") => (AlphaMode::Opaque, 0.0),
        Some(other) => {
            let problem = format!("`{}` is none of OPAQUE, MASK, BLEND", shortened(other));
            return Err(reader
                .model
                .broken(&format!("{}/alphaMode", reader.at), problem));
        }
    })
}

fn emission(
    reader: &mut Reader<'_, '_>,
    stated: &json::Material,
    unlit: bool,
) -> Result<Option<Emission>, IoError> {
    let strength = stated
        .extensions
        .emissive_strength
        .as_ref()
        .map_or(1.0, |e| e.emissive_strength);
    let color = reader
        .units(stated.emissive_factor, "emissiveFactor")
        .map(|c| c * strength.max(0.0) as f32);
    let bright = color.iter().all(|c| c.is_finite());
    if unlit || !bright || color == [0.0; 3] {
        return Ok(None);
    }
    let map = reader.slot(
        stated.emissive_texture.as_ref(),
        Use::OpaqueColor,
        "emissiveTexture",
    )?;
    Ok(Some(Emission { color, map }))
}

fn normal_map(
    reader: &mut Reader<'_, '_>,
    stated: &json::Material,
) -> Result<Option<NormalDetail>, IoError> {
    let Some(info) = &stated.normal_texture else {
        return Ok(None);
    };
    let slot = reader.slot(Some(info), Use::OpaqueData, "normalTexture")?;
    Ok(slot.map(|slot| NormalDetail::NormalMap {
        slot,
        green: NormalMapGreen::Up,
        rebuild_z: false,
        object_space: false,
        strength: info.scale as f32,
    }))
}

//! Models to meshes under the current settings.

use texmap_light::PhongMaterial;
use texmap_sample::Origin;
use texmap_scene::{
    AlphaMode, Clearcoat, Displacement, Emission, Material, Mesh, MetallicRoughness, Sheen,
    TextureRole,
};

use super::Builder;
use crate::models::{self, Request};
use crate::obj::{self, Model};
use crate::scene::effects::Coordinates;
use crate::scene::second_uvs::second_uvs;
use crate::scene::settings::{emitted, light};
use crate::{IoError, SourceLocation, shortened};

impl Builder {
    pub(in crate::scene) fn obj(
        &mut self,
        name: &str,
        location: &SourceLocation,
    ) -> Result<(), IoError> {
        let path = self.textures.source.beside(&location.file, name);
        let textured = self.settings.texture.is_some() || self.settings.effects.reads_uv();
        let request = Request {
            path: &path,
            named_by: Some(location),
            missing: self.settings.missing,
            textured,
        };
        match models::read(&request, &mut self.textures) {
            Ok(model) => {
                let stem = path
                    .file_stem()
                    .map_or_else(String::new, |s| s.to_string_lossy().into_owned());
                let first = self.scene.meshes.len();
                self.model(model, &stem, location);
                match &self.settings.effects.lightmap_uv {
                    None => Ok(()),
                    Some((path, named)) => second_uvs(
                        &mut self.scene.meshes[first..],
                        &mut self.textures,
                        path,
                        named,
                    ),
                }
            }
            Err(
                error @ (IoError::FileMissing { .. }
                | IoError::NotAFile { .. }
                | IoError::OutsideRoot { .. }),
            ) if self.textures.tolerant => {
                self.textures.note(&path, location, Err(error.to_string()));
                Ok(())
            }
            Err(error) => Err(error),
        }
    }

    /// Adds the parts of a model under the current settings.
    pub(in crate::scene) fn model(&mut self, model: Model, stem: &str, named_by: &SourceLocation) {
        let color = self.scene.color;
        self.scene.warnings.extend(model.warnings);
        let transform = self.settings.transform;
        for part in model.parts {
            let described = part.material.and_then(|i| model.materials.get(i));
            let displacement = described
                .and_then(|m| self.described_displacement(m))
                .or_else(|| self.settings.displacement(color))
                .filter(|_| !part.uvs.is_empty());
            let material = match described {
                Some(described) => self.described(described),
                None => match &self.settings.texture {
                    Some(texture) => self
                        .settings
                        .textured(texture, TextureRole::Modulate, color),
                    None if model.colored => self.settings.colored(color),
                    None => self.settings.plain(color),
                },
            };
            let coordinates = Coordinates {
                first: !part.uvs.is_empty() || self.settings.round.is_some(),
                second: self.settings.effects.lightmap_uv.is_some(),
            };
            let material = self.material(material, coordinates, named_by);
            let colors = if model.colored {
                part.colors
            } else {
                Vec::new()
            };
            let mesh = Mesh {
                // Names are for people and messages.
                name: shortened(match part.name.as_str() {
                    obj::UNNAMED => stem,
                    name => name,
                })
                .to_string(),
                positions: part.positions,
                normals: part.normals,
                uvs: part.uvs,
                colors: colors.into_iter().map(|c| light(c, color)).collect(),
                triangles: part.triangles,
                faces: part.faces,
                material,
                world_from_object: transform,
                // A shape speaks of the picture's top.
                uv_origin: match self.settings.round {
                    Some(_) => Origin::TopLeft,
                    None => Origin::BottomLeft,
                },
                uv_projection: self.settings.round,
                displacement,
                ..Mesh::default()
            };
            self.bones
                .follow(self.scene.meshes.len(), self.settings.skin.clone());
            self.scene.meshes.push(mesh);
        }
    }

    /// The displacement of an MTL `disp` line.
    fn described_displacement(&self, m: &obj::Material) -> Option<Displacement> {
        let (map, height) = m.displacement.as_ref()?;
        let slot = self
            .settings
            .slot(map.texture, map.transform, map.clamp, self.scene.color);
        Some(Displacement::new(slot, *height))
    }

    /// A material of an MTL library under the current settings.
    fn described(&self, m: &obj::Material) -> Material {
        let (now, color) = (&self.settings, self.scene.color);
        let slot = |map: &obj::Map| now.slot(map.texture, map.transform, map.clamp, color);
        let map_alpha = m
            .map_kd
            .as_ref()
            .is_some_and(|map| self.textures.textures[map.texture].has_alpha());
        let alpha = match now.alpha {
            None if m.opacity < 1.0 => AlphaMode::Blend,
            _ => now.alpha(map_alpha || m.map_d.is_some()),
        };
        let phong = PhongMaterial {
            color: light(m.kd, color),
            ka: 1.0,
            kd: 1.0,
            ks: m.ks,
            ns: m.ns,
        };
        Material {
            metallic_roughness: m.pbr.as_ref().map(|pbr| metallic(pbr, &phong, slot)),
            maps: texmap_scene::SurfaceMaps {
                ambient: m.map_ka.as_ref().map(slot),
                specular: m.map_ks.as_ref().map(slot),
                exponent: m.map_ns.as_ref().map(slot),
                reflectivity: None,
            },
            emission: (m.ke != [0.0; 3]).then(|| Emission {
                color: emitted(m.ke, color),
                map: m.map_ke.as_ref().map(slot),
            }),
            normal_detail: m.relief.as_ref().map(|(map, relief)| match *relief {
                obj::ReliefKind::Bump(height) => texmap_scene::NormalDetail::Bump {
                    slot: slot(map),
                    height,
                },
                obj::ReliefKind::Normals => texmap_scene::NormalDetail::NormalMap {
                    slot: slot(map),
                    green: texmap_light::NormalMapGreen::Up,
                    rebuild_z: false,
                    object_space: false,
                    strength: 1.0,
                },
            }),
            name: shortened(&m.name).to_string(),
            phong,
            opacity: m.opacity,
            base_color: m.map_kd.as_ref().map(slot),
            opacity_map: m.map_d.as_ref().map(slot),
            texture_role: now.role.unwrap_or(TextureRole::Modulate),
            alpha,
            ..now.plain(color)
        }
    }
}

/// The metallic-roughness model of a material that speaks of it: its reflection is that of index 1.5 whatever `Ks` says.
fn metallic(
    pbr: &obj::Pbr,
    phong: &PhongMaterial,
    slot: impl Fn(&obj::Map) -> texmap_scene::TextureSlot,
) -> MetallicRoughness {
    let of_exponent = || {
        let classic = Material {
            phong: *phong,
            ..Material::default()
        };
        MetallicRoughness::of_classic(&classic).roughness
    };
    MetallicRoughness {
        roughness: pbr.roughness.unwrap_or_else(of_exponent),
        metallic: pbr.metallic,
        map: pbr.map.as_ref().map(&slot),
        clearcoat: (pbr.coat > 0.0).then(|| Clearcoat {
            factor: pbr.coat,
            map: pbr.coat_map.as_ref().map(&slot),
            roughness: pbr.coat_roughness,
            roughness_map: pbr.coat_roughness_map.as_ref().map(&slot),
        }),
        sheen: (pbr.sheen > 0.0).then(|| Sheen {
            color: [pbr.sheen; 3],
            color_map: pbr.sheen_map.as_ref().map(&slot),
            roughness: SHEEN_ROUGHNESS,
            roughness_map: None,
        }),
        ..MetallicRoughness::default()
    }
}

/// The roughness of fibres, of which MTL does not speak: that of Blender's surfaces.
const SHEEN_ROUGHNESS: f32 = 0.5;

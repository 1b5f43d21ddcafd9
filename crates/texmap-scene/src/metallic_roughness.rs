//! The metallic-roughness model of a surface (glTF 2.0, appendix B) with its extensions, as data.

use texmap_light::Roughnesses;

use crate::{Material, TextureSlot};

/// Reflectance by metalness and roughness: a GGX lobe over a diffuse base, both lit by lights and by the environment light of
/// the scene. The base colour is that of the material.
#[derive(Clone, Debug, PartialEq)]
pub struct MetallicRoughness {
    /// 0 (dielectric) to 1 (metal).
    pub metallic: f32,
    /// Perceptual roughness, 0 (mirror) to 1; the GGX width is its square.
    pub roughness: f32,
    /// Multiplies both: roughness by green, metalness by blue. Data, not sRGB.
    pub map: Option<TextureSlot>,
    /// Fraction of the environment's light that reaches a point (red channel), and weight of the map, 0 to 1. Data.
    pub occlusion: Option<(TextureSlot, f32)>,
    /// Index of refraction of a dielectric, at least 1; it reflects `((ior - 1) / (ior + 1))^2` head on.
    pub ior: f32,
    /// Strength of the dielectric's reflection, 0 to 1 (`KHR_materials_specular`).
    pub specular: f32,
    /// Multiplies the strength by its alpha. Data.
    pub specular_map: Option<TextureSlot>,
    /// Colour of the dielectric's reflection head on, linear, not negative.
    pub specular_color: [f32; 3],
    /// Multiplies that colour.
    pub specular_color_map: Option<TextureSlot>,
    /// Light that passes the dielectric base; drawn where the material's [`AlphaMode`](crate::AlphaMode) is `Blend`.
    pub transmission: Option<Transmission>,
    /// A clear layer over everything.
    pub clearcoat: Option<Clearcoat>,
    /// Back-scattering fibres of cloth.
    pub sheen: Option<Sheen>,
}

impl Default for MetallicRoughness {
    /// A rough dielectric of index 1.5.
    fn default() -> Self {
        Self {
            metallic: 0.0,
            roughness: 1.0,
            map: None,
            occlusion: None,
            ior: 1.5,
            specular: 1.0,
            specular_map: None,
            specular_color: [1.0; 3],
            specular_color_map: None,
            transmission: None,
            clearcoat: None,
            sheen: None,
        }
    }
}

/// A thin sheet of glass (`KHR_materials_transmission`).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Transmission {
    /// Fraction of the base's light that passes instead of being scattered, 0 to 1.
    pub factor: f32,
    /// Multiplies the fraction by its red channel. Data.
    pub map: Option<TextureSlot>,
}

/// A clear layer of index 1.5 (`KHR_materials_clearcoat`).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Clearcoat {
    /// Strength, 0 to 1.
    pub factor: f32,
    /// Multiplies the strength by its red channel. Data.
    pub map: Option<TextureSlot>,
    /// Perceptual roughness, 0 to 1.
    pub roughness: f32,
    /// Multiplies the roughness by its green channel. Data.
    pub roughness_map: Option<TextureSlot>,
}

/// Cloth (`KHR_materials_sheen`).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sheen {
    /// Colour of the fibres, linear, 0 to 1.
    pub color: [f32; 3],
    /// Multiplies the colour.
    pub color_map: Option<TextureSlot>,
    /// Perceptual roughness of the fibres, 0 to 1.
    pub roughness: f32,
    /// Multiplies the roughness by its alpha. Data.
    pub roughness_map: Option<TextureSlot>,
}

impl MetallicRoughness {
    /// A dielectric with highlights about as wide as those of Phong's model: the roughness is `sqrt(2 / (ns + 2))`, the mean slope of
    /// a Blinn lobe (Walter and others 2007), `ks` is the strength of the reflection, at most 1, and the map of highlights its colour.
    /// The map of exponents has no counterpart.
    #[must_use]
    pub fn of_classic(material: &Material) -> Self {
        let phong = &material.phong;
        Self {
            roughness: (2.0 / (phong.ns + 2.0)).sqrt().min(1.0),
            specular: phong.ks.min(1.0),
            specular_color_map: material.maps.specular.clone(),
            ..Self::default()
        }
    }

    /// Every texture that the model names.
    pub fn slots(&self) -> impl Iterator<Item = &TextureSlot> {
        let coat = self
            .clearcoat
            .iter()
            .flat_map(|c| [&c.map, &c.roughness_map]);
        let sheen = self
            .sheen
            .iter()
            .flat_map(|s| [&s.color_map, &s.roughness_map]);
        let transmission = self.transmission.iter().map(|t| &t.map);
        [&self.map, &self.specular_map, &self.specular_color_map]
            .into_iter()
            .chain(transmission)
            .chain(coat)
            .chain(sheen)
            .flatten()
            .chain(self.occlusion.iter().map(|(slot, _)| slot))
    }

    /// Every texture that the model names, to change.
    pub fn slots_mut(&mut self) -> impl Iterator<Item = &mut TextureSlot> {
        let coat = self.clearcoat.iter_mut();
        let coat = coat.flat_map(|c| [&mut c.map, &mut c.roughness_map]);
        let sheen = self.sheen.iter_mut();
        let sheen = sheen.flat_map(|s| [&mut s.color_map, &mut s.roughness_map]);
        let transmission = self.transmission.iter_mut().map(|t| &mut t.map);
        [
            &mut self.map,
            &mut self.specular_map,
            &mut self.specular_color_map,
        ]
        .into_iter()
        .chain(transmission)
        .chain(coat)
        .chain(sheen)
        .flatten()
        .chain(self.occlusion.iter_mut().map(|(slot, _)| slot))
    }

    /// The roughnesses at which it reflects an environment: those of its lobes and its clear layer's, all where there is a map. A matte
    /// base, whose reflection has no strength, has none.
    #[must_use]
    pub fn roughnesses(&self) -> Roughnesses {
        let of = |map: &Option<TextureSlot>, without: Roughnesses| match map {
            // Filters with negative weights leave the range of a map.
            Some(_) => Roughnesses::ALL,
            None => without,
        };
        let base = match self.metallic == 0.0 && self.specular == 0.0 {
            true => Roughnesses::NONE,
            false => of(&self.map, Roughnesses::of_surface(self.roughness)),
        };
        let coat = self.clearcoat.as_ref().map(|coat| {
            let own = Roughnesses::between(coat.roughness, coat.roughness);
            of(&coat.roughness_map, own)
        });
        base | coat.unwrap_or_default()
    }

    /// True if every number is finite and within its range.
    #[must_use]
    pub fn is_valid(&self) -> bool {
        let unit = |x: &f32| (0.0..=1.0).contains(x);
        let strength = self
            .occlusion
            .as_ref()
            .map_or(1.0, |(_, strength)| *strength);
        let coat = self.clearcoat.iter().flat_map(|c| [c.factor, c.roughness]);
        let sheen = self.sheen.iter();
        let sheen = sheen.flat_map(|s| s.color.into_iter().chain([s.roughness]));
        let transmission = self.transmission.iter().map(|t| t.factor);
        [self.metallic, self.roughness, self.specular, strength]
            .into_iter()
            .chain(transmission)
            .chain(coat)
            .chain(sheen)
            .all(|x| unit(&x))
            && (1.0..=1e6).contains(&self.ior)
            && self
                .specular_color
                .iter()
                .all(|x| x.is_finite() && *x >= 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use texmap_light::PhongMaterial;

    #[test]
    fn slots_are_those_of_every_layer() {
        let slot = |texture| Some(TextureSlot::new(texture));
        let all = MetallicRoughness {
            map: slot(0),
            occlusion: Some((TextureSlot::new(1), 0.5)),
            specular_map: slot(2),
            specular_color_map: slot(3),
            clearcoat: Some(Clearcoat {
                map: slot(4),
                roughness_map: slot(5),
                ..Clearcoat::default()
            }),
            sheen: Some(Sheen {
                color_map: slot(6),
                roughness_map: slot(7),
                ..Sheen::default()
            }),
            transmission: Some(Transmission {
                factor: 1.0,
                map: slot(8),
            }),
            ..MetallicRoughness::default()
        };
        let mut textures: Vec<usize> = all.slots().map(|slot| slot.texture).collect();
        textures.sort_unstable();
        assert_eq!(textures, [0, 1, 2, 3, 4, 5, 6, 7, 8]);
        assert_eq!(MetallicRoughness::default().slots().count(), 0);
    }

    #[test]
    fn shiny_surfaces_are_smooth() {
        let of = |ns, ks| {
            MetallicRoughness::of_classic(&Material {
                phong: PhongMaterial {
                    ns,
                    ks,
                    ..PhongMaterial::default()
                },
                ..Material::default()
            })
        };
        assert!((of(6.0, 0.5).roughness - 0.5).abs() < 1e-6 && of(0.0, 0.0).roughness == 1.0);
        assert!(of(198.0, 3.0).roughness < 0.11 && of(198.0, 3.0).specular == 1.0);
        assert!(of(1e9, 0.0).is_valid() && of(0.0, 1e9).is_valid());
    }

    #[test]
    fn surfaces_need_the_levels_of_their_lobes_alone() {
        let matte = MetallicRoughness {
            specular: 0.0,
            ..MetallicRoughness::default()
        };
        assert_eq!(matte.roughnesses(), Roughnesses::NONE);
        let metal = MetallicRoughness {
            metallic: 0.5,
            ..matte.clone()
        };
        assert_eq!(metal.roughnesses(), Roughnesses::of_surface(1.0));
        let coated = MetallicRoughness {
            clearcoat: Some(Clearcoat::default()),
            ..matte
        };
        assert_eq!(coated.roughnesses(), Roughnesses::between(0.0, 0.0));
        let mapped = MetallicRoughness {
            map: Some(TextureSlot::new(0)),
            ..MetallicRoughness::default()
        };
        assert_eq!(mapped.roughnesses(), Roughnesses::ALL);
    }

    #[test]
    fn ranges_are_checked() {
        let standard = MetallicRoughness::default();
        assert!(standard.is_valid());
        for broken in [
            MetallicRoughness {
                roughness: 1.5,
                ..standard.clone()
            },
            MetallicRoughness {
                metallic: f32::NAN,
                ..standard.clone()
            },
            MetallicRoughness {
                ior: 0.5,
                ..standard.clone()
            },
            MetallicRoughness {
                specular_color: [-1.0, 0.0, 0.0],
                ..standard.clone()
            },
            MetallicRoughness {
                occlusion: Some((TextureSlot::new(0), 2.0)),
                ..standard.clone()
            },
        ] {
            assert!(!broken.is_valid(), "{broken:?}");
        }
    }
}

//! A light that moves over baked surfaces: maps hold what rests, and only the light that moves is baked again.

use texmap_light::{Light, ShadowMap};
use texmap_render::{RenderError, shadow_map_for};
use texmap_sample::{Alpha, ColorSpace, Image, Origin, TexelData, Texture2d};
use texmap_scene::{Scene, SceneError, shadow_bias, shadow_kind};

use crate::{BakeOptions, Baker};

/// The light maps of a scene without the light that moves (Abrash 1997, "Graphics Programming Black Book", chapter 68: structure times light,
/// with what rests and what moves in maps of their own).
///
/// Light maps of the scene's materials must hold the resting lights alone; those that share a texture get the sum of the light on all their
/// meshes. Surfaces without a light map are lit by the moved light as by any other.
#[derive(Debug)]
pub struct MovingLight {
    light: usize,
    /// Texture, the texels of its level 0 and its levels.
    resting: Vec<Resting>,
    shadow_size: u32,
    pcf_size: u32,
    gutter: u32,
}

#[derive(Debug)]
struct Resting {
    texture: usize,
    size: u32,
    texels: Vec<[f32; 3]>,
    mips: bool,
    /// Meshes with this map, and the factor of its texels.
    meshes: Vec<(usize, f32)>,
}

impl MovingLight {
    /// Remembers the resting light of the maps of a scene. `light` is the index of the one that moves; its shadow maps have `shadow_size`
    /// texels a side (0: no shadows) and `pcf_size` comparisons a side, its islands are dilated by `gutter` texels.
    ///
    /// # Errors
    /// [`SceneError::Index`] for a light that does not exist; [`SceneError::Value`] for a light map that is not square or whose scale is 0.
    pub fn new(
        scene: &Scene,
        light: usize,
        shadow_size: u32,
        pcf_size: u32,
        gutter: u32,
    ) -> Result<Self, RenderError> {
        if light >= scene.lights.len() {
            return Err(SceneError::Index {
                place: "moving light".to_owned(),
                what: "light",
                index: light as u64,
                count: scene.lights.len(),
            }
            .into());
        }
        let mut resting: Vec<Resting> = Vec::new();
        for (index, mesh) in scene.meshes.iter().enumerate() {
            let material = scene.materials.get(mesh.material);
            let Some(map) = material.and_then(|m| m.light_map.as_ref()) else {
                continue;
            };
            let known = resting.iter_mut().find(|r| r.texture == map.slot.texture);
            if let Some(known) = known {
                known.meshes.push((index, map.scale));
                continue;
            }
            let Some(texture) = scene.textures.get(map.slot.texture) else {
                continue;
            };
            let (width, height) = (texture.width(), texture.height());
            if width != height || !(map.scale > 0.0) {
                return Err(SceneError::Value {
                    place: format!("light map of mesh '{}'", mesh.name),
                    what: "size or scale".to_owned(),
                    value: format!("{width} x {height}, scale {}", map.scale),
                    expected: "under a moving light a map must be square and its scale above 0",
                }
                .into());
            }
            // Rows in the order of the texels, which meshes read by their own origin.
            let texture = texture.clone().with_origin(Origin::TopLeft);
            let texel = |i: u32| {
                let [r, g, b, _] = texture.texel(0, i % width, i / width).unwrap_or_default();
                [r, g, b]
            };
            resting.push(Resting {
                texture: map.slot.texture,
                size: width,
                texels: (0..width * height).map(texel).collect(),
                mips: texture.levels() > 1,
                meshes: vec![(index, map.scale)],
            });
        }
        Ok(Self {
            light,
            resting,
            shadow_size,
            pcf_size,
            gutter,
        })
    }

    /// True if some surface has a light map.
    #[must_use]
    pub fn has_maps(&self) -> bool {
        !self.resting.is_empty()
    }

    /// Puts the light into the scene that [`MovingLight::new`] saw: into its list, and into its light maps.
    ///
    /// # Errors
    /// Those of [`bake`](crate::bake) and of shadow maps.
    pub fn place(&self, scene: &mut Scene, light: Light) -> Result<(), RenderError> {
        let Some(own) = scene.lights.get_mut(self.light) else {
            return Ok(());
        };
        *own = light;
        if self.resting.is_empty() {
            return Ok(());
        }
        let shadows = self.shadows(scene)?;
        let baker = Baker::new(scene)?;
        let mut textures = Vec::new();
        for resting in &self.resting {
            let mut texels = resting.texels.clone();
            for (mesh, scale) in &resting.meshes {
                let map = baker.bake(
                    *mesh,
                    &BakeOptions {
                        size: resting.size,
                        gutter: self.gutter,
                        shadows: &shadows,
                        lights: Some(&[self.light]),
                    },
                )?;
                for (sum, moved) in texels.iter_mut().zip(&map.texels) {
                    *sum = [0, 1, 2].map(|k| sum[k] + moved[k] / scale);
                }
            }
            let texture = Texture2d::new(&Image {
                width: resting.size,
                height: resting.size,
                channels: 3,
                texels: TexelData::F32(texels.as_flattened()),
                color: ColorSpace::Linear,
                alpha: Alpha::Data,
                origin: Origin::TopLeft,
            });
            let texture = texture.map_err(|error| SceneError::Value {
                place: "light map".to_owned(),
                what: "texel".to_owned(),
                value: error.to_string(),
                expected: "a light of finite brightness",
            })?;
            textures.push(match resting.mips {
                true => texture.with_mips(),
                false => texture,
            });
        }
        for (resting, texture) in self.resting.iter().zip(textures) {
            scene.textures[resting.texture] = texture;
        }
        Ok(())
    }

    /// The shadow map of the moved light.
    fn shadows(
        &self,
        scene: &Scene,
    ) -> Result<Vec<(usize, ShadowMap, texmap_light::ShadowBias, u32)>, RenderError> {
        if self.shadow_size == 0 {
            return Ok(Vec::new());
        }
        let kind = shadow_kind(scene, self.light, None)?;
        let (bias, taps) = (shadow_bias(scene), self.pcf_size);
        let map = shadow_map_for(scene, &kind, self.shadow_size, bias, taps, usize::MAX)?;
        Ok(vec![(self.light, map, bias, taps)])
    }
}

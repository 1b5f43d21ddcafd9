//! What a surface looks like before the light: its texel, through a ramp or within an outline, times what it is carved out of.

use texmap_math::Footprint;
use texmap_sample::{Sampler, Texture2d};

use super::view::constant;
use crate::canvas::straight;
use crate::solid::SolidStage;
use crate::textures::outline;
use crate::{Material, Mesh, Scene, TextureRole, TextureSlot};

/// Where a sample looks: coordinates of the mesh, and the place in the world with its change to the right and down.
#[derive(Clone, Copy)]
pub(super) struct Spot {
    pub(super) uv: [f32; 2],
    pub(super) footprint: Footprint,
    pub(super) position: [f32; 3],
    pub(super) moves: [[f32; 3]; 2],
}

/// The look-ups of a surface.
pub(super) struct Look<'s> {
    texture: Option<(Texture2d<'static>, &'s TextureSlot)>,
    ramp: Option<(Texture2d<'static>, &'s Sampler)>,
    solid: Option<SolidStage<'s>>,
    crisp: bool,
}

impl<'s> Look<'s> {
    /// Nothing if the surface has one colour.
    pub(super) fn new(scene: &'s Scene, mesh: &Mesh, material: &'s Material) -> Option<Self> {
        let with_mips = |index: usize| {
            let texture = scene.textures[index].clone();
            if texture.levels() == 1 {
                texture.with_mips()
            } else {
                texture
            }
        };
        // What copies its texel shows nothing that lies below.
        let copies = material.base_color.is_some() && material.texture_role == TextureRole::Decal;
        let solid = material.solid.as_ref().filter(|_| !copies);
        if material.base_color.is_none() && solid.is_none() {
            return None;
        }
        Some(Self {
            texture: material.base_color.as_ref().map(|slot| {
                let texture = with_mips(slot.texture).with_origin(mesh.uv_origin);
                (texture, slot)
            }),
            ramp: material
                .color_ramp
                .as_ref()
                .map(|slot| (with_mips(slot.texture), &slot.sampler)),
            solid: solid.map(|solid| SolidStage::new(solid, &scene.effects, 0)),
            crisp: material.crisp,
        })
    }

    /// Its texture's slot.
    pub(super) fn slot(&self) -> Option<&'s TextureSlot> {
        self.texture.as_ref().map(|(_, slot)| *slot)
    }

    /// The one colour of its texture, if nothing but that is seen.
    pub(super) fn constant(&self) -> Option<[f32; 4]> {
        let plain = self.ramp.is_none() && self.solid.is_none() && !self.crisp;
        let (texture, _) = self.texture.as_ref().filter(|_| plain)?;
        constant(texture)
    }

    /// The colour at a spot, its texture read by this sampler: linear, premultiplied.
    pub(super) fn color(&self, sampler: &Sampler, at: &Spot) -> [f32; 4] {
        let texel = match &self.texture {
            Some((texture, slot)) => self.texel(sampler, texture, slot, at),
            None => [1.0; 4],
        };
        let Some(solid) = &self.solid else {
            return texel;
        };
        let mut color = solid.color(at.position, at.moves[0], at.moves[1]);
        if let Some((ramp, along)) = &self.ramp {
            color = along.sample_lod(ramp, [color[0], 0.5], 0.0);
        }
        let [r, g, b] = straight(color);
        [texel[0] * r, texel[1] * g, texel[2] * b, texel[3]]
    }

    fn texel(
        &self,
        sampler: &Sampler,
        texture: &Texture2d<'_>,
        slot: &TextureSlot,
        at: &Spot,
    ) -> [f32; 4] {
        let uv = slot.transform.apply(at.uv);
        let d = slot.transform.apply_footprint(at.footprint);
        let mut texel = sampler.sample_grad(texture, uv, d);
        if let (Some((ramp, along)), None) = (&self.ramp, &self.solid) {
            let keep = texel[3];
            texel = sampler
                .sample_dependent(texture, uv, d, along, ramp)
                .map(|c| c * keep);
        }
        if self.crisp {
            let [r, g, b] = straight(texel);
            let alpha = outline(sampler, texture, uv, d, texel[3]);
            texel = [r * alpha, g * alpha, b * alpha, alpha];
        }
        texel
    }
}

//! Look of a surface before the light: its texel, through a ramp or within an outline, times its solid texture.

use texmap_math::Footprint;
use texmap_sample::{Filter, Lod, Precision, Sampler, Texture2d};

use super::textures::Textures;
use texmap_math::color::straight;
use texmap_scene::{Material, Mesh, Scene, SolidField, TextureRole, TextureSlot};

/// Coordinates of a sample: those of the mesh, and the position in the world with its change to the right and down.
#[derive(Clone, Copy)]
pub(super) struct Spot {
    pub(super) uv: [f32; 2],
    pub(super) footprint: Footprint,
    pub(super) position: [f32; 3],
    pub(super) moves: [[f32; 3]; 2],
}

/// The look-ups of a surface.
pub(super) struct Look<'s> {
    textures: &'s Textures<'s>,
    texture: Option<(Texture2d<'static>, &'s TextureSlot)>,
    ramp: Option<(Texture2d<'static>, &'s Sampler)>,
    solid: Option<SolidField<'s>>,
    /// A label over it.
    label: Option<(Texture2d<'static>, &'s TextureSlot)>,
    /// The surface colour, where it lies below a label.
    under: [f32; 3],
    crisp: bool,
}

/// Samplers of the textures of a surface.
#[derive(Clone)]
pub(super) struct Read {
    pub(super) base: Sampler,
    /// Sampler of the label, unless the label's own.
    pub(super) label: Option<Sampler>,
}

impl<'s> Look<'s> {
    /// Nothing if the surface has one colour.
    pub(super) fn new(
        scene: &'s Scene,
        textures: &'s Textures<'s>,
        mesh: &Mesh,
        material: &'s Material,
    ) -> Option<Self> {
        // A surface that copies its texel shows nothing that lies below.
        let copies = material.base_color.is_some() && material.texture_role == TextureRole::Decal;
        let solid = material.solid.as_ref().filter(|_| !copies);
        if material.base_color.is_none() && solid.is_none() && material.decal.is_none() {
            return None;
        }
        let on_mesh = |slot: &'s TextureSlot| {
            let texture = textures.with_mips(slot.texture).with_origin(mesh.uv_origin);
            (texture, slot)
        };
        Some(Self {
            textures,
            texture: material.base_color.as_ref().map(on_mesh),
            label: material.decal.as_ref().map(on_mesh),
            ramp: material
                .color_ramp
                .as_ref()
                .map(|slot| (textures.with_mips(slot.texture), &slot.sampler)),
            solid: solid.map(|solid| SolidField::new(solid, &scene.effects)),
            under: match material.decal {
                Some(_) if !copies => material.phong.color,
                _ => [1.0; 3],
            },
            crisp: material.antialiased_alpha,
        })
    }

    /// Slot of the base texture.
    pub(super) fn slot(&self) -> Option<&'s TextureSlot> {
        self.texture.as_ref().map(|(_, slot)| *slot)
    }

    /// Both textures by one filter.
    pub(super) fn by(&self, filter: Filter, precision: Precision) -> Read {
        let sampler = |slot: Option<&TextureSlot>| Sampler {
            filter,
            precision,
            ..slot.map(|slot| slot.sampler.clone()).unwrap_or_default()
        };
        let label = self.label.as_ref();
        Read {
            base: sampler(self.slot()),
            label: label.map(|(_, slot)| sampler(Some(slot))),
        }
    }

    /// Both by the best filter, without a bias.
    pub(super) fn reference(&self) -> Read {
        let mut read = self.by(Filter::Anisotropic(16), Precision::Exact);
        read.base.lod = Lod::default();
        if let Some(label) = &mut read.label {
            label.lod = Lod::default();
        }
        read
    }

    /// Textures that its filter reads.
    pub(super) fn textures(&self) -> usize {
        usize::from(self.texture.is_some()) + usize::from(self.label.is_some())
    }

    /// The one colour of its texture, if nothing but that is seen.
    pub(super) fn constant(&self) -> Option<[f32; 4]> {
        let plain = self.ramp.is_none() && self.solid.is_none() && self.label.is_none();
        let plain = plain && !self.crisp;
        let slot = self.slot().filter(|_| plain)?;
        self.textures.constant(slot.texture)
    }

    /// The colour at a spot: linear, premultiplied.
    pub(super) fn color(&self, read: &Read, at: &Spot) -> [f32; 4] {
        let mut texel = match &self.texture {
            Some((texture, slot)) => self.texel(&read.base, texture, slot, at),
            None => [1.0; 4],
        };
        if let Some(solid) = &self.solid {
            let mut color = solid.color(at.position, at.moves[0], at.moves[1]);
            if let Some((ramp, along)) = &self.ramp {
                color = along.sample_lod(ramp, [color[0], 0.5], 0.0);
            }
            let [r, g, b] = straight(color);
            texel = [texel[0] * r, texel[1] * g, texel[2] * b, texel[3]];
        }
        if let Some((texture, slot)) = &self.label {
            let uv = slot.transform.apply(at.uv);
            let d = slot.transform.apply_footprint(at.footprint);
            let sampler = read.label.as_ref().unwrap_or(&slot.sampler);
            let label = sampler.sample_grad(texture, uv, d);
            // The label covers the colour, not the holes.
            let keep = 1.0 - label[3];
            for k in 0..3 {
                texel[k] = label[k] * texel[3] + keep * texel[k] * self.under[k];
            }
        }
        texel
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
                .sample_through_ramp(texture, uv, d, along, ramp)
                .map(|c| c * keep);
        }
        if self.crisp {
            let [r, g, b] = straight(texel);
            let alpha = sampler.antialiased_alpha(texture, uv, d, texel[3]);
            texel = [r * alpha, g * alpha, b * alpha, alpha];
        }
        texel
    }
}

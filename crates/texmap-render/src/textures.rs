//! Textures of a scene, with the levels that its slots read.

use std::borrow::Cow;

use texmap_math::parallel;
use texmap_sample::{Filter, Origin, Texture2d};
use texmap_scene::{Background, ColorMode, Scene, Shading, TextureSlot};
use texmap_shade::Slot;

use crate::{RenderError, RenderSettings};

/// Textures with the mip chains and summed-area tables that samplers read, built once for both passes.
pub(crate) struct Chains {
    pub(crate) made: Vec<Option<Texture2d<'static>>>,
    /// Texels as encoded pixels, where an unlit surface shows them one by one and there are no more of them than pixels.
    codes: Vec<Option<Texture2d<'static>>>,
}

impl Chains {
    pub(crate) fn new(scene: &Scene, settings: &RenderSettings) -> Result<Self, RenderError> {
        let mut read: Vec<Vec<Filter>> = vec![Vec::new(); scene.textures.len()];
        let backdrop = match &scene.effects.background {
            Some(Background::Picture(slot)) => Some(slot),
            _ => None,
        };
        let meshes = scene.meshes.iter();
        let slots = meshes.flat_map(|mesh| scene.materials[mesh.material].slots());
        for slot in slots.chain(backdrop) {
            let texture = &scene.textures[slot.texture];
            let filter = settings.filter.unwrap_or(slot.sampler.filter);
            let read = &mut read[slot.texture];
            let bytes = texture.bytes_to_prepare(filter);
            let alike = |other: &Filter| {
                (other.reads_mips(), other.reads_summed_area())
                    == (filter.reads_mips(), filter.reads_summed_area())
            };
            if bytes > 0 && !read.iter().any(alike) {
                let made = match filter.reads_summed_area() {
                    true => "summed-area table",
                    false => "mip chain",
                };
                settings.memory.ask(
                    bytes,
                    format_args!(
                        "the {made} of a texture of {} x {} texels",
                        texture.width(),
                        texture.height()
                    ),
                    "take a smaller texture, or a filter that reads one level",
                )?;
                read.push(filter);
            }
        }
        let textures = scene.textures.iter().zip(read);
        let made = parallel::map(textures, |(texture, read)| {
            let prepared =
                |texture: Texture2d<'static>, filter: &Filter| texture.prepared_for(*filter);
            (!read.is_empty()).then(|| read.iter().fold(texture.clone(), prepared))
        });
        Ok(Self {
            made,
            codes: codes(scene, settings)?,
        })
    }

    /// A slot as a mesh reads it, by the filter and the wraps of the settings where they have some.
    pub(crate) fn slot<'s>(
        &self,
        slot: &'s TextureSlot,
        scene: &'s Scene,
        settings: &RenderSettings,
        origin: Origin,
    ) -> Slot<'s> {
        let mut sampler = Cow::Borrowed(&slot.sampler);
        if let Some(filter) = settings.filter {
            sampler.to_mut().filter = filter;
        }
        if let Some(wrap) = settings.wrap {
            (sampler.to_mut().wrap_u, sampler.to_mut().wrap_v) = (wrap, wrap);
        }
        let codes = self.codes[slot.texture].clone();
        let texture = self.of(slot, scene).with_origin(origin);
        Slot::new(texture, sampler, slot).with_codes(codes.map(|codes| codes.with_origin(origin)))
    }

    /// A ramp: no override of the settings reaches it.
    pub(crate) fn ramp<'s>(&self, slot: &'s TextureSlot, scene: &'s Scene) -> Slot<'s> {
        let texture = self.of(slot, scene).with_origin(Origin::TopLeft);
        Slot::new(texture, Cow::Borrowed(&slot.sampler), slot)
    }

    /// The texture of a slot, with all that was built for it.
    fn of(&self, slot: &TextureSlot, scene: &Scene) -> Texture2d<'static> {
        let own = &scene.textures[slot.texture];
        self.made[slot.texture].as_ref().unwrap_or(own).clone()
    }
}

fn codes(
    scene: &Scene,
    settings: &RenderSettings,
) -> Result<Vec<Option<Texture2d<'static>>>, RenderError> {
    let mut codes = vec![None; scene.textures.len()];
    let pixels = u64::from(settings.width) * u64::from(settings.height);
    for mesh in &scene.meshes {
        let material = &scene.materials[mesh.material];
        let Some(slot) = &material.base_color else {
            continue;
        };
        let texture = &scene.textures[slot.texture];
        let texels = u64::from(texture.width()) * u64::from(texture.height());
        let nearest = settings.filter.unwrap_or(slot.sampler.filter) == Filter::Nearest;
        let shown = scene.color == ColorMode::Srgb && material.shading == Shading::Unlit;
        if shown && nearest && texels <= pixels && codes[slot.texture].is_none() {
            settings.memory.ask(
                texels * 4,
                format_args!("the encoded texels of a texture"),
                "take a smaller texture",
            )?;
            codes[slot.texture] = texture.srgb8_codes(settings.level);
        }
    }
    Ok(codes)
}

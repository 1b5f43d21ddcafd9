//! Textures as meshes read them.

use std::borrow::Cow;

use rayon::prelude::*;
use texmap_math::Footprint;
use texmap_raster::Varyings;
use texmap_sample::{Filter, Origin, Sampler, Texture2d, UvTransform, Wrap};

use crate::{RenderError, RenderSettings};
use texmap_scene::{Background, ColorMode, Scene, Shading, TextureSlot, UvSet};

/// Mip chains by texture, built once for both passes and only where a sampler reads them.
pub(crate) struct Chains {
    pub(crate) mips: Vec<Option<Texture2d<'static>>>,
    /// Texels as encoded pixels, where an unlit surface shows them one by one and there are no more of them than pixels.
    codes: Vec<Option<Texture2d<'static>>>,
}

impl Chains {
    pub(crate) fn new(scene: &Scene, settings: &RenderSettings) -> Result<Self, RenderError> {
        let mut read = vec![false; scene.textures.len()];
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
            if filter.reads_mips() && texture.levels() == 1 && !*read {
                let (width, height) = (texture.width(), texture.height());
                // Up to four floats a texel, and a third more for the levels.
                settings.memory.ask(
                    u64::from(width) * u64::from(height) * 16 / 3 * 4,
                    format_args!("the mip chain of a texture of {width} x {height} texels"),
                    "take a smaller texture, or a filter that reads one level",
                )?;
                *read = true;
            }
        }
        let textures = scene.textures.par_iter().zip(read);
        let chains = textures
            .map(|(texture, read)| read.then(|| texture.clone().with_mips()))
            .collect();
        Ok(Self {
            mips: chains,
            codes: codes(scene, settings)?,
        })
    }

    /// The texture of a slot, with the levels that were built for it.
    fn of(&self, slot: &TextureSlot, scene: &Scene) -> Texture2d<'static> {
        let own = &scene.textures[slot.texture];
        self.mips[slot.texture].as_ref().unwrap_or(own).clone()
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

/// A texture as one mesh reads it.
pub(crate) struct Slot<'s> {
    pub(crate) texture: Texture2d<'static>,
    /// Its texels as encoded pixels: see [`Texture2d::srgb8_codes`].
    pub(crate) codes: Option<Texture2d<'static>>,
    pub(crate) sampler: Cow<'s, Sampler>,
    /// Rows of the transform, if there is one.
    transform: Option<[[f32; 3]; 2]>,
    /// The coordinates that it is read at.
    pub(crate) uv_set: UvSet,
}

impl Slot<'_> {
    /// Coordinates of the slot, and their footprint, from those of the mesh.
    pub(crate) fn place(&self, uv: [f32; 2], d: Footprint) -> ([f32; 2], Footprint) {
        let Some([[a, b, c], [e, f, g]]) = self.transform else {
            return (uv, d);
        };
        let uv = [a * uv[0] + b * uv[1] + c, e * uv[0] + f * uv[1] + g];
        let d = Footprint {
            du_dx: a * d.du_dx + b * d.dv_dx,
            dv_dx: e * d.du_dx + f * d.dv_dx,
            du_dy: a * d.du_dy + b * d.dv_dy,
            dv_dy: e * d.du_dy + f * d.dv_dy,
        };
        (uv, d)
    }

    /// Coordinates of the slot for the first `count` pixels of columns 0 and 1 of `uv`. They are `uv`, or `scratch` under a transform.
    pub(crate) fn placed<'a>(
        &self,
        uv: &'a Varyings,
        count: usize,
        scratch: &'a mut Varyings,
    ) -> &'a Varyings {
        if self.transform.is_none() {
            return uv;
        }
        scratch.varyings.clear();
        scratch.varyings.extend(uv.varyings.iter().take(2).cloned());
        self.place_columns(scratch, count);
        scratch
    }

    /// [`place`](Self::place) over the first `count` pixels of columns 0 and 1.
    pub(crate) fn place_columns(&self, values: &mut Varyings, count: usize) {
        if self.transform.is_none() {
            return;
        }
        let [u, v, ..] = &mut values.varyings[..] else {
            return;
        };
        self.place_all(
            [&mut u.value[..count], &mut v.value[..count]],
            [&mut u.ddx[..count], &mut v.ddx[..count]],
            [&mut u.ddy[..count], &mut v.ddy[..count]],
        );
    }

    /// [`place`](Self::place) over slices of one length, of coordinates and their changes to the right and down.
    pub(crate) fn place_all(
        &self,
        [u, v]: [&mut [f32]; 2],
        [ux, vx]: [&mut [f32]; 2],
        [uy, vy]: [&mut [f32]; 2],
    ) {
        for i in 0..u.len() {
            let d = Footprint::new(ux[i], vx[i], uy[i], vy[i]);
            let (uv, d) = self.place([u[i], v[i]], d);
            [u[i], v[i]] = uv;
            [ux[i], vx[i]] = [d.du_dx, d.dv_dx];
            [uy[i], vy[i]] = [d.du_dy, d.dv_dy];
        }
    }

    /// True if coordinates of the mesh are not those of the texture.
    pub(crate) fn is_transformed(&self) -> bool {
        self.transform.is_some()
    }

    /// True if the filter reads derivatives.
    pub(crate) fn reads_derivatives(&self) -> bool {
        self.sampler.filter.reads_derivatives()
    }

    /// The texel at coordinates of the mesh: linear, premultiplied.
    pub(crate) fn texel(&self, uv: [f32; 2], d: Footprint) -> [f32; 4] {
        let (uv, d) = self.place(uv, d);
        self.sampler.sample_grad(&self.texture, uv, d)
    }

    /// The texel of a ramp at 0 to 1 along it: linear, premultiplied.
    pub(crate) fn along(&self, place: f32) -> [f32; 4] {
        self.sampler.sample_lod(&self.texture, [place, 0.5], 0.0)
    }

    /// The texel of a ramp where the first channel of this texture points, by the change of both.
    pub(crate) fn dependent(&self, uv: [f32; 2], d: Footprint, ramp: &Slot<'_>) -> [f32; 4] {
        let (uv, d) = self.place(uv, d);
        let (sampler, texture) = (&ramp.sampler, &ramp.texture);
        self.sampler
            .sample_through_ramp(&self.texture, uv, d, sampler, texture)
    }

    /// Fraction of a pixel inside of the outline where alpha is a half; `alpha` is that of the filter.
    pub(crate) fn outline(&self, uv: [f32; 2], d: Footprint, alpha: f32) -> f32 {
        let (uv, d) = self.place(uv, d);
        self.sampler.antialiased_alpha(&self.texture, uv, d, alpha)
    }

    /// Opacity of a texel of an opacity map.
    pub(crate) fn opacity(&self, texel: [f32; 4]) -> f32 {
        texel[self.opacity_channel()]
    }

    /// The channel that holds an opacity map's opacities.
    pub(crate) fn opacity_channel(&self) -> usize {
        if self.texture.has_alpha() { 3 } else { 0 }
    }
}

impl<'s> Slot<'s> {
    pub(crate) fn new(
        slot: &'s TextureSlot,
        scene: &'s Scene,
        settings: &RenderSettings,
        chains: &Chains,
        origin: Origin,
    ) -> Self {
        let texture = chains.of(slot, scene).with_origin(origin);
        let mut sampler = Cow::Borrowed(&slot.sampler);
        if let Some(filter) = settings.filter {
            sampler.to_mut().filter = filter;
        }
        if let Some(wrap) = settings.wrap {
            (sampler.to_mut().wrap_u, sampler.to_mut().wrap_v) = (wrap, wrap);
        }
        let codes = chains.codes[slot.texture].clone();
        Self {
            codes: codes.map(|codes| codes.with_origin(origin)),
            ..Self::with_sampler(texture, sampler, slot)
        }
    }

    /// A ramp: no override of the settings reaches it.
    pub(crate) fn ramp(slot: &'s TextureSlot, scene: &'s Scene, chains: &Chains) -> Self {
        let texture = chains.of(slot, scene).with_origin(Origin::TopLeft);
        Self::with_sampler(texture, Cow::Borrowed(&slot.sampler), slot)
    }

    fn with_sampler(
        texture: Texture2d<'static>,
        sampler: Cow<'s, Sampler>,
        slot: &TextureSlot,
    ) -> Self {
        let transform = (slot.transform != UvTransform::default()).then(|| slot.transform.rows());
        Self {
            texture,
            codes: None,
            sampler,
            transform,
            uv_set: slot.uv_set,
        }
    }
}

impl Slot<'_> {
    /// True if some look-up may give less than full alpha.
    pub(crate) fn can_be_transparent(&self) -> bool {
        let s = &self.sampler;
        let border = s.wrap_u == Wrap::ClampToBorder || s.wrap_v == Wrap::ClampToBorder;
        self.texture.has_alpha() || (border && !(s.border[3] >= 1.0))
    }
}

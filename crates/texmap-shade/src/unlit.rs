//! Unlit surfaces whose color is a texel or one color, times a constant: they need no other stage.

use texmap_math::Level;
use texmap_math::simd::{Isa, prelude::*};
use texmap_raster::{BATCH_STRIDE, FragmentBlock, Varyings};
use texmap_sample::lanes::{BoundTexture, Kernel, sample_bound_soa};
use texmap_sample::{Filter, Sampler, is_exact_in_rgba8, sample_rgba8_soa};

use crate::Slot;
use crate::batch::{Colors, LANES, straight};
use crate::fetch::pixel_samples;
use crate::texels::{Pixels, TexelAddresses, is_near, packed_view, read_texels};
use texmap_scene::{AlphaMode, ColorMode, Material, TextureRole};

/// The conversion of a texel to the color of an unlit surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UnlitColor {
    /// Factors of the straight texel.
    tint: [f32; 3],
    /// Factor of its alpha where the surface blends.
    opacity: f32,
    blends: bool,
    /// Every texel is opaque.
    opaque_texels: bool,
    /// Texels are bytes.
    bytes: bool,
    /// The upper end of colors.
    limit: f32,
    /// True if the bytes are the encoded pixels where nothing blends.
    exact: bool,
}

impl UnlitColor {
    /// For a surface that is unlit, without vertex colors and without an opacity map; `None` where a transparent decal shows the
    /// surface below it.
    pub fn new(
        material: &Material,
        base_color: Option<&Slot<'_>>,
        mode: ColorMode,
    ) -> Option<Self> {
        let decal = base_color.is_some() && material.texture_role == TextureRole::Decal;
        let opaque_texels = !base_color.is_some_and(Slot::can_be_transparent);
        if decal && !opaque_texels && material.alpha == AlphaMode::Opaque {
            return None;
        }
        let tint = if decal {
            [1.0; 3]
        } else {
            material.phong.color
        };
        let bytes = base_color.is_some_and(|slot| is_exact_in_rgba8(&slot.sampler, &slot.texture));
        Some(Self {
            tint,
            opacity: material.opacity,
            blends: material.alpha == AlphaMode::Blend,
            opaque_texels,
            bytes,
            limit: 1.0,
            exact: bytes && mode == ColorMode::Raw && opaque_texels && tint == [1.0; 3],
        })
    }

    /// Colors that end at `limit` in the place of 1.
    #[must_use]
    pub fn with_limit(self, limit: f32) -> Self {
        Self { limit, ..self }
    }

    /// True if all colors are opaque.
    pub fn is_opaque(&self) -> bool {
        !self.blends || (self.opaque_texels && self.opacity >= 1.0)
    }

    /// True if encoded texels are the encoded pixels of the surface.
    fn shows_texels(&self) -> bool {
        self.is_opaque() && self.opaque_texels && self.tint == [1.0; 3]
    }

    /// True if packed texels are the encoded pixels of the surface.
    pub fn is_exact(&self) -> bool {
        self.exact && self.is_opaque()
    }

    /// The premultiplied color of a texel.
    #[inline(always)]
    pub fn tint<I: Isa>(&self, i: I, texel: [I::F32; 4]) -> [I::F32; 4] {
        let one = i.f32(1.0);
        let [mut r, mut g, mut b, a] = texel;
        let alpha = match (self.blends, self.opaque_texels) {
            (false, _) => one,
            (true, true) => i.f32(self.opacity),
            (true, false) => a * self.opacity,
        };
        if !self.opaque_texels {
            [r, g, b] = straight(i, texel);
        }
        // A factor of one changes nothing, and bytes are not above one.
        if !(self.bytes && self.opaque_texels && self.tint == [1.0; 3]) {
            (r, g, b) = (r * self.tint[0], g * self.tint[1], b * self.tint[2]);
            let limit = i.f32(self.limit);
            (r, g, b) = (r.below(limit), g.below(limit), b.below(limit));
        }
        [r * alpha, g * alpha, b * alpha, alpha]
    }
}

/// The one stage of an unlit surface.
pub struct Unlit<'a> {
    color: UnlitColor,
    slot: Option<&'a Slot<'a>>,
    /// The texture, bound, if texels are read channel by channel.
    bound: Option<BoundTexture<'a>>,
    /// The filter of near triangles, which read level 0 alone, where another one finds a level for each pixel.
    near: Option<(Sampler, BoundTexture<'a>)>,
    /// The texture, bound, if texels are read as packed words.
    view: Option<BoundTexture<'a>>,
    /// Its encoded texels, bound, if they are the pixels of the surface.
    codes: Option<BoundTexture<'a>>,
}

impl<'a> Unlit<'a> {
    /// Texels of `slot`, or the plain color without one.
    pub fn new(color: UnlitColor, slot: Option<&'a Slot<'a>>) -> Self {
        let plain = slot.filter(|slot| !slot.is_transformed());
        let codes = plain.filter(|_| color.shows_texels());
        let packed = plain.filter(|_| color.bytes);
        let bound = slot.and_then(|slot| BoundTexture::new(&slot.sampler, &slot.texture));
        let trilinear = |view: &BoundTexture<'_>| view.kind == Kernel::Trilinear;
        let near = plain.filter(|_| bound.as_ref().is_some_and(trilinear));
        Self {
            color,
            slot,
            bound,
            near: near.and_then(|slot| {
                let sampler = Sampler {
                    filter: Filter::Bilinear,
                    ..(*slot.sampler).clone()
                };
                let view = BoundTexture::new(&sampler, &slot.texture)?;
                Some((sampler, view))
            }),
            view: packed.and_then(|slot| packed_view(&slot.sampler, &slot.texture)),
            codes: codes.and_then(|slot| packed_view(&slot.sampler, slot.codes.as_ref()?)),
        }
    }

    /// The factors of texels.
    pub fn color(&self) -> &UnlitColor {
        &self.color
    }

    /// The view by which encoded pixels are read straight from the texture.
    pub fn exact_view(&self) -> Option<&BoundTexture<'a>> {
        self.view.as_ref().filter(|_| self.color.is_exact())
    }

    /// The view whose texels are encoded pixels.
    pub fn encoded_view(&self) -> Option<&BoundTexture<'a>> {
        self.exact_view().or(self.codes.as_ref())
    }

    /// True if texels are read.
    pub fn has_texture(&self) -> bool {
        self.slot.is_some()
    }

    /// True if the texels of a batch are packed words.
    pub fn gives_words(&self) -> bool {
        self.color.bytes
    }

    /// Reads the packed texels of a batch.
    pub fn read_words(
        &self,
        level: Level,
        pixels: &Pixels<'_>,
        batch: &[FragmentBlock],
        scratch: &mut UnlitScratch,
        out: &mut [u32; BATCH_STRIDE],
    ) {
        if let Some(view) = &self.view {
            return read_texels(level, view, pixels, batch, &mut scratch.addresses, out);
        }
        let Some(slot) = self.slot else { return };
        let count = scratch.read_uv(level, slot, pixels, batch, slot.reads_derivatives());
        let at = pixel_samples(slot, &scratch.values, count);
        let out = &mut out[..count];
        sample_rgba8_soa(level, &slot.sampler, &slot.texture, &at, out)
            .expect("the columns have one length");
    }

    /// The texels of a batch, still without the factors of the surface.
    pub fn shade(
        &self,
        level: Level,
        pixels: &Pixels<'_>,
        batch: &[FragmentBlock],
        scratch: &mut UnlitScratch,
        out: &mut Colors,
    ) {
        match (self.slot, &self.bound) {
            (Some(slot), Some(view)) => {
                let near = self.near.as_ref();
                let near = near.filter(|_| is_near(level, view, pixels, batch));
                let derivatives = near.is_none() && slot.reads_derivatives();
                let count = scratch.read_uv(level, slot, pixels, batch, derivatives);
                let mut at = pixel_samples(slot, &scratch.values, count);
                at.gradients = at.gradients.filter(|_| derivatives);
                let columns = out.columns_mut(count);
                let bound = near.map_or((&*slot.sampler, view), |(sampler, view)| (sampler, view));
                sample_bound_soa(level, bound, &at, columns).expect("the columns have one length");
            }
            _ => {
                let columns = out.columns_mut(batch.len() * LANES);
                columns.into_iter().for_each(|c| c.fill(1.0));
            }
        }
    }
}

/// Scratch of unlit stages.
#[derive(Default)]
pub struct UnlitScratch {
    /// Texel addresses of the batch.
    pub addresses: TexelAddresses,
    values: Varyings,
}

impl UnlitScratch {
    /// The coordinates of a batch as columns 0 and 1, as the slot reads them, and the number of pixels.
    fn read_uv(
        &mut self,
        level: Level,
        slot: &Slot<'_>,
        pixels: &Pixels<'_>,
        batch: &[FragmentBlock],
        derivatives: bool,
    ) -> usize {
        let count = batch.len() * LANES;
        let Pixels::Blocks(planes, blocks) = pixels else {
            debug_assert!(false, "scattered pixels are read by views");
            return count;
        };
        planes.values(level, blocks, batch, &[0, 1], derivatives, &mut self.values);
        slot.place_columns(&mut self.values, count);
        count
    }
}

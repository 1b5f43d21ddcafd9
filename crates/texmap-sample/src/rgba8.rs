//! Filters with 8-bit weights: [`Precision::Fast`] on 8-bit texels, rounded to 8 bits after every blend.
//!
//! Bytes are blended in 16-bit lanes; `(a << 8) + (b - a) w + 128` stays below 2^16 whatever the sign of `b - a`, so wrapping 16-bit
//! products are exact. The functions over lanes want a view whose format is [`RGBA8`](crate::lanes::RGBA8), those of
//! [`float`](crate::lanes::float) the others: debug builds check it.

pub(crate) mod anisotropic;
pub(crate) mod bilinear;
pub(crate) mod gl;
pub(crate) mod nearest;
pub(crate) mod trilinear;

use crate::{
    address::{
        lod::{TexelFootprint, log2_sqrt_fixed},
        texel::TexelAddress,
        wrap::Wrap,
    },
    bound_texture::BoundTexture,
    filter::{Kernel, LookUp},
    sampler::{Filter, Precision, Sampler},
    texel_data::{Chain, Format},
};
use texmap_math::simd::{Isa, prelude::*};

/// True if a sampler takes this path on a texture: floats and 16-bit texels keep f32 weights.
#[inline(always)]
pub(crate) fn applies(s: &Sampler, t: &Chain<'_>) -> bool {
    // A texel that is taken whole needs no weights; a border keeps its floats.
    let border = s.wrap_u == Wrap::ClampToBorder || s.wrap_v == Wrap::ClampToBorder;
    let whole = s.filter == Filter::Nearest && !border;
    (s.precision == Precision::Fast || whole)
        && t.format == Format::Rgba8
        && Kernel::of(s.filter).has_bytes()
}

/// Bytes to 0..1, channel by channel.
#[inline(always)]
pub fn unpack<I: Isa>(_: I, c: I::U32) -> [I::F32; 4] {
    let scale = Format::Rgba8.scale();
    [
        (c & 255).to_i32().to_f32() * scale,
        ((c >> 8) & 255).to_i32().to_f32() * scale,
        ((c >> 16) & 255).to_i32().to_f32() * scale,
        (c >> 24).to_i32().to_f32() * scale,
    ]
}

/// A colour as packed bytes.
pub(crate) fn border(c: [f32; 4]) -> u32 {
    let byte = |c: f32| {
        let c = c * 255.0;
        let c = if c > 0.0 { c } else { 0.0 };
        let c = if c < 255.0 { c } else { 255.0 };
        (c + 0.5) as u32
    };
    byte(c[0]) | byte(c[1]) << 8 | byte(c[2]) << 16 | byte(c[3]) << 24
}

/// A texel, or the border.
#[inline(always)]
fn tap<I: Isa>(i: I, view: &BoundTexture<'_>, at: TexelAddress<I>) -> I::U32 {
    let c = i.gather(view.words, at.word);
    if view.bordered {
        return at.outside().select(i.u32(view.border_word), c);
    }
    c
}

/// Level of detail with 8 fraction bits, limited (to 0 and above only where that is not all of it).
#[inline(always)]
pub fn lod<I: Isa>(i: I, view: &BoundTexture<'_>, d: &TexelFootprint<I>) -> I::I32 {
    limited(i, view, log2_sqrt_fixed(i, d.rho_max_squared()))
}

/// Bias and limits of a level with 8 fraction bits.
#[inline(always)]
fn limited<I: Isa>(i: I, view: &BoundTexture<'_>, lod: I::I32) -> I::I32 {
    if view.plain_lod {
        return lod;
    }
    fixed(i, view.lod_range.limit(i, lod.to_f32() * (1.0 / 256.0)))
}

/// A limited level with 8 fraction bits, within +-64 so that the conversion is in range.
#[inline(always)]
fn fixed<I: Isa>(i: I, lod: I::F32) -> I::I32 {
    let lod = lod.simd_gt(64.0).select(i.f32(64.0), lod);
    let lod = lod.simd_gt(-64.0).select(lod, i.f32(-64.0));
    (lod * 256.0).floor_to_i32()
}

impl<I: Isa> LookUp<I> {
    /// The limited level of detail with 8 fraction bits.
    #[inline(always)]
    fn fixed_lod(&self, i: I, view: &BoundTexture<'_>) -> I::I32 {
        match &self.footprint {
            Some(d) => lod(i, view, d),
            None => fixed(i, i.f32(self.flat)),
        }
    }
}

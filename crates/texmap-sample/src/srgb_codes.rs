//! Texels as sRGB encoding gives them.

use crate::{
    texel_data::{self, Chain, Format, Words},
    texture::Texture2d,
};
use alloc::vec;
use texmap_math::{
    Level, dispatch_simd,
    lanes::GatherTable,
    simd::{Isa, encode_srgb8, prelude::*},
};

impl Texture2d<'_> {
    /// The sRGB codes of level 0 as the texels of a linear RGBA8 texture: nearest look-ups in it are the encodings of those in this
    /// one. `None` unless texels are opaque and of 16 bits, as those of 8-bit sRGB images are.
    #[must_use]
    pub fn srgb8_codes(&self, level: Level) -> Option<Texture2d<'static>> {
        let base = *self.chain.levels.first()?;
        if self.chain.format != Format::Rgba16 || self.chain.encoded.is_some() || !self.chain.opaque
        {
            return None;
        }
        let count = base.width as usize * base.height as usize;
        let texels = self.chain.words().get(base.offset..)?.get(..2 * count)?;
        let mut codes = vec![0; count];
        dispatch_simd!(level, i => encode_texels(i, texels, &mut codes));
        Some(Texture2d {
            chain: Chain {
                words: Words::Owned(codes.into()),
                encoded: None,
                format: Format::Rgba8,
                levels: vec![texel_data::Level { offset: 0, ..base }],
                flip: self.chain.flip,
                opaque: true,
                sums: None,
            },
        })
    }
}

/// sRGB codes of opaque 16-bit texels.
#[inline(always)]
fn encode_texels<I: Isa>(i: I, texels: &[u32], codes: &mut [u32]) {
    let Some(words) = GatherTable::new(texels) else {
        return;
    };
    let (scale, half) = (Format::Rgba16.scale(), i.u32(0xffff));
    for (k, codes) in codes.chunks_mut(I::LANES).enumerate() {
        let first = 2 * (k * I::LANES) as i32;
        let at = (i.iota() << 1) + first;
        let [rg, b] = i.gather_pairs(words, at.to_u32());
        let [r, g, b] = [rg & half, rg >> 16, b & half];
        let light = [
            r.to_i32().to_f32() * scale,
            g.to_i32().to_f32() * scale,
            b.to_i32().to_f32() * scale,
        ];
        let word = encode_srgb8(i, light) | i.u32(0xff00_0000);
        let mut lanes = [0; 16];
        word.store(&mut lanes);
        codes.copy_from_slice(&lanes[..codes.len()]);
    }
}

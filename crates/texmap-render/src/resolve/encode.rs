//! 8-bit encoding of light: straight sRGB bytes, or raw ones in raw mode.

use texmap_math::simd::{Isa, One, Scalar, encode_srgb8, encode_unorm8, prelude::*};
use texmap_math::{Level, dispatch_simd};
use texmap_raster::{BATCH_STRIDE, FragmentBlock};

use super::tile_buffer::{Shaded, TileBuffer, load_light};
use texmap_scene::ColorMode;
use texmap_shade::batch::{LANES, straight};

/// Premultiplied light to packed straight bytes, red lowest.
pub(crate) fn encode(mode: ColorMode, light: [f32; 4]) -> u32 {
    let One(word) = encode_lanes(Scalar, mode, light);
    word
}

/// See [`encode`].
#[inline(always)]
pub(super) fn encode_lanes<I: Isa>(i: I, mode: ColorMode, light: [I::F32; 4]) -> I::U32 {
    let [mut r, mut g, mut b, a] = light;
    let mut alpha = i.u32(0xff00_0000);
    if !a.simd_eq(1.0).all_true() {
        [r, g, b] = straight(i, light);
        alpha = encode_unorm8(i, a) << 24;
    }
    let color = match mode {
        ColorMode::Srgb => encode_srgb8(i, [r, g, b]),
        ColorMode::Raw => {
            encode_unorm8(i, r) | (encode_unorm8(i, g) << 8) | (encode_unorm8(i, b) << 16)
        }
    };
    color | alpha
}

impl TileBuffer {
    /// Stores the opaque light of a batch as encoded pixels.
    pub(crate) fn put_encoded(
        &mut self,
        level: Level,
        mode: ColorMode,
        batch: &[FragmentBlock],
        colors: &Shaded<'_>,
    ) {
        let mut words = [0; BATCH_STRIDE];
        dispatch_simd!(level, i => encode_batch(i, mode, batch.len(), colors, &mut words));
        self.put_words(batch, &words);
    }

    /// Encodes the light of all pixels.
    pub(crate) fn encode_all(&mut self, level: Level, mode: ColorMode) {
        let Self { words, light } = self;
        dispatch_simd!(level, i => encode_all(i, mode, light, words));
    }
}

#[inline(always)]
fn encode_batch<I: Isa>(
    i: I,
    mode: ColorMode,
    blocks: usize,
    colors: &Shaded<'_>,
    words: &mut [u32; BATCH_STRIDE],
) {
    for at in (0..blocks * LANES).step_by(I::LANES) {
        let word = encode_lanes(i, mode, colors.load(i, at));
        word.store(&mut words[at..at + I::LANES]);
    }
}

#[inline(always)]
fn encode_all<I: Isa>(i: I, mode: ColorMode, light: &[f32], words: &mut [u32]) {
    for (block, words) in words.chunks_exact_mut(LANES).enumerate() {
        for part in (0..LANES).step_by(I::LANES) {
            let word = encode_lanes(i, mode, load_light(i, light, block, part));
            word.store(&mut words[part..part + I::LANES]);
        }
    }
}

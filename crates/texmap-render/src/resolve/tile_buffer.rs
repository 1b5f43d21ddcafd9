//! The color buffer of a tile, in the 4x4 blocks of the rasterizer: encoded pixels where nothing is to be mixed, else
//! premultiplied light (raw values in raw mode).

use texmap_math::simd::{Isa, prelude::*};
use texmap_math::{Level, dispatch_simd};
use texmap_raster::{BATCH_STRIDE, FragmentBlock, TILE};

use texmap_sample::lanes::packed::unpack_lanes;
use texmap_shade::batch::{Colors, LANES, set_bits};
use texmap_shade::unlit::UnlitColor;

/// Pixels of a tile.
const PIXELS: usize = (TILE * TILE) as usize;
/// Floats of a block: four channels, one after the other.
const FLOATS: usize = 4 * LANES;

/// Encoded colors and light of a tile.
pub(crate) struct TileBuffer {
    /// Packed straight RGBA bytes, red lowest.
    pub(super) words: Vec<u32>,
    /// Block by block.
    pub(super) light: Vec<f32>,
}

/// Colors of a batch, as the shading stages leave them.
pub(crate) enum Shaded<'a> {
    /// One encoded opaque color.
    Word(u32),
    /// Encoded opaque colors.
    Words(&'a [u32; BATCH_STRIDE]),
    /// RGBA8 texels, still without the factors of their surface.
    Texels(UnlitColor, &'a [u32; BATCH_STRIDE]),
    /// Texels as light, still without the factors of their surface.
    Untinted(UnlitColor, &'a Colors),
    /// Premultiplied light.
    Light(&'a Colors),
}

impl Shaded<'_> {
    /// The light from pixel `at` of the batch on.
    #[inline(always)]
    pub(super) fn load<I: Isa>(&self, i: I, at: usize) -> [I::F32; 4] {
        match self {
            Self::Light(colors) => colors.load(i, at),
            Self::Untinted(color, colors) => color.tint(i, colors.load(i, at)),
            Self::Texels(color, words) => {
                let word = i.load_u32(&words[at..at + I::LANES]);
                color.tint(i, unpack_lanes(i, word))
            }
            // Encoded colors never become light again.
            Self::Words(_) | Self::Word(_) => [i.f32(0.0); 4],
        }
    }
}

impl TileBuffer {
    pub(crate) fn new() -> Self {
        Self {
            words: vec![0; PIXELS],
            light: vec![0.0; 4 * PIXELS],
        }
    }

    pub(crate) fn fill_words(&mut self, word: u32) {
        self.words.fill(word);
    }

    pub(crate) fn fill_light(&mut self, color: [f32; 4]) {
        for block in self.light.as_chunks_mut::<FLOATS>().0 {
            for (channel, value) in block.chunks_exact_mut(LANES).zip(color) {
                channel.fill(value);
            }
        }
    }

    /// Stores one encoded color in every pixel of a batch.
    pub(crate) fn put_word(&mut self, batch: &[FragmentBlock], word: u32) {
        for at in batch {
            self.put_block(*at, &[word; LANES]);
        }
    }

    /// Stores the encoded colors of a batch.
    pub(crate) fn put_words(&mut self, batch: &[FragmentBlock], words: &[u32; BATCH_STRIDE]) {
        for (at, from) in batch.iter().zip(words.as_chunks().0) {
            self.put_block(*at, from);
        }
    }

    /// Stores the encoded colors of a block.
    #[inline(always)]
    pub(crate) fn put_block(&mut self, at: FragmentBlock, from: &[u32; LANES]) {
        let Some(to) = self
            .words
            .as_chunks_mut::<LANES>()
            .0
            .get_mut(usize::from(at.block))
        else {
            return;
        };
        if at.mask == u16::MAX {
            *to = *from;
        } else {
            set_bits(at.mask).for_each(|bit| to[bit] = from[bit]);
        }
    }

    /// Stores the light of a batch over the present contents.
    pub(crate) fn put_light(&mut self, level: Level, batch: &[FragmentBlock], colors: &Shaded<'_>) {
        let light = &mut self.light;
        dispatch_simd!(level, i => put_light(i, light, batch, colors));
    }

    /// The light of an encoded opaque pixel of raw mode.
    pub(crate) fn light_of_word(&self, index: usize) -> [f32; 4] {
        unpack_lanes(
            texmap_math::simd::Scalar,
            texmap_math::simd::One(self.words[index]),
        )
    }

    /// An encoded pixel by its index in the blocks of the tile.
    pub(crate) fn word_mut(&mut self, index: usize) -> &mut u32 {
        &mut self.words[index]
    }

    /// The light of a pixel by its index in the blocks of the tile.
    pub(crate) fn light_at(&self, index: usize) -> [f32; 4] {
        let first = index / LANES * FLOATS + index % LANES;
        [0, 1, 2, 3].map(|channel| self.light[first + channel * LANES])
    }
}

#[inline(always)]
fn put_light<I: Isa>(i: I, light: &mut [f32], batch: &[FragmentBlock], colors: &Shaded<'_>) {
    for (k, at) in batch.iter().enumerate() {
        let to = block_mut(light, at.block);
        for part in (0..LANES).step_by(I::LANES) {
            let pixels = i.mask_from_bits(u32::from(at.mask) >> part);
            let front = colors.load(i, k * LANES + part);
            for c in 0..4 {
                let to = &mut to[c * LANES + part..c * LANES + part + I::LANES];
                if at.mask == u16::MAX {
                    front[c].store(to);
                } else {
                    pixels.select(front[c], i.load_f32(to)).store(to);
                }
            }
        }
    }
}

/// The floats of a block.
#[inline(always)]
pub(super) fn block_mut(light: &mut [f32], block: u16) -> &mut [f32] {
    let start = usize::from(block) * FLOATS;
    &mut light[start..start + FLOATS]
}

/// The light of a part of a block, channel by channel.
#[inline(always)]
pub(super) fn load_light<I: Isa>(i: I, light: &[f32], block: usize, part: usize) -> [I::F32; 4] {
    let block = &light[block * FLOATS..(block + 1) * FLOATS];
    [
        i.load_f32(&block[part..]),
        i.load_f32(&block[LANES + part..]),
        i.load_f32(&block[2 * LANES + part..]),
        i.load_f32(&block[3 * LANES + part..]),
    ]
}

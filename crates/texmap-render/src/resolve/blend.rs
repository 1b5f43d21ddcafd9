//! Blending: a batch over the contents of the tile, and the mean of four samples a pixel.

use texmap_math::simd::{Isa, prelude::*};
use texmap_math::{Level, dispatch_simd};
use texmap_raster::FragmentBlock;

use super::encode::encode_lanes;
use super::tile_buffer::{Shaded, TileBuffer, block_mut, load_light};
use texmap_scene::ColorMode;
use texmap_shade::batch::LANES;

impl TileBuffer {
    /// Blends the blocks of a batch, in order, over the buffer. Pixels whose alpha is above 0 are marked in `covered`.
    pub(crate) fn blend(
        &mut self,
        level: Level,
        batch: &[FragmentBlock],
        colors: &Shaded<'_>,
        covered: &mut [u16],
    ) {
        let light = &mut self.light;
        dispatch_simd!(level, i => for (k, at) in batch.iter().enumerate() {
            blend_block(i, light, *at, colors, k * LANES, covered);
        });
    }

    /// The mean of four samples, encoded. (The sums of pairs: four equal colors stay what they are.)
    pub(crate) fn resolve(&mut self, level: Level, mode: ColorMode, samples: [&Self; 4]) {
        let (words, samples) = (&mut self.words, samples.map(|sample| &sample.light[..]));
        dispatch_simd!(level, i => for (block, words) in words.chunks_exact_mut(LANES).enumerate() {
            resolve_block(i, mode, samples, block, words);
        });
    }

    /// [`resolve`](Self::resolve) of encoded opaque pixels of raw mode: the mean of bytes, halves up, is the code of the mean of
    /// their light. Blocks that `same` names have four equal samples.
    pub(crate) fn resolve_words(
        &mut self,
        level: Level,
        samples: [&Self; 4],
        same: impl Fn(usize) -> bool,
    ) {
        let samples = samples.map(|sample| sample.words.as_chunks::<LANES>().0);
        let words = self.words.as_chunks_mut::<LANES>().0;
        dispatch_simd!(level, i => for (block, words) in words.iter_mut().enumerate() {
            if same(block) {
                *words = samples[0][block];
            } else {
                let [a, b, c, d] = samples;
                mean_of_words(i, [&a[block], &b[block], &c[block], &d[block]], words);
            }
        });
    }
}

/// `front + (1 - alpha) back`; opaque fronts replace, so that no infinity behind them survives.
#[inline(always)]
fn blend_block<I: Isa>(
    i: I,
    light: &mut [f32],
    at: FragmentBlock,
    colors: &Shaded<'_>,
    first: usize,
    covered: &mut [u16],
) {
    let to = block_mut(light, at.block);
    for part in (0..LANES).step_by(I::LANES) {
        let front = colors.load(i, first + part);
        let pixels = i.mask_from_bits(u32::from(at.mask) >> part);
        let (solid, keep) = (front[3].simd_ge(1.0), i.f32(1.0) - front[3]);
        // Two loops: one with a choice inside keeps both sides' vectors on the stack.
        if at.mask == u16::MAX && !solid.any_true() {
            for c in 0..4 {
                let to = &mut to[c * LANES + part..c * LANES + part + I::LANES];
                (front[c] + keep * i.load_f32(to)).store(to);
            }
        } else {
            for c in 0..4 {
                let to = &mut to[c * LANES + part..c * LANES + part + I::LANES];
                let back = i.load_f32(to);
                let mixed = solid.select(front[c], front[c] + keep * back);
                pixels.select(mixed, back).store(to);
            }
        }
        let seen = (pixels & front[3].simd_gt(0.0)).to_bitmask() as u16;
        covered[usize::from(at.block)] |= seen << part;
    }
}

#[inline(always)]
fn resolve_block<I: Isa>(
    i: I,
    mode: ColorMode,
    samples: [&[f32]; 4],
    block: usize,
    words: &mut [u32],
) {
    for part in (0..LANES).step_by(I::LANES) {
        let [a, b, c, d] = [
            load_light(i, samples[0], block, part),
            load_light(i, samples[1], block, part),
            load_light(i, samples[2], block, part),
            load_light(i, samples[3], block, part),
        ];
        let word = encode_lanes(i, mode, mean(i, [a, b, c, d]));
        word.store(&mut words[part..part + I::LANES]);
    }
}

/// The mean of four colors.
#[inline(always)]
pub(crate) fn mean<I: Isa>(_: I, [a, b, c, d]: [[I::F32; 4]; 4]) -> [I::F32; 4] {
    let mut mean = a;
    for k in 0..4 {
        mean[k] = ((a[k] + b[k]) + (c[k] + d[k])) * 0.25;
    }
    mean
}

/// Bytes 0 and 2 of a word.
const EVEN: u32 = 0x00ff_00ff;

/// The mean of each byte of a block's samples, halves up.
#[inline(always)]
fn mean_of_words<I: Isa>(i: I, samples: [&[u32; LANES]; 4], out: &mut [u32; LANES]) {
    for part in (0..LANES).step_by(I::LANES) {
        let (mut even, mut odd) = (i.u32(0x0002_0002), i.u32(0x0002_0002));
        for sample in samples {
            let word = i.load_u32(&sample[part..]);
            even = even + (word & EVEN);
            odd = odd + ((word >> 8) & EVEN);
        }
        let word = ((even >> 2) & EVEN) | (((odd >> 2) & EVEN) << 8);
        word.store(&mut out[part..part + I::LANES]);
    }
}

#[cfg(test)]
mod tests {
    use super::super::encode::encode;
    use super::*;
    use texmap_math::simd::Scalar;

    /// The mean of the light of four bytes in f32 is never on the wrong side of a half.
    #[test]
    fn mean_of_bytes_is_that_of_their_light() {
        let mut buffer = TileBuffer::new();
        let mut words = [0; LANES];
        for a in (0..=255).step_by(5) {
            for b in 0..=255 {
                for (c, d) in (0..=255)
                    .step_by(17)
                    .zip([0, 3, 80, 81, 250].into_iter().cycle())
                {
                    let bytes = [a, b, c, d];
                    let light = bytes.map(|byte: u32| {
                        *buffer.word_mut(0) = u32::from_le_bytes([byte as u8, 0, 0, 255]);
                        buffer.light_of_word(0)
                    });
                    let word = encode(ColorMode::Raw, mean(Scalar, light));
                    let samples = bytes.map(|byte| [byte | 0xff00_0000; LANES]);
                    mean_of_words(Scalar, samples.each_ref(), &mut words);
                    assert_eq!(words, [word; LANES], "{bytes:?}");
                }
            }
        }
    }
}

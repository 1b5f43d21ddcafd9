//! Four samples a pixel: each pixel is shaded at its centre, once for every triangle that one of its samples shows.

use texmap_math::simd::{Isa, Scalar, prelude::*};
use texmap_math::{Level, dispatch_simd};
use texmap_raster::{AttributePlanes, BATCH_STRIDE, FragmentBlock, NO_PRIMITIVE, TileVisibility};
use texmap_sample::lanes::BoundTexture;

use super::fragments::{EMPTY, blended};
use super::{BATCH_BLOCKS, BLOCKS, Context, Painter, Sample, Target, Tile};
use crate::resolve::blend::mean;
use crate::resolve::encode::encode;
use texmap_shade::batch::{LANES, set_bits};
use texmap_shade::texels::{Pixels, TexelAddresses, read_texels};

/// `by[j][k]`: the pixels of a block whose sample j shows the fragment that sample k showed first.
#[derive(Clone, Copy, Default)]
pub(super) struct SampleReuse {
    by: [[u16; 4]; 4],
}

impl SampleReuse {
    /// All samples show the fragment of the first, in all pixels.
    fn is_alike(&self) -> bool {
        self.by.iter().all(|by| by[0] == u16::MAX)
    }
}

impl Painter {
    /// Paints a tile of four samples a pixel. Each pixel is shaded at its centre, once for every triangle that one of its samples
    /// shows: at a centre outside of it, with the values its planes have there. `as_light` if
    /// [`mean_of_samples`](Self::mean_of_samples) is read.
    pub(crate) fn paint_multisampled(
        &mut self,
        context: &Context<'_>,
        positions: [[i32; 2]; 4],
        tile: usize,
        as_light: bool,
    ) {
        let (level, mode) = (context.plan.level, context.mode);
        context.prepared.planes(tile, &mut self.shader.planes);
        self.samples.resize_with(4, Sample::new);
        let blocks = self.samples.iter_mut().map(|sample| &mut sample.blocks);
        let (shared, samples) = (&mut self.shared, positions.into_iter().zip(blocks));
        context
            .prepared
            .visible_samples(tile, &context.alpha, shared, samples);
        self.find_reuse(level);
        self.covered.fill(0);
        if !as_light && self.paint_words(context) {
            return;
        }
        for sample in &mut self.samples {
            sample.buffer.fill_light(context.background);
        }
        let Self {
            samples,
            shader,
            list,
            reuse,
            covered,
            resolved,
            ..
        } = self;
        for k in 0..4 {
            let masks: [u16; BLOCKS] = std::array::from_fn(|block| reuse[block].by[k][k]);
            for (covered, mask) in covered.iter_mut().zip(masks) {
                *covered |= mask;
            }
            list.visible(&samples[k].blocks, &masks, NO_PRIMITIVE);
            // The buffers are lent out while the blocks are read.
            let blocks = std::mem::take(&mut samples[k].blocks);
            let of_sample = Tile {
                context,
                index: tile,
                blocks: &blocks,
            };
            for (draw, blocks_of) in list.parts() {
                for batch in blocks_of.chunks(BATCH_BLOCKS) {
                    let shaded = shader.shade(of_sample, draw, batch, false);
                    for (j, sample) in samples.iter_mut().enumerate().skip(k) {
                        let mut shared = [EMPTY; BATCH_BLOCKS];
                        for (to, at) in shared.iter_mut().zip(batch) {
                            *to = *at;
                            to.mask &= reuse[at.block as usize].by[j][k];
                        }
                        sample
                            .buffer
                            .put_light(level, &shared[..batch.len()], &shaded);
                    }
                }
            }
            samples[k].blocks = blocks;
        }
        if blended(context.plan, &samples[0].blocks).is_some() {
            for (sample, offset) in samples.iter_mut().zip(positions) {
                let Sample { blocks, buffer } = sample;
                list.blended(context.prepared, tile, offset, blocks);
                let of_sample = Tile {
                    context,
                    index: tile,
                    blocks,
                };
                let mut target = Target {
                    buffer,
                    encoded: false,
                    covered: Some(&mut covered[..]),
                    rows: &[],
                };
                shader.draw(of_sample, list, &mut target);
            }
        }
        if let [a, b, c, d] = &samples[..] {
            resolved.resolve(level, mode, [&a.buffer, &b.buffer, &c.buffer, &d.buffer]);
        }
    }

    /// The light of a pixel by its index in the blocks of the tile.
    pub(crate) fn mean_of_samples(&self, index: usize) -> [f32; 4] {
        match &self.samples[..] {
            [a, b, c, d] => mean(
                Scalar,
                [a, b, c, d].map(|sample| sample.buffer.light_at(index)),
            ),
            _ => [0.0; 4],
        }
    }

    /// Paints a tile that shows one surface whose look-ups are finished pixels. False, with nothing done, for other tiles.
    fn paint_words(&mut self, context: &Context<'_>) -> bool {
        let Self {
            samples,
            shader,
            list,
            reuse,
            strays,
            covered,
            resolved,
            ..
        } = self;
        let [first, rest @ ..] = &mut samples[..] else {
            return false;
        };
        let draws = &first.blocks.draws;
        let view = draws
            .first()
            .and_then(|draw| context.shaders[*draw as usize].0.unlit()?.exact_view());
        let Some(view) = view else {
            return false;
        };
        if draws.iter().any(|draw| *draw != draws[0])
            || blended(context.plan, &first.blocks).is_some()
            || !shader.planes.is_branch_free()
        {
            return false;
        }
        let level = context.plan.level;
        let masks: [u16; BLOCKS] = std::array::from_fn(|block| reuse[block].by[0][0]);
        list.visible(&first.blocks, &masks, NO_PRIMITIVE);
        let pixels = Pixels::Blocks(&shader.planes, &first.blocks);
        let (addresses, words) = (&mut shader.unlit.addresses, &mut shader.words);
        for batch in list.blocks.chunks(BATCH_BLOCKS) {
            read_texels(level, view, &pixels, batch, addresses, words);
            for (at, words) in batch.iter().zip(words.as_chunks().0) {
                first.buffer.put_block(*at, words);
                let reuse = &reuse[at.block as usize];
                if reuse.is_alike() {
                    continue;
                }
                for (sample, by) in rest.iter_mut().zip(&reuse.by[1..]) {
                    sample
                        .buffer
                        .put_block(FragmentBlock { mask: by[0], ..*at }, words);
                }
            }
        }
        strays.collect(reuse, rest);
        strays.paint(level, view, &shader.planes, addresses, words, rest);
        if let [a, b, c, d] = &samples[..] {
            let buffers = [&a.buffer, &b.buffer, &c.buffer, &d.buffer];
            resolved.resolve_words(level, buffers, |block| reuse[block].is_alike());
        }
        for (block, covered) in covered.iter_mut().enumerate() {
            let masks = samples.iter().map(|sample| sample.blocks.masks[block]);
            *covered = masks.clone().fold(0, |all, mask| all | mask);
            for bit in set_bits(!masks.fold(u16::MAX, |all, mask| all & mask)) {
                let pixel = block * LANES + bit;
                *resolved.word_mut(pixel) = edge(context, samples, pixel);
            }
        }
        true
    }

    /// Finds out which samples of a pixel show the same fragment.
    fn find_reuse(&mut self, level: Level) {
        self.reuse.clear();
        self.reuse.resize(BLOCKS, SampleReuse::default());
        let [a, b, c, d] = &self.samples[..] else {
            return;
        };
        let samples = [&a.blocks, &b.blocks, &c.blocks, &d.blocks];
        dispatch_simd!(level, i => for (block, reuse) in self.reuse.iter_mut().enumerate() {
            reuse_in_block(i, samples, block, reuse);
        });
    }
}

#[inline(always)]
fn reuse_in_block<I: Isa>(
    i: I,
    samples: [&TileVisibility; 4],
    block: usize,
    reuse: &mut SampleReuse,
) {
    for j in 0..4 {
        let mut left = samples[j].masks[block];
        for k in 0..j {
            let mut same = 0;
            for part in (0..LANES).step_by(I::LANES) {
                let at = block * LANES + part;
                let slot = i.load_u32(&samples[j].slot[at..]);
                let equal = slot.simd_eq(i.load_u32(&samples[k].slot[at..]));
                same |= (equal.to_bitmask() as u16) << part;
            }
            reuse.by[j][k] = same & left;
            left &= !same;
        }
        reuse.by[j][j] = left;
    }
}

/// A pixel of which samples show the background.
fn edge(context: &Context<'_>, samples: &[Sample], pixel: usize) -> u32 {
    let mut light = [[0.0; 4]; 4];
    for (light, sample) in light.iter_mut().zip(samples) {
        *light = if sample.blocks.masks[pixel / LANES] >> (pixel % LANES) & 1 == 1 {
            sample.buffer.light_of_word(pixel)
        } else {
            context.background
        };
    }
    encode(context.mode, mean(Scalar, light))
}

/// Pixels of which a later sample shows another fragment than those before.
#[derive(Default)]
pub(super) struct Strays {
    /// Indices in the tile's blocks, a multiple of sixteen: the last is repeated.
    pixels: Vec<u32>,
    slots: Vec<u32>,
    /// For each pixel, a bit per sample after the first that shows its fragment.
    shown_by: Vec<u8>,
    /// Blocks of sixteen of these pixels.
    run: Vec<FragmentBlock>,
}

impl Strays {
    fn collect(&mut self, reuse: &[SampleReuse], rest: &[Sample]) {
        self.pixels.clear();
        self.slots.clear();
        self.shown_by.clear();
        self.run.clear();
        for (block, SampleReuse { by }) in reuse.iter().enumerate() {
            for (k, sample) in (1..).zip(rest) {
                for bit in set_bits(by[k][k]) {
                    let place = block * LANES + bit;
                    let shown = |j: usize| u8::from(by[j][k] >> bit & 1 == 1) << (j - 1);
                    self.pixels.push(place as u32);
                    self.slots.push(sample.blocks.slot[place]);
                    self.shown_by.push((k..4).fold(0, |all, j| all | shown(j)));
                }
            }
        }
        let (Some(&pixel), Some(&slot)) = (self.pixels.last(), self.slots.last()) else {
            return;
        };
        let blocks = self.pixels.len().div_ceil(LANES);
        self.pixels.resize(blocks * LANES, pixel);
        self.slots.resize(blocks * LANES, slot);
        let all = (0..blocks).map(|block| FragmentBlock {
            block: block as u16,
            mask: u16::MAX,
            slot: NO_PRIMITIVE,
        });
        self.run.extend(all);
    }

    fn paint(
        &self,
        level: Level,
        view: &BoundTexture<'_>,
        planes: &AttributePlanes,
        addresses: &mut TexelAddresses,
        words: &mut [u32; BATCH_STRIDE],
        rest: &mut [Sample],
    ) {
        let pixels = Pixels::Scattered(planes, [&self.pixels, &self.slots]);
        for batch in self.run.chunks(BATCH_BLOCKS) {
            read_texels(level, view, &pixels, batch, addresses, words);
            let Some(start) = batch.first().map(|at| usize::from(at.block) * LANES) else {
                return;
            };
            let strays = self.pixels[start..].iter().zip(&self.shown_by[start..]);
            for (word, (pixel, shown_by)) in words[..batch.len() * LANES].iter().zip(strays) {
                for j in set_bits(u16::from(*shown_by)) {
                    *rest[j].buffer.word_mut(*pixel as usize) = *word;
                }
            }
        }
    }
}

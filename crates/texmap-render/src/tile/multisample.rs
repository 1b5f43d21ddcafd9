//! Four samples a pixel: each pixel is shaded at its centre, once for every triangle that one of its samples shows.

use texmap_math::Level;
use texmap_math::fearless_simd::{Simd, prelude::*, u32x16};
use texmap_math::simd::X16;
use texmap_raster::{BlockSink, NONE, RunBlock, TileBlocks, TilePlanes};
use texmap_sample::lanes::View;

use super::{BLOCKS, EMPTY, Painter, RUN_BLOCKS, Sample, Scenery, blended};
use crate::canvas::{Canvas, LANES, bits, finish, put_block};
use crate::direct::{Asked, Brush, Direct, From, Levels, Source};
use texmap_math::on_wide_level;

/// `by[j][k]`: the pixels of a block whose sample j shows the fragment that sample k showed first.
#[derive(Clone, Copy, Default)]
pub(super) struct Sharing {
    by: [[u16; 4]; 4],
}

impl Sharing {
    /// Each sample shows what the first shows, in all pixels.
    fn is_alike(&self) -> bool {
        self.by.iter().all(|by| by[0] == u16::MAX)
    }
}

impl Painter {
    /// Paints a tile of four samples a pixel. Each pixel is shaded at its centre, once for every triangle that one of its samples
    /// shows: at a centre outside of it, with the values its planes have there.
    pub(crate) fn paint_multisampled(
        &mut self,
        scenery: &Scenery<'_>,
        places: [[i32; 2]; 4],
        tile: usize,
    ) {
        let (level, mode) = (scenery.plan.level, scenery.mode);
        scenery.prepared.planes(tile, &mut self.shader.planes);
        self.samples.resize_with(4, Sample::new);
        let blocks = self.samples.iter_mut().map(|sample| &mut sample.blocks);
        let (shared, samples) = (&mut self.shared, places.into_iter().zip(blocks));
        scenery
            .prepared
            .visible_samples(tile, scenery.plan, shared, samples);
        self.share(level);
        self.covered.fill(0);
        if self.paint_words(scenery) {
            return;
        }
        for sample in &mut self.samples {
            sample.canvas.fill_light(scenery.background);
        }
        let Self {
            samples,
            shader,
            listed,
            sharing,
            covered,
            resolved,
            ..
        } = self;
        for k in 0..4 {
            let masks: [u16; BLOCKS] = std::array::from_fn(|block| sharing[block].by[k][k]);
            for (covered, mask) in covered.iter_mut().zip(masks) {
                *covered |= mask;
            }
            listed.visible(&samples[k].blocks, &masks, NONE);
            // The canvases are lent out while the blocks are read.
            let blocks = std::mem::take(&mut samples[k].blocks);
            shader.each_run(scenery, tile, &blocks, listed, |shown, run| {
                for (j, sample) in samples.iter_mut().enumerate().skip(k) {
                    let mut shared = [EMPTY; RUN_BLOCKS];
                    for (to, at) in shared.iter_mut().zip(run) {
                        *to = *at;
                        to.mask &= sharing[at.block as usize].by[j][k];
                    }
                    shown.put(level, mode, &shared[..run.len()], &mut sample.canvas);
                }
            });
            samples[k].blocks = blocks;
        }
        if blended(scenery.plan, &samples[0].blocks).is_some() {
            for (sample, offset) in samples.iter_mut().zip(places) {
                let Sample { blocks, canvas } = sample;
                listed.blended(scenery, tile, offset, blocks);
                let covered = Some(&mut covered[..]);
                shader.lay(scenery, tile, blocks, listed, false, canvas, covered, &[]);
            }
        }
        if let [a, b, c, d] = &samples[..] {
            resolved.resolve(level, mode, [&a.canvas, &b.canvas, &c.canvas, &d.canvas]);
        }
    }

    /// Where the tile shows one surface whose look-ups are finished pixels: false, with nothing done, elsewhere.
    fn paint_words(&mut self, scenery: &Scenery<'_>) -> bool {
        let Self {
            samples,
            shader,
            listed,
            sharing,
            strays,
            covered,
            resolved,
            ..
        } = self;
        let [first, rest @ ..] = &mut samples[..] else {
            return false;
        };
        let draws = &first.blocks.draws;
        let Some(direct) = draws
            .first()
            .and_then(|d| scenery.direct[*d as usize].as_ref())
        else {
            return false;
        };
        if draws.iter().any(|draw| *draw != draws[0])
            || blended(scenery.plan, &first.blocks).is_some()
            || !direct.gives_words()
            || !shader.planes.is_plain()
        {
            return false;
        }
        let level = scenery.plan.level;
        let masks: [u16; BLOCKS] = std::array::from_fn(|block| sharing[block].by[0][0]);
        listed.visible(&first.blocks, &masks, NONE);
        let mut from = From {
            planes: &shader.planes,
            blocks: &first.blocks,
            levels: &mut shader.levels,
        };
        let mut brush = First {
            words: first.canvas.words_mut(),
            rest,
            sharing,
        };
        if !brush.paint(level, direct, &mut from, &listed.blocks) {
            return false;
        }
        strays.collect(sharing, rest);
        strays.paint(level, direct, &shader.planes, &mut shader.levels, rest);
        if let [a, b, c, d] = &samples[..] {
            let canvases = [&a.canvas, &b.canvas, &c.canvas, &d.canvas];
            resolved.resolve_words(level, canvases, |block| sharing[block].is_alike());
        }
        for (block, covered) in covered.iter_mut().enumerate() {
            let masks = samples.iter().map(|sample| sample.blocks.masks[block]);
            *covered = masks.clone().fold(0, |all, mask| all | mask);
            for bit in bits(!masks.fold(u16::MAX, |all, mask| all & mask)) {
                let place = block * LANES + bit;
                *resolved.word_mut(place) = edge(scenery, samples, place);
            }
        }
        true
    }

    /// Finds out which samples of a pixel show the same fragment.
    fn share(&mut self, level: Level) {
        self.sharing.clear();
        self.sharing.resize(BLOCKS, Sharing::default());
        let [a, b, c, d] = &self.samples[..] else {
            return;
        };
        let samples = [&a.blocks, &b.blocks, &c.blocks, &d.blocks];
        on_wide_level!(
            level,
            s => for (block, sharing) in self.sharing.iter_mut().enumerate() {
                share_lanes(s, samples, block, sharing);
            },
            else for (block, sharing) in self.sharing.iter_mut().enumerate() {
                share_plain(samples, block, sharing);
            }
        );
    }
}

#[inline(always)]
fn share_lanes<S: Simd>(s: S, samples: [&TileBlocks; 4], block: usize, sharing: &mut Sharing) {
    let at = block * LANES..(block + 1) * LANES;
    let slots = [
        u32x16::from_slice(s, &samples[0].slot[at.clone()]),
        u32x16::from_slice(s, &samples[1].slot[at.clone()]),
        u32x16::from_slice(s, &samples[2].slot[at.clone()]),
        u32x16::from_slice(s, &samples[3].slot[at]),
    ];
    for j in 0..4 {
        let mut left = samples[j].masks[block];
        for k in 0..j {
            let same = slots[j].simd_eq(slots[k]).to_bitmask() as u16 & left;
            sharing.by[j][k] = same;
            left &= !same;
        }
        sharing.by[j][j] = left;
    }
}

fn share_plain(samples: [&TileBlocks; 4], block: usize, sharing: &mut Sharing) {
    for j in 0..4 {
        let mut left = samples[j].masks[block];
        for k in 0..j {
            for bit in 0..LANES {
                let at = block * LANES + bit;
                let same = samples[j].slot[at] == samples[k].slot[at];
                sharing.by[j][k] |= (u16::from(same) << bit) & left;
            }
            left &= !sharing.by[j][k];
        }
        sharing.by[j][j] = left;
    }
}

/// A pixel of which samples show the background.
fn edge(scenery: &Scenery<'_>, samples: &[Sample], place: usize) -> u32 {
    let mut light = [[0.0; 4]; 4];
    for (light, sample) in light.iter_mut().zip(samples) {
        *light = if sample.blocks.masks[place / LANES] >> (place % LANES) & 1 == 1 {
            sample.canvas.light_of_word(place)
        } else {
            scenery.background
        };
    }
    finish(scenery.mode, Canvas::mean(light))
}

/// Puts what the first samples of a tile show, and what others of their pixels share with them.
struct First<'a> {
    words: &'a mut [u32],
    /// The other samples.
    rest: &'a mut [Sample],
    sharing: &'a [Sharing],
}

impl First<'_> {
    /// False where there are no lanes, with nothing done.
    fn paint(
        &mut self,
        level: Level,
        direct: &Direct<'_>,
        from: &mut From<'_>,
        run: &[RunBlock],
    ) -> bool {
        on_wide_level!(
            level,
            s => {
                direct.paint(s, &from.source(), from.levels, run, self);
                true
            },
            else false
        )
    }
}

impl<S: Simd> Brush<S> for First<'_> {
    #[inline(always)]
    fn block(&mut self, s: S, at: RunBlock, texels: u32x16<S>) {
        put_block(s, self.words, at, texels);
        let sharing = &self.sharing[at.block as usize];
        if sharing.is_alike() {
            return;
        }
        for (sample, by) in self.rest.iter_mut().zip(&sharing.by[1..]) {
            let shared = RunBlock { mask: by[0], ..at };
            put_block(s, sample.canvas.words_mut(), shared, texels);
        }
    }
}

/// Pixels of which a later sample shows another fragment than those before.
#[derive(Default)]
pub(super) struct Strays {
    /// Places in the tile's blocks, a multiple of sixteen: the last is repeated.
    pixels: Vec<u32>,
    slots: Vec<u32>,
    /// Of each, a bit per sample after the first that shows it.
    shown_by: Vec<u8>,
    /// Sixteen a block.
    run: Vec<RunBlock>,
}

impl Strays {
    fn collect(&mut self, sharing: &[Sharing], rest: &[Sample]) {
        self.pixels.clear();
        self.slots.clear();
        self.shown_by.clear();
        self.run.clear();
        for (block, Sharing { by }) in sharing.iter().enumerate() {
            for (k, sample) in (1..).zip(rest) {
                for bit in bits(by[k][k]) {
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
        let all = (0..blocks).map(|block| RunBlock {
            block: block as u16,
            mask: u16::MAX,
            slot: NONE,
        });
        self.run.extend(all);
    }

    fn paint(
        &self,
        level: Level,
        direct: &Direct<'_>,
        planes: &TilePlanes,
        levels: &mut Levels,
        rest: &mut [Sample],
    ) {
        let source = Scattered {
            planes,
            strays: self,
        };
        let mut brush = Scatter { strays: self, rest };
        on_wide_level!(
            level,
            s => direct.paint(s, &source, levels, &self.run, &mut brush),
            else ()
        );
    }
}

/// The values of strays.
struct Scattered<'a> {
    planes: &'a TilePlanes,
    strays: &'a Strays,
}

impl<S: Simd> Source<S> for Scattered<'_> {
    #[inline(always)]
    fn each<const D: bool, K: BlockSink<X16<S>>>(&self, s: S, run: &[RunBlock], sink: &mut K) {
        let of = [&self.strays.pixels[..], &self.strays.slots[..]];
        self.planes
            .each_sixteen::<_, D, _>(X16(s), of, run, [0, 1], sink);
    }

    fn is_magnified(&self, _: S, _: &[RunBlock], _: &View<'_>, _: &mut Asked) -> bool {
        false
    }
}

/// Puts the texels of strays.
struct Scatter<'a> {
    strays: &'a Strays,
    rest: &'a mut [Sample],
}

impl<S: Simd> Brush<S> for Scatter<'_> {
    #[inline(always)]
    fn block(&mut self, _s: S, at: RunBlock, texels: u32x16<S>) {
        let mut words = [0; LANES];
        texels.store_slice(&mut words);
        let start = at.block as usize * LANES;
        let strays = self.strays.pixels[start..]
            .iter()
            .zip(&self.strays.shown_by[start..]);
        for (word, (pixel, shown_by)) in words.into_iter().zip(strays) {
            for j in bits(u16::from(*shown_by)) {
                *self.rest[j].canvas.word_mut(*pixel as usize) = word;
            }
        }
    }
}

//! Texture fetches of a batch. RGBA8 texels stay packed until a block needs them; uv and mips are computed once for the textures that
//! share coordinates.

use texmap_math::simd::Isa;
use texmap_math::{Footprint, Level};
use texmap_raster::{RUN_ROOM, RunBlock, RunValues, TileBlocks, TilePlanes};
use texmap_sample::lanes::View;
use texmap_sample::{Places, sample_columns};

use super::batch::{Colors, LANES, straight, unpack};
use super::texels::{Pixels, TexelAddresses, packed_view, read_pair};
use crate::textures::Slot;

/// Columns 0 and 1 as coordinates to sample at, with the derivatives that the filter reads.
pub(crate) fn places<'a>(slot: &Slot<'_>, values: &'a RunValues, count: usize) -> Places<'a> {
    let [u, v] = [&values.columns[0], &values.columns[1]];
    Places {
        u: &u.value[..count],
        v: &v.value[..count],
        gradients: slot.reads_derivatives().then(|| {
            [
                &u.ddx[..count],
                &v.ddx[..count],
                &u.ddy[..count],
                &v.ddy[..count],
            ]
        }),
    }
}

/// The coordinates of a pixel, and their footprint.
pub(crate) fn footprint_at(uv: &RunValues, at: usize) -> ([f32; 2], Footprint) {
    let [u, v] = [&uv.columns[0], &uv.columns[1]];
    let d = Footprint::new(u.ddx[at], v.ddx[at], u.ddy[at], v.ddy[at]);
    ([u.value[at], v.value[at]], d)
}

/// The texels of one texture over a batch, premultiplied.
#[derive(Default)]
pub(crate) struct Texels {
    /// Coordinates of the slot, where it has some of its own.
    placed: RunValues,
    pub(crate) colors: Colors,
}

impl Texels {
    /// Reads a texture at the coordinates of `blocks` blocks, columns 0 and 1 of `uv`.
    pub(crate) fn fetch(&mut self, level: Level, slot: &Slot<'_>, uv: &RunValues, blocks: usize) {
        let count = blocks * LANES;
        let uv = slot.placed(uv, count, &mut self.placed);
        let (at, columns) = (places(slot, uv, count), self.colors.columns_mut(count));
        sample_columns(level, &slot.sampler, &slot.texture, &at, columns)
            .expect("the columns have one length");
    }

    /// The straight colors from pixel `at` on: black where alpha is 0.
    #[inline(always)]
    pub(crate) fn straight<I: Isa>(&self, i: I, at: usize) -> [I::F32; 3] {
        straight(i, self.colors.load(i, at))
    }
}

/// Texels of a batch: packed bytes, or channel by channel.
pub(crate) struct PackedTexels {
    pub(crate) words: [u32; RUN_ROOM],
    pub(crate) colors: Colors,
    pub(crate) packed: bool,
}

impl Default for PackedTexels {
    fn default() -> Self {
        Self {
            words: [0; RUN_ROOM],
            colors: Colors::default(),
            packed: false,
        }
    }
}

impl PackedTexels {
    /// The premultiplied colors from pixel `at` on.
    #[inline(always)]
    pub(crate) fn load<I: Isa>(&self, i: I, at: usize) -> [I::F32; 4] {
        if self.packed {
            unpack(i, i.load_u32(&self.words[at..at + I::LANES]))
        } else {
            self.colors.load(i, at)
        }
    }
}

/// Two textures that are read at the coordinates of the vertices as they are: base color and normal map.
#[derive(Default)]
pub(crate) struct TexturePair<'a> {
    slots: [Option<&'a Slot<'a>>; 2],
    /// All of them, if all are packed.
    views: Option<[Option<View<'a>>; 2]>,
    /// The mips of both are the same.
    same_mips: bool,
    /// Some filter asks how large a pixel is.
    derivatives: bool,
}

impl<'a> TexturePair<'a> {
    pub(crate) fn new(level: Level, slots: [Option<&'a Slot<'a>>; 2]) -> Self {
        let views =
            slots.map(|slot| slot.map(|slot| packed_view(level, &slot.sampler, &slot.texture)));
        // A slot without a view spoils it.
        let views = match views {
            [Some(None), _] | [_, Some(None)] => None,
            [base, normal] => Some([base.flatten(), normal.flatten()]),
        };
        let same_mips = match (slots, &views) {
            ([Some(base), Some(normal)], Some([Some(a), Some(b)])) => {
                a.kind == b.kind && a.size() == b.size() && base.sampler.lod == normal.sampler.lod
            }
            _ => false,
        };
        let derivatives = slots.into_iter().flatten().any(Slot::reads_derivatives);
        Self {
            slots,
            views,
            same_mips,
            derivatives,
        }
    }

    /// Reads the texels of a batch.
    pub(crate) fn fetch(
        &self,
        level: Level,
        planes: &TilePlanes,
        blocks: &TileBlocks,
        batch: &[RunBlock],
        scratch: &mut PairScratch,
        out: &mut [PackedTexels; 2],
    ) {
        if self.slots.iter().all(Option::is_none) {
            return;
        }
        let PairScratch { values, addresses } = scratch;
        if let Some(views) = &self.views {
            let pixels = Pixels::Blocks(planes, blocks);
            let words = out.each_mut().map(|out| {
                out.packed = true;
                &mut out.words
            });
            read_pair(
                level,
                views,
                self.same_mips,
                &pixels,
                batch,
                addresses,
                words,
            );
            return;
        }
        planes.values(level, blocks, batch, &[0, 1], self.derivatives, values);
        let count = batch.len() * LANES;
        for (slot, out) in self.slots.iter().zip(out) {
            if let Some(slot) = slot {
                out.packed = false;
                let (at, columns) = (places(slot, values, count), out.colors.columns_mut(count));
                sample_columns(level, &slot.sampler, &slot.texture, &at, columns)
                    .expect("the columns have one length");
            }
        }
    }
}

/// Columns that a [`TexturePair`] reads.
#[derive(Default)]
pub(crate) struct PairScratch {
    values: RunValues,
    addresses: TexelAddresses,
}

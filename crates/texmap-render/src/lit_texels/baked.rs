//! The look-ups of light maps.

use texmap_math::Level;
use texmap_math::fearless_simd::{Simd, f32x16, prelude::*};
use texmap_raster::{RunBlock, RunValues, TileBlocks, TilePlanes};
use texmap_sample::sample_columns;

use crate::canvas::{Colors, LANES};
use crate::texel::places;
use crate::textures::Slot;

/// The look-ups of a light map, which has coordinates of its own.
pub(crate) struct BakedLookUp<'a> {
    /// Multiplies the texels.
    pub(crate) share: f32,
    pub(crate) slot: &'a Slot<'a>,
    /// Of the attributes that are its coordinates.
    pub(crate) first: usize,
}

/// Baked light over a run, premultiplied.
pub(crate) struct BakedTexels {
    values: RunValues,
    colors: Colors,
}

impl Default for BakedTexels {
    fn default() -> Self {
        Self {
            values: RunValues::default(),
            colors: Colors::new(),
        }
    }
}

impl BakedTexels {
    /// The straight colours of a block: black where nothing is left of them.
    #[inline(always)]
    pub(crate) fn lanes<S: Simd>(&self, s: S, i: usize) -> [f32x16<S>; 3] {
        let [r, g, b, a] = self.colors.lanes(s, i);
        let (zero, some) = (f32x16::splat(s, 0.0), a.simd_gt(0.0));
        [
            some.select(r / a, zero),
            some.select(g / a, zero),
            some.select(b / a, zero),
        ]
    }
}

impl BakedLookUp<'_> {
    /// The texels of a run.
    pub(crate) fn run(
        &self,
        level: Level,
        planes: &TilePlanes,
        blocks: &TileBlocks,
        run: &[RunBlock],
        out: &mut BakedTexels,
    ) {
        let (slot, count) = (self.slot, run.len() * LANES);
        let (wanted, derivatives) = ([self.first, self.first + 1], slot.reads_derivatives());
        planes.values(level, blocks, run, &wanted, derivatives, &mut out.values);
        slot.place_columns(&mut out.values, count);
        let columns = out.colors.0.each_mut().map(|c| &mut c[..count]);
        let at = places(slot, &out.values, count);
        sample_columns(level, &slot.sampler, &slot.texture, &at, columns)
            .expect("the columns have one length");
    }
}

//! The look-ups of maps, whatever their slots: transformed, with alpha, under any filter.

use texmap_math::Level;
use texmap_math::fearless_simd::{Simd, f32x16};
use texmap_raster::RunValues;
use texmap_sample::sample_columns;

use crate::shade::batch::{Colors, LANES, straight_lanes};
use crate::shade::unlit::places;
use crate::textures::Slot;

/// A map's texels over a run, premultiplied.
pub(crate) struct MapTexels {
    /// Coordinates of the slot, where it has some of its own.
    placed: RunValues,
    colors: Colors,
}

impl Default for MapTexels {
    fn default() -> Self {
        Self {
            placed: RunValues::default(),
            colors: Colors::default(),
        }
    }
}

impl MapTexels {
    /// Looks a map up at the coordinates of `blocks` blocks, columns 0 and 1 of `uv`.
    pub(crate) fn look_up(&mut self, level: Level, slot: &Slot<'_>, uv: &RunValues, blocks: usize) {
        let count = blocks * LANES;
        let uv = slot.placed(uv, count, &mut self.placed);
        let columns = self.colors.0.each_mut().map(|c| &mut c[..count]);
        let at = places(slot, uv, count);
        sample_columns(level, &slot.sampler, &slot.texture, &at, columns)
            .expect("the columns have one length");
    }

    #[inline(always)]
    pub(crate) fn lanes<S: Simd>(&self, s: S, i: usize) -> [f32x16<S>; 4] {
        self.colors.lanes(s, i)
    }

    /// The straight colours of a block: black where nothing is left of them.
    #[inline(always)]
    pub(crate) fn straight<S: Simd>(&self, s: S, i: usize) -> [f32x16<S>; 3] {
        straight_lanes(s, self.colors.lanes(s, i))
    }
}

//! Solid textures: color as a function of the position in space (Perlin 1985; Peachey 1985).

use texmap_light::lanes::{Vector, dot};
use texmap_math::simd::{Isa, prelude::*};
use texmap_math::{Level, dispatch_simd};
use texmap_raster::{BATCH_STRIDE, Varying};
use texmap_sample::{Pattern, Texture3d, UvwBatch, sample_3d_soa};

use crate::batch::{Batch, Colors, Columns, LANES, columns, load_changes, load_vector};
use texmap_scene::{Effects, SolidField, SolidTexture};

/// A solid texture as the stages read it.
pub struct SolidStage<'s> {
    field: SolidField<'s>,
    /// First of the attributes that hold the world position.
    position: usize,
}

impl<'s> SolidStage<'s> {
    /// A solid texture read at attributes `position` to `position + 2`.
    pub fn new(solid: &'s SolidTexture, effects: &'s Effects, position: usize) -> Self {
        Self {
            field: SolidField::new(solid, effects),
            position,
        }
    }

    /// The colors of a batch, premultiplied; a pattern gives its value in all three channels.
    pub(crate) fn fetch(&self, level: Level, batch: &Batch<'_>, out: &mut Colors) {
        let position: &[Varying; 3] = columns(batch.values, self.position);
        let count = batch.list.len() * LANES;
        if let Some((grid, sampler, wrap_w)) = self.field.grid() {
            let mut at = Columns::default();
            dispatch_simd!(level, i => self.texels(i, grid, position, count, &mut at));
            let [u, v, w, lod] = at.columns(count);
            let lod = Some(lod);
            let at = UvwBatch { u, v, w, lod };
            sample_3d_soa(level, sampler, grid, wrap_w, &at, out.columns_mut(count))
                .expect("the columns have one length");
        }
        if let Some(pattern) = self.field.pattern() {
            let [r, g, b, a] = &mut out.0;
            dispatch_simd!(level, i => self.values(i, &pattern, position, count, r));
            g[..count].copy_from_slice(&r[..count]);
            b[..count].copy_from_slice(&r[..count]);
            a[..count].fill(1.0);
        }
    }

    /// Coordinates in a grid and levels of detail.
    #[inline(always)]
    fn texels<I: Isa>(
        &self,
        i: I,
        grid: &Texture3d<'_>,
        position: &[Varying; 3],
        count: usize,
        out: &mut Columns<4>,
    ) {
        for at in (0..count).step_by(I::LANES) {
            let [[u, v, w], dx, dy] = self.place(i, position, at);
            out.store(i, at, [u, v, w, grid.lod_lanes(i, dx, dy)]);
        }
    }

    #[inline(always)]
    fn values<I: Isa>(
        &self,
        i: I,
        pattern: &Pattern,
        position: &[Varying; 3],
        count: usize,
        out: &mut [f32; BATCH_STRIDE],
    ) {
        for at in (0..count).step_by(I::LANES) {
            let [place, dx, dy] = self.place(i, position, at);
            let width = dot(dx, dx).above(dot(dy, dy)).sqrt();
            let value = pattern.value_lanes(i, place, width);
            value.store(&mut out[at..at + I::LANES]);
        }
    }

    /// See [`SolidField::place_lanes`].
    #[inline(always)]
    fn place<I: Isa>(&self, i: I, position: &[Varying; 3], at: usize) -> [Vector<I>; 3] {
        let [dx, dy] = load_changes(i, position, at);
        self.field.place_lanes(load_vector(i, position, at), dx, dy)
    }
}

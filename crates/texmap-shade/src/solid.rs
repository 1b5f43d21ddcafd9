//! Solid textures: color as a function of the position in space (Perlin 1985; Peachey 1985).

use texmap_light::lanes::{Vector, dot};
use texmap_math::simd::{Isa, prelude::*};
use texmap_math::{Level, dispatch_simd};
use texmap_raster::{BATCH_STRIDE, Varying};
use texmap_sample::Pattern;

use crate::batch::{Batch, Colors, LANES, columns, load_changes, load_vector};
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
        if let Some(pattern) = self.field.pattern() {
            let [r, g, b, a] = &mut out.0;
            let count = batch.list.len() * LANES;
            dispatch_simd!(level, i => self.values(i, &pattern, position, count, r));
            g[..count].copy_from_slice(&r[..count]);
            b[..count].copy_from_slice(&r[..count]);
            a[..count].fill(1.0);
            return;
        }
        for (at, ..) in batch.fragments() {
            let value = position.each_ref().map(|c| c.value[at]);
            let dx = position.each_ref().map(|c| c.ddx[at]);
            let dy = position.each_ref().map(|c| c.ddy[at]);
            out.set(at, self.field.color(value, dx, dy));
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
            let mut place = self.along(i, load_vector(i, position, at));
            for (c, row) in place.iter_mut().zip(self.field.rows()) {
                *c = *c + row[3];
            }
            let [dx, dy] = load_changes(i, position, at);
            let (dx, dy) = (self.along(i, dx), self.along(i, dy));
            let width = dot(dx, dx).above(dot(dy, dy)).sqrt();
            let value = pattern.value_lanes(i, place, width);
            value.store(&mut out[at..at + I::LANES]);
        }
    }

    /// A vector in the space of the texture.
    #[inline(always)]
    fn along<I: Isa>(&self, _: I, v: Vector<I>) -> Vector<I> {
        let mut out = v;
        for (out, r) in out.iter_mut().zip(self.field.rows()) {
            *out = v[0] * r[0] + v[1] * r[1] + v[2] * r[2];
        }
        out
    }
}

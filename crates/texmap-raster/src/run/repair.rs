//! Blocks whose pixels the common way does not serve: triangles that f32 planes are too coarse for, and attributes linear on the screen
//! where a block has several triangles.

use texmap_math::fearless_simd::{Simd, prelude::*, u32x16};
use texmap_math::lanes::{LANES, Words};

use super::planes::{OnRow, Own, PlaneSource};
use super::values::{BlockValues, Columns, ColumnsAt, lanes_of};
use super::wide::Wide;
use super::{RunBlock, centres};
use crate::blocks::pixel_of;
use crate::plane_table::TilePlanes;
use crate::setup::{Fragment, TriangleSetup};

/// What the common way has left to do in a block.
enum Rest<'t> {
    Nothing,
    /// Every pixel, in lanes.
    Wide(&'t TriangleSetup),
    /// Pixels of these slots: those whose bits are set, and where attributes are linear.
    Pixels([u32; LANES], u16),
}

/// Takes what is replaced in a block.
pub(super) trait Patch {
    fn inv_w(&mut self, bit: usize, value: f32);
    /// Value, and change to the right and down, of the attribute at place `i` of those asked for.
    fn attribute(&mut self, i: usize, bit: usize, value: [f32; 3]);
}

impl TilePlanes {
    /// Replaces the values of slots that f32 planes cannot serve, and, where a block has several, those that are linear on the screen.
    #[inline(always)]
    pub(super) fn mend<S: Simd, const D: bool>(
        &self,
        s: S,
        slots: u32x16<S>,
        at: RunBlock,
        one: bool,
        wanted: [usize; 2],
        values: &mut BlockValues<S>,
    ) {
        match self.rest(slots, at, one) {
            Rest::Nothing => {}
            Rest::Wide(setup) => {
                let wide = Wide::new(s, setup, at.block);
                values.inv_w = wide.inv_w();
                for (k, &attribute) in wanted.iter().enumerate() {
                    if let Some([u, dx, dy]) = wide.attribute::<D>(attribute) {
                        (values.value[k], values.ddx[k], values.ddy[k]) = (u, dx, dy);
                    }
                }
            }
            Rest::Pixels(lanes, odd) => {
                let mut spilt = values.spill();
                self.repair(s, &lanes, odd, at.block, &wanted, &mut spilt);
                *values = BlockValues::load(s, &spilt);
            }
        }
    }

    /// [`mend`](Self::mend) in the columns of a run.
    #[inline(always)]
    pub(super) fn mend_columns<S: Simd, const D: bool>(
        &self,
        s: S,
        (i, at): (usize, RunBlock),
        slots: u32x16<S>,
        one: bool,
        wanted: &[usize],
        out: &mut Columns<'_>,
    ) {
        match self.rest(slots, at, one) {
            Rest::Nothing => {}
            Rest::Wide(setup) => {
                let wide = Wide::new(s, setup, at.block);
                wide.inv_w().store_slice(&mut out.inv_w[lanes_of(i)]);
                for (column, &k) in out.columns.iter_mut().zip(wanted) {
                    if let Some(values) = wide.attribute::<D>(k) {
                        column.put::<S, D>(i, values);
                    }
                }
            }
            Rest::Pixels(lanes, odd) => {
                let patch = &mut ColumnsAt(out, i);
                self.repair(s, &lanes, odd, at.block, wanted, patch);
            }
        }
    }

    #[inline(always)]
    fn rest<S: Simd>(&self, slots: u32x16<S>, at: RunBlock, one: bool) -> Rest<'_> {
        if one {
            match self.odd_setup(slots[0]) {
                None => return Rest::Nothing,
                Some(setup) if setup.is_wide_perspective() => return Rest::Wide(setup),
                Some(_) => {}
            }
        }
        let mut lanes = [0; LANES];
        slots.store_slice(&mut lanes);
        let mut odd = 0u16;
        if !self.setups.is_empty() {
            for (bit, &slot) in lanes.iter().enumerate() {
                odd |= u16::from(self.odd_setup(slot).is_some()) << bit;
            }
        }
        odd &= at.mask;
        if odd != 0 || self.has_linear {
            Rest::Pixels(lanes, odd)
        } else {
            Rest::Nothing
        }
    }

    /// What [`mend`](Self::mend) replaces pixel by pixel, out of its way.
    #[inline(never)]
    fn repair<S: Simd>(
        &self,
        s: S,
        lanes: &[u32; LANES],
        odd: u16,
        block: u16,
        wanted: &[usize],
        out: &mut dyn Patch,
    ) {
        if self.has_linear {
            self.straighten(s, lanes, block, wanted, out);
        }
        self.evaluate(lanes, odd, block, wanted, out);
    }

    /// The attributes of a block's lanes that are linear on the screen.
    fn straighten<S: Simd>(
        &self,
        s: S,
        lanes: &[u32; LANES],
        block: u16,
        wanted: &[usize],
        out: &mut dyn Patch,
    ) {
        s.vectorize(
            #[inline(always)]
            || {
                let Some(words) = Words::new(bytemuck::cast_slice(&self.words)) else {
                    return;
                };
                let own = Own::new(s, self, words, u32x16::from_slice(s, lanes));
                let flags = lanes.map(|slot| self.linear(slot));
                let [px, py] = centres(s, block);
                for (i, &k) in wanted.iter().enumerate() {
                    let plane = OnRow::new(own.plane(s, 1 + k), py);
                    let [u, dx, dy] = plane.straight(px);
                    let mut values = [[0.0; LANES]; 3];
                    u.store_slice(&mut values[0]);
                    dx.store_slice(&mut values[1]);
                    dy.store_slice(&mut values[2]);
                    for bit in (0..LANES).filter(|bit| flags[*bit] >> k & 1 == 1) {
                        out.attribute(i, bit, values.each_ref().map(|v| v[bit]));
                    }
                }
            },
        );
    }

    /// The pixels `odd` of a block by their triangles' full set-ups.
    fn evaluate(
        &self,
        slots: &[u32; LANES],
        odd: u16,
        block: u16,
        wanted: &[usize],
        out: &mut dyn Patch,
    ) {
        let mut fragment = Fragment::default();
        for bit in (0..LANES).filter(|bit| odd >> bit & 1 == 1) {
            let Some(setup) = self.odd_setup(slots[bit]) else {
                continue;
            };
            self.fragment(setup, block, bit, &mut fragment);
            out.inv_w(bit, fragment.inv_w);
            for (i, &k) in wanted.iter().enumerate() {
                let value = [fragment.values[k], fragment.ddx[k], fragment.ddy[k]];
                out.attribute(i, bit, value);
            }
        }
    }

    pub(super) fn fragment(
        &self,
        setup: &TriangleSetup,
        block: u16,
        bit: usize,
        out: &mut Fragment,
    ) {
        let (x, y) = pixel_of(block as usize, bit as u32);
        setup.evaluate(self.corner[0] + x, self.corner[1] + y, out);
    }
}

//! Blocks whose pixels the common way does not serve: triangles that f32 planes are too coarse for, and attributes linear on the screen
//! where a block has several triangles.

use texmap_math::simd::{GatherTable, Isa, prelude::*};

use super::planes::{Own, PlaneSource};
use super::values::{BlockValues, Columns, ColumnsAt};
use super::{Part, Slots};
use crate::coverage::stamp::BLOCK_PIXELS;
use crate::setup::plane_table::AttributePlanes;
use crate::setup::planes::RowPlane;
use crate::setup::{Fragment, RowNodes, TriangleSetup, WidePixels};
use crate::visibility::blocks::pixel_of;

/// Pixels of a block whose values the f32 planes do not give.
enum Rest<'t> {
    Nothing,
    /// All, in lanes.
    Wide(&'t TriangleSetup),
    /// All, linear between nodes of their rows.
    Rows(&'t TriangleSetup),
    /// Pixels of these slots: those whose bits are set, and those whose attributes are linear.
    Pixels([u32; BLOCK_PIXELS], u32),
}

/// Takes what is replaced, lane by lane.
pub(super) trait Patch {
    fn inv_w(&mut self, lane: usize, value: f32);
    /// Value, and change to the right and down, of the attribute at index `i` of those asked for.
    fn attribute(&mut self, i: usize, lane: usize, value: [f32; 3]);
    /// Value, and change to the right, of that attribute.
    fn along_row(&mut self, i: usize, lane: usize, value: [f32; 2]);
}

/// The nodes of four rows of pixels, each of the slot that was last asked for: blocks of a run lie side by side.
#[derive(Default)]
pub(super) struct RowCache([Option<(u32, RowNodes)>; 4]);

impl RowCache {
    /// The nodes of a slot on a row; `None` for a triangle without.
    fn nodes(&mut self, setup: &TriangleSetup, slot: u32, y: u32) -> Option<&mut RowNodes> {
        let held = &mut self.0[y as usize % 4];
        let known = held
            .as_ref()
            .is_some_and(|(of, row)| *of == slot && row.is_of(y));
        if !known {
            *held = setup.row_nodes(y).map(|row| (slot, row));
        }
        held.as_mut().map(|(_, row)| row)
    }
}

impl AttributePlanes {
    /// Replaces the values of slots that f32 planes cannot serve. In blocks of several slots also those that are linear on the
    /// screen.
    #[inline(always)]
    pub(super) fn mend<I: Isa, const D: bool>(
        &self,
        i: I,
        part: Part,
        slots: &Slots<I>,
        wanted: [usize; 2],
        rows: &mut RowCache,
        values: &mut BlockValues<I>,
    ) {
        let rest = self.rest(i, slots, part);
        if let Rest::Wide(setup) | Rest::Rows(setup) = rest {
            let wide = wide_pixels(i, setup, part);
            values.inv_w = wide.inv_w();
            for (k, &attribute) in wanted.iter().enumerate() {
                if let Some([u, dx, dy]) = wide.attribute::<D>(attribute) {
                    (values.value[k], values.ddx[k], values.ddy[k]) = (u, dx, dy);
                }
            }
        }
        if let Rest::Nothing | Rest::Wide(_) = rest {
            return;
        }
        let mut spilt = values.spill();
        match rest {
            Rest::Rows(setup) => {
                let pixels = (part, part.mask(i));
                self.between_nodes(setup, slots.first, pixels, &wanted, rows, &mut spilt);
            }
            Rest::Pixels(lanes, odd) => {
                self.repair(i, (&lanes, odd), part, &wanted, rows, &mut spilt);
            }
            Rest::Nothing | Rest::Wide(_) => {}
        }
        *values = BlockValues::load(i, &spilt);
    }

    /// [`mend`](Self::mend) in the columns of a run, from index `place` on.
    #[inline(always)]
    pub(super) fn mend_columns<I: Isa, const D: bool>(
        &self,
        i: I,
        (place, part): (usize, Part),
        slots: &Slots<I>,
        wanted: &[usize],
        rows: &mut RowCache,
        out: &mut Columns<'_>,
    ) {
        let rest = self.rest(i, slots, part);
        if let Rest::Wide(setup) | Rest::Rows(setup) = rest {
            let wide = wide_pixels(i, setup, part);
            wide.inv_w().store(&mut out.inv_w[place..]);
            for (column, &k) in out.columns.iter_mut().zip(wanted) {
                if let Some(values) = wide.attribute::<D>(k) {
                    column.put::<I, D>(place, values);
                }
            }
        }
        let patch = &mut ColumnsAt(out, place);
        match rest {
            Rest::Nothing | Rest::Wide(_) => {}
            Rest::Rows(setup) => {
                let pixels = (part, part.mask(i));
                self.between_nodes(setup, slots.first, pixels, wanted, rows, patch);
            }
            Rest::Pixels(lanes, odd) => {
                self.repair(i, (&lanes, odd), part, wanted, rows, patch);
            }
        }
    }

    #[inline(always)]
    fn rest<I: Isa>(&self, i: I, slots: &Slots<I>, part: Part) -> Rest<'_> {
        if slots.one {
            match self.odd_setup(slots.first) {
                None => return Rest::Nothing,
                Some(setup) if setup.uses_rows() => return Rest::Rows(setup),
                Some(setup) => return Rest::Wide(setup),
            }
        }
        let mut lanes = [0; BLOCK_PIXELS];
        slots.each.store(&mut lanes);
        let mut odd = 0;
        if !self.setups.is_empty() {
            for (lane, &slot) in lanes[..I::LANES].iter().enumerate() {
                odd |= u32::from(self.odd_setup(slot).is_some()) << lane;
            }
        }
        odd &= part.mask(i);
        if odd != 0 || self.has_linear {
            Rest::Pixels(lanes, odd)
        } else {
            Rest::Nothing
        }
    }

    /// Replaces values pixel by pixel for [`mend`](Self::mend), in a function of its own.
    #[inline(never)]
    fn repair<I: Isa>(
        &self,
        i: I,
        (slots, odd): (&[u32; BLOCK_PIXELS], u32),
        part: Part,
        wanted: &[usize],
        rows: &mut RowCache,
        out: &mut dyn Patch,
    ) {
        if self.has_linear {
            i.vectorize(
                #[inline(always)]
                || self.replace_linear(i, slots, part, wanted, out),
            );
        }
        self.evaluate(slots, odd, part, wanted, rows, out);
    }

    /// Replaces attributes of the pixels of one slot that are linear between nodes of their rows.
    #[inline(never)]
    fn between_nodes(
        &self,
        setup: &TriangleSetup,
        slot: u32,
        (part, mask): (Part, u32),
        wanted: &[usize],
        rows: &mut RowCache,
        out: &mut dyn Patch,
    ) {
        for lane in (0..BLOCK_PIXELS).filter(|lane| mask >> lane & 1 == 1) {
            let (x, y) = pixel_of(usize::from(part.block.block), (part.at + lane) as u32);
            let (x, y) = (self.corner[0] + x, self.corner[1] + y);
            let Some(row) = rows.nodes(setup, slot, y) else {
                return;
            };
            setup.between_nodes(row, x, |attribute, value, ddx| {
                for (i, _) in wanted.iter().enumerate().filter(|(_, k)| **k == attribute) {
                    out.along_row(i, lane, [value, ddx]);
                }
            });
        }
    }

    /// The attributes of lanes that are linear on the screen.
    #[inline(always)]
    fn replace_linear<I: Isa>(
        &self,
        i: I,
        slots: &[u32; BLOCK_PIXELS],
        part: Part,
        wanted: &[usize],
        out: &mut dyn Patch,
    ) {
        let Some(words) = GatherTable::new(bytemuck::cast_slice(&self.words)) else {
            return;
        };
        let own = Own::new(i, self, words, i.load_u32(slots));
        let flags = slots.map(|slot| self.linear(slot));
        let [px, py] = part.centres(i);
        for (place, &k) in wanted.iter().enumerate() {
            let plane = RowPlane::<I>::new(own.plane(i, 1 + k), py);
            let [u, dx, dy] = plane.linear(px);
            let mut values = [[0.0; BLOCK_PIXELS]; 3];
            u.store(&mut values[0]);
            dx.store(&mut values[1]);
            dy.store(&mut values[2]);
            for lane in (0..I::LANES).filter(|lane| flags[*lane] >> k & 1 == 1) {
                out.attribute(place, lane, values.each_ref().map(|v| v[lane]));
            }
        }
    }

    /// The lanes `odd` by their triangles' full set-ups.
    fn evaluate(
        &self,
        slots: &[u32; BLOCK_PIXELS],
        odd: u32,
        part: Part,
        wanted: &[usize],
        rows: &mut RowCache,
        out: &mut dyn Patch,
    ) {
        let mut fragment = Fragment::default();
        for lane in (0..BLOCK_PIXELS).filter(|lane| odd >> lane & 1 == 1) {
            let Some(setup) = self.odd_setup(slots[lane]) else {
                continue;
            };
            let (x, y) = pixel_of(usize::from(part.block.block), (part.at + lane) as u32);
            let (x, y) = (self.corner[0] + x, self.corner[1] + y);
            let row = rows.nodes(setup, slots[lane], y);
            setup.evaluate_on(row, x, y, &mut fragment);
            out.inv_w(lane, fragment.inv_w);
            for (i, &k) in wanted.iter().enumerate() {
                let value = [fragment.values[k], fragment.ddx[k], fragment.ddy[k]];
                out.attribute(i, lane, value);
            }
        }
    }
}

#[inline(always)]
fn wide_pixels<I: Isa>(i: I, setup: &TriangleSetup, part: Part) -> WidePixels<'_, I> {
    let [px, py] = part.centres(i);
    WidePixels::new(i, setup, [i.widen(px), i.widen(py)])
}

//! Values of a block in lanes, and where they go.

use core::ops::Range;

use texmap_math::fearless_simd::{Simd, f32x16, prelude::*};
use texmap_math::lanes::LANES;

use super::planes::{OnRow, Pixels, PlaneSource};
use super::repair::Patch;
use super::{Column, RUN_ROOM, RunBlock};

/// Two attributes of the sixteen pixels of a block; those outside its mask hold no meaning.
#[derive(Clone, Copy)]
pub struct BlockValues<S: Simd> {
    /// 1 / clip w.
    pub inv_w: f32x16<S>,
    /// Values, in the order asked for.
    pub value: [f32x16<S>; 2],
    /// Change per pixel to the right.
    pub ddx: [f32x16<S>; 2],
    /// Change per pixel down.
    pub ddy: [f32x16<S>; 2],
}

impl<S: Simd> core::fmt::Debug for BlockValues<S> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("BlockValues")
    }
}

/// Takes the values of blocks: see [`TilePlanes::each_block`](crate::TilePlanes::each_block).
pub trait BlockSink<S: Simd> {
    /// The block at place `i` of the run.
    fn block(&mut self, s: S, i: usize, at: RunBlock, values: &BlockValues<S>);
}

impl<S: Simd> BlockValues<S> {
    /// By the planes of 1/w and of two attributes.
    #[inline(always)]
    pub(super) fn new<const D: bool>(
        s: S,
        [w, first, second]: [&OnRow<S>; 3],
        level: Option<[f32x16<S>; 2]>,
        px: f32x16<S>,
    ) -> Self {
        let pixels = Pixels::new(s, w, level, px);
        let [u, ux, uy] = pixels.attribute::<D>(first);
        let [v, vx, vy] = pixels.attribute::<D>(second);
        Self {
            inv_w: pixels.w,
            value: [u, v],
            ddx: [ux, vx],
            ddy: [uy, vy],
        }
    }

    #[inline(always)]
    pub(super) fn spill(&self) -> Spilt {
        let mut out = Spilt {
            inv_w: [0.0; LANES],
            columns: [[[0.0; LANES]; 3]; 2],
        };
        self.inv_w.store_slice(&mut out.inv_w);
        for (k, column) in out.columns.iter_mut().enumerate() {
            self.value[k].store_slice(&mut column[0]);
            self.ddx[k].store_slice(&mut column[1]);
            self.ddy[k].store_slice(&mut column[2]);
        }
        out
    }

    #[inline(always)]
    pub(super) fn load(s: S, from: &Spilt) -> Self {
        let [[u, ux, uy], [v, vx, vy]] = &from.columns;
        Self {
            inv_w: f32x16::from_slice(s, &from.inv_w),
            value: [f32x16::from_slice(s, u), f32x16::from_slice(s, v)],
            ddx: [f32x16::from_slice(s, ux), f32x16::from_slice(s, vx)],
            ddy: [f32x16::from_slice(s, uy), f32x16::from_slice(s, vy)],
        }
    }
}

/// [`BlockValues`] in memory: 1/w, and value and derivatives of each attribute.
pub(super) struct Spilt {
    inv_w: [f32; LANES],
    columns: [[[f32; LANES]; 3]; 2],
}

impl Patch for Spilt {
    fn inv_w(&mut self, bit: usize, value: f32) {
        self.inv_w[bit] = value;
    }

    fn attribute(&mut self, i: usize, bit: usize, value: [f32; 3]) {
        for (column, value) in self.columns[i].iter_mut().zip(value) {
            column[bit] = value;
        }
    }
}

/// The columns of a run, one for each attribute asked for.
pub(super) struct Columns<'a> {
    pub(super) inv_w: &'a mut [f32; RUN_ROOM],
    pub(super) columns: &'a mut [Column],
}

impl Columns<'_> {
    /// Stores the values of the block at place `i`, an attribute at a time: all together would not stay in registers.
    #[inline(always)]
    pub(super) fn put<S: Simd, P: PlaneSource<S>, const D: bool>(
        &mut self,
        s: S,
        i: usize,
        source: &P,
        [px, py]: [f32x16<S>; 2],
        wanted: &[usize],
    ) {
        let w = OnRow::new(source.plane(s, 0), py);
        let pixels = Pixels::new(s, &w, source.level(s), px);
        pixels.w.store_slice(&mut self.inv_w[lanes_of(i)]);
        for (column, &k) in self.columns.iter_mut().zip(wanted) {
            let plane = OnRow::new(source.plane(s, 1 + k), py);
            if source.is_linear(k) {
                column.put::<S, D>(i, plane.straight(px));
            } else {
                column.put::<S, D>(i, pixels.attribute::<D>(&plane));
            }
        }
    }
}

impl Column {
    /// Stores a block.
    #[inline(always)]
    pub(super) fn put<S: Simd, const D: bool>(&mut self, i: usize, [u, dx, dy]: [f32x16<S>; 3]) {
        u.store_slice(&mut self.value[lanes_of(i)]);
        if D {
            dx.store_slice(&mut self.ddx[lanes_of(i)]);
            dy.store_slice(&mut self.ddy[lanes_of(i)]);
        }
    }
}

/// The pixels of the block at place `i` of a run.
#[inline(always)]
pub(super) fn lanes_of(i: usize) -> Range<usize> {
    i * LANES..(i + 1) * LANES
}

/// A block of [`Columns`].
pub(super) struct ColumnsAt<'a, 'b>(pub(super) &'a mut Columns<'b>, pub(super) usize);

impl Patch for ColumnsAt<'_, '_> {
    fn inv_w(&mut self, bit: usize, value: f32) {
        self.0.inv_w[self.1 * LANES + bit] = value;
    }

    fn attribute(&mut self, i: usize, bit: usize, [u, dx, dy]: [f32; 3]) {
        let (column, place) = (&mut self.0.columns[i], self.1 * LANES + bit);
        column.value[place] = u;
        (column.ddx[place], column.ddy[place]) = (dx, dy);
    }
}

//! Values of a block in lanes, and where they go.

use texmap_math::simd::{Isa, prelude::*};

use super::f64_fallback::Patch;
use super::planes::PlaneSource;
use super::{BATCH_STRIDE, FragmentBlock, Varying};
use crate::coverage::stamp::BLOCK_PIXELS;
use crate::setup::planes::{Perspective, RowPlane};

/// Two attributes of pixels of a block, one in each lane; those outside its mask hold no meaning.
#[derive(Clone, Copy)]
pub struct BlockValues<I: Isa> {
    /// 1 / clip w.
    pub inv_w: I::F32,
    /// Values, in the order asked for.
    pub value: [I::F32; 2],
    /// Change per pixel to the right.
    pub ddx: [I::F32; 2],
    /// Change per pixel down.
    pub ddy: [I::F32; 2],
}

impl<I: Isa> core::fmt::Debug for BlockValues<I> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("BlockValues")
    }
}

/// Takes the values of blocks: see [`AttributePlanes::each_block`](crate::AttributePlanes::each_block).
pub trait BlockSink<I: Isa> {
    /// Pixels of block `at`, one in each lane. The first is at index `place` of the run, of which each block takes sixteen.
    fn pixels(&mut self, i: I, place: usize, at: FragmentBlock, values: &BlockValues<I>);
}

impl<I: Isa> BlockValues<I> {
    /// By the planes of 1/w and of two attributes.
    #[inline(always)]
    pub(super) fn new<const D: bool>(
        i: I,
        [w, first, second]: [&RowPlane<I>; 3],
        constant_w: Option<[I::F32; 2]>,
        px: I::F32,
    ) -> Self {
        let pixels = Perspective::new(i, w, constant_w, px);
        let [u, ux, uy] = pixels.attribute::<D>(first);
        let [v, vx, vy] = pixels.attribute::<D>(second);
        Self {
            inv_w: pixels.inv_w,
            value: [u, v],
            ddx: [ux, vx],
            ddy: [uy, vy],
        }
    }

    #[inline(always)]
    pub(super) fn spill(&self) -> Spilt {
        let mut out = Spilt {
            inv_w: [0.0; BLOCK_PIXELS],
            columns: [[[0.0; BLOCK_PIXELS]; 3]; 2],
        };
        self.inv_w.store(&mut out.inv_w);
        for (k, column) in out.columns.iter_mut().enumerate() {
            self.value[k].store(&mut column[0]);
            self.ddx[k].store(&mut column[1]);
            self.ddy[k].store(&mut column[2]);
        }
        out
    }

    #[inline(always)]
    pub(super) fn load(i: I, from: &Spilt) -> Self {
        let [[u, ux, uy], [v, vx, vy]] = &from.columns;
        Self {
            inv_w: i.load_f32(&from.inv_w),
            value: [i.load_f32(u), i.load_f32(v)],
            ddx: [i.load_f32(ux), i.load_f32(vx)],
            ddy: [i.load_f32(uy), i.load_f32(vy)],
        }
    }
}

/// [`BlockValues`] in memory: 1/w, and value and derivatives of each attribute.
pub(super) struct Spilt {
    inv_w: [f32; BLOCK_PIXELS],
    columns: [[[f32; BLOCK_PIXELS]; 3]; 2],
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

    fn along_row(&mut self, i: usize, bit: usize, [u, dx]: [f32; 2]) {
        let [value, ddx, _] = &mut self.columns[i];
        (value[bit], ddx[bit]) = (u, dx);
    }
}

/// The columns of a run, one for each attribute asked for.
pub(super) struct Columns<'a> {
    pub(super) inv_w: &'a mut [f32; BATCH_STRIDE],
    pub(super) columns: &'a mut [Varying],
}

impl Columns<'_> {
    /// Stores the values of pixels from index `place` on, an attribute at a time. All together would not stay in registers.
    #[inline(always)]
    pub(super) fn put<I: Isa, P: PlaneSource<I>, const D: bool>(
        &mut self,
        i: I,
        place: usize,
        source: &P,
        [px, py]: [I::F32; 2],
        wanted: &[usize],
    ) {
        let w = RowPlane::new(source.plane(i, 0), py);
        let pixels = Perspective::new(i, &w, source.constant_w(i), px);
        pixels.inv_w.store(&mut self.inv_w[place..]);
        for (column, &k) in self.columns.iter_mut().zip(wanted) {
            let plane = RowPlane::new(source.plane(i, 1 + k), py);
            if source.is_linear(k) {
                column.put::<I, D>(place, plane.linear(px));
            } else {
                column.put::<I, D>(place, pixels.attribute::<D>(&plane));
            }
        }
    }
}

impl Varying {
    /// Stores pixels from index `place` on.
    #[inline(always)]
    pub(super) fn put<I: Isa, const D: bool>(&mut self, place: usize, [u, dx, dy]: [I::F32; 3]) {
        u.store(&mut self.value[place..]);
        if D {
            dx.store(&mut self.ddx[place..]);
            dy.store(&mut self.ddy[place..]);
        }
    }
}

/// [`Columns`] from an index on.
pub(super) struct ColumnsAt<'a, 'b>(pub(super) &'a mut Columns<'b>, pub(super) usize);

impl Patch for ColumnsAt<'_, '_> {
    fn inv_w(&mut self, bit: usize, value: f32) {
        self.0.inv_w[self.1 + bit] = value;
    }

    fn attribute(&mut self, i: usize, bit: usize, [u, dx, dy]: [f32; 3]) {
        let (column, place) = (&mut self.0.columns[i], self.1 + bit);
        column.value[place] = u;
        (column.ddx[place], column.ddy[place]) = (dx, dy);
    }

    fn along_row(&mut self, i: usize, bit: usize, [u, dx]: [f32; 2]) {
        let (column, place) = (&mut self.0.columns[i], self.1 + bit);
        (column.value[place], column.ddx[place]) = (u, dx);
    }
}

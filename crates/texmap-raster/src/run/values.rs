//! Values of a block in lanes, and where they go.

use texmap_math::fearless_simd::{Simd, f32x16, prelude::*};
use texmap_math::lanes::LANES;

use super::{Column, RUN_ROOM, RunBlock};

/// Attributes of the sixteen pixels of a block; those outside its mask hold no meaning.
#[derive(Clone, Copy)]
pub struct BlockValues<S: Simd, const N: usize> {
    /// 1 / clip w.
    pub inv_w: f32x16<S>,
    /// Values, in the order asked for.
    pub value: [f32x16<S>; N],
    /// Change per pixel to the right.
    pub ddx: [f32x16<S>; N],
    /// Change per pixel down.
    pub ddy: [f32x16<S>; N],
}

impl<S: Simd, const N: usize> core::fmt::Debug for BlockValues<S, N> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("BlockValues")
    }
}

/// Takes the values of blocks: see [`TilePlanes::each_block`](crate::TilePlanes::each_block).
pub trait BlockSink<S: Simd, const N: usize> {
    /// The block at place `i` of the run.
    fn block(&mut self, s: S, i: usize, at: RunBlock, values: &BlockValues<S, N>);
}

/// [`BlockValues`] in memory: 1/w, and value and derivatives of each attribute.
pub(super) struct Spilt<const N: usize> {
    pub(super) inv_w: [f32; LANES],
    pub(super) columns: [[[f32; LANES]; 3]; N],
}

impl<S: Simd, const N: usize> BlockValues<S, N> {
    #[inline(always)]
    pub(super) fn zero(s: S) -> Self {
        let zero = f32x16::splat(s, 0.0);
        Self {
            inv_w: zero,
            value: [zero; N],
            ddx: [zero; N],
            ddy: [zero; N],
        }
    }

    #[inline(always)]
    pub(super) fn spill(&self) -> Spilt<N> {
        let mut out = Spilt {
            inv_w: [0.0; LANES],
            columns: [[[0.0; LANES]; 3]; N],
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
    pub(super) fn load(s: S, from: &Spilt<N>) -> Self {
        let mut out = Self::zero(s);
        out.inv_w = f32x16::from_slice(s, &from.inv_w);
        for (k, column) in from.columns.iter().enumerate() {
            out.value[k] = f32x16::from_slice(s, &column[0]);
            out.ddx[k] = f32x16::from_slice(s, &column[1]);
            out.ddy[k] = f32x16::from_slice(s, &column[2]);
        }
        out
    }
}

/// Stores values in the columns of a run.
pub(super) struct Columns<'a, const N: usize, const D: bool> {
    pub(super) inv_w: &'a mut [f32; RUN_ROOM],
    pub(super) columns: [&'a mut Column; N],
}

impl<S: Simd, const N: usize, const D: bool> BlockSink<S, N> for Columns<'_, N, D> {
    #[inline(always)]
    fn block(&mut self, _s: S, i: usize, _at: RunBlock, values: &BlockValues<S, N>) {
        let at = i * LANES..(i + 1) * LANES;
        values.inv_w.store_slice(&mut self.inv_w[at.clone()]);
        for (k, column) in self.columns.iter_mut().enumerate() {
            values.value[k].store_slice(&mut column.value[at.clone()]);
            if D {
                values.ddx[k].store_slice(&mut column.ddx[at.clone()]);
                values.ddy[k].store_slice(&mut column.ddy[at.clone()]);
            }
        }
    }
}

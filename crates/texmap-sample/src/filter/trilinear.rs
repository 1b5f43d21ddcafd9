//! Bilinear on the two mip levels around.

use super::{CellKernel, FilterKernel, Input, LookUp, bilinear::bilinear, cell::Cell};
use crate::{
    address::texel::LaneLevel,
    bound_texture::BoundTexture,
    fetch::{Color, mix, scaled, select},
};
use texmap_math::simd::{Isa, prelude::*};

/// Trilinear.
pub(crate) struct Trilinear<const FORMAT: u8>;

impl<const FORMAT: u8> FilterKernel for Trilinear<FORMAT> {
    const FORMAT: u8 = FORMAT;
    const INPUT: Input = Input::Level;

    #[inline(always)]
    fn color<I: Isa>(i: I, view: &BoundTexture<'_>, at: &LookUp<I>, lod: I::F32) -> Color<I> {
        let [u, v] = at.uv;
        trilinear::<I, FORMAT>(i, view, u, v, lod)
    }
}

/// [`Trilinear`] by cells: those of a vector on one level or two.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cells {
    fine: Cell,
    coarse: Cell,
    weight: [f32; 16],
    /// Some lane blends two levels.
    blends: bool,
}

impl CellKernel for Cells {
    const INPUT: Input = Input::Level;
    const ZERO: Self = Self {
        fine: Cell::ZERO,
        coarse: Cell::ZERO,
        weight: [0.0; 16],
        blends: false,
    };

    #[inline(always)]
    fn find<I: Isa>(&mut self, i: I, view: &BoundTexture<'_>, at: &LookUp<I>, lod: I::F32) {
        let levels = LevelPair::new(i, view, lod);
        self.fine.find_on(i, view, &levels.fine, at.uv);
        self.blends = levels.blends;
        if levels.blends {
            self.coarse.find_on(i, view, &levels.coarse, at.uv);
            levels.weight.store(&mut self.weight);
        }
    }

    #[inline(always)]
    fn readdress<I: Isa>(&mut self, i: I, format: u8) {
        self.fine.readdress(i, format);
        if self.blends {
            self.coarse.readdress(i, format);
        }
    }

    #[inline(always)]
    fn color<I: Isa, const FORMAT: u8>(&self, i: I, view: &BoundTexture<'_>) -> Color<I> {
        let c = self.fine.mixed::<I, FORMAT>(i, view);
        if !self.blends {
            return scaled::<I>(c, view);
        }
        let next = self.coarse.mixed::<I, FORMAT>(i, view);
        scaled::<I>(blend::<I>(view, c, next, i.load_f32(&self.weight)), view)
    }
}

/// A colour of the finer level and of the coarser; the finer alone where the other weighs nothing.
#[inline(always)]
fn blend<I: Isa>(
    view: &BoundTexture<'_>,
    fine: Color<I>,
    coarse: Color<I>,
    weight: I::F32,
) -> Color<I> {
    let two = weight.simd_gt(0.0);
    select::<I>(two, mix::<I>(view, fine, coarse, weight), fine)
}

/// Trilinear at a limited level of detail. `FORMAT` is the view's.
#[inline(always)]
pub fn trilinear<I: Isa, const FORMAT: u8>(
    i: I,
    view: &BoundTexture<'_>,
    u: I::F32,
    v: I::F32,
    lod: I::F32,
) -> Color<I> {
    let levels = LevelPair::new(i, view, lod);
    scaled::<I>(levels.sample::<FORMAT>(i, view, [u, v]), view)
}

/// The levels that each lane reads, found once and used by every probe.
pub(crate) struct LevelPair<I: Isa> {
    pub(crate) fine: LaneLevel<I>,
    pub(crate) coarse: LaneLevel<I>,
    pub(crate) weight: I::F32,
    /// Some lane blends two levels.
    pub(crate) blends: bool,
}

impl<I: Isa> LevelPair<I> {
    #[inline(always)]
    pub(crate) fn new(i: I, view: &BoundTexture<'_>, lod: I::F32) -> Self {
        let magnified = lod.simd_le(0.0);
        let last = i.f32(view.last as f32);
        let lod = lod.simd_gt(last).select(last, lod);
        let lod = magnified.select(i.f32(0.0), lod);
        let level = lod.to_i32();
        let weight = lod - level.to_f32();
        let [fine, coarse] = LaneLevel::pair(i, view, level);
        Self {
            fine,
            coarse,
            weight,
            blends: weight.simd_gt(0.0).any_true(),
        }
    }

    /// Unscaled.
    #[inline(always)]
    pub(crate) fn sample<const FORMAT: u8>(
        &self,
        i: I,
        view: &BoundTexture<'_>,
        uv: [I::F32; 2],
    ) -> Color<I> {
        let c = bilinear::<I, FORMAT>(i, view, &self.fine, uv);
        if !self.blends {
            return c;
        }
        let next = bilinear::<I, FORMAT>(i, view, &self.coarse, uv);
        blend::<I>(view, c, next, self.weight)
    }
}

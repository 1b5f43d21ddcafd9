//! OpenGL's choices of texels and levels: `mag` on level 0 where nothing is minified, else `min` and `mip`.

use super::{FilterKernel, Input, LookUp, bilinear::bilinear, nearest::nearest};
use crate::{
    address::texel::LaneLevel,
    bound_texture::{ANY, BoundTexture},
    fetch::{Color, mix, scaled, select},
    sampler::{Mip, TexelFilter},
};
use texmap_math::simd::{Isa, prelude::*};

/// Any of OpenGL's choices.
pub(crate) struct Gl;

impl FilterKernel for Gl {
    const FORMAT: u8 = ANY;
    const INPUT: Input = Input::Footprint;

    #[inline(always)]
    fn color<I: Isa>(i: I, view: &BoundTexture<'_>, at: &LookUp<I>, _: I::F32) -> Color<I> {
        let (mag, _, mip) = view.gl;
        // Without levels nothing depends on the level of detail but which of two choices of texels is taken.
        let lod = if mip == Mip::None && mag == view.gl.1 {
            i.f32(0.0)
        } else {
            at.lod(i, view)
        };
        let mut reads = Reads::new(i, view, lod);
        let mut color = [i.f32(0.0); 4];
        loop {
            if reads.lanes.any_true() {
                let level = LaneLevel::of(i, view, reads.level);
                let read = match reads.texel {
                    TexelFilter::Nearest => nearest::<I, ANY>(i, view, &level, at.uv),
                    TexelFilter::Linear => bilinear::<I, ANY>(i, view, &level, at.uv),
                };
                color = reads.onto(view, color, read);
            }
            if !reads.step() {
                return scaled::<I>(color, view);
            }
        }
    }
}

/// The reads of OpenGL's choices, one after the other, so that code that reads a level stands once: that of magnified lanes (if they
/// read other texels than the rest), that of the finer level of the rest, and that of the coarser.
pub(crate) struct Reads<I: Isa> {
    /// Lanes that read it, which texels, of which level.
    pub(crate) lanes: I::Mask,
    pub(crate) texel: TexelFilter,
    pub(crate) level: I::I32,
    /// 0, 1 or 2.
    count: u32,
    rest: I::Mask,
    min: TexelFilter,
    fine: I::I32,
    coarse: I::I32,
    /// The weight of the coarser level.
    weight: I::F32,
}

impl<I: Isa> Reads<I> {
    #[inline(always)]
    pub(crate) fn new(i: I, view: &BoundTexture<'_>, lod: I::F32) -> Self {
        let (mag, min, mip) = view.gl;
        let none = i.i32(0);
        let magnified = lod.simd_le(0.0);
        let top = i.f32(view.last as f32);
        let lod = lod.simd_gt(top).select(top, lod);
        let lod = magnified.select(i.f32(0.0), lod);
        let fine = match mip {
            Mip::None => none,
            // ceil(lod + 0.5) - 1: halves go to the finer level.
            Mip::Nearest => i.i32(-1) - (i.f32(-0.5) - lod).floor_to_i32(),
            Mip::Linear => lod.to_i32(),
        };
        let weight = match mip {
            Mip::Linear => lod - fine.to_f32(),
            _ => i.f32(0.0),
        };
        // If both filters are the same, magnified lanes are minified ones with level 0 as the finer level.
        let magnified = if mag == min { i.mask(false) } else { magnified };
        Self {
            lanes: magnified,
            texel: mag,
            level: none,
            count: 0,
            rest: !magnified,
            min,
            fine,
            coarse: (fine + 1).min(i.i32(view.last)),
            weight,
        }
    }

    /// On to the next; whether there is one.
    #[inline(always)]
    pub(crate) fn step(&mut self) -> bool {
        self.count += 1;
        self.texel = self.min;
        (self.lanes, self.level) = if self.count == 1 {
            (self.rest, self.fine)
        } else {
            (self.weight.simd_gt(0.0), self.coarse)
        };
        self.count < 3
    }

    /// The colours so far, and those that its lanes have read.
    #[inline(always)]
    pub(crate) fn onto(
        &self,
        view: &BoundTexture<'_>,
        color: Color<I>,
        read: Color<I>,
    ) -> Color<I> {
        let read = if self.count == 2 {
            mix::<I>(view, color, read, self.weight)
        } else {
            read
        };
        select::<I>(self.lanes, read, color)
    }
}

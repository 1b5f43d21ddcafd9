//! OpenGL's choices of texels and levels: `mag` on level 0 where nothing is minified, else `min` and `mip`. In f32, then in bytes.

use super::{
    ANY, At, View,
    float::{self, Color},
    packed,
};
use crate::sampler::{Mip, Texel};
use texmap_math::{
    fearless_simd::{f32x16, i32x16, mask32x16, prelude::*, u32x16},
    lanes::floor_to_i32,
};

/// OpenGL's choice of texels and levels for sixteen lanes, scaled: `mag` on level 0 where nothing is minified, else `min` and `mip`.
#[inline(always)]
pub fn float_lanes<S: Simd>(
    s: S,
    view: &View<'_>,
    gl: (Texel, Texel, Mip),
    [u, v]: [f32x16<S>; 2],
    lod: f32x16<S>,
) -> Color<S> {
    let mut reads = Reads::new(s, view, gl, lod);
    let mut color = [f32x16::splat(s, 0.0); 4];
    loop {
        if reads.lanes.any_true() {
            let at = At::of(s, view, reads.level);
            let read = match reads.texel {
                Texel::Nearest => float::nearest_at::<S, ANY>(s, view, &at, u, v),
                Texel::Linear => float::bilinear_at::<S, ANY>(s, view, &at, u, v),
            };
            color = reads.onto(view, color, read);
        }
        if !reads.step() {
            return float::scaled(color, view);
        }
    }
}

/// What OpenGL's choices read, one after the other, so that code that reads a level stands once: what magnified lanes read (if they
/// read other texels than the rest), the finer level of the rest, and the coarser.
pub(crate) struct Reads<S: Simd> {
    /// Which lanes read it, which texels, of which level.
    pub(crate) lanes: mask32x16<S>,
    pub(crate) texel: Texel,
    pub(crate) level: i32x16<S>,
    /// 0, 1 or 2.
    count: u32,
    rest: mask32x16<S>,
    min: Texel,
    fine: i32x16<S>,
    coarse: i32x16<S>,
    /// The share of the coarser level.
    weight: f32x16<S>,
    /// Lanes that it has a share in.
    two: mask32x16<S>,
}

impl<S: Simd> Reads<S> {
    #[inline(always)]
    pub(crate) fn new(
        s: S,
        view: &View<'_>,
        (mag, min, mip): (Texel, Texel, Mip),
        lod: f32x16<S>,
    ) -> Self {
        let (zero, none) = (f32x16::splat(s, 0.0), i32x16::splat(s, 0));
        let magnified = lod.simd_le(zero);
        let top = f32x16::splat(s, view.last as f32);
        let lod = lod.simd_gt(top).select(top, lod);
        let lod = magnified.select(zero, lod);
        let fine = match mip {
            Mip::None => none,
            // ceil(lod + 0.5) - 1: halves go to the finer level.
            Mip::Nearest => -1 - floor_to_i32(s, -0.5 - lod),
            Mip::Linear => lod.to_int::<i32x16<S>>(),
        };
        let weight = match mip {
            Mip::Linear => lod - fine.to_float::<f32x16<S>>(),
            _ => zero,
        };
        // What magnifies with the same texels reads level 0 as its fine one.
        let magnified = if mag == min {
            mask32x16::splat(s, false)
        } else {
            magnified
        };
        let last = i32x16::splat(s, view.last);
        let coarse = fine + 1;
        Self {
            lanes: magnified,
            texel: mag,
            level: none,
            count: 0,
            rest: !magnified,
            min,
            fine,
            coarse: coarse.simd_gt(last).select(last, coarse),
            weight,
            two: weight.simd_gt(zero),
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
            (self.two, self.coarse)
        };
        self.count < 3
    }

    /// The colours so far, and those that its lanes have read.
    #[inline(always)]
    pub(crate) fn onto(&self, view: &View<'_>, color: Color<S>, read: Color<S>) -> Color<S> {
        let read = if self.count == 2 {
            float::mix(view, color, read, self.weight)
        } else {
            read
        };
        float::select(self.lanes, read, color)
    }
}

/// [`float_lanes`] with weights of a byte; `lod` has 8 fraction bits.
#[inline(always)]
pub fn byte_lanes<S: Simd>(
    s: S,
    view: &View<'_>,
    (mag, min, mip): (Texel, Texel, Mip),
    [u, v]: [f32x16<S>; 2],
    lod: i32x16<S>,
) -> u32x16<S> {
    let zero = i32x16::splat(s, 0);
    let magnified = lod.simd_le(zero);
    let (last, top) = (
        i32x16::splat(s, view.last),
        i32x16::splat(s, view.last << 8),
    );
    let lod = lod.simd_gt(top).select(top, lod);
    let lod = magnified.select(zero, lod);
    let (fine, weight) = match mip {
        Mip::None => (zero, zero),
        // ceil(lod + 1/2) - 1: halves go to the finer level.
        Mip::Nearest => ((lod + 127) >> 8, zero),
        Mip::Linear => (lod >> 8, lod & 255),
    };
    let next = fine + 1;
    let next = next.simd_gt(last).select(last, next);
    // One place in the code for all that may be read.
    let reads = [
        (magnified.any_true(), mag, zero),
        (!magnified.all_true(), min, fine),
        (weight.simd_gt(zero).any_true(), min, next),
    ];
    let mut texels = [u32x16::splat(s, 0); 3];
    for (to, (wanted, texel, level)) in texels.iter_mut().zip(&reads) {
        if *wanted {
            let at = At::of(s, view, *level);
            *to = match texel {
                Texel::Nearest => packed::nearest_at(s, view, &at, u, v),
                Texel::Linear => packed::join(packed::bilinear_at::<S>(s, view, &at, u, v)),
            };
        }
    }
    let [near, fine, coarse] = texels;
    let far = packed::lerp_lanes(
        s,
        packed::halves(fine),
        packed::halves(coarse),
        packed::spread(weight),
    );
    magnified.select(near, packed::join(far))
}

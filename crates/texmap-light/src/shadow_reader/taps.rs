//! The common part of look-ups in flat maps and in cubes: a bias, and comparisons around a texel of a face.

use texmap_math::simd::{Isa, prelude::*};

use crate::lanes::Vector;
use crate::shadow::STEEP;
use crate::shadow_bounds::{ShadowBounds, radius};
use crate::vector::{add, scale};
use crate::{ShadowBias, ShadowMap};

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Bias {
    Planes(f32),
    Constant(f32),
    Slope(f32),
    /// Offset along the normal, in texels.
    NormalOffset(f32),
}

/// The comparisons of a look-up.
#[derive(Clone, Debug)]
pub(super) struct Taps {
    /// Texels a side of a face.
    pub(super) size: i32,
    /// Radius in texels within which depths are compared.
    pub(super) radius: i32,
    pub(super) bounds: ShadowBounds,
    pub(super) bias: Bias,
    /// Number of comparisons that are ignored if they contradict all others.
    outliers: f32,
}

/// The receiver's depth at the comparisons around a texel.
pub(super) struct Receiver<I: Isa> {
    depth: I::F32,
    /// Change of the depth per texel right and down.
    slope: [I::F32; 2],
    /// Vector from the receiver to the middle of its texel.
    middle: [I::F32; 2],
    /// True if the majority of the comparisons decides.
    steep: I::Mask,
}

impl<I: Isa> Receiver<I> {
    /// Depths of a receiver at `place` (texels) in the texel whose column and row are `texel`. Its depth changes by `slope` per texel,
    /// at most by `steepest`.
    #[inline(always)]
    pub(super) fn new(
        i: I,
        depth: I::F32,
        slope: [I::F32; 2],
        steepest: I::F32,
        place: [I::F32; 2],
        texel: [I::I32; 2],
    ) -> Self {
        let largest = slope[0].abs().above(slope[1].abs());
        let mut out = Self {
            depth,
            slope,
            middle: place,
            steep: largest.simd_gt(steepest * STEEP),
        };
        for k in 0..2 {
            out.slope[k] = slope[k].below(steepest).above(-steepest);
            out.middle[k] = i.f32(0.5) - (place[k] - texel[k].to_f32());
        }
        out
    }

    /// Depths that are one depth at all comparisons.
    #[inline(always)]
    pub(super) fn level(i: I, depth: I::F32) -> Self {
        Self {
            depth,
            slope: [i.f32(0.0); 2],
            middle: [i.f32(0.0); 2],
            steep: i.f32(0.0).simd_gt(0.0),
        }
    }

    /// Depth of the receiver at the texel `di` columns and `dj` rows away. With `PLANES` it is that of the receiver's plane where that
    /// is nearer to the light, else one depth.
    #[inline(always)]
    pub(super) fn at<const PLANES: bool>(&self, i: I, di: i32, dj: i32) -> I::F32 {
        if !PLANES {
            return self.depth;
        }
        let change = self.slope[0] * (self.middle[0] + di as f32)
            + self.slope[1] * (self.middle[1] + dj as f32);
        self.depth + change.below(i.f32(0.0))
    }

    /// Not above any depth within `radius` texels, to the last bit: rounding keeps order.
    #[inline(always)]
    pub(super) fn least(&self, radius: i32) -> I::F32 {
        let reach = radius as f32 + 0.5;
        let [across, down] = [self.slope[0].abs() * reach, self.slope[1].abs() * reach];
        self.depth + (-across - down)
    }
}

impl Taps {
    pub(super) fn new(
        map: &ShadowMap,
        bias: ShadowBias,
        taps: u32,
        bounds: Option<ShadowBounds>,
    ) -> Self {
        Self {
            size: map.size() as i32,
            radius: radius(taps) as i32,
            bounds: ShadowBounds::fitting(bounds, map.depths(), map.size() as usize, taps),
            outliers: bias.outliers(taps) as f32,
            bias: match bias {
                ShadowBias::Planes(constant) => Bias::Planes(constant as f32),
                ShadowBias::Constant(constant) => Bias::Constant(constant as f32),
                ShadowBias::Slope(constant) => Bias::Slope(constant as f32),
                ShadowBias::NormalOffset(texels) => Bias::NormalOffset(texels as f32),
            },
        }
    }

    /// Number of comparisons.
    fn count(&self) -> f32 {
        let side = (2 * self.radius + 1) as f32;
        side * side
    }

    /// Fraction of the light that reaches a receiver, by the number of comparisons that pass.
    #[inline(always)]
    pub(super) fn share<I: Isa>(&self, i: I, receiver: &Receiver<I>, lit: I::F32) -> I::F32 {
        let share = (lit - self.outliers) / (self.count() - 2.0 * self.outliers);
        let most = lit
            .simd_gt(0.5 * self.count())
            .select(i.f32(1.0), i.f32(0.0));
        receiver
            .steep
            .select(most, share.clamp(i.f32(0.0), i.f32(1.0)))
    }

    /// Texels that lie on their face.
    #[inline(always)]
    pub(super) fn holds<I: Isa>(&self, _: I, i: I::I32, j: I::I32) -> I::Mask {
        inside::<I>(0, self.size, i, j)
    }

    /// Texels whose comparisons all lie on their face.
    #[inline(always)]
    pub(super) fn holds_around<I: Isa>(&self, _: I, x: I::I32, y: I::I32) -> I::Mask {
        inside::<I>(self.radius, self.size - self.radius, x, y)
    }

    /// Addition to the bias for a slope of the receiver's depth per texel, over half the width of all comparisons.
    #[inline(always)]
    pub(super) fn over<I: Isa>(&self, i: I, slope: I::F32) -> I::F32 {
        slope.below(i.f32(f32::MAX)) * (self.radius as f32 + 0.5)
    }
}

/// Points moved along their normals.
#[inline(always)]
pub(super) fn moved<I: Isa>(_: I, point: Vector<I>, normal: Vector<I>, step: I::F32) -> Vector<I> {
    add(point, scale(normal, step))
}

#[inline(always)]
fn inside<I: Isa>(low: i32, high: i32, x: I::I32, y: I::I32) -> I::Mask {
    x.simd_ge(low) & x.simd_lt(high) & y.simd_ge(low) & y.simd_lt(high)
}

//! What look-ups in flat maps and in cubes have in common: a bias, and comparisons around a texel of a face.

use texmap_math::fearless_simd::{Simd, f32x16, i32x16, mask32x16, prelude::*};

use crate::lanes::V3;
use crate::shadow_bounds::{ShadowBounds, radius};
use crate::{ShadowBias, ShadowMap};

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Bias {
    Constant(f32),
    Slope(f32),
    /// In texels.
    NormalOffset(f32),
}

/// The comparisons of a look-up.
#[derive(Clone, Debug)]
pub(super) struct Taps {
    /// Texels a side of a face.
    pub(super) size: i32,
    /// How far around a texel depths are compared.
    pub(super) radius: i32,
    pub(super) bounds: ShadowBounds,
    pub(super) bias: Bias,
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
            bias: match bias {
                ShadowBias::Constant(constant) => Bias::Constant(constant as f32),
                ShadowBias::Slope(constant) => Bias::Slope(constant as f32),
                ShadowBias::NormalOffset(texels) => Bias::NormalOffset(texels as f32),
            },
        }
    }

    /// How many there are.
    pub(super) fn count(&self) -> f32 {
        let side = (2 * self.radius + 1) as f32;
        side * side
    }

    /// Whether a texel lies on its face.
    pub(super) fn holds(&self, i: i32, j: i32) -> bool {
        i >= 0 && j >= 0 && i < self.size && j < self.size
    }

    /// [`holds`](Self::holds) for sixteen.
    #[inline(always)]
    pub(super) fn holds_lanes<S: Simd>(&self, s: S, i: i32x16<S>, j: i32x16<S>) -> mask32x16<S> {
        inside(s, 0, self.size, i, j)
    }

    /// Texels whose comparisons all lie on their face.
    #[inline(always)]
    pub(super) fn hold_lanes<S: Simd>(&self, s: S, x: i32x16<S>, y: i32x16<S>) -> mask32x16<S> {
        inside(s, self.radius, self.size - self.radius, x, y)
    }

    /// What a slope of the receiver's depth per texel adds over half the width of all comparisons.
    pub(super) fn over(&self, slope: f32) -> f32 {
        let slope = if slope < f32::MAX { slope } else { f32::MAX };
        (self.radius as f32 + 0.5) * slope
    }

    /// [`over`](Self::over) for sixteen.
    #[inline(always)]
    pub(super) fn over_lanes<S: Simd>(&self, s: S, slope: f32x16<S>) -> f32x16<S> {
        let most = f32x16::splat(s, f32::MAX);
        let slope = slope.simd_lt(most).select(slope, most);
        slope * (self.radius as f32 + 0.5)
    }
}

/// A point moved along its normal.
pub(super) fn moved(point: [f32; 3], normal: [f32; 3], step: f32) -> [f32; 3] {
    [0, 1, 2].map(|i| point[i] + normal[i] * step)
}

/// [`moved`] for sixteen.
#[inline(always)]
pub(super) fn moved_lanes<S: Simd>(point: V3<S>, normal: V3<S>, step: f32x16<S>) -> V3<S> {
    [
        point[0] + normal[0] * step,
        point[1] + normal[1] * step,
        point[2] + normal[2] * step,
    ]
}

#[inline(always)]
fn inside<S: Simd>(s: S, low: i32, high: i32, x: i32x16<S>, y: i32x16<S>) -> mask32x16<S> {
    let (low, high) = (i32x16::splat(s, low), i32x16::splat(s, high));
    x.simd_ge(low) & x.simd_lt(high) & y.simd_ge(low) & y.simd_lt(high)
}

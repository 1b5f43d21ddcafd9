//! What look-ups in flat maps and in cubes have in common: a bias, and comparisons around a texel of a face.

use texmap_math::fearless_simd::{Simd, f32x16, i32x16, mask32x16, prelude::*};
use texmap_math::lanes::{above, below};

use crate::lanes::V3;
use crate::shadow_bounds::{ShadowBounds, radius};
use crate::{ShadowBias, ShadowMap};

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Bias {
    Planes(f32),
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
    /// Comparisons that say nothing where they contradict all others.
    stray: f32,
}

/// The receiver's depth at the comparisons around a texel.
pub(super) struct Receiver {
    depth: f32,
    /// Change of the depth per texel right and down.
    slope: [f32; 2],
    /// From the receiver to the middle of its texel.
    middle: [f32; 2],
}

/// [`Receiver`] in each lane.
pub(super) struct ReceiverLanes<S: Simd> {
    depth: f32x16<S>,
    slope: [f32x16<S>; 2],
    middle: [f32x16<S>; 2],
}

impl Receiver {
    /// `slope` per texel, `steepest` at most, of a receiver at `place` (texels) in the texel whose column and row are `texel`.
    pub(super) fn new(
        depth: f32,
        slope: [f32; 2],
        steepest: f32,
        place: [f32; 2],
        texel: [i32; 2],
    ) -> Self {
        Self {
            depth,
            slope: slope.map(|c| {
                let c = if c < steepest { c } else { steepest };
                if c > -steepest { c } else { -steepest }
            }),
            middle: [0, 1].map(|k| 0.5 - (place[k] - texel[k] as f32)),
        }
    }

    /// Of one depth.
    pub(super) fn level(depth: f32) -> Self {
        Self {
            depth,
            slope: [0.0; 2],
            middle: [0.0; 2],
        }
    }

    /// At the texel `i` columns and `j` rows away: on its plane where that is nearer to the light.
    pub(super) fn at(&self, i: i32, j: i32) -> f32 {
        let [across, down] = [i, j].map(|c| c as f32);
        let change =
            self.slope[0] * (across + self.middle[0]) + self.slope[1] * (down + self.middle[1]);
        self.depth + if change < 0.0 { change } else { 0.0 }
    }
}

impl<S: Simd> ReceiverLanes<S> {
    /// [`Receiver::new`] for sixteen.
    #[inline(always)]
    pub(super) fn new(
        depth: f32x16<S>,
        slope: [f32x16<S>; 2],
        steepest: f32x16<S>,
        place: [f32x16<S>; 2],
        texel: [i32x16<S>; 2],
    ) -> Self {
        let mut out = Self {
            depth,
            slope,
            middle: place,
        };
        for k in 0..2 {
            out.slope[k] = above(below(slope[k], steepest), -steepest);
            out.middle[k] = 0.5 - (place[k] - texel[k].to_float::<f32x16<S>>());
        }
        out
    }

    /// Of one depth.
    #[inline(always)]
    pub(super) fn level(s: S, depth: f32x16<S>) -> Self {
        let zero = f32x16::splat(s, 0.0);
        Self {
            depth,
            slope: [zero; 2],
            middle: [zero; 2],
        }
    }

    /// [`Receiver::at`] for sixteen; its one depth unless `PLANES`.
    #[inline(always)]
    pub(super) fn at<const PLANES: bool>(&self, s: S, i: i32, j: i32) -> f32x16<S> {
        if !PLANES {
            return self.depth;
        }
        let change = self.slope[0] * (self.middle[0] + i as f32)
            + self.slope[1] * (self.middle[1] + j as f32);
        self.depth + below(change, f32x16::splat(s, 0.0))
    }

    /// Not above any depth within `radius` texels, to the last bit: rounding keeps order.
    #[inline(always)]
    pub(super) fn least(&self, radius: i32) -> f32x16<S> {
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
            stray: bias.stray(taps) as f32,
            bias: match bias {
                ShadowBias::Planes(constant) => Bias::Planes(constant as f32),
                ShadowBias::Constant(constant) => Bias::Constant(constant as f32),
                ShadowBias::Slope(constant) => Bias::Slope(constant as f32),
                ShadowBias::NormalOffset(texels) => Bias::NormalOffset(texels as f32),
            },
        }
    }

    /// How many there are.
    fn count(&self) -> f32 {
        let side = (2 * self.radius + 1) as f32;
        side * side
    }

    /// The share of the light that `lit` comparisons leave.
    pub(super) fn share(&self, lit: f32) -> f32 {
        let share = (lit - self.stray) / (self.count() - 2.0 * self.stray);
        let share = if share > 0.0 { share } else { 0.0 };
        if share < 1.0 { share } else { 1.0 }
    }

    /// [`share`](Self::share) for sixteen.
    #[inline(always)]
    pub(super) fn share_lanes<S: Simd>(&self, s: S, lit: f32x16<S>) -> f32x16<S> {
        let of = f32x16::splat(s, self.count() - 2.0 * self.stray);
        let share = (lit - self.stray) / of;
        below(above(share, f32x16::splat(s, 0.0)), f32x16::splat(s, 1.0))
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

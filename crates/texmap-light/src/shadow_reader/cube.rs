//! Look-ups in the six faces around a point light.

use texmap_math::fearless_simd::{Simd, f32x16, i32x16, mask32x16, prelude::*, u32x16};
use texmap_math::float::sqrt_f32;
use texmap_math::glam::DVec3;
use texmap_math::lanes::{Words, floor_to_i32, floor_to_i32_scalar, gather};

use super::Bias;
use crate::ShadowMap;
use crate::cube_face::{Side, along, direction_of, face_of};
use crate::lanes::V3;
use crate::shadow_bounds::{ShadowBounds, radius};
use crate::vector::{spread, sub, sub_lanes, usable_lanes};

/// A map of six faces.
#[derive(Clone, Debug)]
pub(super) struct Cube {
    position: [f32; 3],
    size: i32,
    bounds: ShadowBounds,
    bias: Bias,
    radius: i32,
}

/// Where a point falls.
struct Place {
    face: usize,
    /// The ray to it: right and down on its face, of which the axis is 1.
    ray: [f32; 2],
    /// Distance along that axis.
    major: f32,
}

/// [`Place`] in each lane.
struct PlaceLanes<S: Simd> {
    side: Side<S>,
    ray: [f32x16<S>; 2],
    major: f32x16<S>,
}

impl Cube {
    pub(super) fn new(
        map: &ShadowMap,
        position: DVec3,
        bias: Bias,
        taps: u32,
        bounds: Option<ShadowBounds>,
    ) -> Self {
        Self {
            position: position.to_array().map(|c| c as f32),
            size: map.size() as i32,
            bounds: ShadowBounds::fitting(bounds, map.depths(), map.size() as usize, taps),
            bias,
            radius: radius(taps) as i32,
        }
    }

    pub(super) fn lit(&self, depths: &[f32], point: [f32; 3], normal: [f32; 3]) -> f32 {
        let Some(mut place) = self.place(point) else {
            return 1.0;
        };
        if let Bias::NormalOffset(texels) = self.bias {
            let step = texels * (place.major * self.step());
            match self.place([0, 1, 2].map(|i| point[i] + normal[i] * step)) {
                Some(moved) => place = moved,
                None => return 1.0,
            }
        }
        let Place { face, ray, major } = place;
        let square = ray[0] * ray[0] + ray[1] * ray[1] + 1.0;
        let depth = major * sqrt_f32(square);
        let add = match self.bias {
            Bias::Constant(constant) => constant,
            Bias::NormalOffset(_) => 1e-4 * (major * self.step()),
            Bias::Slope(constant) => {
                // distance = c |ray| / n.ray on the receiver's plane.
                let [right, down, axis] = along(face, normal);
                let facing = right * ray[0] + down * ray[1] + axis;
                let slope = (ray[0] / square - right / facing).abs()
                    + (ray[1] / square - down / facing).abs();
                let slope = slope * (depth * self.step());
                let slope = if slope < f32::MAX { slope } else { f32::MAX };
                (self.radius as f32 + 0.5) * slope + constant
            }
        };
        let reference = depth - add;
        let [x, y] = ray.map(|c| self.texel(c));
        let mut lit = 0.0;
        for j in y - self.radius..=y + self.radius {
            for i in x - self.radius..=x + self.radius {
                if reference <= depths[self.index(face, i, j)] {
                    lit += 1.0;
                }
            }
        }
        lit / self.count()
    }

    /// `None` for points at the light, and those that are not finite.
    fn place(&self, point: [f32; 3]) -> Option<Place> {
        let d = sub(point, self.position);
        let finite = d.iter().all(|c| c.is_finite());
        if !finite || d == [0.0; 3] {
            return None;
        }
        let face = face_of(d);
        let [right, down, major] = along(face, d);
        Some(Place {
            face,
            ray: [right / major, down / major],
            major,
        })
    }

    /// Column or row of a coordinate in -1..=1 of a face.
    fn texel(&self, c: f32) -> i32 {
        let n = self.size as f32;
        let i = floor_to_i32_scalar((c * 0.5 + 0.5) * n);
        if i < self.size { i } else { self.size - 1 }
    }

    /// Where a texel's depth is stored. One beyond an edge of its face lies on a neighbour: all faces store distances, so that they compare.
    fn index(&self, face: usize, i: i32, j: i32) -> usize {
        let inside = i >= 0 && j >= 0 && i < self.size && j < self.size;
        let (face, i, j) = if inside {
            (face, i, j)
        } else {
            let centre = |i: i32| (i as f32 + 0.5) * self.step() - 1.0;
            let d = direction_of(face, [centre(i), centre(j), 1.0]);
            let face = face_of(d);
            let [right, down, major] = along(face, d);
            (face, self.texel(right / major), self.texel(down / major))
        };
        ((face as i32 * self.size + j) * self.size + i) as usize
    }

    /// Width of a texel on a face of which the axis is 1.
    fn step(&self) -> f32 {
        2.0 / self.size as f32
    }

    fn count(&self) -> f32 {
        let side = (2 * self.radius + 1) as f32;
        side * side
    }

    #[inline(always)]
    pub(super) fn lit_lanes<S: Simd>(
        &self,
        s: S,
        words: Words<'_>,
        asked: mask32x16<S>,
        point: V3<S>,
        normal: V3<S>,
    ) -> f32x16<S> {
        let (zero, one) = (f32x16::splat(s, 0.0), f32x16::splat(s, 1.0));
        let (mut place, mut inside) = self.place_lanes(s, point);
        if let Bias::NormalOffset(texels) = self.bias {
            let step = place.major * self.step() * texels;
            let moved = [
                point[0] + normal[0] * step,
                point[1] + normal[1] * step,
                point[2] + normal[2] * step,
            ];
            let (there, holds) = self.place_lanes(s, moved);
            place = there;
            inside &= holds;
        }
        if !(inside & asked).any_true() {
            return one;
        }
        let PlaceLanes { side, ray, major } = place;
        let square = ray[0] * ray[0] + ray[1] * ray[1] + 1.0;
        let depth = major * square.sqrt();
        let add = match self.bias {
            Bias::Constant(constant) => f32x16::splat(s, constant),
            Bias::NormalOffset(_) => major * self.step() * 1e-4,
            Bias::Slope(constant) => {
                let [right, down, axis] = side.along(normal);
                let facing = right * ray[0] + down * ray[1] + axis;
                let slope = (ray[0] / square - right / facing).abs()
                    + (ray[1] / square - down / facing).abs();
                let slope = slope * (depth * self.step());
                let most = f32x16::splat(s, f32::MAX);
                let slope = slope.simd_lt(most).select(slope, most);
                slope * (self.radius as f32 + 0.5) + constant
            }
        };
        let reference = depth - add;
        let face = side.face(s);
        let (x, y) = (self.texel_lanes(s, ray[0]), self.texel_lanes(s, ray[1]));
        let r = self.radius;
        let (low, high) = (i32x16::splat(s, r), i32x16::splat(s, self.size - r));
        let within = x.simd_ge(low) & x.simd_lt(high) & y.simd_ge(low) & y.simd_lt(high);
        // Bounds know nothing of what lies beyond an edge.
        let [least, most] = self.bounds.around(s, face, x, y);
        let (all, none) = (reference.simd_le(least), reference.simd_gt(most));
        if (within & (all | none) | !(inside & asked)).all_true() {
            return (inside & none).select(zero, one);
        }
        let lit = if within.all_true() {
            self.taps_lanes::<S, true>(s, words, &side, [x, y], reference)
        } else {
            self.taps_lanes::<S, false>(s, words, &side, [x, y], reference)
        };
        inside.select(lit / f32x16::splat(s, self.count()), one)
    }

    /// [`place`](Self::place) for sixteen, and where there is one; elsewhere it is that of a point along +Z.
    #[inline(always)]
    fn place_lanes<S: Simd>(&self, s: S, point: V3<S>) -> (PlaceLanes<S>, mask32x16<S>) {
        let (d, holds) = usable_lanes(s, sub_lanes(point, spread(s, self.position)));
        let side = Side::of(s, d);
        let [right, down, major] = side.along(d);
        let place = PlaceLanes {
            side,
            ray: [right / major, down / major],
            major,
        };
        (place, holds)
    }

    #[inline(always)]
    fn texel_lanes<S: Simd>(&self, s: S, c: f32x16<S>) -> i32x16<S> {
        let i = floor_to_i32(s, (c * 0.5 + 0.5) * self.size as f32);
        let last = i32x16::splat(s, self.size - 1);
        i.simd_lt(last).select(i, last)
    }

    /// Comparisons that pass; all taps lie on the faces of their points if `WITHIN`.
    #[inline(always)]
    fn taps_lanes<S: Simd, const WITHIN: bool>(
        &self,
        s: S,
        words: Words<'_>,
        side: &Side<S>,
        [x, y]: [i32x16<S>; 2],
        reference: f32x16<S>,
    ) -> f32x16<S> {
        let (zero, one) = (f32x16::splat(s, 0.0), f32x16::splat(s, 1.0));
        let (first, size) = (i32x16::splat(s, 0), i32x16::splat(s, self.size));
        let face = side.face(s);
        let mut lit = zero;
        for dj in -self.radius..=self.radius {
            let j = y + dj;
            for di in -self.radius..=self.radius {
                let i = x + di;
                let mut index = (face * self.size + j) * self.size + i;
                if !WITHIN {
                    let inside = i.simd_ge(first) & j.simd_ge(first);
                    let inside = inside & i.simd_lt(size) & j.simd_lt(size);
                    let beyond = self.beyond_lanes(s, side, [i, j]);
                    index = inside.select(index, beyond);
                }
                let index: u32x16<S> = index.bitcast();
                let stored: f32x16<S> = gather(s, words, index).bitcast();
                lit += reference.simd_le(stored).select(one, zero);
            }
        }
        lit
    }

    /// [`index`](Self::index) for sixteen texels beyond the edges of their faces.
    #[inline(always)]
    fn beyond_lanes<S: Simd>(&self, s: S, side: &Side<S>, [i, j]: [i32x16<S>; 2]) -> i32x16<S> {
        let step = self.step();
        let right = (i.to_float::<f32x16<S>>() + 0.5) * step - 1.0;
        let down = (j.to_float::<f32x16<S>>() + 0.5) * step - 1.0;
        let d = side.direction([right, down, f32x16::splat(s, 1.0)]);
        let side = Side::of(s, d);
        let [right, down, major] = side.along(d);
        let (i, j) = (
            self.texel_lanes(s, right / major),
            self.texel_lanes(s, down / major),
        );
        (side.face(s) * self.size + j) * self.size + i
    }
}

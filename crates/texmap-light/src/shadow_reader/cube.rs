//! Look-ups in the six faces around a point light.

use texmap_math::fearless_simd::{Simd, f32x16, i32x16, mask32x16, prelude::*, u32x16};
use texmap_math::float::sqrt_f32;
use texmap_math::glam::DVec3;
use texmap_math::lanes::{Words, floor_to_i32, floor_to_i32_scalar, gather};

use super::taps::{Bias, Taps, moved, moved_lanes};
use crate::cube_face::{Side, along, direction_of, face_of};
use crate::lanes::V3;
use crate::vector::{is_usable, narrow, spread, sub, sub_lanes, usable_lanes};

/// A map of six faces.
#[derive(Clone, Debug)]
pub(super) struct Cube {
    position: [f32; 3],
    taps: Taps,
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

impl Place {
    /// Of a usable direction from the light.
    fn of(d: [f32; 3]) -> Self {
        let face = face_of(d);
        let [right, down, major] = along(face, d);
        Self {
            face,
            ray: [right / major, down / major],
            major,
        }
    }
}

impl<S: Simd> PlaceLanes<S> {
    /// [`Place::of`] for sixteen.
    #[inline(always)]
    fn of(s: S, d: V3<S>) -> Self {
        let side = Side::of(s, d);
        let [right, down, major] = side.along(d);
        Self {
            side,
            ray: [right / major, down / major],
            major,
        }
    }
}

impl Cube {
    pub(super) fn new(position: DVec3, taps: Taps) -> Self {
        Self {
            position: narrow(position),
            taps,
        }
    }

    pub(super) fn taps(&self) -> &Taps {
        &self.taps
    }

    pub(super) fn lit(&self, depths: &[f32], point: [f32; 3], normal: [f32; 3]) -> f32 {
        let Some(mut place) = self.place(point) else {
            return 1.0;
        };
        if let Bias::NormalOffset(texels) = self.taps.bias {
            let step = texels * (place.major * self.step());
            match self.place(moved(point, normal, step)) {
                Some(moved) => place = moved,
                None => return 1.0,
            }
        }
        let Place { face, ray, major } = place;
        let square = ray[0] * ray[0] + ray[1] * ray[1] + 1.0;
        let depth = major * sqrt_f32(square);
        let add = match self.taps.bias {
            Bias::Constant(constant) => constant,
            Bias::NormalOffset(_) => 1e-4 * (major * self.step()),
            Bias::Slope(constant) => {
                // distance = c |ray| / n.ray on the receiver's plane.
                let [right, down, axis] = along(face, normal);
                let facing = right * ray[0] + down * ray[1] + axis;
                let slope = (ray[0] / square - right / facing).abs()
                    + (ray[1] / square - down / facing).abs();
                self.taps.over(slope * (depth * self.step())) + constant
            }
        };
        let reference = depth - add;
        let [x, y] = ray.map(|c| self.texel(c));
        let mut lit = 0.0;
        let radius = self.taps.radius;
        for j in y - radius..=y + radius {
            for i in x - radius..=x + radius {
                if reference <= depths[self.index(face, i, j)] {
                    lit += 1.0;
                }
            }
        }
        lit / self.taps.count()
    }

    /// `None` for points at the light, and those that are not finite.
    fn place(&self, point: [f32; 3]) -> Option<Place> {
        let d = sub(point, self.position);
        is_usable(d).then(|| Place::of(d))
    }

    /// Column or row of a coordinate in -1..=1 of a face.
    fn texel(&self, c: f32) -> i32 {
        let n = self.taps.size as f32;
        let i = floor_to_i32_scalar((c * 0.5 + 0.5) * n);
        if i < self.taps.size {
            i
        } else {
            self.taps.size - 1
        }
    }

    /// Where a texel's depth is stored. One beyond an edge of its face lies on a neighbour: all faces store distances, so that they compare.
    fn index(&self, face: usize, i: i32, j: i32) -> usize {
        let (face, i, j) = if self.taps.holds(i, j) {
            (face, i, j)
        } else {
            let centre = |i: i32| (i as f32 + 0.5) * self.step() - 1.0;
            let there = Place::of(direction_of(face, [centre(i), centre(j), 1.0]));
            let [i, j] = there.ray.map(|c| self.texel(c));
            (there.face, i, j)
        };
        ((face as i32 * self.taps.size + j) * self.taps.size + i) as usize
    }

    /// Width of a texel on a face of which the axis is 1.
    fn step(&self) -> f32 {
        2.0 / self.taps.size as f32
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
        if let Bias::NormalOffset(texels) = self.taps.bias {
            let step = place.major * self.step() * texels;
            let (there, holds) = self.place_lanes(s, moved_lanes(point, normal, step));
            place = there;
            inside &= holds;
        }
        if !(inside & asked).any_true() {
            return one;
        }
        let PlaceLanes { side, ray, major } = place;
        let square = ray[0] * ray[0] + ray[1] * ray[1] + 1.0;
        let depth = major * square.sqrt();
        let add = match self.taps.bias {
            Bias::Constant(constant) => f32x16::splat(s, constant),
            Bias::NormalOffset(_) => major * self.step() * 1e-4,
            Bias::Slope(constant) => {
                let [right, down, axis] = side.along(normal);
                let facing = right * ray[0] + down * ray[1] + axis;
                let slope = (ray[0] / square - right / facing).abs()
                    + (ray[1] / square - down / facing).abs();
                self.taps.over_lanes(s, slope * (depth * self.step())) + constant
            }
        };
        let reference = depth - add;
        let face = side.face(s);
        let (x, y) = (self.texel_lanes(s, ray[0]), self.texel_lanes(s, ray[1]));
        let within = self.taps.hold_lanes(s, x, y);
        // Bounds know nothing of what lies beyond an edge.
        let [least, most] = self.taps.bounds.around(s, face, x, y);
        let (all, none) = (reference.simd_le(least), reference.simd_gt(most));
        if (within & (all | none) | !(inside & asked)).all_true() {
            return (inside & none).select(zero, one);
        }
        let lit = if within.all_true() {
            self.taps_lanes::<S, true>(s, words, &side, [x, y], reference)
        } else {
            self.taps_lanes::<S, false>(s, words, &side, [x, y], reference)
        };
        inside.select(lit / f32x16::splat(s, self.taps.count()), one)
    }

    /// [`place`](Self::place) for sixteen, and where there is one; elsewhere it is that of a point along +Z.
    #[inline(always)]
    fn place_lanes<S: Simd>(&self, s: S, point: V3<S>) -> (PlaceLanes<S>, mask32x16<S>) {
        let (d, holds) = usable_lanes(s, sub_lanes(point, spread(s, self.position)));
        (PlaceLanes::of(s, d), holds)
    }

    #[inline(always)]
    fn texel_lanes<S: Simd>(&self, s: S, c: f32x16<S>) -> i32x16<S> {
        let i = floor_to_i32(s, (c * 0.5 + 0.5) * self.taps.size as f32);
        let last = i32x16::splat(s, self.taps.size - 1);
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
        let Taps { size, radius, .. } = self.taps;
        let face = side.face(s);
        let mut lit = zero;
        for dj in -radius..=radius {
            let j = y + dj;
            for di in -radius..=radius {
                let i = x + di;
                let mut index = (face * size + j) * size + i;
                if !WITHIN {
                    let beyond = self.beyond_lanes(s, side, [i, j]);
                    index = self.taps.holds_lanes(s, i, j).select(index, beyond);
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
        let PlaceLanes { side, ray, .. } = PlaceLanes::of(s, d);
        let (i, j) = (self.texel_lanes(s, ray[0]), self.texel_lanes(s, ray[1]));
        (side.face(s) * self.taps.size + j) * self.taps.size + i
    }
}

//! Look-ups in the six faces around a point light.

use texmap_math::fearless_simd::{Simd, f32x16, i32x16, mask32x16, prelude::*, u32x16};
use texmap_math::float::sqrt_f32;
use texmap_math::glam::DVec3;
use texmap_math::lanes::{Words, floor_to_i32, floor_to_i32_scalar, gather};

use super::taps::{Bias, Receiver, ReceiverLanes, Taps, moved, moved_lanes};
use crate::cube_face::{Side, along, direction_of, face_of};
use crate::lanes::V3;
use crate::shadow::STEEPEST;
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
        let [x, y] = ray.map(|c| self.texel(c));
        // distance = c |ray| / n.ray on the receiver's plane.
        let tilt = || {
            let [right, down, axis] = along(face, normal);
            let facing = right * ray[0] + down * ray[1] + axis;
            [
                ray[0] / square - right / facing,
                ray[1] / square - down / facing,
            ]
        };
        let receiver = match self.taps.bias {
            Bias::Constant(constant) => Receiver::level(depth - constant),
            Bias::NormalOffset(_) => Receiver::level(depth - 1e-4 * (major * self.step())),
            Bias::Slope(constant) => {
                let [right, down] = tilt();
                let slope = right.abs() + down.abs();
                let over = self.taps.over(slope * (depth * self.step()));
                Receiver::level(depth - (over + constant))
            }
            Bias::Planes(constant) => {
                let texel = depth * self.step();
                let slope = tilt().map(|c| c * texel);
                let place = ray.map(|c| self.place_in_texels(c));
                Receiver::new(depth - constant, slope, texel * STEEPEST, place, [x, y])
            }
        };
        let mut lit = 0.0;
        let radius = self.taps.radius;
        for j in -radius..=radius {
            for i in -radius..=radius {
                if receiver.at(i, j) <= depths[self.index(face, x + i, y + j)] {
                    lit += 1.0;
                }
            }
        }
        self.taps.share(lit)
    }

    /// Texels from the first edge of a face to a coordinate in -1..=1.
    fn place_in_texels(&self, c: f32) -> f32 {
        (c * 0.5 + 0.5) * self.taps.size as f32
    }

    /// `None` for points at the light, and those that are not finite.
    fn place(&self, point: [f32; 3]) -> Option<Place> {
        let d = sub(point, self.position);
        is_usable(d).then(|| Place::of(d))
    }

    /// Column or row of a coordinate in -1..=1 of a face.
    fn texel(&self, c: f32) -> i32 {
        let i = floor_to_i32_scalar(self.place_in_texels(c));
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
        let reference = match self.taps.bias {
            Bias::Constant(constant) | Bias::Planes(constant) => depth - constant,
            Bias::NormalOffset(_) => depth - major * self.step() * 1e-4,
            Bias::Slope(constant) => {
                let [right, down] = tilt_lanes(&side, ray, square, normal);
                let slope = (right.abs() + down.abs()) * (depth * self.step());
                depth - (self.taps.over_lanes(s, slope) + constant)
            }
        };
        let face = side.face(s);
        let (x, y) = (self.texel_lanes(s, ray[0]), self.texel_lanes(s, ray[1]));
        let mut receiver = ReceiverLanes::level(s, reference);
        let planes = matches!(self.taps.bias, Bias::Planes(_));
        if planes {
            let texel = depth * self.step();
            let tilt = tilt_lanes(&side, ray, square, normal);
            let slope = [tilt[0] * texel, tilt[1] * texel];
            let place = [
                self.place_in_texels_lanes(ray[0]),
                self.place_in_texels_lanes(ray[1]),
            ];
            receiver = ReceiverLanes::new(reference, slope, texel * STEEPEST, place, [x, y]);
        }
        let within = self.taps.hold_lanes(s, x, y);
        // Bounds know nothing of what lies beyond an edge.
        let [least, most] = self.taps.bounds.around(s, face, x, y);
        let lowest = receiver.least(self.taps.radius);
        let (all, none) = (reference.simd_le(least), lowest.simd_gt(most));
        if (within & (all | none) | !(inside & asked)).all_true() {
            return (inside & none).select(zero, one);
        }
        let lit = match (planes, within.all_true()) {
            (false, true) => self.taps_lanes::<S, true, false>(s, words, &side, [x, y], &receiver),
            (false, false) => {
                self.taps_lanes::<S, false, false>(s, words, &side, [x, y], &receiver)
            }
            (true, true) => self.taps_lanes::<S, true, true>(s, words, &side, [x, y], &receiver),
            (true, false) => self.taps_lanes::<S, false, true>(s, words, &side, [x, y], &receiver),
        };
        inside.select(self.taps.share_lanes(s, lit), one)
    }

    /// [`place_in_texels`](Self::place_in_texels) for sixteen.
    #[inline(always)]
    fn place_in_texels_lanes<S: Simd>(&self, c: f32x16<S>) -> f32x16<S> {
        (c * 0.5 + 0.5) * self.taps.size as f32
    }

    /// [`place`](Self::place) for sixteen, and where there is one; elsewhere it is that of a point along +Z.
    #[inline(always)]
    fn place_lanes<S: Simd>(&self, s: S, point: V3<S>) -> (PlaceLanes<S>, mask32x16<S>) {
        let (d, holds) = usable_lanes(s, sub_lanes(point, spread(s, self.position)));
        (PlaceLanes::of(s, d), holds)
    }

    #[inline(always)]
    fn texel_lanes<S: Simd>(&self, s: S, c: f32x16<S>) -> i32x16<S> {
        let i = floor_to_i32(s, self.place_in_texels_lanes(c));
        let last = i32x16::splat(s, self.taps.size - 1);
        i.simd_lt(last).select(i, last)
    }

    /// Comparisons that pass; all taps lie on the faces of their points if `WITHIN`, the receiver's depth differs between them if `PLANES`.
    #[inline(always)]
    fn taps_lanes<S: Simd, const WITHIN: bool, const PLANES: bool>(
        &self,
        s: S,
        words: Words<'_>,
        side: &Side<S>,
        [x, y]: [i32x16<S>; 2],
        receiver: &ReceiverLanes<S>,
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
                let passes = receiver.at::<PLANES>(s, di, dj).simd_le(stored);
                lit += passes.select(one, zero);
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

/// What the distance of a receiver's plane changes right and down, as a part of it: distance = c |ray| / n.ray.
#[inline(always)]
fn tilt_lanes<S: Simd>(
    side: &Side<S>,
    ray: [f32x16<S>; 2],
    square: f32x16<S>,
    normal: V3<S>,
) -> [f32x16<S>; 2] {
    let [right, down, axis] = side.along(normal);
    let facing = right * ray[0] + down * ray[1] + axis;
    [
        ray[0] / square - right / facing,
        ray[1] / square - down / facing,
    ]
}

//! Look-ups in the six faces around a point light.

use texmap_math::glam::DVec3;
use texmap_math::lanes::GatherTable;
use texmap_math::simd::{Isa, prelude::*};

use super::taps::{Bias, Receiver, Taps, moved};
use crate::cube_face::Side;
use crate::lanes::Vector;
use crate::shadow::STEEPEST;
use crate::vector::{narrow, splat, sub, usable};

/// A map of six faces.
#[derive(Clone, Debug)]
pub(super) struct Cube {
    position: [f32; 3],
    taps: Taps,
}

/// Coordinates of points in the faces around the light.
struct Place<I: Isa> {
    side: Side<I>,
    /// Components of the ray to the point, right and down on its face. The component along the axis is 1.
    ray: [I::F32; 2],
    /// Distance along that axis.
    major: I::F32,
}

impl<I: Isa> Place<I> {
    /// Coordinates of directions from the light that are finite and not zero.
    #[inline(always)]
    fn of(d: Vector<I>) -> Self {
        let side = Side::<I>::of(d);
        let [right, down, major] = side.along(d);
        Self {
            side,
            ray: [right / major, down / major],
            major,
        }
    }

    /// Relative change of the distance to the receiver's plane, right and down: distance = c |ray| / n.ray. `square` is that of the ray.
    #[inline(always)]
    fn tilt(&self, square: I::F32, normal: Vector<I>) -> [I::F32; 2] {
        let ray = self.ray;
        let [right, down, axis] = self.side.along(normal);
        let facing = right * ray[0] + down * ray[1] + axis;
        [
            ray[0] / square - right / facing,
            ray[1] / square - down / facing,
        ]
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

    /// Width of a texel on a face of which the axis is 1.
    fn step(&self) -> f32 {
        2.0 / self.taps.size as f32
    }

    #[inline(always)]
    pub(super) fn visibility<I: Isa>(
        &self,
        i: I,
        words: GatherTable<'_>,
        asked: I::Mask,
        point: Vector<I>,
        normal: Vector<I>,
    ) -> I::F32 {
        let (mut place, mut inside) = self.place(i, point);
        if let Bias::NormalOffset(texels) = self.taps.bias {
            let step = place.major * self.step() * texels;
            let (there, holds) = self.place(i, moved(i, point, normal, step));
            place = there;
            inside = inside & holds;
        }
        if !(inside & asked).any_true() {
            return i.f32(1.0);
        }
        let (ray, major) = (place.ray, place.major);
        let square = ray[0] * ray[0] + ray[1] * ray[1] + 1.0;
        let depth = major * square.sqrt();
        let reference = match self.taps.bias {
            Bias::Constant(constant) | Bias::Planes(constant) => depth - constant,
            Bias::NormalOffset(_) => depth - major * self.step() * 1e-4,
            Bias::Slope(constant) => {
                let [right, down] = place.tilt(square, normal);
                let slope = (right.abs() + down.abs()) * (depth * self.step());
                depth - (self.taps.over(i, slope) + constant)
            }
        };
        let face = place.side.face(i);
        let (x, y) = (self.texel(i, ray[0]), self.texel(i, ray[1]));
        let mut receiver = Receiver::level(i, reference);
        let planes = matches!(self.taps.bias, Bias::Planes(_));
        if planes {
            let texel = depth * self.step();
            let [right, down] = place.tilt(square, normal);
            let slope = [right * texel, down * texel];
            let at = [self.in_texels(i, ray[0]), self.in_texels(i, ray[1])];
            let steepest = place.major * self.step() * STEEPEST;
            receiver = Receiver::new(i, reference, slope, steepest, at, [x, y]);
        }
        let within = self.taps.holds_around(i, x, y);
        // Bounds of a face do not hold for texels beyond its edges.
        let [least, most] = self.taps.bounds.around(i, face, x, y);
        let lowest = receiver.least(self.taps.radius);
        let (all, none) = (reference.simd_le(least), lowest.simd_gt(most));
        if (within & (all | none) | !(inside & asked)).all_true() {
            return (inside & none).select(i.f32(0.0), i.f32(1.0));
        }
        let (side, at) = (&place.side, [x, y]);
        let lit = match (planes, within.all_true()) {
            (false, true) => self.passing::<I, true, false>(i, words, side, at, &receiver),
            (false, false) => self.passing::<I, false, false>(i, words, side, at, &receiver),
            (true, true) => self.passing::<I, true, true>(i, words, side, at, &receiver),
            (true, false) => self.passing::<I, false, true>(i, words, side, at, &receiver),
        };
        inside.select(self.taps.share(i, &receiver, lit), i.f32(1.0))
    }

    /// Texels from the first edge of a face to a coordinate in -1..=1.
    #[inline(always)]
    fn in_texels<I: Isa>(&self, _: I, c: I::F32) -> I::F32 {
        (c * 0.5 + 0.5) * self.taps.size as f32
    }

    /// Coordinates of points, and the lanes that have some. Points at the light and those that are not finite get those along +Z.
    #[inline(always)]
    fn place<I: Isa>(&self, i: I, point: Vector<I>) -> (Place<I>, I::Mask) {
        let (d, holds) = usable(i, sub(point, splat(i, self.position)));
        (Place::of(d), holds)
    }

    /// Columns or rows of coordinates in -1..=1 of a face.
    #[inline(always)]
    fn texel<I: Isa>(&self, i: I, c: I::F32) -> I::I32 {
        self.in_texels(i, c)
            .floor_to_i32()
            .min(i.i32(self.taps.size - 1))
    }

    /// Number of comparisons that pass. All texels lie on the faces of their points if `WITHIN`; the receiver's depth differs between
    /// comparisons if `PLANES`.
    #[inline(always)]
    fn passing<I: Isa, const WITHIN: bool, const PLANES: bool>(
        &self,
        i: I,
        words: GatherTable<'_>,
        side: &Side<I>,
        [x, y]: [I::I32; 2],
        receiver: &Receiver<I>,
    ) -> I::F32 {
        let Taps { size, radius, .. } = self.taps;
        let face = side.face(i);
        let mut lit = i.f32(0.0);
        for dj in -radius..=radius {
            let row = y + dj;
            for di in -radius..=radius {
                let column = x + di;
                let mut index = (face * size + row) * size + column;
                if !WITHIN {
                    let beyond = self.beyond(i, side, [column, row]);
                    index = self.taps.holds(i, column, row).select(index, beyond);
                }
                let stored = i.gather(words, index.to_u32()).to_f32_bits();
                let passes = receiver.at::<PLANES>(i, di, dj).simd_le(stored);
                lit = lit + passes.select(i.f32(1.0), i.f32(0.0));
            }
        }
        lit
    }

    /// Indices of the depths of texels beyond the edges of their faces: on a neighbour. All faces store distances, so that they
    /// compare.
    #[inline(always)]
    fn beyond<I: Isa>(&self, i: I, side: &Side<I>, [column, row]: [I::I32; 2]) -> I::I32 {
        let step = self.step();
        let right = (column.to_f32() + 0.5) * step - 1.0;
        let down = (row.to_f32() + 0.5) * step - 1.0;
        let there = Place::<I>::of(side.direction([right, down, i.f32(1.0)]));
        let (x, y) = (self.texel(i, there.ray[0]), self.texel(i, there.ray[1]));
        (there.side.face(i) * self.taps.size + y) * self.taps.size + x
    }
}

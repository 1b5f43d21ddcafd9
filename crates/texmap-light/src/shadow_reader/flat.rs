//! Look-ups in a map of one face: under parallel light and spot lights.

use texmap_math::fearless_simd::{Simd, f32x16, i32x16, mask32x16, prelude::*, u32x16};
use texmap_math::glam::{DMat4, DVec4};
use texmap_math::lanes::{Words, floor_to_i32, floor_to_i32_scalar, gather};

use super::taps::{Bias, Receiver, ReceiverLanes, Taps, moved, moved_lanes};
use crate::lanes::V3;
use crate::shadow::STEEPEST;
use crate::vector::{affine_lanes, dot, dot_lanes, spread};

/// A map of one face.
#[derive(Clone, Debug)]
pub(super) struct Flat {
    taps: Taps,
    /// Columns and rows of the map (times the depth under a spot light), and depth.
    rows: [[f32; 4]; 3],
    /// The light's axes: right, down, and back to the light.
    axes: [[f32; 3]; 3],
    /// A spot light: columns and rows are divided by the depth.
    divided: bool,
    /// World size of a texel, at a depth of 1 under a spot light.
    texel: f32,
}

impl Flat {
    /// `half` is half the width of the map, at a depth of 1 if `divided`.
    pub(super) fn new(light_from_world: DMat4, half: f64, divided: bool, taps: Taps) -> Self {
        let size = f64::from(taps.size);
        let [x, y, z] = rows(light_from_world);
        let depth = -z;
        // (p / half + 1) / 2 of the map's size; under a spot light p is divided by the depth later.
        let middle = if divided { depth } else { DVec4::W };
        let across = (x * (0.5 / half) + middle * 0.5) * size;
        let down = (y * (-0.5 / half) + middle * 0.5) * size;
        let narrow = |v: DVec4| v.to_array().map(|c| c as f32);
        let axis = |v: DVec4| {
            let [x, y, z, _] = narrow(v);
            [x, y, z]
        };
        Self {
            rows: [across, down, depth].map(narrow),
            axes: [axis(x), axis(-y), axis(z)],
            divided,
            texel: (2.0 * half / size) as f32,
            taps,
        }
    }

    pub(super) fn taps(&self) -> &Taps {
        &self.taps
    }

    pub(super) fn lit(&self, depths: &[f32], point: [f32; 3], normal: [f32; 3]) -> f32 {
        let mut place = self.place(point);
        if !self.holds(place) {
            return 1.0;
        }
        if let Bias::NormalOffset(texels) = self.taps.bias {
            let step = texels * self.texel_at(place[2]);
            place = self.place(moved(point, normal, step));
            if !self.holds(place) {
                return 1.0;
            }
        }
        let [x, y, depth] = place;
        let (column, row) = (floor_to_i32_scalar(x), floor_to_i32_scalar(y));
        let receiver = match self.taps.bias {
            Bias::Constant(constant) => Receiver::level(depth - constant),
            Bias::NormalOffset(_) => Receiver::level(depth - 1e-4 * self.texel_at(depth)),
            Bias::Slope(constant) => {
                let ([right, down], below) = self.tilt(x, y, normal);
                let slope = (right.abs() + down.abs()) * self.texel_at(depth) / below.abs();
                Receiver::level(depth - (self.taps.over(slope) + constant))
            }
            Bias::Planes(constant) => {
                let ([right, down], below) = self.tilt(x, y, normal);
                let (depth, texel) = (depth - constant, self.texel_at(depth));
                let per_texel = texel / -below;
                let slope = [right * per_texel, down * per_texel];
                Receiver::new(depth, slope, texel * STEEPEST, [x, y], [column, row])
            }
        };
        let mut lit = 0.0;
        let Taps { size, radius, .. } = self.taps;
        for j in -radius..=radius {
            for i in -radius..=radius {
                let outside = !self.taps.holds(column + i, row + j);
                let index = ((row + j) * size + column + i) as usize;
                if outside || receiver.at(i, j) <= depths[index] {
                    lit += 1.0;
                }
            }
        }
        self.taps.share(lit)
    }

    /// A normal's components right and down in the map, and along the ray to a place in it.
    fn tilt(&self, x: f32, y: f32, normal: [f32; 3]) -> ([f32; 2], f32) {
        let [right, down, back] = self.axes.map(|axis| dot(axis, normal));
        if !self.divided {
            return ([right, down], -back);
        }
        // n . ray, the ray's components taken from the place in the map.
        let n = self.taps.size as f32;
        let (px, py) = ((x - 0.5 * n) * self.texel, (y - 0.5 * n) * self.texel);
        ([right, down], (right * px + down * py) - back)
    }

    /// Whether a place lies in the map.
    fn holds(&self, [x, y, depth]: [f32; 3]) -> bool {
        let n = self.taps.size as f32;
        let inside = x >= 0.0 && x < n && y >= 0.0 && y < n && depth < f32::INFINITY;
        inside && (!self.divided || depth > 0.0)
    }

    /// Columns and rows of the map, and depth.
    fn place(&self, [px, py, pz]: [f32; 3]) -> [f32; 3] {
        let [x, y, depth] = self
            .rows
            .map(|row| row[0] * px + row[1] * py + row[2] * pz + row[3]);
        if self.divided {
            [x / depth, y / depth, depth]
        } else {
            [x, y, depth]
        }
    }

    fn texel_at(&self, depth: f32) -> f32 {
        if self.divided {
            self.texel * depth
        } else {
            self.texel
        }
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
        let one = f32x16::splat(s, 1.0);
        let mut place = self.place_lanes(point);
        let mut inside = self.holds_lanes(s, place);
        if let Bias::NormalOffset(texels) = self.taps.bias {
            let step = self.texel_at_lanes(s, place[2]) * texels;
            place = self.place_lanes(moved_lanes(point, normal, step));
            inside &= self.holds_lanes(s, place);
        }
        let [x, y, depth] = place;
        if !(inside & asked).any_true() {
            return one;
        }
        let middle = f32x16::splat(s, 0.5 * self.taps.size as f32);
        let place = [inside.select(x, middle), inside.select(y, middle)];
        let [x, y] = [floor_to_i32(s, place[0]), floor_to_i32(s, place[1])];
        let [least, most] = self.taps.bounds.around(s, i32x16::splat(s, 0), x, y);
        let reference = match self.taps.bias {
            Bias::Constant(constant) | Bias::Planes(constant) => depth - constant,
            Bias::NormalOffset(_) => depth - self.texel_at_lanes(s, depth) * 1e-4,
            Bias::Slope(constant) => {
                let ([right, down], below) = self.tilt_lanes(s, place, normal);
                let texel = self.texel_at_lanes(s, depth);
                let slope = (right.abs() + down.abs()) * texel / below.abs();
                depth - (self.taps.over_lanes(s, slope) + constant)
            }
        };
        let mut receiver = ReceiverLanes::level(s, reference);
        let planes = matches!(self.taps.bias, Bias::Planes(_));
        if planes {
            let ([right, down], below) = self.tilt_lanes(s, place, normal);
            let texel = self.texel_at_lanes(s, depth);
            let per_texel = texel / -below;
            let slope = [right * per_texel, down * per_texel];
            receiver = ReceiverLanes::new(reference, slope, texel * STEEPEST, place, [x, y]);
        }
        let lowest = receiver.least(self.taps.radius);
        let (all, none) = (reference.simd_le(least), lowest.simd_gt(most));
        if (all | none | !(inside & asked)).all_true() {
            return (inside & none).select(f32x16::splat(s, 0.0), one);
        }
        let within = self.taps.hold_lanes(s, x, y).all_true();
        let lit = match (planes, within) {
            (false, true) => self.taps_lanes::<S, true, false>(s, words, x, y, &receiver),
            (false, false) => self.taps_lanes::<S, false, false>(s, words, x, y, &receiver),
            (true, true) => self.taps_lanes::<S, true, true>(s, words, x, y, &receiver),
            (true, false) => self.taps_lanes::<S, false, true>(s, words, x, y, &receiver),
        };
        inside.select(self.taps.share_lanes(s, lit), one)
    }

    /// [`holds`](Self::holds) for sixteen.
    #[inline(always)]
    fn holds_lanes<S: Simd>(&self, s: S, [x, y, depth]: V3<S>) -> mask32x16<S> {
        let (zero, n) = (
            f32x16::splat(s, 0.0),
            f32x16::splat(s, self.taps.size as f32),
        );
        let inside = x.simd_ge(zero) & x.simd_lt(n) & y.simd_ge(zero) & y.simd_lt(n);
        let inside = inside & depth.simd_lt(f32::INFINITY);
        if self.divided {
            inside & depth.simd_gt(zero)
        } else {
            inside
        }
    }

    /// Comparisons that pass; all taps lie in the map if `WITHIN`, the receiver's depth differs between them if `PLANES`.
    #[inline(always)]
    fn taps_lanes<S: Simd, const WITHIN: bool, const PLANES: bool>(
        &self,
        s: S,
        words: Words<'_>,
        x: i32x16<S>,
        y: i32x16<S>,
        receiver: &ReceiverLanes<S>,
    ) -> f32x16<S> {
        let (zero, one) = (f32x16::splat(s, 0.0), f32x16::splat(s, 1.0));
        let Taps { size, radius, .. } = self.taps;
        let mut lit = zero;
        for dj in -radius..=radius {
            let j = y + dj;
            let row = j * size;
            for di in -radius..=radius {
                let i = x + di;
                let index: u32x16<S> = (row + i).bitcast();
                let stored: f32x16<S> = gather(s, words, index).bitcast();
                let mut passes = receiver.at::<PLANES>(s, di, dj).simd_le(stored);
                if !WITHIN {
                    passes |= !self.taps.holds_lanes(s, i, j);
                }
                lit += passes.select(one, zero);
            }
        }
        lit
    }

    /// [`tilt`](Self::tilt) for sixteen.
    #[inline(always)]
    fn tilt_lanes<S: Simd>(
        &self,
        s: S,
        [x, y]: [f32x16<S>; 2],
        normal: V3<S>,
    ) -> ([f32x16<S>; 2], f32x16<S>) {
        let right = dot_lanes(spread(s, self.axes[0]), normal);
        let down = dot_lanes(spread(s, self.axes[1]), normal);
        let back = dot_lanes(spread(s, self.axes[2]), normal);
        if !self.divided {
            return ([right, down], -back);
        }
        let half = 0.5 * self.taps.size as f32;
        let (px, py) = ((x - half) * self.texel, (y - half) * self.texel);
        ([right, down], (right * px + down * py) - back)
    }

    #[inline(always)]
    fn place_lanes<S: Simd>(&self, point: V3<S>) -> V3<S> {
        let out = affine_lanes(&self.rows, point);
        if self.divided {
            [out[0] / out[2], out[1] / out[2], out[2]]
        } else {
            out
        }
    }

    #[inline(always)]
    fn texel_at_lanes<S: Simd>(&self, s: S, depth: f32x16<S>) -> f32x16<S> {
        if self.divided {
            depth * self.texel
        } else {
            f32x16::splat(s, self.texel)
        }
    }
}

/// The rows of a matrix that moves points.
fn rows(m: DMat4) -> [DVec4; 3] {
    let t = m.transpose();
    [t.x_axis, t.y_axis, t.z_axis]
}

//! Look-ups in a map of one face: under parallel light and spot lights.

use texmap_math::glam::{DMat4, DVec4};
use texmap_math::lanes::GatherTable;
use texmap_math::simd::{Isa, prelude::*};

use super::taps::{Bias, Receiver, Taps, moved};
use crate::lanes::Vector;
use crate::shadow::STEEPEST;
use crate::vector::{affine, dot, splat};

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

    #[inline(always)]
    pub(super) fn visibility<I: Isa>(
        &self,
        i: I,
        words: GatherTable<'_>,
        asked: I::Mask,
        point: Vector<I>,
        normal: Vector<I>,
    ) -> I::F32 {
        let mut place = self.place(i, point);
        let mut inside = self.holds(i, place);
        if let Bias::NormalOffset(texels) = self.taps.bias {
            let step = self.texel_at(i, place[2]) * texels;
            place = self.place(i, moved(i, point, normal, step));
            inside = inside & self.holds(i, place);
        }
        let [x, y, depth] = place;
        if !(inside & asked).any_true() {
            return i.f32(1.0);
        }
        let middle = i.f32(0.5 * self.taps.size as f32);
        let place = [inside.select(x, middle), inside.select(y, middle)];
        let [x, y] = [place[0].floor_to_i32(), place[1].floor_to_i32()];
        let [least, most] = self.taps.bounds.around(i, i.i32(0), x, y);
        let reference = match self.taps.bias {
            Bias::Constant(constant) | Bias::Planes(constant) => depth - constant,
            Bias::NormalOffset(_) => depth - self.texel_at(i, depth) * 1e-4,
            Bias::Slope(constant) => {
                let ([right, down], below) = self.tilt(i, place, normal);
                let texel = self.texel_at(i, depth);
                let slope = (right.abs() + down.abs()) * texel / below.abs();
                depth - (self.taps.over(i, slope) + constant)
            }
        };
        let mut receiver = Receiver::level(i, reference);
        let planes = matches!(self.taps.bias, Bias::Planes(_));
        if planes {
            let ([right, down], below) = self.tilt(i, place, normal);
            let texel = self.texel_at(i, depth);
            let per_texel = texel / -below;
            let slope = [right * per_texel, down * per_texel];
            receiver = Receiver::new(i, reference, slope, texel * STEEPEST, place, [x, y]);
        }
        let lowest = receiver.least(self.taps.radius);
        let (all, none) = (reference.simd_le(least), lowest.simd_gt(most));
        if (all | none | !(inside & asked)).all_true() {
            return (inside & none).select(i.f32(0.0), i.f32(1.0));
        }
        let within = self.taps.holds_around(i, x, y).all_true();
        let lit = match (planes, within) {
            (false, true) => self.passing::<I, true, false>(i, words, x, y, &receiver),
            (false, false) => self.passing::<I, false, false>(i, words, x, y, &receiver),
            (true, true) => self.passing::<I, true, true>(i, words, x, y, &receiver),
            (true, false) => self.passing::<I, false, true>(i, words, x, y, &receiver),
        };
        inside.select(self.taps.share(i, &receiver, lit), i.f32(1.0))
    }

    /// Lanes whose coordinates lie in the map.
    #[inline(always)]
    fn holds<I: Isa>(&self, _: I, [x, y, depth]: Vector<I>) -> I::Mask {
        let n = self.taps.size as f32;
        let inside = x.simd_ge(0.0) & x.simd_lt(n) & y.simd_ge(0.0) & y.simd_lt(n);
        let inside = inside & depth.simd_lt(f32::INFINITY);
        if self.divided {
            inside & depth.simd_gt(0.0)
        } else {
            inside
        }
    }

    /// Number of comparisons that pass. All texels lie in the map if `WITHIN`; the receiver's depth differs between comparisons if
    /// `PLANES`.
    #[inline(always)]
    fn passing<I: Isa, const WITHIN: bool, const PLANES: bool>(
        &self,
        i: I,
        words: GatherTable<'_>,
        x: I::I32,
        y: I::I32,
        receiver: &Receiver<I>,
    ) -> I::F32 {
        let Taps { size, radius, .. } = self.taps;
        let mut lit = i.f32(0.0);
        for dj in -radius..=radius {
            let row = y + dj;
            let first = row * size;
            for di in -radius..=radius {
                let column = x + di;
                let stored = i.gather(words, (first + column).to_u32()).to_f32_bits();
                let mut passes = receiver.at::<PLANES>(i, di, dj).simd_le(stored);
                if !WITHIN {
                    passes = passes | !self.taps.holds(i, column, row);
                }
                lit = lit + passes.select(i.f32(1.0), i.f32(0.0));
            }
        }
        lit
    }

    /// A normal's components right and down in the map, and along the ray to a texel.
    #[inline(always)]
    fn tilt<I: Isa>(&self, i: I, [x, y]: [I::F32; 2], normal: Vector<I>) -> ([I::F32; 2], I::F32) {
        let right = dot(splat(i, self.axes[0]), normal);
        let down = dot(splat(i, self.axes[1]), normal);
        let back = dot(splat(i, self.axes[2]), normal);
        if !self.divided {
            return ([right, down], -back);
        }
        // n . ray, the ray's components taken from the coordinates in the map.
        let half = 0.5 * self.taps.size as f32;
        let (px, py) = ((x - half) * self.texel, (y - half) * self.texel);
        ([right, down], (right * px + down * py) - back)
    }

    /// Columns and rows of the map, and depth.
    #[inline(always)]
    fn place<I: Isa>(&self, _: I, point: Vector<I>) -> Vector<I> {
        let out = affine(&self.rows, point);
        if self.divided {
            [out[0] / out[2], out[1] / out[2], out[2]]
        } else {
            out
        }
    }

    #[inline(always)]
    fn texel_at<I: Isa>(&self, i: I, depth: I::F32) -> I::F32 {
        if self.divided {
            depth * self.texel
        } else {
            i.f32(self.texel)
        }
    }
}

/// The rows of a matrix that moves points.
fn rows(m: DMat4) -> [DVec4; 3] {
    let t = m.transpose();
    [t.x_axis, t.y_axis, t.z_axis]
}

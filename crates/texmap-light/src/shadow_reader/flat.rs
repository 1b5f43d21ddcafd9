//! Look-ups in a map of one face: under parallel light and spot lights.

use texmap_math::fearless_simd::{Simd, f32x16, i32x16, mask32x16, prelude::*, u32x16};
use texmap_math::glam::{DMat4, DVec4};
use texmap_math::lanes::{Words, floor_to_i32, floor_to_i32_scalar, gather};

use super::taps::{Bias, Taps, moved, moved_lanes};
use crate::lanes::V3;
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
        let ([x, y, depth], n) = (place, self.taps.size as f32);
        let add = match self.taps.bias {
            Bias::Constant(constant) => constant,
            Bias::NormalOffset(_) => 1e-4 * self.texel_at(depth),
            Bias::Slope(constant) => {
                let [right, down, back] = self.axes.map(|axis| dot(axis, normal));
                let below = if self.divided {
                    // n . ray, the ray's components taken from the place in the map.
                    let (px, py) = ((x - 0.5 * n) * self.texel, (y - 0.5 * n) * self.texel);
                    (right * px + down * py) - back
                } else {
                    -back
                };
                let slope = (right.abs() + down.abs()) * self.texel_at(depth) / below.abs();
                self.taps.over(slope) + constant
            }
        };
        let reference = depth - add;
        let (x, y) = (floor_to_i32_scalar(x), floor_to_i32_scalar(y));
        let mut lit = 0.0;
        let Taps { size, radius, .. } = self.taps;
        for j in y - radius..=y + radius {
            for i in x - radius..=x + radius {
                let outside = !self.taps.holds(i, j);
                if outside || reference <= depths[(j * size + i) as usize] {
                    lit += 1.0;
                }
            }
        }
        lit / self.taps.count()
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
        let add = match self.taps.bias {
            Bias::Constant(constant) => f32x16::splat(s, constant),
            Bias::NormalOffset(_) => self.texel_at_lanes(s, depth) * 1e-4,
            Bias::Slope(constant) => self.slope_lanes(s, x, y, depth, normal) + constant,
        };
        let reference = depth - add;
        let middle = f32x16::splat(s, 0.5 * self.taps.size as f32);
        let x = floor_to_i32(s, inside.select(x, middle));
        let y = floor_to_i32(s, inside.select(y, middle));
        let [least, most] = self.taps.bounds.around(s, i32x16::splat(s, 0), x, y);
        let (all, none) = (reference.simd_le(least), reference.simd_gt(most));
        if (all | none | !(inside & asked)).all_true() {
            return (inside & none).select(f32x16::splat(s, 0.0), one);
        }
        let lit = if self.taps.hold_lanes(s, x, y).all_true() {
            self.taps_lanes::<S, true>(s, words, x, y, reference)
        } else {
            self.taps_lanes::<S, false>(s, words, x, y, reference)
        };
        inside.select(lit / f32x16::splat(s, self.taps.count()), one)
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

    /// Comparisons that pass; all taps lie in the map if `WITHIN`.
    #[inline(always)]
    fn taps_lanes<S: Simd, const WITHIN: bool>(
        &self,
        s: S,
        words: Words<'_>,
        x: i32x16<S>,
        y: i32x16<S>,
        reference: f32x16<S>,
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
                let mut passes = reference.simd_le(stored);
                if !WITHIN {
                    passes |= !self.taps.holds_lanes(s, i, j);
                }
                lit += passes.select(one, zero);
            }
        }
        lit
    }

    #[inline(always)]
    fn slope_lanes<S: Simd>(
        &self,
        s: S,
        x: f32x16<S>,
        y: f32x16<S>,
        depth: f32x16<S>,
        normal: V3<S>,
    ) -> f32x16<S> {
        let right = dot_lanes(spread(s, self.axes[0]), normal);
        let down = dot_lanes(spread(s, self.axes[1]), normal);
        let back = dot_lanes(spread(s, self.axes[2]), normal);
        let below = if self.divided {
            let half = 0.5 * self.taps.size as f32;
            let (px, py) = ((x - half) * self.texel, (y - half) * self.texel);
            (right * px + down * py) - back
        } else {
            -back
        };
        let slope = (right.abs() + down.abs()) * self.texel_at_lanes(s, depth) / below.abs();
        self.taps.over_lanes(s, slope)
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

//! The formulae of a round mapping at a pixel, coordinates and derivatives: for one pixel, for sixteen with the same
//! bits, and in f64.

use core::f32::consts::{FRAC_1_PI, TAU};

use texmap_math::fearless_simd::f32x16;
use texmap_math::fearless_simd::prelude::*;
use texmap_math::glam::DVec3;
use texmap_math::lanes::{self, LANES};
use texmap_math::{Footprint, float};

use super::{PixelMapping, Round};
use crate::Origin;
use crate::spherical::{around, around_x16, components, latitude, latitude_x16};

/// A share of the distance from the middle below which a direction from the axis means nothing in f32.
const AXIS: f32 = 1e-12;
/// A vector shorter than this in the unit solid has no direction.
const NOTHING: f32 = 1e-30;

impl PixelMapping {
    /// uv of a point, and the footprint of a pixel along whose sides the point moves by `dx` and `dy`. NaN gives NaN.
    #[must_use]
    pub fn one(&self, point: [f32; 3], dx: [f32; 3], dy: [f32; 3]) -> ([f32; 2], Footprint) {
        let [x, y, z] = self.rows.map(|r| row(r, point) + r[3]);
        let around = around(x, z);
        let (up, nearness) = match self.shape {
            Round::Sphere => (latitude(y, around), Nearness::of(x, y, z)),
            Round::Cylinder => (y, Nearness::of(x, 0.0, z)),
        };
        let (v, sign) = match self.origin {
            Origin::TopLeft => (0.5 - up, -1.0),
            Origin::BottomLeft => (0.5 + up, 1.0),
        };
        let change = |d: [f32; 3]| {
            let d = self.rows.map(|r| row(r, d));
            let [u, up] = nearness.change(d, self.shape);
            [u * self.repeat[0], up * (sign * self.repeat[1])]
        };
        let ([du_dx, dv_dx], [du_dy, dv_dy]) = (change(dx), change(dy));
        (
            [around.u * self.repeat[0], v * self.repeat[1]],
            Footprint::new(du_dx, dv_dx, du_dy, dv_dy),
        )
    }

    /// [`PixelMapping::one`] in f64, for reading: uv, and `[du/dx, dv/dx, du/dy, dv/dy]`. On the axis there is no derivative: NaN.
    #[must_use]
    pub fn reference(&self, point: DVec3, dx: DVec3, dy: DVec3) -> ([f64; 2], [f64; 4]) {
        let q = self.unit_from_point.transform_point3(point);
        let (_, [u, latitude]) = crate::Shape::Sphere.uv(q, self.origin);
        let sign = match self.origin {
            Origin::TopLeft => -1.0,
            Origin::BottomLeft => 1.0,
        };
        let v = match self.shape {
            Round::Sphere => latitude,
            Round::Cylinder => 0.5 + sign * q.y,
        };
        let [across, down] = self.repeat.map(f64::from);
        let change = |d: DVec3| {
            let d = self.unit_from_point.transform_vector3(d);
            let square = q.x * q.x + q.z * q.z;
            let turn = (q.z * d.x - q.x * d.z) / square / core::f64::consts::TAU;
            let up = match self.shape {
                Round::Cylinder => d.y,
                Round::Sphere => {
                    let out = float::sqrt(square);
                    let rise = out * d.y - q.y * (q.x * d.x + q.z * d.z) / out;
                    rise / (square + q.y * q.y) / core::f64::consts::PI
                }
            };
            [turn.clamp(-0.5, 0.5) * across, up * sign * down]
        };
        let ([ux, vx], [uy, vy]) = (change(dx), change(dy));
        ([u * across, v * down], [ux, vx, uy, vy])
    }

    /// u, v, du/dx, dv/dx, du/dy and dv/dy of sixteen pixels.
    #[inline(always)]
    pub(super) fn block<S: Simd>(
        &self,
        s: S,
        points: &[[f32; 3]; LANES],
        dx: &[[f32; 3]; LANES],
        dy: &[[f32; 3]; LANES],
    ) -> [[f32; LANES]; 6] {
        let splat = |c: f32| f32x16::splat(s, c);
        let (point, dx, dy) = (components(s, points), components(s, dx), components(s, dy));
        let x = row_x16(s, self.rows[0], point) + self.rows[0][3];
        let y = row_x16(s, self.rows[1], point) + self.rows[1][3];
        let z = row_x16(s, self.rows[2], point) + self.rows[2][3];
        let around = around_x16(s, x, z);
        let (up, height) = match self.shape {
            Round::Sphere => (latitude_x16(s, y, around), y),
            Round::Cylinder => (y, splat(0.0)),
        };
        let (v, sign) = match self.origin {
            Origin::TopLeft => (splat(0.5) - up, -1.0),
            Origin::BottomLeft => (splat(0.5) + up, 1.0),
        };
        let near = NearnessX16::of(s, x, height, z);
        let [du_dx, up_dx] = near.change(s, self.unit_x16(s, dx), self.shape);
        let [du_dy, up_dy] = near.change(s, self.unit_x16(s, dy), self.shape);
        let rise = sign * self.repeat[1];
        [
            (around.u * self.repeat[0]).into(),
            (v * self.repeat[1]).into(),
            (du_dx * self.repeat[0]).into(),
            (up_dx * rise).into(),
            (du_dy * self.repeat[0]).into(),
            (up_dy * rise).into(),
        ]
    }

    #[inline(always)]
    fn unit_x16<S: Simd>(&self, s: S, d: [f32x16<S>; 3]) -> [f32x16<S>; 3] {
        [
            row_x16(s, self.rows[0], d),
            row_x16(s, self.rows[1], d),
            row_x16(s, self.rows[2], d),
        ]
    }
}

#[inline(always)]
fn row(r: [f32; 4], d: [f32; 3]) -> f32 {
    r[0] * d[0] + r[1] * d[1] + r[2] * d[2]
}

#[inline(always)]
fn row_x16<S: Simd>(s: S, r: [f32; 4], d: [f32x16<S>; 3]) -> f32x16<S> {
    f32x16::splat(s, r[0]) * d[0] + f32x16::splat(s, r[1]) * d[1] + f32x16::splat(s, r[2]) * d[2]
}

/// The point at most one long, and what derivatives divide by.
#[derive(Clone, Copy)]
struct Nearness {
    x: f32,
    y: f32,
    z: f32,
    /// One over the largest component.
    scale: f32,
    /// Distance from the axis; 0 on it.
    out: f32,
    /// One over its square, and over the square of the distance from the middle; 0 where there is none.
    per_out: f32,
    per_all: f32,
}

impl Nearness {
    #[inline(always)]
    fn of(x: f32, y: f32, z: f32) -> Self {
        let most = larger(larger(x.abs(), z.abs()), y.abs());
        let scale = if most > NOTHING { 1.0 / most } else { 0.0 };
        let (x, y, z) = (x * scale, y * scale, z * scale);
        let square = x * x + z * z;
        let off_axis = square > AXIS * AXIS;
        let all = square + y * y;
        Self {
            x,
            y,
            z,
            scale,
            out: if off_axis {
                float::sqrt_f32(square)
            } else {
                0.0
            },
            per_out: if off_axis { 1.0 / square } else { 0.0 },
            per_all: if all > 0.0 { 1.0 / all } else { 0.0 },
        }
    }

    /// Changes of u and of the height for a change of the point in the unit solid.
    #[inline(always)]
    fn change(&self, [dx, dy, dz]: [f32; 3], shape: Round) -> [f32; 2] {
        let turn = (self.z * dx - self.x * dz) * self.scale * self.per_out * (1.0 / TAU);
        let turn = lanes::clamp_scalar(turn, -0.5, 0.5);
        let up = match shape {
            Round::Cylinder => dy,
            Round::Sphere => {
                let out = (self.x * dx + self.z * dz) * self.out * self.per_out;
                (self.out * dy - self.y * out) * self.scale * self.per_all * FRAC_1_PI
            }
        };
        [turn, up]
    }
}

#[inline(always)]
fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// [`Nearness`] of sixteen points.
#[derive(Clone, Copy)]
struct NearnessX16<S: Simd> {
    x: f32x16<S>,
    y: f32x16<S>,
    z: f32x16<S>,
    scale: f32x16<S>,
    out: f32x16<S>,
    per_out: f32x16<S>,
    per_all: f32x16<S>,
}

impl<S: Simd> NearnessX16<S> {
    #[inline(always)]
    fn of(s: S, x: f32x16<S>, y: f32x16<S>, z: f32x16<S>) -> Self {
        let (zero, one) = (f32x16::splat(s, 0.0), f32x16::splat(s, 1.0));
        let most = larger_x16(larger_x16(x.abs(), z.abs()), y.abs());
        let scale = most
            .simd_gt(f32x16::splat(s, NOTHING))
            .select(one / most, zero);
        let (x, y, z) = (x * scale, y * scale, z * scale);
        let square = x * x + z * z;
        let off_axis = square.simd_gt(f32x16::splat(s, AXIS * AXIS));
        let all = square + y * y;
        Self {
            x,
            y,
            z,
            scale,
            out: off_axis.select(square.sqrt(), zero),
            per_out: off_axis.select(one / square, zero),
            per_all: all.simd_gt(zero).select(one / all, zero),
        }
    }

    #[inline(always)]
    fn change(&self, s: S, [dx, dy, dz]: [f32x16<S>; 3], shape: Round) -> [f32x16<S>; 2] {
        let turn = (self.z * dx - self.x * dz) * self.scale * self.per_out * (1.0 / TAU);
        let turn = lanes::clamp(turn, f32x16::splat(s, -0.5), f32x16::splat(s, 0.5));
        let up = match shape {
            Round::Cylinder => dy,
            Round::Sphere => {
                let out = (self.x * dx + self.z * dz) * self.out * self.per_out;
                (self.out * dy - self.y * out) * self.scale * self.per_all * FRAC_1_PI
            }
        };
        [turn, up]
    }
}

#[inline(always)]
fn larger_x16<S: Simd>(a: f32x16<S>, b: f32x16<S>) -> f32x16<S> {
    a.simd_gt(b).select(a, b)
}

#[cfg(test)]
mod tests {
    use super::super::tests::{frame, pixel};
    use super::*;
    use crate::{Frame, Shape};

    fn exact(shape: Round, p: DVec3) -> [f64; 2] {
        let q = frame().placed().unwrap().point(p);
        match shape {
            Round::Sphere => Shape::Sphere.uv(q, Origin::TopLeft).1,
            Round::Cylinder => {
                let u = Shape::Sphere.uv(q, Origin::TopLeft).1[0];
                [u, 0.5 - q.y]
            }
        }
    }

    #[test]
    fn uv_and_derivatives_are_those_of_the_formula() {
        let wide = |v: [f32; 3]| DVec3::from(v.map(f64::from));
        let whole = |d: f64| d - float::floor(d + 0.5);
        for shape in [Round::Cylinder, Round::Sphere] {
            let map = PixelMapping::new(shape, &frame(), [1.0; 2], Origin::TopLeft).unwrap();
            let mut leaps = 0;
            for (i, j) in (-40..40).flat_map(|i| (-40..40).map(move |j| (i, j))) {
                let [p, dx, dy] = pixel(i, j);
                let q = frame().placed().unwrap().point(wide(p));
                if q.x * q.x + q.z * q.z < 1e-3 {
                    continue;
                }
                let (uv, d) = map.one(p, dx, dy);
                let e = exact(shape, wide(p));
                assert!(
                    whole(f64::from(uv[0]) - e[0]).abs() < 1e-5
                        && (f64::from(uv[1]) - e[1]).abs() < 1e-5
                );
                // Within 1e-5 of the reference, derivatives too.
                let (reference, slopes) = map.reference(wide(p), wide(dx), wide(dy));
                assert!((0..2).all(|k| (reference[k] - e[k]).abs() < 1e-12));
                for (d, exact) in [d.du_dx, d.dv_dx, d.du_dy, d.dv_dy].into_iter().zip(slopes) {
                    assert!((f64::from(d) - exact).abs() < 1e-5 * (1.0 + exact.abs()));
                }
                let step = 1e-5;
                for (d, along) in [([d.du_dx, d.dv_dx], dx), ([d.du_dy, d.dv_dy], dy)] {
                    let (a, b) = (
                        exact(shape, wide(p) - wide(along) * step),
                        exact(shape, wide(p) + wide(along) * step),
                    );
                    // Whole turns are no change.
                    let slope = [whole(b[0] - a[0]), b[1] - a[1]].map(|s| s / (2.0 * step));
                    for k in 0..2 {
                        assert!(
                            (f64::from(d[k]) - slope[k]).abs() < 1e-4 * (1.0 + slope[k].abs()),
                            "{shape:?} {p:?}: {d:?} {slope:?}"
                        );
                    }
                }
                // Negative twin: the difference to the next pixel leaps at the seam.
                let next = map.one(pixel(i, j + 1)[0], dx, dy).0;
                leaps += usize::from((next[0] - uv[0]).abs() > 0.5);
            }
            assert!(leaps > 5, "the pixels meet the seam: {leaps}");
        }
    }

    #[test]
    fn footprints_do_not_leap_at_the_seam_and_stay_finite_at_the_pole() {
        for shape in [Round::Cylinder, Round::Sphere] {
            let upright = Frame::upright(DVec3::ZERO, DVec3::splat(2.0));
            let map = PixelMapping::new(shape, &upright, [4.0, 2.0], Origin::BottomLeft).unwrap();
            let at = |z: f32| map.one([0.8, 0.2, z], [0.0, 0.0, 0.01], [0.0, 0.01, 0.0]);
            let ((a, da), (b, db)) = (at(-1e-5), at(1e-5));
            assert!((a[0] - b[0]).abs() > 3.99, "{a:?} {b:?}");
            assert!((da.du_dx - db.du_dx).abs() < 1e-5 && da.du_dx < 0.0);
            assert!((da.dv_dy - db.dv_dy).abs() < 1e-5 && da.dv_dy > 0.0);
            for p in [
                [0.0, 0.7, 0.0],
                [1e-20, 0.7, 0.0],
                [1e-3, 0.7, 0.0],
                [0.0; 3],
            ] {
                let (uv, d) = map.one(p, [0.01, 0.0, 0.0], [0.0, 0.0, 0.01]);
                assert!(uv.iter().all(|c| c.is_finite()));
                for (c, most) in [
                    (d.du_dx, 2.0),
                    (d.dv_dx, 1.0),
                    (d.du_dy, 2.0),
                    (d.dv_dy, 1.0),
                ] {
                    assert!(c.abs() <= most, "{p:?} {d:?}");
                }
            }
            // A thousandth beside the axis a pixel of a hundredth turns all the way.
            let (_, d) = map.one([1e-3, 0.7, 0.0], [0.01, 0.0, 0.0], [0.0, 0.0, 0.01]);
            assert_eq!(d.du_dy.abs(), 2.0);
        }
    }
}

//! The formulas of a round mapping at a pixel, coordinates and derivatives: over lane widths, and in f64.

use core::f32::consts::{FRAC_1_PI, TAU};

use texmap_math::glam::DVec3;
use texmap_math::simd::{Isa, Scalar, prelude::*};
use texmap_math::{Footprint, float};

use super::{CurvedShape, PerPixelProjection};
use crate::Origin;
use crate::spherical::Longitude;

/// A share of the distance from the middle below which a direction from the axis means nothing in f32.
const AXIS: f32 = 1e-12;
/// A vector shorter than this in the unit solid has no direction.
const NOTHING: f32 = 1e-30;

impl PerPixelProjection {
    /// uv of a point, and the footprint of a pixel along whose sides the point moves by `dx` and `dy`. NaN gives NaN.
    #[must_use]
    pub fn uv_at(&self, point: [f32; 3], dx: [f32; 3], dy: [f32; 3]) -> ([f32; 2], Footprint) {
        let [u, v, du_dx, dv_dx, du_dy, dv_dy] = self.pixels(Scalar, [point, dx, dy]);
        ([u, v], Footprint::new(du_dx, dv_dx, du_dy, dv_dy))
    }

    /// u, v, du/dx, dv/dx, du/dy and dv/dy of points that move by `dx` and `dy`.
    #[inline(always)]
    pub(super) fn pixels<I: Isa>(&self, i: I, [point, dx, dy]: [[I::F32; 3]; 3]) -> [I::F32; 6] {
        let [x, y, z] = self.in_solid(i, point);
        let (x, y, z) = (
            x + self.rows[0][3],
            y + self.rows[1][3],
            z + self.rows[2][3],
        );
        let longitude = Longitude::of(i, x, z);
        let (up, height) = match self.shape {
            CurvedShape::Sphere => (longitude.latitude(i, y), y),
            CurvedShape::Cylinder => (y, i.f32(0.0)),
        };
        let (v, sign) = match self.origin {
            Origin::TopLeft => (i.f32(0.5) - up, -1.0),
            Origin::BottomLeft => (i.f32(0.5) + up, 1.0),
        };
        let near = Nearness::of(i, x, height, z);
        let [du_dx, up_dx] = near.change(i, self.in_solid(i, dx), self.shape);
        let [du_dy, up_dy] = near.change(i, self.in_solid(i, dy), self.shape);
        let [across, rise] = [self.repeat[0], sign * self.repeat[1]];
        [
            longitude.turns * across,
            v * self.repeat[1],
            du_dx * across,
            up_dx * rise,
            du_dy * across,
            up_dy * rise,
        ]
    }

    /// A direction in the space of the unit solid.
    #[inline(always)]
    fn in_solid<I: Isa>(&self, i: I, d: [I::F32; 3]) -> [I::F32; 3] {
        let [a, b, c] = &self.rows;
        [row(i, a, d), row(i, b, d), row(i, c, d)]
    }

    /// [`PerPixelProjection::uv_at`] in f64, for reading: uv, and `[du/dx, dv/dx, du/dy, dv/dy]`. On the axis there is no derivative: NaN.
    #[must_use]
    pub fn reference(&self, point: DVec3, dx: DVec3, dy: DVec3) -> ([f64; 2], [f64; 4]) {
        let q = self.unit_from_point.transform_point3(point);
        let (_, [u, latitude]) = crate::Shape::Sphere.uv(q, self.origin);
        let sign = match self.origin {
            Origin::TopLeft => -1.0,
            Origin::BottomLeft => 1.0,
        };
        let v = match self.shape {
            CurvedShape::Sphere => latitude,
            CurvedShape::Cylinder => 0.5 + sign * q.y,
        };
        let [across, down] = self.repeat.map(f64::from);
        let change = |d: DVec3| {
            let d = self.unit_from_point.transform_vector3(d);
            let square = q.x * q.x + q.z * q.z;
            let turn = (q.z * d.x - q.x * d.z) / square / core::f64::consts::TAU;
            let up = match self.shape {
                CurvedShape::Cylinder => d.y,
                CurvedShape::Sphere => {
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
}

#[inline(always)]
fn row<I: Isa>(i: I, r: &[f32; 4], d: [I::F32; 3]) -> I::F32 {
    i.f32(r[0]) * d[0] + i.f32(r[1]) * d[1] + i.f32(r[2]) * d[2]
}

/// The point at most one long, and what derivatives divide by.
#[derive(Clone, Copy)]
struct Nearness<I: Isa> {
    x: I::F32,
    y: I::F32,
    z: I::F32,
    /// One over the largest component.
    scale: I::F32,
    /// Distance from the axis; 0 on it.
    out: I::F32,
    /// One over its square, and over the square of the distance from the middle; 0 where there is none.
    per_out: I::F32,
    per_all: I::F32,
}

impl<I: Isa> Nearness<I> {
    #[inline(always)]
    fn of(i: I, x: I::F32, y: I::F32, z: I::F32) -> Self {
        let (zero, one) = (i.f32(0.0), i.f32(1.0));
        let most = x.abs().above(z.abs()).above(y.abs());
        let scale = most.simd_gt(NOTHING).select(one / most, zero);
        let (x, y, z) = (x * scale, y * scale, z * scale);
        let square = x * x + z * z;
        let off_axis = square.simd_gt(AXIS * AXIS);
        let all = square + y * y;
        Self {
            x,
            y,
            z,
            scale,
            out: off_axis.select(square.sqrt(), zero),
            per_out: off_axis.select(one / square, zero),
            per_all: all.simd_gt(0.0).select(one / all, zero),
        }
    }

    /// Changes of u and of the height for a change of the point in the unit solid.
    #[inline(always)]
    fn change(&self, i: I, [dx, dy, dz]: [I::F32; 3], shape: CurvedShape) -> [I::F32; 2] {
        let turn = (self.z * dx - self.x * dz) * self.scale * self.per_out * (1.0 / TAU);
        let turn = turn.clamp(i.f32(-0.5), i.f32(0.5));
        let up = match shape {
            CurvedShape::Cylinder => dy,
            CurvedShape::Sphere => {
                let out = (self.x * dx + self.z * dz) * self.out * self.per_out;
                (self.out * dy - self.y * out) * self.scale * self.per_all * FRAC_1_PI
            }
        };
        [turn, up]
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{frame, pixel};
    use super::*;
    use crate::{Placement, Shape};

    fn exact(shape: CurvedShape, p: DVec3) -> [f64; 2] {
        let q = frame().placed().unwrap().point(p);
        match shape {
            CurvedShape::Sphere => Shape::Sphere.uv(q, Origin::TopLeft).1,
            CurvedShape::Cylinder => {
                let u = Shape::Sphere.uv(q, Origin::TopLeft).1[0];
                [u, 0.5 - q.y]
            }
        }
    }

    #[test]
    fn uv_and_derivatives_are_those_of_the_formula() {
        let wide = |v: [f32; 3]| DVec3::from(v.map(f64::from));
        let whole = |d: f64| d - float::floor(d + 0.5);
        for shape in [CurvedShape::Cylinder, CurvedShape::Sphere] {
            let map = PerPixelProjection::new(shape, &frame(), [1.0; 2], Origin::TopLeft).unwrap();
            let mut leaps = 0;
            for (i, j) in (-40..40).flat_map(|i| (-40..40).map(move |j| (i, j))) {
                let [p, dx, dy] = pixel(i, j);
                let q = frame().placed().unwrap().point(wide(p));
                if q.x * q.x + q.z * q.z < 1e-3 {
                    continue;
                }
                let (uv, d) = map.uv_at(p, dx, dy);
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
                let next = map.uv_at(pixel(i, j + 1)[0], dx, dy).0;
                leaps += usize::from((next[0] - uv[0]).abs() > 0.5);
            }
            assert!(leaps > 5, "the pixels meet the seam: {leaps}");
        }
    }

    #[test]
    fn footprints_do_not_leap_at_the_seam_and_stay_finite_at_the_pole() {
        for shape in [CurvedShape::Cylinder, CurvedShape::Sphere] {
            let upright = Placement::upright(DVec3::ZERO, DVec3::splat(2.0));
            let map =
                PerPixelProjection::new(shape, &upright, [4.0, 2.0], Origin::BottomLeft).unwrap();
            let at = |z: f32| map.uv_at([0.8, 0.2, z], [0.0, 0.0, 0.01], [0.0, 0.01, 0.0]);
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
                let (uv, d) = map.uv_at(p, [0.01, 0.0, 0.0], [0.0, 0.0, 0.01]);
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
            let (_, d) = map.uv_at([1e-3, 0.7, 0.0], [0.01, 0.0, 0.0], [0.0, 0.0, 0.01]);
            assert_eq!(d.du_dy.abs(), 2.0);
        }
    }
}

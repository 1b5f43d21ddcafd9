//! The unit solids: a vector in, a point on the unit square out, in f64.
//!
//! Conventions of the Brown "Ray" assignments (the root of SUSTech CS lecture 08): every solid fills [-0.5, 0.5];
//! the cone stands on its base with the apex at (0, 0.5, 0).

use core::f64::consts::{PI, TAU};
use texmap_math::{deterministic_f64, float, glam::DVec3};

/// The solid whose surface is unrolled.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Shape {
    /// The square z = 0, seen from +Z.
    Plane,
    /// Side around y, a cap above and one below.
    Cylinder,
    /// Side around y that narrows to the apex, a cap below.
    Cone,
    /// Longitude and latitude.
    Sphere,
    /// Six squares.
    Box,
}

/// A piece of a solid that has texture coordinates of its own, the whole unit square.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ShapeFace {
    /// All of a plane or of a sphere.
    Whole,
    /// The curved side of a cylinder or cone.
    Side,
    /// The cap at y = 0.5, or the upper side of a box.
    Top,
    /// The cap at y = -0.5, or the lower side of a box.
    Bottom,
    /// The side of a box at x = 0.5.
    Right,
    /// The side of a box at x = -0.5.
    Left,
    /// The side of a box at z = 0.5.
    Front,
    /// The side of a box at z = -0.5.
    Back,
}

impl Shape {
    /// Part and texture coordinates of a point on the unit solid.
    ///
    /// Caps are told from sides by y within 1e-9 of the cap. u is in (0, 1] around an axis and 0.5 on it; v is in
    /// [0, 1]. Points off the solid get the coordinates of the formulae (a sphere ignores the radius). Within
    /// 1e-12 of the formula away from poles; NaN gives NaN.
    #[must_use]
    pub fn uv(self, p: DVec3, origin: Origin) -> (ShapeFace, [f64; 2]) {
        let part = match self {
            Self::Plane | Self::Sphere => ShapeFace::Whole,
            Self::Cylinder if p.y >= 0.5 - 1e-9 => ShapeFace::Top,
            Self::Cylinder | Self::Cone if p.y <= -0.5 + 1e-9 => ShapeFace::Bottom,
            Self::Cylinder | Self::Cone => ShapeFace::Side,
            Self::Box if p.is_nan() => {
                return (ShapeFace::Front, [f64::NAN; 2]);
            }
            Self::Box => ShapeFace::facing(p),
        };
        (part, self.place(part, p).uv(origin))
    }

    /// The point of the unit solid with these coordinates: the inverse of [`Shape::uv`] away from poles.
    ///
    /// A part that the solid lacks is read as its whole or its side.
    #[must_use]
    pub fn point(self, part: ShapeFace, uv: [f64; 2], origin: Origin) -> DVec3 {
        let (u, h) = (
            uv[0],
            match origin {
                Origin::TopLeft => 0.5 - uv[1],
                Origin::BottomLeft => uv[1] - 0.5,
            },
        );
        let (sin, cos) = deterministic_f64::sin_cos(TAU * (1.0 - u));
        match (self, part) {
            (Self::Plane, _) => DVec3::new(u - 0.5, h, 0.0),
            (Self::Sphere, _) => {
                let (up, out) = deterministic_f64::sin_cos(h * PI);
                DVec3::new(cos * out, up, sin * out) * 0.5
            }
            (Self::Box | Self::Cylinder, ShapeFace::Top) => DVec3::new(u - 0.5, 0.5, -h),
            (Self::Box | Self::Cylinder | Self::Cone, ShapeFace::Bottom) => {
                DVec3::new(u - 0.5, -0.5, h)
            }
            (Self::Cylinder, _) => DVec3::new(cos * 0.5, h, sin * 0.5),
            (Self::Cone, _) => DVec3::new(cos, 0.0, sin) * ((0.5 - h) * 0.5) + DVec3::Y * h,
            (Self::Box, ShapeFace::Right) => DVec3::new(0.5, h, 0.5 - u),
            (Self::Box, ShapeFace::Left) => DVec3::new(-0.5, h, u - 0.5),
            (Self::Box, ShapeFace::Back) => DVec3::new(0.5 - u, h, -0.5),
            (Self::Box, _) => DVec3::new(u - 0.5, h, 0.5),
        }
    }

    /// The coordinates of a point on one part's unit square. The component along the part's normal does not matter.
    pub(crate) fn place(self, part: ShapeFace, p: DVec3) -> SurfacePoint {
        match (self, part) {
            (Self::Sphere, _) => sphere(p),
            (Self::Cylinder | Self::Cone, ShapeFace::Side) => SurfacePoint {
                u: around(p.x, p.z),
                h: p.y,
            },
            _ => part.flat(p),
        }
    }

    /// Point and part at which a ray from the middle of the unit solid along `d` meets the surface. A plane is no solid: its
    /// point is the end of the vector of length 0.5. `d` must not be zero.
    pub(crate) fn cast(self, d: DVec3) -> (ShapeFace, DVec3) {
        let out = float::sqrt(d.x * d.x + d.z * d.z);
        match self {
            Self::Plane => (
                ShapeFace::Whole,
                d * (0.5 / float::sqrt(out * out + d.y * d.y)),
            ),
            Self::Sphere => (ShapeFace::Whole, d),
            Self::Box => {
                let a = d.abs();
                (ShapeFace::facing(d), d * (0.5 / a.x.max(a.y).max(a.z)))
            }
            Self::Cylinder if d.y.abs() > out => (
                if d.y > 0.0 {
                    ShapeFace::Top
                } else {
                    ShapeFace::Bottom
                },
                d * (0.5 / d.y.abs()),
            ),
            Self::Cylinder => (ShapeFace::Side, d * (0.5 / out)),
            Self::Cone if -d.y >= out => (ShapeFace::Bottom, d * (0.5 / -d.y)),
            // On the side the radius is half the depth below the apex.
            Self::Cone => (ShapeFace::Side, d * (0.5 / (2.0 * out + d.y))),
        }
    }
}

/// The row of the image that v = 0 names.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Origin {
    /// v = 0 is the top row and v grows downward (glTF, and inside texmap).
    #[default]
    TopLeft,
    /// v = 0 is the bottom row and v grows upward (OBJ).
    BottomLeft,
}

/// A point on the unit square with its height measured from the middle. Either origin is one exact
/// addition away, without `1 - v`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SurfacePoint {
    /// Horizontal coordinate, 0 left, 1 right.
    pub(crate) u: f64,
    /// Height above the middle, -0.5 bottom, 0.5 top.
    pub(crate) h: f64,
}

impl SurfacePoint {
    pub(crate) fn uv(self, origin: Origin) -> [f64; 2] {
        match origin {
            Origin::TopLeft => [self.u, 0.5 - self.h],
            Origin::BottomLeft => [self.u, 0.5 + self.h],
        }
    }
}

impl ShapeFace {
    /// The side of a box of the largest absolute component. Equal ones are settled z before y before x, so that
    /// a tie has the same answer everywhere.
    pub(crate) fn facing(d: DVec3) -> Self {
        let a = d.abs();
        if a.z >= a.x && a.z >= a.y {
            if d.z < 0.0 { Self::Back } else { Self::Front }
        } else if a.y >= a.x {
            if d.y < 0.0 { Self::Bottom } else { Self::Top }
        } else if d.x < 0.0 {
            Self::Left
        } else {
            Self::Right
        }
    }

    /// The point `p` of the unit cube seen through this flat part from outside: the other two components.
    pub(crate) fn flat(self, p: DVec3) -> SurfacePoint {
        let [right, h] = self.seen(p);
        SurfacePoint { u: 0.5 + right, h }
    }

    /// Distances of `p` to the right of the middle and above it, seen through this flat part from outside.
    pub(crate) fn seen(self, p: DVec3) -> [f64; 2] {
        match self {
            Self::Right => [-p.z, p.y],
            Self::Left => [p.z, p.y],
            Self::Top => [p.x, -p.z],
            Self::Bottom => [p.x, p.z],
            Self::Back => [-p.x, p.y],
            Self::Front | Self::Whole | Self::Side => [p.x, p.y],
        }
    }

    /// Outward direction of a flat part; +Z for those that are not flat.
    pub(crate) fn outward(self) -> DVec3 {
        match self {
            Self::Right => DVec3::X,
            Self::Left => DVec3::NEG_X,
            Self::Top => DVec3::Y,
            Self::Bottom => DVec3::NEG_Y,
            Self::Back => DVec3::NEG_Z,
            Self::Front | Self::Whole | Self::Side => DVec3::Z,
        }
    }
}

/// Turns around the y axis: u in (0, 1], rising to a viewer's right, with the seam at +X; 0.5 on the axis itself.
pub(crate) fn around(x: f64, z: f64) -> f64 {
    if x == 0.0 && z == 0.0 {
        return 0.5;
    }
    let turn = deterministic_f64::atan2(z, x) / TAU;
    if turn < 0.0 { -turn } else { 1.0 - turn }
}

/// Longitude and latitude of the direction `d`; the length of `d` does not matter.
///
/// The latitude is `atan2(y, hypot(x, z))`: an arc sine loses half the digits near the poles.
pub(crate) fn sphere(d: DVec3) -> SurfacePoint {
    let largest = d.abs().max_element();
    // Squares of others are no numbers.
    let plain = (1e-140..1e140).contains(&largest) || largest == 0.0 || !largest.is_finite();
    let d = if plain { d } else { d / largest };
    let latitude = deterministic_f64::atan2(d.y, float::sqrt(d.x * d.x + d.z * d.z));
    SurfacePoint {
        u: around(d.x, d.z),
        h: latitude / PI,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn u_rises_to_the_viewers_right_and_jumps_only_at_plus_x() {
        // Seen from +Z the right hand is +X: u must grow from -X (0.5) over +Z (0.75) to +X (1).
        assert!((around(-1.0, 0.0) - 0.5).abs() < 1e-15);
        assert!((around(0.0, 1.0) - 0.75).abs() < 1e-15);
        assert!((around(1.0, 0.0) - 1.0).abs() < 1e-15);
        assert!(around(1.0, -1e-9) < 1e-9 && around(1.0, 1e-9) > 1.0 - 1e-9);
        // atan2's own jump at -X must not be one of u.
        assert!((around(-1.0, 1e-9) - around(-1.0, -1e-9)).abs() < 1e-9);
        assert_eq!(around(0.0, 0.0), 0.5);
    }

    #[test]
    fn latitude_keeps_its_digits_at_the_pole() {
        let tiny = 1e-9;
        let h = sphere(DVec3::new(tiny, 1.0, 0.0)).h;
        assert!((0.5 - h - tiny / PI).abs() < 1e-16);
        assert_eq!(
            sphere(DVec3::new(3.0, 4.0, -1.0)),
            sphere(DVec3::new(6.0, 8.0, -2.0))
        );
    }

    /// Property 26: in [0, 1], independent of the radius, inverse, and u to the viewer's right.
    #[test]
    fn the_inverse_returns_the_point() {
        let parts = [
            (Shape::Plane, &[ShapeFace::Whole][..]),
            (Shape::Sphere, &[ShapeFace::Whole]),
            (
                Shape::Cylinder,
                &[ShapeFace::Side, ShapeFace::Top, ShapeFace::Bottom],
            ),
            (Shape::Cone, &[ShapeFace::Side, ShapeFace::Bottom]),
            (
                Shape::Box,
                &[
                    ShapeFace::Right,
                    ShapeFace::Left,
                    ShapeFace::Top,
                    ShapeFace::Bottom,
                    ShapeFace::Front,
                    ShapeFace::Back,
                ],
            ),
        ];
        for (shape, parts) in parts {
            for (part, origin) in parts
                .iter()
                .flat_map(|p| [(*p, Origin::TopLeft), (*p, Origin::BottomLeft)])
            {
                for (i, j) in (0..400).map(|k| (k % 20, k / 20)) {
                    let uv = [f64::from(i) / 21.0 + 0.03, f64::from(j) / 21.0 + 0.03];
                    let p = shape.point(part, uv, origin);
                    let (found, back) = shape.uv(p, origin);
                    assert_eq!(found, part, "{shape:?} {uv:?}");
                    assert!(
                        (back[0] - uv[0]).abs() < 1e-12 && (back[1] - uv[1]).abs() < 1e-12,
                        "{shape:?} {uv:?} {back:?}"
                    );
                }
            }
        }
    }

    #[test]
    fn rays_end_on_the_solid() {
        for k in 1..200 {
            let (s, c) = deterministic_f64::sin_cos(f64::from(k) * 0.7);
            let d = DVec3::new(s * 3.0, c * 2.0 + 0.01 * f64::from(k - 100), s * c + 0.3);
            let (part, p) = Shape::Cylinder.cast(d);
            let out = float::sqrt(p.x * p.x + p.z * p.z);
            assert!(if part == ShapeFace::Side {
                (out - 0.5).abs() < 1e-14 && p.y.abs() <= 0.5 + 1e-15
            } else {
                out <= 0.5 + 1e-14 && (p.y.abs() - 0.5).abs() < 1e-15
            });
            let (part, p) = Shape::Cone.cast(d);
            let out = float::sqrt(p.x * p.x + p.z * p.z);
            assert!(
                p.y.abs() <= 0.5 + 1e-14
                    && if part == ShapeFace::Side {
                        (out - (0.5 - p.y) / 2.0).abs() < 1e-14
                    } else {
                        out <= 0.5 + 1e-14
                    }
            );
            assert!((Shape::Box.cast(d).1.abs().max_element() - 0.5).abs() < 1e-15);
        }
    }

    #[test]
    fn equal_axes_choose_z_then_y_then_x() {
        assert_eq!(
            ShapeFace::facing(DVec3::new(1.0, 1.0, -1.0)),
            ShapeFace::Back
        );
        assert_eq!(
            ShapeFace::facing(DVec3::new(-1.0, -1.0, 0.5)),
            ShapeFace::Bottom
        );
        assert_eq!(
            ShapeFace::facing(DVec3::new(-1.0, 0.9, 0.5)),
            ShapeFace::Left
        );
        // The signed reading (largest component, not largest absolute one) would have said +Y here.
        assert_eq!(
            ShapeFace::facing(DVec3::new(-3.0, 1.0, 0.0)),
            ShapeFace::Left
        );
    }

    #[test]
    fn a_sphere_has_any_size_and_nan_stays() {
        let unit = DVec3::new(0.3, -0.5, 0.7);
        let (_, right) = Shape::Sphere.uv(unit, Origin::TopLeft);
        for size in [1e-300, 1e-170, 1e170, 1e300] {
            let (_, uv) = Shape::Sphere.uv(unit * size, Origin::TopLeft);
            assert!(
                (uv[0] - right[0]).abs() < 1e-12 && (uv[1] - right[1]).abs() < 1e-12,
                "{size}"
            );
        }
        for shape in [
            Shape::Plane,
            Shape::Cylinder,
            Shape::Cone,
            Shape::Sphere,
            Shape::Box,
        ] {
            let p = DVec3::splat(f64::NAN);
            assert!(
                shape.uv(p, Origin::TopLeft).1.iter().all(|c| c.is_nan()),
                "{shape:?}"
            );
        }
        let (_, uv) = Shape::Box.uv(DVec3::new(f64::NAN, 0.1, 0.2), Origin::TopLeft);
        assert!(uv.iter().all(|c| c.is_nan()));
    }
}

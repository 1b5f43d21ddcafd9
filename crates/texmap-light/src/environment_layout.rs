mod place;

use core::f64::consts::{FRAC_1_PI, FRAC_PI_2, FRAC_PI_4, PI, TAU};
use core::fmt;
use core::str::FromStr;

use texmap_math::deterministic_f64;
use texmap_math::float::sqrt;
use texmap_math::glam::{DVec2, DVec3};

/// A way to unfold the sphere of directions onto one or more rectangles.
///
/// Coordinates (u, v) lie in 0..=1 with v downwards; texel (i, j) of a w x h face has its centre at
/// ((i + 1/2)/w, (j + 1/2)/h). Right-handed directions, +Y up. All computations are f64 with texmap's own
/// trigonometry; a direction that comes back from its layout differs by less than 1e-12.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum EnvironmentLayout {
    /// Six faces +X -X +Y -Y +Z -Z, oriented as in Vulkan 1.4 (section Cube Map Face Selection), z before y
    /// before x where components tie.
    Cube,
    /// The cube with `atan` of the face coordinates, which evens out the solid angles. Their ratio is sqrt 2 instead of 5.2.
    TanCube,
    /// Longitude and latitude, 2:1: +Y is the top row, -Z the middle, +X to its right.
    LatLong,
    /// The octahedron unfolded into a square, -Z in its corners (Cigolle et al. 2014).
    Octahedron,
    /// The octahedron with equal solid angles (Clarberg 2008).
    EqualAreaOctahedron,
    /// Two paraboloids, +Z and -Z (Heidrich and Seidel 1998).
    DualParaboloid,
    /// The mirror ball of OpenGL's GL_SPHERE_MAP, seen along -Z: -Z is its rim, a blind spot.
    SphereMap,
}

/// A name that is not a layout's.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UnknownLayout;

impl fmt::Display for UnknownLayout {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("unknown layout: choose from")?;
        EnvironmentLayout::ALL
            .iter()
            .try_for_each(|chart| write!(f, " {}", chart.name()))
    }
}

impl core::error::Error for UnknownLayout {}

impl FromStr for EnvironmentLayout {
    type Err = UnknownLayout;

    fn from_str(name: &str) -> Result<Self, UnknownLayout> {
        Self::ALL
            .into_iter()
            .find(|chart| chart.name() == name)
            .ok_or(UnknownLayout)
    }
}

impl EnvironmentLayout {
    /// Every layout.
    pub const ALL: [Self; 7] = [
        Self::Cube,
        Self::TanCube,
        Self::LatLong,
        Self::Octahedron,
        Self::EqualAreaOctahedron,
        Self::DualParaboloid,
        Self::SphereMap,
    ];

    /// The name in files and flags.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Cube => "cube",
            Self::TanCube => "tan-cube",
            Self::LatLong => "lat-long",
            Self::Octahedron => "octahedron",
            Self::EqualAreaOctahedron => "equal-area-octahedron",
            Self::DualParaboloid => "dual-paraboloid",
            Self::SphereMap => "sphere-map",
        }
    }

    /// Rectangles of the layout.
    #[must_use]
    pub fn faces(self) -> usize {
        match self {
            Self::Cube | Self::TanCube => 6,
            Self::DualParaboloid => 2,
            _ => 1,
        }
    }

    /// Width over height of a face.
    #[must_use]
    pub fn aspect(self) -> u32 {
        if self == Self::LatLong { 2 } else { 1 }
    }

    /// Face and coordinates of a direction of any length. Zero and non-finite directions read as +Z.
    #[must_use]
    pub fn locate(self, direction: DVec3) -> (usize, DVec2) {
        let largest = direction.abs().max_element();
        let usable = direction.is_finite() && largest > 0.0;
        let d = if usable {
            direction / largest
        } else {
            DVec3::Z
        };
        match self {
            Self::Cube => cube(d, |x| x),
            Self::TanCube => cube(d, |x| deterministic_f64::atan(x) * (4.0 * FRAC_1_PI)),
            Self::LatLong => {
                let u = deterministic_f64::atan2(d.x, -d.z) / TAU + 0.5;
                let v = deterministic_f64::atan2(sqrt(d.x * d.x + d.z * d.z), d.y) * FRAC_1_PI;
                (0, DVec2::new(u, v))
            }
            Self::Octahedron => {
                let p = d.truncate() / (d.x.abs() + d.y.abs() + d.z.abs());
                (0, unit(if d.z < 0.0 { fold(p) } else { p }))
            }
            Self::EqualAreaOctahedron => {
                let d = d / d.length();
                let a = d.abs();
                // 1 - |z| without cancellation.
                let r = sqrt((a.x * a.x + a.y * a.y) / (1.0 + a.z));
                let y = r * deterministic_f64::atan2(a.y, a.x) / FRAC_PI_2;
                let p = DVec2::new(sign(d.x) * (r - y), sign(d.y) * y);
                (0, unit(if d.z < 0.0 { fold(p) } else { p }))
            }
            Self::DualParaboloid => {
                let d = d / d.length();
                (
                    usize::from(d.z < 0.0),
                    unit(d.truncate() / (1.0 + d.z.abs())),
                )
            }
            Self::SphereMap => {
                let d = d / d.length();
                // 1 + z without cancellation.
                let rise = if d.z < 0.0 {
                    (d.x * d.x + d.y * d.y) / (1.0 - d.z)
                } else {
                    1.0 + d.z
                };
                let m = sqrt(2.0 * rise);
                // Exactly -Z is any point of the rim.
                let p = if m > 0.0 { d.truncate() / m } else { DVec2::X };
                (0, unit(p))
            }
        }
    }

    /// Unit direction of a point of a face. Points outside of 0..=1 continue over the edge, as a border texel
    /// needs: onto the neighbour, across the pole, or (cubes, paraboloids) along the extended face. The corners of a
    /// sphere map, outside of its disc, give -Z, its rim.
    #[must_use]
    pub fn direction(self, face: usize, uv: DVec2) -> DVec3 {
        let p = DVec2::new(2.0 * uv.x - 1.0, 1.0 - 2.0 * uv.y);
        match self {
            Self::Cube => cube_direction(face, p),
            Self::TanCube => cube_direction(
                face,
                DVec2::new(
                    deterministic_f64::tan(p.x * FRAC_PI_4),
                    deterministic_f64::tan(p.y * FRAC_PI_4),
                ),
            ),
            Self::LatLong => {
                let (sin_lon, cos_lon) = deterministic_f64::sin_cos((uv.x - 0.5) * TAU);
                let (sin_lat, cos_lat) = deterministic_f64::sin_cos(uv.y * PI);
                DVec3::new(sin_lat * sin_lon, cos_lat, -sin_lat * cos_lon)
            }
            Self::Octahedron => {
                let p = wrap_square(p);
                let z = 1.0 - p.x.abs() - p.y.abs();
                let q = if z < 0.0 { fold(p) } else { p };
                normalize(q.extend(z))
            }
            Self::EqualAreaOctahedron => {
                let p = wrap_square(p);
                let a = p.abs();
                let signed = 1.0 - a.x - a.y;
                let r = 1.0 - signed.abs();
                let phi = if r > 0.0 {
                    ((a.y - a.x) / r + 1.0) * FRAC_PI_4
                } else {
                    0.0
                };
                let (sin, cos) = deterministic_f64::sin_cos(phi);
                let radius = r * sqrt(2.0 - r * r);
                let z = sign(signed) * (1.0 - r * r);
                DVec3::new(sign(p.x) * cos * radius, sign(p.y) * sin * radius, z)
            }
            Self::DualParaboloid => {
                let r2 = p.length_squared();
                let z = if face == 0 { 1.0 - r2 } else { r2 - 1.0 };
                (p * 2.0).extend(z) / (1.0 + r2)
            }
            Self::SphereMap => {
                let r2 = p.length_squared();
                let n = sqrt(if r2 < 1.0 { 1.0 - r2 } else { 0.0 });
                let p = if r2 < 1.0 { p } else { DVec2::ZERO };
                (p * (2.0 * n)).extend(2.0 * n * n - 1.0)
            }
        }
    }

    /// Solid angle (steradians) of texel (x, y) of a `width` x `height` face, by its corners. It is 0 where the layout
    /// shows nothing. The faces of all texels add up to 4 pi, but for paraboloids, whose corners show again what
    /// the other face has: those count 0. Not so of faces of a few texels, which are no triangles within a hemisphere.
    #[must_use]
    pub fn solid_angle(self, face: usize, (x, y): (u32, u32), (width, height): (u32, u32)) -> f64 {
        let at = |i: f64, j: f64| {
            DVec2::new(
                (f64::from(x) + i) / f64::from(width),
                (f64::from(y) + j) / f64::from(height),
            )
        };
        if matches!(self, Self::DualParaboloid | Self::SphereMap) {
            let centre = (at(0.0, 0.0) + at(1.0, 1.0)) - DVec2::ONE;
            if centre.length_squared() > 1.0 {
                return 0.0;
            }
        }
        let corner = |i: f64, j: f64| self.direction(face, at(i, j));
        let (a, b) = (corner(0.0, 0.0), corner(1.0, 0.0));
        let (c, d) = (corner(1.0, 1.0), corner(0.0, 1.0));
        triangle(a, b, c) + triangle(a, c, d)
    }
}

/// Solid angle of a spherical triangle (van Oosterom and Strackee 1983).
fn triangle(a: DVec3, b: DVec3, c: DVec3) -> f64 {
    let volume = a.dot(b.cross(c)).abs();
    2.0 * deterministic_f64::atan2(volume, 1.0 + a.dot(b) + b.dot(c) + c.dot(a))
}

fn cube(d: DVec3, warp: impl Fn(f64) -> f64) -> (usize, DVec2) {
    let a = d.abs();
    let (face, major, s, t) = if a.z >= a.x && a.z >= a.y {
        if d.z > 0.0 {
            (4, a.z, d.x, d.y)
        } else {
            (5, a.z, -d.x, d.y)
        }
    } else if a.y >= a.x {
        if d.y > 0.0 {
            (2, a.y, d.x, -d.z)
        } else {
            (3, a.y, d.x, d.z)
        }
    } else if d.x > 0.0 {
        (0, a.x, -d.z, d.y)
    } else {
        (1, a.x, d.z, d.y)
    };
    (face, unit(DVec2::new(warp(s / major), warp(t / major))))
}

fn cube_direction(face: usize, p: DVec2) -> DVec3 {
    normalize(match face {
        0 => DVec3::new(1.0, p.y, -p.x),
        1 => DVec3::new(-1.0, p.y, p.x),
        2 => DVec3::new(p.x, 1.0, -p.y),
        3 => DVec3::new(p.x, -1.0, p.y),
        4 => DVec3::new(p.x, p.y, 1.0),
        _ => DVec3::new(-p.x, p.y, -1.0),
    })
}

/// Face coordinates 0..=1, v down, from -1..=1, y up.
fn unit(p: DVec2) -> DVec2 {
    DVec2::new(0.5 * p.x + 0.5, 0.5 - 0.5 * p.y)
}

fn normalize(d: DVec3) -> DVec3 {
    d / d.length()
}

/// 1 for zero too, of either sign: the folds need a side.
fn sign(x: f64) -> f64 {
    if x < 0.0 { -1.0 } else { 1.0 }
}

/// Between the inner and the outer triangles of an unfolded octahedron.
fn fold(p: DVec2) -> DVec2 {
    DVec2::new(sign(p.x) * (1.0 - p.y.abs()), sign(p.y) * (1.0 - p.x.abs()))
}

/// A point beyond an edge of an unfolded octahedron lies across that edge, turned round.
fn wrap_square(p: DVec2) -> DVec2 {
    let p = if p.x.abs() > 1.0 {
        DVec2::new(sign(p.x) * 2.0 - p.x, -p.y)
    } else {
        p
    };
    if p.y.abs() > 1.0 {
        DVec2::new(-p.x, sign(p.y) * 2.0 - p.y)
    } else {
        p
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use alloc::vec::Vec;

    pub(crate) fn directions(count: u32) -> impl Iterator<Item = DVec3> {
        let mut seed = 1u64;
        let mut next = move || {
            seed = seed
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (seed >> 11) as f64 / (1u64 << 53) as f64
        };
        (0..count).map(move |_| {
            let z = 2.0 * next() - 1.0;
            let (s, c) = deterministic_f64::sin_cos(next() * TAU);
            let r = sqrt(1.0 - z * z);
            DVec3::new(r * c, r * s, z)
        })
    }

    /// Axes, edges and corners of the cube, with zeros of both signs.
    pub(crate) fn special() -> impl Iterator<Item = DVec3> {
        let values = [-1.0, -0.0, 0.0, 1.0];
        let grid =
            (0..64).map(move |i| DVec3::new(values[i % 4], values[i / 4 % 4], values[i / 16]));
        grid.filter(|d| d.length() > 0.0)
    }

    /// Texels count up to the largest number.
    #[test]
    fn the_last_texel_has_an_angle() {
        for layout in EnvironmentLayout::ALL {
            let last = u32::MAX;
            let angle = layout.solid_angle(0, (last - 1, last - 1), (last, last));
            assert!((0.0..1e-9).contains(&angle), "{layout:?}: {angle}");
            let _outside = layout.solid_angle(0, (last, last), (last, last));
        }
    }

    #[test]
    fn directions_come_back() {
        for chart in EnvironmentLayout::ALL {
            for d in directions(20_000).chain(special()) {
                let (face, uv) = chart.locate(d * 7.0);
                assert!(face < chart.faces());
                assert!(
                    uv.min_element() >= -1e-15 && uv.max_element() <= 1.0 + 1e-15,
                    "{chart:?} {d} {uv}"
                );
                let back = chart.direction(face, uv);
                // The rim of the sphere map is one direction: it loses half of the digits.
                let bound = if chart == EnvironmentLayout::SphereMap {
                    1e-7
                } else {
                    1e-12
                };
                assert!(
                    (back - d / d.length()).length() < bound,
                    "{chart:?} {d}: {back}"
                );
            }
        }
    }

    #[test]
    fn length_and_bad_directions_do_not_matter() {
        for chart in EnvironmentLayout::ALL {
            for d in directions(100) {
                assert_eq!(chart.locate(d * 1024.0), chart.locate(d));
                let (face, uv) = chart.locate(d * 1e-300);
                assert!(face == chart.locate(d).0 && (uv - chart.locate(d).1).length() < 1e-12);
            }
            for bad in [
                DVec3::ZERO,
                DVec3::splat(f64::NAN),
                DVec3::new(f64::INFINITY, 0.0, 0.0),
            ] {
                assert_eq!(chart.locate(bad), chart.locate(DVec3::Z), "{chart:?}");
            }
        }
    }

    /// A step over an edge of a face lands where the neighbour's texels are, not across the layout.
    #[test]
    fn borders_continue_onto_their_neighbours() {
        for chart in EnvironmentLayout::ALL {
            if chart == EnvironmentLayout::SphereMap {
                continue;
            }
            for face in 0..chart.faces() {
                for i in 0..64 {
                    let (t, e) = ((f64::from(i) + 0.5) / 64.0, 1e-6);
                    for (inside, outside) in [
                        ((e, t), (-e, t)),
                        ((1.0 - e, t), (1.0 + e, t)),
                        ((t, e), (t, -e)),
                        ((t, 1.0 - e), (t, 1.0 + e)),
                    ] {
                        let a = chart.direction(face, DVec2::new(inside.0, inside.1));
                        let b = chart.direction(face, DVec2::new(outside.0, outside.1));
                        assert!(
                            (a - b).length() < 2e-5,
                            "{chart:?} {face} {inside:?}: {a} {b}"
                        );
                        assert!((b.length() - 1.0).abs() < 1e-9);
                    }
                }
            }
        }
    }

    #[test]
    fn solid_angles_cover_the_sphere_and_have_the_known_ratios() {
        let known = [5.20, 1.41, 0.0, 5.20, 1.0, 4.0, 1.0];
        for (chart, known) in EnvironmentLayout::ALL.into_iter().zip(known) {
            let (w, h) = (64 * chart.aspect(), 64);
            let mut angles = Vec::new();
            for face in 0..chart.faces() {
                angles.extend((0..w * h).map(|i| chart.solid_angle(face, (i % w, i / w), (w, h))));
            }
            let total: f64 = angles.iter().sum();
            assert!(
                (total / (4.0 * PI) - 1.0).abs() < 0.03,
                "{chart:?}: {total}"
            );
            let inner: Vec<f64> = angles.into_iter().filter(|a| *a > 0.0).collect();
            let (min, max) = inner
                .iter()
                .fold((f64::MAX, 0.0f64), |(l, h), a| (l.min(*a), h.max(*a)));
            if known > 0.0 && chart != EnvironmentLayout::SphereMap {
                assert!(
                    (max / min / known - 1.0).abs() < 0.12,
                    "{chart:?}: {}",
                    max / min
                );
            }
        }
    }

    #[test]
    fn names_round_trip() {
        for chart in EnvironmentLayout::ALL {
            assert_eq!(chart.name().parse(), Ok(chart));
        }
        assert_eq!("ball".parse::<EnvironmentLayout>(), Err(UnknownLayout));
    }
}

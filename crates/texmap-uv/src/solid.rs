//! The unit solids: a vector in, a place on the unit square out.
//!
//! Conventions of the Brown "Ray" assignments (the root of SUSTech CS lecture 08): every solid fills [-0.5, 0.5].

use texmap_math::{det, float, glam::DVec3};

/// Which row of the image v = 0 names.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Origin {
    /// v = 0 is the top row and v grows downward (glTF, and inside texmap).
    #[default]
    TopLeft,
    /// v = 0 is the bottom row and v grows upward (OBJ).
    BottomLeft,
}

/// A place on the unit square with its height measured from the middle, so that either origin is one exact
/// addition away and nobody computes `1 - v`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Place {
    /// Horizontal coordinate, 0 left, 1 right.
    pub(crate) u: f64,
    /// Height above the middle, -0.5 bottom, 0.5 top.
    pub(crate) h: f64,
}

impl Place {
    pub(crate) fn uv(self, origin: Origin) -> [f64; 2] {
        match origin {
            Origin::TopLeft => [self.u, 0.5 - self.h],
            Origin::BottomLeft => [self.u, 0.5 + self.h],
        }
    }
}

/// The side of a box that a vector leaves through.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum BoxFace {
    /// +X.
    PosX,
    /// -X.
    NegX,
    /// +Y.
    PosY,
    /// -Y.
    NegY,
    /// +Z.
    PosZ,
    /// -Z.
    NegZ,
}

impl BoxFace {
    /// The face of the largest absolute component; equal ones are settled z before y before x, so that a tie
    /// has the same answer everywhere.
    pub(crate) fn of(d: DVec3) -> Self {
        let a = d.abs();
        if a.z >= a.x && a.z >= a.y {
            if d.z < 0.0 { Self::NegZ } else { Self::PosZ }
        } else if a.y >= a.x {
            if d.y < 0.0 { Self::NegY } else { Self::PosY }
        } else if d.x < 0.0 {
            Self::NegX
        } else {
            Self::PosX
        }
    }

    /// The point `p` of the unit cube seen through this face from outside: the other two components.
    pub(crate) fn place(self, p: DVec3) -> Place {
        match self {
            Self::PosX => Place {
                u: 0.5 - p.z,
                h: p.y,
            },
            Self::NegX => Place {
                u: 0.5 + p.z,
                h: p.y,
            },
            Self::PosY => Place {
                u: 0.5 + p.x,
                h: -p.z,
            },
            Self::NegY => Place {
                u: 0.5 + p.x,
                h: p.z,
            },
            Self::PosZ => Place {
                u: 0.5 + p.x,
                h: p.y,
            },
            Self::NegZ => Place {
                u: 0.5 - p.x,
                h: p.y,
            },
        }
    }
}

/// The plane z = 0, seen from +Z.
pub(crate) fn plane(p: DVec3) -> Place {
    Place {
        u: 0.5 + p.x,
        h: p.y,
    }
}

/// Turns around the y axis: u in (0, 1], rising to a viewer's right, with the seam at +X; 0.5 on the axis itself.
pub(crate) fn around(x: f64, z: f64) -> f64 {
    if x == 0.0 && z == 0.0 {
        return 0.5;
    }
    let turn = det::atan2(z, x) / core::f64::consts::TAU;
    if turn < 0.0 { -turn } else { 1.0 - turn }
}

/// Longitude and latitude of the direction `d`; the length of `d` does not matter.
///
/// The latitude is `atan2(y, hypot(x, z))`: an arc sine loses half the digits near the poles.
pub(crate) fn sphere(d: DVec3) -> Place {
    let latitude = det::atan2(d.y, float::sqrt(d.x * d.x + d.z * d.z));
    Place {
        u: around(d.x, d.z),
        h: latitude / core::f64::consts::PI,
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
        assert!((0.5 - h - tiny / core::f64::consts::PI).abs() < 1e-16);
        assert_eq!(
            sphere(DVec3::new(3.0, 4.0, -1.0)),
            sphere(DVec3::new(6.0, 8.0, -2.0))
        );
    }

    #[test]
    fn equal_axes_choose_z_then_y_then_x() {
        assert_eq!(BoxFace::of(DVec3::new(1.0, 1.0, -1.0)), BoxFace::NegZ);
        assert_eq!(BoxFace::of(DVec3::new(-1.0, -1.0, 0.5)), BoxFace::NegY);
        assert_eq!(BoxFace::of(DVec3::new(-1.0, 0.9, 0.5)), BoxFace::NegX);
        // The signed reading (largest component, not largest absolute one) would have said +Y here.
        assert_eq!(BoxFace::of(DVec3::new(-3.0, 1.0, 0.0)), BoxFace::NegX);
    }
}

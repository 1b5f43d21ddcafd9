//! Texture frames O, U, V and the vectors that turn a view direction into texture coordinates. Source: Brackeen, "Developing
//! Games in Java", 2003, chapter 8.

use core::fmt;

use glam::{DMat4, DVec2, DVec3};

/// A frame of a texture in space: the point of uv (u, v) is `o + u*U + v*V`. U and V are independent; they need neither unit
/// length nor a right angle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TextureFrame {
    /// The point of uv (0, 0).
    pub o: DVec3,
    /// Step in space for u from 0 to 1.
    pub u: DVec3,
    /// Step in space for v from 0 to 1.
    pub v: DVec3,
}

/// Error of points that give no frame.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum FrameError {
    /// A coordinate is NaN or infinite.
    NonFinite,
    /// U and V are zero or parallel: the sine of their angle is too small.
    DegenerateAxes {
        /// Sine of the angle between U and V (0 if a vector is zero).
        sine: f64,
    },
    /// The three positions lie on a line.
    DegenerateTriangle,
    /// The three uv points lie on a line.
    DegenerateUv,
}

impl fmt::Display for FrameError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NonFinite => write!(f, "texture frame: a coordinate is NaN or infinite"),
            Self::DegenerateAxes { sine } => {
                write!(
                    f,
                    "texture frame: U and V are zero or parallel (sine of their angle {sine:e})"
                )
            }
            Self::DegenerateTriangle => write!(f, "texture frame: the triangle has no area"),
            Self::DegenerateUv => write!(f, "texture frame: the three uv points lie on a line"),
        }
    }
}

impl core::error::Error for FrameError {}

/// Below this sine of an angle two directions count as parallel.
const PARALLEL: f64 = 1e-10;

impl TextureFrame {
    /// A frame from its three vectors.
    ///
    /// # Errors
    /// [`FrameError::NonFinite`], or [`FrameError::DegenerateAxes`] for U and V that are zero or parallel.
    pub fn new(o: DVec3, u: DVec3, v: DVec3) -> Result<Self, FrameError> {
        if !(o.is_finite() && u.is_finite() && v.is_finite()) {
            return Err(FrameError::NonFinite);
        }
        let sine = sine_between(u, v);
        if sine < PARALLEL {
            Err(FrameError::DegenerateAxes { sine })
        } else {
            Ok(Self { o, u, v })
        }
    }

    /// The frame in which the three positions have the three uv.
    ///
    /// # Errors
    /// [`FrameError`] for a number that is not finite, a triangle without area, in space or in uv.
    pub fn from_triangle(positions: [DVec3; 3], uv: [DVec2; 3]) -> Result<Self, FrameError> {
        if !(positions.iter().all(|p| p.is_finite()) && uv.iter().all(|p| p.is_finite())) {
            return Err(FrameError::NonFinite);
        }
        let (e1, e2) = (positions[1] - positions[0], positions[2] - positions[0]);
        if sine_between(e1, e2) < PARALLEL {
            return Err(FrameError::DegenerateTriangle);
        }
        let (d1, d2) = (uv[1] - uv[0], uv[2] - uv[0]);
        let area = d1.perp_dot(d2);
        if area.abs() < PARALLEL * d1.length() * d2.length() || area == 0.0 {
            return Err(FrameError::DegenerateUv);
        }
        let u = (e1 * d2.y - e2 * d1.y) / area;
        let v = (e2 * d1.x - e1 * d2.x) / area;
        Self::new(positions[0] - u * uv[0].x - v * uv[0].y, u, v)
    }

    /// The point of a uv.
    #[must_use]
    pub fn point(&self, uv: DVec2) -> DVec3 {
        self.o + self.u * uv.x + self.v * uv.y
    }

    /// The uv of a point: of the point itself in the frame's plane, else of its foot along the normal.
    #[must_use]
    pub fn uv(&self, point: DVec3) -> DVec2 {
        let n = self.normal();
        let d = point - self.o;
        let area = n.length_squared();
        DVec2::new(d.cross(self.v).dot(n) / area, self.u.cross(d).dot(n) / area)
    }

    /// The plane's normal U x V, not normalised.
    #[must_use]
    pub fn normal(&self) -> DVec3 {
        self.u.cross(self.v)
    }

    /// The frame seen through an affine matrix: `o` moves as a point, U and V as vectors.
    #[must_use]
    pub fn transform(&self, m: DMat4) -> Self {
        Self {
            o: m.transform_point3(self.o),
            u: m.transform_vector3(self.u),
            v: m.transform_vector3(self.v),
        }
    }

    /// The magic vectors. The frame must be in camera space: the eye at the origin.
    #[must_use]
    pub fn texgen(&self) -> PlanarTexgen {
        PlanarTexgen {
            a: self.v.cross(self.o),
            b: self.o.cross(self.u),
            c: self.u.cross(self.v),
        }
    }
}

/// A = V x O, B = O x U, C = U x V. For a view direction W through the eye, the ray meets the frame's plane at
/// u = A.W / C.W, v = B.W / C.W: Cramer's rule, for any independent U and V, whatever the length and sign of W.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlanarTexgen {
    /// V x O.
    pub a: DVec3,
    /// O x U.
    pub b: DVec3,
    /// U x V.
    pub c: DVec3,
}

impl PlanarTexgen {
    /// The uv where the line through the eye along `w` meets the plane. None where it does not (parallel: the horizon; or overflow).
    #[must_use]
    pub fn uv(&self, w: DVec3) -> Option<DVec2> {
        let c = self.c.dot(w);
        let uv = DVec2::new(self.a.dot(w) / c, self.b.dot(w) / c);
        (c != 0.0 && uv.is_finite()).then_some(uv)
    }
}

/// Sine of the angle between two vectors, 0 where one is zero. Scaled, so that no length over- or underflows.
fn sine_between(u: DVec3, v: DVec3) -> f64 {
    let (lu, lv) = (u.abs().max_element(), v.abs().max_element());
    if !(lu > 0.0 && lv > 0.0 && lu.is_finite() && lv.is_finite()) {
        return 0.0;
    }
    let (u, v) = (u / lu, v / lv);
    u.cross(v).length() / (u.length() * v.length())
}

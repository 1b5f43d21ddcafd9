//! Plane-to-plane projective maps. Source: Heckbert, "Fundamentals of Texture Mapping and Image Warping", 1989,
//! section 2.2.

use core::fmt;

use glam::{DMat3, DVec2, DVec3};

use crate::float::sqrt;

/// A homography: (x, y) goes to (X/W, Y/W), where (X, Y, W) is the matrix times (x, y, 1). Its scale means nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Homography {
    matrix: DMat3,
}

/// Error of points or a matrix that give no homography.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum HomographyError {
    /// A coordinate or matrix element is NaN or infinite.
    NonFinite,
    /// Three corners lie (nearly) on a line.
    Collinear {
        /// The middle corner of the three.
        corner: usize,
        /// Twice the area of the corner's triangle, over the square of the quad's size.
        area: f64,
    },
    /// The corners do not form a convex quad in the given order.
    NotConvex {
        /// A corner that turns the other way.
        corner: usize,
    },
    /// The matrix has no usable inverse.
    Singular {
        /// The condition number, infinite where not even that exists.
        condition: f64,
    },
}

impl fmt::Display for HomographyError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NonFinite => write!(f, "homography: a coordinate is NaN or infinite"),
            Self::Collinear { corner, area } => write!(
                f,
                "homography: corner {corner} lies nearly on the line of its neighbours (relative area {area:e}); give four corners of which no three are in line"
            ),
            Self::NotConvex { corner } => write!(
                f,
                "homography: the quad is not convex at corner {corner}; give the corners in order around the quad"
            ),
            Self::Singular { condition } => write!(
                f,
                "homography: the matrix is singular (condition {condition:e})"
            ),
        }
    }
}

impl core::error::Error for HomographyError {}

/// Below this relative area a corner counts as lying on the line of its neighbours.
const COLLINEAR: f64 = 1e-9;

impl Homography {
    /// The identity.
    pub const IDENTITY: Self = Self {
        matrix: DMat3::IDENTITY,
    };

    /// A homography from its matrix (columns as glam stores them; acts on column vectors).
    ///
    /// # Errors
    /// [`HomographyError::NonFinite`], or [`HomographyError::Singular`] beyond a condition number of 1e15.
    pub fn from_matrix(matrix: DMat3) -> Result<Self, HomographyError> {
        if !matrix.is_finite() {
            return Err(HomographyError::NonFinite);
        }
        let h = Self { matrix };
        let condition = h.condition();
        // The comparison is false for NaN as well.
        if condition < 1e15 {
            Ok(h)
        } else {
            Err(HomographyError::Singular { condition })
        }
    }

    /// From the unit square to a quad: (0,0), (1,0), (1,1), (0,1) go to the four corners, in that order. Heckbert's closed form.
    ///
    /// # Errors
    /// [`HomographyError`] where three corners are nearly collinear or the quad is not convex.
    pub fn from_square(quad: [DVec2; 4]) -> Result<Self, HomographyError> {
        let low = quad[0].min(quad[1]).min(quad[2]).min(quad[3]);
        let high = quad[0].max(quad[1]).max(quad[2]).max(quad[3]);
        let extent = (high - low).max_element();
        if extent > 0.0 && extent.is_finite() && !PLAIN.contains(&extent) {
            // Areas of the quad are beyond the numbers: those of the quad in its own size are not.
            let matrix = Self::from_square(quad.map(|p| p / extent))?.matrix;
            let sized = DMat3::from_diagonal(DVec3::new(extent, extent, 1.0));
            return Ok(Self {
                matrix: sized * matrix,
            });
        }
        check_quad(quad)?;
        let [p0, p1, p2, p3] = quad;
        let sum = p0 - p1 + p2 - p3;
        let (d1, d2) = (p1 - p2, p3 - p2);
        let area = d1.perp_dot(d2);
        let g = sum.perp_dot(d2) / area;
        let h = d1.perp_dot(sum) / area;
        let x = p1 - p0 + p1 * g;
        let y = p3 - p0 + p3 * h;
        Ok(Self {
            matrix: DMat3::from_cols(x.extend(g), y.extend(h), p0.extend(1.0)),
        })
    }

    /// From one quad to another, corner by corner.
    ///
    /// # Errors
    /// As [`Homography::from_square`], for either quad.
    pub fn from_quads(from: [DVec2; 4], to: [DVec2; 4]) -> Result<Self, HomographyError> {
        Ok(Self::from_square(from)?
            .inverse()
            .then(&Self::from_square(to)?))
    }

    /// The matrix.
    #[must_use]
    pub const fn matrix(&self) -> DMat3 {
        self.matrix
    }

    /// The image of a point; None on the line that goes to infinity (and where the result overflows).
    #[must_use]
    pub fn apply(&self, p: DVec2) -> Option<DVec2> {
        let q = self.apply_homogeneous(p);
        let r = DVec2::new(q.x / q.z, q.y / q.z);
        (q.z != 0.0 && r.is_finite()).then_some(r)
    }

    /// The image before the division: (X, Y, W). For a homography made from quads W is above 0 inside the source quad.
    #[must_use]
    pub fn apply_homogeneous(&self, p: DVec2) -> DVec3 {
        self.matrix * p.extend(1.0)
    }

    /// The inverse, by the adjugate: only products and sums, the scale being free. Divided by its largest element.
    #[must_use]
    pub fn inverse(&self) -> Self {
        let m = plain(self.matrix);
        let (a, b, c) = (m.x_axis, m.y_axis, m.z_axis);
        let adjugate = DMat3::from_cols(b.cross(c), c.cross(a), a.cross(b)).transpose();
        let determinant = a.dot(b.cross(c));
        // The adjugate's sign is that of the determinant; keep W positive where it was.
        Self {
            matrix: unit_scale(if determinant < 0.0 {
                adjugate * -1.0
            } else {
                adjugate
            }),
        }
    }

    /// First `self`, then `next`.
    #[must_use]
    pub fn then(&self, next: &Self) -> Self {
        Self {
            matrix: unit_scale(plain(next.matrix) * plain(self.matrix)),
        }
    }

    /// The condition number of the matrix in the Frobenius norm, at least 3; infinite for a singular one. A round trip
    /// through the inverse loses about this many units of rounding.
    #[must_use]
    pub fn condition(&self) -> f64 {
        let m = unit_scale(self.matrix);
        let (a, b, c) = (m.x_axis, m.y_axis, m.z_axis);
        let adjugate = [b.cross(c), c.cross(a), a.cross(b)];
        let determinant = a.dot(adjugate[0]).abs();
        let norm = sqrt(a.length_squared() + b.length_squared() + c.length_squared());
        let inverse = sqrt(adjugate.iter().map(|v| v.length_squared()).sum());
        if determinant > 0.0 {
            norm * inverse / determinant
        } else {
            f64::INFINITY
        }
    }
}

/// Magnitudes whose products of three are within the range of numbers.
const PLAIN: core::ops::Range<f64> = 1e-60..1e60;

/// The matrix, in another scale where products of its elements would leave the range of numbers.
fn plain(m: DMat3) -> DMat3 {
    match PLAIN.contains(&largest(&m)) {
        true => m,
        false => unit_scale(m),
    }
}

fn largest(m: &DMat3) -> f64 {
    let elements = m.to_cols_array();
    let larger = |l: f64, v: &f64| if v.abs() > l { v.abs() } else { l };
    elements.iter().fold(0.0, larger)
}

/// The matrix over its largest element (unchanged where that is 0 or not finite).
fn unit_scale(m: DMat3) -> DMat3 {
    let largest = largest(&m);
    if largest > 0.0 && largest.is_finite() {
        m * (1.0 / largest)
    } else {
        m
    }
}

fn check_quad(quad: [DVec2; 4]) -> Result<(), HomographyError> {
    if !quad.iter().all(|p| p.is_finite()) {
        return Err(HomographyError::NonFinite);
    }
    let size = (quad[2] - quad[0]).length_squared() + (quad[3] - quad[1]).length_squared();
    let area = |i: usize| {
        let (p, q, r) = (quad[(i + 3) % 4], quad[i], quad[(i + 1) % 4]);
        (q - p).perp_dot(r - q) / size
    };
    let areas = [area(0), area(1), area(2), area(3)];
    for (corner, area) in areas.iter().enumerate() {
        if !(area.abs() > COLLINEAR && area.is_finite()) {
            return Err(HomographyError::Collinear {
                corner,
                area: *area,
            });
        }
    }
    let left_turns = areas.iter().filter(|a| **a > 0.0).count();
    let odd_sign = match left_turns {
        0 | 4 => return Ok(()),
        1 => 1.0,
        _ => -1.0,
    };
    let corner = areas.iter().position(|a| a * odd_sign > 0.0).unwrap_or(0);
    Err(HomographyError::NotConvex { corner })
}

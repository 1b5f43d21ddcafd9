//! Planes over the screen from unsnapped homogeneous vertices, in f64, about a local origin.
use crate::clip::Hom;

/// `a x + b y + c`, x and y in pixels from the origin that the plane was made about.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Plane {
    pub a: f64,
    pub b: f64,
    pub c: f64,
}

impl Plane {
    pub(crate) fn at(self, x: f64, y: f64) -> f64 {
        (self.c + self.b * y) + self.a * x
    }

    /// Largest absolute value over the square of half side `reach` about the origin.
    pub(crate) fn largest(self, reach: f64) -> f64 {
        self.c.abs() + (self.a.abs() + self.b.abs()) * reach
    }

    /// Smallest value over that square.
    pub(crate) fn smallest(self, reach: f64) -> f64 {
        self.c - (self.a.abs() + self.b.abs()) * reach
    }

    pub(crate) fn is_finite(self) -> bool {
        self.a.is_finite() && self.b.is_finite() && self.c.is_finite()
    }
}

/// The rows that turn three vertex values into a plane.
///
/// For vertices (X_i, Y_i, w_i) the plane through value v_i / w_i at (X_i / w_i, Y_i / w_i) solves
/// `a X_i + b Y_i + c w_i = v_i`: homogeneous, so vertices at or behind the eye need no cut (Olano and Greer 1997).
#[derive(Debug, Clone, Copy)]
pub(crate) struct Solver {
    rows: [[f64; 3]; 3],
    inverse: f64,
}

impl Solver {
    /// About the origin (`ox`, `oy`) in pixels. `None` when the vertices span no area.
    pub(crate) fn new(v: &[Hom; 3], ox: f64, oy: f64) -> Option<Self> {
        let p = v.map(|v| [v.x - ox * v.w, v.y - oy * v.w, v.w]);
        let rows = [cross(p[1], p[2]), cross(p[2], p[0]), cross(p[0], p[1])];
        let determinant = p[0][0] * rows[0][0] + p[0][1] * rows[0][1] + p[0][2] * rows[0][2];
        let inverse = 1.0 / determinant;
        (determinant != 0.0 && inverse.is_finite()).then_some(Self { rows, inverse })
    }

    /// The plane of value / w.
    pub(crate) fn plane(&self, v: [f64; 3]) -> Plane {
        let r = &self.rows;
        let k = |i: usize| (v[0] * r[0][i] + v[1] * r[1][i] + v[2] * r[2][i]) * self.inverse;
        Plane {
            a: k(0),
            b: k(1),
            c: k(2),
        }
    }
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

/// Twice the signed area of the triangle times the product of the three w: its sign is the facing, also where some w are
/// negative. y points down, so a front face is negative.
pub(crate) fn determinant(v: &[Hom; 3]) -> f64 {
    let p = v.map(|v| [v.x, v.y, v.w]);
    let n = cross(p[1], p[2]);
    p[0][0] * n[0] + p[0][1] * n[1] + p[0][2] * n[2]
}

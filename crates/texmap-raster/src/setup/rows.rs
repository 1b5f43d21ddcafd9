//! Interpolation along rows: exact at nodes, linear between them.

use texmap_math::simd::{Scalar, prelude::*};

use super::wide::finite;
use super::{Fragment, Shape, TriangleSetup};
use crate::Interp;
use crate::coverage::edge::{Edge, row_span};

/// Evaluation of perspective attributes.
#[derive(Debug, Clone, Copy)]
pub(super) enum Rows {
    /// At the pixel.
    Exact,
    /// Between exact nodes on the row.
    Nodes {
        edges: [Edge; 3],
        width: i32,
        spacing: Spacing,
    },
}

#[derive(Debug, Clone, Copy)]
pub(super) enum Spacing {
    Pixels(u32),
    /// Tolerance of attributes 0 and 1.
    Error(f64),
}

pub(super) fn rows(shape: &Shape<'_>) -> Rows {
    let spacing = match shape.interp {
        Interp::Span(n) => Spacing::Pixels(n),
        Interp::WithinError(tolerance) => {
            Spacing::Error(f64::from(tolerance) / f64::from(shape.interp_scale))
        }
        Interp::Perspective | Interp::Affine | Interp::Subdivided(_) => return Rows::Exact,
    };
    Rows::Nodes {
        edges: shape.edges,
        width: shape.width,
        spacing,
    }
}

impl TriangleSetup {
    /// Exact at two nodes on the row, linear between them.
    pub(super) fn between_nodes(
        &self,
        edges: &[Edge; 3],
        width: i32,
        spacing: Spacing,
        x: u32,
        y: u32,
        out: &mut Fragment,
    ) {
        let (px, py) = self.local(x, y);
        let (px, py) = (f64::from(px), f64::from(py));
        self.at_f64(px, py, out);
        let Some((first, last)) = row_span(edges, y as i32, 0, width - 1) else {
            return;
        };
        // Node positions from the origin, and the pixel's position between them.
        let [first, last] = [first, last].map(|x| f64::from(x - self.origin[0]) + 0.5);
        let [a, b] = match spacing {
            Spacing::Pixels(n) => {
                let n = f64::from(n);
                let start = first + ((px - first) / n).trunc_to_int() * n;
                let end = start + n;
                [start, if end < last { end } else { last }]
            }
            Spacing::Error(tolerance) => self.error_nodes(first, last, px, py, tolerance),
        };
        let length = b - a;
        if length.is_nan() || length <= 0.0 {
            return;
        }
        let t = (px - a) / length;
        let inv_w = |x: f64| self.w.clamp(Scalar, self.w.at(Scalar, x, py));
        let [wa, wb] = [a, b].map(inv_w);
        for (k, ranged) in self.attributes[..self.count].iter().enumerate() {
            if self.is_linear(k) {
                continue;
            }
            let [ua, ub] =
                [(a, wa), (b, wb)].map(|(x, w)| ranged.clamp(Scalar, ranged.at(Scalar, x, py) / w));
            let between = (ua * (1.0 - t) + ub * t) as f32;
            out.values[k] = F32s::<Scalar>::clamp(between, ranged.lo, ranged.hi);
            out.ddx[k] = finite(Scalar, (ub - ua) / length) as f32;
        }
    }

    /// The two nodes about `px` such that attributes 0 and 1 are off by at most the tolerance between any two nodes.
    ///
    /// Between nodes with W = a and W = b (W linear along the row) an affine span is off by at most
    /// `|du| |sqrt b - sqrt a| / (sqrt b + sqrt a)`. With `du = K (1/a - 1/b)`, K = (U_x W - U W_x) / W_x constant along
    /// the row, that is `K (a^-1/2 - b^-1/2)^2`: nodes at equal steps of W^-1/2 share the error evenly.
    fn error_nodes(&self, first: f64, last: f64, px: f64, py: f64, tolerance: f64) -> [f64; 2] {
        let slope = self.w.plane[0];
        let at = |x: f64| self.w.clamp(Scalar, self.w.at(Scalar, x, py));
        let (w1, w2) = (at(first), at(last));
        if slope == 0.0 || w1 == w2 {
            return [first, last];
        }
        let mut largest = 0.0;
        for (k, ranged) in self.attributes[..self.count.min(2)].iter().enumerate() {
            if !self.is_linear(k) {
                let turn = ranged.plane[0] * w1 - ranged.at(Scalar, first, py) * slope;
                let size = (turn / slope).abs();
                if size > largest {
                    largest = size;
                }
            }
        }
        let root = |w: f64| 1.0 / texmap_math::float::sqrt(w);
        let (g1, g2) = (root(w1), root(w2));
        // The nodes are exact only to rounding: a hair below the tolerance keeps the sum below it.
        let parts = (g2 - g1).abs() * texmap_math::float::sqrt(largest / (tolerance * 0.999));
        // More parts than pixels: every pixel is a node.
        if parts.is_nan() || parts > last - first {
            return [px, px];
        }
        let parts = parts.trunc_to_int() + 1.0;
        let node = |k: f64| {
            if k <= 0.0 {
                first
            } else if k >= parts {
                last
            } else {
                let g = g1 + (g2 - g1) * (k / parts);
                let x = first + (1.0 / (g * g) - w1) / slope;
                let x = if x > first { x } else { first };
                if x < last { x } else { last }
            }
        };
        let g = root(at(px));
        let k = ((g - g1) / (g2 - g1) * parts).trunc_to_int();
        // Rounding may put the pixel a hair outside its part; the neighbouring part then holds it.
        if px < node(k) {
            [node(k - 1.0), node(k)]
        } else if px > node(k + 1.0) {
            [node(k + 1.0), node(k + 2.0)]
        } else {
            [node(k), node(k + 1.0)]
        }
    }
}

trait Truncate {
    /// Towards zero, for values in the range of i64.
    fn trunc_to_int(self) -> Self;
}

impl Truncate for f64 {
    fn trunc_to_int(self) -> Self {
        self as i64 as Self
    }
}

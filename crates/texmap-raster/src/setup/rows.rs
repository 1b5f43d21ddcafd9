//! Interpolation along rows: exact at nodes, linear between them.

use texmap_math::simd::{Scalar, prelude::*};

use super::wide::finite;
use super::{Shape, TriangleSetup};
use crate::coverage::edge::{Edge, row_span};
use crate::{Interp, MAX_ATTRIBUTES};

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

/// The part of a row that its pixels share: its ends, and the two nodes about the pixel that was last asked for, with the attributes there.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RowNodes {
    y: u32,
    /// Centres of the first and last pixel from the origin; `None` for a row without pixels.
    ends: Option<[f64; 2]>,
    parts: Parts,
    /// The left node's number and both positions; NaN before a pixel was asked for.
    number: f64,
    nodes: [f64; 2],
    /// Perspective attributes at both.
    values: [[f64; 2]; MAX_ATTRIBUTES],
    /// Their changes to the right between the two.
    slopes: [f32; MAX_ATTRIBUTES],
}

/// Division of a row into parts.
#[derive(Debug, Clone, Copy)]
enum Parts {
    Whole,
    Pixels(f64),
    /// So many parts of equal steps of W^-1/2, from the first root to the last. `w` is W at the first pixel, `slope` its change.
    Roots {
        roots: [f64; 2],
        parts: f64,
        w: f64,
        slope: f64,
    },
    /// Every pixel is a node.
    Exact,
}

impl RowNodes {
    pub(crate) fn is_of(&self, y: u32) -> bool {
        self.y == y
    }

    /// True if `px` lies between the two nodes that are known, on none that it may share with the parts beside.
    fn holds(&self, px: f64) -> bool {
        let [a, b] = self.nodes;
        match self.parts {
            Parts::Whole => !self.number.is_nan(),
            Parts::Pixels(_) => a <= px && px < b,
            Parts::Roots { .. } => a < px && px < b,
            Parts::Exact => false,
        }
    }

    /// The nodes about `px` and the number of the left one.
    fn about(&self, setup: &TriangleSetup, [first, last]: [f64; 2], px: f64) -> (f64, [f64; 2]) {
        match self.parts {
            Parts::Whole => (0.0, [first, last]),
            Parts::Exact => (px, [px, px]),
            Parts::Pixels(n) => {
                let number = ((px - first) / n).trunc_to_int();
                let start = first + number * n;
                let end = start + n;
                (number, [start, if end < last { end } else { last }])
            }
            Parts::Roots { roots, parts, .. } => {
                let [g1, g2] = roots;
                let g = root(setup.w_at(px, f64::from(setup.local(0, self.y).1)));
                let k = ((g - g1) / (g2 - g1) * parts).trunc_to_int();
                let node = |k: f64| self.root_node([first, last], k);
                // Rounding may put the pixel a hair outside its part; the neighbouring part then holds it.
                let k = if px < node(k) {
                    k - 1.0
                } else if px > node(k + 1.0) {
                    k + 1.0
                } else {
                    k
                };
                (k, [node(k), node(k + 1.0)])
            }
        }
    }

    /// Position of a node of [`Parts::Roots`].
    fn root_node(&self, [first, last]: [f64; 2], k: f64) -> f64 {
        let Parts::Roots {
            roots: [g1, g2],
            parts,
            w,
            slope,
        } = self.parts
        else {
            return first;
        };
        if k <= 0.0 {
            first
        } else if k >= parts {
            last
        } else {
            let g = g1 + (g2 - g1) * (k / parts);
            let x = first + (1.0 / (g * g) - w) / slope;
            let x = if x > first { x } else { first };
            if x < last { x } else { last }
        }
    }
}

fn root(w: f64) -> f64 {
    1.0 / texmap_math::float::sqrt(w)
}

impl TriangleSetup {
    /// The nodes of a row, which [`between_nodes`](Self::between_nodes) takes for its pixels; `None` for a triangle that is exact
    /// everywhere.
    pub(crate) fn row_nodes(&self, y: u32) -> Option<RowNodes> {
        let Rows::Nodes {
            edges,
            width,
            spacing,
        } = &self.rows
        else {
            return None;
        };
        let centre = |x: i32| f64::from(x - self.origin[0]) + 0.5;
        let ends = row_span(edges, y as i32, 0, width - 1).map(|(a, b)| [centre(a), centre(b)]);
        let parts = match (*spacing, ends) {
            (Spacing::Pixels(n), _) => Parts::Pixels(f64::from(n)),
            (Spacing::Error(tolerance), Some(ends)) => self.error_parts(ends, y, tolerance),
            (Spacing::Error(_), None) => Parts::Exact,
        };
        Some(RowNodes {
            y,
            ends,
            parts,
            number: f64::NAN,
            nodes: [0.0; 2],
            values: [[0.0; 2]; MAX_ATTRIBUTES],
            slopes: [0.0; MAX_ATTRIBUTES],
        })
    }

    /// Gives `put` the perspective attributes of a pixel of the row with their change to the right: exact at the two nodes about it,
    /// linear between them. Nothing where the pixel's exact values hold.
    pub(crate) fn between_nodes(
        &self,
        row: &mut RowNodes,
        x: u32,
        mut put: impl FnMut(usize, f32, f32),
    ) {
        let (px, py) = self.local(x, row.y);
        let (px, py) = (f64::from(px), f64::from(py));
        let Some(ends) = row.ends else {
            return;
        };
        if !row.holds(px) {
            let (number, nodes) = row.about(self, ends, px);
            let length = nodes[1] - nodes[0];
            if length.is_nan() || length <= 0.0 {
                return;
            }
            if row.number != number {
                (row.number, row.nodes) = (number, nodes);
                let w = nodes.map(|x| self.w_at(x, py));
                for (k, ranged) in self.attributes[..self.count].iter().enumerate() {
                    let at = |x: f64, w: f64| ranged.clamp(Scalar, ranged.at(Scalar, x, py) / w);
                    let [ua, ub] = [at(nodes[0], w[0]), at(nodes[1], w[1])];
                    row.values[k] = [ua, ub];
                    row.slopes[k] = finite(Scalar, (ub - ua) / length) as f32;
                }
            }
        }
        let [a, b] = row.nodes;
        let t = (px - a) / (b - a);
        for (k, ranged) in self.attributes[..self.count].iter().enumerate() {
            if self.is_linear(k) {
                continue;
            }
            let [ua, ub] = row.values[k];
            let between = (ua * (1.0 - t) + ub * t) as f32;
            let value = F32s::<Scalar>::clamp(between, ranged.lo, ranged.hi);
            put(k, value, row.slopes[k]);
        }
    }

    fn w_at(&self, x: f64, y: f64) -> f64 {
        self.w.clamp(Scalar, self.w.at(Scalar, x, y))
    }

    /// The parts of a row such that attributes 0 and 1 are off by at most the tolerance between any two nodes.
    ///
    /// Between nodes with W = a and W = b (W linear along the row) an affine span is off by at most
    /// `|du| |sqrt b - sqrt a| / (sqrt b + sqrt a)`. With `du = K (1/a - 1/b)`, K = (U_x W - U W_x) / W_x constant along
    /// the row, that is `K (a^-1/2 - b^-1/2)^2`: nodes at equal steps of W^-1/2 share the error evenly.
    fn error_parts(&self, [first, last]: [f64; 2], y: u32, tolerance: f64) -> Parts {
        let slope = self.w.plane[0];
        let py = f64::from(self.local(0, y).1);
        let (w1, w2) = (self.w_at(first, py), self.w_at(last, py));
        if slope == 0.0 || w1 == w2 {
            return Parts::Whole;
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
        let (g1, g2) = (root(w1), root(w2));
        // The nodes are exact only to rounding: a hair below the tolerance keeps the sum below it.
        let parts = (g2 - g1).abs() * texmap_math::float::sqrt(largest / (tolerance * 0.999));
        // More parts than pixels: every pixel is a node.
        if parts.is_nan() || parts > last - first {
            return Parts::Exact;
        }
        Parts::Roots {
            roots: [g1, g2],
            parts: parts.trunc_to_int() + 1.0,
            w: w1,
            slope,
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

//! Exact edge functions with the top-left rule. Sources: MIT 6.837, lecture 6, slide 14; Pineda 1988; Direct3D 11.3 functional
//! specification, section 3.4.2.

use crate::fixed::{FixedPoint, SUBPIXEL_ONE};

/// The edge function e(p) = dx (p.y - p0.y) - dy (p.x - p0.x) of the edge from p0 to p1 in 24.8: exact in i64, above 0 on the right
/// hand of the direction of travel with y down. `e = a x + b y + c`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Edge {
    /// Change of e per 1/256 pixel to the right.
    pub a: i64,
    /// Change of e per 1/256 pixel down.
    pub b: i64,
    /// e at the origin.
    pub c: i64,
    /// True if points exactly on the edge belong to it.
    pub top_left: bool,
}

impl Edge {
    /// The edge from `p0` to `p1`. Positions are those of [`fixed`](crate::fixed), within 2^29: products of others leave i64.
    #[inline]
    #[must_use]
    pub const fn new(p0: FixedPoint, p1: FixedPoint) -> Self {
        let dx = p1.x as i64 - p0.x as i64;
        let dy = p1.y as i64 - p0.y as i64;
        // The inside is on the right hand: an edge that rises is a left one, a level one that runs right is a top one.
        Self {
            a: -dy,
            b: dx,
            c: dy * p0.x as i64 - dx * p0.y as i64,
            top_left: dy < 0 || (dy == 0 && dx > 0),
        }
    }

    /// e at a point.
    #[inline]
    #[must_use]
    pub const fn at(&self, p: FixedPoint) -> i64 {
        self.a * p.x as i64 + self.b * p.y as i64 + self.c
    }

    /// True if the point is inside, or on an edge that owns its points.
    #[inline]
    #[must_use]
    pub const fn contains(&self, p: FixedPoint) -> bool {
        self.at(p) >= self.threshold()
    }

    /// The least e that counts as inside: 0 for a top or left edge, else 1.
    #[inline]
    #[must_use]
    pub const fn threshold(&self) -> i64 {
        if self.top_left { 0 } else { 1 }
    }

    /// Change of e per whole pixel to the right and down.
    #[inline]
    #[must_use]
    pub const fn pixel_steps(&self) -> (i64, i64) {
        (self.a * SUBPIXEL_ONE as i64, self.b * SUBPIXEL_ONE as i64)
    }
}

/// The three edges of a triangle, turned so that its inside is positive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TriangleEdges {
    /// Edge `i` lies opposite vertex `i` (of the order given).
    pub edges: [Edge; 3],
    /// Twice the signed area in 1/65536 square pixel: above 0 where the vertices run clockwise on the screen (y down).
    pub area: i64,
}

impl TriangleEdges {
    /// Edges of a triangle, whichever way it turns; None without area.
    #[inline]
    #[must_use]
    pub const fn new(p: [FixedPoint; 3]) -> Option<Self> {
        let area = Edge::new(p[0], p[1]).at(p[2]);
        if area == 0 {
            return None;
        }
        let edges = if area > 0 {
            [
                Edge::new(p[1], p[2]),
                Edge::new(p[2], p[0]),
                Edge::new(p[0], p[1]),
            ]
        } else {
            [
                Edge::new(p[2], p[1]),
                Edge::new(p[0], p[2]),
                Edge::new(p[1], p[0]),
            ]
        };
        Some(Self { edges, area })
    }

    /// True if the triangle covers a point. Triangles that share an edge never both cover a point, and leave none between them.
    #[inline]
    #[must_use]
    pub const fn covers(&self, p: FixedPoint) -> bool {
        self.edges[0].contains(p) && self.edges[1].contains(p) && self.edges[2].contains(p)
    }
}

//! A grazing facet on a face of a shadow map: the texels whose squares it crosses, and its depths in them.

use core::ops::Range;

use texmap_math::bary;
use texmap_math::glam::{DVec2, DVec3, Vec3Swizzles};

use crate::DepthStrip;

/// A triangle on the map.
pub(super) struct Facet {
    /// Column and row in texels, and depth as the buffer holds it: larger is nearer to the light.
    pub(super) corners: [DVec3; 3],
    /// Half a side of the square around a texel's centre that the facet must meet, texels.
    pub(super) half: f64,
}

impl Facet {
    /// The nearest and the farthest depth.
    pub(super) fn ends(&self) -> [f64; 2] {
        let [a, b, c] = self.corners;
        [a.z.max(b.z).max(c.z), a.z.min(b.z).min(c.z)]
    }

    /// Rows and columns of a strip whose squares the facet may meet.
    pub(super) fn texels(&self, strip: &DepthStrip<'_>, size: u32) -> [Range<usize>; 2] {
        let [low, high] = self.bounds();
        let first = strip.first_row as f64;
        let rows = (strip.rows.len() / size as usize) as f64;
        [
            centres(low.y - first, high.y - first, rows),
            centres(low.x, high.x, f64::from(size)),
        ]
    }

    /// The bounding box of the centres whose squares the facet may meet.
    pub(super) fn bounds(&self) -> [DVec2; 2] {
        let [a, b, c] = self.corners.map(DVec3::xy);
        [a.min(b).min(c) - self.half, a.max(b).max(c) + self.half]
    }

    /// Moves each depth whose square at least two edges cross, and that lies between the edges' nearest and farthest depth in the
    /// square, to the farthest.
    pub(super) fn lower(&self, strip: &mut DepthStrip<'_>, size: u32, texels: &[Range<usize>; 2]) {
        let ends = self.ends();
        if !any(strip, size, texels, |stored| starts_at(ends, stored)) {
            return;
        }
        let [rows, columns] = texels;
        let few = rows.len() * columns.len() <= FEW;
        let edges = self.edges();
        for row in rows.clone() {
            let y = (strip.first_row + row) as f64 + 0.5;
            let spans = match few {
                true => [columns.clone(), 0..0, 0..0],
                false => self.crossed(&edges, y, size),
            };
            let row = &mut strip.rows[row * size as usize..][..size as usize];
            let mut done = 0;
            for span in spans {
                let start = done.max(span.start);
                let texels = row.get_mut(start..span.end).into_iter().flatten();
                for (column, stored) in (start..).zip(texels) {
                    if starts_at(ends, *stored) {
                        let centre = DVec2::new(column as f64 + 0.5, y);
                        let ends = self.ends_around(&edges, centre);
                        if starts_at(ends, *stored) && !self.lies_under(centre, *stored) {
                            *stored = ends[1] as f32;
                        }
                    }
                }
                done = done.max(span.end);
            }
        }
    }

    /// True if the facet covers a texel's centre and a stored depth lies before it there.
    fn lies_under(&self, centre: DVec2, stored: f32) -> bool {
        bary::screen(self.corners.map(DVec3::xy), centre).is_some_and(|weights| {
            let depth = bary::blend(weights, self.corners.map(|corner| corner.z));
            weights.iter().all(|weight| *weight >= 0.0) && stored > depth as f32 * (1.0 + ROUNDING)
        })
    }

    fn edges(&self) -> [Edge; 3] {
        let [a, b, c] = self.corners;
        [Edge::new(a, b), Edge::new(b, c), Edge::new(c, a)]
    }

    /// The nearest and the farthest depth of the edges in the square around a texel's centre; none if fewer than two cross it.
    fn ends_around(&self, edges: &[Edge; 3], centre: DVec2) -> [f64; 2] {
        let [low, high] = self.bounds();
        if (high - 2.0 * self.half).cmple(centre).all()
            && (low + 2.0 * self.half).cmpge(centre).all()
        {
            return self.ends();
        }
        let (none, mut crossing) = ([f64::NEG_INFINITY, f64::INFINITY], 0);
        let mut ends = none;
        for edge in edges {
            let [x, y] = [0, 1].map(|axis| edge.near(axis, centre[axis], self.half));
            let [from, to] = both(x, y);
            if from <= to {
                let (a, b) = (edge.at(from).z, edge.at(to).z);
                ends = [ends[0].max(a).max(b), ends[1].min(a).min(b)];
                crossing += 1;
            }
        }
        if crossing >= 2 { ends } else { none }
    }

    /// Columns whose squares at least two edges may cross, in a row whose centres are at `y`: three ranges, by their starts.
    fn crossed(&self, edges: &[Edge; 3], y: f64, size: u32) -> [Range<usize>; 3] {
        let [a, b, c] = edges.each_ref().map(|edge| {
            let part = edge.near(1, y, self.half);
            let [from, to] = part.map(|t| edge.at(t).x);
            if part == EMPTY {
                EMPTY
            } else {
                [from.min(to) - self.half, from.max(to) + self.half]
            }
        });
        let mut pairs = [both(a, b), both(b, c), both(c, a)];
        pairs.sort_by(|a, b| a[0].total_cmp(&b[0]));
        pairs.map(|[from, to]| centres(from, to, f64::from(size)))
    }
}

/// True if a test passes with any of the depths at these rows and columns, or if they are many.
pub(super) fn any(
    strip: &DepthStrip<'_>,
    size: u32,
    [rows, columns]: &[Range<usize>; 2],
    test: impl Fn(f32) -> bool,
) -> bool {
    rows.len() * columns.len() > FEW
        || rows.clone().any(|row| {
            let row = &strip.rows[row * size as usize..][columns.clone()];
            row.iter().any(|stored| test(*stored))
        })
}

/// Most texels around a facet that are looked at before its edges are.
const FEW: usize = 64;

/// Difference by which a stored depth, which is narrow, may lie before the surface that it is of, as a part of it.
const ROUNDING: f32 = 1e-6;

/// True if a stored depth lies between two depths of a facet, the nearest and the farthest. Neither 0, no surface, nor infinity, a tile
/// that is not reached, does.
fn starts_at([near, far]: [f64; 2], stored: f32) -> bool {
    near as f32 * (1.0 + ROUNDING) >= stored && (far as f32) < stored
}

/// An edge of a facet, from 0 to 1.
struct Edge {
    start: DVec3,
    along: DVec3,
    /// 1 / `along`.
    per_unit: DVec3,
}

impl Edge {
    fn new(start: DVec3, end: DVec3) -> Self {
        let along = end - start;
        Self {
            start,
            along,
            per_unit: along.recip(),
        }
    }

    fn at(&self, t: f64) -> DVec3 {
        self.start + self.along * t
    }

    /// The part of the edge whose coordinate `axis` lies within `half` of a place, as an interval that is [`EMPTY`] or within 0 to 1.
    fn near(&self, axis: usize, place: f64, half: f64) -> [f64; 2] {
        let start = self.start[axis];
        if self.along[axis] == 0.0 {
            return if (start - place).abs() <= half {
                [0.0, 1.0]
            } else {
                EMPTY
            };
        }
        let [a, b] = [place - half, place + half].map(|to| (to - start) * self.per_unit[axis]);
        let part = both([a.min(b), a.max(b)], [0.0, 1.0]);
        if part[0] <= part[1] { part } else { EMPTY }
    }
}

/// An interval without numbers.
const EMPTY: [f64; 2] = [f64::INFINITY, f64::NEG_INFINITY];

/// Texels whose centres lie between two places, of so many.
fn centres(from: f64, to: f64, count: f64) -> Range<usize> {
    // `ceil` and `floor` are calls on older processors.
    let end = (to + 0.5).clamp(0.0, count) as usize;
    let from = (from - 0.5).clamp(0.0, count);
    let start = from as usize;
    (start + usize::from(from > start as f64)).min(end)..end
}

/// The interval that two have in common; its end lies before its start if they have nothing.
fn both([a, b]: [f64; 2], [c, d]: [f64; 2]) -> [f64; 2] {
    [a.max(c), b.min(d)]
}

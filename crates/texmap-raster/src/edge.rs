//! Coverage: 24.8 fixed-point vertices, exact integer edge functions, the top-left rule.
use texmap_math::simd::{Isa, Scalar, prelude::*};

use crate::clip::{GUARD_BAND, Hom};

/// Sub-pixel bits of a vertex position.
pub const SUBPIXEL_BITS: u32 = 8;

/// Units a pixel.
pub(crate) const ONE: i64 = 1 << SUBPIXEL_BITS;

/// A vertex in 1/256 pixel, y down.
pub(crate) type Snapped = [i32; 2];

/// Largest snapped position: the guard band.
const LIMIT: i32 = GUARD_BAND as i32 * ONE as i32;

/// Nearest 1/256 pixel, halves up; w > 0. Positions are within the guard band but for rounding, which the clamp takes away.
pub(crate) fn snap(at: Hom) -> Snapped {
    // `as` saturates, so a value out of range cannot overflow.
    [at.x / at.w, at.y / at.w].map(|v| (to_units(Scalar, v) as i32).clamp(-LIMIT, LIMIT))
}

/// Pixels to the nearest 1/256, halves up, as whole numbers.
#[inline(always)]
pub(crate) fn to_units<I: Isa>(i: I, v: I::F64) -> I::F64 {
    // Adding and taking away 1.5 * 2^52 rounds to a whole number, to the even one at a half; then down where that went up.
    const WHOLE: f64 = 1.5 * (1u64 << 52) as f64;
    let shifted = v * ONE as f64 + 0.5;
    let near = (shifted + WHOLE) - WHOLE;
    near - near.simd_gt(shifted).select(i.f64(1.0), i.f64(0.0))
}

/// Twice the area in square units; positive when clockwise on the screen (y down).
pub(crate) fn area(v: &[Snapped; 3]) -> i64 {
    let d = |a: usize, k: usize| i64::from(v[a][k]) - i64::from(v[0][k]);
    d(1, 0) * d(2, 1) - d(2, 0) * d(1, 1)
}

/// `a x + b y + c >= 0` inside, at positions in 1/256 pixel. The top-left rule is in `c`: a centre exactly on an edge is
/// inside when that edge is a left edge or a horizontal top edge.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Edge {
    pub a: i64,
    pub b: i64,
    pub c: i64,
}

impl Edge {
    fn new(p: Snapped, q: Snapped) -> Self {
        let [px, py] = p.map(i64::from);
        let [qx, qy] = q.map(i64::from);
        let (a, b) = (py - qy, qx - px);
        let top_left = a > 0 || (a == 0 && b > 0);
        Self {
            a,
            b,
            c: -(a * px + b * py) - i64::from(!top_left),
        }
    }

    /// The value at a pixel's centre.
    pub(crate) fn at_pixel(self, x: i32, y: i32) -> i64 {
        self.a * centre(x) + self.b * centre(y) + self.c
    }
}

/// A pixel's centre in 1/256 pixel.
pub(crate) fn centre(pixel: i32) -> i64 {
    i64::from(pixel) * ONE + ONE / 2
}

/// The triangle as a sample at `offset` from a pixel's centre sees it: moved the other way.
pub(crate) fn seen_from(v: &[Snapped; 3], offset: [i32; 2]) -> [Snapped; 3] {
    v.map(|p| [p[0] - offset[0], p[1] - offset[1]])
}

/// The edges of a triangle with area, turned so that the inside is positive. `None` without area.
pub(crate) fn edges(v: &[Snapped; 3]) -> Option<[Edge; 3]> {
    let area = area(v);
    if area == 0 {
        return None;
    }
    let (p, q, r) = if area > 0 {
        (v[0], v[1], v[2])
    } else {
        (v[0], v[2], v[1])
    };
    Some([Edge::new(p, q), Edge::new(q, r), Edge::new(r, p)])
}

/// Pixels, both ends included.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct PixelBox {
    pub x0: i32,
    pub y0: i32,
    pub x1: i32,
    pub y1: i32,
}

impl PixelBox {
    /// The pixels whose centres lie in the bounding box of `v` grown by `margin` 1/256 pixel, within `width` x `height`.
    /// `None` when there are none.
    pub(crate) fn of(v: &[Snapped; 3], margin: i32, width: i32, height: i32) -> Option<Self> {
        let range = |k: usize, side: i32| {
            let lo = v[0][k].min(v[1][k]).min(v[2][k]) - margin;
            let hi = v[0][k].max(v[1][k]).max(v[2][k]) + margin;
            // First centre at or after lo, last centre at or before hi.
            ((lo + 127) >> SUBPIXEL_BITS).max(0)..=((hi - 128) >> SUBPIXEL_BITS).min(side - 1)
        };
        let (x, y) = (range(0, width), range(1, height));
        if x.is_empty() || y.is_empty() {
            return None;
        }
        Some(Self {
            x0: *x.start(),
            y0: *y.start(),
            x1: *x.end(),
            y1: *y.end(),
        })
    }

    pub(crate) fn intersect(self, other: Self) -> Option<Self> {
        let b = Self {
            x0: self.x0.max(other.x0),
            y0: self.y0.max(other.y0),
            x1: self.x1.min(other.x1),
            y1: self.y1.min(other.y1),
        };
        (b.x0 <= b.x1 && b.y0 <= b.y1).then_some(b)
    }
}

/// First and last pixel of row `y` that is inside, within `x0..=x1`. `None` when the row has none.
pub(crate) fn row_span(edges: &[Edge; 3], y: i32, x0: i32, x1: i32) -> Option<(i32, i32)> {
    let (mut first, mut last) = (i64::from(x0), i64::from(x1));
    for edge in edges {
        // a (256 x + 128) + rest >= 0
        let step = edge.a * ONE;
        let rest = edge.at_pixel(0, y);
        if step > 0 {
            first = first.max(-rest.div_euclid(step));
        } else if step < 0 {
            last = last.min(rest.div_euclid(-step));
        } else if rest < 0 {
            return None;
        }
    }
    (first <= last).then_some((first as i32, last as i32))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Calls `visit` for each pixel of `area` whose centre is inside, row by row from the top, left to right.
    fn cover(edges: &[Edge; 3], area: PixelBox, mut visit: impl FnMut(i32, i32)) {
        for y in area.y0..=area.y1 {
            let mut e = edges.map(|edge| edge.at_pixel(area.x0, y));
            for x in area.x0..=area.x1 {
                if e[0] >= 0 && e[1] >= 0 && e[2] >= 0 {
                    visit(x, y);
                }
                for (value, edge) in e.iter_mut().zip(edges) {
                    *value += edge.a * ONE;
                }
            }
        }
    }

    #[test]
    fn centre_on_an_edge_belongs_to_the_left_and_the_top() {
        // A square of 2x2 pixels whose corners are pixel centres: only the top-left 2x2 of its 3x3 centres are inside.
        let (a, b) = (128, 128 + 512);
        let square = [[[a, a], [b, a], [b, b]], [[a, a], [b, b], [a, b]]];
        let mut count = [[0; 4]; 4];
        for v in square {
            let edges = edges(&v).unwrap();
            let all = PixelBox::of(&v, 0, 4, 4).unwrap();
            cover(&edges, all, |x, y| count[y as usize][x as usize] += 1);
        }
        assert_eq!(count, [[1, 1, 0, 0], [1, 1, 0, 0], [0; 4], [0; 4]]);
    }

    #[test]
    fn row_span_equals_the_scan() {
        let v = [[-3000, -700], [9000, 4000], [100, 12000]];
        let edges = edges(&v).unwrap();
        for y in 0..48 {
            let mut seen = None;
            cover(
                &edges,
                PixelBox {
                    x0: 0,
                    y0: y,
                    x1: 63,
                    y1: y,
                },
                |x, _| {
                    seen = Some(seen.map_or((x, x), |(first, _)| (first, x)));
                },
            );
            assert_eq!(row_span(&edges, y, 0, 63), seen, "row {y}");
        }
    }

    #[test]
    fn edges_hold_the_whole_fixed_point_range() {
        let far = 1 << 23;
        let v = [[-far, -far], [far, -far], [far, far]];
        let edges = edges(&v).unwrap();
        assert!(edges.iter().all(|e| e.at_pixel(16383, 0) >= 0));
    }
}

//! Homogeneous clipping in f64.
//!
//! Vertices are in homogeneous pixels: a pixel position times clip w, y down. A polygon is cut where w would vanish, at the
//! near and far planes, and at the guard band where pixel positions would leave the fixed-point range. The cut of an edge is
//! computed from its inner end to its outer end, so that both triangles at an edge get the same bits.

use texmap_math::simd::{Isa, Scalar};

/// Pixel positions beyond this do not fit 24.8 fixed point and are cut off.
pub(crate) const GUARD_BAND: f64 = 32768.0;

/// w below this part of the triangle's largest |w| is cut off.
const W_EPSILON: f64 = 1.0 / (1u64 << 44) as f64;

/// Three corners, cut by seven planes.
pub(crate) const MAX_CORNERS: usize = 10;

/// A vertex in homogeneous pixels, or one in each lane.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Hom<I: Isa = Scalar> {
    /// Pixel x times w.
    pub x: I::F64,
    /// Pixel y (down) times w.
    pub y: I::F64,
    /// Clip z: depth times w.
    pub z: I::F64,
    /// Clip w.
    pub w: I::F64,
}

impl Hom {
    /// False for NaN, infinity and values whose products could overflow.
    pub(crate) fn is_usable(self) -> bool {
        [self.x, self.y, self.z, self.w]
            .iter()
            .all(|v| v.abs() < 1e90)
    }

    pub(crate) fn blend(a: Self, b: Self, t: f64) -> Self {
        let s = 1.0 - t;
        Self {
            x: a.x * s + b.x * t,
            y: a.y * s + b.y * t,
            z: a.z * s + b.z * t,
            w: a.w * s + b.w * t,
        }
    }
}

/// A corner of a cut polygon: where it is and its weights over the triangle's vertices (linear in clip space).
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Corner {
    pub at: Hom,
    pub weights: [f64; 3],
}

/// A convex polygon of up to [`MAX_CORNERS`] corners.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Polygon {
    corners: [Corner; MAX_CORNERS],
    len: usize,
}

impl Polygon {
    pub(crate) fn corners(&self) -> &[Corner] {
        &self.corners[..self.len]
    }

    fn push(&mut self, corner: Corner) {
        if self.len < MAX_CORNERS {
            self.corners[self.len] = corner;
            self.len += 1;
        }
    }
}

/// Position of a triangle against the clip planes, which says if it has to be cut.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Region {
    /// No part can be seen.
    Outside,
    /// Every vertex is in front of the eye and in the fixed-point range.
    Inside,
    /// Some part has to be cut off.
    Crossing,
}

/// Region of the triangle. `width` and `height` are the target's, in pixels. A triangle that needs no cut is `Inside` even if no
/// part of it can be seen.
pub(crate) fn region(v: &[Hom; 3], width: f64, height: f64) -> Region {
    let planes = planes(w_epsilon(v));
    if v.iter()
        .all(|p| planes.iter().all(|plane| plane.distance(*p) >= 0.0))
    {
        return Region::Inside;
    }
    let all = |f: fn(&Hom, f64) -> bool, side: f64| v.iter().all(|p| f(p, side));
    let outside = all(|p, _| p.w <= 0.0, 0.0)
        || all(|p, _| p.z > p.w, 0.0)
        || all(|p, _| p.z < 0.0, 0.0)
        || all(|p, _| p.x < 0.0, 0.0)
        || all(|p, _| p.y < 0.0, 0.0)
        || all(|p, side| p.x > side * p.w, width)
        || all(|p, side| p.y > side * p.w, height);
    if outside {
        Region::Outside
    } else {
        Region::Crossing
    }
}

/// The part of the triangle inside all planes; fewer than three corners when nothing is left.
pub(crate) fn clip(v: &[Hom; 3]) -> Polygon {
    let mut polygon = Polygon {
        corners: [Corner::default(); MAX_CORNERS],
        len: 0,
    };
    for (i, &at) in v.iter().enumerate() {
        let mut weights = [0.0; 3];
        weights[i] = 1.0;
        polygon.push(Corner { at, weights });
    }
    for plane in planes(w_epsilon(v)) {
        polygon = cut(&polygon, plane);
    }
    polygon
}

fn cut(polygon: &Polygon, plane: Plane) -> Polygon {
    let mut out = Polygon {
        corners: [Corner::default(); MAX_CORNERS],
        len: 0,
    };
    let corners = polygon.corners();
    for (i, &current) in corners.iter().enumerate() {
        let next = corners[(i + 1) % corners.len()];
        let (here, there) = (plane.distance(current.at), plane.distance(next.at));
        if here >= 0.0 {
            out.push(current);
        }
        if (here >= 0.0) != (there >= 0.0) {
            let (inner, outer, di, d_o) = if here >= 0.0 {
                (current, next, here, there)
            } else {
                (next, current, there, here)
            };
            let t = di / (di - d_o);
            let mut weights = [0.0; 3];
            for (k, w) in weights.iter_mut().enumerate() {
                *w = inner.weights[k] * (1.0 - t) + outer.weights[k] * t;
            }
            out.push(Corner {
                at: Hom::blend(inner.at, outer.at, t),
                weights,
            });
        }
    }
    out
}

/// A half space `x X + y Y + z Z + w W + k >= 0`.
#[derive(Debug, Clone, Copy)]
struct Plane {
    x: f64,
    y: f64,
    z: f64,
    w: f64,
    k: f64,
}

impl Plane {
    fn distance(self, p: Hom) -> f64 {
        self.x * p.x + self.y * p.y + self.z * p.z + self.w * p.w + self.k
    }
}

fn planes(epsilon: f64) -> [Plane; 7] {
    let plane = |x, y, z, w, k| Plane { x, y, z, w, k };
    [
        plane(0.0, 0.0, 0.0, 1.0, -epsilon),
        plane(0.0, 0.0, -1.0, 1.0, 0.0),
        plane(0.0, 0.0, 1.0, 0.0, 0.0),
        plane(1.0, 0.0, 0.0, GUARD_BAND, 0.0),
        plane(-1.0, 0.0, 0.0, GUARD_BAND, 0.0),
        plane(0.0, 1.0, 0.0, GUARD_BAND, 0.0),
        plane(0.0, -1.0, 0.0, GUARD_BAND, 0.0),
    ]
}

fn w_epsilon(v: &[Hom; 3]) -> f64 {
    let mut largest = 0.0;
    for p in v {
        let size = p.w.abs();
        if size > largest {
            largest = size;
        }
    }
    // Never zero: the smallest normal number keeps every division finite.
    let epsilon = largest * W_EPSILON;
    if epsilon > f64::MIN_POSITIVE {
        epsilon
    } else {
        f64::MIN_POSITIVE
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Both triangles at an edge get the same cut corners, to the last bit, whichever way they run along it.
    #[test]
    fn a_shared_edge_is_cut_to_the_same_bits() {
        let mut state = 9u32;
        let mut next = || {
            state = state.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
            f64::from(state >> 4) / f64::from(1 << 28) - 0.5
        };
        let mut cut = 0;
        for _ in 0..500 {
            let mut vertex = || Hom {
                x: next() * 1e6,
                y: next() * 1e6,
                z: 0.5,
                w: next() * 10.0,
            };
            let (a, b, c, d) = (vertex(), vertex(), vertex(), vertex());
            let on_edge = |polygon: &Polygon, other: usize| -> Vec<[u64; 4]> {
                let corners = polygon.corners().iter().filter(|k| k.weights[other] == 0.0);
                let mut bits: Vec<_> = corners
                    .map(|k| [k.at.x, k.at.y, k.at.z, k.at.w].map(f64::to_bits))
                    .collect();
                bits.sort_unstable();
                bits
            };
            let (left, right) = (clip(&[a, b, c]), clip(&[b, a, d]));
            // The eye's plane is cut by a w that depends on the triangle: compare edges cut elsewhere.
            if a.w > 0.6 && b.w > 0.6 && !left.corners().is_empty() && !right.corners().is_empty() {
                assert_eq!(on_edge(&left, 2), on_edge(&right, 2));
                cut += usize::from(
                    on_edge(&left, 2)
                        .iter()
                        .any(|k| *k != [a.x, a.y, a.z, a.w].map(f64::to_bits)),
                );
            }
        }
        assert!(cut > 20, "only {cut} edges were cut");
    }
}

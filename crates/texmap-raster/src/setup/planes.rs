//! Planes over the screen from unsnapped homogeneous vertices, in f64, about a local origin; and their f32 forms.
use texmap_math::simd::{Isa, Scalar, prelude::*};

use crate::front_end::clip::Hom;
use crate::setup::{DEPTH_RATIO, LARGEST, REACH, SMALLEST, W_RATIO};

/// `a x + b y + c`: a, b and c; x and y in pixels from the origin that the plane was made about.
pub(crate) type Plane = [f64; 3];

/// The value of a plane.
#[inline(always)]
pub(crate) fn plane_at<I: Isa>(_: I, [a, b, c]: Plane, x: I::F64, y: I::F64) -> I::F64 {
    (y * b + c) + x * a
}

/// Largest absolute and smallest value of planes over a tile.
#[inline(always)]
fn extent<I: Isa>(_: I, plane: [I::F64; 3]) -> (I::F64, I::F64) {
    let slope = (plane[0].abs() + plane[1].abs()) * REACH;
    (plane[2].abs() + slope, plane[2] - slope)
}

/// True where an f32 plane of 1/w serves a tile; `lo` is the least 1/w of the vertices. False for NaN, as all of these.
#[inline(always)]
pub(crate) fn w_is_even<I: Isa>(i: I, plane: [I::F64; 3], lo: I::F64) -> I::Mask64 {
    let (largest, smallest) = extent(i, plane);
    let lowest = smallest.simd_gt(lo).select(smallest, lo);
    largest.simd_le(lowest * W_RATIO)
}

/// True where an f32 plane of depth serves a tile. Reversed depth near the horizon is small: its digits are kept where it varies much.
#[inline(always)]
pub(crate) fn depth_is_even<I: Isa>(i: I, plane: [I::F64; 3], lo: I::F64) -> I::Mask64 {
    let (largest, smallest) = extent(i, plane);
    let lowest = smallest.simd_gt(lo).select(smallest, lo);
    largest.simd_le(1.0) & largest.simd_le(lowest * DEPTH_RATIO)
}

/// True where a plane is neither too large nor too small for f32. `hull` is that of the vertices' values.
#[inline(always)]
pub(crate) fn is_moderate<I: Isa>(i: I, plane: [I::F64; 3], hull: [I::F32; 2]) -> I::Mask64 {
    let size = i.widen(hull[0].abs().above(hull[1].abs()));
    let in_range = size.simd_eq(0.0) | (size.simd_ge(SMALLEST) & size.simd_le(LARGEST));
    in_range & extent(i, plane).0.simd_le(LARGEST)
}

/// Least and largest of three.
#[inline(always)]
pub(crate) fn hull<I: Isa>(_: I, v: [I::F32; 3]) -> [I::F32; 2] {
    [v[2].below(v[1].below(v[0])), v[2].above(v[1].above(v[0]))]
}

/// Coefficients of an f32 plane with its hull: a, b, c, lo, hi.
pub(crate) const COEFFICIENTS: usize = 5;

/// An f32 plane on a row of pixels, with the hull that its values are clamped to.
#[derive(Clone, Copy)]
pub(crate) struct RowPlane<I: Isa> {
    a: I::F32,
    b: I::F32,
    /// Value of the plane at the tile's middle column.
    start: I::F32,
    lo: I::F32,
    hi: I::F32,
}

impl<I: Isa> RowPlane<I> {
    #[inline(always)]
    pub(crate) fn new([a, b, c, lo, hi]: [I::F32; COEFFICIENTS], py: I::F32) -> Self {
        let start = c + b * py;
        Self {
            a,
            b,
            start,
            lo,
            hi,
        }
    }

    /// Multiply, then add; never stepped, never fused.
    #[inline(always)]
    fn at(&self, px: I::F32) -> I::F32 {
        self.start + self.a * px
    }

    #[inline(always)]
    pub(crate) fn clamp(&self, v: I::F32) -> I::F32 {
        v.clamp(self.lo, self.hi)
    }

    /// The value within the hull.
    #[inline(always)]
    pub(crate) fn value(&self, px: I::F32) -> I::F32 {
        self.clamp(self.at(px))
    }

    /// An attribute that is linear on the screen: value, and change to the right and down.
    #[inline(always)]
    pub(crate) fn linear(&self, px: I::F32) -> [I::F32; 3] {
        [self.value(px), self.a, self.b]
    }
}

/// Pixels of a row with 1 / clip w and its reciprocal.
pub(crate) struct Perspective<I: Isa> {
    px: I::F32,
    /// Change of 1/w to the right and down.
    slope: [I::F32; 2],
    pub(crate) inv_w: I::F32,
    w: I::F32,
}

impl<I: Isa> Perspective<I> {
    /// By the plane of 1/w; `constant` is 1/w and w where they are the same at all pixels.
    #[inline(always)]
    pub(crate) fn new(
        i: I,
        plane: &RowPlane<I>,
        constant: Option<[I::F32; 2]>,
        px: I::F32,
    ) -> Self {
        let [inv_w, w] = match constant {
            Some(constant) => constant,
            None => {
                let inv_w = plane.value(px);
                [inv_w, i.f32(1.0) / inv_w]
            }
        };
        Self {
            px,
            slope: [plane.a, plane.b],
            inv_w,
            w,
        }
    }

    /// An attribute of a plane, and if `D` its change to the right and down.
    #[inline(always)]
    pub(crate) fn attribute<const D: bool>(&self, plane: &RowPlane<I>) -> [I::F32; 3] {
        let (RowPlane { a, b, .. }, [wa, wb]) = (*plane, self.slope);
        let u = plane.clamp(plane.at(self.px) * self.w);
        if !D {
            return [u, a, b];
        }
        [u, (a - u * wa) * self.w, (b - u * wb) * self.w]
    }
}

/// The rows that turn three vertex values into a plane.
///
/// For vertices (X_i, Y_i, w_i) the plane through value v_i / w_i at (X_i / w_i, Y_i / w_i) solves
/// `a X_i + b Y_i + c w_i = v_i`: homogeneous, so vertices at or behind the eye need no cut (Olano and Greer 1997).
#[derive(Clone, Copy)]
pub(crate) struct Solver<I: Isa> {
    rows: [[I::F64; 3]; 3],
    inverse: I::F64,
    /// Triangles with area; the planes of others hold no meaning.
    pub(crate) solvable: I::Mask64,
}

impl<I: Isa> Solver<I> {
    /// About an origin in pixels.
    #[inline(always)]
    pub(crate) fn new(i: I, v: &[Hom<I>; 3], [ox, oy]: [f64; 2]) -> Self {
        let [v0, v1, v2] = v;
        let p0 = [v0.x - v0.w * ox, v0.y - v0.w * oy, v0.w];
        let p1 = [v1.x - v1.w * ox, v1.y - v1.w * oy, v1.w];
        let p2 = [v2.x - v2.w * ox, v2.y - v2.w * oy, v2.w];
        let rows = [cross(i, p1, p2), cross(i, p2, p0), cross(i, p0, p1)];
        let determinant = p0[0] * rows[0][0] + p0[1] * rows[0][1] + p0[2] * rows[0][2];
        let zero = determinant.simd_eq(0.0);
        let inverse = i.f64(1.0) / zero.select(i.f64(1.0), determinant);
        Self {
            rows,
            inverse,
            solvable: !zero & inverse.abs().simd_le(f64::MAX),
        }
    }

    /// The plane of value / w.
    #[inline(always)]
    pub(crate) fn plane(&self, v: [I::F64; 3]) -> [I::F64; 3] {
        let r = &self.rows;
        [
            (v[0] * r[0][0] + v[1] * r[1][0] + v[2] * r[2][0]) * self.inverse,
            (v[0] * r[0][1] + v[1] * r[1][1] + v[2] * r[2][1]) * self.inverse,
            (v[0] * r[0][2] + v[1] * r[1][2] + v[2] * r[2][2]) * self.inverse,
        ]
    }
}

#[inline(always)]
fn cross<I: Isa>(_: I, a: [I::F64; 3], b: [I::F64; 3]) -> [I::F64; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

/// Twice the signed area of the triangle times the product of the three w. Its sign is the facing, also where some w are
/// negative. y points down, so a front face is negative.
pub(crate) fn determinant(v: &[Hom; 3]) -> f64 {
    let p = v.map(|v| [v.x, v.y, v.w]);
    let n = cross(Scalar, p[1], p[2]);
    p[0][0] * n[0] + p[0][1] * n[1] + p[0][2] * n[2]
}

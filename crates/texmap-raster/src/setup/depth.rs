//! The depth of triangles.

use texmap_math::simd::{Isa, Scalar, prelude::*};

use super::{LEAVES_NOTHING, Ranged, Shape, mean, solve};
use crate::setup::planes::{COEFFICIENTS, Plane, RowPlane, Solver, depth_is_even, plane_at};

/// The depth of a triangle over one tile.
#[derive(Debug, Clone, Copy)]
pub(crate) struct DepthPlane {
    pub z: Ranged,
    /// An f32 plane would lose digits here: evaluate in f64.
    pub wide: bool,
}

impl DepthPlane {
    /// About an origin in pixels.
    pub(crate) fn new(shape: &Shape<'_>, solver: &Solver<Scalar>) -> Self {
        // A corner cut off at the far plane may lie beyond it by a rounding.
        let depths = shape.piece.map(|p| (p.z / p.w).clamp(0.0, 1.0));
        let plane = solve(solver, shape.outer.map(|p| p.z), mean(depths));
        let mut z = Ranged::new(plane, depths.map(|v| v as f32));
        let even = depth_is_even(Scalar, plane, f64::from(z.lo));
        if shape.depth_slope != 0.0 {
            z.lower(depth_offset(Scalar, shape.depth_slope, z.near));
        }
        Self { z, wide: !even }
    }

    /// `px`, `py`: a pixel's centre from the origin.
    pub(crate) fn at(&self, px: f32, py: f32) -> f32 {
        let depth = Depth {
            coefficients: self.z.coefficients(Scalar),
            wide: self.wide.then_some(&self.z.plane),
        };
        depth.row(py).at(Scalar, px)
    }
}

/// The depth of a triangle at pixels: an f32 plane, or one in f64.
#[derive(Clone, Copy)]
pub(crate) struct Depth<'g, I: Isa> {
    pub(crate) coefficients: [I::F32; COEFFICIENTS],
    /// The plane in f64 if f32 does not serve. A reference, since a plane by value would put the whole struct into memory.
    pub(crate) wide: Option<&'g Plane>,
}

impl<'g, I: Isa> Depth<'g, I> {
    /// The part that the pixels of a row share.
    #[inline(always)]
    pub(crate) fn row(&self, py: I::F32) -> DepthRow<'g, I> {
        DepthRow {
            plane: RowPlane::new(self.coefficients, py),
            wide: self.wide,
            py,
        }
    }
}

/// [`Depth`] on a row of pixels.
#[derive(Clone, Copy)]
pub(crate) struct DepthRow<'g, I: Isa> {
    plane: RowPlane<I>,
    wide: Option<&'g Plane>,
    py: I::F32,
}

impl<I: Isa> DepthRow<'_, I> {
    #[inline(always)]
    pub(crate) fn at(&self, i: I, px: I::F32) -> I::F32 {
        match self.wide {
            None => self.plane.value(px),
            Some(plane) => self.plane.clamp(wide_depth(i, plane, px, self.py)),
        }
    }
}

/// A plane in f64. Out of line: a compiler moves the steps of an inlined form before the question whether the lane is wide, where
/// what they read holds no meaning and, taken for a subnormal number, costs a hundred cycles a step.
#[cold]
#[inline(never)]
fn wide_depth<I: Isa>(i: I, plane: &Plane, px: I::F32, py: I::F32) -> I::F32 {
    i.vectorize(
        #[inline(always)]
        || i.narrow(plane_at(i, *plane, i.widen(px), i.widen(py))),
    )
}

/// Depth that a draw's [`depth_slope`](crate::DrawCall::depth_slope) takes off a plane. A plane that is seen on edge leaves
/// nothing.
#[inline(always)]
pub(crate) fn depth_offset<I: Isa>(i: I, depth_slope: f32, [a, b, _]: [I::F32; 3]) -> I::F32 {
    ((a.abs() + b.abs()) * depth_slope).below(i.f32(LEAVES_NOTHING))
}

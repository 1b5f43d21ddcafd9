//! Errors of a draw or a target, with the offending numbers.
use core::fmt;

use texmap_math::OverBudget;

/// Error of a target or a list of draws that was refused. Nothing is drawn when one is returned.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum RasterError {
    /// A target side is zero.
    ZeroTarget {
        /// Asked width in pixels.
        width: u32,
        /// Asked height in pixels.
        height: u32,
    },
    /// A target side is above [`TargetSize::MAX`](crate::TargetSize::MAX).
    TargetTooLarge {
        /// Asked width in pixels.
        width: u32,
        /// Asked height in pixels.
        height: u32,
    },
    /// A triangle names a vertex that does not exist.
    IndexOutOfRange {
        /// Position of the draw in the list.
        draw: usize,
        /// Position of the triangle in the draw's `indices`.
        triangle: usize,
        /// The index found.
        index: u32,
        /// Number of vertices of the draw.
        vertices: usize,
    },
    /// `attributes` does not hold `attribute_count` values for every vertex.
    AttributeLength {
        /// Position of the draw in the list.
        draw: usize,
        /// Values needed: vertices times `attribute_count`.
        expected: usize,
        /// Values found.
        found: usize,
    },
    /// `attribute_count` is above [`MAX_ATTRIBUTES`](crate::MAX_ATTRIBUTES).
    TooManyAttributes {
        /// Position of the draw in the list.
        draw: usize,
        /// The count found.
        count: usize,
    },
    /// `Interp::Subdivided(n)` with n outside 1..=[`MAX_SUBDIVISIONS`](crate::MAX_SUBDIVISIONS).
    Parts {
        /// Position of the draw in the list.
        draw: usize,
        /// The n found.
        parts: u32,
    },
    /// `Interp::Span(0)`.
    ZeroSpan {
        /// Position of the draw in the list.
        draw: usize,
    },
    /// `Interp::WithinError` with a tolerance or an `interp_scale` that is not a positive number.
    Tolerance {
        /// Position of the draw in the list.
        draw: usize,
        /// The tolerance found.
        tolerance: f32,
        /// The scale found.
        scale: f32,
    },
    /// A flat index list that does not divide into triangles.
    IndexCount {
        /// Indices found.
        count: usize,
    },
    /// More triangles, after subdivision and clipping, than 32-bit ids can name.
    TooManyTriangles,
    /// A buffer beyond the memory budget.
    Memory(OverBudget),
    /// The progress callback ended the work.
    Cancelled,
}

impl From<OverBudget> for RasterError {
    fn from(refused: OverBudget) -> Self {
        Self::Memory(refused)
    }
}

impl fmt::Display for RasterError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Memory(ref refused) => write!(f, "{refused}; {}", refused.lower),
            Self::Cancelled => write!(f, "cancelled"),
            Self::ZeroTarget { width, height } => {
                write!(
                    f,
                    "target of {width}x{height} pixels has no area; both sides must be at least 1"
                )
            }
            Self::TargetTooLarge { width, height } => write!(
                f,
                "target of {width}x{height} pixels is too large; no side may exceed {}",
                crate::TargetSize::MAX
            ),
            Self::IndexOutOfRange {
                draw,
                triangle,
                index,
                vertices,
            } => write!(
                f,
                "draw {draw}, triangle {triangle}: vertex index {index} is out of range, there are {vertices} vertices"
            ),
            Self::AttributeLength {
                draw,
                expected,
                found,
            } => write!(
                f,
                "draw {draw}: {found} attribute values, {expected} needed (vertices times attribute_count)"
            ),
            Self::TooManyAttributes { draw, count } => write!(
                f,
                "draw {draw}: {count} attributes per vertex, at most {} are supported",
                crate::MAX_ATTRIBUTES
            ),
            Self::Parts { draw, parts } => write!(
                f,
                "draw {draw}: cannot subdivide into {parts} parts a side; use 1 to {}",
                crate::MAX_SUBDIVISIONS
            ),
            Self::ZeroSpan { draw } => write!(f, "draw {draw}: a span of 0 pixels; use at least 1"),
            Self::Tolerance {
                draw,
                tolerance,
                scale,
            } => write!(
                f,
                "draw {draw}: tolerance {tolerance} with scale {scale}; both must be positive numbers"
            ),
            Self::IndexCount { count } => write!(
                f,
                "{count} indices are no list of triangles; three are needed for each"
            ),
            Self::TooManyTriangles => {
                write!(
                    f,
                    "more than 2^32 - 2 triangles after subdivision and clipping; split the draws"
                )
            }
        }
    }
}

impl core::error::Error for RasterError {}

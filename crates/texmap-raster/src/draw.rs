//! Input of the rasterizer: targets, draws and their named choices.
use core::ops::Range;

use texmap_math::glam::DMat4;

use crate::RasterError;

/// Most attributes a vertex can carry.
pub const MAX_ATTRIBUTES: usize = 20;

/// Most parts a side for [`Interp::Subdivided`].
pub const MAX_SUBDIVISIONS: u32 = 256;

/// Size of a target in pixels, each side in 1..=[`TargetSize::MAX`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TargetSize {
    width: u32,
    height: u32,
}

impl TargetSize {
    /// Longest side in pixels.
    pub const MAX: u32 = 16384;

    /// A target of `width` x `height` pixels.
    ///
    /// # Errors
    /// [`RasterError::ZeroTarget`] or [`RasterError::TargetTooLarge`].
    pub fn new(width: u32, height: u32) -> Result<Self, RasterError> {
        if width == 0 || height == 0 {
            return Err(RasterError::ZeroTarget { width, height });
        }
        if width > Self::MAX || height > Self::MAX {
            return Err(RasterError::TargetTooLarge { width, height });
        }
        Ok(Self { width, height })
    }

    /// Width in pixels.
    #[must_use]
    pub fn width(self) -> u32 {
        self.width
    }

    /// Height in pixels.
    #[must_use]
    pub fn height(self) -> u32 {
        self.height
    }
}

/// Interpolation of attributes between the vertices.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Interp {
    /// Exact per pixel: planes of u/w and 1/w and one divide.
    #[default]
    Perspective,
    /// Linear on the screen within each triangle: wrong under perspective, by the amount of
    /// `max |error| = |du| |sqrt(r) - 1| / (sqrt(r) + 1)`, r the ratio of w at the vertices.
    Affine,
    /// Each triangle split into n x n in space before clipping, affine within the parts. Parts of a
    /// side are the same in both triangles that share it, so no T-junction is made. 1..=[`MAX_SUBDIVISIONS`].
    Subdivided(u32),
    /// Exact at every n-th pixel of the triangle's row and at the row's last pixel, linear between.
    /// These are the runs of Brackeen 2003, chapter 8, but never evaluated outside the triangle.
    Span(u32),
    /// Linear between nodes, with no pixel of the first two attributes off by more than this. In attribute units divided
    /// by [`DrawCall::interp_scale`]. The nodes come from the closed form: a span from w = a to w = b (w here 1/z) is off
    /// by at most `K (a^-1/2 - b^-1/2)^2`, K constant along a row.
    WithinError(f32),
}

/// The side of triangles that is dropped. Front faces are counter-clockwise for the viewer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Cull {
    /// Both sides are drawn.
    #[default]
    None,
    /// Back faces are dropped.
    Back,
    /// Front faces are dropped.
    Front,
}

/// Condition on which a fragment passes the depth test. The buffer is reversed: 1 is the near plane, 0 the far plane.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum DepthTest {
    /// Strictly nearer than what is there.
    #[default]
    Less,
    /// As near or nearer: the later of two equals wins.
    LessOrEqual,
    /// Always.
    Always,
}

/// The pass in which a draw takes part.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Pass {
    /// Decides visibility; every covered pixel counts.
    #[default]
    Opaque,
    /// Decides visibility where the [`AlphaTest`](crate::AlphaTest) keeps the fragment.
    CutOut,
    /// Drawn after visibility is known, in submitted order; writes no depth.
    Blended,
}

/// One mesh to draw. Slices are borrowed; nothing is copied.
///
/// Clip space has z in 0..w, reversed: z = w at the near plane and 0 at the far plane, and x, y in -w..w with y up.
#[derive(Debug, Clone, Copy)]
pub struct DrawCall<'a> {
    /// Vertex positions in object space.
    pub positions: &'a [[f32; 3]],
    /// Empty, or the clip z of each vertex, which replaces that of the matrix. Vertices that are in clip space already are drawn
    /// with their x, y and w as positions and the matrix that passes these on.
    pub clip_z: &'a [f32],
    /// Three vertex indices a triangle.
    pub indices: &'a [[u32; 3]],
    /// Object space to clip space.
    pub clip_from_object: DMat4,
    /// `attribute_count` values for vertex 0, then for vertex 1, ... A triangle with a NaN or infinite value is not drawn.
    pub attributes: &'a [f32],
    /// Values a vertex, at most [`MAX_ATTRIBUTES`].
    pub attribute_count: usize,
    /// Bit k set: attribute k is interpolated linearly on the screen (Gouraud), whatever `interp` says.
    pub screen_linear: u32,
    /// Interpolation of the other attributes.
    pub interp: Interp,
    /// Factor of the error of attributes 0 and 1 that [`Interp::WithinError`] compares with its tolerance. The size
    /// of a texture gives the tolerance in texels.
    pub interp_scale: f32,
    /// The side that is dropped.
    pub cull: Cull,
    /// The depth test.
    pub depth_test: DepthTest,
    /// True if a fragment that passes writes its depth. Ignored by [`Pass::Blended`], which never does.
    pub depth_write: bool,
    /// The pass in which the draw takes part.
    pub pass: Pass,
    /// Polygon offset. Every triangle's depth is moved away from the eye by this many times what its plane changes in a pixel,
    /// `|dz/dx| + |dz/dy|`. With r it is the farthest that the plane reaches within r pixels across and down of each pixel.
    /// Depths moved beyond the far plane are behind everything.
    pub depth_slope: f32,
}

impl Default for DrawCall<'_> {
    fn default() -> Self {
        Self {
            positions: &[],
            clip_z: &[],
            indices: &[],
            clip_from_object: DMat4::IDENTITY,
            attributes: &[],
            attribute_count: 0,
            screen_linear: 0,
            interp: Interp::Perspective,
            interp_scale: 1.0,
            cull: Cull::None,
            depth_test: DepthTest::Less,
            depth_write: true,
            pass: Pass::Opaque,
            depth_slope: 0.0,
        }
    }
}

impl DrawCall<'_> {
    pub(crate) fn check(&self, draw: usize) -> Result<(), RasterError> {
        let vertices = self.positions.len();
        if self.attribute_count > MAX_ATTRIBUTES {
            return Err(RasterError::TooManyAttributes {
                draw,
                count: self.attribute_count,
            });
        }
        let expected = vertices.saturating_mul(self.attribute_count);
        if self.attributes.len() != expected {
            return Err(RasterError::AttributeLength {
                draw,
                expected,
                found: self.attributes.len(),
            });
        }
        if !self.clip_z.is_empty() && self.clip_z.len() != vertices {
            return Err(RasterError::AttributeLength {
                draw,
                expected: vertices,
                found: self.clip_z.len(),
            });
        }
        match self.interp {
            Interp::Subdivided(parts) if parts == 0 || parts > MAX_SUBDIVISIONS => {
                return Err(RasterError::Parts { draw, parts });
            }
            Interp::Span(0) => return Err(RasterError::ZeroSpan { draw }),
            Interp::WithinError(tolerance) => {
                let scale = self.interp_scale;
                let positive = |v: f32| v > 0.0 && v.is_finite();
                if !positive(tolerance) || !positive(scale) {
                    return Err(RasterError::Tolerance {
                        draw,
                        tolerance,
                        scale,
                    });
                }
            }
            _ => {}
        }
        Ok(())
    }

    /// True if the indices of the triangles in `range` name vertices.
    #[inline(always)]
    pub(crate) fn check_indices(
        &self,
        draw: usize,
        range: Range<usize>,
    ) -> Result<(), RasterError> {
        let vertices = self.positions.len();
        let triangles = &self.indices[range.clone()];
        // Without an early end, which compiles to wide vectors.
        let mut largest = 0;
        for index in triangles.as_flattened() {
            largest = if *index > largest { *index } else { largest };
        }
        if triangles.is_empty() || (largest as usize) < vertices {
            return Ok(());
        }
        let beyond = |index: &&u32| **index as usize >= vertices;
        let all = triangles.iter().zip(range);
        let bad = all.filter_map(|(corners, i)| Some((i, *corners.iter().find(beyond)?)));
        bad.take(1).try_for_each(|(triangle, index)| {
            Err(RasterError::IndexOutOfRange {
                draw,
                triangle,
                index,
                vertices,
            })
        })
    }
}

/// Number of the submitted triangles (of their parts, where subdivided) by outcome.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Stats {
    /// Triangles in the draws' `indices`.
    pub submitted: usize,
    /// Triangles dropped because a position or an attribute was NaN or infinite, or overflowed in the matrix.
    pub non_finite: usize,
    /// Dropped because they lie outside the view or cover no pixel centre. The latter if their box holds no centre, or holds
    /// up to 2x2 and none is covered.
    pub outside: usize,
    /// Dropped by [`Cull`].
    pub culled: usize,
    /// Dropped because they have no area once snapped to 1/256 pixel.
    pub degenerate: usize,
    /// Cut at the near or far plane, or at the edge of the fixed-point range.
    pub clipped: usize,
    /// Pieces that reached a tile.
    pub binned: usize,
}

impl Stats {
    pub(crate) fn add(&mut self, other: Self) {
        self.submitted += other.submitted;
        self.non_finite += other.non_finite;
        self.outside += other.outside;
        self.culled += other.culled;
        self.degenerate += other.degenerate;
        self.clipped += other.clipped;
        self.binned += other.binned;
    }
}

#[cfg(test)]
mod tests {
    use alloc::vec::Vec;

    use super::*;
    use crate::{BinnedDraws, NoAlphaTest, VisibilityBuffer};
    use texmap_math::Level;
    use texmap_math::glam::DVec4;

    /// Depths and ids of all tiles.
    fn seen(draw: &DrawCall<'_>, level: Level) -> (Vec<u32>, Vec<u32>) {
        let size = TargetSize::new(150, 90).unwrap();
        let binned = BinnedDraws::with_level(size, &[*draw], level, 1).unwrap();
        let (mut depths, mut ids) = (Vec::new(), Vec::new());
        let mut buffers = VisibilityBuffer::new();
        for tile in 0..binned.tiles() {
            binned.visible(tile, &NoAlphaTest, &mut buffers);
            depths.extend(buffers.depth.iter().map(|d| d.to_bits()));
            ids.extend(&buffers.id);
        }
        (depths, ids)
    }

    /// Positions on a grid and a dyadic matrix: the clip z of each vertex is exact in f32.
    #[test]
    fn clip_z_of_vertices_replaces_that_of_the_matrix() {
        let mut state = 1_u32;
        let mut next = || {
            state = state.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
            ((state >> 20) as f32 - 2048.0) / 512.0
        };
        let positions: Vec<[f32; 3]> = (0..300).map(|_| [next(), next(), next()]).collect();
        let indices: Vec<[u32; 3]> = (0..100).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect();
        let rows = [
            DVec4::new(1.0, 0.0, 0.25, 0.0),
            DVec4::new(0.0, 1.0, 0.0, 0.5),
            DVec4::new(0.25, 0.125, 0.25, 1.5),
            DVec4::new(0.0, 0.0, -1.0, 3.0),
        ];
        let matrix = |z: DVec4| DMat4::from_cols(rows[0], rows[1], z, rows[3]).transpose();
        let z = |p: &[f32; 3]| {
            let p = DVec4::new(p[0].into(), p[1].into(), p[2].into(), 1.0);
            rows[2].dot(p) as f32
        };
        let clip_z: Vec<f32> = positions.iter().map(z).collect();
        let by_matrix = DrawCall {
            positions: &positions,
            indices: &indices,
            clip_from_object: matrix(rows[2]),
            ..DrawCall::default()
        };
        let given = DrawCall {
            clip_z: &clip_z,
            clip_from_object: matrix(DVec4::ZERO),
            ..by_matrix
        };
        let without = DrawCall {
            clip_z: &[],
            ..given
        };
        for level in [Level::new(), Level::baseline()] {
            let expected = seen(&by_matrix, level);
            assert!(expected.1.iter().any(|id| *id != u32::MAX));
            assert!(
                expected.1.iter().any(|id| (100..u32::MAX).contains(id)),
                "none is cut"
            );
            assert_eq!(seen(&given, level), expected);
            assert_ne!(seen(&without, level), expected);
        }
        let short = DrawCall {
            clip_z: &clip_z[1..],
            ..given
        };
        let refused = BinnedDraws::new(TargetSize::new(8, 8).unwrap(), &[short]);
        assert!(matches!(
            refused,
            Err(RasterError::AttributeLength {
                expected: 300,
                found: 299,
                ..
            })
        ));
    }
}

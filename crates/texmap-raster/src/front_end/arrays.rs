//! A draw's arrays as 32-bit words: corners, snapped vertices and positions of triangles by gathers.
use texmap_math::simd::{GatherTable, Isa, prelude::*};

use crate::DrawCall;
use crate::coverage::edge::Snapped;
use crate::front_end::clip::Hom;
use crate::front_end::transform::Transform;

#[derive(Debug, Clone, Copy)]
pub(crate) struct Arrays<'a> {
    indices: GatherTable<'a>,
    snapped: GatherTable<'a>,
    positions: GatherTable<'a>,
    /// Clip z of the vertices, where it does not come from the matrix.
    clip_z: Option<GatherTable<'a>>,
}

impl<'a> Arrays<'a> {
    /// `None` where they are empty or too long for 32-bit indices.
    pub(crate) fn new(draw: &DrawCall<'a>, snapped: &'a [Snapped]) -> Option<Self> {
        let limit = i32::MAX as usize / 3;
        if draw.indices.len() >= limit || snapped.len() >= limit {
            return None;
        }
        Some(Self {
            indices: GatherTable::new(bytemuck::cast_slice(draw.indices))?,
            snapped: GatherTable::new(bytemuck::cast_slice(snapped))?,
            positions: GatherTable::new(bytemuck::cast_slice(draw.positions))?,
            clip_z: GatherTable::new(bytemuck::cast_slice(draw.clip_z)),
        })
    }

    /// Vertex numbers of triangles' corners.
    #[inline(always)]
    pub(crate) fn corners<I: Isa>(&self, i: I, triangle: I::I32) -> [I::I32; 3] {
        let [a, b, c] = i.gather_triples(self.indices, (triangle * 3).to_u32());
        [a.to_i32(), b.to_i32(), c.to_i32()]
    }

    /// Snapped x and y.
    #[inline(always)]
    pub(crate) fn snapped<I: Isa>(&self, i: I, vertex: I::I32) -> [I::I32; 2] {
        let [x, y] = i.gather_pairs(self.snapped, (vertex << 1).to_u32());
        [x.to_i32(), y.to_i32()]
    }

    /// Vertices in homogeneous pixels.
    #[inline(always)]
    pub(crate) fn vertex<I: Isa>(&self, i: I, transform: &Transform, vertex: I::I32) -> Hom<I> {
        let [x, y, z] = i.gather_triples(self.positions, (vertex * 3).to_u32());
        let mut at = transform.apply_lanes(
            i,
            [
                i.widen(x.to_f32_bits()),
                i.widen(y.to_f32_bits()),
                i.widen(z.to_f32_bits()),
            ],
        );
        if let Some(clip_z) = self.clip_z {
            at.z = i.widen(i.gather(clip_z, vertex.to_u32()).to_f32_bits());
        }
        at
    }
}

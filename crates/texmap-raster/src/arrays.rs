//! A draw's arrays as 32-bit words: corners, snapped vertices and positions of sixteen triangles by gathers.
use texmap_math::fearless_simd::{Simd, f32x16, f64x8, i32x16, prelude::*};
use texmap_math::lanes::{Words, gather_pairs, gather_triples};

use crate::Draw;
use crate::edge::Snapped;

#[derive(Debug, Clone, Copy)]
pub(crate) struct Arrays<'a> {
    indices: Words<'a>,
    snapped: Words<'a>,
    positions: Words<'a>,
}

impl<'a> Arrays<'a> {
    /// `None` where they are empty or too long for 32-bit indices.
    pub(crate) fn new(draw: &Draw<'a>, snapped: &'a [Snapped]) -> Option<Self> {
        let limit = i32::MAX as usize / 3;
        if draw.indices.len() >= limit || snapped.len() >= limit {
            return None;
        }
        Some(Self {
            indices: Words::new(bytemuck::cast_slice(draw.indices))?,
            snapped: Words::new(bytemuck::cast_slice(snapped))?,
            positions: Words::new(bytemuck::cast_slice(draw.positions))?,
        })
    }

    /// Vertex numbers of sixteen triangles' corners.
    #[inline(always)]
    pub(crate) fn corners<S: Simd>(&self, s: S, triangle: i32x16<S>) -> [i32x16<S>; 3] {
        let corners = gather_triples(s, self.indices, (triangle * 3).bitcast());
        [
            corners[0].bitcast(),
            corners[1].bitcast(),
            corners[2].bitcast(),
        ]
    }

    /// Snapped x and y.
    #[inline(always)]
    pub(crate) fn snapped<S: Simd>(&self, s: S, vertex: i32x16<S>) -> [i32x16<S>; 2] {
        let [x, y] = gather_pairs(s, self.snapped, (vertex << 1).bitcast());
        [x.bitcast(), y.bitcast()]
    }

    /// Positions as f64: lanes 0 to 7, then 8 to 15.
    #[inline(always)]
    pub(crate) fn positions<S: Simd>(&self, s: S, vertex: i32x16<S>) -> [[f64x8<S>; 3]; 2] {
        let [x, y, z] = gather_triples(s, self.positions, (vertex * 3).bitcast());
        let [x, y, z] = [
            x.bitcast::<f32x16<S>>().widen(),
            y.bitcast::<f32x16<S>>().widen(),
            z.bitcast::<f32x16<S>>().widen(),
        ];
        [[x.0, y.0, z.0], [x.1, y.1, z.1]]
    }
}

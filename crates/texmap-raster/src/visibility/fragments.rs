//! Visible fragments one by one: the simplest way to shade with a closure of one's own.

use crate::{AlphaTest, BinnedDraws, Fragment, NO_PRIMITIVE, RasterError, TILE, VisibilityBuffer};

/// A fragment that is seen, and the triangle that it comes from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VisibleFragment<'a> {
    /// Pixel from the left.
    pub x: u32,
    /// Pixel from the top.
    pub y: u32,
    /// Position of the draw in the list.
    pub draw: u32,
    /// Triangle of the draw.
    pub triangle: u32,
    /// Reversed depth: 1 at the near plane, 0 at the far plane.
    pub depth: f32,
    /// 1 / clip w.
    pub inv_w: f32,
    /// True if the front (counter-clockwise) side is seen.
    pub front: bool,
    /// The draw's attributes, perspective-correct.
    pub values: &'a [f32],
    /// Change of each attribute per pixel to the right.
    pub ddx: &'a [f32],
    /// Change of each attribute per pixel down.
    pub ddy: &'a [f32],
}

impl BinnedDraws<'_> {
    /// Calls `shade` with the nearest fragment of each covered pixel, tile by tile. The fragments of blended draws in front of it
    /// follow, in submitted order. `alpha` decides about cut-out draws ([`NoAlphaTest`](crate::NoAlphaTest) keeps all).
    ///
    /// On one thread and a fragment at a time: stages that need speed read [`AttributePlanes`](crate::AttributePlanes) by blocks.
    pub fn for_each_fragment<A: AlphaTest>(
        &self,
        alpha: &A,
        mut shade: impl FnMut(VisibleFragment<'_>),
    ) {
        let mut buffers = VisibilityBuffer::new();
        let mut fragment = Fragment::default();
        let mut show = |id: u32, x: u32, y: u32| {
            self.evaluate(id, x, y, &mut fragment);
            let (draw, triangle) = self.source(id);
            shade(VisibleFragment {
                x,
                y,
                draw,
                triangle,
                depth: fragment.depth,
                inv_w: fragment.inv_w,
                front: fragment.front,
                values: &fragment.values[..fragment.count],
                ddx: &fragment.ddx[..fragment.count],
                ddy: &fragment.ddy[..fragment.count],
            });
        };
        for index in (0..self.tiles()).filter(|tile| !self.is_empty(*tile)) {
            let tile = self.tile(index);
            self.visible(index, alpha, &mut buffers);
            for (y, row) in (0..tile.height).zip(buffers.id.chunks(TILE as usize)) {
                for (x, id) in (0..tile.width).zip(row) {
                    if *id != NO_PRIMITIVE {
                        show(*id, tile.x0 + x, tile.y0 + y);
                    }
                }
            }
            self.blended(index, &buffers, &mut show);
        }
    }
}

/// A flat index list as triangles, for [`DrawCall::indices`](crate::DrawCall::indices).
///
/// # Errors
/// [`RasterError::IndexCount`] for a length that is no multiple of three.
pub fn triangles(indices: &[u32]) -> Result<&[[u32; 3]], RasterError> {
    match indices.as_chunks() {
        (triangles, []) => Ok(triangles),
        _ => Err(RasterError::IndexCount {
            count: indices.len(),
        }),
    }
}

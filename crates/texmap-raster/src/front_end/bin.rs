//! Triangles to bins: clip, cull, snap and bin a chunk of a draw. Chunks are fixed, so threads change nothing.
use alloc::vec::Vec;
use core::ops::Range;

use texmap_math::simd::Isa;
use texmap_math::{Level, MemoryBudget, OverBudget, dispatch_simd};

use crate::coverage::edge::{Edge, PixelBox, Snapped, area, centre, edges, snap};
use crate::front_end::arrays::Arrays;
use crate::front_end::clip::{Corner, Hom, Region, clip, region};
use crate::front_end::transform::Transform;
use crate::setup::TILE;
use crate::setup::group::GROUP;
use crate::setup::planes::determinant;
use crate::{Cull, DrawCall, Interp, RasterError, Stats, TargetSize};

mod cull;

use cull::Sorted;

/// Triangles a chunk.
pub(crate) const CHUNK: usize = 4096;

/// Marks the id of a piece that is counted within its chunk.
const LOCAL: u32 = 1 << 31;

/// Most triangles of all draws, and most pieces: so that ids and marks fit.
pub(crate) const MOST: u32 = 1 << 29;

/// A piece of a triangle that could not be taken whole.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Piece {
    pub draw: u32,
    pub triangle: u32,
    pub front: bool,
    /// The vertices whose planes carry the attributes: the triangle's, or the part's where subdivided.
    pub outer: [Hom; 3],
    pub corners: [Hom; 3],
    /// Weights of each corner over the triangle's vertices.
    pub weights: [[f64; 3]; 3],
}

/// Triangles and pieces that a chunk of submitted triangles gave, by tile.
#[derive(Debug, Default)]
pub(crate) struct Chunk {
    /// In submitted order, tile by tile as far as neighbours lie in one.
    ids: Vec<u32>,
    /// A tile, and how many of the ids it has next.
    runs: Vec<(u32, usize)>,
    pub pieces: Vec<Piece>,
    pub stats: Stats,
    /// Set when the ids outgrow the memory budget; ids after that are dropped, and the chunk is an error.
    refused: Option<OverBudget>,
}

impl Chunk {
    #[inline(always)]
    fn put(&mut self, tile: u32, id: u32) {
        if self.ids.len() == self.ids.capacity() && !self.grow() {
            return;
        }
        self.ids.push(id);
        match self.runs.last_mut() {
            Some(last) if last.0 == tile => last.1 += 1,
            _ => self.runs.push((tile, 1)),
        }
    }

    /// Grows the buffer for as many ids again, unless the budget of the process refuses it.
    #[cold]
    #[inline(never)]
    fn grow(&mut self) -> bool {
        let more = self.ids.len().max(CHUNK / 4);
        let bytes = ((self.ids.len() + more) * size_of::<u32>()) as u64;
        let asked = bins(MemoryBudget::of_process(), bytes);
        if let Err(refused) = asked {
            self.refused.get_or_insert(refused);
            return false;
        }
        self.ids.reserve(more);
        true
    }

    /// Names pieces, which are counted within the chunk, from `first_piece` on.
    pub(crate) fn name_pieces(&mut self, first_piece: u32) {
        if !self.pieces.is_empty() {
            for id in self.ids.iter_mut().filter(|id| **id & LOCAL != 0) {
                *id = first_piece + (*id & !LOCAL);
            }
        }
    }

    /// Tiles and their ids, in submitted order; a tile may come again.
    pub(crate) fn runs(&self) -> impl Iterator<Item = (usize, &[u32])> {
        let mut rest = &self.ids[..];
        self.runs.iter().map_while(move |&(tile, count)| {
            let ids = rest.split_off(..count)?;
            Some((tile as usize, ids))
        })
    }
}

/// Asks for the ids of triangles in tiles.
pub(crate) fn bins(memory: MemoryBudget, bytes: u64) -> Result<(), OverBudget> {
    memory.ask(
        bytes,
        format_args!("the lists of the triangles in each tile"),
        "take a smaller picture, or fewer triangles that fill it",
    )
}

/// Triangles whose indices are checked and then read while they are still in the nearest cache: a multiple of the lanes.
const PART: usize = 64 * GROUP;

/// One draw on its way through the front end.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Submission<'d, 'a> {
    pub size: TargetSize,
    pub draw: &'d DrawCall<'a>,
    pub draw_index: u32,
    /// Id of the draw's first triangle.
    pub first: u32,
    pub transform: Transform,
    pub snapped: &'d [Snapped],
    /// Greatest distance of samples from a pixel's centre, in 1/256 pixel.
    pub margin: i32,
}

impl Submission<'_, '_> {
    /// Does the triangles of `range`.
    ///
    /// # Errors
    /// [`RasterError::TooManyTriangles`] when subdivision leaves too many pieces, [`RasterError::Memory`] when the triangles
    /// lie in too many tiles.
    pub(crate) fn run(&self, level: Level, range: Range<usize>) -> Result<Chunk, RasterError> {
        let mut chunk = Chunk::default();
        chunk.stats.submitted = range.len();
        for start in range.clone().step_by(PART) {
            let part = start..range.end.min(start + PART);
            self.run_part(level, part, &mut chunk)?;
            if let Some(refused) = chunk.refused.take() {
                return Err(refused.into());
            }
        }
        Ok(chunk)
    }

    fn run_part(
        &self,
        level: Level,
        range: Range<usize>,
        chunk: &mut Chunk,
    ) -> Result<(), RasterError> {
        let (draw, all) = (self.draw_index as usize, range.clone());
        dispatch_simd!(level, wide _i => self.draw.check_indices(draw, all))?;
        let whole = !matches!(self.draw.interp, Interp::Subdivided(_));
        match Arrays::new(self.draw, self.snapped) {
            Some(arrays) if whole => {
                dispatch_simd!(level, wide i => self.run_lanes(i, &arrays, range, chunk))
            }
            _ => range
                .into_iter()
                .try_for_each(|triangle| self.submit(triangle, chunk)),
        }
    }

    #[inline(always)]
    fn run_lanes<I: Isa>(
        &self,
        i: I,
        arrays: &Arrays<'_>,
        range: Range<usize>,
        chunk: &mut Chunk,
    ) -> Result<(), RasterError> {
        let mut group = Sorted::default();
        let mut base = range.start;
        while base < range.end {
            let count = I::LANES.min(range.end - base);
            self.sort(i, arrays, base, count, &mut group);
            chunk.stats.degenerate += group.degenerate.count_ones() as usize;
            chunk.stats.culled += group.culled.count_ones() as usize;
            chunk.stats.outside += group.outside.count_ones() as usize;
            let mut left = group.care | group.seen;
            while left != 0 {
                let lane = left.trailing_zeros() as usize;
                left &= left - 1;
                let triangle = base + lane;
                if group.care >> lane & 1 == 1 {
                    self.submit(triangle, chunk)?;
                    continue;
                }
                let pixels = PixelBox {
                    x0: group.x0[lane],
                    y0: group.y0[lane],
                    x1: group.x1[lane],
                    y1: group.y1[lane],
                };
                let id = self.first + triangle as u32;
                if let Some(tile) = self.only_tile(pixels) {
                    chunk.put(tile, id);
                    chunk.stats.binned += 1;
                } else {
                    let v = self.draw.indices[triangle].map(|i| self.snapped[i as usize]);
                    self.bin(id, &v, pixels, chunk);
                }
            }
            base += count;
        }
        Ok(())
    }

    /// One triangle of any kind.
    fn submit(&self, triangle: usize, chunk: &mut Chunk) -> Result<(), RasterError> {
        let corners = self.draw.indices[triangle];
        let v = corners.map(|i| self.transform.vertex(self.draw, i));
        let n = self.draw.attribute_count;
        let finite = |i: u32| {
            self.draw.attributes[i as usize * n..(i as usize + 1) * n]
                .iter()
                .all(|a| a.is_finite())
        };
        if !v.iter().all(|p| p.is_usable()) || !corners.iter().all(|&i| finite(i)) {
            chunk.stats.non_finite += 1;
            return Ok(());
        }
        let Interp::Subdivided(parts) = self.draw.interp else {
            const WHOLE: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
            return self.submit_part(triangle, v, WHOLE, true, chunk);
        };
        for j in 0..parts {
            for i in 0..parts - j {
                // The point i of row j; on a shared side both triangles sum the same two products.
                let at = |i: u32, j: u32| {
                    let n = f64::from(parts);
                    [
                        f64::from(parts - i - j) / n,
                        f64::from(i) / n,
                        f64::from(j) / n,
                    ]
                };
                let up = [at(i, j), at(i + 1, j), at(i, j + 1)];
                self.submit_part(triangle, up.map(|w| combine(&v, w)), up, false, chunk)?;
                if i + j + 2 <= parts {
                    let down = [at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                    self.submit_part(triangle, down.map(|w| combine(&v, w)), down, false, chunk)?;
                }
            }
        }
        Ok(())
    }

    /// `rows` are the weights of the part's vertices over the triangle's. `whole`: the part is the triangle.
    fn submit_part(
        &self,
        triangle: usize,
        v: [Hom; 3],
        rows: [[f64; 3]; 3],
        whole: bool,
        chunk: &mut Chunk,
    ) -> Result<(), RasterError> {
        let (width, height) = (f64::from(self.size.width()), f64::from(self.size.height()));
        let mut piece = Piece {
            draw: self.draw_index,
            triangle: triangle as u32,
            front: true,
            outer: v,
            corners: v,
            weights: rows,
        };
        match region(&v, width, height) {
            Region::Outside => chunk.stats.outside += 1,
            Region::Inside => {
                let snapped = v.map(snap);
                let area = area(&snapped);
                piece.front = area < 0;
                if area == 0 {
                    chunk.stats.degenerate += 1;
                } else if self.drops(piece.front) {
                    chunk.stats.culled += 1;
                } else if let Some(pixels) = self.seen_box(&snapped) {
                    if whole {
                        self.bin(self.first + triangle as u32, &snapped, pixels, chunk);
                    } else {
                        self.bin_piece(piece, &snapped, pixels, chunk)?;
                    }
                } else {
                    chunk.stats.outside += 1;
                }
            }
            Region::Crossing => {
                // The sign holds for vertices behind the eye too.
                let determinant = determinant(&v);
                piece.front = determinant < 0.0;
                if determinant == 0.0 {
                    chunk.stats.degenerate += 1;
                    return Ok(());
                }
                if self.drops(piece.front) {
                    chunk.stats.culled += 1;
                    return Ok(());
                }
                chunk.stats.clipped += 1;
                let polygon = clip(&v);
                let Some((hub, rest)) = polygon.corners().split_first() else {
                    return Ok(());
                };
                let over_triangle = |c: &Corner| {
                    [0, 1, 2].map(|k| {
                        c.weights[0] * rows[0][k]
                            + c.weights[1] * rows[1][k]
                            + c.weights[2] * rows[2][k]
                    })
                };
                for pair in rest.windows(2) {
                    let cut = [*hub, pair[0], pair[1]];
                    piece.corners = cut.map(|c| c.at);
                    piece.weights = cut.each_ref().map(over_triangle);
                    let snapped = piece.corners.map(snap);
                    if area(&snapped) != 0
                        && let Some(pixels) = self.seen_box(&snapped)
                    {
                        self.bin_piece(piece, &snapped, pixels, chunk)?;
                    }
                }
            }
        }
        Ok(())
    }

    fn drops(&self, front: bool) -> bool {
        match self.draw.cull {
            Cull::None => false,
            Cull::Back => !front,
            Cull::Front => front,
        }
    }

    /// The pixels whose centres lie in the triangle's box. `None` where there are none, or where there are up to 2x2 and the
    /// triangle covers none of them.
    fn seen_box(&self, snapped: &[Snapped; 3]) -> Option<PixelBox> {
        let b = PixelBox::of(
            snapped,
            self.margin,
            self.size.width() as i32,
            self.size.height() as i32,
        )?;
        if self.margin > 0 || b.x1 - b.x0 >= 2 || b.y1 - b.y0 >= 2 {
            return Some(b);
        }
        let edges = edges(snapped)?;
        let covers = |x, y| edges.iter().all(|e| e.at_pixel(x, y) >= 0);
        let hit =
            covers(b.x0, b.y0) || covers(b.x1, b.y0) || covers(b.x0, b.y1) || covers(b.x1, b.y1);
        hit.then_some(b)
    }

    fn bin_piece(
        &self,
        piece: Piece,
        snapped: &[Snapped; 3],
        pixels: PixelBox,
        chunk: &mut Chunk,
    ) -> Result<(), RasterError> {
        let id = chunk.pieces.len() as u32;
        if id >= MOST {
            return Err(RasterError::TooManyTriangles);
        }
        if self.bin(id | LOCAL, snapped, pixels, chunk) {
            chunk.pieces.push(piece);
        }
        Ok(())
    }

    /// The tile that holds all of the box.
    fn only_tile(&self, b: PixelBox) -> Option<u32> {
        let side = TILE as i32;
        let (tx, ty) = (b.x0 / side, b.y0 / side);
        (tx == b.x1 / side && ty == b.y1 / side)
            .then(|| ty as u32 * self.size.width().div_ceil(TILE) + tx as u32)
    }

    /// Puts an id into every tile that it may cover; false when there is none.
    fn bin(&self, id: u32, snapped: &[Snapped; 3], pixels: PixelBox, chunk: &mut Chunk) -> bool {
        let Some(edges) = edges(snapped) else {
            return false;
        };
        let before = chunk.ids.len();
        if let Some(tile) = self.only_tile(pixels) {
            chunk.put(tile, id);
        } else {
            let side = TILE as i32;
            let across = self.size.width().div_ceil(TILE);
            for ty in pixels.y0 / side..=pixels.y1 / side {
                for tx in pixels.x0 / side..=pixels.x1 / side {
                    let (x0, y0) = (tx * side, ty * side);
                    let tile = PixelBox {
                        x0,
                        y0,
                        x1: x0 + side - 1,
                        y1: y0 + side - 1,
                    };
                    if pixels
                        .intersect(tile)
                        .is_some_and(|b| edges.iter().all(|e| reaches(*e, b, self.margin)))
                    {
                        chunk.put(ty as u32 * across + tx as u32, id);
                    }
                }
            }
        }
        let binned = chunk.ids.len() > before;
        chunk.stats.binned += usize::from(binned);
        binned
    }
}

/// True if the edge's inner side holds a pixel centre of the box, or a point up to `margin` from one.
fn reaches(edge: Edge, b: PixelBox, margin: i32) -> bool {
    let x = if edge.a > 0 { b.x1 } else { b.x0 };
    let y = if edge.b > 0 { b.y1 } else { b.y0 };
    edge.a * centre(x)
        + edge.b * centre(y)
        + edge.c
        + i64::from(margin) * (edge.a.abs() + edge.b.abs())
        >= 0
}

fn combine(v: &[Hom; 3], w: [f64; 3]) -> Hom {
    let sum = |f: fn(&Hom) -> f64| f(&v[0]) * w[0] + f(&v[1]) * w[1] + f(&v[2]) * w[2];
    Hom {
        x: sum(|p| p.x),
        y: sum(|p| p.y),
        z: sum(|p| p.z),
        w: sum(|p| p.w),
    }
}

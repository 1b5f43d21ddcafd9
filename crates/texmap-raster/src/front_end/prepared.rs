//! The front end: transform, clip, cull, snap, bin.
use alloc::vec::Vec;

use texmap_math::{Level, MemoryBudget, parallel};

use crate::coverage::edge::{PixelBox, Snapped, area, edges, seen_from, snap};
use crate::front_end::arrays::Arrays;
use crate::front_end::bin::{self, Chunk, MOST, Piece, Submission};
use crate::front_end::transform::{self, SPECIAL, Transform};
use crate::setup::{Fragment, Shape, TILE, TriangleSetup};
use crate::{DrawCall, Interp, Pass, RasterError, Stats, TargetSize};

/// In 1/256 pixel.
const HALF_PIXEL: i32 = 128;

/// A part of the target: at most [`TILE`] x [`TILE`] pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Tile {
    /// Left pixel.
    pub x0: u32,
    /// Top pixel (row 0 is the top of the picture).
    pub y0: u32,
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
}

impl Tile {
    /// True if the target's edge does not cut the tile.
    pub(crate) fn is_whole(self) -> bool {
        self.width == TILE && self.height == TILE
    }
}

/// Draws made ready: transformed, clipped, culled, snapped and binned into tiles. A fragment's id names a triangle, or a
/// piece of one that was cut or subdivided, of this `BinnedDraws`.
#[derive(Debug)]
pub struct BinnedDraws<'a> {
    size: TargetSize,
    draws: Vec<DrawCall<'a>>,
    /// First id of each draw, and the number of all triangles at the end.
    first: Vec<u32>,
    transforms: Vec<Transform>,
    /// Vertices of each draw in 1/256 pixel.
    snapped: Vec<Vec<Snapped>>,
    level: Level,
    /// Pixels are shaded at their centre for samples beside it.
    sampled: bool,
    /// Ids from `first.last()` on.
    pieces: Vec<Piece>,
    /// Ids of tile t, in submitted order: `bin_start[t]..bin_start[t + 1]`.
    bin_ids: Vec<u32>,
    bin_start: Vec<u32>,
    stats: Stats,
}

impl<'a> BinnedDraws<'a> {
    /// Checks the draws and prepares them with the best instructions of this CPU, on one thread.
    ///
    /// # Errors
    /// Everything [`RasterError`] names but the target's size.
    pub fn new(size: TargetSize, draws: &[DrawCall<'a>]) -> Result<Self, RasterError> {
        Self::with_level(size, draws, best_level(), 1)
    }

    /// [`new`](Self::new) at a given level: the same bits at each. With the feature `rayon` and more than one thread the work is
    /// spread over the current rayon pool; fixed chunks keep every bit.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn with_level(
        size: TargetSize,
        draws: &[DrawCall<'a>],
        level: Level,
        threads: usize,
    ) -> Result<Self, RasterError> {
        Self::build(size, draws, level, threads, 0)
    }

    /// [`with_level`](Self::with_level) for [`visible_sample`](Self::visible_sample). Keeps triangles that cover no pixel's centre
    /// but may cover a sample up to half a pixel from one.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn with_samples(
        size: TargetSize,
        draws: &[DrawCall<'a>],
        level: Level,
        threads: usize,
    ) -> Result<Self, RasterError> {
        Self::build(size, draws, level, threads, HALF_PIXEL)
    }

    fn build(
        size: TargetSize,
        draws: &[DrawCall<'a>],
        level: Level,
        threads: usize,
        margin: i32,
    ) -> Result<Self, RasterError> {
        let mut first = Vec::with_capacity(draws.len() + 1);
        let mut total = 0u32;
        for (i, draw) in draws.iter().enumerate() {
            draw.check(i)?;
            first.push(total);
            let count =
                u32::try_from(draw.indices.len()).map_err(|_| RasterError::TooManyTriangles)?;
            total = total
                .checked_add(count)
                .filter(|&t| t <= MOST)
                .ok_or(RasterError::TooManyTriangles)?;
        }
        first.push(total);
        let transforms: Vec<_> = draws
            .iter()
            .map(|d| Transform::new(&d.clip_from_object, size))
            .collect();
        let mut snapped: Vec<_> = draws.iter().map(transform::snapped_buffer).collect();
        for ((draw, transform), buffer) in draws.iter().zip(&transforms).zip(&mut snapped) {
            let work = draw
                .positions
                .chunks(transform::CHUNK)
                .enumerate()
                .zip(buffer.chunks_mut(transform::CHUNK))
                .collect();
            for_all(threads, work, |((k, positions), out)| {
                let clip_z = draw.clip_z.get(k * transform::CHUNK..).unwrap_or_default();
                transform::snap_all(level, positions, clip_z, transform, out);
            });
            transform::mark_bad_attributes(level, draw, buffer);
        }
        let mut work = Vec::new();
        for (draw_index, draw) in draws.iter().enumerate() {
            let submission = Submission {
                size,
                draw,
                draw_index: draw_index as u32,
                first: first[draw_index],
                transform: transforms[draw_index],
                snapped: &snapped[draw_index],
                margin,
            };
            let triangles = draw.indices.len();
            work.extend(
                (0..triangles)
                    .step_by(bin::CHUNK)
                    .map(|at| (submission, at..triangles.min(at + bin::CHUNK))),
            );
        }
        let chunks = map_all(threads, work, |(submission, range)| {
            submission.run(level, range)
        });
        let mut prepared = Self {
            size,
            draws: draws.to_vec(),
            first,
            transforms,
            snapped,
            level,
            sampled: margin > 0,
            pieces: Vec::new(),
            bin_ids: Vec::new(),
            bin_start: Vec::new(),
            stats: Stats::default(),
        };
        let chunks = chunks.into_iter().collect::<Result<Vec<_>, _>>()?;
        prepared.merge(chunks)?;
        Ok(prepared)
    }

    /// True if a pixel's centre may lie outside a triangle that one of its samples shows.
    pub(crate) fn is_sampled(&self) -> bool {
        self.sampled
    }

    /// Joins the chunks in order: pieces, then each tile's ids.
    fn merge(&mut self, mut chunks: Vec<Chunk>) -> Result<(), RasterError> {
        let tiles =
            self.size.width().div_ceil(TILE) as usize * self.size.height().div_ceil(TILE) as usize;
        let mut start = alloc::vec![0u32; tiles + 1];
        for chunk in &mut chunks {
            chunk.name_pieces(self.whole() + self.pieces.len() as u32);
            self.pieces.append(&mut chunk.pieces);
            if self.pieces.len() > MOST as usize {
                return Err(RasterError::TooManyTriangles);
            }
            self.stats.add(chunk.stats);
            for (tile, ids) in chunk.runs() {
                let count = &mut start[tile + 1];
                *count = u32::try_from(ids.len())
                    .ok()
                    .and_then(|more| count.checked_add(more))
                    .ok_or(RasterError::TooManyTriangles)?;
            }
        }
        let mut sum = 0u32;
        for count in &mut start {
            sum = sum
                .checked_add(*count)
                .ok_or(RasterError::TooManyTriangles)?;
            *count = sum;
        }
        let bytes = u64::from(sum) * size_of::<u32>() as u64;
        bin::bins(MemoryBudget::of_process(), bytes)?;
        let mut next = start.clone();
        self.bin_ids = alloc::vec![0; sum as usize];
        for (tile, ids) in chunks.iter().flat_map(Chunk::runs) {
            let from = next[tile] as usize;
            self.bin_ids[from..from + ids.len()].copy_from_slice(ids);
            next[tile] += ids.len() as u32;
        }
        self.bin_start = start;
        Ok(())
    }

    /// The target's size.
    #[must_use]
    pub fn size(&self) -> TargetSize {
        self.size
    }

    /// Number of triangles by outcome.
    #[must_use]
    pub fn stats(&self) -> Stats {
        self.stats
    }

    /// Number of tiles of the target.
    #[must_use]
    pub fn tiles(&self) -> usize {
        self.bin_start.len() - 1
    }

    /// True if no triangle reaches a tile. None reaches those beyond the last.
    #[must_use]
    pub fn is_empty(&self, tile: usize) -> bool {
        self.bin_of(tile).is_empty()
    }

    /// Tile `index` of [`tiles`](Self::tiles), counted row by row from the top left.
    #[must_use]
    pub fn tile(&self, index: usize) -> Tile {
        let across = self.size.width().div_ceil(TILE) as usize;
        let (x0, y0) = (
            (index % across) as u32 * TILE,
            (index / across) as u32 * TILE,
        );
        Tile {
            x0,
            y0,
            width: TILE.min(self.size.width() - x0),
            height: TILE.min(self.size.height().saturating_sub(y0)),
        }
    }

    /// The draw, and the index of its triangle, that an id belongs to.
    ///
    /// # Panics
    /// For an id that none of these draws has, as do [`evaluate`](Self::evaluate), [`setup`](Self::setup) and
    /// [`is_front`](Self::is_front).
    #[must_use]
    pub fn source(&self, id: u32) -> (u32, u32) {
        let whole = self.whole();
        if id >= whole {
            let piece = &self.pieces[(id - whole) as usize];
            return (piece.draw, piece.triangle);
        }
        let draw = self.first.partition_point(|&f| f <= id) - 1;
        (draw as u32, id - self.first[draw])
    }

    /// Values, derivatives, 1/w and depth of fragment `id` at a pixel. Pixels outside the triangle give values at its hull.
    pub fn evaluate(&self, id: u32, x: u32, y: u32, out: &mut Fragment) {
        self.setup(id, x / TILE, y / TILE).evaluate(x, y, out);
    }

    /// The set-up behind [`evaluate`](Self::evaluate). Keep it while `id` and the tile (`x` and `y` over [`TILE`]) stay the same.
    #[must_use]
    pub fn setup(&self, id: u32, tile_x: u32, tile_y: u32) -> TriangleSetup {
        let (shape, _) = self.shape(id);
        TriangleSetup::new(&shape, tile_x, tile_y)
    }

    /// True if the viewer sees the front of an id's triangle.
    #[must_use]
    pub fn is_front(&self, id: u32) -> bool {
        if id < self.whole() {
            let (draw, triangle) = self.source(id);
            let snapped = &self.snapped[draw as usize];
            let corners = self.draws[draw as usize].indices[triangle as usize];
            let corners = corners.map(|vertex| snapped[vertex as usize]);
            if !corners.contains(&SPECIAL) {
                return area(&corners) < 0;
            }
        }
        self.shape(id).0.front
    }

    /// Id of a draw's first triangle.
    pub(crate) fn first(&self, draw: usize) -> u32 {
        self.first[draw]
    }

    /// Ids of a draw's whole triangles.
    pub(crate) fn id_range(&self, draw: usize) -> core::ops::Range<u32> {
        self.first[draw]..self.first[draw + 1]
    }

    pub(crate) fn is_piece_of(&self, id: u32, draw: u32) -> bool {
        id.checked_sub(self.whole())
            .is_some_and(|k| self.pieces[k as usize].draw == draw)
    }

    pub(crate) fn transform(&self, draw: usize) -> &Transform {
        &self.transforms[draw]
    }

    /// A draw's arrays for gathers; `None` where they are empty or too long for 32-bit indices.
    pub(crate) fn arrays(&self, draw: usize) -> Option<Arrays<'_>> {
        Arrays::new(&self.draws[draw], &self.snapped[draw])
    }

    pub(crate) fn level(&self) -> Level {
        self.level
    }

    pub(crate) fn draw(&self, draw: u32) -> &DrawCall<'a> {
        &self.draws[draw as usize]
    }

    pub(crate) fn bin_of(&self, tile: usize) -> &[u32] {
        match self.bin_start.get(tile..).unwrap_or_default() {
            [from, to, ..] => &self.bin_ids[*from as usize..*to as usize],
            _ => &[],
        }
    }

    /// The triangle behind an id and its pixels within the target.
    pub(crate) fn shape(&self, id: u32) -> (Shape<'a>, Option<PixelBox>) {
        self.shape_at(id, [0; 2])
    }

    /// [`shape`](Self::shape) as samples at `offset` from the pixels' centres, in 1/256 pixel, see it.
    pub(crate) fn shape_at(&self, id: u32, offset: [i32; 2]) -> (Shape<'a>, Option<PixelBox>) {
        let (draw_index, triangle) = self.source(id);
        let draw = &self.draws[draw_index as usize];
        let corners = draw.indices[triangle as usize];
        let whole = self.whole();
        let (outer, piece, weights, front) = if id >= whole {
            let p = &self.pieces[(id - whole) as usize];
            (p.outer, p.corners, Some(p.weights), p.front)
        } else {
            let transform = &self.transforms[draw_index as usize];
            let v = corners.map(|i| transform.vertex(draw, i));
            let front = area(&v.map(snap)) < 0;
            (v, v, None, front)
        };
        let n = draw.attribute_count;
        let snapped = seen_from(&piece.map(snap), offset);
        let affine = matches!(draw.interp, Interp::Affine | Interp::Subdivided(_));
        let shape = Shape {
            outer,
            piece,
            weights,
            attributes: corners.map(|i| &draw.attributes[i as usize * n..(i as usize + 1) * n]),
            screen_linear: if affine { u32::MAX } else { draw.screen_linear },
            front,
            edges: edges(&snapped).unwrap_or_default(),
            width: self.size.width() as i32,
            interp: draw.interp,
            interp_scale: draw.interp_scale,
            depth_slope: draw.depth_slope,
        };
        (
            shape,
            PixelBox::of(
                &snapped,
                0,
                self.size.width() as i32,
                self.size.height() as i32,
            ),
        )
    }

    /// Number of whole triangles: ids from here on name pieces.
    pub(crate) fn whole(&self) -> u32 {
        self.first.last().copied().unwrap_or(0)
    }
}

/// True if a draw decides visibility.
pub(crate) fn decides_visibility(pass: Pass) -> bool {
    pass != Pass::Blended
}

#[cfg(feature = "std")]
pub(crate) fn best_level() -> Level {
    Level::new()
}

#[cfg(not(feature = "std"))]
pub(crate) fn best_level() -> Level {
    Level::baseline()
}

/// `f` of each item, in order, on the current rayon pool where there is one.
fn map_all<T: Send, R: Send>(threads: usize, work: Vec<T>, f: impl Fn(T) -> R + Sync) -> Vec<R> {
    match threads > 1 {
        true => parallel::map(work.into_iter(), f),
        false => work.into_iter().map(f).collect(),
    }
}

pub(crate) fn for_all<T: Send>(threads: usize, work: Vec<T>, f: impl Fn(T) + Sync) {
    match threads > 1 {
        true => parallel::for_each(work.into_iter(), f),
        false => work.into_iter().for_each(f),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The side by snapped vertices is that of the shape, of triangles that are cut and of ones beyond the guard band too.
    #[test]
    fn sides_are_those_of_shapes() {
        let mut state = 7u32;
        let mut next = |size: f32| {
            state = state.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
            size * ((state >> 8) as f32 / (1 << 24) as f32 - 0.5)
        };
        let positions: Vec<[f32; 3]> = (0..900)
            .map(|k| {
                let size = [1.5, 1.5, 1.5, 3.0, 1e3][k / 3 % 5];
                [next(size), next(size), 0.4 + next(1.0)]
            })
            .collect();
        let indices: Vec<[u32; 3]> = (0..300).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect();
        let draw = DrawCall {
            positions: &positions,
            indices: &indices,
            ..DrawCall::default()
        };
        let size = TargetSize::new(64, 64).unwrap();
        let prepared = BinnedDraws::new(size, &[draw]).unwrap();
        let ids: Vec<u32> = (0..prepared.tiles())
            .flat_map(|tile| prepared.bin_of(tile).iter().copied())
            .collect();
        let fronts: Vec<bool> = ids.iter().map(|id| prepared.is_front(*id)).collect();
        let shapes: Vec<bool> = ids.iter().map(|id| prepared.shape(*id).0.front).collect();
        assert_eq!(fronts, shapes);
        assert!(fronts.contains(&true) && fronts.contains(&false));
        assert!(ids.iter().any(|id| *id >= prepared.whole()));
        // There is nothing beyond the last tile.
        let far = prepared.tiles() + 99;
        let mut buffers = crate::VisibilityBuffer::new();
        prepared.visible(far, &crate::NoAlphaTest, &mut buffers);
        assert!(prepared.is_empty(far) && buffers.id.iter().all(|id| *id == crate::NO_PRIMITIVE));
    }
}

//! The front end: transform, clip, cull, snap, bin.
use alloc::vec::Vec;

use texmap_math::glam::{DMat4, DVec4};

use crate::clip::{Corner, Hom, Region, clip, region};
use crate::edge::{Edge, PixelBox, Snapped, area, centre, edges, snap};
use crate::planes::determinant;
use crate::setup::{Fragment, Shape, TILE, TriangleSetup};
use crate::{Cull, Draw, Interp, Pass, RasterError, Stats, TargetSize};

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

/// Draws made ready: transformed, clipped, culled, snapped and binned into tiles. A fragment's id names a triangle, or a
/// piece of one that was cut or subdivided, of this `Prepared`.
#[derive(Debug)]
pub struct Prepared<'a> {
    size: TargetSize,
    draws: Vec<Draw<'a>>,
    /// First id of each draw, and the number of all triangles at the end.
    first: Vec<u32>,
    /// Ids from `first.last()` on.
    pieces: Vec<Piece>,
    /// Ids of each tile in submitted order.
    bins: Vec<Vec<u32>>,
    stats: Stats,
}

/// A piece of a triangle that could not be taken whole.
#[derive(Debug, Clone, Copy)]
struct Piece {
    draw: u32,
    triangle: u32,
    front: bool,
    /// The vertices whose planes carry the attributes: the triangle's, or the part's where subdivided.
    outer: [Hom; 3],
    corners: [Hom; 3],
    weights: [[f64; 3]; 3],
}

impl<'a> Prepared<'a> {
    /// Checks the draws and prepares them.
    ///
    /// # Errors
    /// Everything [`RasterError`] names but the target's size.
    pub fn new(size: TargetSize, draws: &[Draw<'a>]) -> Result<Self, RasterError> {
        let mut first = Vec::with_capacity(draws.len() + 1);
        let mut total = 0u32;
        for (i, draw) in draws.iter().enumerate() {
            draw.check(i)?;
            first.push(total);
            let count =
                u32::try_from(draw.indices.len()).map_err(|_| RasterError::TooManyTriangles)?;
            total = total
                .checked_add(count)
                .ok_or(RasterError::TooManyTriangles)?;
        }
        first.push(total);
        let tiles = size.width().div_ceil(TILE) as usize * size.height().div_ceil(TILE) as usize;
        let mut prepared = Self {
            size,
            draws: draws.to_vec(),
            first,
            pieces: Vec::new(),
            bins: alloc::vec![Vec::new(); tiles],
            stats: Stats::default(),
        };
        for (index, draw) in draws.iter().enumerate() {
            for triangle in 0..draw.indices.len() {
                prepared.submit(index, triangle)?;
            }
        }
        Ok(prepared)
    }

    /// The target's size.
    #[must_use]
    pub fn size(&self) -> TargetSize {
        self.size
    }

    /// What became of the triangles.
    #[must_use]
    pub fn stats(&self) -> Stats {
        self.stats
    }

    /// How many tiles the target has.
    #[must_use]
    pub fn tiles(&self) -> usize {
        self.bins.len()
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

    /// Which draw and which of its triangles an id belongs to.
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

    /// The set-up behind [`evaluate`](Self::evaluate), to be kept while `id` and the tile (`x` and `y` over [`TILE`]) stay the same.
    #[must_use]
    pub fn setup(&self, id: u32, tile_x: u32, tile_y: u32) -> TriangleSetup {
        let (shape, _) = self.shape(id);
        TriangleSetup::new(&shape, tile_x, tile_y)
    }

    pub(crate) fn draw(&self, draw: u32) -> &Draw<'a> {
        &self.draws[draw as usize]
    }

    pub(crate) fn bin(&self, tile: usize) -> &[u32] {
        &self.bins[tile]
    }

    /// The triangle behind an id and its pixels within the target.
    pub(crate) fn shape(&self, id: u32) -> (Shape<'a>, Option<PixelBox>) {
        let (draw_index, triangle) = self.source(id);
        let draw = &self.draws[draw_index as usize];
        let corners = draw.indices[triangle as usize];
        let whole = self.whole();
        let (outer, piece, weights, front) = if id >= whole {
            let p = &self.pieces[(id - whole) as usize];
            (p.outer, p.corners, Some(p.weights), p.front)
        } else {
            let v = self.vertices(draw, corners);
            let front = area(&v.map(snap)) < 0;
            (v, v, None, front)
        };
        let n = draw.attribute_count;
        let snapped = piece.map(snap);
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
        };
        (
            shape,
            PixelBox::of(
                &snapped,
                self.size.width() as i32,
                self.size.height() as i32,
            ),
        )
    }

    /// Number of whole triangles: ids from here on name pieces.
    fn whole(&self) -> u32 {
        self.first.last().copied().unwrap_or(0)
    }

    fn vertices(&self, draw: &Draw<'_>, corners: [u32; 3]) -> [Hom; 3] {
        corners.map(|i| {
            transform(
                &draw.clip_from_object,
                draw.positions[i as usize],
                self.size,
            )
        })
    }

    fn submit(&mut self, draw_index: usize, triangle: usize) -> Result<(), RasterError> {
        self.stats.submitted += 1;
        let draw = self.draws[draw_index];
        let corners = draw.indices[triangle];
        let v = self.vertices(&draw, corners);
        let n = draw.attribute_count;
        let finite = |i: u32| {
            draw.attributes[i as usize * n..(i as usize + 1) * n]
                .iter()
                .all(|a| a.is_finite())
        };
        if !v.iter().all(|p| p.is_usable()) || !corners.iter().all(|&i| finite(i)) {
            self.stats.non_finite += 1;
            return Ok(());
        }
        let id = self.first[draw_index] + triangle as u32;
        let source = Source {
            draw: draw_index as u32,
            triangle: triangle as u32,
            id,
            cull: draw.cull,
        };
        let Interp::Subdivided(parts) = draw.interp else {
            const WHOLE: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
            return self.submit_part(source, v, WHOLE, true);
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
                self.submit_part(source, up.map(|w| combine(&v, w)), up, false)?;
                if i + j + 2 <= parts {
                    let down = [at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                    self.submit_part(source, down.map(|w| combine(&v, w)), down, false)?;
                }
            }
        }
        Ok(())
    }

    /// `rows` are the weights of the part's vertices over the triangle's; `whole`: the part is the triangle.
    fn submit_part(
        &mut self,
        source: Source,
        v: [Hom; 3],
        rows: [[f64; 3]; 3],
        whole: bool,
    ) -> Result<(), RasterError> {
        let (width, height) = (f64::from(self.size.width()), f64::from(self.size.height()));
        match region(&v, width, height) {
            Region::Outside => self.stats.outside += 1,
            Region::Inside => {
                let snapped = v.map(snap);
                let front = match area(&snapped) {
                    0 => {
                        self.stats.degenerate += 1;
                        return Ok(());
                    }
                    area => area < 0,
                };
                if source.drops(front) {
                    self.stats.culled += 1;
                } else if whole {
                    self.bin_id(source.id, &snapped);
                } else {
                    self.add_piece(source, front, v, v, rows, &snapped)?;
                }
            }
            Region::Crossing => {
                // The sign holds for vertices behind the eye too.
                let determinant = determinant(&v);
                if determinant == 0.0 {
                    self.stats.degenerate += 1;
                    return Ok(());
                }
                let front = determinant < 0.0;
                if source.drops(front) {
                    self.stats.culled += 1;
                    return Ok(());
                }
                self.stats.clipped += 1;
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
                    let piece = [*hub, pair[0], pair[1]];
                    let corners = piece.map(|c| c.at);
                    let snapped = corners.map(snap);
                    if area(&snapped) != 0 {
                        self.add_piece(
                            source,
                            front,
                            v,
                            corners,
                            piece.each_ref().map(over_triangle),
                            &snapped,
                        )?;
                    }
                }
            }
        }
        Ok(())
    }

    fn add_piece(
        &mut self,
        source: Source,
        front: bool,
        outer: [Hom; 3],
        corners: [Hom; 3],
        weights: [[f64; 3]; 3],
        snapped: &[Snapped; 3],
    ) -> Result<(), RasterError> {
        let id = u32::try_from(self.pieces.len())
            .ok()
            .and_then(|n| self.whole().checked_add(n));
        let id = id
            .filter(|&id| id < u32::MAX - 1)
            .ok_or(RasterError::TooManyTriangles)?;
        if self.bin_id(id, snapped) {
            self.pieces.push(Piece {
                draw: source.draw,
                triangle: source.triangle,
                front,
                outer,
                corners,
                weights,
            });
        }
        Ok(())
    }

    /// Puts an id into every tile that it may cover. False when it covers no pixel centre's box.
    fn bin_id(&mut self, id: u32, snapped: &[Snapped; 3]) -> bool {
        let (width, height) = (self.size.width() as i32, self.size.height() as i32);
        let (Some(pixels), Some(edges)) = (PixelBox::of(snapped, width, height), edges(snapped))
        else {
            return false;
        };
        let side = TILE as i32;
        let across = self.size.width().div_ceil(TILE) as usize;
        let mut binned = false;
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
                    .is_some_and(|b| edges.iter().all(|e| reaches(*e, b)))
                {
                    self.bins[ty as usize * across + tx as usize].push(id);
                    binned = true;
                }
            }
        }
        self.stats.binned += usize::from(binned);
        binned
    }
}

/// A triangle on its way through the front end.
#[derive(Debug, Clone, Copy)]
struct Source {
    draw: u32,
    triangle: u32,
    id: u32,
    cull: Cull,
}

impl Source {
    fn drops(self, front: bool) -> bool {
        match self.cull {
            Cull::None => false,
            Cull::Back => !front,
            Cull::Front => front,
        }
    }
}

/// Whether the edge's inner side holds a pixel centre of the box.
fn reaches(edge: Edge, b: PixelBox) -> bool {
    let x = if edge.a > 0 { b.x1 } else { b.x0 };
    let y = if edge.b > 0 { b.y1 } else { b.y0 };
    edge.a * centre(x) + edge.b * centre(y) + edge.c >= 0
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

/// Object space to homogeneous pixels.
fn transform(matrix: &DMat4, position: [f32; 3], size: TargetSize) -> Hom {
    let [x, y, z] = position.map(f64::from);
    let m = matrix.to_cols_array_2d();
    let row = |r: usize| (m[0][r] * x + m[1][r] * y) + (m[2][r] * z + m[3][r]);
    let clip = DVec4::new(row(0), row(1), row(2), row(3));
    Hom {
        x: (clip.x + clip.w) * (0.5 * f64::from(size.width())),
        y: (clip.w - clip.y) * (0.5 * f64::from(size.height())),
        z: clip.z,
        w: clip.w,
    }
}

/// Whether a draw decides visibility.
pub(crate) fn decides_visibility(pass: Pass) -> bool {
    pass != Pass::Blended
}

//! One picture of `rast`: coverage by the rasterizer, then barycentrics, depth and their derivatives from planes over the pixels.

use rayon::prelude::*;
use texmap_math::Level;
use texmap_math::glam::DMat4;
use texmap_raster::{
    AlphaTest, BinnedDraws, DrawCall, NO_PRIMITIVE, NoAlphaTest, Pass, RasterError, TILE,
    TargetSize, VisibilityBuffer,
};

use crate::peel::{Layer, Peel};

/// A picture of a batch: first vertex, vertices, first triangle, triangles.
pub(crate) type Range = (usize, usize, usize, usize);

/// Ids up to this stand in f32 as they are; larger ones as its bits counted on from those of 2^24.
const EXACT: u32 = 1 << 24;

/// The number of a triangle as `rast` holds it: id + 1 as f32, or beyond 2^24 as the bits 0x4a800000 + id + 1.
pub(crate) fn encode(triangle: usize) -> f32 {
    let id = triangle as u32 + 1;
    match id <= EXACT {
        true => id as f32,
        false => f32::from_bits(0x4a80_0000 + id),
    }
}

/// The triangle of a pixel of `rast`; `None` where there is none.
#[inline(always)]
pub(crate) fn decode(id: f32) -> Option<usize> {
    let id = match id <= EXACT as f32 {
        true => id as u32,
        false => id.to_bits() - 0x4a80_0000,
    };
    (id as usize).checked_sub(1)
}

/// The arrays of one picture.
pub(crate) struct Picture<'a> {
    pub(crate) size: TargetSize,
    pub(crate) rast: &'a mut [f32],
    /// Derivatives, or empty.
    pub(crate) db: &'a mut [f32],
}

impl Picture<'_> {
    /// Draws the triangles of a range.
    pub(crate) fn draw(
        self,
        pos: &[[f32; 4]],
        tri: &[[u32; 3]],
        (first_vertex, vertices, first_triangle, triangles): Range,
        layer: Option<Layer<'_>>,
        level: Level,
    ) -> Result<(), RasterError> {
        let pos = &pos[first_vertex..first_vertex + vertices];
        let tri = &tri[first_triangle..first_triangle + triangles];
        let flat: Vec<[f32; 3]> = pos.iter().map(|p| [p[0], p[1], p[3]]).collect();
        // From -w..w, growing away, to w..0.
        let clip_z: Vec<f32> = pos.iter().map(|p| 0.5 * (p[3] - p[2])).collect();
        let peeled = layer.as_ref().is_some_and(|layer| !layer.first);
        let draw = DrawCall {
            positions: &flat,
            clip_z: &clip_z,
            indices: tri,
            // (x, y, w) to (x, -y, z, w): row 0 of the target is the bottom row.
            clip_from_object: DMat4::from_cols_array(&[
                1.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0,
            ]),
            pass: if peeled { Pass::CutOut } else { Pass::Opaque },
            ..DrawCall::default()
        };
        let threads = rayon::current_num_threads();
        let binned = BinnedDraws::with_level(self.size, &[draw], level, threads)?;
        let scene = Triangles {
            pos,
            tri,
            half: [self.size.width(), self.size.height()].map(|n| 0.5 * f64::from(n)),
            first: first_triangle,
        };
        match layer {
            None => self.fill(&scene, &binned, &NoAlphaTest, None),
            Some(layer) if layer.first => {
                self.fill(
                    &scene,
                    &binned,
                    &NoAlphaTest,
                    Some((layer.depths, layer.ids)),
                );
            }
            Some(layer) => {
                let (depths, ids) = (layer.depths.to_vec(), layer.ids.to_vec());
                let peel = Peel {
                    width: self.size.width(),
                    depths: &depths,
                    ids: &ids,
                };
                self.fill(&scene, &binned, &peel, Some((layer.depths, layer.ids)));
            }
        }
        Ok(())
    }

    fn fill<A: AlphaTest + Sync>(
        self,
        scene: &Triangles<'_>,
        binned: &BinnedDraws<'_>,
        test: &A,
        layer: Option<(&mut [f32], &mut [u32])>,
    ) {
        let width = self.size.width() as usize;
        let across = width.div_ceil(TILE as usize);
        let band = width * TILE as usize;
        let (depths, ids) = layer.unwrap_or_default();
        let mut db = self.db.chunks_mut(4 * band);
        let (mut depths, mut ids) = (depths.chunks_mut(band), ids.chunks_mut(band));
        let bands: Vec<_> = self
            .rast
            .chunks_mut(4 * band)
            .enumerate()
            .map(|(k, rast)| Band {
                tiles: k * across..(k + 1) * across,
                width,
                rast: rast.as_chunks_mut().0,
                db: db.next().unwrap_or_default().as_chunks_mut().0,
                depths: depths.next().unwrap_or_default(),
                ids: ids.next().unwrap_or_default(),
            })
            .collect();
        let fill = |band: Band<'_>| band.fill(scene, binned, test);
        if rayon::current_num_threads() > 1 {
            bands.into_par_iter().for_each(fill);
        } else {
            bands.into_iter().for_each(fill);
        }
    }
}

/// The triangles of a picture in clip space.
struct Triangles<'a> {
    pos: &'a [[f32; 4]],
    tri: &'a [[u32; 3]],
    /// Half of the width and height.
    half: [f64; 2],
    /// Number of the first triangle.
    first: usize,
}

/// A row of tiles with its rows of the arrays.
struct Band<'a> {
    tiles: std::ops::Range<usize>,
    width: usize,
    rast: &'a mut [[f32; 4]],
    db: &'a mut [[f32; 4]],
    depths: &'a mut [f32],
    ids: &'a mut [u32],
}

impl Band<'_> {
    fn fill<A: AlphaTest>(mut self, scene: &Triangles<'_>, binned: &BinnedDraws<'_>, test: &A) {
        let mut buffers = VisibilityBuffer::new();
        // Set-ups by the low bits of their id: a triangle comes again in the rows below.
        let mut cache: Vec<(u32, Planes)> = vec![(NO_PRIMITIVE, Planes::default()); CACHED];
        for index in self.tiles.clone() {
            let tile = binned.tile(index);
            let columns = tile.x0 as usize..(tile.x0 + tile.width) as usize;
            let empty = binned.is_empty(index);
            if !empty {
                binned.visible(index, test, &mut buffers);
            }
            for y in 0..tile.height as usize {
                let at = y * self.width + columns.start..y * self.width + columns.end;
                if empty {
                    self.clear(at);
                    continue;
                }
                let row = y * TILE as usize;
                let ids = &buffers.id[row..row + tile.width as usize];
                let py = f64::from(tile.y0) + y as f64 + 0.5;
                if !self.ids.is_empty() {
                    let depths = &buffers.depth[row..row + tile.width as usize];
                    self.depths[at.clone()].copy_from_slice(depths);
                    for (out, id) in self.ids[at.clone()].iter_mut().zip(ids) {
                        *out = match *id {
                            NO_PRIMITIVE => NO_PRIMITIVE,
                            id => binned.source(id).1,
                        };
                    }
                }
                let mut x = 0;
                while x < ids.len() {
                    let id = ids[x];
                    let count = ids[x..].iter().take_while(|next| **next == id).count();
                    let run = at.start + x..at.start + x + count;
                    if id == NO_PRIMITIVE {
                        self.clear_values(run);
                    } else {
                        let slot = &mut cache[id as usize % CACHED];
                        if slot.0 != id {
                            *slot = (id, Planes::new(scene, binned.source(id).1 as usize));
                        }
                        let px = (columns.start + x) as f64 + 0.5;
                        let db = match self.db.is_empty() {
                            true => &mut [],
                            false => &mut self.db[run.clone()],
                        };
                        slot.1.fill([px, py], &mut self.rast[run], db);
                    }
                    x += count;
                }
            }
        }
    }

    fn clear(&mut self, at: std::ops::Range<usize>) {
        if !self.ids.is_empty() {
            self.ids[at.clone()].fill(NO_PRIMITIVE);
            self.depths[at.clone()].fill(0.0);
        }
        self.clear_values(at);
    }

    fn clear_values(&mut self, at: std::ops::Range<usize>) {
        self.rast[at.clone()].fill([0.0; 4]);
        if !self.db.is_empty() {
            self.db[at].fill([0.0; 4]);
        }
    }
}

const CACHED: usize = 256;

/// Planes over the pixels: a triangle's homogeneous edge functions (Olano and Greer 1997), so that no vertex is divided by its w.
#[derive(Clone, Copy, Default)]
struct Planes {
    /// Of the first two vertices; the weights are their values over the sum's.
    edges: [[f64; 3]; 2],
    /// Sum of all three.
    sum: [f64; 3],
    /// z/w, linear on the screen.
    depth: [f64; 3],
    id: f32,
}

impl Planes {
    fn new(scene: &Triangles<'_>, triangle: usize) -> Self {
        let corners = scene.tri[triangle].map(|i| scene.pos[i as usize].map(f64::from));
        let [a, b, c] =
            corners.map(|[x, y, _, w]| [(x + w) * scene.half[0], (y + w) * scene.half[1], w]);
        let cross = |p: [f64; 3], q: [f64; 3]| {
            [
                p[1] * q[2] - p[2] * q[1],
                p[2] * q[0] - p[0] * q[2],
                p[0] * q[1] - p[1] * q[0],
            ]
        };
        let edges = [cross(b, c), cross(c, a), cross(a, b)];
        let sum = [0, 1, 2].map(|k| edges[0][k] + edges[1][k] + edges[2][k]);
        let det = edges[0][0] * a[0] + edges[0][1] * a[1] + edges[0][2] * a[2];
        let depth = [0, 1, 2].map(|k| {
            let [e, f, g] = [edges[0][k], edges[1][k], edges[2][k]];
            (e * corners[0][2] + f * corners[1][2] + g * corners[2][2]) / det
        });
        Self {
            edges: [edges[0], edges[1]],
            sum,
            depth,
            id: encode(scene.first + triangle),
        }
    }

    /// The values of a plane along a row from a pixel on: the first, and the step.
    #[inline(always)]
    fn row([a, b, c]: [f64; 3], [px, py]: [f64; 2]) -> [f64; 2] {
        [a * px + (b * py + c), a]
    }

    /// u, v, z/w and the id of pixels from `at` to the right, and du/dX, du/dY, dv/dX and dv/dY where `db` is not empty. Weights end at 0
    /// and 1: a pixel may lie outside of the exact triangle by the 1/256 pixel that its vertices are snapped to.
    #[inline(always)]
    fn fill(&self, at: [f64; 2], out: &mut [[f32; 4]], db: &mut [[f32; 4]]) {
        let planes = [self.edges[0], self.edges[1], self.sum, self.depth];
        let [[mut u, du], [mut v, dv], [mut s, ds], [mut z, dz]] = planes.map(|p| Self::row(p, at));
        let [[ux, uy, _], [vx, vy, _]] = self.edges;
        let [sx, sy, _] = self.sum;
        let mut db = db.iter_mut();
        for out in out {
            let inv = 1.0 / s;
            let (b0, b1) = (u * inv, v * inv);
            if let Some(db) = db.next() {
                let of = |a: f64, value: f64, b: f64| ((a - value * b) * inv) as f32;
                *db = [
                    of(ux, b0, sx),
                    of(uy, b0, sy),
                    of(vx, b1, sx),
                    of(vy, b1, sy),
                ];
            }
            let (b0, b1) = (bounded(b0), bounded(b1));
            let rest = 1.0 - b0;
            let b1 = if b1 < rest { b1 } else { rest };
            *out = [b0 as f32, b1 as f32, z as f32, self.id];
            (u, v, s, z) = (u + du, v + dv, s + ds, z + dz);
        }
    }
}

/// Within 0 and 1; NaN gives 0.
#[inline(always)]
fn bounded(x: f64) -> f64 {
    let x = if x > 0.0 { x } else { 0.0 };
    if x < 1.0 { x } else { 1.0 }
}

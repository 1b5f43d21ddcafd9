//! One picture of `rast`: visibility by the rasterizer, then the values of what is seen from planes over the pixels.

use rayon::prelude::*;
use texmap_math::glam::DMat4;
use texmap_math::simd::Isa;
use texmap_math::{Level, dispatch_simd};
use texmap_raster::{
    AlphaTest, BinnedDraws, DrawCall, NO_PRIMITIVE, NoAlphaTest, Pass, RasterError, TILE,
    TargetSize, Tile, TileVisibility, block_index,
};

use crate::peel::{Layer, Peel};
use crate::planes::{TilePlanes, Triangles};

/// A picture of a batch: first vertex, vertices, first triangle, triangles.
pub(crate) type Range = (usize, usize, usize, usize);

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
            None => self.fill(&scene, &binned, &NoAlphaTest, level, None),
            Some(layer) if layer.first => {
                self.fill(
                    &scene,
                    &binned,
                    &NoAlphaTest,
                    level,
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
                self.fill(
                    &scene,
                    &binned,
                    &peel,
                    level,
                    Some((layer.depths, layer.ids)),
                );
            }
        }
        Ok(())
    }

    fn fill<A: AlphaTest + Sync>(
        self,
        scene: &Triangles<'_>,
        binned: &BinnedDraws<'_>,
        test: &A,
        level: Level,
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
        let fill = |band: Band<'_>| band.fill(scene, binned, test, level);
        if rayon::current_num_threads() > 1 {
            bands.into_par_iter().for_each(fill);
        } else {
            bands.into_iter().for_each(fill);
        }
    }
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
    fn fill<A: AlphaTest>(
        mut self,
        scene: &Triangles<'_>,
        binned: &BinnedDraws<'_>,
        test: &A,
        level: Level,
    ) {
        let mut seen = TileVisibility::new();
        let mut planes = TilePlanes::default();
        for index in self.tiles.clone() {
            let tile = binned.tile(index);
            if binned.is_empty(index) {
                self.clear(tile);
                continue;
            }
            binned.visible_blocks(index, test, &mut seen);
            if !self.ids.is_empty() {
                self.keep_layer(tile, binned, &seen);
            }
            planes.forget(seen.ids.len());
            match self.db.is_empty() {
                true => {
                    dispatch_simd!(level, i => self.values::<_, false>(i, tile, scene, binned, &seen, &mut planes))
                }
                false => {
                    dispatch_simd!(level, i => self.values::<_, true>(i, tile, scene, binned, &seen, &mut planes))
                }
            }
        }
    }

    /// The pixels of a tile's row.
    fn row(&self, tile: Tile, y: usize) -> std::ops::Range<usize> {
        let start = y * self.width + tile.x0 as usize;
        start..start + tile.width as usize
    }

    fn clear(&mut self, tile: Tile) {
        for y in 0..tile.height as usize {
            let at = self.row(tile, y);
            if !self.ids.is_empty() {
                self.ids[at.clone()].fill(NO_PRIMITIVE);
                self.depths[at.clone()].fill(0.0);
            }
            if !self.db.is_empty() {
                self.db[at.clone()].fill([0.0; 4]);
            }
            self.rast[at].fill([0.0; 4]);
        }
    }

    /// Depths and triangles for the next layer.
    fn keep_layer(&mut self, tile: Tile, binned: &BinnedDraws<'_>, seen: &TileVisibility) {
        for y in 0..tile.height {
            let at = self.row(tile, y as usize);
            let out = self.depths[at.clone()].iter_mut().zip(&mut self.ids[at]);
            for (x, (depth, id)) in (0..).zip(out) {
                let pixel = block_index(x, y);
                *depth = seen.depth[pixel];
                *id = match seen.slot[pixel] {
                    NO_PRIMITIVE => NO_PRIMITIVE,
                    slot => binned.source(seen.ids[slot as usize]).1,
                };
            }
        }
    }

    /// Values of a tile block by block: planes are near, and whole cache lines are written.
    #[inline(always)]
    fn values<I: Isa, const DB: bool>(
        &mut self,
        i: I,
        tile: Tile,
        scene: &Triangles<'_>,
        binned: &BinnedDraws<'_>,
        seen: &TileVisibility,
        planes: &mut TilePlanes,
    ) {
        let (width, height) = (tile.width as usize, tile.height as usize);
        let blocks = seen.slot.as_chunks::<16>().0.iter().zip(&seen.masks);
        let (mut out, mut db) = ([0.0; 64], [0.0; 64]);
        for (block, (slots, mask)) in blocks.enumerate() {
            let (x, y) = (block % BLOCKS * 4, block / BLOCKS * 4);
            if x >= width || y >= height {
                continue;
            }
            let (px, py) = (tile.x0 as usize + x, tile.y0 as usize + y);
            let at = [px as f64 + 0.5, py as f64 + 0.5];
            if *mask == 0 {
                (out, db) = ([0.0; 64], [0.0; 64]);
            } else {
                planes.block::<I, DB>(
                    i, scene, binned, &seen.ids, slots, *mask, at, &mut out, &mut db,
                );
            }
            let columns = (width - x).min(4);
            for k in 0..(height - y).min(4) {
                let pixels = (y + k) * self.width + px..(y + k) * self.width + px + columns;
                put(&out, k, &mut self.rast[pixels.clone()]);
                if DB {
                    put(&db, k, &mut self.db[pixels]);
                }
            }
        }
    }
}

/// Row `k` of a block to the pixels of a picture, which may have fewer.
#[inline(always)]
fn put(block: &[f32; 64], k: usize, out: &mut [[f32; 4]]) {
    let row = &block.as_chunks::<4>().0[4 * k..4 * k + 4];
    match out.as_chunks_mut::<4>() {
        ([whole], []) => whole.copy_from_slice(row),
        (_, out) => out.copy_from_slice(&row[..out.len()]),
    }
}

/// 4x4 blocks across a tile.
const BLOCKS: usize = TILE as usize / 4;

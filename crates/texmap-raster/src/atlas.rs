//! The UV-space target: the same coverage over a texture atlas, for bakes and transfers.
use alloc::vec::Vec;

use texmap_math::float::sqrt;
use texmap_math::glam::{DMat4, DVec3};

use crate::edge::{Edge, ONE, PixelBox, Snapped, centre, edges};
use crate::{Draw, NONE, NoAlphaTest, Prepared, RasterError, TILE, TargetSize, TileBuffers};

/// A mesh with texture coordinates.
#[derive(Debug, Clone, Copy, Default)]
pub struct AtlasMesh<'a> {
    /// Texture coordinates a vertex; the atlas is 0..1 on both axes, what lies outside is not drawn.
    pub uvs: &'a [[f32; 2]],
    /// Positions a vertex, or empty.
    pub positions: &'a [[f32; 3]],
    /// Normals a vertex, or empty.
    pub normals: &'a [[f32; 3]],
    /// Three vertices a face.
    pub indices: &'a [[u32; 3]],
    /// Whether v counts from the bottom row (OBJ) and not from the top (glTF).
    pub bottom_up: bool,
}

/// How a texel came to its face.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[repr(u8)]
pub enum Coverage {
    /// No face.
    #[default]
    None = 0,
    /// The face covers the texel's centre.
    Centre = 1,
    /// The face touches the texel beside its centre (conservative mode).
    Touched = 2,
    /// Copied from a neighbour (gutter).
    Gutter = 3,
}

/// A rasterized atlas: one value a texel, row by row from the top.
#[derive(Debug, Clone, PartialEq)]
pub struct Atlas {
    /// The atlas' size.
    pub size: TargetSize,
    /// How each texel came to its face.
    pub coverage: Vec<Coverage>,
    /// The face, [`NONE`] where there is none. Where faces overlap the first one wins.
    pub face: Vec<u32>,
    /// Weights over the face's three vertices at the texel's centre, moved to the face where the centre lies outside; 0 where
    /// there is no face.
    pub barycentric: Vec<[f32; 3]>,
    /// Interpolated positions; empty when the mesh has none.
    pub position: Vec<[f32; 3]>,
    /// Interpolated normals of unit length (0 where they cancel); empty when the mesh has none.
    pub normal: Vec<[f32; 3]>,
    /// Faces that own no texel, ascending: outside the atlas, not finite, or hidden by others; without `conservative` also
    /// those that cover no texel centre.
    pub lost: Vec<u32>,
}

/// What an atlas is asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct AtlasOptions {
    /// Also texels that a face touches without covering their centre: no face that touches the atlas is lost, however small,
    /// as long as there are texels enough where it lies. A face without a texel takes one from a face that has several.
    pub conservative: bool,
    /// Texels by which charts are dilated afterwards.
    pub gutter: u32,
    /// Threads; above 1 work goes to the current rayon pool (feature `rayon`).
    pub threads: usize,
}

impl Atlas {
    /// Rasterizes a mesh in texture space.
    ///
    /// # Errors
    /// [`RasterError::IndexOutOfRange`], [`RasterError::AttributeLength`] when positions or normals do not match the uvs, and
    /// [`RasterError::TooManyTriangles`].
    pub fn new(
        size: TargetSize,
        mesh: &AtlasMesh<'_>,
        options: AtlasOptions,
    ) -> Result<Self, RasterError> {
        for array in [mesh.positions, mesh.normals] {
            if !array.is_empty() && array.len() != mesh.uvs.len() {
                return Err(RasterError::AttributeLength {
                    draw: 0,
                    expected: mesh.uvs.len(),
                    found: array.len(),
                });
            }
        }
        let flat: Vec<_> = mesh.uvs.iter().map(|uv| [uv[0], uv[1], 0.5]).collect();
        // 0..1 to clip space, y up: v from the bottom already points up.
        let up = if mesh.bottom_up { 1.0 } else { -1.0 };
        let draw = Draw {
            positions: &flat,
            indices: mesh.indices,
            clip_from_object: DMat4::from_translation(DVec3::new(-1.0, -up, 0.0))
                * DMat4::from_scale(DVec3::new(2.0, 2.0 * up, 1.0)),
            ..Draw::default()
        };
        let prepared = Prepared::with_level(
            size,
            &[draw],
            crate::prepared::best_level(),
            options.threads,
        )?;
        let texels = size.width() as usize * size.height() as usize;
        let mut atlas = Self {
            size,
            coverage: alloc::vec![Coverage::None; texels],
            face: alloc::vec![NONE; texels],
            barycentric: alloc::vec![[0.0; 3]; texels],
            position: Vec::new(),
            normal: Vec::new(),
            lost: Vec::new(),
        };
        let mut owned = alloc::vec![0u32; mesh.indices.len()];
        atlas.cover_centres(&prepared, &mut owned);
        let corners = Corners { mesh, size };
        if options.conservative {
            atlas.cover_touched(&corners, &mut owned);
        }
        atlas.lost = (0..owned.len() as u32)
            .filter(|&f| owned[f as usize] == 0)
            .collect();
        atlas.interpolate(&corners);
        for _ in 0..options.gutter {
            if !atlas.dilate() {
                break;
            }
        }
        Ok(atlas)
    }

    fn place(&self, x: i32, y: i32) -> usize {
        y as usize * self.size.width() as usize + x as usize
    }

    fn cover_centres(&mut self, prepared: &Prepared<'_>, owned: &mut [u32]) {
        let mut buffers = TileBuffers::new();
        for index in 0..prepared.tiles() {
            let tile = prepared.tile(index);
            prepared.visible(index, &NoAlphaTest, &mut buffers);
            for y in 0..tile.height {
                for x in 0..tile.width {
                    let id = buffers.id[(y * TILE + x) as usize];
                    if id != NONE {
                        let (_, face) = prepared.source(id);
                        let at = self.place((tile.x0 + x) as i32, (tile.y0 + y) as i32);
                        self.face[at] = face;
                        self.coverage[at] = Coverage::Centre;
                        owned[face as usize] += 1;
                    }
                }
            }
        }
    }

    /// Free texels that faces touch; then one texel for each face that has none.
    fn cover_touched(&mut self, corners: &Corners<'_, '_>, owned: &mut [u32]) {
        for face in 0..owned.len() as u32 {
            corners.touched(face, |x, y| {
                let at = self.place(x, y);
                if self.face[at] == NONE {
                    self.take(at, face, owned);
                }
                false
            });
        }
        for face in 0..owned.len() as u32 {
            if owned[face as usize] > 0 {
                continue;
            }
            corners.touched(face, |x, y| {
                let at = self.place(x, y);
                let holder = self.face[at];
                let spare = holder == NONE || owned[holder as usize] > 1;
                if spare {
                    if holder != NONE {
                        owned[holder as usize] -= 1;
                    }
                    self.take(at, face, owned);
                }
                spare
            });
        }
    }

    fn take(&mut self, at: usize, face: u32, owned: &mut [u32]) {
        self.face[at] = face;
        self.coverage[at] = Coverage::Touched;
        owned[face as usize] += 1;
    }

    fn interpolate(&mut self, corners: &Corners<'_, '_>) {
        let mesh = corners.mesh;
        let texels = self.face.len();
        let room = |array: &[[f32; 3]]| {
            if array.is_empty() {
                Vec::new()
            } else {
                alloc::vec![[0.0; 3]; texels]
            }
        };
        (self.position, self.normal) = (room(mesh.positions), room(mesh.normals));
        let width = self.size.width() as usize;
        for at in 0..texels {
            let face = self.face[at];
            if face == NONE {
                continue;
            }
            let weights =
                corners.weights(face, (at % width) as f64 + 0.5, (at / width) as f64 + 0.5);
            self.barycentric[at] = weights.map(|w| w as f32);
            let vertices = mesh.indices[face as usize];
            if let Some(position) = self.position.get_mut(at) {
                *position = blend(mesh.positions, vertices, weights).map(|v| v as f32);
            }
            if let Some(normal) = self.normal.get_mut(at) {
                let n = blend(mesh.normals, vertices, weights);
                let length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
                *normal = if length > 0.0 {
                    n.map(|v| (v / length) as f32)
                } else {
                    [0.0; 3]
                };
            }
        }
    }

    /// Gives each free texel the values of a neighbour; false when there was nothing to do.
    fn dilate(&mut self) -> bool {
        let (width, height) = (self.size.width() as i32, self.size.height() as i32);
        // Sides before corners, so that the nearer neighbour wins.
        const AROUND: [(i32, i32); 8] = [
            (-1, 0),
            (1, 0),
            (0, -1),
            (0, 1),
            (-1, -1),
            (1, -1),
            (-1, 1),
            (1, 1),
        ];
        let mut copies = Vec::new();
        for y in 0..height {
            for x in 0..width {
                if self.face[self.place(x, y)] != NONE {
                    continue;
                }
                let inside = |&&(dx, dy): &&(i32, i32)| {
                    (0..width).contains(&(x + dx)) && (0..height).contains(&(y + dy))
                };
                let from = AROUND
                    .iter()
                    .filter(inside)
                    .map(|(dx, dy)| self.place(x + dx, y + dy));
                if let Some(from) = from.into_iter().find(|&from| self.face[from] != NONE) {
                    copies.push((self.place(x, y), from));
                }
            }
        }
        for &(to, from) in &copies {
            self.face[to] = self.face[from];
            self.coverage[to] = Coverage::Gutter;
            self.barycentric[to] = self.barycentric[from];
            if !self.position.is_empty() {
                self.position[to] = self.position[from];
            }
            if !self.normal.is_empty() {
                self.normal[to] = self.normal[from];
            }
        }
        !copies.is_empty()
    }
}

fn blend(values: &[[f32; 3]], vertices: [u32; 3], weights: [f64; 3]) -> [f64; 3] {
    let v = vertices.map(|i| values[i as usize].map(f64::from));
    [0, 1, 2].map(|k| v[0][k] * weights[0] + v[1][k] * weights[1] + v[2][k] * weights[2])
}

/// Faces in texels.
struct Corners<'m, 'a> {
    mesh: &'m AtlasMesh<'a>,
    size: TargetSize,
}

impl Corners<'_, '_> {
    /// Texel positions, y down.
    fn of(&self, face: u32) -> [[f64; 2]; 3] {
        let (width, height) = (f64::from(self.size.width()), f64::from(self.size.height()));
        self.mesh.indices[face as usize].map(|i| {
            let [u, v] = self.mesh.uvs[i as usize].map(f64::from);
            [
                u * width,
                if self.mesh.bottom_up {
                    height - v * height
                } else {
                    v * height
                },
            ]
        })
    }

    /// Weights over the vertices at a texel position, pulled into the face.
    fn weights(&self, face: u32, x: f64, y: f64) -> [f64; 3] {
        let p = self.of(face).map(|p| [p[0] - x, p[1] - y]);
        let cross = |a: [f64; 2], b: [f64; 2]| a[0] * b[1] - a[1] * b[0];
        let b = [cross(p[1], p[2]), cross(p[2], p[0]), cross(p[0], p[1])];
        let area = b[0] + b[1] + b[2];
        if area == 0.0 || !area.is_finite() {
            return [1.0 / 3.0; 3];
        }
        let inside = b.map(|v| if v / area > 0.0 { v / area } else { 0.0 });
        let sum = inside[0] + inside[1] + inside[2];
        if sum > 0.0 {
            inside.map(|v| v / sum)
        } else {
            [1.0 / 3.0; 3]
        }
    }

    /// Visits the texels that a face touches until `visit` says stop; for a face without area those of its box's middle.
    fn touched(&self, face: u32, mut visit: impl FnMut(i32, i32) -> bool) {
        let corners = self.of(face);
        // Far outside nothing is touched, and i32 could not hold it.
        if !corners.iter().flatten().all(|v| v.abs() < 16_384.0 * 2.0) {
            return;
        }
        let snapped: [Snapped; 3] =
            corners.map(|p| p.map(|v| texmap_math::float::round_half_up(v * ONE as f64) as i32));
        let (width, height) = (self.size.width() as i32, self.size.height() as i32);
        let range = |k: usize, side: i32| {
            let lo = snapped[0][k].min(snapped[1][k]).min(snapped[2][k]);
            let hi = snapped[0][k].max(snapped[1][k]).max(snapped[2][k]);
            // A side that ends on a texel's border does not touch the next one.
            let last = if hi > lo { (hi - 1) >> 8 } else { hi >> 8 };
            (lo >> 8).max(0)..=last.min(side - 1)
        };
        let (xs, ys) = (range(0, width), range(1, height));
        if xs.is_empty() || ys.is_empty() {
            return;
        }
        let Some(edges) = edges(&snapped) else {
            let middle = |r: &core::ops::RangeInclusive<i32>| (r.start() + r.end()) / 2;
            visit(middle(&xs), middle(&ys));
            return;
        };
        let b = PixelBox {
            x0: *xs.start(),
            y0: *ys.start(),
            x1: *xs.end(),
            y1: *ys.end(),
        };
        for y in b.y0..=b.y1 {
            for x in b.x0..=b.x1 {
                if edges.iter().all(|e| touches(*e, x, y)) && visit(x, y) {
                    return;
                }
            }
        }
    }
}

/// Whether the open inner side of an edge meets the texel's square.
fn touches(edge: Edge, x: i32, y: i32) -> bool {
    let half = ONE / 2;
    edge.a * centre(x) + edge.b * centre(y) + edge.c + half * (edge.a.abs() + edge.b.abs()) > 0
}

//! The UV-space target: the same coverage over a texture atlas, for bakes and transfers.

mod taken;
mod texels;

use alloc::vec::Vec;

use texmap_math::MemoryBudget;
use texmap_math::glam::{DMat4, DVec3};
use texmap_math::progress::{Progress, Steps, no_progress};

use crate::front_end::prepared::for_all;
use crate::{
    BinnedDraws, DrawCall, NO_PRIMITIVE, NoAlphaTest, RasterError, TILE, TargetSize,
    VisibilityBuffer,
};

use taken::{Taken, Visited};
use texels::{Corners, Values};

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
    /// True if v counts from the bottom row (OBJ) and not from the top (glTF).
    pub bottom_up: bool,
}

/// Relation of a texel to its face.
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
    /// Relation of each texel to its face.
    pub coverage: Vec<Coverage>,
    /// The face, [`NO_PRIMITIVE`] where there is none. Of overlapping faces the first one wins.
    pub face: Vec<u32>,
    /// Weights over the face's three vertices at the texel's centre. If the centre lies outside, it is moved to the face; 0
    /// if there is no face.
    pub barycentric: Vec<[f32; 3]>,
    /// Interpolated positions; empty when the mesh has none.
    pub position: Vec<[f32; 3]>,
    /// Interpolated normals of unit length (0 where they cancel); empty when the mesh has none.
    pub normal: Vec<[f32; 3]>,
    /// Faces that own no texel, ascending: outside the atlas, not finite, or hidden by others; without `conservative` also
    /// those that cover no texel centre.
    pub lost: Vec<u32>,
}

/// Options of an atlas.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct AtlasOptions {
    /// Also texels that a face touches without covering their centre: no face that touches the atlas is lost, however small,
    /// as long as there are texels enough where it lies and its corners are less than 32,768 texels from the atlas. A face without a
    /// texel takes one from a face that has several.
    pub conservative: bool,
    /// Texels by which islands are dilated afterwards.
    pub gutter: u32,
    /// Threads; above 1 work goes to the current rayon pool (feature `rayon`).
    pub threads: usize,
    /// Asked for the arrays before they are allocated.
    pub memory: MemoryBudget,
}

/// Threads that work on bands, and a count of the bands that are done.
#[derive(Clone, Copy)]
struct Bands<'a> {
    threads: usize,
    steps: &'a Steps<'a>,
}

impl Bands<'_> {
    fn for_all<T: Send>(self, bands: Vec<T>, fill: impl Fn(T) + Sync) {
        for_all(self.threads, bands, |band| {
            if !self.steps.is_cancelled() {
                fill(band);
                self.steps.step();
            }
        });
    }
}

/// Bytes of all arrays of an atlas per texel.
fn texel_bytes(mesh: &AtlasMesh<'_>, options: &AtlasOptions) -> u64 {
    let triple = size_of::<[f32; 3]>();
    let triples =
        1 + usize::from(!mesh.positions.is_empty()) + usize::from(!mesh.normals.is_empty());
    let taken = usize::from(options.conservative) * size_of::<u32>();
    (size_of::<Coverage>() + size_of::<u32>() + taken + triples * triple) as u64
}

impl Atlas {
    /// Rasterizes a mesh in texture space.
    ///
    /// # Errors
    /// [`RasterError::IndexOutOfRange`], [`RasterError::AttributeLength`] when positions or normals do not match the uvs,
    /// [`RasterError::TooManyTriangles`], and [`RasterError::Memory`] for arrays beyond [`AtlasOptions::memory`].
    pub fn new(
        size: TargetSize,
        mesh: &AtlasMesh<'_>,
        options: AtlasOptions,
    ) -> Result<Self, RasterError> {
        Self::with_progress(size, mesh, options, &no_progress)
    }

    /// [`new`](Self::new) with a callback that hears of each row of tiles of each stage, or as many parts of it, and each texel of the gutter, and may end the work.
    ///
    /// # Errors
    /// Those of [`new`](Self::new); [`RasterError::Cancelled`] after a break.
    pub fn with_progress(
        size: TargetSize,
        mesh: &AtlasMesh<'_>,
        options: AtlasOptions,
        progress: Progress<'_>,
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
        let texels = size.width() as usize * size.height() as usize;
        let bytes = texels as u64 * texel_bytes(mesh, &options);
        options.memory.ask(
            bytes,
            format_args!("an atlas of {} x {} texels", size.width(), size.height()),
            "take a smaller atlas",
        )?;
        let flat: Vec<_> = mesh.uvs.iter().map(|uv| [uv[0], uv[1], 0.5]).collect();
        // 0..1 to clip space, y up: v from the bottom already points up.
        let up = if mesh.bottom_up { 1.0 } else { -1.0 };
        let draw = DrawCall {
            positions: &flat,
            indices: mesh.indices,
            clip_from_object: DMat4::from_translation(DVec3::new(-1.0, -up, 0.0))
                * DMat4::from_scale(DVec3::new(2.0, 2.0 * up, 1.0)),
            ..DrawCall::default()
        };
        let prepared = BinnedDraws::with_level(
            size,
            &[draw],
            crate::front_end::prepared::best_level(),
            options.threads,
        )?;
        let mut atlas = Self {
            size,
            coverage: alloc::vec![Coverage::None; texels],
            face: alloc::vec![NO_PRIMITIVE; texels],
            barycentric: alloc::vec![[0.0; 3]; texels],
            position: Vec::new(),
            normal: Vec::new(),
            lost: Vec::new(),
        };
        let corners = Corners { mesh, size };
        let stages = 2 + 2 * usize::from(options.conservative);
        let bands = size.height().div_ceil(TILE) as usize;
        // Further rounds would find no free texel.
        let gutter = options.gutter.min(size.width().max(size.height()));
        let steps = Steps::new(progress, stages * bands + gutter as usize);
        let work = Bands {
            threads: options.threads,
            steps: &steps,
        };
        atlas.cover_centres(&prepared, work);
        if options.conservative {
            atlas.cover_touched(&corners, work);
        }
        if steps.is_cancelled() {
            return Err(RasterError::Cancelled);
        }
        let mut owned = atlas.owned(mesh.indices.len());
        if options.conservative {
            atlas.rescue(&corners, &mut owned, work);
        }
        atlas.lost = (0..owned.len() as u32)
            .filter(|&f| owned[f as usize] == 0)
            .collect();
        atlas.interpolate(&corners, work);
        atlas.dilate(gutter, work);
        match steps.is_cancelled() {
            true => Err(RasterError::Cancelled),
            false => Ok(atlas),
        }
    }

    /// Texels of a band: of all tiles of one row.
    fn band(&self) -> usize {
        self.size.width() as usize * TILE as usize
    }

    fn cover_centres(&mut self, prepared: &BinnedDraws<'_>, work: Bands<'_>) {
        let (width, band) = (self.size.width() as usize, self.band());
        let across = self.size.width().div_ceil(TILE) as usize;
        let faces = self.face.chunks_mut(band);
        let bands = faces.zip(self.coverage.chunks_mut(band)).enumerate();
        work.for_all(bands.collect(), |(row, (faces, coverage))| {
            let mut buffers = VisibilityBuffer::new();
            for index in row * across..(row + 1) * across {
                let tile = prepared.tile(index);
                prepared.visible(index, &NoAlphaTest, &mut buffers);
                for y in 0..tile.height as usize {
                    let ids = &buffers.id[y * TILE as usize..][..tile.width as usize];
                    let at = y * width + tile.x0 as usize;
                    for (x, &id) in ids
                        .iter()
                        .enumerate()
                        .filter(|(_, id)| **id != NO_PRIMITIVE)
                    {
                        faces[at + x] = prepared.source(id).1;
                        coverage[at + x] = Coverage::Centre;
                    }
                }
            }
        });
    }

    /// Gives each free texel to the first face that touches it.
    fn cover_touched(&mut self, corners: &Corners<'_, '_>, work: Bands<'_>) {
        let (width, band) = (self.size.width() as usize, self.band());
        let reaches = corners.by_band();
        let faces = self.face.chunks_mut(band);
        let bands = faces.zip(self.coverage.chunks_mut(band)).enumerate();
        work.for_all(bands.collect(), |(row, (faces, coverage))| {
            let top = row as i32 * TILE as i32;
            let mut taken = Taken::new(width, faces.len() / width);
            for &face in &reaches[row] {
                let Some(reach) = corners.reach(face) else {
                    continue;
                };
                for y in reach.y.start.max(top)..reach.y.end.min(top + TILE as i32) {
                    taken.visit((y - top) as usize, &reach.row(y), |at| {
                        if faces[at] == NO_PRIMITIVE {
                            faces[at] = face;
                            coverage[at] = Coverage::Touched;
                        }
                        Visited::Taken
                    });
                }
            }
        });
    }

    /// Texels of each face.
    fn owned(&self, faces: usize) -> Vec<u32> {
        let mut owned = alloc::vec![0u32; faces];
        for &face in self.face.iter().filter(|f| **f != NO_PRIMITIVE) {
            owned[face as usize] += 1;
        }
        owned
    }

    /// Gives each face without a texel one that it touches, of a face that has several.
    fn rescue(&mut self, corners: &Corners<'_, '_>, owned: &mut [u32], work: Bands<'_>) {
        let (width, height) = (self.size.width() as usize, self.size.height() as usize);
        let parts = height.div_ceil(TILE as usize);
        let mut taken = None;
        for part in 0..parts {
            if work.steps.is_cancelled() {
                return;
            }
            for face in part * owned.len() / parts..(part + 1) * owned.len() / parts {
                if owned[face] > 0 {
                    continue;
                }
                let Some(reach) = corners.reach(face as u32) else {
                    continue;
                };
                let taken = taken.get_or_insert_with(|| Taken::new(width, height));
                let mut spare = None;
                for y in reach.y.clone() {
                    // The only texel of a face is never spare again.
                    taken.visit(y as usize, &reach.row(y), |at| {
                        let holder = self.face[at];
                        match holder == NO_PRIMITIVE || owned[holder as usize] > 1 {
                            true => {
                                spare = Some(at);
                                Visited::Last
                            }
                            false => Visited::Taken,
                        }
                    });
                    if spare.is_some() {
                        break;
                    }
                }
                if let Some(at) = spare {
                    if self.face[at] != NO_PRIMITIVE {
                        owned[self.face[at] as usize] -= 1;
                    }
                    self.face[at] = face as u32;
                    self.coverage[at] = Coverage::Touched;
                    owned[face] += 1;
                }
            }
            work.steps.step();
        }
    }

    fn interpolate(&mut self, corners: &Corners<'_, '_>, work: Bands<'_>) {
        let (mesh, texels) = (corners.mesh, self.face.len());
        let buffer = |array: &[[f32; 3]]| match array.is_empty() {
            true => Vec::new(),
            false => alloc::vec![[0.0; 3]; texels],
        };
        (self.position, self.normal) = (buffer(mesh.positions), buffer(mesh.normals));
        let (width, band) = (self.size.width() as usize, self.band());
        // Absent arrays have empty bands.
        let mut positions = self.position.chunks_mut(band);
        let mut normals = self.normal.chunks_mut(band);
        let bands = self
            .face
            .chunks(band)
            .zip(self.barycentric.chunks_mut(band));
        let bands = bands.enumerate().map(|(row, (faces, barycentric))| Values {
            top: row * TILE as usize,
            faces,
            barycentric,
            positions: positions.next().unwrap_or_default(),
            normals: normals.next().unwrap_or_default(),
        });
        work.for_all(bands.collect(), |band| band.fill(corners, width));
    }

    /// Dilates charts: each free texel beside a taken one gets the values of a neighbour, `gutter` times.
    fn dilate(&mut self, gutter: u32, work: Bands<'_>) {
        let band = self.band();
        // Later rounds can only reach what lies beside a texel of the round before.
        let mut candidates: Option<Vec<usize>> = None;
        for _ in 0..gutter {
            if work.steps.is_cancelled() {
                return;
            }
            let copies = match candidates {
                None => {
                    let mut found: Vec<Vec<(usize, usize)>> =
                        alloc::vec![Vec::new(); self.face.len().div_ceil(band)];
                    let this = &*self;
                    for_all(
                        work.threads,
                        found.iter_mut().enumerate().collect(),
                        |(k, out)| {
                            let texels = k * band..((k + 1) * band).min(this.face.len());
                            out.extend(texels.filter_map(|to| Some((to, this.neighbour(to)?))));
                        },
                    );
                    found.concat()
                }
                Some(list) => list
                    .into_iter()
                    .filter_map(|to| Some((to, self.neighbour(to)?)))
                    .collect(),
            };
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
            let mut beside: Vec<usize> = copies.iter().flat_map(|c| self.around(c.0)).collect();
            beside.sort_unstable();
            beside.dedup();
            candidates = Some(beside);
            work.steps.step();
        }
    }

    /// For a free texel a taken one beside it.
    fn neighbour(&self, to: usize) -> Option<usize> {
        if self.face[to] != NO_PRIMITIVE {
            return None;
        }
        self.around(to)
            .find(|&from| self.face[from] != NO_PRIMITIVE)
    }

    /// The texels around one; sides before corners, so that the nearer neighbour wins.
    fn around(&self, at: usize) -> impl Iterator<Item = usize> + use<> {
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
        let (width, height) = (self.size.width() as i32, self.size.height() as i32);
        let (x, y) = (at as i32 % width, at as i32 / width);
        AROUND
            .into_iter()
            .map(move |(dx, dy)| (x + dx, y + dy))
            .filter(move |(x, y)| (0..width).contains(x) && (0..height).contains(y))
            .map(move |(x, y)| y as usize * width as usize + x as usize)
    }
}

//! A surface, batch by batch: vectors and texels that several stages read, then the stages.

use texmap_math::Level;
use texmap_raster::{AttributePlanes, Varyings};

use crate::batch::{Batch, Colors};
use crate::coordinates::{Coordinates, UvScratch};
use crate::facing::{FacingStage, Sides};
use crate::fetch::PackedTexels;
use crate::projector::{ProjectorStage, ProjectorTexels};
use crate::stage::{Inputs, ShadeColumns, Stage};
use crate::texture_set::{SetScratch, TextureSet};
use crate::vectors::{VectorReader, VectorScratch};

/// The stages of one surface.
pub struct SurfaceShader<'a> {
    /// SIMD level of the kernels.
    pub level: Level,
    /// Coordinates of the textures, where a stage reads some by them.
    pub uv: Option<&'a Coordinates>,
    /// First attribute of the second set of coordinates, where a stage reads some by them.
    pub second_uv: Option<usize>,
    /// Textures that are read at the coordinates of the vertices, before the stages.
    pub textures: TextureSet<'a>,
    /// Vectors that several stages read.
    pub vectors: VectorReader,
    /// The facing stage, if lights are computed per pixel.
    pub facing: Option<FacingStage<'a>>,
    /// The projectors of the lights, then those that paint.
    pub projectors: Vec<ProjectorStage<'a>>,
    /// The stages in their order; the last leaves the final colors.
    pub stages: Vec<Box<dyn Stage + 'a>>,
    /// The attributes that the stages read; `None` if a few columns of vectors suffice, which the surface reads itself.
    pub attributes: Option<usize>,
}

/// Columns of a batch; a thread keeps them.
#[derive(Default)]
pub struct SurfaceScratch {
    vectors: VectorScratch,
    /// Coordinates that are no attributes.
    uv: Varyings,
    second_uv: Varyings,
    coordinates: UvScratch,
    set: SetScratch,
    set_texels: Vec<PackedTexels>,
    projectors: Vec<ProjectorTexels>,
    sides: Sides,
    columns: ShadeColumns,
}

impl SurfaceShader<'_> {
    /// Shades a batch: linear light (raw values in raw mode), premultiplied.
    pub fn shade<'s>(
        &self,
        planes: &AttributePlanes,
        batch: &Batch<'_>,
        scratch: &'s mut SurfaceScratch,
    ) -> &'s Colors {
        let SurfaceScratch {
            vectors,
            uv,
            second_uv,
            coordinates,
            set,
            set_texels,
            projectors,
            sides,
            columns,
        } = scratch;
        let level = self.level;
        self.textures
            .fetch(level, planes, batch.blocks, batch.list, set, set_texels);
        let uv = match self.uv {
            Some(from) => from.columns(level, batch, coordinates, uv),
            None => batch.values,
        };
        if let Some(first) = self.second_uv {
            let wanted = [first, first + 1];
            planes.values(level, batch.blocks, batch.list, &wanted, true, second_uv);
        }
        let (of, texels) = (&self.projectors, &mut *projectors);
        let (vectors, reached) = self.vectors.read(level, planes, batch, of, vectors, texels);
        if let Some(facing) = &self.facing {
            facing.see(batch, sides);
        }
        let inputs = Inputs {
            level,
            planes,
            batch,
            uv,
            second_uv,
            vectors,
            reached,
            sides,
            textures: set_texels,
            projectors,
        };
        for stage in &self.stages {
            stage.run(&inputs, columns);
        }
        &columns.color
    }
}

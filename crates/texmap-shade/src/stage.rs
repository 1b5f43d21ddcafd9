//! A stage of a surface: its inputs, and the columns that it shares with the others.

use texmap_math::simd::Isa;
use texmap_math::{Level, dispatch_simd};
use texmap_raster::{AttributePlanes, FragmentBlock, Varyings};

use crate::Slot;
use crate::base_color::BaseTexels;
use crate::batch::{Batch, Colors, Columns};
use crate::facing::Sides;
use crate::fetch::{PackedTexels, Texels};
use crate::projector::ProjectorTexels;
use crate::slopes::Slopes;
use crate::vectors::Vectors;
use texmap_scene::UvSet;

/// A step of shading a batch, from inputs and columns to columns.
pub trait Stage: Sync {
    /// Reads inputs and columns, writes columns.
    fn run(&self, inputs: &Inputs<'_>, columns: &mut ShadeColumns);
}

/// A stage that is a kernel over lanes.
pub(crate) trait Kernel: Sync {
    /// Reads textures, before the kernel runs.
    fn read(&self, _: &Inputs<'_>, _: &mut ShadeColumns) {}

    /// The kernel; `#[inline(always)]`.
    fn lanes<I: Isa>(&self, i: I, inputs: &Inputs<'_>, columns: &mut ShadeColumns);
}

impl<K: Kernel> Stage for K {
    fn run(&self, inputs: &Inputs<'_>, columns: &mut ShadeColumns) {
        self.read(inputs, columns);
        dispatch_simd!(inputs.level, i => self.lanes(i, inputs, columns));
    }
}

/// Inputs of the stages, read before they run.
pub struct Inputs<'a> {
    pub(crate) level: Level,
    pub(crate) planes: &'a AttributePlanes,
    pub(crate) batch: &'a Batch<'a>,
    /// Coordinates as columns 0 and 1, where a stage reads a texture by them.
    pub(crate) uv: &'a Varyings,
    /// Coordinates of the second set.
    pub(crate) second_uv: &'a Varyings,
    pub(crate) vectors: Vectors<'a>,
    /// The blocks of the batch, without the pixels of those whose normals nothing asks for.
    pub(crate) reached: &'a [FragmentBlock],
    pub(crate) sides: &'a Sides,
    /// Texels of the [`TextureSet`](crate::texture_set::TextureSet) of the surface, by their numbers.
    pub(crate) textures: &'a [PackedTexels],
    /// Texels of the projectors of the lights, then of those that paint.
    pub projectors: &'a [ProjectorTexels],
}

impl Inputs<'_> {
    /// The coordinates that a texture is read at.
    pub(crate) fn uv_of(&self, slot: &Slot<'_>) -> &Varyings {
        match slot.uv_set {
            UvSet::First => self.uv,
            UvSet::Second => self.second_uv,
        }
    }
}

/// The columns between stages. A thread keeps them: those that no stage of a surface writes hold no meaning.
#[derive(Default)]
pub struct ShadeColumns {
    /// Unit directions to the eye.
    pub(crate) toward_eye: Columns<3>,
    /// Unit normals on the side that is seen.
    pub(crate) normal: Columns<3>,
    /// Light that multiplies the base color.
    pub(crate) diffuse: Columns<3>,
    /// Light in its own color.
    pub(crate) highlight: Columns<3>,
    /// Fraction of the light from behind that passes.
    pub(crate) transmitted: Columns<1>,
    /// Straight base colors and alpha; premultiplied final colors after the last stage.
    pub(crate) color: Colors,
    /// Texels and coordinates of the stage that runs; the next one reads its own.
    pub(crate) texels: Texels,
    pub(crate) uv: Varyings,
    pub(crate) base: BaseTexels,
    pub(crate) slopes: Slopes,
    /// Texels of the maps of a metallic-roughness model.
    pub(crate) metallic: Vec<Texels>,
}

impl ShadeColumns {
    /// Reads a texture at the coordinates of the batch.
    pub(crate) fn fetch(&mut self, inputs: &Inputs<'_>, slot: &Slot<'_>) {
        let blocks = inputs.batch.list.len();
        self.texels
            .fetch(inputs.level, slot, inputs.uv_of(slot), blocks);
    }
}

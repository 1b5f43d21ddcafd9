//! The stages of a surface, run batch by batch: coordinates, texture fetches, then per part normals, light and color.

use texmap_math::simd::{Isa, prelude::*};
use texmap_math::{Level, dispatch_simd};
use texmap_raster::{AttributePlanes, FragmentBlock, Varying, Varyings};

use super::base_color::{BaseColor, BaseTexels};
use super::batch::{Batch, Colors, LANES, Part, columns};
use super::compose::Inputs;
use super::coordinates::{Coordinates, UvScratch};
use super::environment::Reflections;
use super::facing::{FacingStage, Side};
use super::fetch::{PackedTexels, PairScratch, Texels, TexturePair};
use super::lighting::{LightStage, LightTexels, Lighting};
use super::normal::{NormalStage, NormalTexels, Vectors};
use super::projector::ProjectorTexels;
use crate::textures::Slot;

/// The stages of one surface.
pub(crate) struct SurfaceShader<'a> {
    pub(crate) level: Level,
    pub(crate) uv: &'a Coordinates,
    pub(crate) base: BaseColor<'a>,
    /// The base color is a decal that covers the lit surface.
    pub(crate) covers: bool,
    pub(crate) light: LightStage,
    /// Diffuse light is looked up along this by its luminance.
    pub(crate) light_ramp: Option<&'a Slot<'a>>,
    /// Emitted light and its map.
    pub(crate) emission: Option<([f32; 3], Option<&'a Slot<'a>>)>,
    pub(crate) normal: NormalStage<'a>,
    pub(crate) facing: FacingStage<'a>,
    pub(crate) lighting: Lighting<'a>,
    pub(crate) reflections: Reflections<'a>,
    pub(crate) pair: TexturePair<'a>,
    /// First attributes of normals and positions.
    pub(crate) normal_attribute: Option<usize>,
    pub(crate) position_attribute: Option<usize>,
    /// The attributes that the stages read; `None` if a few columns of vectors suffice, which the stage reads itself.
    pub(crate) attributes: Option<usize>,
}

/// The texels that a batch has read.
#[derive(Default)]
pub(crate) struct SurfaceTexels {
    /// Base color and normal map.
    pub(crate) pair: [PackedTexels; 2],
    pub(crate) base: BaseTexels,
    pub(crate) normal: NormalTexels,
    pub(crate) light: LightTexels,
    pub(crate) emission: Texels,
}

/// Columns between the stages; a thread keeps them.
#[derive(Default)]
pub(crate) struct SurfaceScratch {
    /// Vectors of a surface that reads no other attributes, and normals that are read after them.
    vectors: [Varyings; 2],
    columns: ColumnScratch,
    read: SurfaceTexels,
}

/// Columns that texture fetches are made from.
#[derive(Default)]
struct ColumnScratch {
    /// Coordinates of the mesh, where they are no attributes.
    uv: Varyings,
    /// Coordinates of the light map.
    light_map_uv: Varyings,
    coordinates: UvScratch,
    pair: PairScratch,
    /// The batch, without the pixels of blocks that no projector reaches.
    reached: Vec<FragmentBlock>,
}

impl SurfaceShader<'_> {
    /// Shades a batch: linear light (raw values in raw mode), premultiplied.
    pub(crate) fn shade(
        &self,
        planes: &AttributePlanes,
        batch: &Batch<'_>,
        scratch: &mut SurfaceScratch,
        out: &mut Colors,
    ) {
        let SurfaceScratch {
            vectors,
            columns,
            read,
        } = scratch;
        let vectors = self.fetch(planes, batch, columns, vectors, read);
        let inputs = Inputs {
            shader: self,
            batch,
            vectors,
            read,
        };
        dispatch_simd!(self.level, i => shade_blocks(i, &inputs, out));
    }

    /// Reads vectors and texels.
    fn fetch<'b>(
        &self,
        planes: &AttributePlanes,
        batch: &Batch<'b>,
        scratch: &mut ColumnScratch,
        [vectors, normals]: &'b mut [Varyings; 2],
        read: &mut SurfaceTexels,
    ) -> Vectors<'b> {
        let (level, list, blocks) = (self.level, batch.list, batch.list.len());
        let ColumnScratch {
            uv,
            light_map_uv,
            coordinates,
            pair,
            reached,
        } = scratch;
        if let Some((_, slot, first)) = self.lighting.light_map {
            let (wanted, derivatives) = ([first, first + 1], slot.reads_derivatives());
            planes.values(
                level,
                batch.blocks,
                list,
                &wanted,
                derivatives,
                light_map_uv,
            );
            let texels = &mut read.light.light_map;
            texels.fetch(level, slot, light_map_uv, blocks);
        }
        self.pair
            .fetch(level, planes, batch.blocks, list, pair, &mut read.pair);
        let uv = if self.reads_uv() {
            self.uv.columns(level, batch, coordinates, uv)
        } else {
            batch.values
        };
        if !self.base.paired {
            self.base.fetch(level, batch, uv, &mut read.base);
        }
        if self.reads_uv() {
            self.normal.fetch(level, uv, blocks, &mut read.normal);
            for (slot, out) in self.lighting.maps.iter().zip(&mut read.light.maps) {
                if let Some(slot) = slot {
                    out.fetch(level, slot, uv, blocks);
                }
            }
            if let Some((_, Some(slot))) = self.emission {
                read.emission.fetch(level, slot, uv, blocks);
            }
        }
        let projectors = &mut read.light.projectors;
        projectors.resize_with(self.lighting.projectors().count(), ProjectorTexels::default);
        if self.attributes.is_some() {
            let of = |first| columns(batch.values, first);
            let position = self.position_attribute.map(of);
            self.fetch_projectors(position, blocks, projectors);
            return Vectors {
                normal: of(self.normal_attribute.unwrap_or(0)),
                position,
                tangent: columns(batch.values, self.normal.tangent().unwrap_or(0)),
            };
        }
        // Normals are late where few blocks may ask for them.
        let late = !self.lighting.needs_normal && self.normal.detail.is_none();
        let leveled = self
            .lighting
            .projectors()
            .any(|stage| stage.projected.reads_derivatives());
        let n = self.normal_attribute.unwrap_or(0);
        let normal = [n, n + 1, n + 2];
        let values = |list, wanted: &[usize], derivatives, out: &mut Varyings| {
            planes.values(level, batch.blocks, list, wanted, derivatives, out);
        };
        match self.position_attribute {
            None => {
                values(list, &normal, !self.reflections.is_empty(), vectors);
                self.fetch_projectors(None, blocks, projectors);
                Vectors {
                    normal: columns(vectors, 0),
                    position: None,
                    tangent: columns(vectors, 0),
                }
            }
            Some(p) if late => {
                values(list, &[p, p + 1, p + 2], leveled, vectors);
                self.fetch_projectors(Some(columns(vectors, 0)), blocks, projectors);
                reached.clear();
                reached.extend_from_slice(list);
                for (block, at) in reached.iter_mut().enumerate() {
                    if !projectors.iter().any(|texels| texels.reaches(block)) {
                        at.mask = 0;
                    }
                }
                values(reached, &normal, false, normals);
                Vectors {
                    normal: columns(normals, 0),
                    position: Some(columns(vectors, 0)),
                    tangent: columns(vectors, 0),
                }
            }
            Some(p) => {
                let t = self.normal.tangent();
                let at = t.unwrap_or(0);
                let all = [n, n + 1, n + 2, p, p + 1, p + 2, at, at + 1, at + 2, at + 3];
                let wanted = &all[..if t.is_some() { 10 } else { 6 }];
                let derivatives = leveled || !self.reflections.is_empty();
                values(list, wanted, derivatives, vectors);
                let position = Some(columns(vectors, 3));
                self.fetch_projectors(position, blocks, projectors);
                Vectors {
                    normal: columns(vectors, 0),
                    position,
                    tangent: columns(vectors, 6),
                }
            }
        }
    }

    /// True if some stage reads columns of coordinates.
    fn reads_uv(&self) -> bool {
        self.base.reads_uv()
            || self.normal.reads_uv()
            || self.lighting.maps.iter().any(Option::is_some)
            || matches!(self.emission, Some((_, Some(_))))
    }

    fn fetch_projectors(
        &self,
        position: Option<&[Varying; 3]>,
        blocks: usize,
        out: &mut [ProjectorTexels],
    ) {
        let Some(position) = position else { return };
        for (stage, out) in self.lighting.projectors().zip(out) {
            stage.fetch(self.level, position, blocks, out);
        }
    }
}

#[inline(always)]
fn shade_blocks<I: Isa>(i: I, inputs: &Inputs<'_>, out: &mut Colors) {
    let (shader, batch) = (inputs.shader, inputs.batch);
    let mut side = Side::default();
    for (index, block) in batch.list.iter().enumerate() {
        shader.facing.update(batch, *block, &mut side);
        for pixel in (0..LANES).step_by(I::LANES) {
            let part = Part {
                at: index * LANES + pixel,
                pixel,
                block: *block,
                index,
            };
            if I::LANES < LANES && !part.mask(i, block.mask).any_true() {
                continue;
            }
            // Few lanes gain nothing by a kernel of their own.
            let color = if I::LANES == LANES && shader.attributes.is_none() {
                inputs.short(i, &part, &side)
            } else {
                inputs.any(i, &part, &side)
            };
            out.store(i, part.at, color);
        }
    }
}

//! Cut-outs in shadow maps: the holes that the camera sees are holes to the light.

use rayon::prelude::*;
use texmap_raster::{AlphaTest, Fragment, Prepared, TILE, TileBlocks, block_index};

use crate::coordinates::Coordinates;
use crate::plan::{Cut, cut};
use crate::textures::{Chains, Slot};
use crate::{AlphaMode, Mesh, Scene, Settings};

/// What the meshes of a scene let through. Those whose coordinates come from a texture frame, which is bound to the camera, let
/// nothing through.
pub(crate) struct Cuts<'s> {
    meshes: Vec<Option<Cutting<'s>>>,
}

struct Cutting<'s> {
    uv: Coordinates,
    base_color: Option<Slot<'s>>,
    opacity_map: Option<Slot<'s>>,
    cut: Cut,
    opacity: f32,
    attributes: Vec<f32>,
    attribute_count: usize,
}

impl<'s> Cuts<'s> {
    /// `None` if nothing has holes.
    pub(crate) fn new(scene: &'s Scene) -> Option<Self> {
        let tested = |mesh: &Mesh| {
            let alpha = scene.materials[mesh.material].alpha;
            matches!(alpha, AlphaMode::Test(_)) && mesh.frame.is_none()
        };
        if !scene.meshes.iter().any(tested) {
            return None;
        }
        let settings = Settings::new(1, 1);
        let chains = Chains::new(scene, &settings);
        let meshes: Vec<_> = scene
            .meshes
            .iter()
            .map(|mesh| {
                tested(mesh)
                    .then(|| Cutting::new(scene, &settings, &chains, mesh))
                    .flatten()
            })
            .collect();
        meshes
            .iter()
            .any(Option::is_some)
            .then_some(Self { meshes })
    }

    /// Attributes of a mesh and how many a vertex has; `None` for one without holes.
    pub(crate) fn attributes(&self, mesh: usize) -> Option<(&[f32], usize)> {
        let cutting = self.meshes[mesh].as_ref()?;
        Some((&cutting.attributes, cutting.attribute_count))
    }

    /// [`Prepared::depth_map`] without what lies in holes. The same bits for any number of `threads`.
    pub(crate) fn depth_map(&self, prepared: &Prepared<'_>, threads: usize) -> Vec<f32> {
        let width = prepared.size().width() as usize;
        let across = width.div_ceil(TILE as usize);
        let mut map = vec![0.0; width * prepared.size().height() as usize];
        let draw = |(row, out): (usize, &mut [f32])| {
            let mut blocks = TileBlocks::new();
            for column in 0..across {
                let index = row * across + column;
                prepared.visible_blocks(index, self, &mut blocks);
                let tile = prepared.tile(index);
                for (x, y) in (0..tile.height).flat_map(|y| (0..tile.width).map(move |x| (x, y))) {
                    let at = y as usize * width + column * TILE as usize + x as usize;
                    out[at] = blocks.depth[block_index(x, y)];
                }
            }
        };
        let rows = width * TILE as usize;
        if threads > 1 {
            map.par_chunks_mut(rows).enumerate().for_each(draw);
        } else {
            map.chunks_mut(rows).enumerate().for_each(draw);
        }
        map
    }
}

impl AlphaTest for Cuts<'_> {
    fn keep(&self, draw: u32, _triangle: u32, fragment: &Fragment) -> bool {
        let Some(c) = &self.meshes[draw as usize] else {
            return true;
        };
        let (uv, d) = c.uv.at(fragment).unwrap_or_default();
        let texel = c.base_color.as_ref().map_or(1.0, |s| s.texel(uv, d)[3]);
        let mask = c
            .opacity_map
            .as_ref()
            .map_or(1.0, |s| s.opacity(s.texel(uv, d)));
        c.cut.keeps(texel * mask * c.opacity)
    }
}

impl<'s> Cutting<'s> {
    fn new(scene: &'s Scene, settings: &Settings, chains: &Chains, mesh: &'s Mesh) -> Option<Self> {
        let material = &scene.materials[mesh.material];
        let slot = |slot| Slot::new(slot, scene, settings, chains, mesh.uv_origin);
        let base_color = material.base_color.as_ref().map(slot);
        let opacity_map = material.opacity_map.as_ref().map(slot);
        let cut = cut(material, base_color.as_ref(), opacity_map.as_ref())?;
        let (uv, attributes, attribute_count) = match mesh.round {
            Some(map) => {
                let place = |p: &[f32; 3]| {
                    let p = texmap_math::glam::DVec3::from(p.map(f64::from));
                    let world = mesh.world_from_object.transform_point3(p);
                    world.as_vec3().to_array()
                };
                let world = mesh.positions.iter().flat_map(place).collect();
                (Coordinates::Round(map, 0), world, 3)
            }
            None => (Coordinates::Vertices, mesh.uvs.as_flattened().to_vec(), 2),
        };
        Some(Self {
            uv,
            base_color,
            opacity_map,
            cut,
            opacity: material.opacity,
            attributes,
            attribute_count,
        })
    }
}

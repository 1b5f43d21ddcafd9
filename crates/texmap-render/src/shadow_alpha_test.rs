//! Alpha tests in shadow maps: holes of cut-outs let light through.

use texmap_math::{Level, narrow, wide};
use texmap_raster::{AlphaTest, Fragment, UvBlock};

use crate::plan::{AlphaTestStage, alpha_test, bound};
use crate::textures::Chains;
use crate::{RenderError, RenderSettings};
use texmap_scene::{AlphaMode, Mesh, Scene, UvSet};
use texmap_shade::Slot;
use texmap_shade::coordinates::Coordinates;

/// The alpha tests of the meshes of a scene. Meshes whose coordinates come from a texture frame, which is bound to the camera, have
/// none.
pub(crate) struct AlphaTests<'s> {
    meshes: Vec<Option<AlphaTested<'s>>>,
    level: Level,
}

struct AlphaTested<'s> {
    uv: Coordinates,
    base_color: Option<Slot<'s>>,
    opacity_map: Option<Slot<'s>>,
    cut: AlphaTestStage,
    opacity: f32,
    attributes: Vec<f32>,
    attribute_count: usize,
}

impl<'s> AlphaTests<'s> {
    /// The alpha tests of a scene; `None` if no mesh has holes.
    ///
    /// # Errors
    /// [`RenderError::Memory`].
    pub(crate) fn new(scene: &'s Scene) -> Result<Option<Self>, RenderError> {
        let tested = |mesh: &Mesh| {
            let alpha = scene.materials[mesh.material].alpha;
            matches!(alpha, AlphaMode::Test(_)) && mesh.texture_frame.is_none()
        };
        if !scene.meshes.iter().any(tested) {
            return Ok(None);
        }
        let settings = RenderSettings::new(1, 1);
        let chains = Chains::new(scene, &settings)?;
        let meshes: Vec<_> = scene
            .meshes
            .iter()
            .map(|mesh| {
                tested(mesh)
                    .then(|| AlphaTested::new(scene, &settings, &chains, mesh))
                    .flatten()
            })
            .collect();
        Ok(meshes.iter().any(Option::is_some).then_some(Self {
            meshes,
            level: Level::new(),
        }))
    }

    /// Attributes of a mesh and their number per vertex; `None` for a mesh without holes.
    pub(crate) fn attributes(&self, mesh: usize) -> Option<(&[f32], usize)> {
        let cutting = self.meshes[mesh].as_ref()?;
        Some((&cutting.attributes, cutting.attribute_count))
    }
}

impl AlphaTest for AlphaTests<'_> {
    fn keep(&self, draw: u32, _triangle: u32, fragment: &Fragment) -> bool {
        let Some(c) = &self.meshes[draw as usize] else {
            return true;
        };
        let maps = [&c.base_color, &c.opacity_map].map(Option::as_ref);
        c.cut.keeps(c.uv.at(fragment), maps, c.opacity)
    }

    fn keep_by_uv(&self, draw: u32, at: &UvBlock, asked: u16) -> Option<u16> {
        let Some(c) = &self.meshes[draw as usize] else {
            return Some(asked);
        };
        if !matches!(c.uv, Coordinates::Vertices) {
            return None;
        }
        let maps = [&c.base_color, &c.opacity_map].map(|map| bound(map.as_ref()));
        let maps = maps.each_ref().map(Option::as_ref);
        Some(c.cut.keeps_block(self.level, at, maps, c.opacity))
    }
}

impl<'s> AlphaTested<'s> {
    fn new(
        scene: &'s Scene,
        settings: &RenderSettings,
        chains: &Chains,
        mesh: &'s Mesh,
    ) -> Option<Self> {
        let material = &scene.materials[mesh.material];
        let slot = |slot| chains.slot(slot, scene, settings, mesh.uv_origin);
        let base_color = material.base_color.as_ref().map(slot);
        let opacity_map = material.opacity_map.as_ref().map(slot);
        let cut = alpha_test(material, base_color.as_ref(), opacity_map.as_ref())?;
        let by_second = |slot: &Option<Slot<'_>>| {
            let slot = slot.as_ref();
            slot.is_some_and(|slot| slot.uv_set == UvSet::Second)
        };
        let second = by_second(&base_color) || by_second(&opacity_map);
        let (uv, attributes, attribute_count) = match mesh.uv_projection {
            _ if second => {
                let attributes = mesh.lightmap_uvs.as_flattened().to_vec();
                (Coordinates::Vertices, attributes, 2)
            }
            Some(map) => {
                let place =
                    |p: &[f32; 3]| narrow(mesh.world_from_object.transform_point3(wide(*p)));
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

//! Effects of one surface that is lit per pixel: its maps, and the attributes that they read.

use texmap_light::{Light, NormalMap};
use texmap_math::glam::{DMat3, DVec3};

use crate::RenderSettings;
use crate::frame_resources::FrameResources;
use crate::textures::Chains;
use crate::vertices::{Values, Vertices};
use texmap_scene::{LightMapSlot, NormalDetail};
use texmap_scene::{Material, Mesh, Scene, TextureSlot};
use texmap_shade::Slot;
use texmap_shade::metallic::{self, METALLIC_MAPS};
use texmap_shade::normal::{NormalSource, NormalSpace};
use texmap_shade::procedural::ProceduralBump;
use texmap_shade::slopes::Rise;

/// Textures instead of numbers of a material: their indices in [`SurfaceEffects::maps`].
pub(super) const AMBIENT: usize = 0;
pub(super) const SPECULAR: usize = 1;
pub(super) const EXPONENT: usize = 2;
pub(super) const REFLECTIVITY: usize = 3;
pub(super) const MAPS: usize = 4;

/// The maps of one surface, and the attributes that they read.
pub(crate) struct SurfaceEffects<'s> {
    /// Ambient color, specular color, exponent, reflectivity.
    pub(crate) maps: [Option<Slot<'s>>; MAPS],
    pub(crate) normal: Option<NormalSource<'s>>,
    /// The maps of a metallic-roughness model.
    pub(crate) metallic: [Option<Slot<'s>>; METALLIC_MAPS],
    /// Baked light, its map, and the first attribute of the coordinates.
    pub(crate) light_map: Option<(&'s LightMapSlot, Slot<'s>, usize)>,
    /// True if a mirror leads its rays to walls.
    leads_rays: bool,
    /// True if the model of light reads the direction to the eye for any lights.
    sees_eye: bool,
    /// Unit normals of the triangles' planes, world space; empty where there are neither shadows nor projectors, which alone read them.
    pub(crate) planes: Vec<DVec3>,
    /// The lights that are not baked, by their number.
    pub(crate) lights: Vec<(usize, Light)>,
}

impl<'s> SurfaceEffects<'s> {
    /// The effects that a surface lit per pixel is under; `None` if there are none. Asks for the attributes that they read; the
    /// caller sees to uv, normals and positions.
    pub(crate) fn new(
        scene: &'s Scene,
        settings: &RenderSettings,
        chains: &Chains,
        ready: &FrameResources<'s>,
        mesh: &'s Mesh,
        vertices: &mut Vertices,
    ) -> Option<Box<Self>> {
        let material = &scene.materials[mesh.material];
        if ready.is_plain() && !has_effects(material) {
            return None;
        }
        let slot = |slot| chains.slot(slot, scene, settings, mesh.uv_origin);
        let maps = &material.maps;
        let detail = material.normal_detail.as_ref();
        let normal = detail.map(|detail| normal_detail(detail, mesh, vertices, slot));
        let light_map = material.light_map.as_ref();
        let lightmap_uv = light_map.map(|_| vertices.push(Values::LightMapUv, false));
        // Projectors come after the lights of the scene; no light map holds theirs.
        let baked = |index: usize| index < scene.lights.len() && material.bakes(index);
        let lights = ready.lights.iter().copied().enumerate();
        Some(Box::new(Self {
            maps: [
                &maps.ambient,
                &maps.specular,
                &maps.exponent,
                &maps.reflectivity,
            ]
            .map(|map| map.as_ref().map(slot)),
            metallic: material.metallic_roughness.as_ref().map_or_else(
                || [const { None }; METALLIC_MAPS],
                |model| metallic::slots(model).map(|map| map.map(slot)),
            ),
            normal,
            light_map: light_map
                .zip(lightmap_uv)
                .map(|(map, first)| (map, slot(&map.slot), first)),
            leads_rays: material.reflection.is_some_and(|r| r.within.is_some()),
            sees_eye: material.metallic_roughness.is_some(),
            planes: match ready.is_plain() {
                true => Vec::new(),
                false => mesh.triangle_normals(),
            },
            lights: lights.filter(|(index, _)| !baked(*index)).collect(),
        }))
    }

    /// True if some stage asks for positions. (A mirror without walls asks for the direction to the eye alone.)
    pub(crate) fn reads_positions(&self, ready: &FrameResources<'_>) -> bool {
        let mut lights = self.lights.iter();
        self.sees_eye
            || self.leads_rays
            || self.normal.is_some()
            || !ready.projector_decals.is_empty()
            || lights.any(|(_, light)| !matches!(light, Light::Ambient { .. }))
    }

    /// Normal of a triangle's plane on the side that is seen.
    pub(crate) fn plane(&self, triangle: u32, front: bool) -> Option<DVec3> {
        let plane = *self.planes.get(triangle as usize)?;
        Some(if front { plane } else { -plane })
    }
}

/// The normal stage of a material, and the attributes that it reads but uv, normals and positions.
fn normal_detail<'s>(
    detail: &'s NormalDetail,
    mesh: &Mesh,
    vertices: &mut Vertices,
    slot: impl Fn(&'s TextureSlot) -> Slot<'s>,
) -> NormalSource<'s> {
    let unit = world_unit(mesh);
    let rise = |height| Rise {
        height,
        unit: unit as f32,
    };
    match detail {
        NormalDetail::Bump { slot: map, height } => NormalSource::Bump(slot(map), rise(*height)),
        NormalDetail::Offsets {
            slot: map,
            slope,
            green,
        } => NormalSource::Offsets(slot(map), rise(*slope), *green),
        NormalDetail::Procedural {
            heights,
            world_from_solid,
            height,
        } => {
            let height = (f64::from(*height) * unit) as f32;
            NormalSource::Procedural(ProceduralBump::new(*heights, *world_from_solid, height))
        }
        NormalDetail::NormalMap {
            slot: map,
            green,
            rebuild_z,
            object_space,
            strength,
        } => {
            let space = if *object_space {
                let linear = DMat3::from_mat4(mesh.world_from_object);
                NormalSpace::Object(linear.inverse().transpose())
            } else {
                NormalSpace::Tangent(vertices.push(Values::Tangent, false))
            };
            let decoder = NormalMap {
                green: *green,
                rebuild_z: *rebuild_z,
                strength: *strength,
            };
            NormalSource::Map(slot(map), decoder, space)
        }
    }
}

/// World units of one unit of a mesh's own space, the mean of its three axes by volume.
fn world_unit(mesh: &Mesh) -> f64 {
    let volume = DMat3::from_mat4(mesh.world_from_object).determinant().abs();
    texmap_math::deterministic_f64::pow(volume, 1.0 / 3.0)
}

/// True if a material lit per pixel needs more than lights.
fn has_effects(material: &Material) -> bool {
    let maps = &material.maps;
    material.normal_detail.is_some()
        || material.metallic_roughness.is_some()
        || material.light_map.is_some()
        || material.reflection.is_some()
        || material.specular_map.is_some()
        || material.specular_model != texmap_light::SpecularModel::Phong
        || [&maps.ambient, &maps.specular, &maps.exponent]
            .into_iter()
            .any(Option::is_some)
}

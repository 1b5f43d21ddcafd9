//! A scene made ready for rays: its surfaces, and everything that they look up.

use texmap_light::{EnvironmentSample, ShadowBias, ShadowMap};
use texmap_math::glam::{DVec2, DVec3};
use texmap_raster::Cull;
use texmap_render::{RenderError, shadow_map_for};
use texmap_scene::shadow_fit::ENVIRONMENT_SHADOW_SIZE;
use texmap_scene::{Background, Scene};

use super::backdrop::SampledBackground;
use super::environment::EnvironmentMap;
use super::metallic::Albedos;
use super::projector::Cast;
use super::shadow::Shadow;
use super::slot::Textures;
use super::surface::Surface;
use super::volume::Medium;
use crate::TruthError;
use crate::caster::Pinhole;
use crate::rays::{RayObject, RayScene};

pub(super) struct World<'s> {
    pub(super) scene: &'s Scene,
    /// Mirrors show what their rays meet, in place of their environments.
    pub(super) traces: bool,
    /// Numbers of the draws of the back and the front of each mesh.
    pub(super) ranks: Vec<[usize; 2]>,
    /// Rays of the samples.
    pub(super) pinhole: Pinhole,
    pub(super) surfaces: Vec<Surface<'s>>,
    /// The triangles of all surfaces.
    pub(super) rays: RayScene,
    /// Length of the diagonal of everything.
    pub(super) extent: f64,
    /// By light.
    pub(super) shadows: Vec<Vec<Shadow>>,
    /// Of the samples of the environment that cast shadows, and their bias.
    pub(super) environment_shadows: (Vec<(EnvironmentSample, ShadowMap)>, ShadowBias),
    pub(super) projectors: Vec<Cast<'s>>,
    pub(super) projector_shadows: Vec<Option<Shadow>>,
    /// Environments that something reads.
    pub(super) environments: Vec<Option<EnvironmentMap>>,
    pub(super) volumes: Vec<Medium<'s>>,
    pub(super) behind: SampledBackground<'s>,
    pub(super) albedos: Albedos,
}

impl<'s> World<'s> {
    /// A checked scene for a picture of this size with `samples` x `samples` samples a pixel.
    pub(super) fn new(
        scene: &'s Scene,
        (width, height): (u32, u32),
        samples: u32,
    ) -> Result<Self, TruthError> {
        let mut textures = Textures::new(scene);
        let effects = &scene.effects;
        let mut shadows: Vec<Vec<Shadow>> = scene.lights.iter().map(|_| Vec::new()).collect();
        for shadow in &effects.shadows {
            shadows[shadow.light].push(Shadow::of_light(scene, shadow, width)?);
        }
        let surfaces = scene
            .meshes
            .iter()
            .map(|mesh| Surface::new(scene, mesh, &mut textures));
        let surfaces = surfaces.collect::<Result<Vec<_>, _>>()?;
        let (mut low, mut high) = (scene.camera.eye, scene.camera.eye);
        for p in scene.meshes.iter().flat_map(super::world) {
            (low, high) = (low.min(p), high.max(p));
        }
        let read = environments_read(scene);
        let environment =
            |(i, environment)| read.contains(&i).then(|| EnvironmentMap::new(environment));
        let environment_shadows = environment_shadows(scene)?;
        let size = DVec2::new(f64::from(width * samples), f64::from(height * samples));
        let projectors = &effects.projectors;
        Ok(Self {
            scene,
            traces: false,
            ranks: ranks(scene),
            pinhole: Pinhole::of_camera(&scene.camera, width * samples, height * samples)?,
            surfaces,
            rays: RayScene::new(scene.meshes.iter().map(RayObject::Mesh)),
            extent: (high - low).length(),
            shadows,
            environment_shadows,
            projectors: projectors
                .iter()
                .map(|p| Cast::new(p, &mut textures))
                .collect(),
            projector_shadows: projectors.iter().map(Shadow::of_projector).collect(),
            environments: effects
                .environments
                .iter()
                .enumerate()
                .map(environment)
                .collect(),
            volumes: effects
                .volumes
                .iter()
                .map(|volume| Medium::new(scene, volume, &mut textures))
                .collect(),
            behind: SampledBackground::new(scene, size, &mut textures),
            albedos: Albedos::default(),
        })
    }

    /// Display light of the light of a surface or a sky.
    pub(super) fn display(&self, light: DVec3) -> DVec3 {
        display(self.scene, light)
    }

    /// The upper end of display light.
    pub(super) fn limit(&self) -> DVec3 {
        DVec3::splat(f64::from(self.scene.effects.tone_mapping.map.limit()))
    }

    /// True if shadows reach the surface of a mesh.
    pub(super) fn has_shadows(&self) -> bool {
        let cast = self.projector_shadows.iter().any(Option::is_some);
        cast || self.shadows.iter().any(|of_light| !of_light.is_empty())
    }
}

/// Display light of light: exposure and tone mapping.
pub(super) fn display(scene: &Scene, light: DVec3) -> DVec3 {
    let mapping = scene.effects.tone_mapping;
    if mapping.is_identity() {
        return light.min(DVec3::splat(f64::from(mapping.map.limit())));
    }
    texmap_light::reference::tone_map(mapping.map, f64::from(mapping.exposure), light)
}

/// Numbers of the draws of the back and the front of each mesh.
fn ranks(scene: &Scene) -> Vec<[usize; 2]> {
    let mut ranks = vec![[0; 2]; scene.meshes.len()];
    for (number, draw) in scene.drawing_order().into_iter().enumerate() {
        let [back, front] = &mut ranks[draw.mesh];
        if draw.cull != Cull::Back {
            *back = number;
        }
        if draw.cull != Cull::Front {
            *front = number;
        }
    }
    ranks
}

/// The maps of the samples of the environment that cast shadows, and the bias of their look-ups.
fn environment_shadows(
    scene: &Scene,
) -> Result<(Vec<(EnvironmentSample, ShadowMap)>, ShadowBias), RenderError> {
    let (samples, bias) = texmap_scene::shadow_fit::environment_shadows(scene);
    let maps = samples.into_iter().map(|(sample, kind)| {
        let map = shadow_map_for(scene, &kind, ENVIRONMENT_SHADOW_SIZE, bias, 1, usize::MAX);
        Ok((sample, map?))
    });
    Ok((maps.collect::<Result<_, RenderError>>()?, bias))
}

/// Environments that some surface or the sky looks up.
fn environments_read(scene: &Scene) -> Vec<usize> {
    let of_mesh = |mesh: &texmap_scene::Mesh| {
        let material = &scene.materials[mesh.material];
        let mirrored = material.reflection.map(|reflection| reflection.environment);
        mirrored.into_iter().chain(material.specular_map)
    };
    let mut read: Vec<usize> = scene.meshes.iter().flat_map(of_mesh).collect();
    if let Some(Background::Environment(index)) = scene.effects.background {
        read.push(index);
    }
    read
}

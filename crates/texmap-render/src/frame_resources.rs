//! The effects of a scene, made ready before the first tile: shadow maps, projectors, environments.

use std::sync::Arc;

use texmap_light::{
    BoundProjectorTexture, Environment, EnvironmentSample, Light, ProjectorTexture, ShadowBias,
    ShadowKind, ShadowSampler,
};
use texmap_math::glam::{DMat3, DMat4, DVec3};
use texmap_math::{MemoryBudget, Projector, narrow};
use texmap_scene::shadow_fit::{ENVIRONMENT_SHADOW_SIZE, fitting_size, shadow_bias, shadow_kind};

use crate::shadow::shadow_map_in;
use crate::{RenderError, RenderSettings};
use texmap_scene::{ProjectorLight, ProjectorMode, Scene};
use texmap_shade::projector::Projected;

/// The effects of a scene, made ready: every map is finished before the first tile.
#[derive(Debug)]
pub(crate) struct FrameResources<'s> {
    /// The scene's lights, then a point light for each projector of light.
    pub(crate) lights: Vec<Light>,
    /// The shadow maps of each light.
    pub(crate) shadows: Vec<Vec<ShadowSampler>>,
    /// The projected textures of the last `projector_lights.len()` of `lights`.
    pub(crate) projector_lights: Vec<Projected<'s>>,
    pub(crate) projector_decals: Vec<Projected<'s>>,
    pub(crate) environments: &'s [Environment],
    pub(crate) environment_shadows: EnvironmentShadows,
}

/// Samples of the environment light, and the shadow map of each: see [`Effects::environment_shadows`](texmap_scene::Effects). They
/// depend neither on the camera nor on the settings.
#[derive(Clone, Debug)]
pub struct EnvironmentShadows(pub(crate) Arc<Vec<(EnvironmentSample, ShadowSampler)>>);

impl<'s> FrameResources<'s> {
    /// Draws all maps.
    pub(crate) fn new(scene: &'s Scene, settings: &RenderSettings) -> Result<Self, RenderError> {
        Self::with_buffers(scene, settings, Vec::new())
    }

    /// [`new`](Self::new) in the [`take_buffers`](Self::take_buffers) of earlier maps.
    pub(crate) fn with_buffers(
        scene: &'s Scene,
        settings: &RenderSettings,
        buffers: Vec<Vec<f32>>,
    ) -> Result<Self, RenderError> {
        let first_frame = buffers.is_empty();
        let mut buffers = buffers.into_iter();
        let threads = settings.threads.unwrap_or(usize::MAX);
        let mut draw = |kind: &ShadowKind, size: u32, bias: ShadowBias, taps: u32| {
            let mut buffer = buffers.next().unwrap_or_default();
            reserve_map(settings.memory, kind, size, &mut buffer)?;
            let (map, bounds) = shadow_map_in(scene, kind, size, (bias, taps), threads, buffer)?;
            let bounds = Some(bounds);
            Ok::<_, RenderError>(ShadowSampler::with_bounds(map, bias, taps, bounds))
        };
        let mut lights = scene.lights.clone();
        let mut shadows: Vec<Vec<ShadowSampler>> =
            scene.lights.iter().map(|_| Vec::new()).collect();
        let mut maps = Vec::new();
        for shadow in &scene.effects.shadows {
            let kind = shadow_kind(scene, shadow.light, shadow.area)?;
            let size = shadow
                .size
                .unwrap_or_else(|| fitting_size(scene, &kind, settings.width));
            maps.push((shadow, kind, size));
        }
        // Before the first of many is drawn.
        if first_frame && maps.len() > 1 {
            let all = maps.iter().map(|(_, kind, size)| map_texels(kind, *size));
            settings.memory.ask(
                all.sum::<usize>() as u64 * 4,
                format_args!("{} shadow maps", maps.len()),
                "give `shadow` a smaller size",
            )?;
        }
        for (shadow, kind, size) in maps {
            let bias = shadow.bias.unwrap_or_else(|| shadow_bias(scene));
            shadows[shadow.light].push(draw(&kind, size, bias, shadow.pcf_size)?);
        }
        let (mut projector_lights, mut projector_decals) = (Vec::new(), Vec::new());
        for projector in &scene.effects.projectors {
            let shadow = match projector.shadow {
                None => None,
                Some(size) => Some(draw(
                    &projector_kind(projector),
                    size,
                    shadow_bias(scene),
                    3,
                )?),
            };
            let view = BoundProjectorTexture::new(&ProjectorTexture {
                projector: projector.projector,
                texture: &scene.textures[projector.texture],
                sampler: &projector.sampler,
                border: projector.border,
                softness: projector.softness,
            });
            let position = narrow(projector.position);
            let projected = Projected {
                view: match projector.mode {
                    ProjectorMode::Decal => view.as_decal(),
                    ProjectorMode::Light(_) => view,
                },
                position,
                shadow,
            };
            match projector.mode {
                ProjectorMode::Decal => projector_decals.push(projected),
                ProjectorMode::Light(color) => {
                    lights.push(Light::Point { color, position });
                    shadows.push(Vec::new());
                    projector_lights.push(projected);
                }
            }
        }
        let (samples, bias) = texmap_scene::shadow_fit::environment_shadows(scene);
        let fits = |EnvironmentShadows(made): &&EnvironmentShadows| {
            let made = made.iter().map(|(sample, map)| (sample, map.kind()));
            made.eq(samples.iter().map(|(sample, kind)| (sample, kind)))
        };
        let environment_shadows = match settings.environment_shadows.as_ref().filter(fits) {
            Some(made) => made.clone(),
            None => {
                if first_frame && !samples.is_empty() {
                    let texels = u64::from(ENVIRONMENT_SHADOW_SIZE).pow(2);
                    settings.memory.ask(
                        texels * 4 * samples.len() as u64,
                        format_args!("{} shadow maps of the environment light", samples.len()),
                        "let fewer of its samples cast shadows",
                    )?;
                }
                let draw = |(sample, kind)| {
                    draw(&kind, ENVIRONMENT_SHADOW_SIZE, bias, 1).map(|map| (sample, map))
                };
                let made: Result<Vec<_>, RenderError> = samples.into_iter().map(draw).collect();
                EnvironmentShadows(Arc::new(made?))
            }
        };
        Ok(Self {
            lights,
            shadows,
            projector_lights,
            projector_decals,
            environments: &scene.effects.environments,
            environment_shadows,
        })
    }

    /// Takes the buffers of all shadow maps, which are empty from then on.
    pub(crate) fn take_buffers(&mut self) -> Vec<Vec<f32>> {
        let of_lights = self.shadows.iter_mut().flatten();
        let projectors = self
            .projector_lights
            .iter_mut()
            .chain(&mut self.projector_decals);
        let of_projectors = projectors.filter_map(|projected| projected.shadow.as_mut());
        let of_sky = Arc::get_mut(&mut self.environment_shadows.0);
        let of_sky = of_sky.into_iter().flatten().map(|(_, map)| map);
        let all = of_lights.chain(of_projectors).chain(of_sky);
        all.map(ShadowSampler::take_depths).collect()
    }

    /// True if there are neither projectors nor shadows, so that plain surfaces need no effects.
    pub(crate) fn is_plain(&self) -> bool {
        !self.has_projectors()
            && self.environment_shadows.0.is_empty()
            && self.shadows.iter().all(Vec::is_empty)
    }

    pub(crate) fn has_projectors(&self) -> bool {
        !(self.projector_lights.is_empty() && self.projector_decals.is_empty())
    }

    /// Visibility of a light of the scene at a sample, for the `shadow` AOV; `None` without a shadow.
    pub(crate) fn shadow(&self, light: usize, point: [f32; 3], plane: DVec3) -> Option<f32> {
        let shades = self.shadows.get(light).filter(|s| !s.is_empty())?;
        Some(
            shades
                .iter()
                .map(|s| s.visibility(point, narrow(plane)))
                .product(),
        )
    }
}

/// Reserves the depths of all faces of a shadow map.
pub(crate) fn reserve_map(
    memory: MemoryBudget,
    kind: &ShadowKind,
    size: u32,
    buffer: &mut Vec<f32>,
) -> Result<(), RenderError> {
    memory.reserve(
        buffer,
        map_texels(kind, size),
        format_args!("a shadow map of {} x {size} x {size} texels", faces(kind)),
        "give `shadow` a smaller size",
    )?;
    Ok(())
}

fn faces(kind: &ShadowKind) -> usize {
    match kind {
        ShadowKind::Point { .. } => 6,
        _ => 1,
    }
}

/// Texels of all faces of a shadow map.
fn map_texels(kind: &ShadowKind, size: u32) -> usize {
    faces(kind) * size as usize * size as usize
}

/// The pyramid of a projector as a spot light's map: square, as wide as the wider side of the picture.
fn projector_kind(projector: &ProjectorLight) -> ShadowKind {
    let Projector { q, s, t } = projector.projector;
    // q - t/2 and s - t/2 are the right and down axes times the focal lengths.
    let forward = t.truncate();
    let (right, down) = (q.truncate() - forward * 0.5, s.truncate() - forward * 0.5);
    let tan_half = 0.5 / right.length().min(down.length());
    let (x, y) = (right.normalize(), -down.normalize());
    let rotation = DMat3::from_cols(x, y, -forward).transpose();
    ShadowKind::Spot {
        light_from_world: DMat4::from_mat3(rotation) * DMat4::from_translation(-projector.position),
        tan_half,
    }
}

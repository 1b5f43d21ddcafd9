//! The effects of a scene, made ready before the first tile: shadow maps, slides, environments.

use texmap_light::{
    BoundProjectorTexture, Environment, Light, ProjectorTexture, ShadowBias, ShadowKind,
    ShadowSampler,
};
use texmap_math::glam::{DMat3, DMat4, DVec3};
use texmap_math::{MemoryBudget, Projector, narrow};
use texmap_scene::shadow_fit::{fitting_size, shadow_bias, shadow_kind};

use crate::shade::projector::Projected;
use crate::shadow::shadow_map_in;
use crate::{RenderError, RenderSettings};
use texmap_scene::{ProjectorLight, ProjectorMode, Scene};

/// The effects of a scene, made ready: every map is finished before the first tile.
#[derive(Debug)]
pub(crate) struct FrameResources<'s> {
    /// The scene's lights, then a lamp for each projector of light.
    pub(crate) lights: Vec<Light>,
    /// Per light.
    pub(crate) shadows: Vec<Vec<ShadowSampler>>,
    /// Slides of the lamps, from light `lights.len() - lamps.len()` on.
    pub(crate) projector_lights: Vec<Projected<'s>>,
    pub(crate) projector_decals: Vec<Projected<'s>>,
    pub(crate) environments: &'s [Environment],
}

impl<'s> FrameResources<'s> {
    /// Draws all maps.
    pub(crate) fn new(scene: &'s Scene, settings: &RenderSettings) -> Result<Self, RenderError> {
        Self::with_buffers(scene, settings, Vec::new())
    }

    /// [`new`](Self::new) in the [`take_buffers`](Self::take_buffers) of earlier maps.
    pub(crate) fn with_buffers(
        scene: &'s Scene,
        settings: &RenderSettings,
        rooms: Vec<Vec<f32>>,
    ) -> Result<Self, RenderError> {
        let mut rooms = rooms.into_iter();
        let threads = settings.threads.unwrap_or(usize::MAX);
        let mut draw = |kind: &ShadowKind, size: u32, bias: ShadowBias, taps: u32| {
            let mut room = rooms.next().unwrap_or_default();
            reserve_map(settings.memory, kind, size, &mut room)?;
            let (map, bounds) = shadow_map_in(scene, kind, size, (bias, taps), threads, room)?;
            let bounds = Some(bounds);
            Ok::<_, RenderError>(ShadowSampler::with_bounds(map, bias, taps, bounds))
        };
        let mut lights = scene.lights.clone();
        let mut shadows: Vec<Vec<ShadowSampler>> =
            scene.lights.iter().map(|_| Vec::new()).collect();
        for shadow in &scene.effects.shadows {
            let kind = shadow_kind(scene, shadow.light, shadow.area)?;
            let size = shadow
                .size
                .unwrap_or_else(|| fitting_size(scene, &kind, settings.width));
            let bias = shadow.bias.unwrap_or_else(|| shadow_bias(scene));
            shadows[shadow.light].push(draw(&kind, size, bias, shadow.pcf_size)?);
        }
        let (mut lamps, mut paints) = (Vec::new(), Vec::new());
        for slide in &scene.effects.projectors {
            let shadow = match slide.shadow {
                None => None,
                Some(size) => Some(draw(&slide_kind(slide), size, shadow_bias(scene), 3)?),
            };
            let view = BoundProjectorTexture::new(&ProjectorTexture {
                projector: slide.projector,
                texture: &scene.textures[slide.texture],
                sampler: &slide.sampler,
                border: slide.border,
                softness: slide.softness,
            });
            let position = narrow(slide.position);
            let projected = Projected {
                view: match slide.mode {
                    ProjectorMode::Decal => view.as_decal(),
                    ProjectorMode::Light(_) => view,
                },
                position,
                shadow,
            };
            match slide.mode {
                ProjectorMode::Decal => paints.push(projected),
                ProjectorMode::Light(color) => {
                    lights.push(Light::Point { color, position });
                    shadows.push(Vec::new());
                    lamps.push(projected);
                }
            }
        }
        Ok(Self {
            lights,
            shadows,
            projector_lights: lamps,
            projector_decals: paints,
            environments: &scene.effects.environments,
        })
    }

    /// Takes the rooms of all maps, which are empty from then on.
    pub(crate) fn take_buffers(&mut self) -> Vec<Vec<f32>> {
        let of_lights = self.shadows.iter_mut().flatten();
        let slides = self
            .projector_lights
            .iter_mut()
            .chain(&mut self.projector_decals);
        let of_slides = slides.filter_map(|projected| projected.shadow.as_mut());
        let all = of_lights.chain(of_slides);
        all.map(ShadowSampler::take_depths).collect()
    }

    /// Whether surfaces without effects of their own must know of these.
    pub(crate) fn is_plain(&self) -> bool {
        self.projector_lights.is_empty()
            && self.projector_decals.is_empty()
            && self.shadows.iter().all(Vec::is_empty)
    }

    /// Share of each light of the scene that its shadows leave at a sample, for the `shadow` AOV.
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
    room: &mut Vec<f32>,
) -> Result<(), RenderError> {
    let faces = match kind {
        ShadowKind::Point { .. } => 6,
        _ => 1,
    };
    memory.reserve(
        room,
        faces * size as usize * size as usize,
        format_args!("a shadow map of {faces} x {size} x {size} texels"),
        "give `shadow` a smaller size",
    )?;
    Ok(())
}

/// The pyramid of a projector as a spot light's map: square, as wide as the wider side of the picture.
fn slide_kind(slide: &ProjectorLight) -> ShadowKind {
    let Projector { q, s, t } = slide.projector;
    // q - t/2 and s - t/2 are the right and down axes times the focal lengths.
    let forward = t.truncate();
    let (right, down) = (q.truncate() - forward * 0.5, s.truncate() - forward * 0.5);
    let tan_half = 0.5 / right.length().min(down.length());
    let (x, y) = (right.normalize(), -down.normalize());
    let rotation = DMat3::from_cols(x, y, -forward).transpose();
    ShadowKind::Spot {
        light_from_world: DMat4::from_mat3(rotation) * DMat4::from_translation(-slide.position),
        tan_half,
    }
}

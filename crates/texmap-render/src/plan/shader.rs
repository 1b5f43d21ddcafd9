//! The stages that run on the fragments of a surface, and their inputs: the one module that knows all stages.

use texmap_light::{Light, ShadowSampler, SpecularExponent};

use super::effects::SurfaceEffects;
use super::{Plan, Space, Surface};
use crate::frame_resources::FrameResources;
use crate::shade::base_color::BaseColor;
use crate::shade::coordinates::Coordinates;
use crate::shade::environment::Reflections;
use crate::shade::facing::FacingStage;
use crate::shade::fetch::TexturePair;
use crate::shade::lighting::{LightStage, Lighting, LitBy, MAPS};
use crate::shade::normal::{NormalSource, NormalStage};
use crate::shade::projector::ProjectorStage;
use crate::shade::sky::SkyStage;
use crate::shade::surface::SurfaceShader;
use crate::shade::unlit::Unlit;
use crate::shade::volume::VolumeStage;
use crate::textures::Slot;
use texmap_scene::{AlphaMode, TextureRole};

/// The stages of a draw.
pub(crate) enum Shader<'a> {
    Unlit(Box<Unlit<'a>>),
    Surface(Box<SurfaceShader<'a>>),
    Sky(&'a SkyStage<'a>),
    Volume(&'a VolumeStage<'a>),
}

impl<'a> Shader<'a> {
    pub(crate) fn new(plan: &'a Plan<'a>, surface: &'a Surface<'a>) -> Self {
        match (&surface.space, surface.unlit) {
            (Some(Space::Sky(stage)), _) => Self::Sky(stage),
            (Some(Space::Volume(stage)), _) => Self::Volume(stage),
            (None, Some(color)) => {
                let slot = surface.base_color.as_ref();
                Self::Unlit(Box::new(Unlit::new(color, slot)))
            }
            (None, None) => Self::Surface(Box::new(surface_shader(plan, surface))),
        }
    }

    /// The one stage of an unlit surface.
    pub(crate) fn unlit(&self) -> Option<&Unlit<'a>> {
        match self {
            Self::Unlit(unlit) => Some(unlit),
            _ => None,
        }
    }
}

fn surface_shader<'a>(plan: &'a Plan<'a>, surface: &'a Surface<'a>) -> SurfaceShader<'a> {
    let (level, ready, material) = (plan.level, &*plan.ready, surface.material);
    let per_pixel = matches!(surface.light, LightStage::PerPixel);
    let effects = surface.effects.as_deref().filter(|_| per_pixel);
    let covers = surface.base_color.is_some() && material.texture_role == TextureRole::Decal;
    let position = surface.position.filter(|first| first + 3 <= surface.shaded);

    let detail = effects.and_then(|effects| effects.normal.as_ref());
    let normal_map = match detail {
        Some(NormalSource::Map(slot, ..)) if fits(surface, slot) => Some(slot),
        _ => None,
    };
    let normal = NormalStage {
        detail,
        paired: normal_map.is_some(),
        horizon_clamp: material.horizon_clamp,
    };
    let base = base_color(surface, covers);
    let pair = TexturePair::new([base.texture.filter(|_| base.paired), normal_map]);

    let environment = |index: usize| &ready.environments[index];
    let reflection = material.reflection.filter(|_| effects.is_some());
    let specular = material.specular_map.filter(|_| effects.is_some());
    let reflections = Reflections {
        mirror: reflection.map(|r| (environment(r.environment), r.reflectivity)),
        specular: specular.map(|index| (environment(index), material.phong.ks)),
        rays: plan.rays,
    };

    let lights = match (per_pixel, effects) {
        (false, _) => Vec::new(),
        (true, None) => plan.lights.iter().map(unshadowed).collect(),
        (true, Some(effects)) => lights(ready, effects),
    };
    let paints = ready.projector_decals.iter();
    let paints = paints.filter(|_| effects.is_some() && position.is_some());
    let shines = lights.iter().any(|by| !by.is_ambient());
    let lights_all = |by: &LitBy<'_>| !by.is_ambient() && by.projector.is_none();
    let lighting = Lighting {
        numbers: material.phong,
        power: SpecularExponent::new(material.phong.ns),
        model: material.specular_model,
        light_map: effects
            .and_then(|effects| effects.light_map.as_ref())
            .map(|(map, slot, first)| (material.phong.kd * map.scale, slot, *first)),
        paints: paints.map(ProjectorStage::new).collect(),
        maps: effects.map_or([None; MAPS], |effects| {
            effects.maps.each_ref().map(Option::as_ref)
        }),
        eye: plan.eye,
        sees_eye: (shines && material.phong.ks > 0.0)
            || (detail.is_some() && material.horizon_clamp),
        needs_normal: !reflections.is_empty() || lights.iter().any(lights_all),
        lights,
    };

    let mut shadow_maps = lighting.lights.iter().flat_map(LitBy::shadow_maps);
    let by_shadows = shadow_maps.any(ShadowSampler::reads_normals);
    drop(shadow_maps);
    // Paint does not reach what faces away from its projector.
    let reads_planes = by_shadows || !lighting.paints.is_empty();
    let emission = surface.emission.as_ref();
    let emission = emission.map(|(color, map)| (*color, map.as_ref()));
    let light_ramp = surface.light_ramp.as_ref();
    let short = per_pixel
        && base.paired
        && normal.is_short()
        && lighting.maps.iter().all(Option::is_none)
        && light_ramp.is_none()
        && emission.is_none()
        && reflections.specular.is_none()
        && lighting.paints.is_empty();
    SurfaceShader {
        level,
        uv: &surface.uv,
        base,
        covers,
        light: surface.light,
        light_ramp,
        emission,
        normal,
        facing: FacingStage {
            cull: material.cull,
            planes: effects
                .filter(|_| reads_planes)
                .map(|effects| &effects.planes[..]),
        },
        lighting,
        reflections,
        pair,
        normal_attribute: surface.normal,
        position_attribute: position,
        attributes: (!short).then_some(surface.shaded),
    }
}

fn base_color<'a>(surface: &'a Surface<'a>, covers: bool) -> BaseColor<'a> {
    let material = surface.material;
    let texture = surface.base_color.as_ref();
    let mut base = BaseColor {
        color: material.phong.color,
        texture,
        paired: false,
        opaque_texels: surface.solid,
        ramp: surface.color_ramp.as_ref(),
        antialiased: material.antialiased_alpha,
        solid: surface.carved.as_ref(),
        decal: surface.decal.as_ref(),
        opacity_map: surface.opacity_map.as_ref(),
        vertex_color: surface.color,
        alpha: material.alpha,
        opacity: material.opacity,
    };
    base.paired = !covers
        && base.alpha == AlphaMode::Opaque
        && base.opacity_map.is_none()
        && base.vertex_color.is_none()
        && base.ramp.is_none()
        && !base.antialiased
        && base.solid.is_none()
        && base.decal.is_none()
        && texture.is_none_or(|slot| fits(surface, slot));
    base
}

fn unshadowed<'a>(light: &Light) -> LitBy<'a> {
    LitBy {
        light: *light,
        shadows: &[],
        projector: None,
    }
}

/// The lights of a surface, their shadow maps and projectors.
fn lights<'a>(ready: &'a FrameResources<'a>, effects: &'a SurfaceEffects<'a>) -> Vec<LitBy<'a>> {
    let first_lamp = ready.lights.len() - ready.projector_lights.len();
    let lights = effects.lights.iter().map(|(index, light)| {
        let projected = index
            .checked_sub(first_lamp)
            .map(|k| &ready.projector_lights[k]);
        LitBy {
            light: *light,
            shadows: &ready.shadows[*index],
            projector: projected.map(ProjectorStage::new),
        }
    });
    lights.collect()
}

/// True if a texture is opaque and read at the coordinates of the vertices as they are.
fn fits(surface: &Surface<'_>, slot: &Slot<'_>) -> bool {
    let uv = matches!(surface.uv, Coordinates::Vertices);
    uv && !slot.is_transformed() && !slot.can_be_transparent()
}

//! Lights: those that a picture does without, and the shadow maps of the others.

use texmap_light::{Light, ShadowBias};
use texmap_math::glam::DVec3;
use texmap_scene::SceneError;

use texmap_math::wide;
use texmap_scene::shadow_fit::{fitting_size, shadow_bias, shadow_kind, texel_in_pixels};
use texmap_scene::{Mesh, Scene, Shading, Shadow};

/// A light that reaches nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct IdleLight {
    /// Index into [`Scene::lights`].
    pub light: usize,
    /// Reason why the light does nothing, in words.
    pub why: &'static str,
}

/// A shadow map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShadowChoice {
    /// Index into [`Scene::lights`].
    pub light: usize,
    /// Texels a side (of each face, for a point light): the scene's own, or about one for each pixel.
    pub size: u32,
    /// The scene's own, or the slope of the receiver over the filter.
    pub bias: ShadowBias,
    /// Predicted width of one of its texels at the middle of the scene, in pixels: the error of a shadow's edge.
    pub pixels: f64,
    /// True if the scene had set the size.
    pub fixed: bool,
}

/// Lights without colour, those in a scene without lit surfaces, and spot lights whose cone holds no lit surface.
pub(super) fn idle(scene: &Scene) -> Vec<IdleLight> {
    let lit: Vec<(DVec3, f64)> = scene
        .meshes
        .iter()
        .filter(|mesh| scene.materials[mesh.material].shading != Shading::Unlit)
        .filter_map(ball)
        .collect();
    let why = |light: &Light| {
        let (Light::Ambient { color }
        | Light::Directional { color, .. }
        | Light::Point { color, .. }
        | Light::Spot { color, .. }
        | Light::Punctual {
            intensity: color, ..
        }) = light
        else {
            return None;
        };
        if *color == [0.0; 3] {
            Some("it has no colour")
        } else if lit.is_empty() {
            Some("no surface is lit")
        } else if !lit.iter().any(|ball| may_reach(light, *ball)) {
            Some("no lit surface lies in its cone and range")
        } else {
            None
        }
    };
    let idle = scene.lights.iter().enumerate();
    idle.filter_map(|(light, l)| why(l).map(|why| IdleLight { light, why }))
        .collect()
}

/// Centre and radius, in the world, of a ball around the triangles of a mesh.
fn ball(mesh: &Mesh) -> Option<(DVec3, f64)> {
    let used = || {
        let corners = mesh.triangles.as_flattened().iter();
        corners.map(|&i| {
            let p = mesh.positions[i as usize].map(f64::from);
            mesh.world_from_object.transform_point3(DVec3::from(p))
        })
    };
    let (low, high) = used().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), p| {
        (l.min(p), h.max(p))
    });
    let centre = (low + high) * 0.5;
    let radius = used().map(|p| (p - centre).length()).reduce(f64::max)?;
    Some((centre, radius * (1.0 + 1e-6) + 1e-9))
}

/// The distance that a mesh keeps at least from a point; 0 for one without triangles.
pub(super) fn distance(mesh: &Mesh, point: DVec3) -> f64 {
    ball(mesh).map_or(0.0, |(centre, radius)| {
        ((centre - point).length() - radius).max(0.0)
    })
}

/// True if a light's cone and range may meet a ball.
fn may_reach(light: &Light, (centre, radius): (DVec3, f64)) -> bool {
    let (position, direction, cos_outer) = match *light {
        Light::Spot {
            position,
            direction,
            cos_outer,
            ..
        } => (position, direction, cos_outer),
        Light::Punctual {
            position,
            range,
            cone,
            ..
        } => {
            let way = (centre - wide(position)).length();
            // Distances are rounded to f32.
            if way - radius > f64::from(range) + 1e-5 * way {
                return false;
            }
            let Some(cone) = cone else { return true };
            (position, cone.direction, cone.cos_outer)
        }
        _ => return true,
    };
    let from = centre - wide(position);
    let axis = wide(direction);
    let axis = axis / axis.length();
    let cos = f64::from(cos_outer).clamp(-1.0, 1.0);
    if cos <= 0.0 || from.length() <= radius {
        return true;
    }
    // Distance of the centre from the cone's surface, by its half plane through the axis.
    let (along, sin) = (from.dot(axis), (1.0 - cos * cos).sqrt());
    let beside = (from.length_squared() - along * along).max(0.0).sqrt();
    // The cosine is rounded to f32.
    beside * cos - along * sin <= radius + 1e-5 * from.length()
}

/// The maps of the lights that stay.
pub(super) fn shadows(
    scene: &Scene,
    width: u32,
    idle: &[IdleLight],
) -> Result<Vec<ShadowChoice>, SceneError> {
    let stays = |s: &&Shadow| idle.iter().all(|l| l.light != s.light);
    let choose = |shadow: &Shadow| {
        let kind = shadow_kind(scene, shadow.light, shadow.area)?;
        let size = shadow
            .size
            .unwrap_or_else(|| fitting_size(scene, &kind, width));
        Ok(ShadowChoice {
            light: shadow.light,
            size,
            bias: shadow.bias.unwrap_or_else(|| shadow_bias(scene)),
            pixels: texel_in_pixels(scene, &kind, width) / f64::from(size),
            fixed: shadow.size.is_some(),
        })
    };
    scene
        .effects
        .shadows
        .iter()
        .filter(stays)
        .map(choose)
        .collect()
}

/// Takes idle lights out of a scene, with their shadow maps, and writes down the sizes of the others.
pub(super) fn apply(idle: &[IdleLight], shadows: &[ShadowChoice], scene: &mut Scene) {
    // Index of each light afterwards.
    let mut next = 0;
    let place: Vec<Option<usize>> = (0..scene.lights.len())
        .map(|light| {
            let stays = idle.iter().all(|l| l.light != light);
            next += usize::from(stays);
            stays.then(|| next - 1)
        })
        .collect();
    let of = |light: usize| place.get(light).copied().flatten();
    let mut kept = place.iter();
    scene
        .lights
        .retain(|_| kept.next().is_none_or(Option::is_some));
    scene.effects.shadows.retain(|s| of(s.light).is_some());
    for (shadow, choice) in scene.effects.shadows.iter_mut().zip(shadows) {
        (shadow.size, shadow.bias) = (Some(choice.size), Some(choice.bias));
        shadow.light = of(shadow.light).unwrap_or(shadow.light);
    }
    for material in &mut scene.materials {
        let baked = material.light_map.as_mut().and_then(|m| m.baked.as_mut());
        if let Some(lights) = baked {
            *lights = lights.iter().filter_map(|&l| of(l)).collect();
        }
    }
}

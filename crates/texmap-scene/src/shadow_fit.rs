//! Shadow maps fitted to a scene: the square, pyramid or cube of directions that a light sees, its size and its bias.

use texmap_light::{EnvironmentSample, Light, LightCone, ShadowBias, ShadowKind};
use texmap_math::camera::Camera;
use texmap_math::glam::{DMat4, DVec3};

use crate::{AlphaMode, Mesh, Scene, SceneError};
use texmap_math::wide;

/// Cosine and tangent of 85 degrees, half the widest pyramid.
const LEAST_COS: f64 = 0.087;
const MOST_TAN: f64 = 11.43;

/// The part of a scene that a shadow map of a light shows.
///
/// A directional light gets the square around everything that casts a shadow, or around `area` (a centre and half a side), a
/// spot light the pyramid around its outer cone, a point light all directions, or the pyramid that shows `area`.
///
/// # Errors
/// [`SceneError::Index`] for a light that does not exist, [`SceneError::Value`] for one that has no shadow map (ambient light, a
/// spot light of 85 degrees and more from its axis) or an area that is not finite and positive.
pub fn shadow_kind(
    scene: &Scene,
    light: usize,
    area: Option<(DVec3, f64)>,
) -> Result<ShadowKind, SceneError> {
    let place = || format!("shadow of light {light}");
    let value = |what: &str, value: String, expected| SceneError::Value {
        place: place(),
        what: what.to_owned(),
        value,
        expected,
    };
    let good = |centre: DVec3, half: f64| centre.is_finite() && half.is_finite() && half > 0.0;
    let bad_area = |centre: DVec3, half: f64| {
        value(
            "area",
            format!("{centre}, half a side {half}"),
            "it must be finite and of some size, and seen from a point light within 85 degrees of its centre",
        )
    };
    let source = scene.lights.get(light).ok_or(SceneError::Index {
        place: place(),
        what: "light",
        index: light as u64,
        count: scene.lights.len(),
    })?;
    match *source {
        Light::Directional { direction, .. } => {
            let (centre, half) = area.unwrap_or_else(|| bounding_square(scene));
            if !good(centre, half) {
                return Err(bad_area(centre, half));
            }
            Ok(ShadowKind::Directional {
                light_from_world: toward(centre, wide(direction)),
                half,
            })
        }
        Light::Point { position, .. }
        | Light::Punctual {
            position,
            cone: None,
            ..
        } => {
            let position = wide(position);
            let Some((centre, half)) = area else {
                return Ok(ShadowKind::Point { position });
            };
            let way = centre - position;
            if !(good(centre, half) && half < MOST_TAN * way.length()) {
                return Err(bad_area(centre, half));
            }
            Ok(ShadowKind::Spot {
                light_from_world: toward(position, way),
                tan_half: half / way.length(),
            })
        }
        Light::Spot {
            position,
            direction,
            cos_outer,
            ..
        }
        | Light::Punctual {
            position,
            cone:
                Some(LightCone {
                    direction,
                    cos_outer,
                    ..
                }),
            ..
        } => {
            let cos = f64::from(cos_outer);
            if cos < LEAST_COS {
                return Err(value(
                    "cosine of its outer cone",
                    cos.to_string(),
                    "a spot light with a shadow must stay within 85 degrees of its axis: make it a point light",
                ));
            }
            Ok(ShadowKind::Spot {
                light_from_world: toward(wide(position), wide(direction)),
                tan_half: (1.0 - cos * cos).sqrt() / cos,
            })
        }
        _ => Err(value(
            "kind",
            "ambient".to_owned(),
            "only directional, point and spot lights have shadows",
        )),
    }
}

/// Texels a side of the shadow map of a [sample of the environment](crate::Effects::environment_shadows), which is looked up without a filter:
/// the sum over samples is one.
pub const ENVIRONMENT_SHADOW_SIZE: u32 = 512;

/// The [samples](crate::Effects::environment_shadows) of the environment light that cast shadows, the part of the scene that the map of each
/// shows, and the bias of all: of the meshes that cast shadows. None where no surface is lit by the environment.
#[must_use]
pub fn environment_shadows(scene: &Scene) -> (Vec<(EnvironmentSample, ShadowKind)>, ShadowBias) {
    let casters = scene.meshes.iter().filter(|mesh| {
        let alpha = scene.materials[mesh.material].alpha;
        !mesh.casts_no_shadow && alpha != AlphaMode::Blend
    });
    let (centre, half) = square_around(casters.flat_map(Mesh::world_positions));
    let light = scene.effects.environment_light.as_ref();
    let light = light.filter(|_| scene.reads_environment());
    let samples = light.map(|light| light.samples(scene.effects.environment_shadows));
    let shadows = samples.into_iter().flatten().map(|sample| {
        let direction = -wide(sample.direction);
        let kind = ShadowKind::Directional {
            light_from_world: toward(centre, direction),
            half,
        };
        (sample, kind)
    });
    (shadows.collect(), bias_of(half))
}

/// Centre and half a side of a square that holds everything from any direction: of the ball around the box.
#[must_use]
pub fn bounding_square(scene: &Scene) -> (DVec3, f64) {
    square_around(world_positions(scene))
}

fn square_around(points: impl Iterator<Item = DVec3>) -> (DVec3, f64) {
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for p in points {
        (low, high) = (low.min(p), high.max(p));
    }
    if low.x > high.x {
        return (DVec3::ZERO, 1.0);
    }
    let half = 0.5 * (high - low).length();
    (
        0.5 * (low + high),
        if half > 0.0 { half * 1.001 } else { 1.0 },
    )
}

/// All vertices, world space.
pub fn world_positions(scene: &Scene) -> impl Iterator<Item = DVec3> + '_ {
    scene.meshes.iter().flat_map(Mesh::world_positions)
}

/// World to the space of a light at `position` that looks along `direction` (not zero).
fn toward(position: DVec3, direction: DVec3) -> DMat4 {
    let direction = direction / direction.abs().max_element();
    // The axis that is least along the direction cannot be parallel to it.
    let a = direction.abs();
    let up = if a.y <= a.x && a.y <= a.z {
        DVec3::Y
    } else if a.z <= a.x {
        DVec3::Z
    } else {
        DVec3::X
    };
    let camera = Camera {
        eye: DVec3::ZERO,
        look: direction,
        up,
        fov_x: 1.0,
        near: 1.0,
        far: 2.0,
        lens: Default::default(),
    };
    // Neither zero nor parallel, so there is a view.
    let view = camera.view().unwrap_or(DMat4::IDENTITY);
    view * DMat4::from_translation(-position)
}

/// The bias of shadows that name none: the planes of receiver and caster, and a constant of 1e-4 of the scene's size. It leaves neither
/// acne, at creases neither, nor light that leaks, with maps of `texmap_render::shadow_map_for`.
#[must_use]
pub fn shadow_bias(scene: &Scene) -> ShadowBias {
    bias_of(bounding_square(scene).1)
}

fn bias_of(half: f64) -> ShadowBias {
    ShadowBias::Planes(2e-4 * half)
}

/// Texels a side for about one texel a pixel, where the scene's middle is.
#[must_use]
pub fn fitting_size(scene: &Scene, kind: &ShadowKind, width: u32) -> u32 {
    let texels = texel_in_pixels(scene, kind, width).clamp(256.0, 4096.0);
    (texels / 64.0).ceil() as u32 * 64
}

/// Pixels that the one texel of a map of size 1 would be wide, where the scene's middle is.
#[must_use]
pub fn texel_in_pixels(scene: &Scene, kind: &ShadowKind, width: u32) -> f64 {
    let (centre, half) = bounding_square(scene);
    // The nearer half of the scene is what is looked at.
    let way = |from: DVec3| (from - centre).length().max(0.5 * half);
    let pixel = 2.0 * scene.camera.half_width(way(scene.camera.eye)) / f64::from(width);
    let side = match kind {
        ShadowKind::Directional { half, .. } => 2.0 * half,
        ShadowKind::Spot {
            light_from_world,
            tan_half,
        } => 2.0 * tan_half * way(light_from_world.inverse().transform_point3(DVec3::ZERO)),
        ShadowKind::Point { position } => 2.0 * way(*position),
    };
    side / pixel
}

/// True if a point lies inside of a closed mesh: a ray in an odd direction leaves through an odd number of triangles.
#[must_use]
pub fn encloses(mesh: &Mesh, point: DVec3) -> bool {
    let d = DVec3::new(0.612, 0.354, 0.709);
    let crossed = mesh.triangles.iter().filter(|t| {
        let [a, b, c] = t.map(|v| {
            mesh.world_from_object
                .transform_point3(wide(mesh.positions[v as usize]))
        });
        let (u, v) = (b - a, c - a);
        let p = d.cross(v);
        let (det, s) = (u.dot(p), point - a);
        let q = s.cross(u);
        let (x, y, t) = (s.dot(p) / det, d.dot(q) / det, v.dot(q) / det);
        x >= 0.0 && y >= 0.0 && x + y < 1.0 && t > 0.0
    });
    crossed.count() % 2 == 1
}

//! What a shadow map of a light shows of a scene: a square, a pyramid, or all directions.

use texmap_light::{Light, ShadowKind};
use texmap_math::camera::Camera;
use texmap_math::glam::{DMat4, DVec3};

use crate::vertices::wide;
use crate::{RenderError, Scene};

/// Cosine and tangent of 85 degrees, half the widest pyramid.
const LEAST_COS: f64 = 0.087;
const MOST_TAN: f64 = 11.43;

/// The part of a scene that a shadow map of a light shows.
///
/// A directional light gets the square around everything that casts a shadow, or around `area` (a centre and half a side), a
/// spot light the pyramid around its outer cone, a point light all directions, or the pyramid that shows `area`.
///
/// # Errors
/// [`RenderError::Index`] for a light that does not exist, [`RenderError::Value`] for one that has no shadow map (ambient light, a
/// spot light of 85 degrees and more from its axis) or an area that is not finite and positive.
pub fn shadow_kind(
    scene: &Scene,
    light: usize,
    area: Option<(DVec3, f64)>,
) -> Result<ShadowKind, RenderError> {
    let place = || format!("shadow of light {light}");
    let value = |what: &str, value: String, expected| RenderError::Value {
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
    let source = scene.lights.get(light).ok_or(RenderError::Index {
        place: place(),
        what: "light",
        index: light as u64,
        count: scene.lights.len(),
    })?;
    match *source {
        Light::Directional { direction, .. } => {
            let (centre, half) = area.unwrap_or_else(|| around(scene));
            if !good(centre, half) {
                return Err(bad_area(centre, half));
            }
            Ok(ShadowKind::Directional {
                light_from_world: toward(centre, wide(direction)),
                half,
            })
        }
        Light::Point { position, .. } => {
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

/// Centre and half a side of a square that holds everything from any direction: of the ball around the box.
pub(crate) fn around(scene: &Scene) -> (DVec3, f64) {
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for p in points(scene) {
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
pub(super) fn points(scene: &Scene) -> impl Iterator<Item = DVec3> + '_ {
    scene.meshes.iter().flat_map(|mesh| {
        mesh.positions
            .iter()
            .map(|p| mesh.world_from_object.transform_point3(wide(*p)))
    })
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
    };
    // Neither zero nor parallel, so there is a view.
    let view = camera.view().unwrap_or(DMat4::IDENTITY);
    view * DMat4::from_translation(-position)
}

#[cfg(test)]
mod tests {
    use super::super::shadow_map;
    use super::super::tests::scene;
    use super::*;

    #[test]
    fn lights_without_a_map_are_named() {
        let spot = Light::spot([1.0; 3], [0.0; 3], [0.0, -1.0, 0.0], 1.0, 1.5);
        let ambient = Light::Ambient { color: [1.0; 3] };
        for light in [spot, ambient] {
            let error = shadow_kind(&scene(light), 0, None).unwrap_err();
            assert!(error.to_string().contains("light 0"), "{error}");
        }
        assert!(matches!(
            shadow_kind(&scene(ambient), 3, None),
            Err(RenderError::Index { .. })
        ));
        let sun = Light::Directional {
            color: [1.0; 3],
            direction: [0.0, -1.0, 0.0],
        };
        assert!(shadow_kind(&scene(sun), 0, Some((DVec3::ZERO, 0.0))).is_err());
        let kind = shadow_kind(&scene(sun), 0, None).unwrap();
        assert!(matches!(
            shadow_map(&scene(sun), &kind, 0, 1),
            Err(RenderError::Raster { .. })
        ));
    }
}

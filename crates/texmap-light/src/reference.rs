//! The formulae of this crate in f64, one point at a time, written for reading. Finite input is assumed.

pub mod metallic_roughness;
mod tone_map;

pub use tone_map::tone_map;

use texmap_math::deterministic_f64;
use texmap_math::glam::DVec3;

use crate::{Light, LightCone, PhongMaterial};

/// Diffuse and highlight terms; see [`crate::lighting`].
#[must_use]
pub fn lighting(
    surface: &PhongMaterial,
    lights: &[Light],
    point: DVec3,
    normal: DVec3,
    eye: DVec3,
) -> (DVec3, DVec3) {
    let vector = |a: [f32; 3]| DVec3::new(a[0].into(), a[1].into(), a[2].into());
    let n = normal.normalize_or_zero();
    let v = (eye - point).normalize_or_zero();
    let (mut diffuse, mut highlight) = (DVec3::ZERO, DVec3::ZERO);
    for light in lights {
        let (color, l) = match *light {
            Light::Ambient { color } => {
                diffuse += vector(color) * f64::from(surface.ka);
                continue;
            }
            Light::Directional { color, direction } => (color, -vector(direction)),
            Light::Point { color, position } => (color, vector(position) - point),
            Light::Spot {
                color,
                position,
                direction,
                cos_inner,
                cos_outer,
            } => {
                let l = vector(position) - point;
                let axis = vector(direction).normalize_or_zero();
                let along = -axis.dot(l.normalize_or_zero());
                let (inner, outer) = (f64::from(cos_inner), f64::from(cos_outer));
                let x = if along >= inner {
                    1.0
                } else {
                    ((along - outer) / (inner - outer)).max(0.0)
                };
                (color.map(|c| c * (x * x * (3.0 - 2.0 * x)) as f32), l)
            }
            Light::Punctual {
                intensity,
                position,
                range,
                ref cone,
            } => {
                let l = vector(position) - point;
                let share = falloff(range, cone.as_ref(), l);
                (intensity.map(|c| (f64::from(c) * share) as f32), l)
            }
        };
        let l = l.normalize_or_zero();
        let n_l = n.dot(l);
        if n_l > 0.0 {
            let r = 2.0 * n_l * n - l;
            diffuse += vector(color) * f64::from(surface.kd) * n_l;
            let v_r = v.dot(r);
            if v_r > 0.0 {
                highlight += vector(color)
                    * f64::from(surface.ks)
                    * deterministic_f64::pow(v_r, f64::from(surface.ns));
            }
        }
    }
    (diffuse, highlight)
}

/// Falloff of a [`Light::Punctual`] for the vector from a point to the light. It is the factor of the intensity in candela.
#[must_use]
pub fn falloff(range: f32, cone: Option<&LightCone>, way: DVec3) -> f64 {
    let square = way.length_squared();
    let ratio = square / (f64::from(range) * f64::from(range));
    let window = (1.0 - ratio * ratio).max(0.0);
    let part = cone.map_or(1.0, |cone| {
        let axis = DVec3::from(cone.direction.map(f64::from)).normalize_or_zero();
        let along = -axis.dot(way.normalize_or_zero());
        let (inner, outer) = (f64::from(cone.cos_inner), f64::from(cone.cos_outer));
        ((along - outer) / (inner - outer).max(1e-3)).clamp(0.0, 1.0)
    });
    window * part * part / (core::f64::consts::PI * square.max(1e-12))
}

/// Colour clipped at 1; see [`crate::illuminate`].
#[must_use]
pub fn illuminate(
    surface: &PhongMaterial,
    lights: &[Light],
    point: DVec3,
    normal: DVec3,
    eye: DVec3,
) -> DVec3 {
    let (diffuse, highlight) = lighting(surface, lights, point, normal, eye);
    let base = DVec3::new(
        surface.color[0].into(),
        surface.color[1].into(),
        surface.color[2].into(),
    );
    (base * diffuse + highlight).min(DVec3::ONE)
}

use texmap_math::det32;

use crate::error::{LightError, same_length};
use crate::vector::{dot, normalize, scale, sub};
use crate::{Light, Surface};

/// Light that reaches the eye from one point, split so that a texture can stand in for the colour:
/// `base colour * diffuse + highlight`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Terms {
    /// `sum ka La + sum kd max(0, N.L) Ll`: multiplies the base colour.
    pub diffuse: [f32; 3],
    /// `sum ks max(0, V.R)^ns Ll`: added in the light's colour.
    pub highlight: [f32; 3],
}

impl Terms {
    /// The colour of a surface of this base colour, linear light, clipped at 1 per channel.
    #[must_use]
    pub fn color(&self, base: [f32; 3]) -> [f32; 3] {
        let channel = |i: usize| {
            let value = base[i] * self.diffuse[i] + self.highlight[i];
            if value < 1.0 { value } else { 1.0 }
        };
        [channel(0), channel(1), channel(2)]
    }
}

/// The two light terms at a point (the colour of `surface` is not read).
///
/// With N, L, V of unit length and `R = 2(N.L)N - L`:
/// `diffuse = sum_ambient ka La + sum kd max(0, N.L) Ll`, `highlight = sum ks max(0, V.R)^ns Ll`, where a
/// light behind the surface (`N.L <= 0`) gives neither. There is no attenuation. Source: MIT 6.837 (Fall
/// 2000), lecture 19, slides 20-22.
///
/// A zero or non-finite normal leaves the ambient light alone; a light or an eye that stands in the point
/// has no direction and gives nothing. Finite input of reasonable size (products within f32) gives finite
/// output; error against [`reference::terms`](crate::reference::terms) below 2e-5 for `ns <= 128` and
/// terms up to 1.
#[must_use]
pub fn terms(surface: &Surface, lights: &[Light], point: [f32; 3], normal: [f32; 3], eye: [f32; 3]) -> Terms {
    let normal = normalize(normal);
    let view = normalize(sub(eye, point));
    let mut sum = Terms::default();
    for light in lights {
        let (color, toward) = match *light {
            Light::Ambient { color } => {
                add(&mut sum.diffuse, color, surface.ka);
                continue;
            }
            Light::Directional { color, direction } => (color, scale(direction, -1.0)),
            Light::Point { color, position } => (color, sub(position, point)),
        };
        let toward = normalize(toward);
        let facing = dot(normal, toward);
        // Not `<=`: written so that a NaN gives nothing.
        if !(facing > 0.0) {
            continue;
        }
        add(&mut sum.diffuse, color, surface.kd * facing);
        if surface.ks > 0.0 {
            let mirrored = sub(scale(normal, 2.0 * facing), toward);
            let along = dot(view, mirrored);
            if along > 0.0 {
                add(&mut sum.highlight, color, surface.ks * det32::pow(along, surface.ns));
            }
        }
    }
    sum
}

/// Colour of a surface at a point: [`terms`] applied to its own colour, clipped at 1, linear light.
#[must_use]
pub fn illuminate(
    surface: &Surface,
    lights: &[Light],
    point: [f32; 3],
    normal: [f32; 3],
    eye: [f32; 3],
) -> [f32; 3] {
    terms(surface, lights, point, normal, eye).color(surface.color)
}

/// As [`illuminate`], but the side that the eye sees is lit: a normal that points away from the eye is
/// turned round first. For flat faces; on smooth meshes turn the normal by the facing of the triangle, as
/// a vertex normal may point away although its triangle is seen.
#[must_use]
pub fn illuminate_two_sided(
    surface: &Surface,
    lights: &[Light],
    point: [f32; 3],
    normal: [f32; 3],
    eye: [f32; 3],
) -> [f32; 3] {
    let away = dot(normal, sub(eye, point)) < 0.0;
    illuminate(surface, lights, point, if away { scale(normal, -1.0) } else { normal }, eye)
}

/// [`terms`] for every point of a slice: the same bits, entry by entry.
///
/// # Errors
/// [`LightError::Length`] unless `points`, `normals` and `out` have one length.
pub fn terms_slice(
    surface: &Surface,
    lights: &[Light],
    points: &[[f32; 3]],
    normals: &[[f32; 3]],
    eye: [f32; 3],
    out: &mut [Terms],
) -> Result<(), LightError> {
    same_length("points", points.len(), out.len())?;
    same_length("normals", normals.len(), out.len())?;
    for ((out, point), normal) in out.iter_mut().zip(points).zip(normals) {
        *out = terms(surface, lights, *point, *normal, eye);
    }
    Ok(())
}

/// [`illuminate`] for every point of a slice: the same bits, entry by entry.
///
/// # Errors
/// [`LightError::Length`] unless `points`, `normals` and `out` have one length.
pub fn illuminate_slice(
    surface: &Surface,
    lights: &[Light],
    points: &[[f32; 3]],
    normals: &[[f32; 3]],
    eye: [f32; 3],
    out: &mut [[f32; 3]],
) -> Result<(), LightError> {
    same_length("points", points.len(), out.len())?;
    same_length("normals", normals.len(), out.len())?;
    for ((out, point), normal) in out.iter_mut().zip(points).zip(normals) {
        *out = illuminate(surface, lights, *point, *normal, eye);
    }
    Ok(())
}

fn add(sum: &mut [f32; 3], color: [f32; 3], k: f32) {
    for (sum, color) in sum.iter_mut().zip(color) {
        *sum += color * k;
    }
}

//! Light of many points, in lanes.

use texmap_math::dispatch_simd;
use texmap_math::simd::Isa;

use super::sum_over_lights;
use crate::error::{LightError, same_length};
use crate::vector::{columns, load, splat};
use crate::{Light, Lighting, PhongMaterial, SpecularModel};

/// [`lighting`](super::lighting) for every point of a slice: the same bits, entry by entry.
///
/// # Errors
/// [`LightError::Length`] unless `points`, `normals` and `out` have one length.
pub fn lighting_slice(
    surface: &PhongMaterial,
    lights: &[Light],
    points: &[[f32; 3]],
    normals: &[[f32; 3]],
    eye: [f32; 3],
    out: &mut [Lighting],
) -> Result<(), LightError> {
    let count = out.len();
    each_point(
        surface,
        lights,
        (count, points, normals),
        eye,
        &mut |at, terms| {
            out[at] = terms;
        },
    )
}

/// [`illuminate`](super::illuminate) for every point of a slice: the same bits, entry by entry.
///
/// # Errors
/// [`LightError::Length`] unless `points`, `normals` and `out` have one length.
pub fn illuminate_slice(
    surface: &PhongMaterial,
    lights: &[Light],
    points: &[[f32; 3]],
    normals: &[[f32; 3]],
    eye: [f32; 3],
    out: &mut [[f32; 3]],
) -> Result<(), LightError> {
    let count = out.len();
    each_point(
        surface,
        lights,
        (count, points, normals),
        eye,
        &mut |at, terms| {
            out[at] = terms.color(surface.color);
        },
    )
}

/// [`lighting`](super::lighting) of `count` points, in lanes.
fn each_point(
    surface: &PhongMaterial,
    lights: &[Light],
    (count, points, normals): (usize, &[[f32; 3]], &[[f32; 3]]),
    eye: [f32; 3],
    put: &mut dyn FnMut(usize, Lighting),
) -> Result<(), LightError> {
    same_length("points", points.len(), count)?;
    same_length("normals", normals.len(), count)?;
    dispatch_simd!(crate::level(), i => blocks(i, surface, lights, points, normals, eye, put));
    Ok(())
}

#[inline(always)]
fn blocks<I: Isa>(
    i: I,
    surface: &PhongMaterial,
    lights: &[Light],
    points: &[[f32; 3]],
    normals: &[[f32; 3]],
    eye: [f32; 3],
    put: &mut dyn FnMut(usize, Lighting),
) {
    for first in (0..points.len()).step_by(I::LANES) {
        let (point, normal) = (load(i, points, first), load(i, normals, first));
        let phong = SpecularModel::Phong;
        let sum = sum_over_lights(
            i,
            surface,
            phong,
            lights,
            point,
            normal,
            eye,
            #[inline(always)]
            |_, _| splat(i, [1.0; 3]),
        );
        let (diffuse, highlight) = (columns(i, sum.diffuse), columns(i, sum.highlight));
        for lane in 0..I::LANES.min(points.len() - first) {
            let terms = Lighting {
                diffuse: diffuse.map(|c| c[lane]),
                highlight: highlight.map(|c| c[lane]),
            };
            put(first + lane, terms);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::illuminate;
    use super::super::tests::{SURFACE, vector};
    use super::*;
    use alloc::vec::Vec;

    #[test]
    fn slices_have_the_bits_of_the_scalar_form() {
        let mut seed = 7;
        let points: Vec<_> = (0..37).map(|_| vector(&mut seed)).collect();
        let normals: Vec<_> = (0..37).map(|_| vector(&mut seed)).collect();
        let lights = [Light::Point {
            color: [1.0; 3],
            position: [0.0, 2.0, 3.0],
        }];
        let eye = [0.0, 0.0, 4.0];
        let mut out = alloc::vec![[0.0; 3]; 37];
        illuminate_slice(&SURFACE, &lights, &points, &normals, eye, &mut out).unwrap();
        for i in 0..37 {
            assert_eq!(
                out[i],
                illuminate(&SURFACE, &lights, points[i], normals[i], eye)
            );
        }
        let mut short = [Lighting::default(); 3];
        let error = lighting_slice(
            &SURFACE,
            &lights,
            &points[..3],
            &normals[..2],
            eye,
            &mut short,
        );
        assert_eq!(
            error,
            Err(LightError::Length {
                what: "normals",
                found: 2,
                expected: 3
            })
        );
    }
}

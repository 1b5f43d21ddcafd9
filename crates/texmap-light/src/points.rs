//! The effects for one point: the kernels of [`lanes`](crate::lanes) at a width of one.

use texmap_math::dispatch_simd;
use texmap_math::simd::{Isa, Scalar};

use crate::error::{LightError, same_length};
use crate::lanes::{self, PowerLanes, RayLanes};
use crate::vector::{columns, load};
use crate::{Highlight, Light, Power, Ray, Share, Surface};

/// Unit vector; zero for a vector without a direction (zero or not finite). Off by 2 units in the last place.
#[must_use]
pub fn unit(a: [f32; 3]) -> [f32; 3] {
    lanes::unit(Scalar, a)
}

/// The mirrored view: `R = 2(N.V)N - V` for the direction V to the eye and a unit normal N. R has the length of V.
#[must_use]
pub fn reflect(view: [f32; 3], normal: [f32; 3]) -> [f32; 3] {
    lanes::reflect(view, normal)
}

/// [`reflect`] with the change of its result: `dR = 2 ((dN.V + N.dV) N + (N.V) dN) - dV`. `normal` holds a unit normal and the
/// change of the vector that it is the direction of, of length `length`: the part of that change across the normal turns it. (Igehy
/// 1999, Tracing Ray Differentials.)
#[must_use]
pub fn reflect_across(view: &Ray, normal: &Ray, length: f32) -> Ray {
    let ray = lanes::reflect_across(Scalar, &(*view).into(), &(*normal).into(), length);
    let RayLanes { direction, dx, dy } = ray;
    Ray { direction, dx, dy }
}

impl From<Ray> for RayLanes<Scalar> {
    fn from(Ray { direction, dx, dy }: Ray) -> Self {
        Self { direction, dx, dy }
    }
}

/// [`bump`](crate::bump()) on a surface with smooth normals: `n` is the unit normal of the shading, on the side that is seen, and stands
/// for the direction of `O_u x O_v`, whose length alone counts. Heights rise along `n`, whichever way u and v turn.
/// Parallel O_u and O_v give `n`.
#[must_use]
pub fn bump_on(n: [f32; 3], o_u: [f32; 3], o_v: [f32; 3], b_u: f32, b_v: f32) -> [f32; 3] {
    lanes::bump_on(Scalar, n, o_u, o_v, b_u, b_v)
}

/// A tangent-space normal on a surface: `x T + y B + z N` with `B = sign (N x T)` (MikkTSpace), unit length. The frame is
/// interpolated and not renormalised, as the map's baker expects. A frame or a normal without length gives `normal`.
#[must_use]
pub fn perturb(normal: [f32; 3], [x, y, z, sign]: [f32; 4], map: [f32; 3]) -> [f32; 3] {
    lanes::perturb(Scalar, normal, [x, y, z], sign, map)
}

/// [`perturb`] for every entry of a slice: the same bits.
///
/// # Errors
/// [`LightError::Length`] unless all slices have one length.
pub fn perturb_slice(
    normals: &[[f32; 3]],
    tangents: &[[f32; 4]],
    maps: &[[f32; 3]],
    out: &mut [[f32; 3]],
) -> Result<(), LightError> {
    same_length("normals", normals.len(), out.len())?;
    same_length("tangents", tangents.len(), out.len())?;
    same_length("map normals", maps.len(), out.len())?;
    dispatch_simd!(crate::level(), i => perturb_blocks(i, normals, tangents, maps, out));
    Ok(())
}

#[inline(always)]
fn perturb_blocks<I: Isa>(
    i: I,
    normals: &[[f32; 3]],
    tangents: &[[f32; 4]],
    maps: &[[f32; 3]],
    out: &mut [[f32; 3]],
) {
    for (block, out) in out.chunks_mut(I::LANES).enumerate() {
        let first = block * I::LANES;
        let [x, y, z, sign] = load(i, tangents, first);
        let (normal, map) = (load(i, normals, first), load(i, maps, first));
        let columns = columns(i, lanes::perturb(i, normal, [x, y, z], sign, map));
        for (lane, out) in out.iter_mut().enumerate() {
            *out = columns.map(|c| c[lane]);
        }
    }
}

/// A normal that a map has turned away from the eye, brought back to the horizon: the nearest direction with `N.V >= 0.01`
/// (case: black speckles on bumps seen at grazing angles). `view` points to the eye; others pass unchanged.
#[must_use]
pub fn clamp_to_horizon(normal: [f32; 3], view: [f32; 3]) -> [f32; 3] {
    let (n, v) = (unit(normal), unit(view));
    let clamped = clamp_unit_to_horizon(n, v);
    if clamped == n { normal } else { clamped }
}

/// [`clamp_to_horizon`] of vectors of unit length.
#[must_use]
pub fn clamp_unit_to_horizon(n: [f32; 3], v: [f32; 3]) -> [f32; 3] {
    lanes::clamp_to_horizon(Scalar, n, v)
}

/// The contribution of a light to a point; `None` for a light behind the surface, and one without light there. `normal` and `view`,
/// the direction to the eye, have unit length or are zero.
#[must_use]
pub fn share(
    surface: &Surface,
    power: Power,
    model: Highlight,
    light: &Light,
    point: [f32; 3],
    normal: [f32; 3],
    view: [f32; 3],
) -> Option<Share> {
    let power = PowerLanes::Same(power);
    let given = lanes::share(Scalar, surface, power, model, light, point, normal, view);
    given.lit.then_some(Share {
        color: given.color,
        diffuse: given.diffuse,
        highlight: given.highlight,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use alloc::vec::Vec;

    /// Frames and normals without length among them.
    #[test]
    fn slices_have_the_bits_of_one_point() {
        let vector = |i: usize| [3, 5, 7].map(|k| ((i * k) % 11) as f32 - 4.0);
        let normals: Vec<_> = (0..37).map(vector).collect();
        let maps: Vec<_> = (9..46).map(vector).collect();
        let tangents: Vec<_> = (0..37)
            .map(|i| {
                let [x, y, z] = vector(i + 5);
                [[x, y, z, 1.0], [x, -y, z, -1.0], [0.0; 4], [f32::NAN; 4]][i % 4]
            })
            .collect();
        let mut out = alloc::vec![[0.0; 3]; 37];
        perturb_slice(&normals, &tangents, &maps, &mut out).unwrap();
        for (i, out) in out.iter().enumerate() {
            assert_eq!(*out, perturb(normals[i], tangents[i], maps[i]), "{i}");
        }
        assert!(perturb_slice(&normals[1..], &tangents, &maps, &mut out).is_err());
    }
}

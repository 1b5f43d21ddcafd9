//! The effects for one point: the kernels of [`lanes`](crate::lanes) at a width of one.

use texmap_math::dispatch_simd;
use texmap_math::simd::{Isa, Scalar};

use crate::error::{LightError, same_length};
use crate::lanes::{self, LightContributionLanes, RayLanes, SpecularExponentLanes, TermsLanes};
use crate::vector::{columns, load};
use crate::{Light, PhongMaterial, SpecularExponent, SpecularModel};

/// A direction and its change for one pixel to the right and one down.
pub type Ray = RayLanes<Scalar>;

/// The contribution of one light to a point: `color * diffuse` to the diffuse term, `color * highlight` to the highlight.
pub type LightContribution = LightContributionLanes<Scalar>;

/// Light that reaches the eye from one point, split so that a texture can stand in for the colour:
/// `base colour * diffuse + highlight`.
pub type Lighting = TermsLanes<Scalar>;

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
    lanes::reflect_across(Scalar, view, normal, length)
}

/// [`bump`](crate::bump()) on a surface with smooth normals: `n` is the unit normal of the shading, and stands
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
pub fn evaluate_light(
    surface: &PhongMaterial,
    power: SpecularExponent,
    model: SpecularModel,
    light: &Light,
    point: [f32; 3],
    normal: [f32; 3],
    view: [f32; 3],
) -> Option<LightContribution> {
    let power = SpecularExponentLanes::Same(power);
    let given = lanes::evaluate_light(Scalar, surface, power, model, light, point, normal, view);
    given.lit.then_some(given)
}

#[cfg(test)]
mod tests {
    use super::*;
    use alloc::vec::Vec;
    use texmap_math::Projector;
    use texmap_math::glam::DVec3;
    use texmap_math::simd::prelude::*;
    use texmap_sample::{ColorSpace, Origin, Sampler, Texture2d};

    use crate::lanes::Vector;
    use crate::{
        BoundProjectorTexture, NormalMap, NormalMapGreen, ProjectorBorder, ProjectorTexture,
    };

    /// Vectors of all lengths, some without a direction.
    fn vector(i: usize) -> [f32; 3] {
        match i % 13 {
            0 => [0.0; 3],
            1 => [f32::NAN, 1.0, 0.0],
            2 => [3e-25, -2e-26, 0.0],
            n => [3, 5, 7].map(|k| ((i * k) % 11) as f32 * 0.3 - 0.1 * n as f32),
        }
    }

    /// The results of every effect, vector by vector.
    const RESULTS: usize = 37;

    #[inline(always)]
    fn every_effect<I: Isa>(
        i: I,
        first: usize,
        slides: &[BoundProjectorTexture<'_>],
        out: &mut [Vec<f32>],
    ) {
        let all: [_; 96] = core::array::from_fn(vector);
        let v = |k: usize| load(i, &all[k * 5..], first);
        let (p, n, t, d) = (v(0), lanes::unit(i, v(1)), v(2), v(3));
        let eye = lanes::unit(i, v(4));
        let mut results = Vec::new();
        let view = RayLanes {
            direction: p,
            dx: d,
            dy: t,
        };
        let normal = RayLanes {
            direction: n,
            dx: t,
            dy: d,
        };
        let ray = lanes::reflect_across(i, &view, &normal, p[0]);
        results.extend([
            ray.direction,
            ray.dx,
            ray.dy,
            lanes::clamp_to_horizon(i, n, eye),
        ]);
        results.push(lanes::bump_on(i, n, t, d, p[1], p[2]));
        for (green, rebuild_z) in [(NormalMapGreen::Up, false), (NormalMapGreen::Down, true)] {
            let map = NormalMap {
                green,
                rebuild_z,
                strength: 1.5,
            };
            results.push(map.apply(i, n, t, p[0], d));
        }
        let color = [0.9, 0.4, 0.0];
        let (position, direction) = ([0.3, 0.2, 1.5], [0.1, -0.2, -1.0]);
        for light in [
            Light::Ambient { color },
            Light::Directional { color, direction },
            Light::Directional {
                color: [0.0; 3],
                direction,
            },
            Light::Point { color, position },
            Light::spot(color, position, direction, 0.4, 0.9),
            Light::Punctual {
                intensity: color,
                position,
                range: 4.0,
                cone: Some(crate::LightCone::new(direction, 0.4, 0.9)),
            },
        ] {
            for (model, ns) in [(SpecularModel::Phong, 5.0), (SpecularModel::Blinn, 7.3)] {
                let (power, surface) = (
                    SpecularExponentLanes::Same(SpecularExponent::new(ns)),
                    PhongMaterial::default(),
                );
                let given = lanes::evaluate_light(i, &surface, power, model, &light, p, n, eye);
                let mut sum = TermsLanes::dark(i);
                sum.add(&given, given.lit, d);
                results.extend([sum.diffuse, sum.highlight]);
            }
        }
        for slide in slides {
            let places = slide.uv_at(i, p);
            let fade = places.reached.select(places.fade, i.f32(-1.0));
            let change = slide.changes(i, &places, d);
            results.push([places.uv[0], places.uv[1], fade]);
            results.push([change[0], change[1], fade]);
        }
        put(i, &results, out);
    }

    fn put<I: Isa>(i: I, results: &[Vector<I>], out: &mut [Vec<f32>]) {
        assert_eq!(results.len(), RESULTS);
        for (result, out) in results.iter().zip(out) {
            let columns = columns(i, *result);
            for lane in 0..I::LANES {
                out.extend(columns.map(|c| c[lane]));
            }
        }
    }

    /// Every width gives the bits of one point.
    #[test]
    fn widths_agree() {
        let texels = (0..64u8).map(|i| i.wrapping_mul(77)).collect();
        let texture = Texture2d::from_rgba8(4, 4, texels, ColorSpace::Linear, Origin::TopLeft);
        let (texture, sampler) = (texture.unwrap(), Sampler::default());
        let projector = Projector::new(DVec3::ZERO, DVec3::Z, DVec3::Y, 1.5, 1.0).unwrap();
        let borders = [
            ProjectorBorder::Black,
            ProjectorBorder::Clamp,
            ProjectorBorder::Repeat,
        ];
        let slides = borders.map(|border| {
            BoundProjectorTexture::new(&ProjectorTexture {
                projector,
                texture: &texture,
                sampler: &sampler,
                border,
                softness: 0.2,
            })
        });
        let run = |each: &mut dyn FnMut(&mut [Vec<f32>])| {
            let mut out = alloc::vec![Vec::new(); RESULTS];
            each(&mut out);
            let bits = |c: &f32| if c.is_nan() { u32::MAX } else { c.to_bits() };
            let all = out.iter().map(|c| c.iter().map(bits).collect());
            all.collect::<Vec<Vec<u32>>>()
        };
        let one = run(&mut |out| {
            for first in 0..64 {
                every_effect(Scalar, first, &slides, out);
            }
        });
        every_width!(i => {
            let got = run(&mut |out| blocks(i, &slides, out));
            assert_eq!(got, one);
        });
        fn blocks<I: Isa>(i: I, slides: &[BoundProjectorTexture<'_>], out: &mut [Vec<f32>]) {
            for first in (0..64).step_by(I::LANES) {
                every_effect(i, first, slides, out);
            }
        }
    }

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

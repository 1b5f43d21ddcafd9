//! Normal maps on tangent frames, for one point and for sixteen.

use texmap_math::fearless_simd::{Simd, f32x16, mask32x16, prelude::*};
use texmap_math::float::sqrt_f32;

use crate::error::{LightError, same_length};
use crate::lanes::V3;
use crate::vector::{dot, dot_lanes, scale, sub, unit, unit_lanes};
use crate::{Green, bump::cross};

/// How the texels of a tangent-space normal map are read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NormalMap {
    /// Which way the green channel points.
    pub green: Green,
    /// Only red and green are stored.
    pub rebuild_z: bool,
    /// Multiplies x and y; 1 is the map as it is.
    pub strength: f32,
}

impl NormalMap {
    /// The direction that a texel of 0..=1 per channel holds, of any length.
    #[must_use]
    pub fn decode(&self, texel: [f32; 3]) -> [f32; 3] {
        let [x, y, z] = texel.map(|c| 2.0 * c - 1.0);
        let y = if self.green == Green::Up { y } else { -y };
        let z = if self.rebuild_z {
            let left = 1.0 - x * x - y * y;
            if left > 0.0 { sqrt_f32(left) } else { 0.0 }
        } else {
            z
        };
        [x * self.strength, y * self.strength, z]
    }

    /// The unit normal that a texel turns a unit `normal` to: [`perturb`] by what it holds.
    #[must_use]
    pub fn turn(&self, normal: [f32; 3], tangent: [f32; 4], texel: [f32; 3]) -> [f32; 3] {
        perturb(normal, tangent, self.decode(texel))
    }

    /// [`decode`](Self::decode) for sixteen.
    #[inline(always)]
    pub fn decode_lanes<S: Simd>(&self, s: S, texel: V3<S>) -> V3<S> {
        let zero = f32x16::splat(s, 0.0);
        let x = texel[0] * 2.0 - 1.0;
        let y = texel[1] * 2.0 - 1.0;
        let y = if self.green == Green::Up { y } else { -y };
        let z = if self.rebuild_z {
            let left = 1.0 - x * x - y * y;
            let some = left.simd_gt(zero);
            some.select(some.select(left, zero).sqrt(), zero)
        } else {
            texel[2] * 2.0 - 1.0
        };
        [x * self.strength, y * self.strength, z]
    }

    /// [`turn`](Self::turn) for sixteen; `sign` is the tangent's fourth component.
    #[inline(always)]
    pub fn turn_lanes<S: Simd>(
        &self,
        s: S,
        normal: V3<S>,
        tangent: V3<S>,
        sign: f32x16<S>,
        texel: V3<S>,
    ) -> V3<S> {
        let zero = f32x16::splat(s, 0.0);
        let [x, y, z] = self.decode_lanes(s, texel);
        let (n, t) = (normal, tangent);
        let b = [
            (n[1] * t[2] - n[2] * t[1]) * sign,
            (n[2] * t[0] - n[0] * t[2]) * sign,
            (n[0] * t[1] - n[1] * t[0]) * sign,
        ];
        let mut turned = n;
        for i in 0..3 {
            turned[i] = x * t[i] + y * b[i] + z * n[i];
        }
        let mut turned = unit_lanes(s, turned);
        let none = is_zero(zero, turned);
        let flat = x.simd_eq(zero) & y.simd_eq(zero);
        let useless = none | (is_zero(zero, t) & !flat);
        if useless.any_true() {
            let smooth = unit_lanes(s, n);
            for i in 0..3 {
                turned[i] = useless.select(smooth[i], turned[i]);
            }
        }
        turned
    }
}

#[inline(always)]
pub(crate) fn is_zero<S: Simd>(zero: f32x16<S>, v: V3<S>) -> mask32x16<S> {
    v[0].simd_eq(zero) & v[1].simd_eq(zero) & v[2].simd_eq(zero)
}

/// A tangent-space normal on a surface: `x T + y B + z N` with `B = sign (N x T)` (MikkTSpace), unit length. The frame is
/// interpolated and not renormalised, as the map's baker expects. A frame or a normal without length gives `normal`.
#[must_use]
pub fn perturb(normal: [f32; 3], tangent: [f32; 4], map: [f32; 3]) -> [f32; 3] {
    let [tx, ty, tz, sign] = tangent;
    let t = [tx, ty, tz];
    let b = scale(cross(normal, t), sign);
    let n = unit([0, 1, 2].map(|i| map[0] * t[i] + map[1] * b[i] + map[2] * normal[i]));
    let usable = n != [0.0; 3] && (t != [0.0; 3] || (map[0] == 0.0 && map[1] == 0.0));
    if usable { n } else { unit(normal) }
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
    for (i, out) in out.iter_mut().enumerate() {
        *out = perturb(normals[i], tangents[i], maps[i]);
    }
    Ok(())
}

/// Least cosine between a normal and the direction to the eye.
const LEAST: f32 = 0.01;

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
    let along = dot(n, v);
    if along >= LEAST || v == [0.0; 3] {
        return n;
    }
    let flat = unit(sub(n, scale(v, along)));
    let rest = sqrt_f32(1.0 - LEAST * LEAST);
    [0, 1, 2].map(|i| flat[i] * rest + v[i] * LEAST)
}

/// [`clamp_unit_to_horizon`] for sixteen.
#[inline(always)]
pub fn clamp_to_horizon_lanes<S: Simd>(s: S, n: V3<S>, v: V3<S>) -> V3<S> {
    let zero = f32x16::splat(s, 0.0);
    let along = dot_lanes(n, v);
    let fine = along.simd_ge(LEAST) | is_zero(zero, v);
    if fine.all_true() {
        return n;
    }
    let mut flat = n;
    for i in 0..3 {
        flat[i] = n[i] - v[i] * along;
    }
    let flat = unit_lanes(s, flat);
    let rest = sqrt_f32(1.0 - LEAST * LEAST);
    let mut out = n;
    for i in 0..3 {
        out[i] = fine.select(n[i], flat[i] * rest + v[i] * LEAST);
    }
    out
}

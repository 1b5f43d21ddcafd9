//! Normal maps on tangent frames.

use texmap_math::float::sqrt_f32;
use texmap_math::simd::{Isa, prelude::*};

use crate::NormalMapGreen;
use crate::lanes::Vector;
use crate::vector::{cross, dot, is_zero, scale, select, sub, unit};

/// Format of the texels of a tangent-space normal map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NormalMap {
    /// Direction of the green channel.
    pub green: NormalMapGreen,
    /// Only red and green are stored.
    pub rebuild_z: bool,
    /// Multiplies x and y; 1 is the map as it is.
    pub strength: f32,
}

impl NormalMap {
    /// The direction that a texel of 0..=1 per channel holds, of any length.
    #[inline(always)]
    #[must_use]
    pub fn decode<I: Isa>(&self, i: I, texel: Vector<I>) -> Vector<I> {
        let x = texel[0] * 2.0 - 1.0;
        let y = texel[1] * 2.0 - 1.0;
        let y = if self.green == NormalMapGreen::Up {
            y
        } else {
            -y
        };
        let z = if self.rebuild_z {
            let left = i.f32(1.0) - x * x - y * y;
            left.above(i.f32(0.0)).sqrt()
        } else {
            texel[2] * 2.0 - 1.0
        };
        [x * self.strength, y * self.strength, z]
    }

    /// The unit normal that a texel turns a unit `normal` to. It is [`perturb`](crate::perturb) by the texel's direction. `sign` is the
    /// tangent's fourth component.
    #[inline(always)]
    #[must_use]
    pub fn apply<I: Isa>(
        &self,
        i: I,
        normal: Vector<I>,
        tangent: Vector<I>,
        sign: I::F32,
        texel: Vector<I>,
    ) -> Vector<I> {
        perturb(i, normal, tangent, sign, self.decode(i, texel))
    }
}

/// A tangent-space normal on a surface, unit length: see [`crate::perturb`]. `sign` is the tangent's fourth component.
#[inline(always)]
pub fn perturb<I: Isa>(
    i: I,
    normal: Vector<I>,
    tangent: Vector<I>,
    sign: I::F32,
    [x, y, z]: Vector<I>,
) -> Vector<I> {
    let bitangent = scale(cross(normal, tangent), sign);
    let mut turned = normal;
    for k in 0..3 {
        turned[k] = x * tangent[k] + y * bitangent[k] + z * normal[k];
    }
    let turned = unit(i, turned);
    let flat = x.simd_eq(0.0) & y.simd_eq(0.0);
    let useless = is_zero(i, turned) | (is_zero(i, tangent) & !flat);
    if useless.any_true() {
        select(useless, unit(i, normal), turned)
    } else {
        turned
    }
}

/// Least cosine between a normal and the direction to the eye.
const LEAST: f32 = 0.01;

/// Unit normals brought back to the horizon of the unit directions `v` to the eye: see [`crate::clamp_to_horizon`].
#[inline(always)]
pub fn clamp_to_horizon<I: Isa>(i: I, n: Vector<I>, v: Vector<I>) -> Vector<I> {
    let along = dot(n, v);
    let fine = along.simd_ge(LEAST) | is_zero(i, v);
    if fine.all_true() {
        return n;
    }
    let flat = unit(i, sub(n, scale(v, along)));
    let rest = sqrt_f32(1.0 - LEAST * LEAST);
    let mut out = n;
    for k in 0..3 {
        out[k] = fine.select(n[k], flat[k] * rest + v[k] * LEAST);
    }
    out
}

//! Microfacet lobes in lanes. Cosines are within 0 to 1, those of directions above 0.

use core::f32::consts::{FRAC_1_PI, LOG2_E, TAU};

use texmap_math::deterministic_f32;
use texmap_math::simd::{Isa, prelude::*};

/// `D(H) V(L, V) (N.L)` of GGX with height-correlated Smith: `nh` is the cosine of the half vector, `sine` the square of its sine.
#[inline(always)]
pub(super) fn ggx<I: Isa>(
    i: I,
    alpha: I::F32,
    nh: I::F32,
    sine: I::F32,
    nv: I::F32,
    nl: I::F32,
) -> I::F32 {
    let a2 = alpha * alpha;
    let k = alpha / (sine + nh * nh * a2);
    let rest = i.f32(1.0) - a2;
    let v = nl * (nv * nv * rest + a2).sqrt();
    let l = nv * (nl * nl * rest + a2).sqrt();
    k * k * nl * (0.5 * FRAC_1_PI) / (v + l)
}

/// `D(H) V(L, V) (N.L)` of Charlie's cloth.
#[inline(always)]
pub(super) fn charlie<I: Isa>(i: I, alpha: I::F32, sine: I::F32, nv: I::F32, nl: I::F32) -> I::F32 {
    let one = i.f32(1.0);
    let inverse = one / alpha;
    // Powers of zero are zero.
    let sine = sine.above(i.f32(1e-30));
    let power = deterministic_f32::pow_lanes(i, sine, inverse * 0.5);
    let d = (inverse + 2.0) * power * (1.0 / TAU);
    let lambda = one + shadowing(i, alpha, nv) + shadowing(i, alpha, nl);
    let v = one / (lambda * nv * nl * 4.0);
    d * v.below(one) * nl
}

/// Smith's lambda of Charlie's cloth, fitted by Estevez and Kulla.
#[inline(always)]
fn shadowing<I: Isa>(i: I, alpha: I::F32, cosine: I::F32) -> I::F32 {
    let t = i.f32(1.0) - alpha;
    let t = t * t;
    // Parameters of the fit at both ends of the roughness, and between them.
    let (a, b, c) = (
        t * (25.3245 - 21.5473) + 21.5473,
        t * (3.324_35 - 3.829_87) + 3.829_87,
        t * (0.168_01 - 0.198_23) + 0.198_23,
    );
    let (d, e) = (
        t * (-1.273_93 - -1.977_60) + -1.977_60,
        t * (-4.859_67 - -4.320_54) + -4.320_54,
    );
    let numbers = [a, b, c, d, e];
    let near = cosine.simd_lt(0.5);
    let one = fit(i, numbers, near.select(cosine, i.f32(1.0) - cosine));
    let exponent = near.select(one, fit(i, numbers, i.f32(0.5)) * 2.0 - one);
    deterministic_f32::exp2_lanes(i, exponent * LOG2_E)
}

#[inline(always)]
fn fit<I: Isa>(i: I, [a, b, c, d, e]: [I::F32; 5], x: I::F32) -> I::F32 {
    let power = deterministic_f32::pow_lanes(i, x.above(i.f32(1e-30)), c);
    a / (b * power + 1.0) + d * x + e
}

/// `x^5`.
#[inline(always)]
pub(crate) fn power5<I: Isa>(_: I, x: I::F32) -> I::F32 {
    let square = x * x;
    square * square * x
}

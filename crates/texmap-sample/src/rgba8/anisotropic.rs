//! Bilinear probes along the long axis of the footprint, on one mip level.

use super::{bilinear::bilinear_in, limited};
use crate::{
    address::{
        lod::{TexelFootprint, log2_sqrt_fixed},
        texel::LaneLevel,
    },
    bound_texture::BoundTexture,
    filter::{ByteKernel, LookUp},
};
use texmap_math::simd::{ByteIsa, Isa, prelude::*};

pub(crate) struct Anisotropic;

impl ByteKernel for Anisotropic {
    const WIDE: bool = false;

    #[inline(always)]
    fn word<I: ByteIsa>(i: I, view: &BoundTexture<'_>, at: &LookUp<I>) -> I::U32 {
        let [u, v] = at.uv;
        match &at.footprint {
            Some(d) => anisotropic(i, view, u, v, d),
            None => i.u32(0),
        }
    }
}

/// Squared ratio of axes, in quarter octaves of the ratio, to the number of probes.
static PROBES: [u32; 16] = [1, 2, 2, 2, 2, 3, 3, 4, 4, 5, 6, 7, 8, 10, 12, 16];
/// 256 log2 of the number of probes, from 1 on.
static PROBE_LEVELS: [u32; 16] = [
    0, 256, 406, 512, 594, 662, 719, 768, 811, 850, 886, 918, 947, 975, 1000, 1024,
];

/// `1 / sqrt(x)` within 0.2 %: the float's bits halved, and one Newton step.
#[inline(always)]
fn rsqrt<I: Isa>(i: I, x: I::F32) -> I::F32 {
    let y = (i.u32(0x5f37_59df) - (x.to_bits() >> 1)).to_f32_bits();
    y * (i.f32(1.5) - x * 0.5 * y * y)
}

/// The mean of probes. The axes are those of `Axes`, by cheaper roots.
#[inline(always)]
pub fn anisotropic<I: ByteIsa>(
    i: I,
    view: &BoundTexture<'_>,
    u: I::F32,
    v: I::F32,
    d: &TexelFootprint<I>,
) -> I::U32 {
    let p = d.ux * d.ux + d.uy * d.uy;
    let r = d.vx * d.vx + d.vy * d.vy;
    // If the squares of both axes add up to less than one (and the 0.2 % of the root below) in all lanes, there is one probe on
    // level 0.
    if view.plain_lod && (p + r).simd_lt(0.99).all_true() {
        let level = LaneLevel::uniform(i, view, 0);
        return i.words(bilinear_in(i, view, &level, [u, v]));
    }
    let q = d.ux * d.vx + d.uy * d.vy;
    let half = (p - r) * 0.5;
    let square = half * half + q * q;
    let root = square * rsqrt(i, square);
    let major2 = (p + r) * 0.5 + root;
    let magnified = !major2.simd_gt(1.0);
    let log_major = log2_sqrt_fixed(i, major2);
    let det = d.ux * d.vy - d.uy * d.vx;
    // ratio^2 = major2 / minor2 = major2^2 / det^2, in fixed-point logarithms of lengths; a short axis below a texel counts as one.
    let ratio = (log_major << 1) - log2_sqrt_fixed(i, det * det);
    let ratio = ratio.simd_lt(log_major).select(ratio, log_major);
    let slot = ratio.simd_lt(0).select(i.i32(0), ratio >> 6);
    let slot = slot.simd_gt(15).select(i.i32(15), slot);
    let most = i.i32(i32::from(view.most));
    let count = i.table16(&PROBES, slot.to_u32()).to_i32();
    let count = count.simd_lt(most).select(count, most);
    let count = magnified.select(i.i32(1), count);
    let level_drop = i.table16(&PROBE_LEVELS, (count - 1).to_u32()).to_i32();
    let steep = !half.simd_ge(0.0);
    let x = steep.select(q, half + root);
    let y = steep.select(root - half, q);
    let length2 = x * x + y * y;
    // The square of what probes are spread over, as the exact filter has it.
    let along2 = ((p + r) - 1.0).below(major2).above(i.f32(0.0));
    let k = along2 * rsqrt(i, along2) * rsqrt(i, length2);
    let n = count.to_f32();
    let share = i.f32(1.0) / n;
    let (w, h) = view.size();
    let step_u = x * k * share * (1.0 / w as f32);
    let step_v = y * k * share * (1.0 / h as f32);
    let lod = limited(i, view, log_major - level_drop);
    let level = (lod + 128) >> 8;
    let level = level.simd_lt(0).select(i.i32(0), level);
    let top = i.i32(view.last);
    let level = level.simd_gt(top).select(top, level);
    let first = (i.f32(1.0) - n) * 0.5;
    let level = LaneLevel::of(i, view, level);
    let mut sum = i.bytes(i.u32(0));
    let mut k = 0;
    loop {
        let active = count.simd_gt(k);
        if !active.any_true() {
            break;
        }
        let at = first + k as f32;
        let c = bilinear_in(i, view, &level, [u + step_u * at, v + step_v * at]);
        sum = i.add_bytes(sum, c, active);
        k += 1;
    }
    let [r, g, b, a] = i.byte_sums(sum);
    mean::<I>(r, share)
        | (mean::<I>(g, share) << 8)
        | (mean::<I>(b, share) << 16)
        | (mean::<I>(a, share) << 24)
}

#[inline(always)]
fn mean<I: Isa>(sum: I::U32, share: I::F32) -> I::U32 {
    (sum.to_i32().to_f32() * share + 0.5).to_i32().to_u32()
}

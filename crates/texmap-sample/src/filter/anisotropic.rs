//! Trilinear probes along the long axis of the footprint.

use super::{FilterKernel, Input, LookUp, trilinear::LevelPair};
use crate::{
    address::lod::{TexelFootprint, log2},
    bound_texture::{ANY, BoundTexture},
    fetch::{Color, scaled, select},
    sampler::Precision,
};
use texmap_math::simd::{Isa, prelude::*};

/// Probes a short axis. One a short axis blurs noise and letters, since bilinear filtering reaches over two texels of a level; 1.3 aliases
/// checkers. `test_oiio_anisotropic.py` of the Python module holds it against elliptical filters.
const DENSITY: f32 = 1.1;

/// Axes of the ellipse that a unit circle of pixels maps to.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Axes<I: Isa> {
    /// The long half axis as a vector in texels.
    pub(crate) major: [I::F32; 2],
    /// Squared half axes in texels.
    pub(crate) major2: I::F32,
    pub(crate) minor2: I::F32,
    /// The sum of both squared half axes, without the rounding of either.
    trace: I::F32,
}

impl<I: Isa> Axes<I> {
    /// The singular values of the Jacobian (Heckbert 1989, section 3.5.9). The columns of a sheared
    /// Jacobian are not the axes. `J J^T = [p q; q r]`.
    #[inline(always)]
    pub(crate) fn new(i: I, d: &TexelFootprint<I>) -> Self {
        let zero = i.f32(0.0);
        let p = d.ux * d.ux + d.uy * d.uy;
        let r = d.vx * d.vx + d.vy * d.vy;
        let q = d.ux * d.vx + d.uy * d.vy;
        let half = (p - r) * 0.5;
        let root = (half * half + q * q).sqrt();
        let trace = p + r;
        let major2 = trace * 0.5 + root;
        // The determinant gives the short axis without the cancellation of mean - root.
        let det = d.ux * d.vy - d.uy * d.vx;
        let minor2 = major2.simd_gt(0.0).select(det * (det / major2), zero);
        // An eigenvector from the better conditioned row.
        let steep = !half.simd_ge(0.0);
        let x = steep.select(q, half + root);
        let y = steep.select(root - half, q);
        let length2 = x * x + y * y;
        let length = major2.sqrt();
        let along = length2.simd_gt(0.0);
        let k = length / length2.sqrt();
        Self {
            major: [along.select(x * k, length), along.select(y * k, zero)],
            major2,
            minor2,
            trace,
        }
    }

    /// Number of probes of a round filter that cover the ellipse, at most `most`: [`DENSITY`] for each short axis by which the long one
    /// exceeds the first, but no more than one a texel. A probe is a texel wide at least, so that a short axis below a texel counts as one.
    #[inline(always)]
    pub(crate) fn probes(&self, i: I, most: u8) -> I::F32 {
        let (one, most) = (i.f32(1.0), i.f32(f32::from(most)));
        let minor2 = self.minor2.simd_gt(1.0).select(self.minor2, one);
        let ratio = (self.major2 / minor2).sqrt();
        let n = ratio * DENSITY + (1.0 - DENSITY);
        let length = self.major2.sqrt();
        let n = n.simd_lt(length).select(n, length);
        let n = n.simd_lt(most).select(n, most);
        let n = (-(-n).floor_to_i32()).to_f32();
        n.simd_gt(1.0).select(n, one)
    }

    /// The share of the long axis that probes are spread over. A bilinear probe on level 0 blurs as much as a pixel of one texel does
    /// (in twelfths of a squared texel, variance 2 against `1 + axis^2`); what a shorter short axis has too much of it, `1 - minor^2`, is
    /// taken off the square of the long one.
    #[inline(always)]
    fn spread(&self, i: I) -> I::F32 {
        let share = (self.trace - 1.0) / self.major2;
        let share = share.simd_gt(0.0).select(share, i.f32(0.0));
        share.simd_lt(1.0).select(share, i.f32(1.0)).sqrt()
    }
}

/// Box-weighted trilinear probes along the true long axis of the footprint. This is EXT_texture_filter_anisotropic with the
/// orthogonalised footprint that the Direct3D 11.3 specification asks for. Probes that would be less than a texel apart are
/// fewer.
pub(crate) struct Anisotropic;

impl FilterKernel for Anisotropic {
    const FORMAT: u8 = ANY;
    const INPUT: Input = Input::Footprint;

    #[inline(always)]
    fn color<I: Isa>(i: I, view: &BoundTexture<'_>, at: &LookUp<I>, _: I::F32) -> Color<I> {
        let Some(d) = &at.footprint else {
            return [i.f32(0.0); 4];
        };
        let [u, v] = at.uv;
        anisotropic::<I, ANY>(i, view, u, v, d)
    }
}

/// The mean of probes.
#[inline(always)]
pub fn anisotropic<I: Isa, const FORMAT: u8>(
    i: I,
    view: &BoundTexture<'_>,
    u: I::F32,
    v: I::F32,
    d: &TexelFootprint<I>,
) -> Color<I> {
    let axes = Axes::new(i, d);
    let spread = axes.spread(i);
    let n = axes.probes(i, view.most);
    let lod = log2(i, axes.major2 / (n * n)) * 0.5;
    let lod = view.lod_range.limit(i, lod);
    let lod = match view.precision {
        Precision::Exact => lod,
        // One rounded level a pixel.
        Precision::Fast => {
            let lod = lod.simd_gt(64.0).select(i.f32(64.0), lod);
            let lod = lod.simd_gt(-64.0).select(lod, i.f32(-64.0));
            (lod + 0.5).floor_to_i32().to_f32()
        }
    };
    let (w, h) = view.size();
    let step_u = axes.major[0] * spread / (n * (w as f32));
    let step_v = axes.major[1] * spread / (n * (h as f32));
    let start = (i.f32(1.0) - n) * 0.5;
    let levels = LevelPair::new(i, view, lod);
    // Sums run over differences to the first probe, so that a constant texture stays constant to the bit.
    let (mut first, mut sum) = ([i.f32(0.0); 4], [i.f32(0.0); 4]);
    let mut k = 0.0;
    loop {
        let active = n.simd_gt(k);
        if !active.any_true() {
            break;
        }
        let at = start + k;
        let c = levels.sample::<FORMAT>(i, view, [u + step_u * at, v + step_v * at]);
        if k == 0.0 {
            first = c;
            k = 1.0;
            continue;
        }
        let more = [
            sum[0] + (c[0] - first[0]),
            sum[1] + (c[1] - first[1]),
            sum[2] + (c[2] - first[2]),
            sum[3] + (c[3] - first[3]),
        ];
        sum = select::<I>(active, more, sum);
        k += 1.0;
    }
    scaled::<I>(
        [
            first[0] + sum[0] / n,
            first[1] + sum[1] / n,
            first[2] + sum[2] / n,
            first[3] + sum[3] / n,
        ],
        view,
    )
}

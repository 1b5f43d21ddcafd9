use super::{floor, unscaled_lod};
use crate::{
    lod::{TexelFootprint, log2},
    sampler::{Precision, Sampler},
    texels::Chain,
};
use texmap_math::float::{ceil_f32, sqrt_f32};

/// Axes of the ellipse that a unit circle of pixels maps to.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Axes {
    /// Squared half axes in texels.
    pub(crate) major2: f32,
    pub(crate) minor2: f32,
    /// The long half axis as a vector in texels.
    pub(crate) major: [f32; 2],
    /// The sum of both squared half axes, without the rounding of either.
    trace: f32,
}

impl Axes {
    /// The singular values of the Jacobian (Heckbert 1989, section 3.5.9): the columns of a sheared
    /// Jacobian are not the axes. `J J^T = [p q; q r]`.
    pub(crate) fn new(d: &TexelFootprint) -> Self {
        let p = d.ux * d.ux + d.uy * d.uy;
        let r = d.vx * d.vx + d.vy * d.vy;
        let q = d.ux * d.vx + d.uy * d.vy;
        let half = 0.5 * (p - r);
        let trace = p + r;
        let mean = 0.5 * trace;
        let root = sqrt_f32(half * half + q * q);
        let major2 = mean + root;
        // The determinant gives the short axis without the cancellation of mean - root.
        let det = d.ux * d.vy - d.uy * d.vx;
        let minor2 = if major2 > 0.0 {
            det * (det / major2)
        } else {
            0.0
        };
        // An eigenvector from the better conditioned row.
        let (x, y) = if half >= 0.0 {
            (half + root, q)
        } else {
            (q, root - half)
        };
        let length2 = x * x + y * y;
        let major = if length2 > 0.0 {
            let k = sqrt_f32(major2) / sqrt_f32(length2);
            [x * k, y * k]
        } else {
            [sqrt_f32(major2), 0.0]
        };
        Self {
            major2,
            minor2,
            major,
            trace,
        }
    }

    /// How many probes of a round filter cover the ellipse, at most `most`. A probe is a texel wide at least, so that a short axis
    /// below a texel counts as one.
    pub(crate) fn probes(&self, most: u8) -> f32 {
        let most = f32::from(most.clamp(1, 16));
        let minor2 = if self.minor2 > 1.0 { self.minor2 } else { 1.0 };
        let ratio = sqrt_f32(self.major2 / minor2);
        let n = ceil_f32(if ratio < most { ratio } else { most });
        if n > 1.0 { n } else { 1.0 }
    }

    /// The share of the long axis that probes are spread over. A bilinear probe on level 0 blurs as much as a pixel of one texel does
    /// (in twelfths of a squared texel, variance 2 against `1 + axis^2`); what a shorter short axis has too much of it, `1 - minor^2`, is
    /// taken off the square of the long one.
    fn spread(&self) -> f32 {
        let share = (self.trace - 1.0) / self.major2;
        let share = if share > 0.0 { share } else { 0.0 };
        sqrt_f32(if share < 1.0 { share } else { 1.0 })
    }
}

/// Box-weighted trilinear probes along the true long axis (EXT_texture_filter_anisotropic with the
/// orthogonalised footprint that the Direct3D 11.3 specification asks for), with fewer and closer probes where they would be less
/// than a texel apart.
pub(super) fn sample(
    s: &Sampler,
    t: &Chain<'_>,
    uv: [f32; 2],
    d: TexelFootprint,
    most: u8,
) -> [f32; 4] {
    let axes = Axes::new(&d);
    let n = axes.probes(most);
    let lod = s.limit_lod(0.5 * log2(axes.major2 / (n * n)));
    let lod = match s.precision {
        Precision::Exact => lod,
        // One rounded level a pixel.
        Precision::Fast => floor(lod.clamp(-64.0, 64.0) + 0.5) as f32,
    };
    let level = &t.levels[0];
    let spread = axes.spread();
    let step = [
        axes.major[0] * spread / (n * level.width as f32),
        axes.major[1] * spread / (n * level.height as f32),
    ];
    let first = unscaled_lod(s, t, probe(uv, step, 0.5 * (1.0 - n)), lod);
    let mut sum = [0.0; 4];
    for k in 1..n as u32 {
        let c = unscaled_lod(s, t, probe(uv, step, k as f32 + 0.5 * (1.0 - n)), lod);
        for i in 0..4 {
            sum[i] += c[i] - first[i];
        }
    }
    let scale = t.format.scale();
    [0, 1, 2, 3].map(|i| (first[i] + sum[i] / n) * scale)
}

fn probe(uv: [f32; 2], step: [f32; 2], k: f32) -> [f32; 2] {
    [uv[0] + step[0] * k, uv[1] + step[1] * k]
}

//! The filters in f32, one sample at a time. The lanes repeat these operations in the same order.

pub(crate) mod anisotropic;
#[path = "filter/bicubic.rs"]
pub(crate) mod cubic;
pub(crate) mod ewa;

use crate::{
    lanes::packed,
    lod::{TexelFootprint, log2, log2_sqrt_fixed},
    sampler::{Filter, Mip, Precision, Sampler, Texel},
    texels::{Chain, Level, scaled},
    wrap::{Axis, OUTSIDE},
};
use texmap_math::{float, footprint::Footprint};

/// What [`Filter`] comes down to where no axis of the footprint matters.
pub(crate) fn gl_of(filter: Filter) -> (Texel, Texel, Mip) {
    match filter {
        // Cubics have their own kernel on level 0.
        Filter::Bilinear | Filter::Bicubic(_) => (Texel::Linear, Texel::Linear, Mip::None),
        Filter::Nearest => (Texel::Nearest, Texel::Nearest, Mip::None),
        Filter::MipNearest => (Texel::Nearest, Texel::Nearest, Mip::Nearest),
        Filter::BilinearMipNearest => (Texel::Linear, Texel::Linear, Mip::Nearest),
        Filter::Trilinear | Filter::Anisotropic(_) | Filter::Ewa { .. } => {
            (Texel::Linear, Texel::Linear, Mip::Linear)
        }
        Filter::Gl { mag, min, mip } => (mag, min, mip),
    }
}

pub(crate) fn sample_grad(s: &Sampler, t: &Chain<'_>, uv: [f32; 2], d: Footprint) -> [f32; 4] {
    let d = TexelFootprint::new(d, &t.levels[0]);
    if packed::applies(s, t) {
        return packed::unpack(packed::sample_grad(s, t, uv, &d));
    }
    match s.filter {
        Filter::Nearest | Filter::Bilinear | Filter::Bicubic(_) => sample_lod(s, t, uv, 0.0),
        Filter::Anisotropic(most) => anisotropic::sample(s, t, uv, d, most),
        Filter::Ewa { ratio, percent } => ewa::sample(s, t, uv, d, ratio, percent),
        _ => sample_lod(s, t, uv, s.limit_lod(level_of(s, d.rho_max_squared()))),
    }
}

/// Level of detail of a squared length in texels.
pub(crate) fn level_of(s: &Sampler, rho2: f32) -> f32 {
    match s.precision {
        Precision::Exact => 0.5 * log2(rho2),
        Precision::Fast => log2_sqrt_fixed(rho2) as f32 / 256.0,
    }
}

/// `lod` has its bias and limits behind it.
pub(crate) fn sample_lod(s: &Sampler, t: &Chain<'_>, uv: [f32; 2], lod: f32) -> [f32; 4] {
    if packed::applies(s, t) {
        return packed::unpack(packed::sample_lod(s, t, uv, packed::fixed_lod(lod)));
    }
    let scale = t.format.scale();
    scaled(unscaled_lod(s, t, uv, lod), scale)
}

/// As [`sample_lod`] before the scale of the format.
fn unscaled_lod(s: &Sampler, t: &Chain<'_>, uv: [f32; 2], lod: f32) -> [f32; 4] {
    if let Filter::Bicubic(kernel) = s.filter {
        return cubic::sample(s, t, uv, kernel);
    }
    across_levels(s.filter, t, lod, |level, texel| {
        in_level(s, t, level, uv, texel)
    })
}

/// The choice of levels that all shapes of texture share: `at` gives the colour of one level, `lod` has
/// its bias and limits behind it.
pub(crate) fn across_levels(
    filter: Filter,
    t: &Chain<'_>,
    lod: f32,
    at: impl Fn(&Level, Texel) -> [f32; 4],
) -> [f32; 4] {
    let (mag, min, mip) = gl_of(filter);
    if lod <= 0.0 {
        return at(&t.levels[0], mag);
    }
    let last = (t.levels.len() - 1) as f32;
    let lod = if lod > last { last } else { lod };
    match mip {
        Mip::None => at(&t.levels[0], min),
        // ceil(lod + 0.5) - 1: halves go to the finer level.
        Mip::Nearest => at(&t.levels[float::ceil_f32(lod + 0.5) as usize - 1], min),
        Mip::Linear => {
            let fine = lod as usize;
            let weight = lod - fine as f32;
            let a = at(&t.levels[fine], min);
            if weight > 0.0 {
                mix(a, at(&t.levels[fine + 1], min), weight)
            } else {
                a
            }
        }
    }
}

fn in_level(s: &Sampler, t: &Chain<'_>, level: &Level, uv: [f32; 2], texel: Texel) -> [f32; 4] {
    match texel {
        Texel::Nearest => nearest(s, t, level, uv),
        Texel::Linear => bilinear(s, t, level, uv),
    }
}

/// The wrap of both axes.
#[inline(always)]
pub(crate) fn axes(s: &Sampler, t: &Chain<'_>) -> [Axis; 2] {
    let base = &t.levels[0];
    [
        Axis::new(s.wrap_u, base.width),
        Axis::new(s.wrap_v, base.height),
    ]
}

fn nearest(s: &Sampler, t: &Chain<'_>, level: &Level, uv: [f32; 2]) -> [f32; 4] {
    let [ax, ay] = axes(s, t);
    let x = floor(ax.place(uv[0], level.width));
    let y = floor(ay.place(uv[1], level.height));
    let (x, y) = (ax.index(x, level.width), ay.index(y, level.height));
    tap(s, t, level, [x, y, 0])
}

fn bilinear(s: &Sampler, t: &Chain<'_>, level: &Level, uv: [f32; 2]) -> [f32; 4] {
    let [ax, ay] = axes(s, t);
    let x = linear_axis(ax, uv[0], level.width);
    let y = linear_axis(ay, uv[1], level.height);
    in_slice(s, t, level, x, y, 0)
}

/// Bilinear, unscaled, in a slice of a volume; an image has one.
#[inline(always)]
pub(crate) fn in_slice(
    s: &Sampler,
    t: &Chain<'_>,
    level: &Level,
    (x, wx): ([i32; 2], f32),
    (y, wy): ([i32; 2], f32),
    z: i32,
) -> [f32; 4] {
    let texels = if x[0] | x[1] | y[0] | y[1] | z >= 0 {
        t.fetch_four(level, x, y, z)
    } else {
        [
            tap(s, t, level, [x[0], y[0], z]),
            tap(s, t, level, [x[1], y[0], z]),
            tap(s, t, level, [x[0], y[1], z]),
            tap(s, t, level, [x[1], y[1], z]),
        ]
    };
    mix_four(texels, wx, wy)
}

/// The two texels around a coordinate and the weight of the second.
#[inline(always)]
pub(crate) fn linear_axis(axis: Axis, u: f32, n: i32) -> ([i32; 2], f32) {
    let x = axis.place(u, n) - 0.5;
    let i = floor(x);
    (axis.pair(i, n), x - i as f32)
}

/// A texel at wrapped indices, or the border, unscaled.
#[inline(always)]
pub(crate) fn tap(s: &Sampler, t: &Chain<'_>, level: &Level, [x, y, z]: [i32; 3]) -> [f32; 4] {
    if x == OUTSIDE || y == OUTSIDE || z == OUTSIDE {
        s.border_in(t.format.units())
    } else {
        t.fetch(level, x, y, z)
    }
}

/// `a + (b - a) w`: exact where both are equal.
#[inline(always)]
pub(crate) fn mix(a: [f32; 4], b: [f32; 4], w: f32) -> [f32; 4] {
    [
        a[0] + (b[0] - a[0]) * w,
        a[1] + (b[1] - a[1]) * w,
        a[2] + (b[2] - a[2]) * w,
        a[3] + (b[3] - a[3]) * w,
    ]
}

/// Two texels of a row and two of the next.
#[inline(always)]
pub(crate) fn mix_four([a, b, c, d]: [[f32; 4]; 4], wx: f32, wy: f32) -> [f32; 4] {
    mix(mix(a, b, wx), mix(c, d, wx), wy)
}

/// Floor of a number within +-2^30.
#[inline(always)]
pub(crate) fn floor(x: f32) -> i32 {
    let i = x as i32;
    i - i32::from(i as f32 > x)
}

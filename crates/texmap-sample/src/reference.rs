//! The filters in f64, written to be read: one sample at a time, straight from the definitions.
//!
//! The f32 forms are held against these. Texels are taken as stored (linear, premultiplied).

mod blocks;

pub use blocks::block_texel;

use crate::{
    address::wrap::Wrap,
    sampler::{Cubic, Filter, Mip, Sampler, TexelFilter},
    texel_data::{Chain, Level},
    texture::Texture2d,
};
use texmap_math::{
    deterministic_f64,
    float::{ceil, floor, sqrt},
};

/// Derivatives of uv per pixel in f64: `[du/dx, dv/dx, du/dy, dv/dy]`.
pub type Gradient = [f64; 4];

/// [`Sampler::sample`] in f64.
pub fn sample(s: &Sampler, t: &Texture2d<'_>, uv: [f64; 2]) -> [f64; 4] {
    sample_lod(s, t, uv, 0.0)
}

/// [`Sampler::sample_grad`] in f64. [`Ewa`](crate::Filter::Ewa) has its ellipse at any size here.
pub fn sample_grad(s: &Sampler, t: &Texture2d<'_>, uv: [f64; 2], d: Gradient) -> [f64; 4] {
    match s.filter {
        Filter::Anisotropic(most) => anisotropic(s, t, uv, d, f64::from(most.clamp(1, 16))),
        Filter::Ewa { ratio, percent } => {
            let width = f64::from(percent.clamp(25, 200)) / 100.0;
            ewa(
                s,
                t,
                uv,
                d.map(|d| d * width),
                f64::from(ratio.clamp(1, 16)),
            )
        }
        Filter::SummedArea if t.has_summed_area() => {
            let [ux, vx, uy, vy] = in_texels(t, d);
            let side = |length: f64| deterministic_f64::exp2(limit(s, log2(length)));
            rectangle(
                s,
                t,
                uv,
                [side(ux.abs() + uy.abs()), side(vx.abs() + vy.abs())],
            )
        }
        _ => sample_limited(s, t, uv, lod(s, t, d)),
    }
}

/// [`Sampler::sample_lod`] in f64.
pub fn sample_lod(s: &Sampler, t: &Texture2d<'_>, uv: [f64; 2], lod: f64) -> [f64; 4] {
    if s.filter == Filter::SummedArea && t.has_summed_area() {
        return rectangle(s, t, uv, [deterministic_f64::exp2(limit(s, lod)); 2]);
    }
    sample_limited(s, t, uv, limit(s, lod))
}

/// [`Sampler::lod`] in f64: log2 of the longer column of the Jacobian in texels.
pub fn lod(s: &Sampler, t: &Texture2d<'_>, d: Gradient) -> f64 {
    let [ux, vx, uy, vy] = in_texels(t, d);
    limit(s, log2(hypot(ux, vx).max(hypot(uy, vy))))
}

fn limit(s: &Sampler, lod: f64) -> f64 {
    let lod = if lod.is_nan() { 0.0 } else { lod };
    // The limits of `max` and `min` that are NaN limit nothing.
    (lod + f64::from(s.lod_range().bias))
        .max(f64::from(s.lod.min))
        .min(f64::from(s.lod.max))
}

fn in_texels(t: &Texture2d<'_>, d: Gradient) -> Gradient {
    let (w, h) = (f64::from(t.width()), f64::from(t.height()));
    [d[0] * w, d[1] * h, d[2] * w, d[3] * h]
}

fn sample_limited(s: &Sampler, t: &Texture2d<'_>, uv: [f64; 2], lod: f64) -> [f64; 4] {
    let (mag, min, mip) = match s.filter {
        Filter::Nearest => (TexelFilter::Nearest, TexelFilter::Nearest, Mip::None),
        Filter::Bilinear => (TexelFilter::Linear, TexelFilter::Linear, Mip::None),
        Filter::MipNearest => (TexelFilter::Nearest, TexelFilter::Nearest, Mip::Nearest),
        Filter::BilinearMipNearest => (TexelFilter::Linear, TexelFilter::Linear, Mip::Nearest),
        Filter::Gl { mag, min, mip } => (mag, min, mip),
        Filter::Bicubic(kernel) => return cubic(s, t, uv, kernel),
        Filter::Trilinear | Filter::Anisotropic(_) | Filter::Ewa { .. } | Filter::SummedArea => {
            (TexelFilter::Linear, TexelFilter::Linear, Mip::Linear)
        }
    };
    let last = f64::from(t.levels() - 1);
    if lod <= 0.0 {
        return level_sample(s, t, 0, uv, mag);
    }
    let lod = lod.min(last);
    match mip {
        Mip::None => level_sample(s, t, 0, uv, min),
        Mip::Nearest => level_sample(s, t, ceil(lod + 0.5) as usize - 1, uv, min),
        Mip::Linear => {
            let fine = floor(lod);
            let next = (fine + 1.0).min(last);
            let a = level_sample(s, t, fine as usize, uv, min);
            let b = level_sample(s, t, next as usize, uv, min);
            core::array::from_fn(|k| a[k] * (1.0 - (lod - fine)) + b[k] * (lod - fine))
        }
    }
}

fn level_sample(
    s: &Sampler,
    t: &Texture2d<'_>,
    level: usize,
    uv: [f64; 2],
    texel: TexelFilter,
) -> [f64; 4] {
    let chain = &t.chain;
    let level = &chain.levels[level];
    let x = uv[0] * f64::from(level.width);
    let y = uv[1] * f64::from(level.height);
    match texel {
        TexelFilter::Nearest => fetch(s, chain, level, floor(x) as i64, floor(y) as i64),
        TexelFilter::Linear => {
            let (x, y) = (x - 0.5, y - 0.5);
            let (i, j) = (floor(x), floor(y));
            let (fx, fy) = (x - i, y - j);
            let mut sum = [0.0; 4];
            for (dx, dy, w) in [
                (0, 0, (1.0 - fx) * (1.0 - fy)),
                (1, 0, fx * (1.0 - fy)),
                (0, 1, (1.0 - fx) * fy),
                (1, 1, fx * fy),
            ] {
                let c = fetch(s, chain, level, i as i64 + dx, j as i64 + dy);
                for k in 0..4 {
                    sum[k] += w * c[k];
                }
            }
            sum
        }
    }
}

/// One texel of the endless plane that the wrap modes make of a level.
fn fetch(s: &Sampler, t: &Chain<'_>, level: &Level, x: i64, y: i64) -> [f64; 4] {
    match (
        wrapped(x, i64::from(level.width), s.wrap_u),
        wrapped(y, i64::from(level.height), s.wrap_v),
    ) {
        (Some(x), Some(y)) => {
            let c = t.fetch(level, x as i32, y as i32, 0);
            c.map(|c| f64::from(c) / f64::from(t.format.units()))
        }
        _ => s.border_in(1.0).map(f64::from),
    }
}

/// Vulkan 1.4, "Wrapping Operation".
fn wrapped(i: i64, n: i64, wrap: Wrap) -> Option<i64> {
    let mirror = |k: i64| if k >= 0 { k } else { -1 - k };
    match wrap {
        Wrap::Repeat => Some(i.rem_euclid(n)),
        Wrap::MirroredRepeat => Some(n - 1 - mirror(i.rem_euclid(2 * n) - n)),
        Wrap::ClampToEdge => Some(i.clamp(0, n - 1)),
        Wrap::ClampToBorder => (0..n).contains(&i).then_some(i),
        Wrap::MirrorClampToEdge => Some(mirror(i).clamp(0, n - 1)),
    }
}

/// Weight of a cubic at distance `x` from its texel: Mitchell and Netravali's family.
fn cubic_weight(kernel: Cubic, x: f64) -> f64 {
    let (b, c) = match kernel {
        Cubic::CatmullRom => (0.0, 0.5),
        Cubic::Mitchell => (1.0 / 3.0, 1.0 / 3.0),
        Cubic::BSpline => (1.0, 0.0),
    };
    let x = x.abs();
    if x < 1.0 {
        ((12.0 - 9.0 * b - 6.0 * c) * x * x * x
            + (-18.0 + 12.0 * b + 6.0 * c) * x * x
            + (6.0 - 2.0 * b))
            / 6.0
    } else if x < 2.0 {
        ((-b - 6.0 * c) * x * x * x
            + (6.0 * b + 30.0 * c) * x * x
            + (-12.0 * b - 48.0 * c) * x
            + (8.0 * b + 24.0 * c))
            / 6.0
    } else {
        0.0
    }
}

fn cubic(s: &Sampler, t: &Texture2d<'_>, uv: [f64; 2], kernel: Cubic) -> [f64; 4] {
    let level = &t.chain.levels[0];
    let x = uv[0] * f64::from(level.width) - 0.5;
    let y = uv[1] * f64::from(level.height) - 0.5;
    let mut sum = [0.0; 4];
    for dy in -1..=2 {
        for dx in -1..=2 {
            let (i, j) = (floor(x) + f64::from(dx), floor(y) + f64::from(dy));
            let w = cubic_weight(kernel, x - i) * cubic_weight(kernel, y - j);
            let c = fetch(s, &t.chain, level, i as i64, j as i64);
            for k in 0..4 {
                sum[k] += w * c[k];
            }
        }
    }
    sum
}

/// Half axes of the ellipse of a unit circle of pixels: long axis as a vector, length of the short.
fn axes([ux, vx, uy, vy]: Gradient) -> ([f64; 2], f64, f64) {
    let (p, q, r) = (ux * ux + uy * uy, ux * vx + uy * vy, vx * vx + vy * vy);
    let root = hypot(0.5 * (p - r), q);
    let major = sqrt(0.5 * (p + r) + root);
    let minor = if major > 0.0 {
        (ux * vy - uy * vx).abs() / major
    } else {
        0.0
    };
    // Half the angle of the axis' double angle.
    let angle = 0.5 * deterministic_f64::atan2(q, 0.5 * (p - r));
    (
        [
            major * deterministic_f64::cos(angle),
            major * deterministic_f64::sin(angle),
        ],
        major,
        minor,
    )
}

/// Box-weighted trilinear probes spread evenly over the long axis: one, and 1.1 for each short axis by which the long one exceeds the first,
/// but no more than one a texel. Where the short axis is below a texel it counts as one, and the probes spread over what bilinear filtering
/// leaves of the long axis.
fn anisotropic(s: &Sampler, t: &Texture2d<'_>, uv: [f64; 2], d: Gradient, most: f64) -> [f64; 4] {
    let (axis, major, minor) = axes(in_texels(t, d));
    let wanted = 1.0 + 1.1 * (major / minor.max(1.0) - 1.0);
    let n = ceil(wanted.min(major).min(most)).max(1.0);
    let lod = limit(s, log2(major / n));
    let spread = sqrt(((major * major + minor * minor - 1.0) / (major * major)).clamp(0.0, 1.0));
    let mut sum = [0.0; 4];
    for k in 0..n as u32 {
        let at = if n > 1.0 {
            spread * ((f64::from(k) + 0.5) / n - 0.5)
        } else {
            0.0
        };
        let place = [
            uv[0] + at * axis[0] / f64::from(t.width()),
            uv[1] + at * axis[1] / f64::from(t.height()),
        ];
        let c = sample_limited(s, t, place, lod);
        for i in 0..4 {
            sum[i] += c[i] / n;
        }
    }
    sum
}

/// Gaussian e^(-2 r^2) over the ellipse in the two levels around the short axis.
fn ewa(s: &Sampler, t: &Texture2d<'_>, uv: [f64; 2], d: Gradient, most: f64) -> [f64; 4] {
    let (axis, major, minor) = axes(in_texels(t, d));
    let minor = minor.max(major / most);
    let lod = limit(s, log2(minor)).clamp(0.0, f64::from(t.levels() - 1));
    let fine = floor(lod);
    let in_level = |level: f64| {
        let level = &t.chain.levels[level as usize];
        let (sx, sy) = (
            f64::from(level.width) / f64::from(t.width()),
            f64::from(level.height) / f64::from(t.height()),
        );
        let unit = if major > 0.0 {
            [axis[0] / major, axis[1] / major]
        } else {
            [1.0, 0.0]
        };
        let (mx, my) = (unit[0] * major * sx, unit[1] * major * sy);
        let (ox, oy) = (-unit[1] * minor * sx, unit[0] * minor * sy);
        let (p, q, r) = (
            mx * mx + ox * ox + 1.0,
            mx * my + ox * oy,
            my * my + oy * oy + 1.0,
        );
        let f = p * r - q * q;
        let x = uv[0] * f64::from(level.width) - 0.5;
        let y = uv[1] * f64::from(level.height) - 0.5;
        let (mut sum, mut total) = ([0.0; 4], 0.0);
        for j in ceil(y - sqrt(r)) as i64..=floor(y + sqrt(r)) as i64 {
            for i in ceil(x - sqrt(p)) as i64..=floor(x + sqrt(p)) as i64 {
                let (dx, dy) = (i as f64 - x, j as f64 - y);
                let r2 = (r * dx * dx - 2.0 * q * dx * dy + p * dy * dy) / f;
                if r2 < 1.0 {
                    let w = deterministic_f64::exp(-2.0 * r2) - deterministic_f64::exp(-2.0);
                    let c = fetch(s, &t.chain, level, i, j);
                    for k in 0..4 {
                        sum[k] += w * c[k];
                    }
                    total += w;
                }
            }
        }
        sum.map(|c| c / total)
    };
    let a = in_level(fine);
    if lod == fine {
        return a;
    }
    let b = in_level(fine + 1.0);
    core::array::from_fn(|k| a[k] * (1.0 - (lod - fine)) + b[k] * (lod - fine))
}

/// The mean of all texels of a rectangle with these sides, each weighted by the part of it that is inside.
fn rectangle(s: &Sampler, t: &Texture2d<'_>, uv: [f64; 2], sides: [f64; 2]) -> [f64; 4] {
    let (chain, level) = (&t.chain, &t.chain.levels[0]);
    let [columns, rows] = [(level.width, 0), (level.height, 1)].map(|(n, axis)| {
        let side = sides[axis].clamp(1.0, 1_048_576.0);
        let low = uv[axis] * f64::from(n) - 0.5 * side;
        let covered = move |i: i64| {
            let i = i as f64;
            ((i + 1.0).min(low + side) - i.max(low)).max(0.0) / side
        };
        (floor(low) as i64..=floor(low + side) as i64, covered)
    });
    let mut sum = [0.0; 4];
    for y in rows.0 {
        for x in columns.0.clone() {
            let (c, w) = (fetch(s, chain, level, x, y), columns.1(x) * rows.1(y));
            for k in 0..4 {
                sum[k] += w * c[k];
            }
        }
    }
    sum
}

/// Logarithm of a length; 0 gives a level below any texture's.
/// [`gradient_noise`](crate::gradient_noise) in f64, of the same gradients.
pub fn gradient_noise(p: [f64; 3], seed: u32) -> f64 {
    let mut sum = 0.0;
    for corner in 0..8 {
        let mut weight = 1.0;
        let (mut cell, mut from) = ([0; 3], [0.0; 3]);
        for k in 0..3 {
            let side = f64::from(corner >> k & 1);
            let t = p[k] - floor(p[k]);
            let fade = t * t * t * (t * (t * 6.0 - 15.0) + 10.0);
            weight *= if side > 0.0 { fade } else { 1.0 - fade };
            cell[k] = floor(p[k]) as i32 + side as i32;
            from[k] = t - side;
        }
        for (axis, negative) in crate::pattern::edge(crate::pattern::hash(cell, seed)) {
            sum += weight * if negative { -from[axis] } else { from[axis] };
        }
    }
    sum
}

fn log2(x: f64) -> f64 {
    if x > 1e-30 {
        deterministic_f64::log2(x)
    } else {
        -100.0
    }
}

fn hypot(x: f64, y: f64) -> f64 {
    sqrt(x * x + y * y)
}

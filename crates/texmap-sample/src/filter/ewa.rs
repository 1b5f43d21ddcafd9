use super::{anisotropic::Axes, axes as wraps, bilinear, floor, mix, tap};
use crate::{
    lod::{TexelFootprint, log2},
    sampler::{Precision, Sampler},
    texels::{Chain, Level, scaled},
};
use texmap_math::float::{ceil_f32, sqrt_f32};

/// Entries of the weight table over squared radius 0..1.
const STEPS: usize = 128;

/// The Gaussian e^(-2 r^2) of half a pixel, lowered so that it ends at 0 on the ellipse.
static WEIGHTS: [f32; STEPS] = weight_table();

const fn weight_table() -> [f32; STEPS] {
    let mut table = [0.0; STEPS];
    let mut i = 0;
    while i < STEPS {
        let r2 = (i as f64 + 0.5) / STEPS as f64;
        table[i] = (exp(-2.0 * r2) - exp(-2.0)) as f32;
        i += 1;
    }
    table
}

/// The exponential series; enough terms for -2..0 in f64.
const fn exp(x: f64) -> f64 {
    let (mut sum, mut term, mut n) = (1.0, 1.0, 1.0);
    while n < 30.0 {
        term *= x / n;
        sum += term;
        n += 1.0;
    }
    sum
}

/// The exact ellipse of Heckbert 1989 ("Fundamentals of Texture Mapping and Image Warping", section
/// 3.5): the pixel's Gaussian through the Jacobian plus one texel for reconstruction, over the level
/// (`Exact`: two levels) on which the short axis is one to two texels. `most` bounds the ratio of axes.
pub(super) fn sample(
    s: &Sampler,
    t: &Chain<'_>,
    uv: [f32; 2],
    d: TexelFootprint,
    most: u8,
) -> [f32; 4] {
    let axes = Axes::new(&d);
    let most = f32::from(most.clamp(1, 16));
    let floor2 = axes.major2 / (most * most);
    let minor2 = if axes.minor2 > floor2 {
        axes.minor2
    } else {
        floor2
    };
    let lod = s.limit_lod(0.5 * log2(minor2));
    let last = (t.levels.len() - 1) as f32;
    let lod = if lod > last {
        last
    } else if lod > 0.0 {
        lod
    } else {
        0.0
    };
    let fine = lod as usize;
    let weight = lod - fine as f32;
    let a = in_level(s, t, fine, uv, &axes, minor2, most);
    let blended = match s.precision {
        Precision::Exact if weight > 0.0 => {
            mix(a, in_level(s, t, fine + 1, uv, &axes, minor2, most), weight)
        }
        _ => a,
    };
    let scale = t.format.scale();
    scaled(blended, scale)
}

fn in_level(
    s: &Sampler,
    t: &Chain<'_>,
    number: usize,
    uv: [f32; 2],
    axes: &Axes,
    minor2: f32,
    most: f32,
) -> [f32; 4] {
    let level = &t.levels[number];
    let Some(ellipse) = Ellipse::new(&t.levels[0], level, axes, minor2, most) else {
        return bilinear(s, t, level, uv);
    };
    let [ax, ay] = wraps(s, t);
    let x = ax.place(uv[0], level.width) - 0.5;
    let y = ay.place(uv[1], level.height) - 0.5;
    let nearest = [
        ax.index(floor(x + 0.5), level.width),
        ay.index(floor(y + 0.5), level.height),
        0,
    ];
    let centre = tap(s, t, level, nearest);
    let (mut sum, mut total) = ([0.0; 4], 0.0);
    for j in ceil_f32(y - ellipse.half_height) as i32..=floor(y + ellipse.half_height) {
        let dy = j as f32 - y;
        let row = ay.index(j, level.height);
        for i in ceil_f32(x - ellipse.half_width) as i32..=floor(x + ellipse.half_width) {
            let dx = i as f32 - x;
            let r2 = (ellipse.a * dx + ellipse.b * dy) * dx + ellipse.c * dy * dy;
            if r2 < 1.0 {
                let at = floor(r2 * STEPS as f32);
                let w = WEIGHTS[if at > 0 { at as usize } else { 0 }];
                let c = tap(s, t, level, [ax.index(i, level.width), row, 0]);
                for k in 0..4 {
                    sum[k] += w * (c[k] - centre[k]);
                }
                total += w;
            }
        }
    }
    if total > 0.0 {
        [0, 1, 2, 3].map(|k| centre[k] + sum[k] / total)
    } else {
        centre
    }
}

/// `a dx^2 + b dx dy + c dy^2 < 1` in texels of one level.
struct Ellipse {
    a: f32,
    b: f32,
    c: f32,
    half_width: f32,
    half_height: f32,
}

impl Ellipse {
    /// `None` when the level is so small (or the chain so short) that the ellipse would span more
    /// than its cost allows: there a bilinear tap of the last level stands in.
    fn new(base: &Level, level: &Level, axes: &Axes, minor2: f32, most: f32) -> Option<Self> {
        let (sx, sy) = (
            level.width as f32 / base.width as f32,
            level.height as f32 / base.height as f32,
        );
        let [mx, my] = axes.major;
        let k = if axes.major2 > 0.0 {
            sqrt_f32(minor2 / axes.major2)
        } else {
            0.0
        };
        let (ox, oy) = (-my * k, mx * k);
        let (mx, my, ox, oy) = (mx * sx, my * sy, ox * sx, oy * sy);
        let p = mx * mx + ox * ox + 1.0;
        let r = my * my + oy * oy + 1.0;
        let q = mx * my + ox * oy;
        let limit = 4.0 * most + 4.0;
        if p.max(r) > limit * limit {
            return None;
        }
        let f = p * r - q * q;
        Some(Self {
            a: r / f,
            b: -2.0 * q / f,
            c: p / f,
            half_width: sqrt_f32(p),
            half_height: sqrt_f32(r),
        })
    }
}

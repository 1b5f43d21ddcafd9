use super::{anisotropic::Axes, axes as wraps, bilinear, floor, mix, tap};
use crate::{
    lanes::{
        ANY, At, View,
        float::{self, AxesLanes, Color, limit_lanes},
        packed::FootprintLanes,
    },
    lod::{TexelFootprint, log2},
    sampler::{Precision, Sampler},
    texels::{Chain, Level, scaled},
};
use texmap_math::{
    fearless_simd::{f32x16, i32x16, mask32x16, prelude::*},
    float::{ceil_f32, sqrt_f32},
    lanes::{Words, floor_to_i32, gather},
};

/// Entries of the weight table over squared radius 0..1.
const STEPS: usize = 128;

/// The Gaussian e^(-2 r^2) of half a pixel, lowered so that it ends at 0 on the ellipse; times 2^-16, so that the sum over an ellipse of
/// texels of any size stays finite.
static WEIGHTS: [f32; STEPS] = weight_table();
/// [`WEIGHTS`] to gather from.
static WEIGHT_BITS: [u32; STEPS] = weight_bits();

const fn weight_table() -> [f32; STEPS] {
    let mut table = [0.0; STEPS];
    let mut i = 0;
    while i < STEPS {
        let r2 = (i as f64 + 0.5) / STEPS as f64;
        table[i] = ((exp(-2.0 * r2) - exp(-2.0)) as f32) / 65536.0;
        i += 1;
    }
    table
}

const fn weight_bits() -> [u32; STEPS] {
    let (weights, mut bits) = (weight_table(), [0; STEPS]);
    let mut i = 0;
    while i < STEPS {
        bits[i] = weights[i].to_bits();
        i += 1;
    }
    bits
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

/// The width that a filter gives in hundredths.
pub(crate) fn width(percent: u8) -> f32 {
    f32::from(percent.clamp(25, 200)) / 100.0
}

/// The exact ellipse of Heckbert 1989 ("Fundamentals of Texture Mapping and Image Warping", section
/// 3.5): the pixel's Gaussian, `percent` hundredths as wide, through the Jacobian plus one texel for reconstruction, over the level
/// (`Exact`: two levels) on which the short axis is one to two texels. `most` bounds the ratio of axes.
pub(super) fn sample(
    s: &Sampler,
    t: &Chain<'_>,
    uv: [f32; 2],
    d: TexelFootprint,
    most: u8,
    percent: u8,
) -> [f32; 4] {
    let axes = Axes::new(&d.times(width(percent)));
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

/// [`sample`] for sixteen lanes.
#[inline(always)]
pub(crate) fn lanes<S: Simd>(
    s: S,
    view: &View<'_>,
    uv: [f32x16<S>; 2],
    d: &FootprintLanes<S>,
) -> Color<S> {
    let zero = f32x16::splat(s, 0.0);
    let axes = AxesLanes::new(s, &d.times(view.width));
    let most = f32::from(view.most);
    let floor2 = axes.major2 / (most * most);
    let minor2 = axes.minor2.simd_gt(floor2).select(axes.minor2, floor2);
    let lod = limit_lanes(s, view, float::log2(s, minor2) * 0.5);
    let last = f32x16::splat(s, view.last as f32);
    let above = lod.simd_gt(zero).select(lod, zero);
    let lod = lod.simd_gt(last).select(last, above);
    let fine = lod.to_int::<i32x16<S>>();
    let weight = lod - fine.to_float::<f32x16<S>>();
    let two = match view.precision {
        Precision::Exact => weight.simd_gt(zero),
        Precision::Fast => mask32x16::splat(s, false),
    };
    let (next, last) = (fine + 1, i32x16::splat(s, view.last));
    let next = next.simd_gt(last).select(last, next);
    let reads = [(true, fine), (two.any_true(), next)];
    let mut colors = [[zero; 4]; 2];
    for (color, (wanted, level)) in colors.iter_mut().zip(&reads) {
        if *wanted {
            *color = in_level_lanes(s, view, *level, uv, &axes, minor2);
        }
    }
    let [a, b] = colors;
    float::scaled(float::select(two, float::mix(view, a, b, weight), a), view)
}

#[inline(always)]
fn in_level_lanes<S: Simd>(
    s: S,
    view: &View<'_>,
    level: i32x16<S>,
    [u, v]: [f32x16<S>; 2],
    axes: &AxesLanes<S>,
    minor2: f32x16<S>,
) -> Color<S> {
    let (zero, one) = (f32x16::splat(s, 0.0), f32x16::splat(s, 1.0));
    let at = At::of(s, view, level);
    let ellipse = EllipseLanes::new(s, view, &at, axes, minor2);
    let (x, y) = at.place(s, view, u, v);
    let (x, y) = (x - 0.5, y - 0.5);
    let centre = float::tap::<S, ANY>(
        s,
        view,
        at.general::<ANY>(
            view,
            at.far_column(s, view, floor_to_i32(s, x + 0.5)),
            at.far_row(s, view, floor_to_i32(s, y + 0.5)),
        ),
    );
    let first = [
        -floor_to_i32(s, ellipse.half_width - x),
        -floor_to_i32(s, ellipse.half_height - y),
    ];
    let last = [
        floor_to_i32(s, x + ellipse.half_width),
        floor_to_i32(s, y + ellipse.half_height),
    ];
    let (mut sum, mut total) = ([zero; 4], zero);
    let mut j = first[1];
    loop {
        let rows = j.simd_le(last[1]) & ellipse.fits;
        if !rows.any_true() {
            break;
        }
        let dy = j.to_float::<f32x16<S>>() - y;
        let row = at.far_row(s, view, j);
        let mut i = first[0];
        loop {
            let columns = i.simd_le(last[0]) & rows;
            if !columns.any_true() {
                break;
            }
            let dx = i.to_float::<f32x16<S>>() - x;
            let r2 = (ellipse.a * dx + ellipse.b * dy) * dx + ellipse.c * dy * dy;
            let inside = r2.simd_lt(one) & columns;
            if inside.any_true() {
                let w = weight_lanes(s, inside.select(r2, zero));
                let place = at.general::<ANY>(view, at.far_column(s, view, i), row);
                let c = float::tap::<S, ANY>(s, view, place);
                for k in 0..4 {
                    sum[k] = inside.select(sum[k] + w * (c[k] - centre[k]), sum[k]);
                }
                total = inside.select(total + w, total);
            }
            i += 1;
        }
        j += 1;
    }
    let some = total.simd_gt(zero);
    let mut color = centre;
    for k in 0..4 {
        color[k] = some.select(centre[k] + sum[k] / total, centre[k]);
    }
    if ellipse.fits.all_true() {
        return color;
    }
    let near = float::bilinear_at::<S, ANY>(s, view, &at, u, v);
    float::select(ellipse.fits, color, near)
}

/// Weights of squared radii below one.
#[inline(always)]
fn weight_lanes<S: Simd>(s: S, r2: f32x16<S>) -> f32x16<S> {
    let zero = i32x16::splat(s, 0);
    let at = floor_to_i32(s, r2 * STEPS as f32);
    let at = at.simd_gt(zero).select(at, zero);
    match Words::new(&WEIGHT_BITS) {
        Some(weights) => gather(s, weights, at.bitcast()).bitcast(),
        None => r2,
    }
}

/// [`Ellipse`] of sixteen lanes.
struct EllipseLanes<S: Simd> {
    a: f32x16<S>,
    b: f32x16<S>,
    c: f32x16<S>,
    half_width: f32x16<S>,
    half_height: f32x16<S>,
    /// Lanes whose ellipse is no larger than its cost allows.
    fits: mask32x16<S>,
}

impl<S: Simd> EllipseLanes<S> {
    #[inline(always)]
    fn new(s: S, view: &View<'_>, at: &At<S>, axes: &AxesLanes<S>, minor2: f32x16<S>) -> Self {
        let zero = f32x16::splat(s, 0.0);
        let (w, h) = view.size();
        let sx = at.width.to_float::<f32x16<S>>() / w as f32;
        let sy = at.height.to_float::<f32x16<S>>() / h as f32;
        let [mx, my] = axes.major;
        let k = (minor2 / axes.major2).sqrt();
        let k = axes.major2.simd_gt(zero).select(k, zero);
        let (ox, oy) = (-my * k, mx * k);
        let (mx, my, ox, oy) = (mx * sx, my * sy, ox * sx, oy * sy);
        let p = mx * mx + ox * ox + 1.0;
        let r = my * my + oy * oy + 1.0;
        let q = mx * my + ox * oy;
        let limit = 4.0 * f32::from(view.most) + 4.0;
        let limit = f32x16::splat(s, limit * limit);
        let f = p * r - q * q;
        let fits = !(p.simd_gt(limit) | r.simd_gt(limit));
        // Lanes that do not fit keep their bounds in the range of integers.
        Self {
            a: r / f,
            b: q * -2.0 / f,
            c: p / f,
            half_width: fits.select(p, zero).sqrt(),
            half_height: fits.select(r, zero).sqrt(),
            fits,
        }
    }
}

//! The elliptical weighted average.

use super::{FilterKernel, Input, LookUp, anisotropic::Axes, bilinear::bilinear};
use crate::{
    address::{lod::log2, texel::LaneLevel},
    bound_texture::{ANY, BoundTexture},
    fetch::{Color, mix, scaled, select, tap},
    sampler::Precision,
};
use texmap_math::{
    lanes::GatherTable,
    simd::{Isa, prelude::*},
};

/// Entries of the weight table over squared radius 0..1.
const STEPS: usize = 128;

/// The Gaussian e^(-2 r^2) of half a pixel, lowered so that it ends at 0 on the ellipse. Times 2^-16, so that the sum over an ellipse of
/// texels of any size stays finite.
static WEIGHT_BITS: [u32; STEPS] = weight_bits();

const fn weight_bits() -> [u32; STEPS] {
    let mut bits = [0; STEPS];
    let mut i = 0;
    while i < STEPS {
        let r2 = (i as f64 + 0.5) / STEPS as f64;
        bits[i] = (((exp(-2.0 * r2) - exp(-2.0)) as f32) / 65536.0).to_bits();
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

/// Elliptical weighted average, with the exact ellipse. The pixel's Gaussian, as wide as the filter says, goes through the Jacobian plus
/// one texel for reconstruction, over the level (`Exact`: two levels) on which the short axis is one to two texels. Source: Heckbert
/// 1989, "Fundamentals of Texture Mapping and Image Warping", section 3.5.
pub(crate) struct Ewa;

impl FilterKernel for Ewa {
    const FORMAT: u8 = ANY;
    const INPUT: Input = Input::Footprint;

    #[inline(always)]
    fn color<I: Isa>(i: I, view: &BoundTexture<'_>, at: &LookUp<I>, _: I::F32) -> Color<I> {
        let zero = i.f32(0.0);
        let Some(d) = &at.footprint else {
            return [zero; 4];
        };
        let axes = Axes::new(i, &d.times(view.width));
        let most = f32::from(view.most);
        let floor2 = axes.major2 / (most * most);
        let minor2 = axes.minor2.simd_gt(floor2).select(axes.minor2, floor2);
        let lod = view.lod_range.limit(i, log2(i, minor2) * 0.5);
        let last = i.f32(view.last as f32);
        let above = lod.simd_gt(0.0).select(lod, zero);
        let lod = lod.simd_gt(last).select(last, above);
        let fine = lod.to_i32();
        let weight = lod - fine.to_f32();
        let two = match view.precision {
            Precision::Exact => weight.simd_gt(0.0),
            Precision::Fast => i.mask(false),
        };
        let next = (fine + 1).min(i.i32(view.last));
        let reads = [(true, fine), (two.any_true(), next)];
        let mut colors = [[zero; 4]; 2];
        for (color, (wanted, level)) in colors.iter_mut().zip(&reads) {
            if *wanted {
                *color = in_level(i, view, *level, at.uv, &axes, minor2);
            }
        }
        let [a, b] = colors;
        let blended = select::<I>(two, mix::<I>(view, a, b, weight), a);
        scaled::<I>(blended, view)
    }
}

#[inline(always)]
fn in_level<I: Isa>(
    i: I,
    view: &BoundTexture<'_>,
    level: I::I32,
    uv: [I::F32; 2],
    axes: &Axes<I>,
    minor2: I::F32,
) -> Color<I> {
    let zero = i.f32(0.0);
    let level = LaneLevel::of(i, view, level);
    let ellipse = Ellipse::new(i, view, &level, axes, minor2);
    let [x, y] = level.scale(i, view, uv);
    let (x, y) = (x - 0.5, y - 0.5);
    let centre = [
        level.far_column(i, view, (x + 0.5).floor_to_i32()),
        level.far_row(i, view, (y + 0.5).floor_to_i32()),
    ];
    let centre = tap::<I, ANY>(i, view, level.wrapped_texel::<ANY>(view, centre));
    let first = [
        -(ellipse.half_width - x).floor_to_i32(),
        -(ellipse.half_height - y).floor_to_i32(),
    ];
    let last = [
        (x + ellipse.half_width).floor_to_i32(),
        (y + ellipse.half_height).floor_to_i32(),
    ];
    let (mut sum, mut total) = ([zero; 4], zero);
    let mut row = first[1];
    loop {
        let rows = row.simd_le(last[1]) & ellipse.fits;
        if !rows.any_true() {
            break;
        }
        let dy = row.to_f32() - y;
        let wrapped_row = level.far_row(i, view, row);
        let mut column = first[0];
        loop {
            let columns = column.simd_le(last[0]) & rows;
            if !columns.any_true() {
                break;
            }
            let dx = column.to_f32() - x;
            let r2 = (ellipse.a * dx + ellipse.b * dy) * dx + ellipse.c * dy * dy;
            let inside = r2.simd_lt(1.0) & columns;
            if inside.any_true() {
                let w = weight(i, inside.select(r2, zero));
                let texel = [level.far_column(i, view, column), wrapped_row];
                let c = tap::<I, ANY>(i, view, level.wrapped_texel::<ANY>(view, texel));
                for k in 0..4 {
                    sum[k] = inside.select(sum[k] + w * (c[k] - centre[k]), sum[k]);
                }
                total = inside.select(total + w, total);
            }
            column = column + 1;
        }
        row = row + 1;
    }
    let some = total.simd_gt(0.0);
    let mut color = centre;
    for k in 0..4 {
        color[k] = some.select(centre[k] + sum[k] / total, centre[k]);
    }
    if ellipse.fits.all_true() {
        return color;
    }
    let near = bilinear::<I, ANY>(i, view, &level, uv);
    select::<I>(ellipse.fits, color, near)
}

/// Weights of squared radii below one.
#[inline(always)]
fn weight<I: Isa>(i: I, r2: I::F32) -> I::F32 {
    let at = (r2 * STEPS as f32).floor_to_i32().max(i.i32(0));
    match GatherTable::new(&WEIGHT_BITS) {
        Some(weights) => i.gather(weights, at.to_u32()).to_f32_bits(),
        None => r2,
    }
}

/// `a dx^2 + b dx dy + c dy^2 < 1` in texels of one level.
struct Ellipse<I: Isa> {
    a: I::F32,
    b: I::F32,
    c: I::F32,
    half_width: I::F32,
    half_height: I::F32,
    /// False if the ellipse spans more texels than its cost allows, on a small level or a short chain. A bilinear look-up
    /// in the level is taken then.
    fits: I::Mask,
}

impl<I: Isa> Ellipse<I> {
    #[inline(always)]
    fn new(
        i: I,
        view: &BoundTexture<'_>,
        level: &LaneLevel<I>,
        axes: &Axes<I>,
        minor2: I::F32,
    ) -> Self {
        let zero = i.f32(0.0);
        let (w, h) = view.size();
        let sx = level.width.to_f32() / w as f32;
        let sy = level.height.to_f32() / h as f32;
        let [mx, my] = axes.major;
        let k = (minor2 / axes.major2).sqrt();
        let k = axes.major2.simd_gt(0.0).select(k, zero);
        let (ox, oy) = (-my * k, mx * k);
        let (mx, my, ox, oy) = (mx * sx, my * sy, ox * sx, oy * sy);
        let p = mx * mx + ox * ox + 1.0;
        let r = my * my + oy * oy + 1.0;
        let q = mx * my + ox * oy;
        let limit = 4.0 * f32::from(view.most) + 4.0;
        let limit = limit * limit;
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

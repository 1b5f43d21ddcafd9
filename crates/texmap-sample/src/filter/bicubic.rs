use super::{axes, floor, tap};
use crate::{
    lanes::{ANY, At, View, float},
    sampler::{Cubic, Sampler},
    texels::Chain,
};
use texmap_math::{
    fearless_simd::{f32x16, prelude::*},
    lanes::floor_to_i32,
};

/// The four weights at fraction `t` between the second and the third texel. They are the matrices
/// of Vulkan 1.4, "Cubic Texel Filtering"; the largest takes what the others leave of one.
pub(crate) fn weights(kernel: Cubic, t: f32) -> [f32; 4] {
    let (t2, t3) = (t * t, t * t * t);
    let [a, b, c, d] = match kernel {
        Cubic::CatmullRom => [
            0.5 * (-t + 2.0 * t2 - t3),
            0.5 * (2.0 - 5.0 * t2 + 3.0 * t3),
            0.5 * (t + 4.0 * t2 - 3.0 * t3),
            0.5 * (t3 - t2),
        ],
        Cubic::Mitchell => [
            (1.0 - 9.0 * t + 15.0 * t2 - 7.0 * t3) / 18.0,
            (16.0 - 36.0 * t2 + 21.0 * t3) / 18.0,
            (1.0 + 9.0 * t + 27.0 * t2 - 21.0 * t3) / 18.0,
            (7.0 * t3 - 6.0 * t2) / 18.0,
        ],
        Cubic::BSpline => [
            (1.0 - 3.0 * t + 3.0 * t2 - t3) / 6.0,
            (4.0 - 6.0 * t2 + 3.0 * t3) / 6.0,
            (1.0 + 3.0 * t + 3.0 * t2 - 3.0 * t3) / 6.0,
            t3 / 6.0,
        ],
    };
    if t < 0.5 {
        [a, 1.0 - (a + c + d), c, d]
    } else {
        [a, b, 1.0 - (a + b + d), d]
    }
}

/// Bicubic on level 0, unscaled. Sums run over differences to the centre texel, so that a constant
/// texture stays constant to the bit.
pub(super) fn sample(s: &Sampler, t: &Chain<'_>, uv: [f32; 2], kernel: Cubic) -> [f32; 4] {
    let level = &t.levels[0];
    let [ax, ay] = axes(s, t);
    let x = ax.place(uv[0], level.width) - 0.5;
    let y = ay.place(uv[1], level.height) - 0.5;
    let (i, j) = (floor(x), floor(y));
    let (wx, wy) = (weights(kernel, x - i as f32), weights(kernel, y - j as f32));
    let columns = [-1, 0, 1, 2].map(|k| ax.index(i + k, level.width));
    let rows = [-1, 0, 1, 2].map(|k| ay.index(j + k, level.height));
    let centre = tap(s, t, level, [columns[1], rows[1], 0]);
    let mut sum = [0.0; 4];
    for (wy, row) in wy.into_iter().zip(rows) {
        let mut line = [0.0; 4];
        for (wx, column) in wx.into_iter().zip(columns) {
            let c = tap(s, t, level, [column, row, 0]);
            for k in 0..4 {
                line[k] += wx * (c[k] - centre[k]);
            }
        }
        for k in 0..4 {
            sum[k] += wy * line[k];
        }
    }
    [0, 1, 2, 3].map(|k| centre[k] + sum[k])
}

/// [`weights`] for sixteen.
#[inline(always)]
fn weights_lanes<S: Simd>(s: S, kernel: Cubic, t: f32x16<S>) -> [f32x16<S>; 4] {
    let one = f32x16::splat(s, 1.0);
    let (t2, t3) = (t * t, t * t * t);
    let [a, b, c, d] = match kernel {
        Cubic::CatmullRom => [
            (t2 * 2.0 - t - t3) * 0.5,
            (2.0 - t2 * 5.0 + t3 * 3.0) * 0.5,
            (t + t2 * 4.0 - t3 * 3.0) * 0.5,
            (t3 - t2) * 0.5,
        ],
        Cubic::Mitchell => [
            (1.0 - t * 9.0 + t2 * 15.0 - t3 * 7.0) / 18.0,
            (16.0 - t2 * 36.0 + t3 * 21.0) / 18.0,
            (t * 9.0 + 1.0 + t2 * 27.0 - t3 * 21.0) / 18.0,
            (t3 * 7.0 - t2 * 6.0) / 18.0,
        ],
        Cubic::BSpline => [
            (1.0 - t * 3.0 + t2 * 3.0 - t3) / 6.0,
            (4.0 - t2 * 6.0 + t3 * 3.0) / 6.0,
            (t * 3.0 + 1.0 + t2 * 3.0 - t3 * 3.0) / 6.0,
            t3 / 6.0,
        ],
    };
    let near = t.simd_lt(f32x16::splat(s, 0.5));
    [
        a,
        near.select(one - (a + c + d), b),
        near.select(c, one - (a + b + d)),
        d,
    ]
}

/// [`sample`] for sixteen lanes, scaled.
#[inline(always)]
pub(crate) fn lanes<S: Simd>(
    s: S,
    view: &View<'_>,
    kernel: Cubic,
    u: f32x16<S>,
    v: f32x16<S>,
) -> float::Color<S> {
    let at = At::uniform(s, view, 0);
    let (x, y) = at.place(s, view, u, v);
    let (x, y) = (x - 0.5, y - 0.5);
    let (i, j) = (floor_to_i32(s, x), floor_to_i32(s, y));
    let wx = weights_lanes(s, kernel, x - i.to_float::<f32x16<S>>());
    let wy = weights_lanes(s, kernel, y - j.to_float::<f32x16<S>>());
    let mut columns = [i; 4];
    let mut rows = [j; 4];
    for k in 0..4 {
        let step = k as i32 - 1;
        (columns[k], rows[k]) = at.wrapped(s, view, i + step, j + step);
    }
    // Wraps of all kinds keep neighbours within one of each other, so that three steps up are one after the other.
    let in_order = (columns[3] - columns[0]).simd_eq(3).all_true() && !view.is_bordered();
    let centre = at.general::<ANY>(view, columns[1], rows[1]);
    let centre = float::tap::<S, ANY>(s, view, centre);
    let zero = f32x16::splat(s, 0.0);
    let mut sum = [zero; 4];
    for r in 0..4 {
        let texels = if in_order {
            let first = at.general::<ANY>(view, columns[0], rows[r]);
            float::fetch_four::<S, ANY>(s, view, first.word)
        } else {
            let mut texels = [centre; 4];
            for c in 0..4 {
                let place = at.general::<ANY>(view, columns[c], rows[r]);
                texels[c] = float::tap::<S, ANY>(s, view, place);
            }
            texels
        };
        let mut line = [zero; 4];
        for c in 0..4 {
            for k in 0..4 {
                line[k] += wx[c] * (texels[c][k] - centre[k]);
            }
        }
        for k in 0..4 {
            sum[k] += wy[r] * line[k];
        }
    }
    float::scaled(
        [
            centre[0] + sum[0],
            centre[1] + sum[1],
            centre[2] + sum[2],
            centre[3] + sum[3],
        ],
        view,
    )
}

use super::{axes, floor, tap};
use crate::{
    sampler::{Cubic, Sampler},
    texels::Chain,
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

//! Sixteen texels weighted by a cubic.

use super::{FilterKernel, Input, Kernel, LookUp, bilinear::cell};
use crate::{
    address::texel::LaneLevel,
    bound_texture::{ANY, BLOCKS, BoundTexture},
    fetch::{Color, fetch_four, scaled, tap},
    sampler::Cubic,
};
use texmap_math::simd::{Isa, prelude::*};

/// The four weights at fraction `t` between the second and the third texel. They are the matrices
/// of Vulkan 1.4, "Cubic Texel Filtering"; the largest takes what the others leave of one.
#[inline(always)]
fn weights<I: Isa>(i: I, kernel: Cubic, t: I::F32) -> [I::F32; 4] {
    let (t2, t3) = (t * t, t * t * t);
    let [a, b, c, d] = match kernel {
        Cubic::CatmullRom => [
            (t2 * 2.0 - t - t3) * 0.5,
            (i.f32(2.0) - t2 * 5.0 + t3 * 3.0) * 0.5,
            (t + t2 * 4.0 - t3 * 3.0) * 0.5,
            (t3 - t2) * 0.5,
        ],
        Cubic::Mitchell => [
            (i.f32(1.0) - t * 9.0 + t2 * 15.0 - t3 * 7.0) / 18.0,
            (i.f32(16.0) - t2 * 36.0 + t3 * 21.0) / 18.0,
            (t * 9.0 + 1.0 + t2 * 27.0 - t3 * 21.0) / 18.0,
            (t3 * 7.0 - t2 * 6.0) / 18.0,
        ],
        Cubic::BSpline => [
            (i.f32(1.0) - t * 3.0 + t2 * 3.0 - t3) / 6.0,
            (i.f32(4.0) - t2 * 6.0 + t3 * 3.0) / 6.0,
            (t * 3.0 + 1.0 + t2 * 3.0 - t3 * 3.0) / 6.0,
            t3 / 6.0,
        ],
    };
    let near = t.simd_lt(0.5);
    [
        a,
        near.select(i.f32(1.0) - (a + c + d), b),
        near.select(c, i.f32(1.0) - (a + b + d)),
        d,
    ]
}

/// Bicubic on level 0.
pub(crate) struct Bicubic;

impl FilterKernel for Bicubic {
    const FORMAT: u8 = ANY;
    const INPUT: Input = Input::Coordinates;

    /// Sums run over differences to the centre texel, so that a constant texture stays constant to the bit.
    #[inline(always)]
    fn color<I: Isa>(i: I, view: &BoundTexture<'_>, at: &LookUp<I>, _: I::F32) -> Color<I> {
        let Kernel::Bicubic(kernel) = view.kind else {
            return [i.f32(0.0); 4];
        };
        let level = LaneLevel::uniform(i, view, 0);
        let [x, y] = level.scale(i, view, at.uv);
        let ([x, y], [tx, ty]) = cell::<I>([x - 0.5, y - 0.5]);
        let (wx, wy) = (weights(i, kernel, tx), weights(i, kernel, ty));
        let (mut columns, mut rows) = ([x; 4], [y; 4]);
        for k in 0..4 {
            let step = k as i32 - 1;
            [columns[k], rows[k]] = level.wrapped(i, view, [x + step, y + step]);
        }
        // Wraps of all kinds keep neighbours within one of each other, so that three steps up are one after the other;
        // but not in blocks.
        let in_order = (columns[3] - columns[0]).simd_eq(3).all_true()
            && !view.bordered
            && view.format != BLOCKS;
        let centre = level.wrapped_texel::<ANY>(view, [columns[1], rows[1]]);
        let centre = tap::<I, ANY>(i, view, centre);
        let mut sum = [i.f32(0.0); 4];
        for r in 0..4 {
            let texels = if in_order {
                let first = level.wrapped_texel::<ANY>(view, [columns[0], rows[r]]);
                fetch_four::<I, ANY>(i, view, first.word)
            } else {
                let mut texels = [centre; 4];
                for c in 0..4 {
                    let texel = level.wrapped_texel::<ANY>(view, [columns[c], rows[r]]);
                    texels[c] = tap::<I, ANY>(i, view, texel);
                }
                texels
            };
            let mut line = [i.f32(0.0); 4];
            for c in 0..4 {
                for k in 0..4 {
                    line[k] = line[k] + wx[c] * (texels[c][k] - centre[k]);
                }
            }
            for k in 0..4 {
                sum[k] = sum[k] + wy[r] * line[k];
            }
        }
        scaled::<I>(
            [
                centre[0] + sum[0],
                centre[1] + sum[1],
                centre[2] + sum[2],
                centre[3] + sum[3],
            ],
            view,
        )
    }
}

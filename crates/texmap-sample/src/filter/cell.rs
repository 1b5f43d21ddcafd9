//! Bilinear look-ups in two steps: the addresses and weights of a run of vectors, then their texels.

use super::{CellKernel, Input, LookUp, bilinear};
use crate::{
    address::texel::{Corners, LaneLevel, TexelAddress},
    bound_texture::{BoundTexture, EXACT_WORDS, RGBA16},
    fetch::{Color, fetch_two_at, mix_four, scaled, tap},
};
use texmap_math::simd::{Isa, prelude::*};

/// Vectors in a run. A load waits for an address that was only just stored; those of a run are in the cache by the time they are used.
pub(crate) const RUN: usize = 4;

/// The addresses of a vector's four texels on a level, and their weights.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(crate) struct Cell {
    /// The left texels of both rows. Negative on the border.
    left: [[u32; 16]; 2],
    /// The right ones, unless they are the next in memory.
    right: [[u32; 16]; 2],
    weights: [[f32; 16]; 2],
    /// True if the right texels are the next in memory in all lanes.
    paired: bool,
}

impl Cell {
    /// Puts the cells of coordinates on a level here.
    #[inline(always)]
    pub(crate) fn find_on<I: Isa>(
        &mut self,
        i: I,
        view: &BoundTexture<'_>,
        level: &LaneLevel<I>,
        uv: [I::F32; 2],
    ) {
        let [x, y] = level.scale(i, view, uv);
        let (at, [wx, wy]) = bilinear::cell::<I>([x - 0.5, y - 0.5]);
        let (top, bottom) = match level.corners::<EXACT_WORDS>(i, view, at) {
            Corners::Pairs([top, bottom]) => {
                self.paired = true;
                (top, bottom)
            }
            Corners::Apart([a, b, c, d]) => {
                self.paired = false;
                b.stored(i).store(&mut self.right[0]);
                d.stored(i).store(&mut self.right[1]);
                (a.stored(i), c.stored(i))
            }
        };
        top.store(&mut self.left[0]);
        bottom.store(&mut self.left[1]);
        wx.store(&mut self.weights[0]);
        wy.store(&mut self.weights[1]);
    }

    /// The colour, unscaled.
    #[inline(always)]
    pub(crate) fn mixed<I: Isa, const FORMAT: u8>(
        &self,
        i: I,
        view: &BoundTexture<'_>,
    ) -> Color<I> {
        if !self.paired {
            return self.mixed_apart::<I, FORMAT>(i, view);
        }
        let [top, bottom] = &self.left;
        let texels = [
            fetch_two_at::<I, FORMAT>(i, view, top),
            fetch_two_at::<I, FORMAT>(i, view, bottom),
        ];
        self.mix(i, view, texels)
    }

    /// Of texels of which some do not lie side by side: rare, and much code.
    #[inline(never)]
    fn mixed_apart<I: Isa, const FORMAT: u8>(&self, i: I, view: &BoundTexture<'_>) -> Color<I> {
        i.vectorize(
            #[inline(always)]
            || {
                let ([a, c], [b, d]) = (&self.left, &self.right);
                let texels = [
                    [
                        tap_at::<I, FORMAT>(i, view, a),
                        tap_at::<I, FORMAT>(i, view, b),
                    ],
                    [
                        tap_at::<I, FORMAT>(i, view, c),
                        tap_at::<I, FORMAT>(i, view, d),
                    ],
                ];
                self.mix(i, view, texels)
            },
        )
    }

    #[inline(always)]
    fn mix<I: Isa>(&self, i: I, view: &BoundTexture<'_>, texels: [[Color<I>; 2]; 2]) -> Color<I> {
        let [wx, wy] = &self.weights;
        mix_four::<I>(view, texels, [i.load_f32(wx), i.load_f32(wy)])
    }
}

/// Bilinear on level 0.
impl CellKernel for Cell {
    const INPUT: Input = Input::Coordinates;
    const ZERO: Self = Self {
        left: [[0; 16]; 2],
        right: [[0; 16]; 2],
        weights: [[0.0; 16]; 2],
        paired: false,
    };

    #[inline(always)]
    fn find<I: Isa>(&mut self, i: I, view: &BoundTexture<'_>, at: &LookUp<I>, _: I::F32) {
        self.find_on(i, view, &LaneLevel::uniform(i, view, 0), at.uv);
    }

    #[inline(always)]
    fn readdress<I: Isa>(&mut self, i: I, format: u8) {
        for words in self.left.iter_mut().chain(&mut self.right) {
            let at = i.load_u32(words);
            let at = if format == RGBA16 { at << 1 } else { at >> 1 };
            at.store(words);
        }
    }

    #[inline(always)]
    fn color<I: Isa, const FORMAT: u8>(&self, i: I, view: &BoundTexture<'_>) -> Color<I> {
        scaled::<I>(self.mixed::<I, FORMAT>(i, view), view)
    }
}

/// Texels or the border.
#[inline(always)]
fn tap_at<I: Isa, const FORMAT: u8>(i: I, view: &BoundTexture<'_>, words: &[u32; 16]) -> Color<I> {
    tap::<I, FORMAT>(i, view, TexelAddress::loaded(i.load_u32(words)))
}

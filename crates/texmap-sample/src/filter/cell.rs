//! Bilinear look-ups in two steps: the addresses and weights of a run of vectors, then their texels.

use crate::{
    address::texel::{Corners, LaneLevel},
    bound_texture::{BoundTexture, EXACT_WORDS, RGBA16},
    fetch::{Color, fetch_two_at, mix_four},
};
use texmap_math::simd::{Isa, prelude::*};

/// Vectors in a run. A load waits for an address that was only just stored; those of a run are in the cache by the time they are used.
pub(crate) const RUN: usize = 4;

/// The addresses of a vector's four texels on a level, and their weights.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(crate) struct Cell {
    /// The left texels of both rows; the right ones are the next in memory.
    words: [[u32; 16]; 2],
    weights: [[f32; 16]; 2],
}

impl Cell {
    pub(crate) const ZERO: Self = Self {
        words: [[0; 16]; 2],
        weights: [[0.0; 16]; 2],
    };

    /// Puts the cells of coordinates on a level here. False if the texels of a row are not next to each other in all lanes.
    #[inline(always)]
    pub(crate) fn find<I: Isa>(
        &mut self,
        i: I,
        view: &BoundTexture<'_>,
        level: &LaneLevel<I>,
        uv: [I::F32; 2],
    ) -> bool {
        let [x, y] = level.scale(i, view, uv);
        let (at, [wx, wy]) = super::bilinear::cell::<I>([x - 0.5, y - 0.5]);
        let Corners::Pairs([top, bottom]) = level.corners::<EXACT_WORDS>(i, view, at) else {
            return false;
        };
        top.store(&mut self.words[0]);
        bottom.store(&mut self.words[1]);
        wx.store(&mut self.weights[0]);
        wy.store(&mut self.weights[1]);
        true
    }

    /// Turns addresses of the other format of one or two words a texel into those of `format`.
    #[inline(always)]
    pub(crate) fn readdress<I: Isa>(&mut self, i: I, format: u8) {
        for words in &mut self.words {
            let at = i.load_u32(words);
            let at = if format == RGBA16 { at << 1 } else { at >> 1 };
            at.store(words);
        }
    }

    /// Unscaled.
    #[inline(always)]
    pub(crate) fn color<I: Isa, const FORMAT: u8>(
        &self,
        i: I,
        view: &BoundTexture<'_>,
    ) -> Color<I> {
        let texels = [
            fetch_two_at::<I, FORMAT>(i, view, &self.words[0]),
            fetch_two_at::<I, FORMAT>(i, view, &self.words[1]),
        ];
        let [wx, wy] = &self.weights;
        mix_four::<I>(view, texels, [i.load_f32(wx), i.load_f32(wy)])
    }
}

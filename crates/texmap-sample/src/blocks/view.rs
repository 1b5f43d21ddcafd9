//! Blocks as the kernels read them.

use super::{BlockFormat, Blocks, bc1, bc4, bc7};
use crate::fetch::Color;
use texmap_math::{
    lanes::GatherTable,
    simd::{Isa, prelude::*},
};

/// Most of an unscaled channel.
const UNITS: f32 = 65535.0;

/// Compressed texels of a chain.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BlockView<'a> {
    words: GatherTable<'a>,
    light: GatherTable<'a>,
    format: BlockFormat,
    /// Texels that are compressed: those of levels made from them come after.
    pub(crate) texels: i32,
    straight: bool,
    linear: bool,
}

impl<'a> BlockView<'a> {
    pub(super) fn new(blocks: &'a Blocks) -> Option<Self> {
        Some(Self {
            words: GatherTable::new(&blocks.words)?,
            light: GatherTable::new(&blocks.light[..])?,
            format: blocks.format,
            texels: blocks.texels as i32,
            straight: blocks.straight,
            linear: blocks.linear,
        })
    }

    /// Unscaled texels in block order, all of them compressed.
    #[inline(never)]
    pub(crate) fn decoded<I: Isa>(&self, i: I, texel: I::I32) -> Color<I> {
        i.vectorize(
            #[inline(always)]
            || self.decode(i, texel),
        )
    }

    #[inline(always)]
    fn decode<I: Isa>(&self, i: I, texel: I::I32) -> Color<I> {
        let (words, block, t) = (self.words, texel >> 4, texel & 15);
        let (two, four) = ((block << 1).to_u32(), (block << 2).to_u32());
        let codes = match self.format {
            BlockFormat::Bc1 => bc1::codes(i, words, two, t, true),
            BlockFormat::Bc1Opaque => {
                let [r, g, b, a] = bc1::codes(i, words, two, t, true);
                [r, g, b, a.max(i.i32(255))]
            }
            BlockFormat::Bc2 => {
                let [r, g, b, _] = bc1::codes(i, words, four + 2, t, false);
                [r, g, b, bc1::alpha4(i, words, four, t)]
            }
            BlockFormat::Bc3 => {
                let [r, g, b, _] = bc1::codes(i, words, four + 2, t, false);
                [r, g, b, bc4::value(i, words, four, t, 1.0)]
            }
            BlockFormat::Bc4 if self.linear => {
                let x = bc4::value(i, words, two, t, 257.0).to_f32();
                return [x, x, x, i.f32(UNITS)];
            }
            BlockFormat::Bc4 => {
                let x = bc4::value(i, words, two, t, 1.0);
                [x, x, x, i.i32(255)]
            }
            BlockFormat::Bc5 => {
                let x = bc4::value(i, words, four, t, 257.0).to_f32();
                let y = bc4::value(i, words, four + 2, t, 257.0).to_f32();
                return [x, y, third(i, x, y), i.f32(UNITS)];
            }
            BlockFormat::Bc7 => bc7::codes(i, words, block, t),
        };
        self.lit(i, codes)
    }

    /// Linear light, premultiplied, rounded to 16 bits.
    #[inline(always)]
    fn lit<I: Isa>(&self, i: I, [r, g, b, a]: [I::I32; 4]) -> Color<I> {
        let a = a.to_f32() / 255.0;
        let factor = if self.straight { a } else { i.f32(1.0) };
        [
            rounded::<I>(self.light(i, r) * factor),
            rounded::<I>(self.light(i, g) * factor),
            rounded::<I>(self.light(i, b) * factor),
            rounded::<I>(a),
        ]
    }

    #[inline(always)]
    fn light<I: Isa>(&self, i: I, code: I::I32) -> I::F32 {
        i.gather(self.light, code.to_u32()).to_f32_bits()
    }
}

/// The z of a unit vector whose x and y are kept as (n + 1) / 2, kept as they are; that of a longer vector is 0.
#[inline(always)]
fn third<I: Isa>(i: I, x: I::F32, y: I::F32) -> I::F32 {
    let (x, y) = (x * (2.0 / UNITS) - 1.0, y * (2.0 / UNITS) - 1.0);
    let z2 = i.f32(1.0) - x * x - y * y;
    let z = z2.above(i.f32(0.0)).sqrt();
    rounded::<I>((z + 1.0) * 0.5)
}

#[inline(always)]
fn rounded<I: Isa>(c: I::F32) -> I::F32 {
    (c * UNITS + 0.5).to_i32().to_f32()
}

//! Memory layout of texels: one allocation of 32-bit words for all levels and layers.

use crate::{blocks::block_order, encoded::Encoded, filter::summed_area::SummedArea};
use alloc::{sync::Arc, vec::Vec};

/// Texels as they come from a decoder: rows top to bottom, channels together.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub enum TexelData<'a> {
    /// 0..255 stands for 0..1.
    U8(&'a [u8]),
    /// 0..65535 stands for 0..1.
    U16(&'a [u16]),
    /// Any finite value within +-2^120, and so after its sRGB curve and opacity.
    F32(&'a [f32]),
}

impl TexelData<'_> {
    pub(crate) fn len(&self) -> usize {
        match self {
            Self::U8(t) => t.len(),
            Self::U16(t) => t.len(),
            Self::F32(t) => t.len(),
        }
    }

    /// Value `i` on the 0..1 scale of integers, as it is for floats.
    pub(crate) fn value(&self, i: usize) -> f32 {
        match self {
            Self::U8(t) => f32::from(t[i]) / 255.0,
            Self::U16(t) => f32::from(t[i]) / 65535.0,
            Self::F32(t) => t[i],
        }
    }
}

/// Layout of one texel, chosen at upload so that the look-up needs no conversion but a scale.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Format {
    /// One word: bytes r, g, b, a from the low end.
    Rgba8,
    /// Two words: r | g << 16, b | a << 16.
    Rgba16,
    /// Four words of f32 bits.
    Rgba32,
    /// One word of f32 bits, read as (x, x, x, 1).
    R32,
}

impl Format {
    pub(crate) const fn words(self) -> usize {
        match self {
            Self::Rgba8 | Self::R32 => 1,
            Self::Rgba16 => 2,
            Self::Rgba32 => 4,
        }
    }

    /// The value that one unit of a fetched value stands for. Filters run on the unscaled values (small
    /// integers are exact in f32) and scale once at the end.
    pub(crate) const fn scale(self) -> f32 {
        match self {
            Self::Rgba8 => 1.0 / 255.0,
            Self::Rgba16 => 1.0 / 65535.0,
            Self::Rgba32 | Self::R32 => 1.0,
        }
    }

    /// The factor back to unscaled values.
    pub(crate) const fn units(self) -> f32 {
        match self {
            Self::Rgba8 => 255.0,
            Self::Rgba16 => 65535.0,
            Self::Rgba32 | Self::R32 => 1.0,
        }
    }

    /// Appends one texel given in unscaled values (integers are rounded half up and clamped).
    pub(crate) fn push(self, words: &mut Vec<u32>, c: [f32; 4]) {
        match self {
            Self::Rgba8 => {
                let [r, g, b, a] = rounded_words(c, 255.0);
                words.push(r | g << 8 | b << 16 | a << 24);
            }
            Self::Rgba16 => {
                let [r, g, b, a] = rounded_words(c, 65535.0);
                words.extend([r | g << 16, b | a << 16]);
            }
            Self::Rgba32 => words.extend(c.map(f32::to_bits)),
            Self::R32 => words.push(c[0].to_bits()),
        }
    }

    /// Unscaled texel that starts at word `i`.
    #[inline(always)]
    pub(crate) fn fetch(self, words: &[u32], i: usize) -> [f32; 4] {
        match self {
            Self::Rgba8 => {
                let w = words[i];
                floats([w & 255, w >> 8 & 255, w >> 16 & 255, w >> 24])
            }
            Self::Rgba16 => {
                let (a, b) = (words[i], words[i + 1]);
                floats([a & 65535, a >> 16, b & 65535, b >> 16])
            }
            Self::Rgba32 => [
                f32::from_bits(words[i]),
                f32::from_bits(words[i + 1]),
                f32::from_bits(words[i + 2]),
                f32::from_bits(words[i + 3]),
            ],
            Self::R32 => {
                let x = f32::from_bits(words[i]);
                [x, x, x, 1.0]
            }
        }
    }
}

// Written out: a compiler leaves the closures of `array::map` out of line, which doubles the price of a look-up.

/// A colour times a number.
#[inline(always)]
pub(crate) fn scaled([r, g, b, a]: [f32; 4], by: f32) -> [f32; 4] {
    [r * by, g * by, b * by, a * by]
}

/// Integers as numbers.
#[inline(always)]
pub(crate) fn floats([r, g, b, a]: [u32; 4]) -> [f32; 4] {
    [r as f32, g as f32, b as f32, a as f32]
}

/// Unscaled values to the nearest whole numbers of 0 to `max`, halves up; NaN gives 0.
#[inline(always)]
pub(crate) fn rounded_words([r, g, b, a]: [f32; 4], max: f32) -> [u32; 4] {
    [
        round_clamped(r, max),
        round_clamped(g, max),
        round_clamped(b, max),
        round_clamped(a, max),
    ]
}

// Selections and signed conversion: a row of texels takes lanes.
#[inline(always)]
fn round_clamped(x: f32, max: f32) -> u32 {
    let x = if x > 0.0 { x } else { 0.0 };
    let x = if x < max { x } else { max };
    (x + 0.5) as i32 as u32
}

#[derive(Clone, Debug)]
pub(crate) enum Words<'a> {
    Owned(Arc<Vec<u32>>),
    Borrowed(&'a [u32]),
}

/// One mip level of a [`Chain`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Level {
    /// First word, or [`Level::ENCODED`]; of a chain with blocks the first texel, in block order.
    pub(crate) offset: usize,
    pub(crate) width: i32,
    pub(crate) height: i32,
    /// Slices of a volume, faces of a cube; 1 otherwise.
    pub(crate) depth: i32,
}

impl Level {
    /// Offset of a level that is not among the words.
    pub(crate) const ENCODED: usize = usize::MAX;
}

/// All texels of a texture.
#[derive(Clone, Debug)]
pub(crate) struct Chain<'a> {
    pub(crate) words: Words<'a>,
    /// Levels that are not among the words.
    pub(crate) encoded: Option<Encoded>,
    pub(crate) format: Format,
    pub(crate) levels: Vec<Level>,
    /// Rows count from the bottom.
    pub(crate) flip: bool,
    /// Every alpha is one.
    pub(crate) opaque: bool,
    /// Sums of level 0, once a filter reads them.
    pub(crate) sums: Option<Arc<SummedArea>>,
}

impl Chain<'_> {
    #[inline(always)]
    pub(crate) fn words(&self) -> &[u32] {
        match &self.words {
            Words::Owned(w) => w,
            Words::Borrowed(w) => w,
        }
    }

    /// Unscaled texel at integer coordinates that are inside the level.
    #[inline(always)]
    pub(crate) fn fetch(&self, level: &Level, x: i32, y: i32, z: i32) -> [f32; 4] {
        let y = if self.flip { level.height - 1 - y } else { y };
        if let Some(Encoded::Blocks(blocks)) = &self.encoded {
            let i = level.offset + block_order(level.width, x, y);
            return blocks.fetch_in(self.words(), i);
        }
        let row = z as usize * level.height as usize + y as usize;
        let i = row * level.width as usize + x as usize;
        match &self.encoded {
            Some(Encoded::Bytes(bytes)) if level.offset == Level::ENCODED => bytes.fetch(i),
            _ => {
                let words = self.format.words();
                self.format.fetch(self.words(), level.offset + i * words)
            }
        }
    }
}

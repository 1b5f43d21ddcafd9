//! A batch: up to 256 fragments of one surface, in the 4x4 blocks of the rasterizer, and their colors.

use texmap_math::simd::{Isa, prelude::*};
use texmap_raster::RUN_ROOM;

/// Pixels of a 4x4 block.
pub(crate) const LANES: usize = 16;

/// Premultiplied colors of a batch, channel by channel.
pub(crate) struct Colors(pub(crate) [[f32; RUN_ROOM]; 4]);

impl Default for Colors {
    fn default() -> Self {
        Self([[0.0; RUN_ROOM]; 4])
    }
}

impl Colors {
    /// The colors from pixel `at` of the batch on.
    #[inline(always)]
    pub(crate) fn load<I: Isa>(&self, i: I, at: usize) -> [I::F32; 4] {
        let [r, g, b, a] = &self.0;
        [
            load(i, r, at),
            load(i, g, at),
            load(i, b, at),
            load(i, a, at),
        ]
    }

    /// Stores colors from pixel `at` of the batch on.
    #[inline(always)]
    pub(crate) fn store<I: Isa>(&mut self, _: I, at: usize, colors: [I::F32; 4]) {
        for (column, color) in self.0.iter_mut().zip(&colors) {
            color.store(&mut column[at..at + I::LANES]);
        }
    }

    /// Sets the color of pixel `at`.
    pub(crate) fn set(&mut self, at: usize, color: [f32; 4]) {
        for (column, value) in self.0.iter_mut().zip(color) {
            column[at] = value;
        }
    }

    /// The color of pixel `at`.
    pub(crate) fn get(&self, at: usize) -> [f32; 4] {
        self.0.each_ref().map(|column| column[at])
    }

    /// The four channels over the first `count` pixels.
    pub(crate) fn columns_mut(&mut self, count: usize) -> [&mut [f32]; 4] {
        self.0.each_mut().map(|column| &mut column[..count])
    }
}

/// Values of a column from pixel `at` of the batch on.
#[inline(always)]
pub(crate) fn load<I: Isa>(i: I, column: &[f32; RUN_ROOM], at: usize) -> I::F32 {
    i.load_f32(&column[at..at + I::LANES])
}

/// Premultiplied to straight color; black where alpha is 0 or NaN.
#[inline(always)]
pub(crate) fn straight<I: Isa>(i: I, [r, g, b, a]: [I::F32; 4]) -> [I::F32; 3] {
    let (zero, some) = (i.f32(0.0), a.simd_gt(0.0));
    [
        some.select(r / a, zero),
        some.select(g / a, zero),
        some.select(b / a, zero),
    ]
}

/// The channels of packed RGBA8 texels, 0..=1.
#[inline(always)]
pub(crate) fn unpack<I: Isa>(_: I, word: I::U32) -> [I::F32; 4] {
    let scale = 1.0 / 255.0;
    [
        (word & 255).to_i32().to_f32() * scale,
        ((word >> 8) & 255).to_i32().to_f32() * scale,
        ((word >> 16) & 255).to_i32().to_f32() * scale,
        (word >> 24).to_i32().to_f32() * scale,
    ]
}

/// The positions of the bits that are set, from the lowest up.
pub(crate) fn set_bits(mut mask: u16) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let bit = mask.trailing_zeros() as usize;
        mask &= mask.wrapping_sub(1);
        (bit < LANES).then_some(bit)
    })
}

use texmap_math::fearless_simd::{Simd, f32x16};
use texmap_math::simd::X16;
impl Colors {
    #[inline(always)]
    pub(crate) fn lanes<S: Simd>(&self, s: S, i: usize) -> [f32x16<S>; 4] {
        self.load(X16(s), i * LANES)
    }
}
#[inline(always)]
pub(crate) fn vector<S: Simd>(s: S, [x, y, z]: [&[f32; RUN_ROOM]; 3], i: usize) -> [f32x16<S>; 3] {
    let at = i * LANES;
    [
        load(X16(s), x, at),
        load(X16(s), y, at),
        load(X16(s), z, at),
    ]
}
#[inline(always)]
pub(crate) fn straight_lanes<S: Simd>(s: S, c: [f32x16<S>; 4]) -> [f32x16<S>; 3] {
    straight(X16(s), c)
}
pub(crate) fn clip(value: f32) -> f32 {
    if value < 1.0 { value } else { 1.0 }
}

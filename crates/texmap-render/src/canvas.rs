//! The colours of a tile, in the 4x4 blocks of the rasterizer: as finished bytes where nothing is to be mixed, else as
//! premultiplied light (raw values in raw mode).

mod copy;

use texmap_math::color::straight;
use texmap_math::fearless_simd::{Simd, f32x16, mask32x16, prelude::*, u32x16};
use texmap_math::{Level, color, lanes};
use texmap_raster::{RUN_ROOM, RunBlock, TILE};

pub(crate) use copy::{fill_rows, put_block_rows, rows_fit};
use texmap_math::on_wide_level;
use texmap_scene::ColorMode;

/// Pixels of a block.
pub(crate) const LANES: usize = 16;
/// Pixels of a tile.
pub(crate) const PIXELS: usize = (TILE * TILE) as usize;
/// Floats of a block: four channels, one after the other.
const FLOATS: usize = 4 * LANES;

/// Premultiplied colours of a run, channel by channel.
pub(crate) struct Colors(pub(crate) [[f32; RUN_ROOM]; 4]);

impl Colors {
    pub(crate) fn new() -> Self {
        Self([[0.0; RUN_ROOM]; 4])
    }

    #[inline(always)]
    pub(crate) fn lanes<S: Simd>(&self, s: S, i: usize) -> [f32x16<S>; 4] {
        let (at, [r, g, b, a]) = (i * LANES, &self.0);
        [
            f32x16::from_slice(s, &r[at..at + LANES]),
            f32x16::from_slice(s, &g[at..at + LANES]),
            f32x16::from_slice(s, &b[at..at + LANES]),
            f32x16::from_slice(s, &a[at..at + LANES]),
        ]
    }

    fn pixel(&self, place: usize) -> [f32; 4] {
        self.0.each_ref().map(|c| c[place])
    }
}

pub(crate) struct Canvas {
    /// Packed straight RGBA bytes, red lowest.
    words: Vec<u32>,
    /// Block by block.
    light: Vec<f32>,
}

impl Canvas {
    pub(crate) fn new() -> Self {
        Self {
            words: vec![0; PIXELS],
            light: vec![0.0; 4 * PIXELS],
        }
    }

    pub(crate) fn fill_words(&mut self, word: u32) {
        self.words.fill(word);
    }

    pub(crate) fn fill_light(&mut self, color: [f32; 4]) {
        for block in self.light.as_chunks_mut::<FLOATS>().0 {
            for (channel, value) in block.chunks_exact_mut(LANES).zip(color) {
                channel.fill(value);
            }
        }
    }

    pub(crate) fn words_mut(&mut self) -> &mut [u32] {
        &mut self.words
    }

    pub(crate) fn light_mut(&mut self) -> &mut [f32] {
        &mut self.light
    }

    /// Puts one finished pixel all over a run.
    pub(crate) fn put_word(&mut self, level: Level, run: &[RunBlock], word: u32) {
        let words = &mut self.words;
        on_wide_level!(
            level,
            s => for at in run {
                put_block(s, words, *at, u32x16::splat(s, word));
            },
            else for at in run {
                let start = at.block as usize * LANES;
                for bit in bits(at.mask) {
                    words[start + bit] = word;
                }
            }
        );
    }

    /// Puts finished pixels of a run, sixteen a block.
    pub(crate) fn put_words(&mut self, run: &[RunBlock], words: &[u32]) {
        for (at, from) in run.iter().zip(words.chunks_exact(LANES)) {
            let start = at.block as usize * LANES;
            let to = &mut self.words[start..start + LANES];
            if at.mask == u16::MAX {
                to.copy_from_slice(from);
            } else {
                for (bit, (to, from)) in to.iter_mut().zip(from).enumerate() {
                    if at.mask >> bit & 1 == 1 {
                        *to = *from;
                    }
                }
            }
        }
    }

    /// Puts opaque colours as finished pixels.
    pub(crate) fn put_finished(
        &mut self,
        level: Level,
        mode: ColorMode,
        run: &[RunBlock],
        colors: &Colors,
    ) {
        let mut words = [0; RUN_ROOM];
        on_wide_level!(
            level,
            s => for i in 0..run.len() {
                let word = finish_lanes(s, mode, colors.lanes(s, i));
                word.store_slice(&mut words[i * LANES..(i + 1) * LANES]);
            },
            else for (i, at) in run.iter().enumerate() {
                for bit in bits(at.mask) {
                    let place = i * LANES + bit;
                    words[place] = finish(mode, colors.pixel(place));
                }
            }
        );
        self.put_words(run, &words);
    }

    /// Puts opaque colours.
    pub(crate) fn put(&mut self, level: Level, run: &[RunBlock], colors: &Colors) {
        let light = &mut self.light;
        on_wide_level!(
            level,
            s => for (i, at) in run.iter().enumerate() {
                let pixels = mask32x16::from_bitmask(s, u64::from(at.mask));
                let to = block_mut(light, at.block);
                let front = colors.lanes(s, i);
                for c in 0..4 {
                    let to = &mut to[c * LANES..(c + 1) * LANES];
                    if at.mask == u16::MAX {
                        front[c].store_slice(to);
                    } else {
                        let back = f32x16::from_slice(s, to);
                        pixels.select(front[c], back).store_slice(to);
                    }
                }
            },
            else for (i, at) in run.iter().enumerate() {
                for bit in bits(at.mask) {
                    let to = at.block as usize * LANES + bit;
                    for (channel, value) in colors.pixel(i * LANES + bit).into_iter().enumerate() {
                        light[place(channel, to)] = value;
                    }
                }
            }
        );
    }

    /// Lays the blocks of a run, one after the other, over what is there, and marks in `covered` the pixels that are not all clear.
    pub(crate) fn over(
        &mut self,
        level: Level,
        run: &[RunBlock],
        colors: &Colors,
        covered: &mut [u16],
    ) {
        let light = &mut self.light;
        on_wide_level!(
            level,
            s => for (i, at) in run.iter().enumerate() {
                over_block(s, light, *at, colors.lanes(s, i), covered);
            },
            else for (i, at) in run.iter().enumerate() {
                for bit in bits(at.mask) {
                    let to = at.block as usize * LANES + bit;
                    let front = colors.pixel(i * LANES + bit);
                    let back = [0, 1, 2, 3].map(|c| light[place(c, to)]);
                    for (c, value) in over(front, back).into_iter().enumerate() {
                        light[place(c, to)] = value;
                    }
                    covered[at.block as usize] |= u16::from(front[3] > 0.0) << bit;
                }
            }
        );
    }

    /// Finishes all pixels.
    pub(crate) fn finish(&mut self, level: Level, mode: ColorMode) {
        let Self { words, light } = self;
        on_wide_level!(
            level,
            s => for (i, word) in words.chunks_exact_mut(LANES).enumerate() {
                finish_lanes(s, mode, light_lanes(s, light, i)).store_slice(word);
            },
            else for (i, word) in words.iter_mut().enumerate() {
                *word = finish(mode, [0, 1, 2, 3].map(|c| light[place(c, i)]));
            }
        );
    }

    /// The mean of four colours.
    pub(crate) fn mean([a, b, c, d]: [[f32; 4]; 4]) -> [f32; 4] {
        [0, 1, 2, 3].map(|k| ((a[k] + b[k]) + (c[k] + d[k])) * 0.25)
    }

    /// The light of a finished opaque pixel of raw mode, as [`unpack_lanes`](texmap_sample::lanes::packed::unpack_lanes) has it.
    pub(crate) fn light_of_word(&self, index: usize) -> [f32; 4] {
        let bytes = self.words[index].to_le_bytes();
        bytes.map(|byte| f32::from(byte) * (1.0 / 255.0))
    }

    /// The mean of four canvases, as finished pixels. (The sums of pairs: four equal colours stay what they are.)
    pub(crate) fn resolve(&mut self, level: Level, mode: ColorMode, samples: [&Self; 4]) {
        let words = &mut self.words;
        let [a, b, c, d] = samples.map(|canvas| &canvas.light);
        on_wide_level!(
            level,
            s => for (i, word) in words.chunks_exact_mut(LANES).enumerate() {
                let (a, b) = (light_lanes(s, a, i), light_lanes(s, b, i));
                let (c, d) = (light_lanes(s, c, i), light_lanes(s, d, i));
                let mut mean = a;
                for k in 0..4 {
                    mean[k] = ((a[k] + b[k]) + (c[k] + d[k])) * 0.25;
                }
                finish_lanes(s, mode, mean).store_slice(word);
            },
            else for (i, word) in words.iter_mut().enumerate() {
                let pixel = |light: &[f32]| [0, 1, 2, 3].map(|channel| light[place(channel, i)]);
                *word = finish(mode, Self::mean([pixel(a), pixel(b), pixel(c), pixel(d)]));
            }
        );
    }

    /// [`resolve`](Self::resolve) of the finished opaque pixels of raw mode: the mean of bytes, halves up, is what the mean of their
    /// light comes to. Blocks that `alike` names take the first's.
    pub(crate) fn resolve_words(
        &mut self,
        level: Level,
        samples: [&Self; 4],
        alike: impl Fn(usize) -> bool,
    ) {
        let [a, b, c, d] = samples.map(|canvas| canvas.words.as_chunks::<LANES>().0);
        let words = self.words.as_chunks_mut::<LANES>().0;
        on_wide_level!(
            level,
            s => for (i, word) in words.iter_mut().enumerate() {
                if alike(i) {
                    *word = a[i];
                } else {
                    mean_lanes(s, [&a[i], &b[i], &c[i], &d[i]]).store_slice(word);
                }
            },
            else for (i, word) in words.iter_mut().enumerate() {
                *word = std::array::from_fn(|bit| if alike(i) {
                    a[i][bit]
                } else {
                    mean([a[i][bit], b[i][bit], c[i][bit], d[i][bit]])
                });
            }
        );
    }

    /// A finished pixel by its place in the tile's blocks.
    pub(crate) fn word_mut(&mut self, index: usize) -> &mut u32 {
        &mut self.words[index]
    }

    /// The light of a pixel by its place in the tile's blocks.
    pub(crate) fn light_at(&self, index: usize) -> [f32; 4] {
        [0, 1, 2, 3].map(|c| self.light[place(c, index)])
    }
}

/// Bytes 0 and 2 of a word.
const EVEN: u32 = 0x00ff_00ff;

/// The mean of each byte, halves up.
fn mean(samples: [u32; 4]) -> u32 {
    let half = |shift: u32| {
        let sum: u32 = samples.iter().map(|word| word >> shift & EVEN).sum();
        (sum + 0x0002_0002) >> 2 & EVEN
    };
    half(0) | half(8) << 8
}

/// [`mean`] for sixteen.
#[inline(always)]
fn mean_lanes<S: Simd>(s: S, [a, b, c, d]: [&[u32; LANES]; 4]) -> u32x16<S> {
    let [a, b, c, d] = [
        u32x16::from_slice(s, a),
        u32x16::from_slice(s, b),
        u32x16::from_slice(s, c),
        u32x16::from_slice(s, d),
    ];
    let even = ((a & EVEN) + (b & EVEN)) + ((c & EVEN) + (d & EVEN));
    let odd = (((a >> 8) & EVEN) + ((b >> 8) & EVEN)) + (((c >> 8) & EVEN) + ((d >> 8) & EVEN));
    let (even, odd) = (
        ((even + 0x0002_0002) >> 2) & EVEN,
        ((odd + 0x0002_0002) >> 2) & EVEN,
    );
    even | (odd << 8)
}

/// Where a channel of a pixel lies.
fn place(channel: usize, pixel: usize) -> usize {
    pixel / LANES * FLOATS + channel * LANES + pixel % LANES
}

#[inline(always)]
fn block_mut(light: &mut [f32], block: u16) -> &mut [f32] {
    let start = block as usize * FLOATS;
    &mut light[start..start + FLOATS]
}

/// The light of a block, channel by channel.
#[inline(always)]
fn light_lanes<S: Simd>(s: S, light: &[f32], block: usize) -> [f32x16<S>; 4] {
    let block = &light[block * FLOATS..(block + 1) * FLOATS];
    [
        f32x16::from_slice(s, &block[..LANES]),
        f32x16::from_slice(s, &block[LANES..2 * LANES]),
        f32x16::from_slice(s, &block[2 * LANES..3 * LANES]),
        f32x16::from_slice(s, &block[3 * LANES..]),
    ]
}

/// Set bits of a mask.
pub(crate) fn bits(mut mask: u16) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let bit = mask.trailing_zeros() as usize;
        mask &= mask.wrapping_sub(1);
        (bit < LANES).then_some(bit)
    })
}

/// Puts finished pixels of a block.
#[inline(always)]
pub(crate) fn put_block<S: Simd>(s: S, words: &mut [u32], at: RunBlock, front: u32x16<S>) {
    let start = at.block as usize * LANES;
    let to = &mut words[start..start + LANES];
    if at.mask == u16::MAX {
        front.store_slice(to);
    } else {
        let pixels = mask32x16::<S>::from_bitmask(s, u64::from(at.mask));
        pixels
            .select(front, u32x16::from_slice(s, to))
            .store_slice(to);
    }
}

/// [`Canvas::over`] for a block.
#[inline(always)]
pub(crate) fn over_block<S: Simd>(
    s: S,
    light: &mut [f32],
    at: RunBlock,
    front: [f32x16<S>; 4],
    covered: &mut [u16],
) {
    let (zero, one) = (f32x16::splat(s, 0.0), f32x16::splat(s, 1.0));
    let pixels = mask32x16::<S>::from_bitmask(s, u64::from(at.mask));
    let (solid, k) = (front[3].simd_ge(one), one - front[3]);
    let to = block_mut(light, at.block);
    if at.mask == u16::MAX && !solid.any_true() {
        for c in 0..4 {
            let to = &mut to[c * LANES..(c + 1) * LANES];
            let back = f32x16::from_slice(s, to);
            (front[c] + k * back).store_slice(to);
        }
    } else {
        for c in 0..4 {
            let to = &mut to[c * LANES..(c + 1) * LANES];
            let back = f32x16::from_slice(s, to);
            let mixed = solid.select(front[c], front[c] + k * back);
            pixels.select(mixed, back).store_slice(to);
        }
    }
    covered[at.block as usize] |= (pixels & front[3].simd_gt(zero)).to_bitmask() as u16;
}

/// `front` over `back`, both premultiplied.
fn over(front: [f32; 4], back: [f32; 4]) -> [f32; 4] {
    if front[3] >= 1.0 {
        return front;
    }
    let k = 1.0 - front[3];
    [0, 1, 2, 3].map(|c| front[c] + k * back[c])
}

/// Premultiplied light to packed straight bytes.
pub(crate) fn finish(mode: ColorMode, light: [f32; 4]) -> u32 {
    let encode = |c: f32| match mode {
        ColorMode::Srgb => color::linear_to_srgb8(c),
        ColorMode::Raw => color::unit_to_u8(c),
    };
    let [r, g, b] = straight(light).map(encode);
    u32::from_le_bytes([r, g, b, color::unit_to_u8(light[3])])
}

#[inline(always)]
fn finish_lanes<S: Simd>(s: S, mode: ColorMode, [r, g, b, a]: [f32x16<S>; 4]) -> u32x16<S> {
    let mut straight = [r, g, b];
    // A division by one changes nothing.
    if !a.simd_eq(f32x16::splat(s, 1.0)).all_true() {
        let some = a.simd_gt(f32x16::splat(s, 0.0));
        for c in &mut straight {
            *c = some.select(*c / a, f32x16::splat(s, 0.0));
        }
    }
    let [r, g, b] = straight;
    let (r, g, b) = match mode {
        ColorMode::Srgb => (
            lanes::linear_to_srgb8(s, r),
            lanes::linear_to_srgb8(s, g),
            lanes::linear_to_srgb8(s, b),
        ),
        ColorMode::Raw => (
            lanes::unit_to_u8(s, r),
            lanes::unit_to_u8(s, g),
            lanes::unit_to_u8(s, b),
        ),
    };
    r | (g << 8) | (b << 16) | (lanes::unit_to_u8(s, a) << 24)
}

/// A vector of a block from its three columns.
#[inline(always)]
pub(crate) fn vector<S: Simd>(s: S, [x, y, z]: [&[f32; RUN_ROOM]; 3], i: usize) -> [f32x16<S>; 3] {
    let at = i * LANES..(i + 1) * LANES;
    [
        f32x16::from_slice(s, &x[at.clone()]),
        f32x16::from_slice(s, &y[at.clone()]),
        f32x16::from_slice(s, &z[at]),
    ]
}

/// [`straight`] for sixteen.
#[inline(always)]
pub(crate) fn straight_lanes<S: Simd>(s: S, [r, g, b, a]: [f32x16<S>; 4]) -> [f32x16<S>; 3] {
    let zero = f32x16::splat(s, 0.0);
    let some = a.simd_gt(zero);
    [
        some.select(r / a, zero),
        some.select(g / a, zero),
        some.select(b / a, zero),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// In f32 the mean of four bytes' light is never on the wrong side of a half.
    #[test]
    fn mean_of_bytes_is_that_of_their_light() {
        let mut canvas = Canvas::new();
        for a in (0..=255).step_by(5) {
            for b in 0..=255 {
                for (c, d) in (0..=255)
                    .step_by(17)
                    .zip([0, 3, 80, 81, 250].into_iter().cycle())
                {
                    let bytes = [a, b, c, d];
                    let light = bytes.map(|byte: u32| {
                        *canvas.word_mut(0) = u32::from_le_bytes([byte as u8, 0, 0, 255]);
                        canvas.light_of_word(0)
                    });
                    let word = finish(ColorMode::Raw, Canvas::mean(light));
                    let words = bytes.map(|byte| byte | 0xff00_0000);
                    assert_eq!(mean(words), word, "{bytes:?}");
                }
            }
        }
    }
}

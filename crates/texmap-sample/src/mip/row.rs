//! Rows of texels with a plane for each channel: the form in which the levels of a mip chain are made.

use alloc::{vec, vec::Vec};

use crate::fetch::{color8, color16};
use crate::texel_data::Format;
use texmap_math::simd::{Isa, prelude::*};

/// Words of the texels that a kernel takes at once, at most.
const MOST: usize = 64;

/// A row of unscaled texels. Planes are longer than the row, so that a kernel may load and store whole vectors.
#[derive(Clone)]
pub(super) struct Row {
    width: usize,
    planes: [Vec<f32>; 4],
}

impl Row {
    pub(super) fn new(width: i32) -> Self {
        let width = width as usize;
        let plane = vec![0.0; width.next_multiple_of(32) + 32];
        Self {
            width,
            planes: [plane.clone(), plane.clone(), plane.clone(), plane],
        }
    }

    pub(super) fn set(&mut self, x: usize, texel: [f32; 4]) {
        for (plane, value) in self.planes.iter_mut().zip(texel) {
            plane[x] = value;
        }
    }

    /// Takes the texels of words.
    #[inline(always)]
    pub(super) fn load<I: Isa>(&mut self, i: I, format: Format, words: &[u32]) {
        let texels = words.chunks(I::LANES * format.words());
        for (k, words) in texels.enumerate() {
            let mut padded = [0; MOST];
            let words = match words.len() == I::LANES * format.words() {
                true => words,
                false => {
                    padded[..words.len()].copy_from_slice(words);
                    &padded
                }
            };
            self.store_at(k * I::LANES, unpack(i, format, words));
        }
    }

    /// The words of the texels, integers rounded half up and clamped; of unit vectors along them with `normals`.
    #[inline(always)]
    pub(super) fn store<I: Isa>(&self, i: I, format: Format, normals: bool, words: &mut [u32]) {
        let texels = words.chunks_mut(I::LANES * format.words());
        for (k, words) in texels.enumerate() {
            let mut texels = self.load_at(i, k * I::LANES);
            if normals {
                texels = normalized(i, texels, format.units());
            }
            match words.len() == I::LANES * format.words() {
                true => pack(i, format, texels, words),
                false => {
                    let mut padded = [0; MOST];
                    pack(i, format, texels, &mut padded);
                    words.copy_from_slice(&padded[..words.len()]);
                }
            }
        }
    }

    /// The weighted sums of texels 2x, 2x + 1 and 2x + 2 of `rows`, as many as there are weights.
    #[inline(always)]
    pub(super) fn reduce<I: Isa>(&mut self, i: I, rows: &[&Self], wy: &[f64], wx: &[Vec<f64>]) {
        // Two weights are halves, and a quarter is exact and may come last.
        match (wx.len(), wy.len()) {
            (2, 2) => self.sums::<I, true>(i, rows, wy, wx),
            _ => self.sums::<I, false>(i, rows, wy, wx),
        }
    }

    /// The sums of [`reduce`](Self::reduce); `MEANS` are those of two by two texels.
    #[inline(always)]
    fn sums<I: Isa, const MEANS: bool>(
        &mut self,
        i: I,
        rows: &[&Self],
        wy: &[f64],
        wx: &[Vec<f64>],
    ) {
        for at in (0..self.width).step_by(I::LANES) {
            let mut sums = [i.f64(0.0); 4];
            for (row, wy) in rows.iter().zip(wy) {
                let mut weights = [i.f64(0.0); 3];
                if !MEANS {
                    for (weight, wx) in weights.iter_mut().zip(wx) {
                        *weight = i.load_f64(&wx[at..]) * *wy;
                    }
                }
                for (sum, plane) in sums.iter_mut().zip(&row.planes) {
                    let [first, second] = pairs(i, &plane[2 * at..]);
                    if MEANS {
                        *sum = *sum + i.widen(first) + i.widen(second);
                        continue;
                    }
                    *sum = *sum + weights[0] * i.widen(first);
                    if wx.len() > 1 {
                        *sum = *sum + weights[1] * i.widen(second);
                    }
                    if wx.len() > 2 {
                        let [third, _] = pairs(i, &plane[2 * at + 2..]);
                        *sum = *sum + weights[2] * i.widen(third);
                    }
                }
            }
            for (plane, sum) in self.planes.iter_mut().zip(sums) {
                let sum = if MEANS { sum * 0.25 } else { sum };
                i.narrow(sum).store(&mut plane[at..]);
            }
        }
    }

    #[inline(always)]
    fn load_at<I: Isa>(&self, i: I, x: usize) -> [I::F32; 4] {
        let [r, g, b, a] = &self.planes;
        [
            i.load_f32(&r[x..]),
            i.load_f32(&g[x..]),
            i.load_f32(&b[x..]),
            i.load_f32(&a[x..]),
        ]
    }

    #[inline(always)]
    fn store_at<F: Number<f32>>(&mut self, x: usize, texels: [F; 4]) {
        for (plane, values) in self.planes.iter_mut().zip(texels) {
            values.store(&mut plane[x..]);
        }
    }
}

/// The even and the odd values.
#[inline(always)]
fn pairs<I: Isa>(i: I, values: &[f32]) -> [I::F32; 2] {
    let (a, b) = (i.load_f32(values), i.load_f32(&values[I::LANES..]));
    let [even, odd] = i.deinterleave(a.to_bits(), b.to_bits());
    [even.to_f32_bits(), odd.to_f32_bits()]
}

/// The channels of texels.
#[inline(always)]
fn unpack<I: Isa>(i: I, format: Format, words: &[u32]) -> [I::F32; 4] {
    match format {
        Format::Rgba8 => color8(i, false, i.load_u32(words)),
        Format::Rgba16 => {
            let halves = i.deinterleave(i.load_u32(words), i.load_u32(&words[I::LANES..]));
            color16(i, false, halves)
        }
        Format::Rgba32 => {
            let [rb0, ga0] = i.deinterleave(i.load_u32(words), i.load_u32(&words[I::LANES..]));
            let [rb1, ga1] = i.deinterleave(
                i.load_u32(&words[2 * I::LANES..]),
                i.load_u32(&words[3 * I::LANES..]),
            );
            let [r, b] = i.deinterleave(rb0, rb1);
            let [g, a] = i.deinterleave(ga0, ga1);
            [
                r.to_f32_bits(),
                g.to_f32_bits(),
                b.to_f32_bits(),
                a.to_f32_bits(),
            ]
        }
        Format::R32 => {
            let x = i.load_u32(words).to_f32_bits();
            [x, x, x, i.f32(1.0)]
        }
    }
}

/// [`unpack`] undone.
#[inline(always)]
fn pack<I: Isa>(i: I, format: Format, [r, g, b, a]: [I::F32; 4], words: &mut [u32]) {
    let most = format.units();
    match format {
        Format::Rgba8 => {
            let rgb = rounded(i, r, most) | rounded(i, g, most) << 8 | rounded(i, b, most) << 16;
            (rgb | rounded(i, a, most) << 24).store(words);
        }
        Format::Rgba16 => {
            let (rg, ba) = (
                rounded(i, r, most) | rounded(i, g, most) << 16,
                rounded(i, b, most) | rounded(i, a, most) << 16,
            );
            let [low, high] = i.interleave(rg, ba);
            low.store(words);
            high.store(&mut words[I::LANES..]);
        }
        Format::Rgba32 => {
            let [rb0, rb1] = i.interleave(r.to_bits(), b.to_bits());
            let [ga0, ga1] = i.interleave(g.to_bits(), a.to_bits());
            let [w0, w1] = i.interleave(rb0, ga0);
            let [w2, w3] = i.interleave(rb1, ga1);
            for (part, values) in words.chunks_mut(I::LANES).zip([w0, w1, w2, w3]) {
                values.store(part);
            }
        }
        Format::R32 => r.to_bits().store(words),
    }
}

/// The nearest whole numbers of 0 to `most`, halves up; NaN gives 0.
#[inline(always)]
fn rounded<I: Isa>(i: I, x: I::F32, most: f32) -> I::U32 {
    (x.clamp(i.f32(0.0), i.f32(most)) + 0.5).to_i32().to_u32()
}

/// The unit vectors along means of unit vectors; +z where they cancel.
#[inline(always)]
fn normalized<I: Isa>(i: I, [x, y, z, a]: [I::F32; 4], units: f32) -> [I::F32; 4] {
    let (mut x, mut y, mut z) = (
        x * 2.0 / units - 1.0,
        y * 2.0 / units - 1.0,
        z * 2.0 / units - 1.0,
    );
    let mut length2 = x * x + y * y + z * z;
    let finite = length2.simd_lt(f32::INFINITY);
    if !finite.all_true() {
        // Floats whose squares are too large.
        x = finite.select(x, x * 1e-36);
        y = finite.select(y, y * 1e-36);
        z = finite.select(z, z * 1e-36);
        length2 = x * x + y * y + z * z;
    }
    let long = length2.simd_gt(1e-12);
    let length = long.select(length2, i.f32(1.0)).sqrt();
    let x = long.select(x / length, i.f32(0.0));
    let y = long.select(y / length, i.f32(0.0));
    let z = long.select(z / length, i.f32(1.0));
    [
        (x + 1.0) * 0.5 * units,
        (y + 1.0) * 0.5 * units,
        (z + 1.0) * 0.5 * units,
        a,
    ]
}

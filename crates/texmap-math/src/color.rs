//! Colour transfer: the sRGB curve (IEC 61966-2-1:1999) and its 8-bit tables, all made by this crate's own power function.

use crate::deterministic_f64;
use crate::float::floor_f32;

/// sRGB value to linear light. Below 0 the linear piece goes on, above 1 the curve; NaN passes.
#[must_use]
pub fn srgb_to_linear(c: f32) -> f32 {
    decode(c as f64) as f32
}

/// Linear light to an sRGB value. Below 0 the linear piece goes on, above 1 the curve; NaN passes.
#[must_use]
pub fn linear_to_srgb(c: f32) -> f32 {
    let c = f64::from(c);
    (if c <= 0.003_130_8 {
        c * 12.92
    } else {
        1.055 * deterministic_f64::pow(c, 1.0 / 2.4) - 0.055
    }) as f32
}

/// An 8-bit sRGB value to linear light in `[0, 1]`, by table.
#[inline]
#[must_use]
pub fn srgb8_to_linear(c: u8) -> f32 {
    SRGB8_TO_LINEAR[c as usize]
}

/// A 16-bit sRGB value to linear light in `[0, 1]`. It takes a power: whoever has many makes a table of all 65536 first.
#[must_use]
pub fn srgb16_to_linear(c: u16) -> f32 {
    srgb_to_linear(f32::from(c) / 65535.0)
}

/// An 8-bit sRGB value to linear light in 16 bits, by table, rounded to nearest; all 256 differ.
#[inline]
#[must_use]
pub fn srgb8_to_linear16(c: u8) -> u16 {
    SRGB8_TO_LINEAR16[c as usize]
}

/// Linear light to the nearest 8-bit sRGB value: the table's thresholds are exact to one f32. NaN gives 0.
#[must_use]
pub fn linear_to_srgb8(c: f32) -> u8 {
    // Number of the 255 rising thresholds that are at or below c.
    let mut count = 0;
    let mut step = 128;
    while step > 0 {
        if c >= SRGB8_THRESHOLDS[count + step - 1] {
            count += step;
        }
        step /= 2;
    }
    count as u8
}

/// `[0, 1]` to 8 bits, nearest, halves up: clamped by comparison, NaN gives 0.
#[inline(always)]
#[must_use]
pub fn unit_to_u8(c: f32) -> u8 {
    let c = if c > 0.0 { c } else { 0.0 };
    let c = if c < 1.0 { c } else { 1.0 };
    floor_f32(c * 255.0 + 0.5) as u8
}

/// Linear light of each 8-bit sRGB value.
pub static SRGB8_TO_LINEAR: [f32; 256] = {
    let mut table = [0.0; 256];
    let mut i = 0;
    while i < 256 {
        table[i] = decode(i as f64 / 255.0) as f32;
        i += 1;
    }
    table
};

/// Linear light of each 8-bit sRGB value, times 65535, rounded.
pub static SRGB8_TO_LINEAR16: [u16; 256] = {
    let mut table = [0; 256];
    let mut i = 0;
    while i < 256 {
        table[i] = (decode(i as f64 / 255.0) * 65535.0 + 0.5) as u16;
        i += 1;
    }
    table
};

pub(crate) static SRGB8_THRESHOLDS: [f32; 256] = SRGB8_THRESHOLD_TABLE;

/// The least f32 whose nearest 8-bit sRGB value is `i + 1`; the last is out of reach.
const SRGB8_THRESHOLD_TABLE: [f32; 256] = {
    let mut table = [f32::INFINITY; 256];
    let mut i = 0;
    while i < 255 {
        let exact = decode((i as f64 + 0.5) / 255.0);
        let near = exact as f32;
        table[i] = if (near as f64) < exact {
            near.next_up()
        } else {
            near
        };
        i += 1;
    }
    table
};

/// Bits of the f32 below which everything is sRGB 0: 2^-13.
pub(crate) const SRGB8_FIRST: u32 = 0x3900_0000;

/// Encoding of the f32 whose upper bits are `SRGB8_FIRST >> 16` + i, by one look-up and one addition: the upper half of an entry plus
/// the lower 16 bits of the f32 is its 8-bit sRGB value. An entry holds the value at the start of its part in the upper half, and in
/// the lower one what the bits of the threshold within that part lack of a carry. These are the finest parts with one threshold at most.
pub(crate) static SRGB8_STEPS: [u32; 1665] = {
    let mut table = [0; 1665];
    let (mut i, mut count) = (0, 0);
    while i < 1665 {
        let start = SRGB8_FIRST + ((i as u32) << 16);
        while f32::from_bits(start) >= SRGB8_THRESHOLD_TABLE[count] {
            count += 1;
        }
        let above = SRGB8_THRESHOLD_TABLE[count].to_bits() - start;
        table[i] = ((count as u32) << 16) + (0x1_0000_u32).saturating_sub(above);
        i += 1;
    }
    table
};

const fn decode(c: f64) -> f64 {
    if c <= 0.040_45 {
        c / 12.92
    } else {
        deterministic_f64::pow((c + 0.055) / 1.055, 2.4)
    }
}

/// Luminance of linear light (Rec. ITU-R BT.709): 0.2126 R + 0.7152 G + 0.0722 B.
#[must_use]
#[inline]
pub fn luminance([r, g, b]: [f32; 3]) -> f32 {
    0.2126 * r + 0.7152 * g + 0.0722 * b
}

/// [`luminance`] in f64.
#[must_use]
#[inline]
pub fn luminance_f64([r, g, b]: [f64; 3]) -> f64 {
    0.2126 * r + 0.7152 * g + 0.0722 * b
}

/// Straight colour of a premultiplied one; black where alpha is 0, less or NaN.
#[must_use]
#[inline]
pub fn straight([r, g, b, a]: [f32; 4]) -> [f32; 3] {
    if a > 0.0 {
        [r / a, g / a, b / a]
    } else {
        [0.0; 3]
    }
}

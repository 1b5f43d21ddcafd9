//! Blocks decoded one texel at a time, bit by bit as the specifications write them.

use crate::blocks::{
    BlockFormat,
    partitions::{ANCHORS, SUBSETS},
};

/// The codes, 0 to 255, of texel (x, y) of a block before anything is rounded: red, green, blue and alpha as the format stores them (one
/// channel three times, two with a third of 0). Those of BC7 are whole numbers, as its specification rounds. `None` if the block has
/// another length than [`BlockFormat::block_bytes`] or the texel lies outside. Source: Khronos Data Format Specification 1.3, sections 18 to 20.
pub fn block_texel(format: BlockFormat, block: &[u8], x: usize, y: usize) -> Option<[f64; 4]> {
    if block.len() != format.block_bytes() || x > 3 || y > 3 {
        return None;
    }
    let t = 4 * y + x;
    let bits = block
        .iter()
        .rev()
        .fold(0, |bits, byte| bits << 8 | u128::from(*byte));
    let (low, high) = (bits as u64, (bits >> 64) as u64);
    Some(match format {
        BlockFormat::Bc1 => colors(low, t, true),
        BlockFormat::Bc1Opaque => {
            let [r, g, b, _] = colors(low, t, true);
            [r, g, b, 255.0]
        }
        BlockFormat::Bc2 => {
            let [r, g, b, _] = colors(high, t, false);
            [r, g, b, (low >> (4 * t) & 15) as f64 * 255.0 / 15.0]
        }
        BlockFormat::Bc3 => {
            let [r, g, b, _] = colors(high, t, false);
            [r, g, b, channel(low, t)]
        }
        BlockFormat::Bc4 => {
            let x = channel(low, t);
            [x, x, x, 255.0]
        }
        BlockFormat::Bc5 => [channel(low, t), channel(high, t), 0.0, 255.0],
        BlockFormat::Bc7 => bc7(bits, t),
    })
}

/// Two 5:6:5 colours and one or two between them.
fn colors(bits: u64, t: usize, holes: bool) -> [f64; 4] {
    let ends = [bits & 0xffff, bits >> 16 & 0xffff];
    let unpacked = ends.map(|c| {
        [
            (c >> 11) as f64 * 255.0 / 31.0,
            (c >> 5 & 63) as f64 * 255.0 / 63.0,
            (c & 31) as f64 * 255.0 / 31.0,
        ]
    });
    let mix = |w: f64| [0, 1, 2].map(|k| unpacked[0][k] * (1.0 - w) + unpacked[1][k] * w);
    let four = ends[0] > ends[1] || !holes;
    let ([r, g, b], a) = match (bits >> (32 + 2 * t) & 3, four) {
        (0, _) => (mix(0.0), 255.0),
        (1, _) => (mix(1.0), 255.0),
        (2, true) => (mix(1.0 / 3.0), 255.0),
        (_, true) => (mix(2.0 / 3.0), 255.0),
        (2, false) => (mix(0.5), 255.0),
        (_, false) => ([0.0; 3], 0.0),
    };
    [r, g, b, a]
}

/// Two ends, and six or four values between them.
fn channel(bits: u64, t: usize) -> f64 {
    let (a, b) = ((bits & 255) as f64, (bits >> 8 & 255) as f64);
    match (bits >> (16 + 3 * t) & 7, a > b) {
        (0, _) => a,
        (1, _) => b,
        (k, true) => a + (b - a) * (k - 1) as f64 / 7.0,
        (6, false) => 0.0,
        (7, false) => 255.0,
        (k, false) => a + (b - a) * (k - 1) as f64 / 5.0,
    }
}

/// Bits that are read one field after the other.
struct Reader {
    bits: u128,
}

impl Reader {
    fn take(&mut self, count: usize) -> u32 {
        let field = (self.bits & ((1 << count) - 1)) as u32;
        self.bits >>= count;
        field
    }
}

/// One of eight modes: subsets, bits of partition, rotation, selection, colour, alpha, low bits of each end and of each subset, index and
/// second index.
const MODES: [[usize; 10]; 8] = [
    [3, 4, 0, 0, 4, 0, 1, 0, 3, 0],
    [2, 6, 0, 0, 6, 0, 0, 1, 3, 0],
    [3, 6, 0, 0, 5, 0, 0, 0, 2, 0],
    [2, 6, 0, 0, 7, 0, 1, 0, 2, 0],
    [1, 0, 2, 1, 5, 6, 0, 0, 2, 3],
    [1, 0, 2, 0, 7, 8, 0, 0, 2, 2],
    [1, 0, 0, 0, 7, 7, 1, 0, 4, 0],
    [2, 6, 0, 0, 5, 5, 1, 0, 2, 0],
];

fn bc7(bits: u128, t: usize) -> [f64; 4] {
    let mode = bits.trailing_zeros() as usize;
    let Some(numbers) = MODES.get(mode) else {
        return [0.0; 4];
    };
    let [
        subsets,
        partition,
        rotation,
        selection,
        color,
        alpha,
        each,
        shared,
        index,
        second,
    ] = *numbers;
    let mut reader = Reader {
        bits: bits >> (mode + 1),
    };
    let partition = reader.take(partition) as usize;
    let rotation = reader.take(rotation) as usize;
    let selection = reader.take(selection);
    let mut ends = [[[0_u32; 4]; 2]; 3];
    for channel in 0..4 {
        let width = if channel == 3 { alpha } else { color };
        for end in ends.iter_mut().take(subsets).flatten() {
            end[channel] = reader.take(width);
        }
    }
    let mut widths = [color, color, color, alpha];
    if each + shared > 0 {
        for subset in ends.iter_mut().take(subsets) {
            let mut low = reader.take(1);
            for (k, end) in subset.iter_mut().enumerate() {
                if k == 1 && each > 0 {
                    low = reader.take(1);
                }
                end.iter_mut().for_each(|c| *c = *c << 1 | low);
            }
        }
        widths = widths.map(|width| width + 1);
    }
    for end in ends.iter_mut().flatten() {
        for (c, width) in end.iter_mut().zip(widths) {
            // The bits, and their highest again below them.
            *c <<= 8 - width;
            *c |= *c >> width;
        }
        if alpha == 0 {
            end[3] = 255;
        }
    }
    let entry = match subsets {
        1 => 128,
        2 => partition,
        _ => 64 + partition,
    };
    let anchors = [
        0,
        (ANCHORS[entry] & 255) as usize,
        (ANCHORS[entry] >> 8) as usize,
    ];
    let mut indices = |width: usize, anchors: &[usize]| {
        let mut found = 0;
        for k in 0..16 {
            let width = width.saturating_sub(usize::from(anchors.contains(&k)));
            let index = reader.take(width);
            if k == t {
                found = index;
            }
        }
        found
    };
    let first = weight(index, indices(index, &anchors));
    let (mut color, mut alpha) = (first, first);
    if second > 0 {
        alpha = weight(second, indices(second, &[0]));
        if selection == 1 {
            (color, alpha) = (alpha, color);
        }
    }
    let [a, b] = ends[(SUBSETS[entry] >> (2 * t) & 3) as usize];
    let mut out = [0, 1, 2, 3].map(|k| {
        let w = if k == 3 { alpha } else { color };
        f64::from(((64 - w) * a[k] + w * b[k] + 32) >> 6)
    });
    if rotation > 0 {
        out.swap(rotation - 1, 3);
    }
    out
}

/// The weight of the second end in 64ths.
fn weight(bits: usize, index: u32) -> u32 {
    const TWO: [u32; 4] = [0, 21, 43, 64];
    const THREE: [u32; 8] = [0, 9, 18, 27, 37, 46, 55, 64];
    const FOUR: [u32; 16] = [0, 4, 9, 13, 17, 21, 26, 30, 34, 38, 43, 47, 51, 55, 60, 64];
    match bits {
        2 => TWO[index as usize],
        3 => THREE[index as usize],
        _ => FOUR[index as usize],
    }
}

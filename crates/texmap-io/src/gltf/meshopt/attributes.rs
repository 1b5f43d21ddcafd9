//! Elements of any size: differences of their bytes, byte by byte, in groups of sixteen elements.

use super::{Reader, body};

const VERSION_0: u8 = 0xa0;
const VERSION_1: u8 = 0xa1;
/// Elements of a group.
const GROUP: usize = 16;
/// Elements of a block, at most.
const BLOCK: usize = 256;

/// `count` elements of `stride` bytes, a multiple of 4 up to 256.
pub(super) fn decode(bytes: &[u8], count: usize, stride: usize) -> Result<Vec<u8>, String> {
    let tail = |header| match header {
        VERSION_0 => stride.max(32),
        _ => (stride + stride / 4).max(24),
    };
    let (header, mut reader, tail) = body(bytes, &[VERSION_0, VERSION_1], tail)?;
    let newer = header == VERSION_1;
    let modes = if newer { stride / 4 } else { 0 };
    let (tail, modes) = tail.split_at(tail.len() - modes);
    let first = &tail[tail.len() - stride..];
    let channels = (0..stride / 4).map(|k| Channel::of(modes.get(k).copied().unwrap_or(0)));
    let channels = channels.collect::<Result<Vec<_>, _>>()?;

    let mut out = vec![0; count * stride];
    let mut before = first.to_vec();
    let most = ((8192 / stride) & !(GROUP - 1)).min(BLOCK);
    for block in out.chunks_mut(most * stride) {
        let elements = block.len() / stride;
        let controls = reader.take(if newer { stride / 4 } else { 0 })?;
        for (k, channel) in channels.iter().enumerate() {
            let mut differences = [[0; BLOCK]; 4];
            for (byte, differences) in differences.iter_mut().enumerate() {
                let control = controls.get(k).map(|c| (c >> (2 * byte)) & 3);
                read(&mut reader, control, elements, differences)?;
            }
            let before = &mut before[4 * k..4 * k + 4];
            channel.sum(&differences, before, block, 4 * k, stride);
        }
    }
    reader.finish()?;
    Ok(out)
}

/// The differences of one byte of the elements of a block.
fn read(
    reader: &mut Reader<'_>,
    control: Option<u8>,
    elements: usize,
    out: &mut [u8; BLOCK],
) -> Result<(), String> {
    // Bits of a difference by the mode of a group.
    let bits = match control {
        None => [0, 2, 4, 8],
        Some(0) => [0, 1, 2, 4],
        Some(1) => [1, 2, 4, 8],
        Some(2) => return Ok(()),
        Some(_) => {
            out[..elements].copy_from_slice(reader.take(elements)?);
            return Ok(());
        }
    };
    let groups = elements.div_ceil(GROUP);
    let modes = reader.take(groups.div_ceil(4))?;
    let (out, _) = out.as_chunks_mut();
    for (k, out) in out.iter_mut().take(groups).enumerate() {
        let mode = modes[k / 4] >> (2 * (k % 4)) & 3;
        group(reader, bits[usize::from(mode)], out)?;
    }
    Ok(())
}

/// Sixteen differences of 0, 1, 2, 4 or 8 bits.
fn group(reader: &mut Reader<'_>, bits: usize, out: &mut [u8; GROUP]) -> Result<(), String> {
    match bits {
        0 => out.fill(0),
        1 => packed::<1>(reader, out)?,
        2 => packed::<2>(reader, out)?,
        4 => packed::<4>(reader, out)?,
        _ => out.copy_from_slice(reader.take(GROUP)?),
    }
    Ok(())
}

/// Sixteen differences of some bits. One whose bits are all set stands in a byte of its own behind them.
fn packed<const BITS: usize>(reader: &mut Reader<'_>, out: &mut [u8; GROUP]) -> Result<(), String> {
    let packed = reader.take(2 * BITS)?;
    let all = (1_u8 << BITS) - 1;
    let mut apart = 0_u32;
    for (k, out) in out.iter_mut().enumerate() {
        let bit = k * BITS % 8;
        // Single bits begin with the lowest, the others with the highest.
        let shift = if BITS == 1 { bit } else { 8 - BITS - bit };
        *out = (packed[k * BITS / 8] >> shift) & all;
        apart |= u32::from(*out == all) << k;
    }
    while apart != 0 {
        out[apart.trailing_zeros() as usize] = reader.byte()?;
        apart &= apart - 1;
    }
    Ok(())
}

/// Four bytes of an element and the kind of their differences.
enum Channel {
    Bytes,
    Halves,
    /// By exclusive or, turned left by some bits before they were stored.
    Words(u32),
}

impl Channel {
    fn of(mode: u8) -> Result<Self, String> {
        match (mode & 15, mode >> 4) {
            (0, 0) => Ok(Self::Bytes),
            (1, 0) => Ok(Self::Halves),
            (2, turn) => Ok(Self::Words(turn.into())),
            _ => Err(format!("there is no channel mode {mode:#04x}")),
        }
    }

    /// Adds up differences from the element `before`, and stores the sums at byte `at` of each element.
    fn sum(
        &self,
        differences: &[[u8; BLOCK]; 4],
        before: &mut [u8],
        block: &mut [u8],
        at: usize,
        stride: usize,
    ) {
        let mut sum = [before[0], before[1], before[2], before[3]];
        for (k, element) in block.chunks_exact_mut(stride).enumerate() {
            let d = [0, 1, 2, 3].map(|byte| differences[byte][k]);
            sum = match self {
                Self::Bytes => [0, 1, 2, 3].map(|i| {
                    let signed = (d[i] >> 1) ^ (d[i] & 1).wrapping_neg();
                    sum[i].wrapping_add(signed)
                }),
                Self::Halves => {
                    let half = |i: usize| {
                        let d = u16::from_le_bytes([d[i], d[i + 1]]);
                        let signed = (d >> 1) ^ (d & 1).wrapping_neg();
                        let sum = u16::from_le_bytes([sum[i], sum[i + 1]]);
                        sum.wrapping_add(signed).to_le_bytes()
                    };
                    let [[a, b], [c, d]] = [half(0), half(2)];
                    [a, b, c, d]
                }
                Self::Words(turn) => {
                    let d = u32::from_le_bytes(d).rotate_right(*turn);
                    (u32::from_le_bytes(sum) ^ d).to_le_bytes()
                }
            };
            element[at..at + 4].copy_from_slice(&sum);
        }
        before.copy_from_slice(&sum);
    }
}

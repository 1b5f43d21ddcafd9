use std::time::Duration;

use crate::Aov;

/// Bits of the f32 that marks a hole in an AOV: the canonical quiet NaN.
pub const HOLE_BITS: u32 = 0x7fc0_0000;

/// A finished picture.
#[derive(Clone, Debug)]
pub struct Frame {
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
    /// 4 bytes a pixel: sRGB (raw under `ColorMode::Raw`), straight alpha, rows top to bottom.
    pub rgba: Vec<u8>,
    /// The buffers that were asked for, in that order: AOV, channels, values. C order, shape (height,
    /// width, channels), rows top to bottom.
    pub aovs: Vec<(Aov, usize, AovData)>,
    /// Counts and times.
    pub stats: Stats,
    /// The scene's warnings, then those of its check and of drawing, one sentence each.
    pub warnings: Vec<String>,
}

/// Values of an AOV.
#[derive(Clone, Debug, PartialEq)]
pub enum AovData {
    /// Holes have the bits [`HOLE_BITS`].
    F32(Vec<f32>),
    /// Holes are `u32::MAX`.
    U32(Vec<u32>),
}

/// Counts and times of one frame. The times reach no pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Stats {
    /// Triangles of all meshes.
    pub triangles_submitted: u64,
    /// Triangles that reached a tile.
    pub triangles_drawn: u64,
    /// Triangles outside of the view, or facing away where that is culled.
    pub triangles_culled: u64,
    /// Triangles that were cut at the eye or near plane or at the guard band.
    pub triangles_clipped: u64,
    /// Triangles without area, on the screen or at all.
    pub triangles_degenerate: u64,
    /// Triangles with a vertex that is not finite after the transform: not drawn.
    pub triangles_non_finite: u64,
    /// Pixels in which a surface is seen (with supersampling: at least in one sample).
    pub pixels_covered: u64,
    /// Time per stage.
    pub times: Times,
}

/// Wall-clock time per stage.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Times {
    /// Checks, vertex attributes, mip chains.
    pub plan: Duration,
    /// Transform, clipping, set-up and binning.
    pub bin: Duration,
    /// Visibility, shading and the frame itself.
    pub draw: Duration,
}

/// Hash of the decoded pixels, see [`hash_pixels`].
#[must_use]
pub fn pixel_hash(frame: &Frame) -> String {
    hash_pixels(frame.width, frame.height, &frame.rgba)
}

/// Hash of decoded pixels: `fnv1a-128:` and 32 hexadecimal digits. It is the 128-bit FNV-1a (Fowler,
/// Noll, Vo; draft-eastlake-fnv) of width and height as little-endian u32, then the bytes of the pixels in
/// order. It guards against accidents, not against forgery.
#[must_use]
pub fn hash_pixels(width: u32, height: u32, bytes: &[u8]) -> String {
    let mut hash = PixelHash::new(width, height);
    hash.update(bytes);
    hash.digits()
}

/// [`hash_pixels`] of pixels that come in parts, in order.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PixelHash(u128);

impl PixelHash {
    /// The hash of a picture of this size, before its first byte.
    #[must_use]
    pub fn new(width: u32, height: u32) -> Self {
        let mut hash = Self(0x6c62_272e_07bb_0142_62b8_2175_6295_c58d);
        hash.update(&width.to_le_bytes());
        hash.update(&height.to_le_bytes());
        hash
    }

    /// Takes the next bytes.
    pub fn update(&mut self, bytes: &[u8]) {
        const PRIME: u128 = 0x0000_0000_0100_0000_0000_0000_0000_013b;
        self.0 = bytes.iter().fold(self.0, |hash, byte| {
            (hash ^ u128::from(*byte)).wrapping_mul(PRIME)
        });
    }

    /// `fnv1a-128:` and the digits.
    #[must_use]
    pub fn digits(&self) -> String {
        format!("fnv1a-128:{:032x}", self.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(width: u32, height: u32, rgba: Vec<u8>) -> Frame {
        Frame {
            width,
            height,
            rgba,
            aovs: Vec::new(),
            stats: Stats::default(),
            warnings: Vec::new(),
        }
    }

    #[test]
    fn hash_tells_size_and_bytes_apart() {
        let hashes = [
            pixel_hash(&frame(2, 1, vec![0; 8])),
            pixel_hash(&frame(1, 2, vec![0; 8])),
            pixel_hash(&frame(2, 1, vec![0, 0, 0, 0, 0, 0, 0, 1])),
        ];
        assert!(hashes[0] != hashes[1] && hashes[0] != hashes[2] && hashes[1] != hashes[2]);
    }

    /// Published test vector: FNV-1a 128 of "foobar" is 343e1662793c64bf6f0d3597ba446f18. The size bytes
    /// are the prefix, so the string is cut into width, height and pixels.
    #[test]
    fn hash_is_fnv1a_128() {
        let bytes = *b"chongo w";
        let width = u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]);
        let height = u32::from_le_bytes([bytes[4], bytes[5], bytes[6], bytes[7]]);
        let hash = pixel_hash(&frame(width, height, b"as here!\n".to_vec()));
        let mut expected = 0x6c62_272e_07bb_0142_62b8_2175_6295_c58du128;
        for byte in b"chongo was here!\n" {
            expected ^= u128::from(*byte);
            // The prime is 2^88 + 2^8 + 0x3b.
            expected = (expected << 88)
                .wrapping_add(expected << 8)
                .wrapping_add(expected.wrapping_mul(0x3b));
        }
        assert_eq!(hash, format!("fnv1a-128:{expected:032x}"));
    }
}

//! Bytes in 16-bit lanes: the steps of filters whose weights are bytes.

use fearless_simd::{Bytes, Select, Simd, SimdBase, i32x4, i32x16, u16x8, u16x32, u32x4, u32x16};

use super::{Isa, One, Scalar, X4, X16};
use crate::lanes;

/// The even and the odd bytes of 32-bit words, each in 16 bits.
#[derive(Clone, Copy, Debug)]
pub struct ByteHalves<T> {
    low: T,
    high: T,
}

/// An [`Isa`] with the steps of filters on words of four bytes. Every operation gives the same bits in a lane for each width.
pub trait ByteIsa: Isa {
    /// The four bytes of each lane's word, 16 bits each.
    type Bytes: Copy;
    /// A weight for each of them.
    type Weights: Copy;

    /// The bytes of words.
    fn bytes(self, words: Self::U32) -> Self::Bytes;
    /// The words of bytes, each below 256.
    fn words(self, bytes: Self::Bytes) -> Self::U32;
    /// The same weight, 0 to 255, for each byte of a word.
    fn weights(self, w: Self::I32) -> Self::Weights;
    /// `a + (b - a) w / 256`, halves up.
    fn lerp_bytes(self, a: Self::Bytes, b: Self::Bytes, w: Self::Weights) -> Self::Bytes;
    /// `sum + bytes` in the lanes that are true; sums stay below 65536.
    fn add_bytes(self, sum: Self::Bytes, bytes: Self::Bytes, mask: Self::Mask) -> Self::Bytes;
    /// The sums of the first byte, the second, the third and the last.
    fn byte_sums(self, sum: Self::Bytes) -> [Self::U32; 4];
}

const EVEN: u32 = 0x00ff_00ff;

/// Four 16-bit lanes of one u64: the even bytes, then the odd ones.
impl ByteIsa for Scalar {
    type Bytes = u64;
    type Weights = u64;

    #[inline(always)]
    fn bytes(self, words: One<u32>) -> u64 {
        u64::from(words.0 & EVEN) | u64::from(words.0 >> 8 & EVEN) << 32
    }
    #[inline(always)]
    fn words(self, bytes: u64) -> One<u32> {
        One(bytes as u32 | ((bytes >> 32) as u32) << 8)
    }
    #[inline(always)]
    fn weights(self, w: One<i32>) -> u64 {
        w.0 as u64
    }
    #[inline(always)]
    fn lerp_bytes(self, a: u64, b: u64, w: u64) -> u64 {
        const HALVES: u64 = 0x0080_0080_0080_0080;
        const BYTES: u64 = 0x00ff_00ff_00ff_00ff;
        // Each sum stays within its 16 bits.
        let sum = (a << 8)
            .wrapping_add(b.wrapping_sub(a).wrapping_mul(w))
            .wrapping_add(HALVES);
        sum >> 8 & BYTES
    }
    #[inline(always)]
    fn add_bytes(self, sum: u64, bytes: u64, mask: bool) -> u64 {
        if mask { sum.wrapping_add(bytes) } else { sum }
    }
    #[inline(always)]
    fn byte_sums(self, sum: u64) -> [One<u32>; 4] {
        [
            One(sum as u32 & 0xffff),
            One((sum >> 32) as u32 & 0xffff),
            One((sum >> 16) as u32 & 0xffff),
            One((sum >> 48) as u32),
        ]
    }
}

macro_rules! wide {
    ($isa:ident, $u16:ident, $i32:ident, $u32:ident, $lerp:expr) => {
        impl<S: Simd> ByteIsa for $isa<S> {
            type Bytes = ByteHalves<$u16<S>>;
            type Weights = $u16<S>;

            #[inline(always)]
            fn bytes(self, words: $u32<S>) -> Self::Bytes {
                ByteHalves {
                    low: (words & EVEN).bitcast(),
                    high: words.bitcast::<$u16<S>>() >> 8,
                }
            }
            #[inline(always)]
            fn words(self, bytes: Self::Bytes) -> $u32<S> {
                let (low, high): ($u32<S>, $u32<S>) = (bytes.low.bitcast(), bytes.high.bitcast());
                low | (high << 8)
            }
            #[inline(always)]
            fn weights(self, w: $i32<S>) -> $u16<S> {
                (w | (w << 16)).bitcast()
            }
            #[inline(always)]
            fn lerp_bytes(self, a: Self::Bytes, b: Self::Bytes, w: $u16<S>) -> Self::Bytes {
                ByteHalves {
                    low: $lerp(self.0, a.low, b.low, w),
                    high: $lerp(self.0, a.high, b.high, w),
                }
            }
            #[inline(always)]
            fn add_bytes(
                self,
                sum: Self::Bytes,
                bytes: Self::Bytes,
                mask: Self::Mask,
            ) -> Self::Bytes {
                let ones = $i32::splat(self.0, -1);
                let mask: $u16<S> = Select::select(mask, ones, $i32::splat(self.0, 0)).bitcast();
                ByteHalves {
                    low: sum.low + (bytes.low & mask),
                    high: sum.high + (bytes.high & mask),
                }
            }
            #[inline(always)]
            fn byte_sums(self, sum: Self::Bytes) -> [$u32<S>; 4] {
                let (low, high): ($u32<S>, $u32<S>) = (sum.low.bitcast(), sum.high.bitcast());
                [low & 0xffff, high & 0xffff, low >> 16, high >> 16]
            }
        }
    };
}
wide!(X16, u16x32, i32x16, u32x16, lanes::lerp_bytes);
wide!(X4, u16x8, i32x4, u32x4, lerp_x4);

#[inline(always)]
fn lerp_x4<S: Simd>(_: S, a: u16x8<S>, b: u16x8<S>, w: u16x8<S>) -> u16x8<S> {
    ((a << 8) + (b - a) * w + 128) >> 8
}

//! Textures that the benchmarks share.

use texmap_sample::{ColorSpace, Origin, Texture2d};

/// Squares of 64 texels with a little of everything on them: linear bytes, opaque, with mips.
///
/// # Panics
/// A side of 0 or above the limit.
#[must_use]
pub fn squares(side: u32) -> Texture2d<'static> {
    Texture2d::from_rgba8(
        side,
        side,
        square_texels(side),
        ColorSpace::Linear,
        Origin::TopLeft,
    )
    .expect("a good size")
    .with_mips()
}

/// The bytes of [`squares`].
#[must_use]
pub fn square_texels(side: u32) -> Vec<u8> {
    (0..side * side)
        .flat_map(|i| {
            let (x, y) = (i % side, i / side);
            let k = (x.wrapping_mul(0x9e37_79b1) ^ y.wrapping_mul(0x85eb_ca77)) >> 27;
            let square = ((x >> 6) ^ (y >> 6)) & 1 == 1;
            let c = if square { 200 } else { 60 };
            [(c + k) as u8, (c / 2 + k) as u8, (x ^ y) as u8, 255]
        })
        .collect()
}

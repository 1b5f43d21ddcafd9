//! A neutral room with bright windows.
//!
//! Its light is held in files, as it takes longer to make than many a model to draw; the tests make them again.

#[cfg(test)]
mod cast;

use texmap_math::simd::{One, Scalar};

use super::prefilter::{DIFFUSE_SIZE, level_size};
use super::roughnesses::STEPS;
use super::{EnvironmentLight, Prefilter, Roughnesses};
use crate::environment::Environment;
use crate::{EnvironmentLayout, LightError, shared_exponent};

/// Texels a side. The blur leaves nothing finer.
const SIZE: u32 = 64;

/// Texels of a cube with their borders.
const fn texels(side: usize) -> usize {
    6 * (side + 2) * (side + 2)
}

/// The grey texels of the room, f32 with the low byte first.
static ROOM: &[u8; 4 * texels(64)] = include_bytes!("studio/room.f32");
/// Those of the light of diffuse surfaces (all of it, and that at grazing incidence) and of the levels of roughness but the first, in
/// the words of [`shared_exponent`]: nine bits of one channel and five of the exponent, the low byte first.
static GATHERED: &[u8; 2 * (4 * texels(64) + 5 * texels(32) + 4 * texels(16))] =
    include_bytes!("studio/gathered.u14");

/// The light of the room as its eye sees it.
pub(super) fn room() -> Environment {
    let (texels, _) = ROOM.as_chunks();
    let texels = texels.iter().map(|bytes| [f32::from_le_bytes(*bytes); 3]);
    Environment::with_borders(EnvironmentLayout::Cube, (SIZE, SIZE), texels.collect())
}

/// The light of diffuse surfaces and of the levels of roughness but the first.
pub(super) fn gathered() -> ([Environment; 2], [Environment; STEPS]) {
    let (mut codes, _) = GATHERED.as_chunks();
    let mut cube = |size: u32| {
        let (own, rest) = codes.split_at(texels(size as usize));
        codes = rest;
        let light = |bytes: &[u8; 2]| {
            let code = u32::from(u16::from_le_bytes(*bytes));
            let channel = code & 511;
            let word = channel | channel << 9 | channel << 18 | (code >> 9) << 27;
            shared_exponent::unpack(Scalar, One(word))
        };
        let own = own.iter().map(light).collect();
        Environment::with_borders(EnvironmentLayout::Cube, (size, size), own)
    };
    let diffuse = [(); 2].map(|()| cube(DIFFUSE_SIZE));
    (
        diffuse,
        core::array::from_fn(|k| cube(level_size(SIZE, k + 1))),
    )
}

/// The error of a size, which is a constant within range.
fn out_of_range<T>(error: LightError) -> T {
    unreachable!("the size is within range: {error}")
}

impl EnvironmentLight {
    /// A neutral studio: a white room with bright windows on four sides and boxes on its floor, for looking at a model that brings
    /// no light of its own. Its irradiance from above is about 1.4 pi. [`Prefilter::studio`] makes it for some roughnesses alone.
    #[must_use]
    pub fn studio() -> Self {
        let light = Prefilter::studio().light(Roughnesses::ALL);
        light.unwrap_or_else(out_of_range)
    }
}

//! A neutral room with bright windows.
//!
//! Its light is held in a file, as casting and blurring it takes longer than drawing many a model; the tests make it anew.

#[cfg(test)]
mod cast;

use super::{EnvironmentLight, Prefilter, Roughnesses};
use crate::environment::Environment;
use crate::{EnvironmentLayout, LightError};

/// Texels a side. The blur leaves nothing finer.
const SIZE: u32 = 64;
/// The grey texels of a cube with their borders, f32 with the low byte first.
static ROOM: &[u8; 4 * 6 * (SIZE as usize + 2).pow(2)] = include_bytes!("studio/room.f32");

/// The light of the room as its eye sees it.
pub(super) fn room() -> Environment {
    let (texels, _) = ROOM.as_chunks();
    let texels = texels.iter().map(|bytes| [f32::from_le_bytes(*bytes); 3]);
    Environment::with_borders(EnvironmentLayout::Cube, (SIZE, SIZE), texels.collect())
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

//! Light in bands: pixel by pixel between the stages that have lanes.

use crate::canvas::{LANES, bits};
use crate::textures::Slot;
use texmap_math::color::{luminance, straight};

/// Light along a ramp, by its luminance.
#[inline(never)]
pub(super) fn banded(ramp: &Slot<'_>, pixels: u16, light: &[[f32; LANES]; 3]) -> [[f32; LANES]; 3] {
    let mut out = [[0.0; LANES]; 3];
    for bit in bits(pixels) {
        let band = ramp.along(luminance(light.map(|c| c[bit])));
        for (column, c) in out.iter_mut().zip(straight(band)) {
            column[bit] = c;
        }
    }
    out
}

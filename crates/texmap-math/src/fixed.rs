//! Screen positions in 24.8 fixed point.

use glam::DVec2;

use crate::float::round_half_up;

/// Fraction bits of a snapped position.
pub const SUBPIXEL_BITS: u32 = 8;
/// One pixel in snapped units.
pub const SUBPIXEL_ONE: i32 = 1 << SUBPIXEL_BITS;
/// Largest absolute screen coordinate that can be snapped, in pixels: 2^21, so that edge functions stay exact in i64.
pub const LIMIT: f64 = 2_097_152.0;

/// A position in 1/256 pixel: x to the right, y down.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct FixedPoint {
    /// To the right, 24.8.
    pub x: i32,
    /// Down, 24.8.
    pub y: i32,
}

impl FixedPoint {
    /// The centre of pixel (`x`, `y`), for coordinates below 2^21.
    #[inline]
    #[must_use]
    pub const fn pixel_centre(x: i32, y: i32) -> Self {
        Self {
            x: x * SUBPIXEL_ONE + SUBPIXEL_ONE / 2,
            y: y * SUBPIXEL_ONE + SUBPIXEL_ONE / 2,
        }
    }
}

/// `x` in pixels to the nearest 1/256, halves up; None beyond [`LIMIT`] and for NaN.
#[inline]
#[must_use]
pub fn snap(x: f64) -> Option<i32> {
    (x.abs() <= LIMIT).then(|| round_half_up(x * f64::from(SUBPIXEL_ONE)) as i32)
}

/// [`snap`] for both coordinates.
#[inline]
#[must_use]
pub fn snap_point(p: DVec2) -> Option<FixedPoint> {
    Some(FixedPoint {
        x: snap(p.x)?,
        y: snap(p.y)?,
    })
}

//! Choosing a texel and tiling it, in integers.

use crate::float::floor;

/// `value` modulo `size`, in `0..size` for every value. After MIT 6.837, lecture 18, slide 16, in one step instead of one per
/// repeat. None for a size that is not above 0.
#[inline]
#[must_use]
pub const fn tile(value: i32, size: i32) -> Option<i32> {
    if size > 0 {
        Some(value.rem_euclid(size))
    } else {
        None
    }
}

/// The texel that holds coordinate `u` of a texture `size` texels wide: `floor(u * size)`, so that every texel is equally wide, below
/// zero too; not wrapped. Saturates at the ends of i32; NaN gives 0.
#[inline]
#[must_use]
pub fn texel(u: f64, size: u32) -> i32 {
    floor(u * f64::from(size)) as i32
}

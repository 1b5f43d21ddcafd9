//! Vectors between arrays of f32, as meshes hold them, and f64, in which geometry is computed.

use glam::DVec3;

/// A vector of f32 as f64: exact.
#[must_use]
#[inline]
pub fn wide(v: [f32; 3]) -> DVec3 {
    DVec3::from(v.map(f64::from))
}

/// A vector of f64 rounded to f32; beyond the range of f32 infinite, NaN stays NaN.
#[must_use]
#[inline]
pub fn narrow(v: DVec3) -> [f32; 3] {
    v.to_array().map(|x| x as f32)
}

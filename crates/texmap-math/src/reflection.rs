//! Mirror directions.

use glam::DVec3;

/// The mirror image of `v` at the unit normal `n`, both pointing away from the surface: `2 (n.v) n - v`. Its length is that of `v`.
#[inline]
#[must_use]
pub fn reflect(v: DVec3, n: DVec3) -> DVec3 {
    n * (2.0 * n.dot(v)) - v
}

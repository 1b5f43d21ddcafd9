//! What the suites share: SIMD levels, strategies, scenes, golden images.

pub mod levels;
pub mod tilted_plane;

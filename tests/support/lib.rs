//! Support of the suites: SIMD levels, strategies, scenes, golden images.

#[cfg(unix)]
pub mod attack;
pub mod exr_files;
pub mod golden;
pub mod levels;

/// The README's library example, compiled.
#[cfg(doctest)]
#[doc = include_str!("../../README.md")]
struct Readme;

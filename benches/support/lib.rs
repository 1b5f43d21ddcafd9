//! Scenes and clocks that the benchmarks share.

pub mod scenes;

//! Scenes and clocks that the benchmarks share.

pub mod bench_scenes;
pub mod chart;
pub mod floor;
pub mod meshes;
pub mod scenes;
pub mod textures;

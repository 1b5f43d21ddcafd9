//! Scenes and clocks that the benchmarks share.

//! Laws and regressions of texmap-math.

mod clipping;
mod colour;
mod coverage;
mod det;
mod det32;
mod frames;
mod lanes;
mod quad;
mod simd;
mod span;
mod strategies;
mod triangle;
mod viewing;
mod wrap;

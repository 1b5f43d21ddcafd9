//! Laws and regressions of the sampler.

mod filters;
mod lanes;
mod levels;
mod light;
mod plane;
mod support;
mod wraps;

//! Laws and regressions of texmap-math.

mod det32;
mod lanes;

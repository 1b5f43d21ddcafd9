//! Laws and regressions of texmap-math.

mod lanes;

//! Laws and regressions of lighting effects.

mod charts;
mod waves;

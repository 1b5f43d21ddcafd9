//! Laws and regressions of coverage, depth, interpolation and the front end.
mod support;

mod coverage;
mod horizon;
mod interpolation;
mod levels;
mod modes;
mod robust;

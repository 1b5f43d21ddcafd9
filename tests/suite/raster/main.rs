//! Laws and regressions of coverage, depth, interpolation and the front end.
mod support;

mod atlas;
mod coverage;
mod depth;
mod fragments;
mod horizon;
mod interpolation;
mod levels;
mod modes;
mod robust;
mod steepest;
mod thin_walls;

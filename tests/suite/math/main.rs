//! Laws and regressions of this area.

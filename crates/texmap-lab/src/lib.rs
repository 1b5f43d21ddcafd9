//! texmap-lab
#![forbid(unsafe_code)]

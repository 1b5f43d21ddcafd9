//! texmap-render
#![forbid(unsafe_code)]

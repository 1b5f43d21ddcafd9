//! texmap-io
#![forbid(unsafe_code)]

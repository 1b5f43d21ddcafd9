//! Rebuilds every asset.
fn main() {}

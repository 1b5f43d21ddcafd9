//! The program `texmap`.
fn main() {}

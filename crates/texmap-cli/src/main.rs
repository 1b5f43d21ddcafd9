//! The program `texmap`. Everything it does is in the library beside it, so that the end-to-end
//! tests can build the same program as a binary of their own package.
#![forbid(unsafe_code)]

use std::process::ExitCode;

#[global_allocator]
static ALLOCATOR: texmap_cli::Allocator = texmap_cli::Allocator;

fn main() -> ExitCode {
    texmap_cli::main()
}

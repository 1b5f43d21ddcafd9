//! The program `texmap`, built as a binary of the test package: that is how cargo tells the
//! end-to-end tests where it stands, in any target folder and from a bare clone.

use std::process::ExitCode;

#[global_allocator]
static ALLOCATOR: texmap_cli::Allocator = texmap_cli::Allocator;

fn main() -> ExitCode {
    texmap_cli::main()
}

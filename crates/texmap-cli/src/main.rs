//! The program `texmap`. Everything it does is in the library beside it, so that the end-to-end
//! tests can build the same program as a binary of their own package.
#![forbid(unsafe_code)]

use std::process::ExitCode;

fn main() -> ExitCode {
    texmap_cli::main()
}

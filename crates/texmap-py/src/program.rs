//! The program `texmap` inside of the package.

use std::ffi::OsString;

use pyo3::prelude::*;

/// Runs the program on these arguments, the first of which is its name, and returns its exit code.
#[pyfunction]
pub(crate) fn main(py: Python<'_>, arguments: Vec<OsString>) -> u8 {
    py.detach(|| texmap_cli::run_program(&arguments))
}

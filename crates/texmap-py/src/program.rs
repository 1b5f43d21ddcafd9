//! The program `texmap` inside of the package.

use std::ffi::OsString;

use pyo3::prelude::*;

/// Runs the program on these arguments, the first of which is its name, and returns its exit code. `again` are the words that start it again,
/// for the processes of a batch.
#[pyfunction]
pub(crate) fn main(py: Python<'_>, arguments: Vec<OsString>, again: Vec<OsString>) -> u8 {
    texmap_cli::started_by(again);
    py.detach(|| texmap_cli::run_program(&arguments))
}

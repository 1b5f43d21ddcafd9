//! The extension module `texmap._texmap`: the kernels behind the Python package `texmap`.
//!
//! Every function takes flat contiguous arrays and writes into arrays of the caller; shapes, defaults and messages about them
//! are the matter of the Python layer. The interpreter lock is released around all work.
#![deny(unsafe_code)]

use pyo3::prelude::*;

mod antialias;
mod attributes;
mod by_levels;
mod cube;
mod image;
mod light;
mod look_up;
mod peel;
mod perspective;
mod planes;
mod poses;
mod program;
mod rast;
mod rasterize;
mod render;
mod scene;
mod support;
mod texel_gradient;
mod texture;
mod uv;

#[pymodule]
fn _texmap(m: &Bound<'_, PyModule>) -> PyResult<()> {
    support::numpy_api(m.py())?;
    m.add("__version__", env!("CARGO_PKG_VERSION"))?;
    m.add_class::<scene::Scene>()?;
    m.add_class::<texture::Texture>()?;
    m.add_class::<cube::Cube>()?;
    m.add_function(wrap_pyfunction!(scene::load, m)?)?;
    m.add_function(wrap_pyfunction!(render::render, m)?)?;
    m.add_function(wrap_pyfunction!(render::check_cameras, m)?)?;
    m.add_function(wrap_pyfunction!(look_up::sample, m)?)?;
    m.add_function(wrap_pyfunction!(by_levels::sample_levels, m)?)?;
    m.add_function(wrap_pyfunction!(cube::sample_cube, m)?)?;
    m.add_function(wrap_pyfunction!(rasterize::rasterize, m)?)?;
    m.add_function(wrap_pyfunction!(attributes::interpolate, m)?)?;
    m.add_function(wrap_pyfunction!(attributes::interpolate_gradient, m)?)?;
    m.add_function(wrap_pyfunction!(texel_gradient::texture_gradient, m)?)?;
    m.add_function(wrap_pyfunction!(antialias::topology, m)?)?;
    m.add_function(wrap_pyfunction!(antialias::antialias, m)?)?;
    m.add_function(wrap_pyfunction!(image::warp, m)?)?;
    m.add_function(wrap_pyfunction!(image::read_image, m)?)?;
    m.add_function(wrap_pyfunction!(image::homography, m)?)?;
    m.add_function(wrap_pyfunction!(image::diff, m)?)?;
    m.add_function(wrap_pyfunction!(image::diff_f64, m)?)?;
    m.add_function(wrap_pyfunction!(image::pixel_hash, m)?)?;
    m.add_function(wrap_pyfunction!(uv::unwrap, m)?)?;
    m.add_function(wrap_pyfunction!(uv::uv_map, m)?)?;
    m.add_function(wrap_pyfunction!(uv::uv_report, m)?)?;
    m.add_function(wrap_pyfunction!(uv::tangents, m)?)?;
    m.add_function(wrap_pyfunction!(uv::uv_raster, m)?)?;
    m.add_function(wrap_pyfunction!(light::bake, m)?)?;
    m.add_function(wrap_pyfunction!(light::env, m)?)?;
    m.add_function(wrap_pyfunction!(light::set_environment, m)?)?;
    m.add_function(wrap_pyfunction!(perspective::perspective_interpolate, m)?)?;
    m.add_function(wrap_pyfunction!(program::main, m)?)?;
    Ok(())
}

//! Laws of the uv mapper and their negative twins.

mod crowds;
mod invariance;
mod mapping;
mod meshes;
mod program;
mod raster;
mod repair;
mod report;
mod tangents;

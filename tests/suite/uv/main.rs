//! Laws of the uv mapper and their negative twins.

mod meshes;
mod mapping;
mod program;
mod repair;
mod report;

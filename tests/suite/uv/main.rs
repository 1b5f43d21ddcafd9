//! Laws of the uv mapper and their negative twins.

mod mapping;
mod meshes;
mod program;
mod repair;
mod report;

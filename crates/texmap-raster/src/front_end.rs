//! The front end: draws to triangles in the bins of tiles.

pub(crate) mod arrays;
pub(crate) mod bin;
pub(crate) mod clip;
pub(crate) mod prepared;
pub(crate) mod transform;

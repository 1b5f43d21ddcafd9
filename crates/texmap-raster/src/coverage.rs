//! Coverage: which pixels of a tile a triangle covers.

pub(crate) mod edge;
pub(crate) mod hierarchical_z;
pub(crate) mod stamp;

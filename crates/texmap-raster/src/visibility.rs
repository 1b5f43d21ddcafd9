//! Visibility: which of the covering triangles a pixel shows.

pub(crate) mod blocks;
pub(crate) mod depth_only;
pub(crate) mod fragments;
pub(crate) mod grazing_facets;
pub(crate) mod runs;
pub(crate) mod sinks;
pub(crate) mod visible;

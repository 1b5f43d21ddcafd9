//! From coordinates and derivatives to mip levels and texels.

pub(crate) mod lod;
pub(crate) mod texel;
pub(crate) mod wrap;

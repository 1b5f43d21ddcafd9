//! From shaded colors to the rows of the frame: tile color buffer, blending, 8-bit encoding, copies.

pub(crate) mod copy;
pub(crate) mod rows;
pub(crate) mod tile_buffer;

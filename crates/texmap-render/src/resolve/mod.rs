//! From shaded colors to the rows of the frame: tile color buffer, blending, 8-bit encoding, copies, output arrays.

pub(crate) mod aov;
pub(crate) mod blend;
pub(crate) mod copy;
pub(crate) mod encode;
pub(crate) mod rows;
pub(crate) mod tile_buffer;

//! OpenEXR: pictures in, pictures with arrays beside the colour out. The codec is compiled here alone, once for each direction.

mod header;
mod read;
mod write;

pub(crate) use read::{ExrFile, MAGIC};
pub(crate) use write::write_floats;
pub use write::{ExrLayer, write_exr};

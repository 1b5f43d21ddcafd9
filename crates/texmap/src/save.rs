//! Frames to files.

use std::path::Path;

use texmap_io::{IoError, image_io};
use texmap_render::Frame;

/// Writes a picture to a file. Only [`texmap_io`] sees files, so that the renderer stays without them.
pub trait SaveFrame {
    /// Writes an 8-bit RGBA PNG; the file appears complete or not at all.
    ///
    /// # Errors
    /// The file cannot be written.
    fn save(&self, path: impl AsRef<Path>) -> Result<(), IoError>;
}

impl SaveFrame for Frame {
    fn save(&self, path: impl AsRef<Path>) -> Result<(), IoError> {
        image_io::write_png(path.as_ref(), self.width, self.height, &self.rgba)
    }
}

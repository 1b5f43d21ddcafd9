//! OpenEXR files by another reader than the product's: the codec's own, pixel by pixel.

use std::path::Path;

use exr::prelude::{Vec2, read_first_rgba_layer_from_file, write_rgba_file};
use image::{Rgba, Rgba32FImage};

/// The picture of a file, opaque where it has no alpha.
///
/// # Panics
/// If the file cannot be read.
#[must_use]
pub fn read(path: &Path) -> Rgba32FImage {
    let read = read_first_rgba_layer_from_file(
        path,
        |size, _| Rgba32FImage::new(size.width() as u32, size.height() as u32),
        |picture, at: Vec2<usize>, (r, g, b, a): (f32, f32, f32, f32)| {
            picture.put_pixel(at.x() as u32, at.y() as u32, Rgba([r, g, b, a]));
        },
    );
    let read = read.unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    read.layer_data.channel_data.pixels
}

/// Writes four floats a pixel.
///
/// # Errors
/// Those of the file.
pub fn write(path: &Path, picture: &Rgba32FImage) -> exr::error::UnitResult {
    let (width, height) = picture.dimensions();
    write_rgba_file(path, width as usize, height as usize, |x, y| {
        let [r, g, b, a] = picture.get_pixel(x as u32, y as u32).0;
        (r, g, b, a)
    })
}

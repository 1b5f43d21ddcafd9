//! Rectifies the quadrangle of a photo to a rectangle by a homography.

use texmap::io::image_io::{read_texture, write_png};
use texmap::prelude::*;
use texmap::sample::{EdgeMode, Resample};

/// Runs the example.
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    let photo = read_texture("assets/textures/brick.png".as_ref(), ColorSpace::Srgb)?.0;
    let corners = [[20.0, 12.0], [110.0, 4.0], [120.0, 118.0], [8.0, 90.0]];
    let rectangle = [[0.0, 0.0], [320.0, 0.0], [320.0, 200.0], [0.0, 200.0]];
    let map = Homography::from_quads(corners.map(DVec2::from), rectangle.map(DVec2::from))?;

    let (photo, filter) = (photo.with_mips(), Filter::Anisotropic(16));
    let mut linear = vec![[0.0; 4]; 320 * 200];
    Resample::new(&photo, filter, EdgeMode::Edge, &map).rows(Level::new(), 320, 0, &mut linear)?;

    let to_bytes = |color: &[f32; 4]| color.map(texmap::math::color::linear_to_srgb8);
    let bytes: Vec<u8> = linear.iter().flat_map(to_bytes).collect();
    write_png("rectified.png".as_ref(), 320, 200, &bytes)?;
    Ok(())
}

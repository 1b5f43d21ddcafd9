//! Rasterizes an indexed mesh and shades its fragments with a closure.
#![allow(clippy::print_stdout, reason = "an example prints")]

use texmap::prelude::*;
use texmap::raster::{NoAlphaTest, triangles};

/// Runs the example.
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    let camera = Camera::look_at([0.0, 1.0, 3.0], [0.0, 0.0, -2.0]);
    let positions = [[-1, 1], [1, 1], [-1, -9], [1, -9]].map(|[x, z]| [x as f32, 0.0, z as f32]);
    let indices: [u32; 6] = [0, 1, 2, 2, 1, 3];
    let mut floor = DrawCall::default();
    (floor.positions, floor.indices) = (&positions, triangles(&indices)?);
    floor.attributes = &[0.0, 0.0, 4.0, 0.0, 0.0, 20.0, 4.0, 20.0]; // u, v of each vertex
    floor.attribute_count = 2;
    floor.clip_from_object = camera.clip_from_world(320.0 / 200.0)?;

    let mut image = image::GrayImage::new(320, 200);
    let prepared = BinnedDraws::new(TargetSize::new(320, 200)?, &[floor])?;
    prepared.for_each_fragment(&NoAlphaTest, |fragment| {
        let odd = fragment.values.iter().map(|c| *c as u8).sum::<u8>() & 1;
        image.put_pixel(fragment.x, fragment.y, image::Luma([80 + 150 * odd]));
    });
    println!(
        "{} are white",
        image.pixels().filter(|p| p.0[0] == 230).count()
    );
    Ok(())
}

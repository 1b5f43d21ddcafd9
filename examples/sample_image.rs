//! Samples an image twice, trilinear and anisotropic, and prints sRGB bytes.
#![allow(clippy::print_stdout, reason = "an example prints")]

use image::{Rgba, RgbaImage};
use texmap::prelude::*;
use texmap::{math::color::linear_to_srgb8, texture_from_rgba8};

/// Runs the example.
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    // Stripes 4 texels wide.
    let stripe = |x: u32| {
        if x % 8 < 4 {
            [255, 160, 0, 255]
        } else {
            [0, 40, 90, 255]
        }
    };
    let image = RgbaImage::from_fn(256, 256, |x, _| Rgba(stripe(x)));
    let texture = texture_from_rgba8(&image, ColorSpace::Srgb)?.with_mips();

    // A pixel that covers 2 texels across and 16 down.
    let footprint = Footprint::new(2.0 / 256.0, 0.0, 0.0, 16.0 / 256.0);
    for filter in [Filter::Trilinear, Filter::Anisotropic(16)] {
        let sampler = Sampler {
            filter,
            ..Sampler::default()
        };
        let [r, g, b, _] = sampler.sample_grad(&texture, [0.508, 0.5], footprint);
        println!("{filter:?}: {:?}", [r, g, b].map(linear_to_srgb8));
    }
    Ok(())
}

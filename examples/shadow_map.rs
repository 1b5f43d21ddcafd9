//! A shadow map from the rasterizer's depth, filtered look-ups, and a reflected view direction.
#![allow(clippy::print_stdout, reason = "an example prints")]

use texmap::light::{ShadowBias, ShadowKind, ShadowMap, reflect};
use texmap::prelude::*;

/// Runs the example.
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    // A sun shines straight down on a triangle; reversed depth is 1 at the light and 0 at 20 below.
    let light_from_world = Camera::look_at([0.0, 10.0, 0.0], [0.0; 3]).view()?;
    let scale = DMat4::from_scale(DVec3::new(0.25, 0.25, 0.05));
    let clip = DMat4::from_translation(DVec3::Z) * scale * light_from_world;
    let triangle = [[-2.0, 1.0, -2.0], [2.0, 1.0, -2.0], [0.0, 1.0, 3.0]];
    let mut caster = DrawCall::default();
    (caster.positions, caster.indices, caster.clip_from_object) = (&triangle, &[[0, 1, 2]], clip);
    let depth = BinnedDraws::new(TargetSize::new(256, 256)?, &[caster])?.depth_map(1);

    let distance = |z| [f32::INFINITY, 20.0 * (1.0 - z)][usize::from(z > 0.0)];
    let kind = ShadowKind::Directional {
        light_from_world,
        half: 4.0,
    };
    let map = ShadowMap::new(kind, 256, depth.into_iter().map(distance).collect())?;
    let at = |x| map.visibility(DVec3::X * x, DVec3::Y, ShadowBias::Slope(1e-3), 3);
    println!("of the sun at x = 0, 1, 2: {:.2?}", [0.0, 1.0, 2.0].map(at));
    println!(
        "reflected: {:?}",
        reflect([0.6, -0.8, 0.0], [0.0, 1.0, 0.0])
    );
    Ok(())
}

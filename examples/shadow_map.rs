//! A shadow map from the rasterizer's depth, filtered look-ups, and a reflected view direction.

use texmap::light::{ShadowBias, ShadowKind, ShadowMap, reflect};
use texmap::prelude::*;

/// Runs the example.
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    // A sun shines straight down on a square; reversed depth is 1 at the light and 0 at 20 below.
    let sun = Camera::look_at([0.0, 10.0, 0.0], [0.0; 3]);
    let (half, light_from_world) = (4.0, sun.view()?);
    let scale = DMat4::from_scale(DVec3::new(1.0 / half, 1.0 / half, 1.0 / 20.0));
    let clip = DMat4::from_translation(DVec3::Z) * scale * light_from_world;
    let square = [[-1, -1], [1, -1], [1, 1], [-1, 1]].map(|[x, z]| [x as f32, 1.0, z as f32]);
    let mut caster = DrawCall::default();
    (caster.positions, caster.indices) = (&square, &[[0, 1, 2], [0, 2, 3]]);
    caster.clip_from_object = clip;
    let depth = BinnedDraws::new(TargetSize::new(256, 256)?, &[caster])?.depth_map(1);

    let distance = |z| [f32::INFINITY, 20.0 * (1.0 - z)][usize::from(z > 0.0)];
    let kind = ShadowKind::Directional {
        light_from_world,
        half,
    };
    let map = ShadowMap::new(kind, 256, depth.into_iter().map(distance).collect())?;
    for x in [0.0, 1.0, 2.0] {
        let visible = map.visibility(DVec3::X * x, DVec3::Y, ShadowBias::Slope(1e-3), 3);
        println!("{visible:.2} of the sun reaches x = {x}");
    }
    println!(
        "reflected: {:?}",
        reflect([0.6, -0.8, 0.0], [0.0, 1.0, 0.0])
    );
    Ok(())
}

//! Draws a lit, textured cube and saves it as a PNG.
#![allow(clippy::print_stdout, reason = "an example prints")]

use texmap::prelude::*;

/// Runs the example.
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    let brick =
        texmap::io::image_io::read_texture("assets/textures/brick.png".as_ref(), ColorSpace::Srgb)?
            .0;
    let mut scene = Scene::new(Camera::look_at([3.0, 2.5, 4.0], [0.0; 3]));
    scene.lights = vec![
        Light::Ambient { color: [0.2; 3] },
        Light::Directional {
            color: [1.0; 3],
            direction: [-1.0, -2.0, -1.5],
        },
    ];
    scene.textures = vec![brick.with_mips()];
    scene.materials = vec![Material {
        base_color: Some(TextureSlot::new(0)),
        ..Material::default()
    }];
    scene.meshes = vec![Mesh::cube()];

    let frame = render(&scene, &RenderSettings::new(640, 480), &no_progress)?;
    frame.save("cube.png")?;
    println!("{} pixels are covered", frame.stats.pixels_covered);
    Ok(())
}

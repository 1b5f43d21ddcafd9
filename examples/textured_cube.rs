//! Draws a lit, textured cube and saves it as a PNG.

use texmap::prelude::*;

pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    let brick =
        texmap::io::image_io::read_texture("assets/textures/brick.png".as_ref(), ColorSpace::Srgb)?
            .0;
    let mut scene = Scene::new(Camera::look_at(DVec3::new(2.0, 1.5, 2.5), DVec3::ZERO));
    scene.lights = vec![
        Light::Ambient { color: [0.2; 3] },
        Light::Directional {
            color: [1.0; 3],
            direction: [-1.0, -2.0, -1.5],
        },
    ];
    scene.textures = vec![brick.with_mips()];
    scene.materials = vec![Material {
        texture: Some(TextureSlot::new(0)),
        ..Material::default()
    }];
    scene.meshes = vec![Mesh::cube(1.5)];

    let frame = render(&scene, &Settings::new(640, 480), &|_done, _of| ())?;
    frame.save("cube.png")?;
    println!("{} pixels are covered", frame.stats.pixels_covered);
    Ok(())
}

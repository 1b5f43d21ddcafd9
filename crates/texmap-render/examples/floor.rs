//! A checker floor to the horizon, a fence with holes and a pane of red glass. Writes floor.png, or the file named by the
//! first argument.

use std::error::Error;

use texmap_light::{Light, PhongMaterial};
use texmap_math::Camera;
use texmap_math::glam::DVec3;
use texmap_render::{RenderSettings, render};
use texmap_sample::{ColorSpace, Filter, Origin, Sampler, Texture2d};
use texmap_scene::{AlphaMode, Material, Mesh, Scene, Shading, TextureRole, TextureSlot};

fn main() -> Result<(), Box<dyn Error>> {
    let checker = texture(64, |x, y| {
        if (x / 32 + y / 32) % 2 == 0 {
            [235, 235, 225, 255]
        } else {
            [60, 80, 110, 255]
        }
    })?;
    let fence = texture(32, |x, y| {
        if x % 16 < 5 || y < 6 {
            [150, 95, 45, 255]
        } else {
            [0; 4]
        }
    })?;
    let white = PhongMaterial {
        color: [1.0; 3],
        ..PhongMaterial::default()
    };
    let slot = |texture, filter| {
        Some(TextureSlot {
            sampler: Sampler {
                filter,
                ..Sampler::default()
            },
            ..TextureSlot::new(texture)
        })
    };
    let floor = Material {
        phong: PhongMaterial { ks: 0.0, ..white },
        base_color: slot(0, Filter::Anisotropic(16)),
        ..Material::default()
    };
    let fence_material = Material {
        base_color: slot(1, Filter::Nearest),
        texture_role: TextureRole::Decal,
        shading: Shading::Unlit,
        alpha: AlphaMode::Test(0.0),
        ..Material::default()
    };
    let glass = Material {
        phong: PhongMaterial {
            color: [0.8, 0.05, 0.05],
            ..PhongMaterial::default()
        },
        opacity: 0.5,
        alpha: AlphaMode::Blend,
        ..Material::default()
    };
    let scene = Scene {
        background: [0.6, 0.8, 1.0, 1.0],
        lights: vec![
            Light::Ambient { color: [0.3; 3] },
            Light::Directional {
                color: [0.7; 3],
                direction: [-1.0, -2.0, -1.0],
            },
        ],
        textures: vec![checker, fence],
        materials: vec![floor, fence_material, glass],
        meshes: vec![
            quad(
                0,
                [
                    [-500.0, 0.0, 8.0],
                    [500.0, 0.0, 8.0],
                    [500.0, 0.0, -992.0],
                    [-500.0, 0.0, -992.0],
                ],
                [1000.0; 2],
            ),
            quad(
                1,
                [
                    [-2.0, 0.0, 1.0],
                    [2.0, 0.0, 1.0],
                    [2.0, 1.0, 1.0],
                    [-2.0, 1.0, 1.0],
                ],
                [4.0, 1.0],
            ),
            quad(
                2,
                [
                    [0.3, 0.0, 2.0],
                    [1.3, 0.0, 2.5],
                    [1.3, 1.4, 2.5],
                    [0.3, 1.4, 2.0],
                ],
                [1.0; 2],
            ),
        ],
        ..Scene::new(Camera {
            eye: DVec3::new(0.0, 1.5, 6.0),
            look: DVec3::new(0.0, 0.8, 0.0),
            up: DVec3::Y,
            fov_x: 1.0,
            near: 1e-4,
            far: f64::INFINITY,
        })
    };
    let frame = render(
        &scene,
        &RenderSettings {
            supersample: 2,
            ..RenderSettings::new(640, 360)
        },
        &texmap_render::no_progress,
    )?;
    let path = std::env::args()
        .nth(1)
        .unwrap_or_else(|| "floor.png".to_owned());
    image::save_buffer(
        path,
        &frame.rgba,
        frame.width,
        frame.height,
        image::ColorType::Rgba8,
    )?;
    // The sky, and the fence's first picket.
    assert_eq!(frame.rgba[..4], [153, 204, 255, 255]);
    assert_eq!(frame.rgba[(250 * 640 + 98) * 4..][..4], [150, 95, 45, 255]);
    Ok(())
}

fn texture(
    size: u32,
    texel: impl Fn(u32, u32) -> [u8; 4],
) -> Result<Texture2d<'static>, Box<dyn Error>> {
    let texels = (0..size * size)
        .flat_map(|i| texel(i % size, i / size))
        .collect();
    Ok(Texture2d::from_rgba8(
        size,
        size,
        texels,
        ColorSpace::Srgb,
        Origin::TopLeft,
    )?)
}

fn quad(material: usize, positions: [[f32; 3]; 4], repeat: [f32; 2]) -> Mesh {
    Mesh {
        positions: positions.to_vec(),
        uvs: vec![[0.0, repeat[1]], repeat, [repeat[0], 0.0], [0.0, 0.0]],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        material,
        ..Mesh::default()
    }
}

//! Time that a plan for each triangle would save over one for each mesh: the last part of docs/generated/plans.md.
//!
//! `cargo run --release -p texmap-lab --example plan_triangles` draws a floor, whose triangles in front are magnified, with one
//! filter, and again with bilinear for just those triangles; and a wall across the line of sight, where w is equal, with
//! perspective and with affine interpolation. One thread, frames in turns: least times, and the median of what a pair saves.

#![allow(clippy::print_stdout, reason = "the table is the output")]

use std::error::Error;
use std::time::Instant;

use texmap_lab::plane::{Pattern, TEXELS};
use texmap_light::PhongMaterial;
use texmap_math::camera::Camera;
use texmap_math::glam::DVec3;
use texmap_raster::Interp;
use texmap_render::{RenderSettings, Renderer};
use texmap_sample::{ColorSpace, Filter, Origin, Precision, Sampler, Texture2d};
use texmap_scene::{ColorMode, Material, Mesh, Scene, Shading, TextureSlot};

const SIZE: (u32, u32) = (1920, 1080);
const ROUNDS: usize = 61;
/// Height of the eye over the floor.
const EYE: f64 = 1.5;
const FOV: f64 = 1.2;
/// Distance along the floor at which a pixel covers one texel: in front of it the floor is magnified.
const MIDDLE: f64 = 6.0;

fn main() -> Result<(), Box<dyn Error>> {
    println!("| scene | one plan | ms | plans for triangles | ms | saved |");
    println!("|---|---|---|---|---|---|");
    for (name, filter) in [
        ("trilinear, fast", Filter::Trilinear),
        ("anisotropic:16, fast", Filter::Anisotropic(16)),
    ] {
        let one = floor(filter, None)?;
        let (split, share) = {
            let scene = floor(filter, Some(Filter::Bilinear))?;
            let near = scene.meshes[1].triangles.len();
            let all = near + scene.meshes[0].triangles.len();
            (scene, near as f64 / all as f64)
        };
        let ([a, b], saved) = race([&one, &split])?;
        println!(
            "| floor, {:.0} % of its triangles magnified | {name} | {a:.2} | those bilinear, fast | {b:.2} | {:.0} % |",
            share * 100.0,
            saved * 100.0
        );
    }
    let ([a, b], saved) = race([&wall(Interp::Perspective)?, &wall(Interp::Affine)?])?;
    println!(
        "| wall across the line of sight | perspective | {a:.2} | affine | {b:.2} | {:.0} % |",
        saved * 100.0
    );
    Ok(())
}

/// Least milliseconds of a frame of each, and the part that the second saves of the first, median of all turns.
fn race(scenes: [&Scene; 2]) -> Result<([f64; 2], f64), Box<dyn Error>> {
    let settings = RenderSettings {
        threads: Some(1),
        ..RenderSettings::new(SIZE.0, SIZE.1)
    };
    let renderers = [
        Renderer::new(scenes[0], &settings)?,
        Renderer::new(scenes[1], &settings)?,
    ];
    let (mut least, mut saved) = ([f64::INFINITY; 2], Vec::new());
    for _ in 0..ROUNDS {
        let mut times = [0.0; 2];
        for (time, renderer) in times.iter_mut().zip(&renderers) {
            let start = Instant::now();
            renderer.draw(&texmap_render::no_progress)?;
            *time = start.elapsed().as_secs_f64() * 1e3;
        }
        least = [0, 1].map(|i| least[i].min(times[i]));
        saved.push(1.0 - times[1] / times[0]);
    }
    saved.sort_by(f64::total_cmp);
    Ok((least, saved[ROUNDS / 2]))
}

/// A floor of squares. Those in front, which are magnified, are a mesh of their own with another filter if one is given.
fn floor(filter: Filter, near: Option<Filter>) -> Result<Scene, Box<dyn Error>> {
    let focal = f64::from(SIZE.0) * 0.5 / (FOV * 0.5).tan();
    // Along the line of sight a pixel covers z^2 / (height focal).
    let scale = EYE * focal / (MIDDLE * MIDDLE) / TEXELS as f64;
    let (columns, rows, side) = (40u32, 96u32, 0.5);
    let mut positions = Vec::new();
    for row in 0..=rows {
        for column in 0..=columns {
            let x = (f64::from(column) - f64::from(columns) / 2.0) * side * 2.0;
            positions.push([x, -EYE, -1.0 - f64::from(row) * side]);
        }
    }
    let uvs = positions
        .iter()
        .map(|p| [p[0] * scale, -p[2] * scale].map(|c| c as f32));
    let whole = Mesh {
        positions: positions.iter().map(|p| p.map(|c| c as f32)).collect(),
        uvs: uvs.collect(),
        ..Mesh::default()
    };
    let squares = (0..rows * columns).map(|i| {
        let first = i / columns * (columns + 1) + i % columns;
        let (a, b, c, d) = (first, first + 1, first + columns + 2, first + columns + 1);
        [[a, b, c], [a, c, d]]
    });
    let magnified = |square: &[[u32; 3]; 2]| -positions[square[0][2] as usize][2] <= MIDDLE;
    let (front, back): (Vec<_>, Vec<_>) = squares.partition(|s| near.is_some() && magnified(s));
    let mut meshes = vec![Mesh {
        triangles: back.concat(),
        ..whole.clone()
    }];
    let mut materials = vec![material(filter)];
    if let Some(near) = near {
        meshes.push(Mesh {
            triangles: front.concat(),
            material: 1,
            ..whole
        });
        materials.push(material(near));
    }
    scene(meshes, materials)
}

fn wall(interp: Interp) -> Result<Scene, Box<dyn Error>> {
    let corners = [[-4.0, -3.0], [4.0, -3.0], [4.0, 3.0], [-4.0, 3.0]];
    let mesh = Mesh {
        positions: corners.map(|[x, y]| [x, y, -4.0]).to_vec(),
        uvs: corners.map(|c: [f32; 2]| c.map(|c| c * 2.0)).to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    };
    let material = Material {
        interp,
        ..material(Filter::Bilinear)
    };
    scene(vec![mesh], vec![material])
}

fn material(filter: Filter) -> Material {
    Material {
        phong: PhongMaterial {
            color: [1.0; 3],
            ..PhongMaterial::default()
        },
        base_color: Some(TextureSlot {
            sampler: Sampler {
                filter,
                precision: Precision::Fast,
                ..Sampler::default()
            },
            ..TextureSlot::new(0)
        }),
        shading: Shading::Unlit,
        ..Material::default()
    }
}

fn scene(meshes: Vec<Mesh>, materials: Vec<Material>) -> Result<Scene, Box<dyn Error>> {
    let side = TEXELS as u32;
    let noise = Pattern::Noise.rgba();
    let texture = Texture2d::from_rgba8(side, side, noise, ColorSpace::Linear, Origin::TopLeft)?;
    Ok(Scene {
        background: [0.0; 4],
        color: ColorMode::Raw,
        textures: vec![texture],
        materials,
        meshes,
        ..Scene::new(Camera {
            eye: DVec3::ZERO,
            look: DVec3::NEG_Z,
            up: DVec3::Y,
            fov_x: FOV,
            near: 0.1,
            far: f64::INFINITY,
        })
    })
}

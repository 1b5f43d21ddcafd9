//! The race with the registry's software renderers: a floor and a torus of 100,000 triangles, textured by the nearest texel, drawn by
//! texmap, euc 0.5.3 and retrofire 0.4.0 in turns on one pinned core.
//!
//! `cargo run --release -p texmap-benches --features rust-peers --bin rust-peers` writes `benches/results/rust_peers.md`.
//!
//! The pictures are compared with the f64 truth before any time counts. The others have neither filters, mip maps nor threads: texmap
//! draws on one thread, and beside it with trilinear filtering, which the others cannot.

#![allow(clippy::print_stdout, reason = "the rows are the output")]

mod registry;

use std::fmt::Write;
use std::path::Path;
use std::time::Instant;

use registry::{Euc, Outcome, Racer, Retrofire, Texmap};
use texmap_benches::textures::squares;
use texmap_lab::chart::decal_scene;
use texmap_math::camera::Camera;
use texmap_math::glam::DVec3;
use texmap_sample::{Filter, Precision, Sampler};
use texmap_truth::rays::{RayObject, RayScene};

const WIDTH: u32 = 1920;
const HEIGHT: u32 = 1080;
const SIZE: [u32; 2] = [WIDTH, HEIGHT];
/// Texels a side.
const SIDE: u32 = 256;
const ROUNDS: usize = 7;
const BACKGROUND: [u8; 4] = [26, 51, 77, 255];

fn main() -> Outcome<()> {
    if let Some(core) = core_affinity::get_core_ids().and_then(|cores| cores.first().copied()) {
        core_affinity::set_for_current(core);
    }
    let mut out = String::from(HEADER);
    for (name, mesh) in [("floor", floor()), ("torus, 100k triangles", torus())] {
        let scene = scene(&mesh, Filter::Nearest);
        let truth = truth(&scene)?;
        let filtered = self::scene(&mesh, Filter::Trilinear);
        let mut racers: Vec<(&str, Box<dyn Racer>)> = vec![
            ("texmap", Box::new(Texmap::new(&scene, SIZE)?)),
            ("texmap, trilinear", Box::new(Texmap::new(&filtered, SIZE)?)),
            ("euc 0.5.3", Box::new(Euc::new(&scene, SIZE)?)),
            ("retrofire 0.4.0", Box::new(Retrofire::new(&scene, SIZE)?)),
        ];
        let mut least = vec![f64::MAX; racers.len()];
        for _ in 0..ROUNDS {
            for ((_, racer), least) in racers.iter_mut().zip(&mut least) {
                let start = Instant::now();
                racer.frame();
                *least = least.min(start.elapsed().as_secs_f64() * 1e3);
            }
        }
        for ((who, racer), time) in racers.iter().zip(&least) {
            let picture = racer.picture();
            let off = picture.chunks_exact(4).zip(truth.iter());
            let off = off.filter(|(a, b)| (0..3).any(|k| a[k].abs_diff(b[k]) > 1));
            let off = 100.0 * off.count() as f64 / f64::from(WIDTH * HEIGHT);
            let off = if who.contains("trilinear") {
                "another filter".to_owned()
            } else {
                format!("{off:.3} %")
            };
            writeln!(
                out,
                "| {name} | {who} | {time:.2} | {:.2} | {off} |",
                time / least[0]
            )?;
        }
    }
    print!("{out}");
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("results/rust_peers.md");
    std::fs::write(path, out)?;
    Ok(())
}

const HEADER: &str = "\
# The race with the registry's renderers

`cargo run --release -p texmap-benches --features rust-peers --bin rust-peers`

1920 x 1080, one thread, pinned, all in turns; least times. Pixels that are off differ by more than 1 of 255 from the f64 truth at the
pixel's centre.

| scene | renderer | ms | times texmap's | pixels off |
|---|---|---|---|---|
";

/// The texel that the f64 ray through each pixel's centre meets.
fn truth(scene: &Scene) -> Outcome<Vec<[u8; 4]>> {
    let rays = RayScene::new([RayObject::Mesh(&scene.meshes[0])]);
    let texture = &scene.textures[0];
    let mut picture = Vec::with_capacity((WIDTH * HEIGHT) as usize);
    for (x, y) in (0..HEIGHT).flat_map(|y| (0..WIDTH).map(move |x| (x, y))) {
        let (x, y) = (f64::from(x) + 0.5, f64::from(y) + 0.5);
        let ray = scene.camera.ray(WIDTH, HEIGHT, x, y)?;
        let hit = rays.nearest(scene.camera.eye, ray, (1e-6, f64::INFINITY));
        picture.push(hit.and_then(|hit| hit.uv).map_or(BACKGROUND, |uv| {
            let [x, y] = [uv.x, uv.y]
                .map(|c| (c * f64::from(SIDE)).floor().rem_euclid(f64::from(SIDE)) as u32);
            let texel = texture.texel(0, x, y).unwrap_or_default();
            texel.map(|c| (c * 255.0 + 0.5) as u8)
        }));
    }
    Ok(picture)
}

/// A plane to the horizon, all of it before the eye: euc does not clip.
fn floor() -> Mesh {
    Mesh {
        positions: [[-400.0, -100.0], [400.0, -100.0], [4.0, -1.0], [-4.0, -1.0]]
            .map(|[x, z]| [x, -1.0, z])
            .to_vec(),
        uvs: vec![[-100.0, 25.0], [100.0, 25.0], [1.0, 0.25], [-1.0, 0.25]],
        triangles: vec![[0, 2, 1], [0, 3, 2]],
        ..Mesh::default()
    }
}

/// 500 around, 100 about the tube.
fn torus() -> Mesh {
    let (around, about) = (500u32, 100u32);
    let mut mesh = Mesh::default();
    for j in 0..=around {
        for i in 0..=about {
            let turn = |k: u32, n: u32| {
                texmap_math::deterministic_f64::sin_cos(
                    std::f64::consts::TAU * f64::from(k) / f64::from(n),
                )
            };
            let ((s, c), (t, d)) = (turn(j, around), turn(i, about));
            let out = 1.5 + 0.6 * d;
            let p = DVec3::new(out * c, 0.6 * t + 0.15 * s, out * s - 4.0);
            mesh.positions.push(p.as_vec3().to_array());
            mesh.uvs.push([
                16.0 * j as f32 / around as f32,
                4.0 * i as f32 / about as f32,
            ]);
        }
    }
    let row = about + 1;
    for (j, i) in (0..around).flat_map(|j| (0..about).map(move |i| (j, i))) {
        let a = j * row + i;
        mesh.triangles.push([a, a + 1, a + row]);
        mesh.triangles.push([a + 1, a + row + 1, a + row]);
    }
    mesh
}

fn scene(mesh: &Mesh, filter: Filter) -> Scene {
    let texture = squares(SIDE);
    let sampler = Sampler {
        filter,
        precision: Precision::Fast,
        ..Sampler::default()
    };
    let camera = Camera {
        eye: DVec3::new(0.0, 0.6, 0.0),
        look: DVec3::new(0.0, -0.3, -4.0),
        up: DVec3::Y,
        fov_x: 80f64.to_radians(),
        near: 0.1,
        far: 1000.0,
        lens: Default::default(),
    };
    let mut scene = decal_scene(camera, mesh.clone(), texture, sampler);
    scene.background = BACKGROUND.map(|c| f32::from(c) / 255.0);
    scene
}

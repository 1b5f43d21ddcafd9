//! glTF models: those of the assets, small ones made here, and broken ones.

mod compressed;
mod faults;
mod geometry;
mod hostile;
mod looks;
mod motion;

use std::path::{Path, PathBuf};

use texmap_io::{FileSource, IoError, LoadOptions, load};
use texmap_scene::{Mesh, Scene};

fn asset(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../assets/gltf")
        .join(name)
}

fn read(name: &str) -> Scene {
    read_with(name, LoadOptions::default()).unwrap_or_else(|e| panic!("{e}; {}", e.help()))
}

fn read_with(name: &str, options: LoadOptions) -> Result<Scene, IoError> {
    load(&asset(name), &options)
}

/// A model of one document and one buffer, read from memory.
fn small(json: &str, buffer: &[u8]) -> Result<Scene, IoError> {
    let files = FileSource::in_memory([
        ("a.gltf".into(), json.as_bytes().to_vec()),
        ("a.bin".into(), buffer.to_vec()),
    ]);
    load(
        Path::new("a.gltf"),
        &LoadOptions {
            files,
            ..LoadOptions::default()
        },
    )
}

/// A triangle of floats; tests put one fault in.
const TRIANGLE: &str = r#"{"asset":{"version":"2.0"},"nodes":[{"mesh":0}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}],
"buffers":[{"uri":"a.bin","byteLength":44}],
"bufferViews":[{"buffer":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":6}],
"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"},
{"bufferView":1,"componentType":5123,"count":3,"type":"SCALAR"}]}"#;

fn triangle_bytes() -> Vec<u8> {
    let corners = [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    let mut bytes: Vec<u8> = corners.iter().flat_map(|x| x.to_le_bytes()).collect();
    bytes.extend([0, 0, 1, 0, 2, 0, 0, 0]);
    bytes
}

/// Positions of a mesh in the world.
fn world(mesh: &Mesh) -> Vec<[f64; 3]> {
    let place = |p: &[f32; 3]| {
        mesh.world_from_object
            .transform_point3(p.map(f64::from).into())
            .to_array()
    };
    mesh.positions.iter().map(place).collect()
}

fn near(a: &[[f64; 3]], b: &[[f64; 3]], tolerance: f64) -> bool {
    let pairs = a.iter().flatten().zip(b.iter().flatten());
    a.len() == b.len() && pairs.into_iter().all(|(a, b)| (a - b).abs() <= tolerance)
}

//! `whole/...`: the whole program, file to PNG (1024 x 768, the automatic picture of a model), beside reading and decoding the same files.
//!
//! `cargo build --release && cargo bench -p texmap-benches --bench whole` prints the ratio of minima last. The program runs as a process
//! of its own; files are read and decoded within the benchmark, by the same readers. Models are written to a temporary folder.

#![allow(clippy::print_stdout, reason = "the ratio is the output")]

use std::error::Error;
use std::fmt::Write as _;
use std::fs;
use std::hint::black_box;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use criterion::{BenchmarkGroup, Criterion, measurement::WallTime};
use texmap_benches::textures::square_texels;
use texmap_io::{LoadOptions, image_io, load};
use texmap_math::deterministic_f64;

type Outcome<T> = Result<T, Box<dyn Error>>;

fn main() -> Outcome<()> {
    let program = program()?;
    let folder = std::env::temp_dir().join(format!("texmap-whole-{}", std::process::id()));
    fs::create_dir_all(&folder)?;
    let done = compare(&program, &folder);
    fs::remove_dir_all(&folder)?;
    done
}

/// The program beside this benchmark.
fn program() -> Outcome<PathBuf> {
    let own = std::env::current_exe()?;
    let name = format!("texmap{}", std::env::consts::EXE_SUFFIX);
    let mut folders = own.ancestors().skip(1).map(|folder| folder.join(&name));
    let found = folders.find(|path| path.is_file());
    found.ok_or_else(|| "there is no program: run `cargo build --release` first".into())
}

fn compare(program: &Path, folder: &Path) -> Outcome<()> {
    let assets = Path::new(env!("CARGO_MANIFEST_DIR")).join("../assets");
    let files = [
        ("obj-20k", obj(folder, 100, 100)?),
        ("obj-200k", obj(folder, 400, 250)?),
        ("ply-200k", ply(folder, 400, 250)?),
        ("gltf-maps", gltf(folder, 64, 64)?),
        ("scene", assets.join("scenes/purple_cow.scene")),
    ];
    let mut criterion = Criterion::default().configure_from_args();
    let mut rows = String::new();
    for (name, file) in &files {
        let mut group = criterion.benchmark_group(format!("whole/{name}"));
        // The light of a glTF is made once, which is no reading.
        load(file, &LoadOptions::default())?;
        let read = least(&mut group, "read", || {
            black_box(load(file, &LoadOptions::default())).is_ok()
        });
        let picture = folder.join("out.png");
        let run = least(&mut group, "run", || {
            let mut command = Command::new(program);
            let command = command.args(["render", "--quiet", "-o"]).arg(&picture);
            let status = command.arg(file).stderr(Stdio::null()).status();
            status.is_ok_and(|status| status.success())
        });
        group.finish();
        if let (Some(read), Some(run)) = (read, run) {
            let [read, run] = [read, run].map(|time| time.as_secs_f64() * 1e3);
            writeln!(
                rows,
                "| {name} | {read:.1} | {run:.1} | {:.1} |",
                run / read
            )?;
        }
    }
    criterion.final_summary();
    println!(
        "\n| file | read and decoded, ms | whole run, ms | ratio |\n|---|---|---|---|\n{rows}"
    );
    Ok(())
}

/// The least time of something that must succeed; `None` where a filter of the command line leaves it out.
fn least(
    group: &mut BenchmarkGroup<'_, WallTime>,
    name: &str,
    work: impl Fn() -> bool,
) -> Option<Duration> {
    let mut least = None;
    group.sample_size(10).bench_function(name, |bencher| {
        bencher.iter_custom(|count| {
            let times = (0..count).map(|_| {
                let began = Instant::now();
                assert!(work(), "{name} failed");
                began.elapsed()
            });
            let times: Vec<Duration> = times.collect();
            least = times.iter().copied().chain(least).min();
            times.iter().sum()
        });
    });
    least
}

/// A torus of `2 around across` triangles: positions, coordinates and faces.
struct Torus {
    positions: Vec<[f32; 3]>,
    uvs: Vec<[f32; 2]>,
    triangles: Vec<[u32; 3]>,
}

impl Torus {
    fn new(around: u32, across: u32) -> Self {
        let turn = |k: u32, n: u32| f64::from(k) / f64::from(n);
        let (mut positions, mut uvs, mut triangles) = (Vec::new(), Vec::new(), Vec::new());
        for i in 0..=around {
            for j in 0..=across {
                let (u, v) = (turn(i, around), turn(j, across));
                let [(s, c), (t, d)] =
                    [u, v].map(|x| deterministic_f64::sin_cos(x * core::f64::consts::TAU));
                let r = 1.0 + 0.4 * d;
                positions.push([r * c, 0.4 * t, r * s].map(|x| x as f32));
                uvs.push([u, v].map(|x| x as f32));
                if i < around && j < across {
                    let a = i * (across + 1) + j;
                    let c = a + across + 1;
                    triangles.extend([[a, a + 1, c + 1], [a, c + 1, c]]);
                }
            }
        }
        Self {
            positions,
            uvs,
            triangles,
        }
    }
}

fn obj(folder: &Path, around: u32, across: u32) -> Outcome<PathBuf> {
    let torus = Torus::new(around, across);
    let mut text = String::new();
    for [x, y, z] in &torus.positions {
        writeln!(text, "v {x:.6} {y:.6} {z:.6}")?;
    }
    for [u, v] in &torus.uvs {
        writeln!(text, "vt {u:.6} {v:.6}")?;
    }
    for triangle in &torus.triangles {
        let [a, b, c] = triangle.map(|v| v + 1);
        writeln!(text, "f {a}/{a} {b}/{b} {c}/{c}")?;
    }
    written(folder.join(format!("torus{around}.obj")), text.as_bytes())
}

fn ply(folder: &Path, around: u32, across: u32) -> Outcome<PathBuf> {
    let torus = Torus::new(around, across);
    let mut bytes = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n\
         property float s\nproperty float t\nelement face {}\nproperty list uchar int vertex_indices\nend_header\n",
        torus.positions.len(),
        torus.triangles.len()
    )
    .into_bytes();
    for (position, uv) in torus.positions.iter().zip(&torus.uvs) {
        bytes.extend(position.iter().chain(uv).flat_map(|x| x.to_le_bytes()));
    }
    for triangle in &torus.triangles {
        bytes.push(3);
        bytes.extend(triangle.iter().flat_map(|v| v.to_le_bytes()));
    }
    written(folder.join(format!("torus{around}.ply")), &bytes)
}

/// A torus with three maps of 1024 x 1024 texels.
fn gltf(folder: &Path, around: u32, across: u32) -> Outcome<PathBuf> {
    const SIDE: u32 = 1024;
    let torus = Torus::new(around, across);
    let mut bytes = Vec::new();
    bytes.extend(
        torus
            .positions
            .as_flattened()
            .iter()
            .flat_map(|x| x.to_le_bytes()),
    );
    bytes.extend(
        torus
            .uvs
            .as_flattened()
            .iter()
            .flat_map(|x| x.to_le_bytes()),
    );
    bytes.extend(
        torus
            .triangles
            .as_flattened()
            .iter()
            .flat_map(|v| v.to_le_bytes()),
    );
    let (vertices, corners) = (torus.positions.len(), 3 * torus.triangles.len());
    written(folder.join("torus.bin"), &bytes)?;
    for name in ["color", "rough", "normal"] {
        let path = folder.join(format!("{name}.png"));
        image_io::write_png(&path, SIDE, SIDE, &square_texels(SIDE))?;
    }
    let text = format!(
        r#"{{"asset": {{"version": "2.0"}}, "scenes": [{{"nodes": [0]}}], "nodes": [{{"mesh": 0}}],
"meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0, "TEXCOORD_0": 1}}, "indices": 2, "material": 0}}]}}],
"materials": [{{"pbrMetallicRoughness": {{"baseColorTexture": {{"index": 0}}, "metallicRoughnessTexture": {{"index": 1}}}},
"normalTexture": {{"index": 2, "scale": 0.1}}}}],
"textures": [{{"source": 0}}, {{"source": 1}}, {{"source": 2}}],
"images": [{{"uri": "color.png"}}, {{"uri": "rough.png"}}, {{"uri": "normal.png"}}],
"buffers": [{{"uri": "torus.bin", "byteLength": {length}}}],
"bufferViews": [{{"buffer": 0, "byteOffset": 0, "byteLength": {uvs}}},
{{"buffer": 0, "byteOffset": {uvs}, "byteLength": {uv_bytes}}},
{{"buffer": 0, "byteOffset": {indices}, "byteLength": {index_bytes}}}],
"accessors": [{{"bufferView": 0, "componentType": 5126, "count": {vertices}, "type": "VEC3", "min": [-1.4, -0.4, -1.4], "max": [1.4, 0.4, 1.4]}},
{{"bufferView": 1, "componentType": 5126, "count": {vertices}, "type": "VEC2"}},
{{"bufferView": 2, "componentType": 5125, "count": {corners}, "type": "SCALAR"}}]}}"#,
        length = bytes.len(),
        uvs = 12 * vertices,
        uv_bytes = 8 * vertices,
        indices = 20 * vertices,
        index_bytes = 4 * corners,
    );
    written(folder.join("torus.gltf"), text.as_bytes())
}

fn written(path: PathBuf, bytes: &[u8]) -> Outcome<PathBuf> {
    fs::write(&path, bytes)?;
    Ok(path)
}

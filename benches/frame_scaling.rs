//! Growth of a frame's time with triangles and with pixels, with two threads and on each SIMD level, and the memory beside the
//! scene.
//!
//! `cargo run --release -p texmap-benches --bin frame-scaling` writes `benches/results/frame_scaling.csv` and `.svg` (about a
//! minute). Every time is the minimum of several frames.

#![allow(clippy::print_stdout, reason = "the figures are the output")]

use std::error::Error;
use std::fmt::Write;
use std::fs;
use std::path::Path;
use std::time::{Duration, Instant};

use texmap_benches::bench_scenes::{BenchScene, Hidden, SCENES, sphere};
use texmap_benches::chart::LogChart;
use texmap_math::Level;
use texmap_render::{RenderSettings, Renderer};
use texmap_sample::Precision;
use texmap_scene::{Mesh, Scene};

type Outcome<T> = Result<T, Box<dyn Error + Send + Sync>>;

/// Stacks of the spheres: 1 thousand to 8 million triangles.
const STACKS: [u32; 8] = [16, 32, 64, 128, 256, 512, 1024, 1448];
/// Sides of the square pictures of the floor.
const SIDES: [u32; 5] = [256, 512, 1024, 2048, 4096];

struct Row {
    scene: String,
    level: &'static str,
    threads: usize,
    /// Triangles or pixels.
    count: usize,
    milliseconds: f64,
    /// Rise of the peak of resident memory by preparing and drawing, in MiB. The frame is in it, memory that the allocator had
    /// kept is not.
    memory: Option<f64>,
}

fn main() -> Outcome<()> {
    let threads = [1, 2.min(std::thread::available_parallelism()?.get())];
    let mut rows = Vec::new();
    for stacks in STACKS {
        let mesh = sphere(2 * stacks, stacks);
        let count = mesh.triangles.len();
        let mut scene = scene_of("mesh20k,trilinear")?;
        let old = scene.meshes.remove(0);
        scene.meshes.push(Mesh {
            name: old.name,
            positions: mesh.positions,
            uvs: mesh.uvs,
            triangles: mesh.triangles,
            world_from_object: old.world_from_object,
            ..Mesh::default()
        });
        for threads in threads {
            let (milliseconds, memory) = frame(&scene, (1920, 1080), threads, Level::new())?;
            push(
                &mut rows,
                "sphere",
                "auto",
                threads,
                count,
                milliseconds,
                memory,
            );
        }
    }
    let floor = scene_of("floor,trilinear")?;
    for side in SIDES {
        for threads in threads {
            let (milliseconds, _) = frame(&floor, (side, side), threads, Level::new())?;
            let pixels = side as usize * side as usize;
            push(
                &mut rows,
                "floor",
                "auto",
                threads,
                pixels,
                milliseconds,
                None,
            );
        }
    }
    for key in [
        "floor,nearest",
        "floor,bilinear",
        "floor,trilinear",
        "mesh200k",
    ] {
        let scene = scene_of(key)?;
        for (name, level) in levels() {
            let (milliseconds, _) = frame(&scene, (1920, 1080), 1, level)?;
            push(&mut rows, key, name, 1, 1920 * 1080, milliseconds, None);
        }
    }
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("results");
    let mut csv = String::from("scene,level,threads,count,min_ms,ns_per_item,memory_mib\n");
    for r in &rows {
        let _ = writeln!(
            csv,
            "\"{}\",{},{},{},{:.3},{:.2},{}",
            r.scene,
            r.level,
            r.threads,
            r.count,
            r.milliseconds,
            r.milliseconds * 1e6 / r.count as f64,
            r.memory.map_or(String::new(), |m| format!("{m:.1}"))
        );
    }
    fs::write(folder.join("frame_scaling.csv"), csv)?;
    chart(&folder.join("frame_scaling.svg"), &rows)
}

fn push(
    rows: &mut Vec<Row>,
    scene: &str,
    level: &'static str,
    threads: usize,
    count: usize,
    milliseconds: f64,
    memory: Option<f64>,
) {
    println!(
        "{scene:<16} {level:<7} {threads} threads {count:>9}: {milliseconds:8.2} ms, {:7.2} ns each{}",
        milliseconds * 1e6 / count as f64,
        memory.map_or(String::new(), |m| format!(", {m:.1} MiB beside the scene"))
    );
    rows.push(Row {
        scene: scene.to_owned(),
        level,
        threads,
        count,
        milliseconds,
        memory,
    });
}

fn scene_of(key: &str) -> Outcome<Scene> {
    let named = |scene: &BenchScene| scene.key().starts_with(key);
    let scene = SCENES.iter().find(|s| named(s)).ok_or("no such scene")?;
    Ok(scene
        .scene(Precision::Fast, Hidden::Skipped)?
        .ok_or("a scene without colour")?)
}

fn levels() -> Vec<(&'static str, Level)> {
    let best = Level::new();
    let mut levels = Vec::new();
    #[cfg(target_arch = "x86_64")]
    {
        levels.extend(best.as_avx512().map(|s| ("avx512", Level::Avx512(s))));
        levels.extend(best.as_avx2().map(|s| ("avx2", Level::Avx2(s))));
        levels.extend(best.as_sse2().map(|s| ("sse2", Level::Sse2(s))));
    }
    if levels.is_empty() {
        levels.push(("auto", best));
    }
    levels
}

/// The shortest of at least five frames in half a second, and the memory that making ready and drawing took.
fn frame(
    scene: &Scene,
    (width, height): (u32, u32),
    threads: usize,
    level: Level,
) -> Outcome<(f64, Option<f64>)> {
    let mut settings = RenderSettings::new(width, height);
    (settings.threads, settings.level) = (Some(threads), level);
    let before = Resident::reset();
    let renderer = Renderer::new(scene, &settings)?;
    let mut frame = renderer.draw(&texmap_render::no_progress)?;
    let memory = before.and_then(|before| before.grown());
    let (begin, mut best, mut frames) = (Instant::now(), f64::INFINITY, 0);
    while frames < 5 || begin.elapsed() < Duration::from_millis(500) {
        let start = Instant::now();
        renderer.draw_into(&mut frame, &texmap_render::no_progress, &|blocks| {
            (0..blocks).collect()
        })?;
        best = best.min(start.elapsed().as_secs_f64() * 1e3);
        frames += 1;
    }
    Ok((best, memory))
}

/// Resident memory of this process in KiB, where Linux tells.
struct Resident(f64);

impl Resident {
    /// The resident memory now; the peak counts from here.
    fn reset() -> Option<Self> {
        fs::write("/proc/self/clear_refs", "5").ok()?;
        status("VmRSS:").map(Self)
    }

    fn grown(&self) -> Option<f64> {
        Some((status("VmHWM:")? - self.0) / 1024.0)
    }
}

fn status(field: &str) -> Option<f64> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with(field))?;
    line.split_whitespace().nth(1)?.parse().ok()
}

/// Milliseconds over triangles and over pixels.
fn chart(path: &Path, rows: &[Row]) -> Outcome<()> {
    let lines = [("sphere", 1), ("sphere", 2), ("floor", 1), ("floor", 2)];
    let points = |(scene, threads)| {
        let rows = rows
            .iter()
            .filter(|r| r.scene == scene && r.threads == threads && r.level == "auto");
        let points = rows.map(|r| (r.count as f64, r.milliseconds)).collect();
        (format!("{scene}, {threads} threads"), points)
    };
    LogChart {
        caption: "a frame over triangles and over pixels, minima",
        counted: "triangles of the sphere, 1920 x 1080; pixels of the floor",
        counts: 800.0..2e7,
        milliseconds: 0.1..1000.0,
        linear: ([65_536.0, 16_777_216.0], 4e-6),
    }
    .write(path, &lines.map(points))
}

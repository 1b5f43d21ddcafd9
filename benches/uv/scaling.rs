//! Growth of the uv mapper's steps with the mesh, and the cost of a slice against a copy of the positions.
//!
//! `cargo run --release -p texmap-benches --bin uv-scaling` writes `benches/results/uv_scaling.csv` and `.svg` (about
//! two minutes). Every time is the minimum of several rounds; the slices are interleaved on one thread.

#![allow(clippy::print_stdout, reason = "the figures are the output")]

use std::error::Error;
use std::fmt::Write;
use std::hint::black_box;
use std::path::Path;
use std::time::Instant;

use texmap_benches::chart::LogChart;
use texmap_benches::meshes::ball;
use texmap_math::Level;
use texmap_raster::{Atlas, AtlasMesh, AtlasOptions, TargetSize};
use texmap_uv::{
    Faces, Mapping, Mesh, Origin, ReportOptions, Shape, UvSet, cylinder_uv_batch, overlaps, report,
    sphere_uv_batch, t_junctions,
};

const TRIANGLES: [usize; 7] = [
    62_500, 125_000, 250_000, 500_000, 1_000_000, 2_000_000, 4_000_000,
];

/// One measurement.
struct Row {
    step: &'static str,
    /// Triangles, vertices or texels.
    count: usize,
    threads: usize,
    seconds: f64,
}

/// Rows from inside a pool.
type Rows = Result<Vec<Row>, Box<dyn Error + Send + Sync>>;

fn main() -> Result<(), Box<dyn Error + Send + Sync>> {
    let cores = std::thread::available_parallelism()?.get();
    let mut rows = slices()?;
    for threads in [1, cores] {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()?;
        for triangles in TRIANGLES {
            rows.extend(pool.install(|| meshes(triangles, threads))?);
        }
        rows.extend(pool.install(|| atlases(threads))?);
        if cores == 1 {
            break;
        }
    }
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("results");
    let mut csv = String::from("step,count,threads,min_ms,ns_per_item\n");
    for r in &rows {
        let _ = writeln!(
            csv,
            "\"{}\",{},{},{:.3},{:.2}",
            r.step,
            r.count,
            r.threads,
            r.seconds * 1e3,
            r.seconds * 1e9 / r.count as f64
        );
    }
    std::fs::write(folder.join("uv_scaling.csv"), csv)?;
    chart(&folder.join("uv_scaling.svg"), &rows)
}

/// The shortest of several runs.
fn least(rounds: usize, mut work: impl FnMut()) -> f64 {
    let times = (0..rounds).map(|_| {
        let start = Instant::now();
        work();
        start.elapsed().as_secs_f64()
    });
    times.fold(f64::INFINITY, f64::min)
}

fn slices() -> Rows {
    let vectors: Vec<[f32; 3]> = ball(2_000_000).0;
    let (mut copies, mut uvs) = (vec![[0.0; 3]; vectors.len()], vec![[0.0; 2]; vectors.len()]);
    let level = Level::new();
    let mut best = [f64::INFINITY; 3];
    for _ in 0..60 {
        let times = [
            least(1, || copies.copy_from_slice(black_box(&vectors))),
            least(1, || {
                let _ = sphere_uv_batch(level, black_box(&vectors), Origin::TopLeft, &mut uvs);
            }),
            least(1, || {
                let _ = cylinder_uv_batch(level, black_box(&vectors), Origin::TopLeft, &mut uvs);
            }),
        ];
        black_box((&mut copies, &mut uvs));
        for (b, t) in best.iter_mut().zip(times) {
            *b = b.min(t);
        }
    }
    println!(
        "{} vertices: copy {:.2} ms, sphere {:.2} ms = {:.2} copies, cylinder {:.2} ms = {:.2} copies",
        vectors.len(),
        best[0] * 1e3,
        best[1] * 1e3,
        best[1] / best[0],
        best[2] * 1e3,
        best[2] / best[0]
    );
    let names = ["copy of the positions", "sphere slice", "cylinder slice"];
    let row = |(step, seconds)| Row {
        step,
        count: vectors.len(),
        threads: 1,
        seconds,
    };
    Ok(names.into_iter().zip(best).map(row).collect())
}

fn meshes(triangles: usize, threads: usize) -> Rows {
    let (positions, faces) = ball(triangles);
    let mesh = Mesh::new(&positions, &faces)?;
    let level = Level::new();
    let sphere = Mapping::new(Shape::Sphere);
    let set = sphere.map(level, &mesh, &[])?.set;
    // Two layers: every triangle lies on others.
    let folded = Mapping::new(Shape::Plane).map(level, &mesh, &[])?.set;
    let options = ReportOptions {
        views: false,
        ..ReportOptions::default()
    };
    let rounds = if triangles > 1_000_000 { 2 } else { 4 };
    let row = |step, seconds| Row {
        step,
        count: faces.len(),
        threads,
        seconds,
    };
    let run = |set: &UvSet| {
        least(rounds, || {
            black_box(overlaps(&mesh, set)).ok();
        })
    };
    let rows = vec![
        row(
            "mapping and seam repair",
            least(rounds, || {
                black_box(sphere.map(level, &mesh, &[])).ok();
            }),
        ),
        row(
            "report",
            least(rounds, || {
                black_box(report(&mesh, &set, &options)).ok();
            }),
        ),
        row("overlaps, one layer", run(&set)),
        row("overlaps, two layers", run(&folded)),
        row(
            "T-joints",
            least(rounds, || {
                black_box(t_junctions(&mesh));
            }),
        ),
    ];
    println!("{} triangles on {threads} threads", faces.len());
    Ok(rows)
}

/// A mesh of 250,000 triangles in its own texture space.
fn atlases(threads: usize) -> Rows {
    let (positions, faces) = ball(250_000);
    let mesh = Mesh::new(&positions, &faces)?;
    let uvs = Mapping::new(Shape::Sphere)
        .map(Level::new(), &mesh, &[])?
        .set
        .per_corner();
    let indices: Vec<[u32; 3]> = (0..faces.len() as u32)
        .map(|f| [0, 1, 2].map(|k| 3 * f + k))
        .collect();
    let corners: Vec<[f32; 3]> = corners(&positions, &faces);
    let atlas = AtlasMesh {
        uvs: &uvs,
        positions: &corners,
        normals: &corners,
        indices: &indices,
        bottom_up: false,
    };
    let mut rows = Vec::new();
    for side in [1024, 2048, 4096] {
        let size = TargetSize::new(side, side)?;
        for (step, conservative, gutter) in [
            ("atlas", false, 0),
            ("atlas, conservative, gutter 4", true, 4),
        ] {
            let options = AtlasOptions {
                conservative,
                gutter,
                threads,
                ..AtlasOptions::default()
            };
            rows.push(Row {
                step,
                count: side as usize * side as usize,
                threads,
                seconds: least(3, || {
                    black_box(Atlas::new(size, &atlas, options)).ok();
                }),
            });
        }
    }
    Ok(rows)
}

fn corners(positions: &[[f32; 3]], faces: &Faces) -> Vec<[f32; 3]> {
    let corners = faces.corners().iter();
    corners.map(|&i| positions[i as usize]).collect()
}

/// Milliseconds over triangles on one thread.
fn chart(path: &Path, rows: &[Row]) -> Result<(), Box<dyn Error + Send + Sync>> {
    let steps = [
        "mapping and seam repair",
        "report",
        "overlaps, one layer",
        "overlaps, two layers",
        "T-joints",
    ];
    let points = |step: &str| {
        let rows = rows.iter().filter(|r| r.step == step && r.threads == 1);
        let points = rows.map(|r| (r.count as f64, r.seconds * 1e3)).collect();
        (step.to_owned(), points)
    };
    LogChart {
        caption: "uv mapper on one thread, minima",
        counted: "triangles",
        counts: 50_000.0..5_000_000.0,
        milliseconds: 1.0..20_000.0,
        linear: ([62_500.0, 4_000_000.0], 2e-5),
    }
    .write(path, &steps.map(points))
}

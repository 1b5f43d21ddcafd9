//! `uv/...`: mapping, repair, report and overlap test. Each asserts its result.
//!
//! `cargo bench -p texmap-benches --bench uv`

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use texmap_benches::meshes::ball;
use texmap_math::Level;
use texmap_uv::{
    Mapping, Mesh, Origin, ReportOptions, Shape, cylinder_uv_batch, overlaps, report,
    sphere_uv_batch,
};

fn slices(c: &mut Criterion) {
    let vectors: Vec<[f32; 3]> = ball(2_000_000).0;
    let mut out = vec![[0.0; 2]; vectors.len()];
    let mut group = c.benchmark_group("uv/slice-1M");
    group.throughput(Throughput::Elements(vectors.len() as u64));
    // The yardstick: what it costs to read the vectors and write as many pairs.
    group.bench_function("copy", |b| {
        b.iter(|| {
            for (v, o) in black_box(&vectors).iter().zip(&mut out) {
                *o = [v[0], v[1]];
            }
            black_box(&mut out);
        });
    });
    group.bench_function("sphere", |b| {
        b.iter(|| sphere_uv_batch(Level::new(), black_box(&vectors), Origin::TopLeft, &mut out));
    });
    assert!(out.as_flattened().iter().all(|c| (0.0..=1.0).contains(c)));
    group.bench_function("cylinder", |b| {
        b.iter(|| cylinder_uv_batch(Level::new(), black_box(&vectors), Origin::TopLeft, &mut out));
    });
    group.finish();
}

fn meshes(c: &mut Criterion) {
    let mut group = c.benchmark_group("uv/mesh");
    group.sample_size(10);
    for triangles in [62_500, 250_000, 1_000_000, 4_000_000] {
        let (positions, faces) = ball(triangles);
        let mesh = Mesh::new(&positions, &faces).expect("a sound mesh");
        group.throughput(Throughput::Elements(faces.len() as u64));
        let mapping = Mapping::new(Shape::Sphere);
        let set = mapping
            .map(Level::new(), &mesh, &[])
            .expect("a mapping")
            .set;
        group.bench_with_input(
            BenchmarkId::new("sphere-repaired", triangles),
            &mesh,
            |b, mesh| {
                b.iter(|| mapping.map(Level::new(), mesh, &[]));
            },
        );
        let options = ReportOptions {
            views: false,
            ..ReportOptions::default()
        };
        let found = report(&mesh, &set, &options).expect("a report");
        assert_eq!(
            (found.overlapping, found.wide, found.flipped, found.islands),
            (0, 0, 0, 1)
        );
        group.bench_with_input(BenchmarkId::new("report", triangles), &mesh, |b, mesh| {
            b.iter(|| report(mesh, &set, &options));
        });
        assert_eq!(overlaps(&mesh, &set).expect("an answer").pairs, 0);
        group.bench_with_input(BenchmarkId::new("overlaps", triangles), &mesh, |b, mesh| {
            b.iter(|| overlaps(mesh, &set));
        });
    }
    group.finish();
}

criterion_group!(benches, slices, meshes);
criterion_main!(benches);

//! The rasterizer's stages on the mesh and depth scenes of the yardstick: `raster/<case>/<level>`. Each bench first asserts how many
//! pixels its scene covers.
use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use texmap_benches::scenes::{self, Sphere};
use texmap_math::Level;
use texmap_raster::{
    Atlas, AtlasMesh, AtlasOptions, AttributePlanes, BinnedDraws, Cull, DrawCall, NO_PRIMITIVE,
    NoAlphaTest, TargetSize, TileVisibility,
};

fn levels() -> Vec<(&'static str, Level)> {
    let best = Level::new();
    let mut levels = Vec::new();
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    {
        levels.extend(best.as_avx512().map(|t| ("avx512", Level::Avx512(t))));
        levels.extend(best.as_avx2().map(|t| ("avx2", Level::Avx2(t))));
        levels.extend(best.as_sse2().map(|t| ("sse2", Level::Sse2(t))));
    }
    if levels.is_empty() {
        levels.push(("best", best));
    }
    levels
}

fn draw(sphere: &Sphere, clip_from_object: texmap_math::glam::DMat4) -> DrawCall<'_> {
    DrawCall {
        positions: &sphere.positions,
        indices: &sphere.indices,
        attributes: &sphere.uvs,
        attribute_count: 2,
        clip_from_object,
        cull: Cull::Back,
        ..DrawCall::default()
    }
}

/// Prepares, finds what is visible, sets up planes; returns the number of covered pixels.
fn frame(
    level: Level,
    size: TargetSize,
    draw: &DrawCall<'_>,
    blocks: &mut TileVisibility,
    planes: &mut AttributePlanes,
) -> usize {
    let prepared = BinnedDraws::with_level(size, &[*draw], level, 1).expect("valid");
    let mut covered = 0;
    for tile in 0..prepared.tiles() {
        prepared.visible_blocks(tile, &NoAlphaTest, blocks);
        prepared.planes(tile, planes);
        covered += blocks.slot.iter().filter(|&&s| s != NO_PRIMITIVE).count();
    }
    covered
}

fn meshes(c: &mut Criterion) {
    let size = TargetSize::new(1920, 1080).expect("valid");
    for (name, slices, stacks) in [
        ("mesh20k", 142, 71),
        ("mesh200k", 448, 224),
        ("mesh2m", 1416, 708),
    ] {
        let sphere = Sphere::new(slices, stacks);
        let draw = draw(&sphere, scenes::mesh_camera());
        let (mut blocks, mut planes) = (TileVisibility::new(), AttributePlanes::new());
        let mut group = c.benchmark_group(format!("raster/{name}"));
        group.sample_size(10);
        for (level_name, level) in levels() {
            let covered = frame(level, size, &draw, &mut blocks, &mut planes);
            assert!(
                (1_240_000..1_250_000).contains(&covered),
                "{name} covers {covered} pixels"
            );
            group.bench_function(level_name, |b| {
                b.iter(|| black_box(frame(level, size, &draw, &mut blocks, &mut planes)));
            });
        }
        group.finish();
    }
}

fn depth(c: &mut Criterion) {
    let size = TargetSize::new(2048, 2048).expect("valid");
    for (name, slices, stacks) in [("depth200k", 448, 224), ("depth2m", 1416, 708)] {
        let sphere = Sphere::new(slices, stacks);
        let draw = draw(&sphere, scenes::depth_camera());
        let mut group = c.benchmark_group(format!("raster/{name}"));
        group.sample_size(10);
        for (level_name, level) in levels() {
            let map = || {
                BinnedDraws::with_level(size, &[draw], level, 1)
                    .expect("valid")
                    .depth_map(1)
            };
            let covered = map().iter().filter(|&&d| d > 0.0).count();
            assert!(
                (2_515_000..2_518_000).contains(&covered),
                "{name} covers {covered} pixels"
            );
            group.bench_function(level_name, |b| b.iter(|| black_box(map())));
        }
        group.finish();
    }
}

fn atlas(c: &mut Criterion) {
    let sphere = Sphere::new(448, 224);
    let uvs: Vec<_> = sphere
        .uvs
        .chunks_exact(2)
        .map(|uv| [uv[0] / 4.0, uv[1] / 2.0])
        .collect();
    let mesh = AtlasMesh {
        uvs: &uvs,
        positions: &sphere.positions,
        normals: &sphere.positions,
        indices: &sphere.indices,
        bottom_up: false,
    };
    let size = TargetSize::new(1024, 1024).expect("valid");
    let mut group = c.benchmark_group("raster/atlas1024");
    group.sample_size(10);
    for conservative in [false, true] {
        let options = AtlasOptions {
            conservative,
            gutter: 4,
            threads: 1,
            ..AtlasOptions::default()
        };
        let name = if conservative {
            "conservative"
        } else {
            "centres"
        };
        group.bench_function(name, |b| {
            b.iter(|| black_box(Atlas::new(size, &mesh, options).expect("valid")));
        });
    }
    group.finish();
}

criterion_group!(benches, meshes, depth, atlas);
criterion_main!(benches);

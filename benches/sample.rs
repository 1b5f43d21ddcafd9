//! `sample/<filter>/<precision>/<level>`: a perspective floor, run by run, against the loop that
//! only computes the coordinates (`sample/coordinates/-/<level>`). Acceptance is by ratio in one run:
//! `cargo bench -p texmap-benches --bench sample`. `mips/<kind>`: mip chains, a texel of the base.

use std::hint::black_box;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use texmap_benches::textures::{square_texels, squares};
use texmap_math::{Footprint, Level};
use texmap_sample::{
    ColorSpace, Cubic, Filter, Origin, Precision, Sampler, Texture2d, sample_rgba8_slice,
    sample_slice,
};

const WIDTH: usize = 1920;
const ROWS: usize = 540;
const RUN: usize = 256;

/// Planes of u w, v w and w over the lower half of a 1920x1080 picture of a floor: u = x z, v = z.
struct Floor {
    repeats: f32,
}

impl Floor {
    /// uv and derivatives of one run of a row.
    fn coordinates(
        &self,
        row: usize,
        x0: usize,
        u: &mut [f32],
        v: &mut [f32],
        grads: &mut [Footprint],
    ) {
        let below = (row as f32 + 4.5) / ROWS as f32;
        let (per_x, per_y) = (1.0 / ROWS as f32, 1.0 / ROWS as f32);
        let z = 1.0 / below;
        for (i, ((u, v), d)) in u.iter_mut().zip(v.iter_mut()).zip(grads).enumerate() {
            let x = ((x0 + i) as f32 - 0.5 * WIDTH as f32) * per_x;
            *u = self.repeats * x * z;
            *v = self.repeats * z;
            *d = Footprint {
                du_dx: self.repeats * per_x * z,
                dv_dx: 0.0,
                du_dy: -*u * z * per_y,
                dv_dy: -*v * z * per_y,
            };
        }
    }
}

fn levels() -> Vec<(&'static str, Level)> {
    let best = Level::new();
    let mut levels = Vec::new();
    #[cfg(target_arch = "x86_64")]
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

fn floor(c: &mut Criterion) {
    let floor = Floor { repeats: 0.25 };
    let mut group = c.benchmark_group("sample");
    group.throughput(Throughput::Elements((WIDTH * ROWS) as u64));
    group.sample_size(20);
    let (mut u, mut v) = (vec![0.0; RUN], vec![0.0; RUN]);
    let mut grads = vec![Footprint::default(); RUN];
    group.bench_function("coordinates/-/-", |b| {
        b.iter(|| {
            for row in 0..ROWS {
                for x0 in (0..WIDTH).step_by(RUN) {
                    floor.coordinates(row, x0, &mut u, &mut v, &mut grads);
                    black_box((&mut u, &mut v, &mut grads));
                }
            }
        });
    });
    for side in [256, 1024] {
        let t = squares(side);
        for (name, filter) in [
            ("nearest", Filter::Nearest),
            ("bilinear", Filter::Bilinear),
            ("trilinear", Filter::Trilinear),
            ("anisotropic16", Filter::Anisotropic(16)),
            ("mip-nearest", Filter::MipNearest),
            ("bicubic", Filter::Bicubic(Cubic::CatmullRom)),
            ("ewa8", Filter::ewa(8)),
        ] {
            for precision in [Precision::Fast, Precision::Exact] {
                let sampler = Sampler {
                    filter,
                    precision,
                    ..Sampler::default()
                };
                for (level_name, level) in levels() {
                    let id = format!("{name}/{precision:?}/{level_name}/{side}").to_lowercase();
                    let mut bytes = vec![0; RUN];
                    let mut colors = vec![[0.0; 4]; RUN];
                    let with_grads = filter.reads_derivatives();
                    group.bench_function(&id, |b| {
                        b.iter(|| {
                            for row in 0..ROWS {
                                for x0 in (0..WIDTH).step_by(RUN) {
                                    floor.coordinates(row, x0, &mut u, &mut v, &mut grads);
                                    let d = with_grads.then_some(&grads[..]);
                                    let done = match precision {
                                        Precision::Fast => sample_rgba8_slice(
                                            level, &sampler, &t, &u, &v, d, &mut bytes,
                                        ),
                                        Precision::Exact => sample_slice(
                                            level,
                                            &sampler,
                                            &t,
                                            &u,
                                            &v,
                                            d,
                                            &mut colors,
                                        ),
                                    };
                                    assert!(done.is_ok());
                                    black_box((&mut bytes, &mut colors));
                                }
                            }
                        });
                    });
                }
            }
        }
    }
    group.finish();
}

/// A mip chain of each kind, with a copy of its base level.
fn mips(c: &mut Criterion) {
    let mut group = c.benchmark_group("mips");
    group.sample_size(20);
    for (name, side, color, normals) in [
        ("bytes", 1024, ColorSpace::Linear, false),
        ("srgb", 1024, ColorSpace::Srgb, false),
        ("normals", 1024, ColorSpace::Linear, true),
        ("odd", 1023, ColorSpace::Srgb, false),
    ] {
        let base = Texture2d::from_rgba8(side, side, square_texels(side), color, Origin::TopLeft)
            .expect("a texture");
        group.throughput(Throughput::Elements(u64::from(side * side)));
        group.bench_function(name, |b| {
            b.iter(|| match normals {
                true => base.clone().with_normal_mips(),
                false => base.clone().with_mips(),
            });
        });
    }
}

criterion_group!(benches, floor, mips);
criterion_main!(benches);

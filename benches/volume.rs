//! `volume/march/<what>` and `volume/pattern/<what>`: nanoseconds a step of a ray through a grid of 64^3, and a value of each
//! pattern: `cargo bench -p texmap-benches --bench volume`. The throughput counts steps, or values.

use std::hint::black_box;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use texmap_math::Level;
use texmap_sample::{
    Alpha, ColorSpace, Filter, Image, Origin, Pattern, Sampler, TexelData, Texture2d, Texture3d,
    VolumeIntegrator, Wrap,
};

const SIDE: u32 = 64;
const RAYS: u32 = 32;

fn grid() -> Texture3d<'static> {
    let texels: Vec<u8> = (0..SIDE * SIDE * SIDE)
        .map(|i| {
            let p = [i % SIDE, i / SIDE % SIDE, i / SIDE / SIDE].map(|c| c as f32 / 16.0);
            (Pattern::Noise { octaves: 2 }.value(p, 0.0) * 255.0) as u8
        })
        .collect();
    let slices = Image {
        width: SIDE,
        height: SIDE,
        channels: 1,
        texels: TexelData::U8(&texels),
        color: ColorSpace::Linear,
        alpha: Alpha::Data,
        origin: Origin::TopLeft,
    };
    Texture3d::new(SIDE, &slices)
        .expect("64^3 voxels")
        .with_mips()
}

fn march(c: &mut Criterion) {
    let grid = grid();
    let ramp = Texture2d::from_rgba8(
        4,
        1,
        [
            [0, 0, 0, 0],
            [90, 20, 10, 30],
            [240, 160, 40, 90],
            [255, 255, 220, 255],
        ]
        .concat(),
        ColorSpace::Srgb,
        Origin::TopLeft,
    )
    .expect("a row");
    let sampler = |filter| Sampler {
        filter,
        wrap_u: Wrap::ClampToEdge,
        wrap_v: Wrap::ClampToEdge,
        ..Sampler::default()
    };
    let (nearest, linear) = (sampler(Filter::Nearest), sampler(Filter::Bilinear));
    let transfer = Some((&ramp, &linear));
    let mut group = c.benchmark_group("volume/march");
    for (name, sampler, transfer, density) in [
        ("nearest", &nearest, None, 0.5),
        ("bilinear", &linear, None, 0.5),
        ("bilinear, transfer", &linear, transfer, 0.5),
        ("bilinear, transfer, ends early", &linear, transfer, 500.0),
    ] {
        let volume = VolumeIntegrator::new(&grid, sampler, transfer, density, 1.0 / 128.0)
            .expect("good numbers");
        let in_lanes = volume.clone().on_level(Level::new());
        for (how, volume) in [("one at a time", volume), ("lanes", in_lanes)] {
            let all = || {
                let ray = |i: u32| {
                    let at = (f64::from(i) + 0.5) / f64::from(RAYS);
                    volume.integrate([-1.0, at, 1.0 - 0.7 * at], [0.9, 0.05, 0.02], (0.0, 1e9))
                };
                (0..RAYS).map(|i| black_box(ray(i)).steps).sum::<u32>()
            };
            group.throughput(Throughput::Elements(u64::from(all())));
            group.bench_function(format!("{name}, {how}"), |b| b.iter(all));
        }
    }
    group.finish();
}

fn pattern(c: &mut Criterion) {
    let mut group = c.benchmark_group("volume/pattern");
    group.throughput(Throughput::Elements(1024));
    for (name, pattern) in [
        ("noise, 1 octave", Pattern::Noise { octaves: 1 }),
        ("noise, 4 octaves", Pattern::Noise { octaves: 4 }),
        (
            "marble",
            Pattern::Marble {
                octaves: 4,
                turbulence: 1.0,
            },
        ),
        ("wood", Pattern::Wood { grain: 0.2 }),
    ] {
        group.bench_function(name, |b| {
            b.iter(|| {
                let value = |i: u32| pattern.value([0.37, 0.11, 0.53].map(|s| s * i as f32), 0.01);
                (0..1024).map(|i| value(black_box(i))).sum::<f32>()
            });
        });
    }
    group.finish();
}

criterion_group!(benches, march, pattern);
criterion_main!(benches);

//! Errors of the environment layouts, as the page `docs/generated/charts.md` (MIT 6.837, lecture 18). The light is a known
//! function of directions, stored in about 24,400 texels, and looked up bilinearly and without seams.
#![allow(clippy::print_stdout, reason = "the page is its output")]

use std::f64::consts::TAU;

use texmap_light::{Environment, EnvironmentLayout};
use texmap_math::deterministic_f64;
use texmap_math::glam::DVec3;

/// Number of draws of the waves. One draw says little about a layout whose error is concentrated around one direction.
const DRAWS: u64 = 16;

fn main() {
    let directions: u32 = std::env::args()
        .nth(1)
        .and_then(|n| n.parse().ok())
        .unwrap_or(400_000 / DRAWS as u32);
    println!("# What's the best chart?\n");
    println!(
        "Written by `cargo run --release -p texmap-light --example charts > docs/generated/charts.md`. Light is a sum of 64 plane"
    );
    println!(
        "waves of frequency F with unit RMS; each chart stores about 24,400 texels with a border of one texel over its"
    );
    println!(
        "edges; bilinear look-ups in {directions} uniform directions of each of {DRAWS} draws of the waves: means of the draws, with"
    );
    println!("the smallest and largest for F = 20. Solid angles are those of single texels.\n");
    println!(
        "| chart | texels | largest / smallest solid angle | RMSE F = 10 | F = 20 | F = 40 | largest error F = 20 |"
    );
    println!("|---|---|---|---|---|---|---|");
    let waves =
        [10.0, 20.0, 40.0].map(|f| (0..DRAWS).map(|draw| waves(f, draw)).collect::<Vec<_>>());
    let mut best = (f64::MAX, EnvironmentLayout::Cube);
    for chart in EnvironmentLayout::ALL {
        let size = match chart {
            EnvironmentLayout::Cube | EnvironmentLayout::TanCube => 64,
            EnvironmentLayout::LatLong => 111,
            EnvironmentLayout::DualParaboloid => 110,
            _ => 156,
        };
        let errors = waves.each_ref().map(|draws| {
            let all: Vec<_> = draws
                .iter()
                .map(|w| error(chart, size, w, directions))
                .collect();
            let mean = all.iter().map(|(e, _)| e).sum::<f64>() / all.len() as f64;
            let least = all.iter().map(|(e, _)| *e).fold(f64::MAX, f64::min);
            let most = all.iter().map(|(e, _)| *e).fold(0.0, f64::max);
            let worst = all.iter().map(|(_, w)| w).sum::<f64>() / all.len() as f64;
            (mean, least, most, worst)
        });
        let texels = size * size * chart.aspect() * chart.faces() as u32;
        let [(a, ..), (b, least, most, worst), (c, ..)] = errors;
        println!(
            "| {} | {texels} | {:.2} | {a:.4} | {b:.4} ({least:.4} to {most:.4}) | {c:.3} | {worst:.3} |",
            chart.name(),
            spread(chart, size)
        );
        best = if b < best.0 { (b, chart) } else { best };
    }
    println!(
        "\nThe answer: the {} has the smallest error for its bytes, if its edges are handled; the plain cube",
        best.1.name()
    );
    println!(
        "comes next with a cheaper look-up. Lat-long is the one that files exchange: a good mean, with texels wasted on"
    );
    println!(
        "its poles. Octahedra need one square and no faces. Two paraboloids are what two renders can fill. The sphere map's"
    );
    println!(
        "texels have equal solid angles (but those that its rim cuts) and it is the worst all the same: they stretch"
    );
    println!(
        "without end towards the rim, which is one direction. Its error is that of the light around this one direction, and so it"
    );
    println!(
        "is the only row that depends on the draw: by nearly a half up and down, where the others keep to a tenth."
    );
    assert_eq!(best.1, EnvironmentLayout::TanCube);
}

/// Uniform directions and phases from a fixed seed.
fn noise(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed;
    move || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 53) as f64
    }
}

fn direction(next: &mut impl FnMut() -> f64) -> DVec3 {
    let z = 2.0 * next() - 1.0;
    let (sin, cos) = deterministic_f64::sin_cos(next() * TAU);
    let r = (1.0 - z * z).sqrt();
    DVec3::new(r * cos, r * sin, z)
}

fn waves(frequency: f64, draw: u64) -> Vec<(DVec3, f64)> {
    let mut next = noise(7 + 1_000 * draw);
    (0..64)
        .map(|_| (direction(&mut next) * frequency, next() * TAU))
        .collect()
}

fn light(waves: &[(DVec3, f64)], d: DVec3) -> f64 {
    (2.0f64 / 64.0).sqrt()
        * waves
            .iter()
            .map(|(k, p)| deterministic_f64::cos(k.dot(d) + p))
            .sum::<f64>()
}

/// RMSE and largest error.
fn error(
    chart: EnvironmentLayout,
    size: u32,
    waves: &[(DVec3, f64)],
    directions: u32,
) -> (f64, f64) {
    let environment = Environment::from_fn(chart, size, |d| [light(waves, d) as f32; 3])
        .expect("the size is in range");
    let mut next = noise(99);
    let (mut sum, mut worst) = (0.0, 0.0f64);
    for _ in 0..directions {
        let d = direction(&mut next);
        let error = (f64::from(environment.radiance(d.to_array().map(|c| c as f32))[0])
            - light(waves, d))
        .abs();
        sum += error * error;
        worst = worst.max(error);
    }
    ((sum / f64::from(directions)).sqrt(), worst)
}

fn spread(chart: EnvironmentLayout, size: u32) -> f64 {
    let (width, height) = (size * chart.aspect(), size);
    let (mut least, mut most) = (f64::MAX, 0.0f64);
    for face in 0..chart.faces() {
        for i in 0..width * height {
            let angle = chart.solid_angle(face, (i % width, i / width), (width, height));
            if angle > 0.0 {
                (least, most) = (least.min(angle), most.max(angle));
            }
        }
    }
    most / least
}

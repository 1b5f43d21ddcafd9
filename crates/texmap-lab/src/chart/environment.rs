//! Panel 3: charts of all directions.

use texmap_light::{Environment, EnvironmentLayout};
use texmap_math::deterministic_f64;
use texmap_math::glam::{DVec2, DVec3};

use super::time::{Effort, timed};
use super::{Across, Error, Panel, Point, SceneChart, Source};
use crate::LabError;
use crate::cases::Random;
use texmap_truth::picture::Picture;
use texmap_truth::strip::heat;

/// Light from all around: 64 plane waves of one frequency, unit RMS.
pub(super) struct Waves(Vec<(DVec3, f64)>);

impl Waves {
    pub(super) fn new(frequency: f64) -> Self {
        let mut random = Random(7);
        let wave = |_| {
            let k = direction(&mut random) * frequency;
            (k, random.range(0.0, std::f64::consts::TAU))
        };
        Self((0..64).map(wave).collect())
    }

    pub(super) fn light(&self, d: DVec3) -> f64 {
        let sum: f64 = self
            .0
            .iter()
            .map(|(k, p)| deterministic_f64::cos(k.dot(d) + p))
            .sum();
        (2.0f64 / 64.0).sqrt() * sum
    }

    pub(super) fn environment(
        &self,
        chart: EnvironmentLayout,
        size: u32,
    ) -> Result<Environment, LabError> {
        Ok(Environment::from_fn(chart, size, |d| {
            [self.light(d) as f32; 3]
        })?)
    }
}

/// Uniform on the sphere.
pub(super) fn direction(random: &mut Random) -> DVec3 {
    let z = random.range(-1.0, 1.0);
    let (sin, cos) = deterministic_f64::sin_cos(random.range(0.0, std::f64::consts::TAU));
    let r = (1.0 - z * z).sqrt();
    DVec3::new(r * cos, r * sin, z)
}

/// Faces of about 24,400 texels in all.
pub(super) fn size(chart: EnvironmentLayout) -> u32 {
    match chart {
        EnvironmentLayout::Cube | EnvironmentLayout::TanCube => 64,
        EnvironmentLayout::LatLong => 111,
        EnvironmentLayout::DualParaboloid => 110,
        _ => 156,
    }
}

/// A reconstruction of light from texels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Lookup {
    /// Bilinear with a border that continues over the edge of each face.
    Seamless,
    /// Bilinear, clamped at the edge of the face.
    Clamped,
    /// The nearest texel.
    Nearest,
}

impl Lookup {
    const ALL: [Self; 3] = [Self::Seamless, Self::Clamped, Self::Nearest];

    fn name(self, chart: EnvironmentLayout) -> String {
        let how = match self {
            Self::Seamless => "",
            Self::Clamped => ", clamped",
            Self::Nearest => ", nearest",
        };
        format!("{}{how}", chart.name())
    }

    fn light(self, environment: &Environment, directions: &[[f32; 3]], out: &mut [[f32; 3]]) {
        if self == Self::Seamless {
            // Both slices have one length.
            let _ = environment.radiance_slice(directions, out);
            return;
        }
        let (width, height) = environment.size();
        for (d, out) in directions.iter().zip(out) {
            let (face, uv) = environment.layout().locate(DVec3::from(d.map(f64::from)));
            let at = uv * DVec2::new(f64::from(width), f64::from(height));
            let texel = |x: f64, y: f64| {
                let clamp = |c: f64, n: u32| c.clamp(0.0, f64::from(n) - 1.0) as u32;
                let texel = environment.texel(face, clamp(x, width), clamp(y, height));
                texel.unwrap_or([f32::NAN; 3])
            };
            *out = if self == Self::Nearest {
                texel(at.x.floor(), at.y.floor())
            } else {
                let p = at - 0.5;
                let (low, t) = (p.floor(), (p - p.floor()).as_vec2());
                let mix = |a: [f32; 3], b: [f32; 3], t: f32| {
                    [0, 1, 2].map(|i| a[i] * (1.0 - t) + b[i] * t)
                };
                let row = |y: f64| mix(texel(low.x, y), texel(low.x + 1.0, y), t.x);
                mix(row(low.y), row(low.y + 1.0), t.y)
            };
        }
    }

    /// Senseless directions without a number.
    fn failures(self, environment: &Environment) -> Vec<String> {
        let odd = [0.0, -0.0, 1.0, -1.0, 1e-30, 1e30, f32::INFINITY, f32::NAN];
        let mut directions = Vec::new();
        for x in odd {
            for y in odd {
                directions.extend(odd.map(|z| [x, y, z]));
            }
        }
        let mut out = vec![[0.0; 3]; directions.len()];
        self.light(environment, &directions, &mut out);
        match out
            .iter()
            .filter(|c| !c.iter().all(|c| c.is_finite()))
            .count()
        {
            0 => Vec::new(),
            n => vec![format!("{n} senseless directions without a number")],
        }
    }
}

pub(super) fn panel(effort: Effort) -> Result<Panel, LabError> {
    let count = if effort == Effort::FULL {
        400_000
    } else {
        40_000
    };
    let mut random = Random(99);
    let directions: Vec<DVec3> = (0..count).map(|_| direction(&mut random)).collect();
    let single: Vec<[f32; 3]> = directions.iter().map(|d| d.as_vec3().to_array()).collect();
    let mut charts = Vec::new();
    for frequency in [10.0, 20.0, 40.0] {
        let waves = Waves::new(frequency);
        let truth: Vec<f64> = directions.iter().map(|&d| waves.light(d)).collect();
        let mut candidates = Vec::new();
        for chart in EnvironmentLayout::ALL {
            let environment = waves.environment(chart, size(chart))?;
            candidates.extend(Lookup::ALL.map(|lookup| (lookup, environment.clone())));
        }
        let mut points = Vec::new();
        for (lookup, environment) in &candidates {
            let mut out = vec![[0.0f32; 3]; single.len()];
            lookup.light(environment, &single, &mut out);
            let (width, height) = environment.size();
            let faces = environment.layout().faces() as u64;
            points.push(Point {
                method: lookup.name(environment.layout()),
                source: if *lookup == Lookup::Seamless {
                    Source::Texmap
                } else {
                    Source::Lab
                },
                time: None,
                error: Error::of(out.iter().zip(&truth).map(|(o, t)| f64::from(o[0]) - t)),
                bytes: Some(faces * u64::from(width) * u64::from(height) * 12),
                failures: lookup.failures(environment),
                picture: Some(picture(*lookup, environment, &waves)),
            });
        }
        // Enough directions to time by, few enough to stay in the cache beside the texels.
        let part = &single[..8192.min(single.len())];
        let mut runs: Vec<Box<dyn FnMut() + '_>> = Vec::new();
        for (lookup, environment) in &candidates {
            let mut out = vec![[0.0f32; 3]; part.len()];
            runs.push(Box::new(move || {
                lookup.light(environment, part, &mut out);
                std::hint::black_box(&out);
            }));
        }
        timed(&mut points, effort, part.len(), &mut runs);
        charts.push(SceneChart {
            id: format!("environment-{frequency}"),
            title: format!("64 plane waves of frequency {frequency}, about 24,400 texels"),
            truth: format!("the waves themselves in {count} uniform directions"),
            item: "look-up",
            unit: "of the light's RMS",
            across: Across::Time,
            points,
        });
    }
    Ok(Panel {
        id: "environment",
        title: "Environment charts",
        about: "Light from every direction in one of seven charts of equal storage. texmap's look-ups are bilinear over \
                a border that continues across the edges; clamped and nearest ones are the lab's. A look-up is hollow \
                when zero, infinite or undefined directions give no number.",
        charts,
    })
}

/// The ball of directions seen from +Z, mirrored rays in the lower half, beside its error: white from 0.5.
fn picture(lookup: Lookup, environment: &Environment, waves: &Waves) -> Picture {
    const SIDE: u32 = 128;
    let mut picture = Picture::new(2 * SIDE + 2, SIDE, [96, 96, 128, 255]);
    for i in 0..SIDE * SIDE {
        let (x, y) = (i % SIDE, i / SIDE);
        let at = |c: u32| (f64::from(c) + 0.5) / f64::from(SIDE) * 2.0 - 1.0;
        let (nx, ny) = (at(x), -at(y));
        let left = 1.0 - nx * nx - ny * ny;
        if left <= 0.0 {
            continue;
        }
        let n = DVec3::new(nx, ny, left.sqrt());
        let d = n * (2.0 * n.z) - DVec3::Z;
        let mut out = [[0.0f32; 3]];
        lookup.light(environment, &[d.as_vec3().to_array()], &mut out);
        let found = f64::from(out[0][0]);
        let c = ((found * 0.2 + 0.5).clamp(0.0, 1.0) * 15.0).round() as u8 * 17;
        picture.set(x.into(), y.into(), [c, c, c, 255]);
        let off = ((found - waves.light(d)).abs() * 2.0 * 12.0).round() / 12.0;
        picture.set(i64::from(x + SIDE + 2), y.into(), heat(off));
    }
    picture
}

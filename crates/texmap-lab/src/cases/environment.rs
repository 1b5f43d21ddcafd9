//! E1 to E7: environment charts and light maps.

use std::f64::consts::TAU;

use texmap_bake::{BakeOptions, bake};
use texmap_light::{Environment, EnvironmentLayout, Light};
use texmap_math::camera::Camera;
use texmap_math::color;
use texmap_math::deterministic_f64;
use texmap_math::glam::{DVec2, DVec3};
use texmap_raster::Coverage;
use texmap_scene::{Material, Mesh, Scene};

use super::Measurement;
use crate::LabError;

/// Uniform numbers from a fixed seed.
pub(super) struct Noise(u64);

impl Noise {
    pub(super) fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// 0..1.
    pub(super) fn unit(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// 64 plane waves of frequency 10 with unit RMS.
struct Waves(Vec<(DVec3, f64)>);

impl Waves {
    fn new() -> Self {
        let mut noise = Noise::new(7);
        Self(
            (0..64)
                .map(|_| (direction(&mut noise) * 10.0, noise.unit() * TAU))
                .collect(),
        )
    }

    fn at(&self, d: DVec3) -> f64 {
        let sum: f64 = self
            .0
            .iter()
            .map(|(k, p)| deterministic_f64::cos(k.dot(d) + p))
            .sum();
        (2.0f64 / 64.0).sqrt() * sum
    }
}

fn direction(noise: &mut Noise) -> DVec3 {
    let z = 2.0 * noise.unit() - 1.0;
    let (sin, cos) = deterministic_f64::sin_cos(noise.unit() * TAU);
    let r = (1.0 - z * z).sqrt();
    DVec3::new(r * cos, r * sin, z)
}

fn rendered(chart: EnvironmentLayout, size: u32, waves: &Waves) -> Result<Environment, LabError> {
    Environment::from_fn(chart, size, |d| [waves.at(d) as f32; 3])
        .map_err(|e| LabError::Cases(e.to_string()))
}

fn narrow(d: DVec3) -> [f32; 3] {
    d.to_array().map(|c| c as f32)
}

/// The naive look-up: each face clamped at its own edge, in both directions.
fn clamped(environment: &Environment, d: DVec3) -> f64 {
    let (face, uv) = environment.layout().locate(d);
    let (w, h) = environment.size();
    let last = DVec2::new(f64::from(w) - 1.0, f64::from(h) - 1.0);
    let p = (uv * (last + 1.0) - 0.5).clamp(DVec2::ZERO, last);
    let (low, f) = (p.floor(), p - p.floor());
    let texel = |i: f64, j: f64| {
        let (x, y) = ((low.x + i).min(last.x), (low.y + j).min(last.y));
        let texel = environment.texel(face, x as u32, y as u32);
        texel.map_or(f64::NAN, |c| f64::from(c[0]))
    };
    let row = |j: f64| texel(0.0, j) * (1.0 - f.x) + texel(1.0, j) * f.x;
    row(0.0) * (1.0 - f.y) + row(1.0) * f.y
}

/// Largest errors of the seamless and of the clamped look-up over directions.
fn errors(
    chart: EnvironmentLayout,
    size: u32,
    directions: impl Iterator<Item = DVec3>,
) -> Result<(f64, f64), LabError> {
    let waves = Waves::new();
    let environment = rendered(chart, size, &waves)?;
    let (mut worst, mut naive) = (0.0f64, 0.0f64);
    for d in directions {
        let truth = waves.at(d);
        worst = worst.max((f64::from(environment.radiance(narrow(d))[0]) - truth).abs());
        naive = naive.max((clamped(&environment, d) - truth).abs());
    }
    Ok((worst, naive))
}

pub(super) fn e1() -> Result<Vec<Measurement>, LabError> {
    let mut noise = Noise::new(3);
    let near_edges = (0..40_000).map(move |i| {
        let mut d = [
            1.0,
            1.0 + 2e-3 * (noise.unit() - 0.5),
            2.0 * noise.unit() - 1.0,
        ];
        if i % 4 == 0 {
            d[2] = 1.0 + 2e-3 * (noise.unit() - 0.5);
        }
        d.rotate_right(i % 3);
        let side = |x: f64, bit: usize| if ((i / 12) >> bit) & 1 == 0 { x } else { -x };
        DVec3::new(side(d[0], 0), side(d[1], 1), side(d[2], 2)).normalize()
    });
    let (worst, naive) = errors(EnvironmentLayout::Cube, 64, near_edges)?;
    let measure = "largest error at edges and corners, 64 x 64 faces, f = 10";
    Ok(measured![
        "border texels", measure => worst;
        "clamped faces", measure => naive;
    ])
}

pub(super) fn e2() -> Result<Vec<Measurement>, LabError> {
    let environment = rendered(EnvironmentLayout::SphereMap, 64, &Waves::new())?;
    let mut bad = 0;
    let mut naive = 0;
    for d in [
        [0.0, 0.0, -1.0],
        [-0.0, 0.0, -1.0],
        [0.0, -0.0, -7.0],
        [1e-30, 0.0, -1.0],
    ] {
        let light = environment.radiance(d);
        bad += u32::from(!light.iter().all(|c| c.is_finite()));
        // OpenGL's formula, m = 2 sqrt(x^2 + y^2 + (z + 1)^2).
        let [x, y, z] = d;
        let m: f32 = 2.0 * (x * x + y * y + (z + 1.0) * (z + 1.0)).sqrt();
        naive += u32::from(!(x / m + 0.5).is_finite());
    }
    let measure = "directions at -Z without a defined colour";
    Ok(measured![
        "the rim for m = 0", measure => f64::from(bad);
        "division by m", measure => f64::from(naive);
    ])
}

pub(super) fn e3() -> Result<Vec<Measurement>, LabError> {
    let values = [-1.0, -0.0, 0.0, 1.0];
    let special = (0..64)
        .map(|i| DVec3::new(values[i % 4], values[i / 4 % 4], values[i / 16]))
        .filter(|d| *d != DVec3::ZERO);
    let mut noise = Noise::new(5);
    let uniform = (0..1_000_000).map(move |_| direction(&mut noise));
    let (mut worst, mut naive) = (0.0f64, 0.0f64);
    for d in special.chain(uniform) {
        let unit = d / d.length();
        for chart in [
            EnvironmentLayout::Octahedron,
            EnvironmentLayout::EqualAreaOctahedron,
        ] {
            let (face, uv) = chart.locate(d);
            worst = worst.max(1.0 - chart.direction(face, uv).dot(unit));
        }
        // The folded half with a sign that is 0 for 0.
        let sign = |x: f64| if x == 0.0 { 0.0 } else { x.signum() };
        let p = d.truncate() / (d.x.abs() + d.y.abs() + d.z.abs());
        let q = if d.z < 0.0 {
            DVec2::new(sign(p.x) * (1.0 - p.y.abs()), sign(p.y) * (1.0 - p.x.abs()))
        } else {
            p
        };
        let back = EnvironmentLayout::Octahedron
            .direction(0, DVec2::new(0.5 * q.x + 0.5, 0.5 - 0.5 * q.y));
        naive = naive.max(1.0 - back.dot(unit));
    }
    let measure = "1 less the cosine of a direction and its round trip";
    Ok(measured![
        "sign(0) = 1", measure => worst;
        "sign(0) = 0", measure => naive;
    ])
}

pub(super) fn e4() -> Result<Vec<Measurement>, LabError> {
    let mut noise = Noise::new(11);
    let equator = (0..20_000).map(move |_| {
        let (sin, cos) = deterministic_f64::sin_cos(noise.unit() * TAU);
        DVec3::new(cos, sin, 2e-3 * (noise.unit() - 0.5)).normalize()
    });
    let mut noise = Noise::new(12);
    let inside = (0..20_000).map(move |_| {
        let d = direction(&mut noise);
        DVec3::new(d.x, d.y, d.z.signum() * (0.05 + d.z.abs())).normalize()
    });
    let (at_rim, naive) = errors(EnvironmentLayout::DualParaboloid, 110, equator)?;
    let (interior, _) = errors(EnvironmentLayout::DualParaboloid, 110, inside)?;
    let measure = "largest error at the equator over that of the interior";
    Ok(measured![
        "texels past the rim", measure => at_rim / interior;
        "clamped squares", "largest error at the equator" => naive;
    ])
}

pub(super) fn e5() -> Result<Vec<Measurement>, LabError> {
    let directions = || {
        let mut noise = Noise::new(13);
        (0..40_000).map(move |i| {
            let (sin, cos) = deterministic_f64::sin_cos(noise.unit() * TAU);
            let small = 0.03 * noise.unit();
            match i % 3 {
                0 => DVec3::new(small * cos, 1.0, small * sin).normalize(),
                1 => DVec3::new(small * cos, -1.0, small * sin).normalize(),
                _ => DVec3::new(0.02 * (noise.unit() - 0.5), 2.0 * noise.unit() - 1.0, 1.0)
                    .normalize(),
            }
        })
    };
    let (worst, naive) = errors(EnvironmentLayout::LatLong, 111, directions())?;
    let measure = "largest error of the clamped look-up over that of the method, poles and seam";
    Ok(measured![
        "wrapped, across the pole", measure => naive / worst;
        "clamped", measure => 1.0;
    ])
}

/// Two squares side by side in one light map, one white, one dark: far apart in space, a gutter apart in the map.
fn two_charts(gap: f32) -> Scene {
    let square = |x: f32, left: f32, right: f32, away: bool| {
        let z = if away {
            [0, 2, 1, 3, 2, 0]
        } else {
            [0, 1, 2, 0, 2, 3]
        };
        Mesh {
            positions: vec![
                [x, 0.0, 0.0],
                [x + 1.0, 0.0, 0.0],
                [x + 1.0, 1.0, 0.0],
                [x, 1.0, 0.0],
            ],
            lightmap_uvs: vec![[left, 0.95], [right, 0.95], [right, 0.05], [left, 0.05]],
            triangles: vec![
                [z[0], z[1], z[2]],
                if away { [0, 3, 2] } else { [z[3], z[4], z[5]] },
            ],
            ..Mesh::default()
        }
    };
    let (lit, dark) = (
        square(0.0, 0.05, 0.5 - gap, false),
        square(9.0, 0.5 + gap, 0.95, true),
    );
    let mut both = lit;
    let base = both.positions.len() as u32;
    both.positions.extend(dark.positions);
    both.lightmap_uvs.extend(dark.lightmap_uvs);
    both.triangles
        .extend(dark.triangles.iter().map(|t| t.map(|v| v + base)));
    Scene {
        background: [0.0; 4],
        lights: vec![Light::Directional {
            color: [1.0; 3],
            direction: [0.0, 0.0, -1.0],
        }],
        materials: vec![Material::default()],
        meshes: vec![both],
        ..Scene::new(Camera {
            eye: DVec3::new(0.0, 0.0, 5.0),
            look: DVec3::ZERO,
            up: DVec3::Y,
            fov_x: 1.0,
            near: 1e-3,
            far: f64::INFINITY,
            lens: Default::default(),
        })
    }
}

pub(super) fn e6() -> Result<Vec<Measurement>, LabError> {
    let size = 64u32;
    // Charts six texels apart.
    let scene = two_charts(3.0 / size as f32);
    let leak = |gutter: u32, level: u32| -> Result<f64, LabError> {
        let options = BakeOptions {
            size,
            gutter,
            shadows: &[],
            lights: None,
        };
        let map = bake(&scene, 0, &options)?;
        // Box-filtered levels, as mip chains are made.
        let (mut texels, mut side) = (map.texels.clone(), size as usize);
        for _ in 0..level {
            let half = side / 2;
            texels = (0..half * half)
                .map(|i| {
                    let (x, y) = (i % half * 2, i / half * 2);
                    let at = |dx: usize, dy: usize| texels[(y + dy) * side + x + dx][0];
                    [0.25 * (at(0, 0) + at(1, 0) + at(0, 1) + at(1, 1)); 3]
                })
                .collect();
            side = half;
        }
        // Bilinear look-ups all over the two charts, against what each chart is.
        let mut worst = 0.0f64;
        for (left, right, truth) in [(0.05, 0.5 - 3.0 / 64.0, 1.0), (0.5 + 3.0 / 64.0, 0.95, 0.0)] {
            for i in 0..=400 {
                let u = left + (right - left) * f64::from(i) / 400.0;
                for v in [0.06, 0.3, 0.5, 0.94] {
                    let p = DVec2::new(u, v) * side as f64 - 0.5;
                    let (x, f) = (p.x.floor(), p.x - p.x.floor());
                    let y = p.y.round() as usize;
                    let texel = |x: f64| {
                        let x = x.clamp(0.0, side as f64 - 1.0) as usize;
                        f64::from(texels[y.min(side - 1) * side + x][0])
                    };
                    worst = worst.max((texel(x) * (1.0 - f) + texel(x + 1.0) * f - truth).abs());
                }
            }
        }
        let own = map
            .coverage
            .iter()
            .filter(|c| **c == Coverage::Centre)
            .count();
        if own == 0 {
            Ok(f64::NAN)
        } else {
            Ok(worst * 255.0)
        }
    };
    let measure = |level| format!("largest leak, /255, level {level}");
    Ok(measured![
        "gutter of 1", measure(0) => leak(1, 0)?;
        "gutter of 2", measure(1) => leak(2, 1)?;
        "no gutter", measure(0) => leak(0, 0)?;
        "gutter of 1", measure(2) => leak(1, 2)?;
    ])
}

pub(super) fn e7() -> Result<Vec<Measurement>, LabError> {
    let (mut worst, mut naive) = (0.0f64, 0.0f64);
    for (i, j) in (0..=32u8).flat_map(|i| (0..=32u8).map(move |j| (i, j))) {
        let (base, light) = (f32::from(i) / 32.0, f32::from(j) / 32.0);
        // Structure and light both sRGB codes, as files hold them.
        let linear = |code: f32| f64::from(color::srgb_to_linear(code));
        let encode = |c: f64| {
            if c <= 0.003_130_8 {
                12.92 * c
            } else {
                1.055 * deterministic_f64::pow(c, 1.0 / 2.4) - 0.055
            }
        };
        let truth = encode(linear(base) * linear(light)) * 255.0;
        let product = color::srgb_to_linear(base) * color::srgb_to_linear(light);
        worst = worst.max((f64::from(color::linear_to_srgb8(product)) - truth).abs());
        naive = naive.max((f64::from(base * light) * 255.0 - truth).abs());
    }
    let measure = "largest error of structure times light, /255";
    Ok(measured![
        "multiplied in linear light", measure => worst;
        "multiplied as codes", measure => naive;
    ])
}

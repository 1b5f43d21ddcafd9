//! `light/<effect>/<level>`: 4096 points through each effect of texmap-light, in lanes, and one at a time for the fallback.
//! The bits of all levels are asserted to be the same.
//!
//! `cargo bench -p texmap-benches --bench light`

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use texmap_light::lanes::{self, RayLanes, SpecularExponentLanes, Vector};
use texmap_light::{
    BoundProjectorTexture, Environment, EnvironmentLayout, Light, NormalMap, NormalMapGreen,
    PhongMaterial, ProjectorBorder, ProjectorTexture, Ray, ShadowBias, ShadowKind, ShadowMap,
    ShadowSampler, SpecularExponent, SpecularModel, evaluate_light, reflect_across, unit,
};
use texmap_math::glam::{DMat4, DVec3};
use texmap_math::simd::{Isa, Scalar, prelude::*};
use texmap_math::{Level, Projector, dispatch_simd};
use texmap_sample::{ColorSpace, Filter, Origin, Sampler, Texture2d};

const POINTS: usize = 4096;
const EYE: [f32; 3] = [0.3, 0.5, 4.0];

const SURFACE: PhongMaterial = PhongMaterial {
    color: [1.0; 3],
    ka: 0.2,
    kd: 0.8,
    ks: 0.4,
    ns: 32.0,
};

/// Vectors, component by component.
struct Vectors([Vec<f32>; 3]);

impl Vectors {
    fn new(seed: u32, of: impl Fn([f32; 3]) -> [f32; 3]) -> Self {
        let mut out = Self([Vec::new(), Vec::new(), Vec::new()]);
        let mut seed = seed;
        for _ in 0..POINTS {
            let mut noise = || {
                seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                (seed >> 8) as f32 / 8_388_608.0 - 1.0
            };
            let v = of([noise(), noise(), noise()]);
            out.0.iter_mut().zip(v).for_each(|(c, v)| c.push(v));
        }
        out
    }

    fn at(&self, i: usize) -> [f32; 3] {
        [self.0[0][i], self.0[1][i], self.0[2][i]]
    }

    #[inline(always)]
    fn lanes<I: Isa>(&self, i: I, at: usize) -> Vector<I> {
        [
            i.load_f32(&self.0[0][at..]),
            i.load_f32(&self.0[1][at..]),
            i.load_f32(&self.0[2][at..]),
        ]
    }
}

/// Inputs of the effects.
struct Input {
    points: Vectors,
    normals: Vectors,
    tangents: Vectors,
    texels: Vectors,
    steps: [Vectors; 2],
    light: Light,
    /// Of a spot light, and of a point light.
    shadows: [ShadowSampler; 2],
    picture: Texture2d<'static>,
    sampler: Sampler,
    /// In a cube, and in a lat-long chart.
    environments: [Environment; 2],
}

const MAP: NormalMap = NormalMap {
    green: NormalMapGreen::Up,
    rebuild_z: false,
    strength: 1.0,
};

impl Input {
    fn new() -> Self {
        let toward = |[x, y, z]: [f32; 3]| [0.5 * x, 0.5 * y, 1.5 + z];
        let small = |v: [f32; 3]| v.map(|c| 0.002 * c);
        // A light above that looks down.
        let down = DMat4::from_cols_array(&[
            1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0, -4.0, 1.0,
        ]);
        let spot = ShadowKind::Spot {
            light_from_world: down,
            tan_half: 0.5,
        };
        let around = ShadowKind::Point {
            position: DVec3::new(0.0, 4.0, 0.0),
        };
        let reader = |kind: ShadowKind, faces: u32| {
            let depths = (0..faces * 512 * 512).map(|i| 3.0 + ((i * 7919) % 512) as f32 / 256.0);
            let map = ShadowMap::new(kind, 512, depths.collect()).expect("a full map");
            ShadowSampler::new(map, ShadowBias::Constant(0.01), 3)
        };
        let environment = |chart: EnvironmentLayout| {
            let light = |d: DVec3| [d.x, d.y, d.z].map(|c| 0.5 + 0.5 * c as f32);
            let environment = Environment::from_fn(chart, 256, light);
            environment.expect("a chart").with_mips()
        };
        let texels = (0..256 * 256 * 4)
            .map(|i: u32| if i % 4 == 3 { 255 } else { (i / 7 % 256) as u8 })
            .collect();
        Self {
            points: Vectors::new(1, |v| v),
            normals: Vectors::new(2, |v| unit(toward(v))),
            tangents: Vectors::new(3, |[x, y, z]| unit([1.5 + x, 0.3 * y, 0.3 * z])),
            texels: Vectors::new(4, |[x, y, _]| [0.5 + 0.2 * x, 0.5 + 0.2 * y, 0.9]),
            steps: [Vectors::new(5, small), Vectors::new(6, small)],
            light: Light::Point {
                color: [0.9, 0.8, 0.7],
                position: [1.0, 3.0, 3.0],
            },
            shadows: [reader(spot, 1), reader(around, 6)],
            picture: Texture2d::from_rgba8(256, 256, texels, ColorSpace::Linear, Origin::TopLeft)
                .expect("a picture"),
            sampler: Sampler {
                filter: Filter::Bilinear,
                ..Sampler::default()
            },
            environments: [EnvironmentLayout::Cube, EnvironmentLayout::LatLong].map(environment),
        }
    }

    fn projector(&self) -> BoundProjectorTexture<'_> {
        let eye = DVec3::new(0.0, 4.0, 0.0);
        let projector = Projector::new(eye, DVec3::ZERO, DVec3::X, 0.8, 1.0);
        BoundProjectorTexture::new(&ProjectorTexture {
            projector: projector.expect("it looks down"),
            texture: &self.picture,
            sampler: &self.sampler,
            border: ProjectorBorder::Black,
            softness: 0.1,
        })
    }
}

/// An effect; its results are added up per point and component.
#[derive(Clone, Copy, Debug)]
enum Effect {
    Share(SpecularModel),
    NormalMap,
    /// By which of the maps.
    Shadow(usize),
    Slide,
    /// Of which of the environments.
    Mirror(usize),
}

impl Effect {
    const ALL: [(&'static str, Self); 8] = [
        ("phong", Self::Share(SpecularModel::Phong)),
        ("blinn", Self::Share(SpecularModel::Blinn)),
        ("normal-map", Self::NormalMap),
        ("shadow-pcf9", Self::Shadow(0)),
        ("cube-shadow-pcf9", Self::Shadow(1)),
        ("slide-places", Self::Slide),
        ("mirror", Self::Mirror(0)),
        ("lat-long-mirror", Self::Mirror(1)),
    ];

    /// One point.
    fn scalar(self, input: &Input, projector: &BoundProjectorTexture<'_>, i: usize) -> [f32; 3] {
        let (point, normal) = (input.points.at(i), input.normals.at(i));
        let view = [0, 1, 2].map(|k| EYE[k] - point[k]);
        let zero = [0.0; 3];
        match self {
            Self::Share(model) => {
                let power = SpecularExponent::new(SURFACE.ns);
                let light = &input.light;
                let given =
                    evaluate_light(&SURFACE, power, model, light, point, normal, unit(view));
                given.map_or(zero, |g| [g.diffuse, g.specular, g.color[0]])
            }
            Self::NormalMap => {
                let [x, y, z] = input.tangents.at(i);
                MAP.apply(Scalar, normal, [x, y, z], 1.0, input.texels.at(i))
            }
            Self::Shadow(map) => [input.shadows[map].visibility(point, normal), 0.0, 0.0],
            Self::Slide => {
                let places = projector.uv_at(Scalar, point);
                let fade = if places.reached { places.fade } else { 0.0 };
                [places.uv[0], places.uv[1], fade]
            }
            Self::Mirror(which) => {
                let back = |v: [f32; 3]| v.map(|c| -c);
                let [dx, dy] = [0, 1].map(|k| back(input.steps[k].at(i)));
                let view = Ray {
                    direction: view,
                    dx,
                    dy,
                };
                let normal = Ray {
                    direction: normal,
                    dx,
                    dy,
                };
                let ray = reflect_across(&view, &normal, 1.0);
                input.environments[which].radiance_filtered(&ray)
            }
        }
    }

    /// A block of points from `at` on.
    #[inline(always)]
    fn lanes<I: Isa>(
        self,
        i: I,
        input: &Input,
        projector: &BoundProjectorTexture<'_>,
        at: usize,
    ) -> Vector<I> {
        let (point, normal) = (input.points.lanes(i, at), input.normals.lanes(i, at));
        let mut view = point;
        for k in 0..3 {
            view[k] = i.f32(EYE[k]) - point[k];
        }
        let (zero, one) = (i.f32(0.0), i.f32(1.0));
        match self {
            Self::Share(model) => {
                let power = SpecularExponentLanes::Same(SpecularExponent::new(SURFACE.ns));
                let (light, view) = (&input.light, lanes::unit(i, view));
                let given =
                    lanes::evaluate_light(i, &SURFACE, power, model, light, point, normal, view);
                [
                    given.lit.select(given.diffuse, zero),
                    given.lit.select(given.specular, zero),
                    given.lit.select(given.color[0], zero),
                ]
            }
            Self::NormalMap => {
                let (tangent, texel) = (input.tangents.lanes(i, at), input.texels.lanes(i, at));
                MAP.apply(i, normal, tangent, one, texel)
            }
            Self::Shadow(map) => {
                let lit = input.shadows[map].visibility_lanes(i, i.mask(true), point, normal);
                [lit, zero, zero]
            }
            Self::Slide => {
                let places = projector.uv_at(i, point);
                [
                    places.uv[0],
                    places.uv[1],
                    places.reached.select(places.fade, zero),
                ]
            }
            Self::Mirror(which) => {
                let (mut dx, mut dy) = (input.steps[0].lanes(i, at), input.steps[1].lanes(i, at));
                for k in 0..3 {
                    (dx[k], dy[k]) = (-dx[k], -dy[k]);
                }
                let view = RayLanes {
                    direction: view,
                    dx,
                    dy,
                };
                let normal = RayLanes {
                    direction: normal,
                    dx,
                    dy,
                };
                let ray = lanes::reflect_across(i, &view, &normal, one);
                input.environments[which].radiance_lanes(i, &ray)
            }
        }
    }
}

/// An effect at every point.
fn run(level: Option<Level>, effect: Effect, input: &Input, out: &mut [Vec<f32>; 3]) {
    let projector = input.projector();
    let Some(level) = level else {
        for i in 0..POINTS {
            let value = effect.scalar(input, &projector, i);
            out.iter_mut().zip(value).for_each(|(out, v)| out[i] = v);
        }
        return;
    };
    dispatch_simd!(level, i => blocks(i, effect, input, &projector, out));
}

#[inline(always)]
fn blocks<I: Isa>(
    i: I,
    effect: Effect,
    input: &Input,
    projector: &BoundProjectorTexture<'_>,
    out: &mut [Vec<f32>; 3],
) {
    for at in (0..POINTS).step_by(I::LANES) {
        let value = effect.lanes(i, input, projector, at);
        for (out, v) in out.iter_mut().zip(value) {
            v.store(&mut out[at..]);
        }
    }
}

fn light(criterion: &mut Criterion) {
    let input = Input::new();
    let best = Level::new();
    let mut levels = Vec::new();
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    {
        levels.extend(best.as_avx512().map(|t| ("avx512", Some(Level::Avx512(t)))));
        levels.extend(best.as_avx2().map(|t| ("avx2", Some(Level::Avx2(t)))));
        levels.extend(best.as_sse2().map(|t| ("sse2", Some(Level::Sse2(t)))));
    }
    if levels.is_empty() {
        levels.push(("best", Some(best)));
    }
    levels.push(("fallback", None));
    for (name, effect) in Effect::ALL {
        let mut group = criterion.benchmark_group(format!("light/{name}"));
        group.throughput(Throughput::Elements(POINTS as u64));
        let mut expected = [0, 1, 2].map(|_| vec![0.0; POINTS]);
        run(None, effect, &input, &mut expected);
        assert!(expected[0].iter().any(|v| *v != expected[0][0]), "{name}");
        for (level_name, level) in &levels {
            let mut out = [0, 1, 2].map(|_| vec![0.0; POINTS]);
            group.bench_function(BenchmarkId::from_parameter(level_name), |bencher| {
                bencher.iter(|| run(*level, effect, &input, &mut out));
            });
            if out[0].iter().any(|v| *v != 0.0) {
                assert_eq!(out, expected, "{name} at {level_name}");
            }
        }
        group.finish();
    }
}

criterion_group!(benches, light);
criterion_main!(benches);

//! Laws of the model: nothing lost in a white furnace, reciprocity, no more light than there is; and lanes against the f64 reference.

use alloc::vec::Vec;
use texmap_math::deterministic_f64;
use texmap_math::glam::DVec3;

use super::*;
use crate::reference::metallic_roughness::{Gathered, Reflectance};
use crate::vector::select;
use crate::vector::{columns, load};

fn surface(metallic: f32, roughness: f32) -> MetallicRoughnessSurface {
    MetallicRoughnessLanes::new(Scalar, [1.0; 3], metallic, roughness)
}

fn layered(metallic: f32, roughness: f32) -> MetallicRoughnessSurface {
    MetallicRoughnessLanes {
        base_color: [0.9, 0.5, 0.1],
        f0: dielectric_f0(1.8, 0.7, [1.0, 0.6, 0.2]),
        f90: 0.7,
        clearcoat: Some(ClearcoatLanes {
            factor: 0.8,
            roughness: 0.3,
        }),
        sheen: Some(SheenLanes {
            color: [0.3, 0.6, 0.2],
            roughness: 0.5,
        }),
        ..surface(metallic, roughness)
    }
}

/// Directions over the upper hemisphere.
fn direction(k: usize, n: usize) -> DVec3 {
    let z = (k as f64 + 0.5) / n as f64;
    let (sin, cos) = deterministic_f64::sin_cos(k as f64 * 2.399_963_229_728_653);
    let s = (1.0 - z * z).sqrt();
    DVec3::new(s * cos, s * sin, z)
}

fn towards(nv: f64) -> DVec3 {
    DVec3::new((1.0 - nv * nv).sqrt(), 0.0, nv)
}

/// Radiance returned of even light of 1. The integral is over half vectors for the lobes and over directions for the rest.
fn furnace(surface: &MetallicRoughnessSurface, nv: f64) -> DVec3 {
    let reflectance = Reflectance::new(surface);
    let (n, view) = (DVec3::Z, towards(nv));
    let mut sum = DVec3::ZERO;
    // Even steps of the lobe's own distribution: half of the samples by half vectors, half by the cosine, weighted by the balance
    // heuristic.
    let alpha = f64::from(surface.roughness.max(MIN_ROUGHNESS)).powi(2);
    let steps = 160;
    for i in 0..steps {
        for j in 0..steps {
            let u = (f64::from(i) + 0.5) / f64::from(steps);
            let phi = (f64::from(j) + 0.5) / f64::from(steps) * core::f64::consts::TAU;
            let (sin, cos) = deterministic_f64::sin_cos(phi);
            let c = ((1.0 - u) / (1.0 + (alpha * alpha - 1.0) * u)).sqrt();
            let half = DVec3::new((1.0 - c * c).sqrt() * cos, (1.0 - c * c).sqrt() * sin, c);
            let mirrored = 2.0 * view.dot(half) * half - view;
            let s = u.sqrt();
            let spread = DVec3::new(s * cos, s * sin, (1.0 - u).sqrt());
            for light in [mirrored, spread] {
                if light.z <= 1e-9 {
                    continue;
                }
                let h = (view + light).normalize();
                let lobe = crate::reference::metallic_roughness::ggx(alpha, h.z) * h.z
                    / (4.0 * view.dot(h));
                let density = lobe + light.z * core::f64::consts::FRAC_1_PI;
                sum += reflectance.brdf(n, n, view, light) * light.z / density;
            }
        }
    }
    sum / f64::from(steps * steps)
}

#[test]
fn a_white_furnace_shows_no_surface() {
    for metallic in [0.0, 0.5, 1.0] {
        for roughness in [0.1, 0.4, 0.7, 1.0] {
            for nv in [0.2, 0.6, 1.0] {
                let got = furnace(&surface(metallic, roughness), nv);
                assert!(
                    (got - 1.0).abs().max_element() < 0.01,
                    "{metallic} {roughness} {nv}: {got}"
                );
            }
        }
    }
}

/// Without light that is scattered more than once, a rough metal returns less than half.
#[test]
fn one_bounce_loses_light() {
    let [a, b] = crate::reference::metallic_roughness::ggx_albedo(1.0, 1.0, 128);
    assert!(a + b < 0.5, "{}", a + b);
}

#[test]
fn layers_return_no_more_light_than_there_is() {
    for (metallic, roughness) in [(0.0, 0.3), (1.0, 0.2), (0.5, 1.0)] {
        for nv in [0.05, 0.3, 1.0] {
            let white = MetallicRoughnessSurface {
                base_color: [1.0; 3],
                sheen: Some(SheenLanes {
                    color: [1.0; 3],
                    roughness: 0.4,
                }),
                ..layered(metallic, roughness)
            };
            let got = furnace(&white, nv);
            assert!(
                got.max_element() < 1.01,
                "{metallic} {roughness} {nv}: {got}"
            );
            assert!(
                got.min_element() > 0.6,
                "{metallic} {roughness} {nv}: {got}"
            );
        }
    }
}

/// White sheets lose no light: what they do not return they pass. What coloured ones pass is no more than what they keep back.
#[test]
fn sheets_return_or_pass_all_light() {
    for roughness in [0.03, 0.3, 0.7, 1.0] {
        for nv in [0.05, 0.3, 1.0] {
            let sheet = |base_color: [f32; 3]| MetallicRoughnessSurface {
                base_color,
                transmission: Some(1.0),
                ..surface(0.0, roughness)
            };
            let white = sheet([1.0; 3]);
            let passing = |surface| Reflectance::new(surface).transmitted((nv, nv));
            let all = furnace(&white, nv) + DVec3::splat(passing(&white));
            assert!(
                (all - DVec3::ONE).abs().max_element() < 0.01,
                "{roughness} {nv}: {all}"
            );
            assert!(passing(&white) < 1.0 - f64::from(roughness) + 1e-6);
            let red = sheet([0.9, 0.3, 0.0]);
            let all = furnace(&red, nv) + DVec3::splat(passing(&red));
            assert!(all.max_element() < 1.01, "{roughness} {nv}: {all}");
            let opaque = MetallicRoughnessSurface {
                transmission: None,
                ..red
            };
            // A sheet is no darker than it would be without light from behind.
            assert!((all - furnace(&opaque, nv)).min_element() > -0.01);
        }
    }
    let metal = MetallicRoughnessSurface {
        transmission: Some(1.0),
        ..surface(1.0, 0.1)
    };
    assert_eq!(Reflectance::new(&metal).transmitted((0.5, 0.5)), 0.0);
}

#[test]
fn eye_and_light_may_change_places() {
    let smooth = DVec3::new(0.1, -0.05, 1.0).normalize();
    for (metallic, roughness) in [(0.0, 0.2), (0.4, 0.6), (1.0, 1.0)] {
        let reflectance = Reflectance::new(&layered(metallic, roughness));
        for k in 0..40 {
            let (v, l) = (direction(k, 40), direction((k * 7 + 3) % 40, 40));
            let there = reflectance.brdf(DVec3::Z, smooth, v, l);
            let back = reflectance.brdf(DVec3::Z, smooth, l, v);
            let off = (there - back).abs().max_element();
            assert!(off <= 1e-9 * there.max_element(), "{k}: {there} {back}");
        }
    }
}

fn sun(light: DVec3) -> Light {
    Light::Directional {
        color: [1.0, 0.5, 2.0],
        direction: (-light.as_vec3()).to_array(),
    }
}

#[test]
fn lights_give_what_the_reference_says() {
    let smooth = DVec3::new(0.1, -0.05, 1.0).normalize();
    let mut worst = 0.0f64;
    for (layers, transmission) in [(false, None), (true, None), (true, Some(0.8))] {
        for (metallic, roughness) in [(0.0, 0.2), (0.4, 0.6), (1.0, 1.0), (1.0, 0.1)] {
            let surface = if layers {
                layered(metallic, roughness)
            } else {
                surface(metallic, roughness)
            };
            let surface = MetallicRoughnessSurface {
                transmission,
                ..surface
            };
            let reflectance = Reflectance::new(&surface);
            for k in 0..60 {
                let (v, l) = (direction(k, 60), direction((k * 7 + 3) % 60, 60));
                // Near the mirrored direction too.
                let l = if k % 3 == 0 {
                    (DVec3::new(-v.x, -v.y, v.z) + 0.02 * l).normalize()
                } else {
                    l
                };
                let right = reflectance.brdf(DVec3::Z, smooth, v, l)
                    * (l.z * core::f64::consts::PI)
                    * DVec3::new(1.0, 0.5, 2.0);
                let narrow = |v: DVec3| v.as_vec3().to_array();
                let ready = ReflectanceLanes::new(
                    Scalar,
                    &surface,
                    [0.0, 0.0, 1.0],
                    narrow(smooth),
                    narrow(v),
                );
                let passing = reflectance.transmitted((v.z, smooth.dot(v)));
                let of_lanes = f64::from(ready.transmitted().unwrap_or(0.0));
                assert!((of_lanes - passing).abs() < 0.01, "{of_lanes} {passing}");
                assert_eq!(passing > 0.0, transmission.is_some() && metallic < 1.0);
                let (got, lit) = ready.under_light(Scalar, &sun(l), [0.0; 3]);
                assert!(lit);
                let got = DVec3::from(got.map(f64::from));
                // Albedos are off by 0.005, of which the lobes take parts.
                let off = ((got - right) / (right + 0.1)).abs().max_element();
                worst = worst.max(off);
                assert!(
                    off < 0.03,
                    "{layers} {metallic} {roughness} {k}: {got} {right}"
                );
            }
        }
    }
    assert!(worst > 1e-7, "the comparison compares nothing");
}

#[test]
fn lights_behind_reach_nothing_and_ambient_light_is_a_furnace() {
    let view = [0.0, 0.6, 0.8];
    let up = [0.0, 0.0, 1.0];
    let ready = ReflectanceLanes::new(Scalar, &surface(1.0, 0.7), up, up, view);
    let below = sun(DVec3::new(0.0, 0.3, -0.5));
    assert!(!ready.under_light(Scalar, &below, [0.0; 3]).1);
    let ambient = Light::Ambient { color: [0.5; 3] };
    let (got, lit) = ready.under_light(Scalar, &ambient, [0.0; 3]);
    assert!(lit && got.iter().all(|c| (c - 0.5).abs() < 2e-3), "{got:?}");
}

/// Vectors, roughnesses and layers of every kind; also far out of range, where values must stay finite.
#[test]
fn lanes_have_the_bits_of_one_point() {
    let all: Vec<[f32; 3]> = (0..48)
        .map(|i| [3, 5, 7].map(|k| ((i * k) % 11) as f32 * 0.3 - 1.4))
        .collect();
    let studio = EnvironmentLight::studio();
    every_width!(i => check(i, &all, &studio));
    fn one<I: Isa>(
        i: I,
        all: &[[f32; 3]],
        first: usize,
        studio: &EnvironmentLight,
    ) -> [[f32; 16]; 7] {
        let v = |k: usize| load(i, &all[k..], first);
        let share = |x: I::F32| x.abs().below(i.f32(1.0));
        let numbers = v(0);
        let surface = MetallicRoughnessLanes {
            base_color: v(1).map(share),
            metallic: share(numbers[0]),
            roughness: share(numbers[1]),
            f0: splat(i, dielectric_f0(1.5, 1.0, [1.0; 3])),
            f90: i.f32(1.0),
            transmission: Some(share(numbers[2])),
            clearcoat: Some(ClearcoatLanes {
                factor: i.f32(0.5),
                roughness: share(numbers[2]),
            }),
            sheen: Some(SheenLanes {
                color: v(2).map(share),
                roughness: share(numbers[0]),
            }),
        };
        let (normal, smooth, view) = (unit(i, v(3)), unit(i, v(4)), unit(i, v(5)));
        let ready = ReflectanceLanes::new(i, &surface, normal, smooth, view);
        let lamp = Light::Punctual {
            intensity: [3.0; 3],
            position: [0.2, 0.4, 1.0],
            range: 9.0,
            cone: None,
        };
        let (direct, lit) = ready.under_light(i, &lamp, v(6));
        let direct = select(lit, direct, splat(i, [0.0; 3]));
        let indirect = ready.under_environment(i, studio, i.f32(0.5), None);
        let [a, b, c] = direct;
        let [d, e, f] = indirect;
        let passing = ready.transmitted().unwrap_or(i.f32(0.0));
        columns(i, [a, b, c, d, e, f, passing])
    }
    fn check<I: Isa>(i: I, all: &[[f32; 3]], studio: &EnvironmentLight) {
        for first in (0..32).step_by(I::LANES) {
            let got = one(i, all, first, studio);
            for lane in 0..I::LANES {
                let right = one(Scalar, all, first + lane, studio);
                for (got, right) in got.iter().zip(right) {
                    assert!(
                        right[0].is_finite() && right[0] >= 0.0,
                        "{}: {}",
                        first + lane,
                        right[0]
                    );
                    assert_eq!(got[lane].to_bits(), right[0].to_bits(), "{}", first + lane);
                }
            }
        }
    }
}

/// Light that is even over the hemisphere, over the GGX lobe and over the clear layer.
fn gathered(even: [f32; 3], glossy: [f32; 3], coating: [f32; 3]) -> GatheredLanes<Scalar> {
    GatheredLanes {
        diffuse: even,
        irradiance: even,
        glossy,
        coating,
    }
}

/// Layered surfaces under even light within each lobe, and no lobe stands for another.
#[test]
fn even_light_gives_what_the_reference_says() {
    let smooth = DVec3::new(0.1, -0.05, 1.0).normalize();
    let [red, green, blue] = [[0.9, 0.1, 0.3], [0.2, 0.8, 0.1], [0.1, 0.3, 1.2]];
    for (metallic, roughness) in [(0.0, 0.2), (0.5, 0.6), (1.0, 0.9)] {
        let surface = layered(metallic, roughness);
        let reference = Reflectance::new(&surface);
        for nv in [0.1, 0.5, 0.97] {
            let view = towards(nv);
            let narrow = |v: DVec3| v.as_vec3().to_array();
            let got = ReflectanceLanes::new(
                Scalar,
                &surface,
                [0.0, 0.0, 1.0],
                narrow(smooth),
                narrow(view),
            );
            let cosines = (nv, smooth.dot(view));
            let wide = |c: [f32; 3]| DVec3::from(c.map(f64::from));
            let right = |irradiance, glossy, coating| {
                let light = Gathered {
                    irradiance: wide(irradiance),
                    grazing: wide(irradiance),
                    glossy: wide(glossy),
                    coating: wide(coating),
                };
                reference.under_gathered(cosines, &light)
            };
            let even = wide(got.under_gathered(Scalar, &gathered(red, green, blue)));
            let off = (even - right(red, green, blue)).abs().max_element();
            assert!(off < 0.012, "{metallic} {roughness} {nv}: {off}");
            let other = (even - right(green, red, blue)).abs().max_element();
            assert!(other > 0.02, "{metallic} {roughness} {nv}: {other}");
            let baked = wide(got.under_irradiance(red));
            let right = reference.under_irradiance(cosines, wide(red));
            let off = (baked - right).abs().max_element();
            assert!(off < 0.012, "{metallic} {roughness} {nv}: baked {off}");
        }
    }
}

/// Radiance towards the eye from an environment by its BRDF: over the texels of a cube, and over the directions of the base's lobe,
/// weighted by the balance heuristic.
fn integral(reflectance: &Reflectance, roughness: f32, room: &Room, n: DVec3, v: DVec3) -> DVec3 {
    let alpha = f64::from(roughness.max(MIN_ROUGHNESS)).powi(2);
    let steps = 40_u32;
    let lobe = f64::from(steps * steps);
    let weighted = |l: DVec3, light: DVec3, texel: f64| {
        let h = (v + l).normalize();
        let c = n.dot(h).max(0.0);
        let density = crate::reference::metallic_roughness::ggx(alpha, c) * c / (4.0 * v.dot(h));
        let nl = n.dot(l);
        reflectance.brdf(n, n, v, l) * light * nl / (1.0 / texel + lobe * density)
    };
    let mut sum = DVec3::ZERO;
    for (l, light, angle) in &room.texels {
        if n.dot(*l) > 0.0 {
            sum += weighted(*l, *light, *angle);
        }
    }
    let t = n.any_orthonormal_vector();
    let b = n.cross(t);
    for i in 0..steps * steps {
        let u = (f64::from(i / steps) + 0.5) / f64::from(steps);
        let phi = (f64::from(i % steps) + 0.5) / f64::from(steps) * core::f64::consts::TAU;
        let c = ((1.0 - u) / (1.0 + (alpha * alpha - 1.0) * u)).sqrt();
        let s = (1.0 - c * c).sqrt();
        let h = t * (s * phi.cos()) + b * (s * phi.sin()) + n * c;
        let l = 2.0 * v.dot(h) * h - v;
        if n.dot(l) > 1e-9 && v.dot(h) > 0.0 {
            sum += weighted(l, room.radiance(l), room.angle(l));
        }
    }
    sum
}

/// An environment light as its texels.
struct Room {
    light: EnvironmentLight,
    texels: Vec<(DVec3, DVec3, f64)>,
}

impl Room {
    fn new(light: EnvironmentLight, side: u32) -> Self {
        let mut room = Self {
            light,
            texels: Vec::new(),
        };
        let cube = crate::EnvironmentLayout::Cube;
        for k in 0..6 * side * side {
            let (face, x, y) = ((k / side / side) as usize, k % side, k / side % side);
            let centre = |c: u32| (f64::from(c) + 0.5) / f64::from(side);
            let uv = texmap_math::glam::DVec2::new(centre(x), centre(y));
            let d = cube.direction(face, uv);
            let angle = cube.solid_angle(face, (x, y), (side, side));
            room.texels.push((d, room.radiance(d), angle));
        }
        room
    }

    /// Solid angle of a texel in a direction.
    fn angle(&self, d: DVec3) -> f64 {
        let nearest = d.abs().max_element();
        24.0 / self.texels.len() as f64 * nearest * nearest * nearest
    }

    fn radiance(&self, d: DVec3) -> DVec3 {
        let light = self.light.radiance(0.0, d.as_vec3().to_array());
        DVec3::from(light.map(f64::from))
    }
}

/// Display codes of 0 to 1 under PBR Neutral.
fn code(light: DVec3) -> DVec3 {
    let display = crate::reference::tone_map(crate::ToneMap::PbrNeutral, 1.0, light);
    DVec3::from(display.to_array().map(|c| {
        if c <= 0.003_130_8 {
            12.92 * c
        } else {
            1.055 * c.powf(1.0 / 2.4) - 0.055
        }
    }))
}

/// Spheres of seven metalnesses by seven roughnesses in the studio, seen from afar, against the f64 integral of the BRDF. The error is that of
/// the lobes as they are seen head on; one is off by more than twice as much.
#[test]
fn spheres_in_the_studio_are_near_their_integral() {
    let room = Room::new(EnvironmentLight::studio(), 64);
    let side = 9u32;
    let view = DVec3::new(0.3, 0.35, 1.0).normalize();
    let x = DVec3::Y.cross(view).normalize();
    let y = view.cross(x);
    let narrow = |v: DVec3| v.as_vec3().to_array();
    let (mut squares, mut even_base) = ([0.0; 7], [0.0; 7]);
    let (mut single, mut dull, mut count) = (0.0, 0.0, 0);
    for (m, r) in (0..7u16).flat_map(|m| (0..7u16).map(move |r| (m, r))) {
        let roughness = f32::from(r) / 6.0;
        let surface = MetallicRoughnessSurface {
            base_color: [0.9, 0.6, 0.3],
            ..surface(f32::from(m) / 6.0, roughness)
        };
        let reference = Reflectance::new(&surface);
        for k in 0..side * side {
            let at = |k: u32| (f64::from(k) + 0.5) / f64::from(side) * 2.0 - 1.0;
            let (a, b) = (at(k % side), at(k / side));
            if a * a + b * b >= 0.96 {
                continue;
            }
            let n = x * a + y * b + view * (1.0 - a * a - b * b).sqrt();
            let lanes = ReflectanceLanes::new(Scalar, &surface, narrow(n), narrow(n), narrow(view));
            let right = code(integral(&reference, roughness, &room, n, view));
            let off = |light: [f32; 3]| {
                let got = code(DVec3::from(light.map(f64::from)));
                (got - right).length_squared() / 3.0
            };
            squares[usize::from(r)] += off(lanes.under_environment(Scalar, &room.light, 1.0, None));
            // As if as much light arrived at grazing incidence as elsewhere.
            let blind = ReflectanceLanes {
                per_left: 0.0,
                ..lanes
            };
            even_base[usize::from(r)] +=
                off(blind.under_environment(Scalar, &room.light, 1.0, None));
            let even = room.light.irradiance(narrow(n));
            let mirrored = narrow(2.0 * n.dot(view) * n - view);
            let one = room.light.radiance(roughness.max(MIN_ROUGHNESS), mirrored);
            single += off(lanes.under_gathered(Scalar, &gathered(even, one, one)));
            // Light without a lobe.
            dull += off(lanes.under_gathered(Scalar, &gathered(even, even, even)));
            count += 1;
        }
    }
    let root = |squares: f64| (squares / f64::from(count)).sqrt();
    let by_roughness = squares.map(|squares| root(7.0 * squares));
    let limits = [0.0011, 0.0150, 0.0098, 0.0060, 0.0039, 0.0034, 0.0048];
    assert!(
        by_roughness.iter().zip(limits).all(|(e, limit)| *e < limit),
        "{by_roughness:?}"
    );
    // Most of the error of smooth surfaces would be that of their diffuse light.
    let even_base = even_base.map(|squares| root(7.0 * squares));
    assert!(even_base[0] > 4.0 * by_roughness[0], "{even_base:?}");
    let (rmse, single, dull) = (root(squares.iter().sum()), root(single), root(dull));
    assert!(rmse < 0.0076, "{rmse}");
    assert!(
        single > 2.0 * rmse && dull > 2.0 * single,
        "{rmse} {single} {dull}"
    );
}

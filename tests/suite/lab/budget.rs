//! Budgets of the quality planner on random scenes, held against the true error of the pictures.

use texmap_lab::cases::Random;
use texmap_lab::plane::{Pattern, TEXELS};
use texmap_light::{Light, PhongMaterial};
use texmap_math::camera::Camera;
use texmap_math::deterministic_f64;
use texmap_math::glam::{DVec2, DVec3};
use texmap_planner::{Budget, choose, choose_sampled};
use texmap_planner::{Price, prices};
use texmap_render::{RenderSettings, render};
use texmap_sample::{ColorSpace, Filter, Origin, Sampler, Texture2d};
use texmap_scene::{ColorMode, Material, Mesh, Scene, Shading, TextureSlot};
use texmap_truth::verify::verify;

const SIDE: u32 = 32;
/// Samples a side of a pixel in the truth.
const SAMPLES: u32 = 6;

/// A quad beyond the whole picture: w-ratio 1 to 64, LOD -4 to 8 at its middle, turned coordinates, one of five
/// textures; unlit, or lit per pixel or per vertex, matt or shiny, by light that leaves white paper a quarter to four times its white.
fn scene(seed: u64) -> (Scene, Budget) {
    let mut random = Random(seed.wrapping_mul(0x0123_4567_89ab_cdef));
    let ratio = deterministic_f64::exp2(random.range(0.0, 6.0));
    let level = random.range(-4.0, 8.0);
    let turn = random.range(0.0, std::f64::consts::TAU);
    let kind = random.range(0.0, 5.0) as usize;
    let srgb = random.range(0.0, 1.0) < 0.5;
    let lit = random.range(0.0, 1.0) < 0.3;
    let rmse = [0.01, 0.02, 0.05][random.range(0.0, 3.0) as usize];
    let mut light = Random(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ 0x5a5a);
    let white = deterministic_f64::exp2(light.range(-2.0, 2.0)) as f32;
    let shiny = light.range(0.0, 1.0) < 0.3;
    let ks = if shiny { 0.3 } else { 0.0 };
    let strength = white / (1.0 + ks);
    let lit_at = if light.range(0.0, 1.0) < 0.7 {
        Shading::PerPixel
    } else {
        Shading::PerVertex
    };
    let color = if srgb {
        ColorSpace::Srgb
    } else {
        ColorSpace::Linear
    };
    let grey: Vec<u8> = match kind {
        0..3 => Pattern::ALL[kind].bytes(),
        3 => vec![90; TEXELS * TEXELS],
        _ => (0..TEXELS * TEXELS)
            .map(|i| (i % TEXELS / 2) as u8)
            .collect(),
    };
    let rgba = grey
        .iter()
        .flat_map(|&g| [g, g / 2 + 60, 255 - g, 255])
        .collect();
    let side = TEXELS as u32;
    let texture = Texture2d::from_rgba8(side, side, rgba, color, Origin::TopLeft).unwrap();
    let camera = Camera {
        eye: DVec3::ZERO,
        look: DVec3::NEG_Z,
        up: DVec3::Y,
        fov_x: 90f64.to_radians(),
        near: 1e-3,
        far: f64::INFINITY,
        lens: Default::default(),
    };
    // The plane's distance runs from 1 at one end of a turned axis to `ratio` at the other.
    let tilt = random.range(0.0, std::f64::consts::TAU);
    let axis = DVec2::new(deterministic_f64::cos(tilt), deterministic_f64::sin(tilt));
    let inv = |p: DVec2| {
        let t = p.dot(axis) / (2.0 * 1.3 * std::f64::consts::SQRT_2) + 0.5;
        1.0 + (1.0 / ratio - 1.0) * t
    };
    let corners = [(-1.3, 1.3), (1.3, 1.3), (1.3, -1.3), (-1.3, -1.3)].map(|(x, y)| {
        let p = DVec2::new(x, y);
        DVec3::new(x, y, -1.0) / inv(p)
    });
    // Coordinates linear on the plane; at the middle a pixel is 2^level texels wide.
    let middle = 1.0 / inv(DVec2::ZERO);
    let scale = deterministic_f64::exp2(level) / TEXELS as f64 * f64::from(SIDE) / 2.0 / middle;
    let (sin, cos) = deterministic_f64::sin_cos(turn);
    let e1 = (corners[1] - corners[0]).normalize();
    let normal = e1.cross(corners[3] - corners[0]).normalize();
    let e2 = normal.cross(e1);
    let uv = corners.map(|p| {
        let (a, b) = (
            (p - corners[0]).dot(e1) * scale,
            (p - corners[0]).dot(e2) * scale,
        );
        [(a * cos - b * sin) as f32, (a * sin + b * cos) as f32]
    });
    let material = Material {
        phong: PhongMaterial {
            color: [1.0; 3],
            ka: 0.3,
            kd: 0.7,
            ks,
            ns: 10.0,
        },
        base_color: Some(TextureSlot {
            sampler: Sampler {
                filter: Filter::Trilinear,
                ..Sampler::default()
            },
            ..TextureSlot::new(0)
        }),
        shading: if lit { lit_at } else { Shading::Unlit },
        ..Material::default()
    };
    let scene = Scene {
        camera,
        background: [0.0; 4],
        color: if srgb {
            ColorMode::Srgb
        } else {
            ColorMode::Raw
        },
        lights: vec![
            Light::Ambient {
                color: [strength; 3],
            },
            Light::Directional {
                color: [0.8, 0.9, 1.0].map(|c| c * strength),
                direction: [0.3, -0.4, -1.0],
            },
        ],
        textures: vec![texture],
        materials: vec![material],
        meshes: vec![Mesh {
            positions: corners.map(|p| p.as_vec3().to_array()).to_vec(),
            uvs: uv.to_vec(),
            triangles: vec![[0, 3, 2], [0, 2, 1]],
            ..Mesh::default()
        }],
        effects: Default::default(),
        depth_test: Default::default(),
        blend_order: Default::default(),
        warnings: Vec::new(),
    };
    (scene, Budget { texels: 0.5, rmse })
}

/// Scenes over their budget, and how many could not promise it.
fn over(seeds: std::ops::Range<u64>) -> (Vec<String>, usize) {
    let (mut over, mut unmet) = (Vec::new(), 0);
    for seed in seeds {
        let (scene, budget) = scene(seed);
        let choices = choose(&scene, SIDE, SIDE, budget).unwrap();
        if !choices.met() {
            unmet += 1;
            continue;
        }
        let mut planned = scene.clone();
        choices.apply(&mut planned);
        let settings = RenderSettings {
            supersample: choices.supersample,
            ..RenderSettings::new(SIDE, SIDE)
        };
        let frame = render(&planned, &settings, &texmap_render::no_progress).unwrap();
        let truth = verify(&scene, &frame, SAMPLES).unwrap();
        assert!(
            truth.judged > 900,
            "seed {seed}: {} pixels judged",
            truth.judged
        );
        if truth.rmse > budget.rmse {
            let choice = &choices.meshes[0];
            over.push(format!(
                "seed {seed}: {} > {}, predicted {}, {:?}",
                truth.rmse, budget.rmse, choice.predicted_rmse, choice.filter
            ));
        }
    }
    (over, unmet)
}

#[test]
fn a_budget_is_kept_on_random_scenes() {
    let (over, unmet) = over(0..12);
    assert!(over.is_empty(), "{}", over.join("\n"));
    assert!(unmet < 6, "{unmet} of 12 could not be promised");
}

/// `cargo test --release --workspace --test lab -- --ignored --nocapture thousand`
/// (found: none over its budget; 28 not promised, because nothing was predicted to fit, 4 x 4 samples neither)
#[test]
#[ignore = "minutes: run by hand, in release"]
fn a_budget_is_kept_on_a_thousand_random_scenes() {
    let (over, unmet) = over(0..1000);
    eprintln!(
        "1000 scenes: {} over their budget, {unmet} not promised",
        over.len()
    );
    assert!(over.is_empty(), "{}", over.join("\n"));
}

/// By the table of prices a plan costs little more than the cheapest filter that would have done, which is known
/// only afterwards. `cargo test --release --workspace --test lab -- --ignored --nocapture cheapest`
/// (found: 54 of 56 plans within 1.15, median 1; the dearest took a filter that the table prices at 35 times the next)
#[test]
#[ignore = "minutes: run by hand, in release"]
fn a_plan_is_about_as_cheap_as_the_cheapest_that_would_do() {
    let mut ratios = Vec::new();
    for seed in 0..100 {
        let (scene, budget) = scene(seed);
        let choices = choose_sampled(&scene, SIDE, SIDE, budget, &[1]).unwrap();
        let Some(chosen) = choices.meshes[0].filter.filter(|_| choices.met()) else {
            continue;
        };
        let price = prices()
            .iter()
            .find(|p| (p.filter, p.precision) == chosen)
            .map_or(f64::INFINITY, |p| p.ns);
        let fits = |p: &&Price| {
            let mut fixed = scene.clone();
            if let Some(slot) = &mut fixed.materials[0].base_color {
                slot.sampler.filter = p.filter;
                slot.sampler.precision = p.precision;
            }
            let frame = render(
                &fixed,
                &RenderSettings::new(SIDE, SIDE),
                &texmap_render::no_progress,
            )
            .unwrap();
            verify(&scene, &frame, SAMPLES).unwrap().rmse <= budget.rmse
        };
        let cheapest = prices().iter().find(fits).unwrap();
        ratios.push(price / cheapest.ns);
    }
    ratios.sort_by(f64::total_cmp);
    let within = ratios.iter().filter(|r| **r <= 1.15).count();
    eprintln!(
        "{within} of {} plans within 1.15 of the cheapest; median {}, dearest {}",
        ratios.len(),
        ratios[ratios.len() / 2],
        ratios[ratios.len() - 1]
    );
    assert!(within * 2 > ratios.len());
}

/// The cheapest filter everywhere breaks the budget.
#[test]
fn nearest_everywhere_breaks_the_budget() {
    let broken = (0..12).filter(|&seed| {
        let (scene, budget) = scene(seed);
        let settings = RenderSettings {
            filter: Some(Filter::Nearest),
            ..RenderSettings::new(SIDE, SIDE)
        };
        let frame = render(&scene, &settings, &texmap_render::no_progress).unwrap();
        verify(&scene, &frame, 2).unwrap().rmse > budget.rmse
    });
    assert!(broken.count() >= 4);
}

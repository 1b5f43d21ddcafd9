//! Time of the planner's choice beside every fixed filter, on the chart's tilted planes: the second half of
//! docs/generated/plans.md.
//!
//! `cargo run --release -p texmap-lab --example plan_costs` prints the table and ends with 1 if a plan is over its budget, costs
//! more than 1.15 times the cheapest filter that keeps it, or as much as all features where less would do.

#![allow(clippy::print_stdout, reason = "the table is the output")]

use std::error::Error;
use std::process::ExitCode;

use texmap_lab::plane::{Pattern, TEXELS};
use texmap_light::PhongMaterial;
use texmap_math::camera::Camera;
use texmap_math::glam::DVec3;
use texmap_planner::{Budget, choose, prices};
use texmap_render::{Frame, RenderSettings, render};
use texmap_sample::{ColorSpace, Filter, Origin, Precision, Sampler, Texture2d};
use texmap_scene::{ColorMode, Material, Mesh, Scene, Shading, TextureSlot};
use texmap_truth::verify::verify_all;

/// Pixels a side: half of the chart's, for the sake of the reference.
const SIDE: u32 = 128;
/// Samples a side of a pixel in the reference.
const SAMPLES: u32 = 6;
/// Most time of a plan over that of the cheapest filter that keeps the budget, which is known only afterwards.
const LIMIT: f64 = 1.15;

fn main() -> Result<ExitCode, Box<dyn Error>> {
    println!(
        "| scene | budget | plan | ns | predicted | measured | cheapest that keeps it | ns | plan / cheapest | plan / all features |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|");
    let grey = |p: Pattern| p.bytes();
    let scenes = [
        ("checker", grey(Pattern::Checker), 0.0, 1.0),
        ("sines", grey(Pattern::Sines), 0.0, 1.0),
        ("noise", grey(Pattern::Noise), 0.0, 1.0),
        (
            "sines, turned by 30 degrees",
            grey(Pattern::Sines),
            30.0,
            1.0,
        ),
        ("sines, magnified 8 times", grey(Pattern::Sines), 0.0, 8.0),
        ("one colour", vec![120; TEXELS * TEXELS], 0.0, 1.0),
    ];
    let (mut plans, mut faults) = (0, 0);
    for (name, bytes, turn, magnify) in scenes {
        let scene = plane(&bytes, turn, magnify)?;
        let draw = |scene: &Scene, supersample: u32| {
            let settings = RenderSettings {
                supersample,
                ..RenderSettings::new(SIDE, SIDE)
            };
            render(scene, &settings, &texmap_render::no_progress)
        };
        let fixed: Vec<Frame> = prices()
            .iter()
            .map(|p| {
                let mut fixed = scene.clone();
                if let Some(slot) = &mut fixed.materials[0].base_color {
                    (slot.sampler.filter, slot.sampler.precision) = (p.filter, p.precision);
                }
                draw(&fixed, 1)
            })
            .collect::<Result<_, _>>()?;
        let errors: Vec<f64> = verify_all(&scene, &fixed, SAMPLES)?
            .iter()
            .map(|v| v.rmse)
            .collect();
        let all = prices()
            .iter()
            .find(|p| (p.filter, p.precision) == (Filter::Anisotropic(16), Precision::Exact))
            .ok_or("the table has no anisotropic:16")?;
        for rmse in [0.1, 0.05, 0.03, 0.02, 0.01] {
            let budget = Budget { texels: 0.5, rmse };
            let choices = choose(&scene, SIDE, SIDE, budget)?;
            let cheapest = (0..errors.len()).find(|&i| errors[i] <= rmse);
            let least = cheapest.map_or_else(
                || "none | ".to_owned(),
                |i| {
                    format!(
                        "{} | {:.2}",
                        label(prices()[i].filter, prices()[i].precision),
                        prices()[i].ns
                    )
                },
            );
            let choice = &choices.meshes[0];
            if !choices.met() {
                println!(
                    "| {name} | {rmse} | not promised | | {} | | {least} | | |",
                    figure(choice.predicted_rmse)
                );
                continue;
            }
            plans += 1;
            let mut planned = scene.clone();
            choices.apply(&mut planned);
            let n = choices.supersample;
            let measured = verify_all(&scene, &[draw(&planned, n)?], SAMPLES)?[0].rmse;
            let price = choice.filter.map_or(0.0, |chosen| {
                let price = prices().iter().find(|p| (p.filter, p.precision) == chosen);
                price.map_or(f64::INFINITY, |p| p.ns) * f64::from(n * n)
            });
            let ratio = cheapest.map_or(0.0, |i| price / prices()[i].ns);
            let of_all = price / all.ns;
            let less_would_do = cheapest.is_some_and(|i| prices()[i].ns < all.ns);
            faults +=
                usize::from(measured > rmse || ratio > LIMIT || less_would_do && of_all >= 1.0);
            let plan = choice
                .filter
                .map_or_else(|| "no look-up".to_owned(), |(f, p)| label(f, p));
            let plan = if n > 1 {
                format!("{n} x {n} samples of {plan}")
            } else {
                plan
            };
            println!(
                "| {name} | {rmse} | {plan} | {price:.2} | {} | {} | {least} | {ratio:.2} | {of_all:.2} |",
                figure(choice.predicted_rmse),
                figure(measured)
            );
        }
    }
    println!(
        "\n{plans} plans, {faults} of them over the budget, above {LIMIT} times the cheapest, or no cheaper than all features where less would do."
    );
    Ok(ExitCode::from(u8::from(faults > 0)))
}

/// The tilted plane of the filtering panel as a scene: raw values, unlit.
fn plane(bytes: &[u8], turn: f64, magnify: f64) -> Result<Scene, Box<dyn Error>> {
    let side = TEXELS as u32;
    let rgba = bytes.iter().flat_map(|&b| [b, b, b, 255]).collect();
    let texture = Texture2d::from_rgba8(side, side, rgba, ColorSpace::Linear, Origin::TopLeft)?;
    let (sin, cos) = texmap_math::deterministic_f64::sin_cos(f64::to_radians(turn));
    let corners = [[-10.0, -2.5], [10.0, -2.5], [10.0, 20.0], [-10.0, 20.0]];
    let uv = |[x, y]: [f64; 2]| {
        [x * cos - y * sin, x * sin + y * cos].map(|c| (c / (4.0 * magnify)) as f32)
    };
    let material = Material {
        phong: PhongMaterial {
            color: [1.0; 3],
            ..PhongMaterial::default()
        },
        base_color: Some(TextureSlot {
            sampler: Sampler::default(),
            ..TextureSlot::new(0)
        }),
        shading: Shading::Unlit,
        ..Material::default()
    };
    Ok(Scene {
        background: [0.0; 4],
        color: ColorMode::Raw,
        textures: vec![texture],
        materials: vec![material],
        meshes: vec![Mesh {
            positions: corners.map(|[x, y]| [x as f32, y as f32, 0.0]).to_vec(),
            uvs: corners.map(uv).to_vec(),
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            ..Mesh::default()
        }],
        ..Scene::new(Camera {
            eye: DVec3::new(0.0, -3.0, 1.0),
            look: DVec3::new(0.3, 0.0, 0.35),
            up: DVec3::Z,
            fov_x: 60f64.to_radians(),
            near: 1e-3,
            far: f64::INFINITY,
        })
    })
}

fn label(filter: Filter, precision: Precision) -> String {
    let name = texmap_io::scene_file::words::filter(filter);
    let name = name.unwrap_or_else(|| format!("{filter:?}"));
    match precision {
        Precision::Exact => name,
        Precision::Fast => format!("{name}, fast"),
    }
}

fn figure(x: f64) -> String {
    format!("{x:.4}")
}

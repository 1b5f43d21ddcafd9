//! "Reflection is about the object's centroid", and its cure: mirrored rays led to the walls of a box.

use texmap_light::{Environment, EnvironmentLayout, Ray, ReflectionBox};
use texmap_math::deterministic_f64;
use texmap_math::glam::DVec3;
use texmap_scene::{Reflection, Scene};

use super::environments::{HALF, room, seen, wall};
use super::lit::{Lit, ball, difference, matte};
use super::sheet::sheet;
use super::{DemoPicture, stage};
use crate::LabError;
use texmap_truth::picture::Picture;
use texmap_truth::rays::RayScene;

/// Part of the way from the centre of the room to a wall at which the mirror stands.
const PART: f64 = 0.3;
const RADIUS: f64 = 0.8;

/// Colours that change evenly along each wall: bilinear look-ups in a cube around the centre are exact.
fn even(p: DVec3) -> [f32; 3] {
    (DVec3::splat(0.5) + p * (0.4 / HALF))
        .to_array()
        .map(|c| c as f32)
}

fn walls() -> ReflectionBox {
    let half = HALF as f32;
    ReflectionBox {
        low: [-half; 3],
        high: [half; 3],
        center: [0.0; 3],
    }
}

/// A mirror away from the centre, at which the environment was captured.
fn mirror(environment: Environment, within: Option<ReflectionBox>) -> Scene {
    let center = DVec3::X * (PART * HALF);
    let mut scene = stage::scene(center + DVec3::new(0.5, 0.7, 2.9), center, 40.0);
    let mut mirror = matte([0.0; 3], 0.0);
    mirror.reflection = Some(Reflection {
        environment: 0,
        reflectivity: 1.0,
        within,
    });
    let mirror = stage::add(&mut scene, mirror);
    scene.effects.environments.push(environment);
    scene.meshes.push(ball(center, RADIUS, mirror));
    scene
}

/// The same pixels by mirror rays.
fn traced(scene: &Scene, room: &RayScene, shot: &Lit, color: fn(DVec3) -> [f32; 3]) -> Picture {
    shot.painted(|i, p| {
        let view = (scene.camera.eye - p).normalize();
        let mirrored = texmap_math::reflection::reflect(view, shot.normal[i]);
        Some(seen(room, p, mirrored).map_or([0.0; 3], color))
    })
}

/// Largest difference to the mirror rays on pixels of the ball.
fn worst(shot: &Lit, traced: &Picture) -> f64 {
    let on_ball = (0..shot.position.len()).filter(|i| shot.position[*i].is_finite());
    let largest = on_ball.map(|i| difference(&shot.picture, traced, i)).max();
    f64::from(largest.unwrap_or(255))
}

pub(super) fn parallax(size: u32) -> Result<DemoPicture, LabError> {
    let room = room();
    let failed = |e: texmap_light::LightError| LabError::Cases(e.to_string());
    let captured = |color: fn(DVec3) -> [f32; 3], texels| {
        let light = |d: DVec3| seen(&room, DVec3::ZERO, d).map_or([0.0; 3], color);
        Environment::from_fn(EnvironmentLayout::Cube, texels, light).map_err(failed)
    };
    let tiles = captured(wall, 512)?;
    let scenes = [None, Some(walls())].map(|within| mirror(tiles.clone(), within));
    let [far, led] = [Lit::take(&scenes[0], size)?, Lit::take(&scenes[1], size)?];
    let truth = traced(&scenes[0], &room, &far, wall);
    let smooth = captured(even, 256)?;
    let even_error = |within| {
        let scene = mirror(smooth.clone(), within);
        let shot = Lit::take(&scene, size)?;
        Ok::<_, LabError>(worst(&shot, &traced(&scene, &room, &shot, even)))
    };
    // Two roundings, and half a texel of the bend where two walls meet: half of 10 / 256 units of colours that change by .08 a unit, whose
    // codes rise 1.7 times as fast as light of .1 does.
    let bound = 1.0 + 0.5 * (2.0 * HALF / 256.0) * (0.4 / HALF) * 1.7 * 255.0;
    let without = even_error(None)?;
    let claims = claims! {
        "led to the walls: largest difference to mirror rays where colours are even, /255" =>
            even_error(Some(walls()))?, 0.0, bound;
        "infinitely far: the same, at least, /255" => without.min(20.0), 20.0, 0.0;
        // A wall beside the way sees the way from the centre to the mirror under 2 atan(part / 2), where it sees it best.
        "infinitely far: largest error of the direction, degrees" =>
            worst_angle(&room, None), 2.0 * deterministic_f64::atan2(0.5 * PART, 1.0).to_degrees(), 0.05;
        "led to the walls: the same" => worst_angle(&room, Some(walls())), 0.0, 1e-3;
    };
    let panels = panels! {
        truth => "Mirror rays", "Each ray starts where it is mirrored.";
        far.picture => "Environment, infinitely far",
            format!("The mirror stands {PART} of the way to a wall, and shows the room from its centre.");
        led.picture => "Environment, led to the walls", "Each ray is led to the wall of a box that it meets.";
    };
    Ok(sheet(
        "Reflection is about the centroid: the cure for rooms that are boxes",
        panels,
        claims,
    ))
}

/// Largest angle between the direction that is looked up and that of the point which a mirror at [`PART`] of the way sees.
fn worst_angle(room: &RayScene, within: Option<ReflectionBox>) -> f64 {
    let place = DVec3::X * (PART * HALF);
    let narrow = |v: DVec3| Ray {
        direction: v.to_array().map(|c| c as f32),
        ..Ray::default()
    };
    let mut worst = 0.0f64;
    for i in 0..20_000 {
        let z = (f64::from(i) + 0.5) / 10_000.0 - 1.0;
        let (sin, cos) = deterministic_f64::sin_cos(f64::from(i) * 2.399_963);
        let r = (1.0 - z * z).sqrt();
        let d = DVec3::new(r * cos, r * sin, z);
        let asked = match &within {
            Some(walls) => {
                let led = walls.led(texmap_math::simd::Scalar, &narrow(place), &narrow(d));
                DVec3::from(led.direction.map(f64::from))
            }
            None => d,
        };
        if let Some(hit) = seen(room, place, d) {
            let angle = deterministic_f64::atan2(asked.cross(hit).length(), asked.dot(hit));
            worst = worst.max(angle.to_degrees());
        }
    }
    worst
}

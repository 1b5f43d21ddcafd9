//! "Which one is ray-traced?": a mirror under an environment map against mirror rays, and the seam of a clamped cube.

use texmap_light::{Environment, EnvironmentLayout};
use texmap_math::deterministic_f64;
use texmap_math::glam::{DMat4, DVec2, DVec3};
use texmap_scene::{Reflection, Scene};
use texmap_uv::Shape;

use super::lit::{Lit, ball, difference, matte};
use super::sheet::sheet;
use super::{Claim, DemoPicture, stage};
use crate::LabError;
use texmap_truth::picture::Picture;
use texmap_truth::rays::{RayObject, RayScene};

/// Half the side of the room.
pub(super) const HALF: f64 = 5.0;

/// Colour of a point on the room's walls, linear: tiles of two tints, another pair on each wall.
pub(super) fn wall(p: DVec3) -> [f32; 3] {
    let a = p.abs();
    let tile = |x: f64, y: f64| ((x * 0.8).floor() as i64 + (y * 0.8).floor() as i64) & 1 == 0;
    let (light, dark, even) = if a.y >= a.x && a.y >= a.z {
        if p.y > 0.0 {
            ([0.75, 0.8, 0.85], [0.6, 0.68, 0.75], tile(p.x, p.z))
        } else {
            ([0.5, 0.4, 0.3], [0.3, 0.22, 0.15], tile(p.x, p.z))
        }
    } else if a.x >= a.z {
        if p.x > 0.0 {
            ([0.7, 0.25, 0.2], [0.4, 0.1, 0.1], tile(p.z, p.y))
        } else {
            ([0.2, 0.5, 0.25], [0.1, 0.3, 0.15], tile(p.z, p.y))
        }
    } else if p.z > 0.0 {
        ([0.8, 0.7, 0.3], [0.5, 0.4, 0.15], tile(p.x, p.y))
    } else {
        ([0.25, 0.35, 0.7], [0.12, 0.18, 0.4], tile(p.x, p.y))
    };
    if even { light } else { dark }
}

/// The room as a ray scene.
pub(super) fn room() -> RayScene {
    let world = DMat4::from_scale(DVec3::splat(2.0 * HALF));
    RayScene::new([RayObject::Solid(Shape::Box, world)])
}

pub(super) fn seen(room: &RayScene, origin: DVec3, direction: DVec3) -> Option<DVec3> {
    let hit = room.nearest(origin, direction, (1e-9, f64::INFINITY))?;
    Some(hit.point)
}

fn scene(environment: Environment, radius: f64) -> Scene {
    let mut scene = stage::scene(DVec3::new(0.6, 0.8, 3.6), DVec3::ZERO, 40.0);
    let mut mirror = matte([0.0; 3], 0.0);
    mirror.reflection = Some(Reflection {
        environment: 0,
        reflectivity: 1.0,
        within: None,
    });
    let mirror = stage::add(&mut scene, mirror);
    scene.effects.environments.push(environment);
    scene.meshes.push(ball(DVec3::ZERO, radius, mirror));
    scene
}

pub(super) fn environments(size: u32) -> Result<DemoPicture, LabError> {
    let room = room();
    let light = |d: DVec3| seen(&room, DVec3::ZERO, d).map_or([0.0; 3], wall);
    let failed = |e: texmap_light::LightError| LabError::Cases(e.to_string());
    let environment =
        Environment::from_fn(EnvironmentLayout::TanCube, 512, light).map_err(failed)?;
    let mut panels = Vec::new();
    let mut claims = Vec::new();
    for (radius, name, expected, tolerance) in
        [(1.0, "large", 56.0, 8.0), (0.25, "small", 17.5, 6.0)]
    {
        let mut scene = scene(environment.clone(), radius);
        // The small ball fills the picture as the large one does.
        scene.camera.eye *= radius;
        let mapped = Lit::take(&scene, size)?;
        let traced = traced(&scene, &room, radius, &mapped);
        let count = mapped
            .position
            .iter()
            .filter(|p| p.is_finite())
            .count()
            .max(1);
        let differ = (0..mapped.position.len())
            .filter(|&i| {
                mapped.position[i].is_finite() && difference(&mapped.picture, &traced, i) > 16
            })
            .count();
        let share = 100.0 * differ as f64 / count as f64;
        claims.push(Claim::new(
            format!("{name} ball: % of its pixels more than 16 / 255 off the ray-traced ones"),
            share,
            expected,
            tolerance,
        ));
        panels.extend(panels![
            traced => format!("Mirror rays, {name} ball"), "Each ray starts where it is mirrored.";
            mapped.picture =>
                format!("Environment map, {name} ball"),
                format!("All rays start at the centre; radius {radius} in a room of half side 5.");
        ]);
    }
    for (part, degrees) in [(0.01, 0.6), (0.1, 5.7), (0.3, 17.4)] {
        claims.push(Claim::new(
            format!("largest error of the direction, degrees, {part} of the room's half side from the centre"),
            worst_angle(&room, part),
            degrees,
            0.06 * degrees + 0.05,
        ));
    }
    let small = Environment::from_fn(EnvironmentLayout::Cube, 8, light).map_err(failed)?;
    let seamless = Lit::take(&scene(small.clone(), 1.0), size)?;
    let clamped = clamp_picture(&scene(small.clone(), 1.0), &small, &seamless);
    let unlike = (0..seamless.position.len())
        .filter(|&i| difference(&seamless.picture, &clamped, i) > 8)
        .count();
    claims.push(Claim::new(
        "pixels that the seam of clamped faces spoils, % of the picture",
        100.0 * unlike as f64 / f64::from(size * size),
        5.2,
        1.5,
    ));
    let torn = |picture: &Picture| f64::from(seams(&scene(small.clone(), 1.0), &seamless, picture));
    claims.extend(claims![
        "neighbouring pixels that mirror two faces and are more than 48 / 255 apart, clamped" =>
            torn(&clamped), f64::from(size), 0.3 * f64::from(size);
        "the same where texels past the edge continue the neighbour" => torn(&seamless.picture), 0.0, 0.0;
    ]);
    panels.extend(panels![
        clamped => "8 x 8 cube, clamped (wrong)", "Each face ends at its edge: the seams show.";
        seamless.picture => "8 x 8 cube, seamless", "Texels past the edge continue the neighbour.";
    ]);
    Ok(sheet(
        "Environment maps: which one is ray-traced?",
        panels,
        claims,
    ))
}

/// The ball by mirror rays, under the mapped picture's own pixels.
fn traced(scene: &Scene, room: &RayScene, radius: f64, mapped: &Lit) -> Picture {
    mapped.painted(|_, p| {
        let n = p.normalize();
        let view = (scene.camera.eye - p).normalize();
        let mirrored = texmap_math::reflection::reflect(view, n);
        Some(seen(room, n * radius, mirrored).map_or([0.0; 3], wall))
    })
}

/// Largest angle between the true direction from the centre to what a mirror at `part` of the half side sees, and the one looked up.
fn worst_angle(room: &RayScene, part: f64) -> f64 {
    let mut worst = 0.0f64;
    let p = DVec3::X * (part * HALF);
    for i in 0..20_000 {
        let z = (f64::from(i) + 0.5) / 10_000.0 - 1.0;
        let (sin, cos) = deterministic_f64::sin_cos(f64::from(i) * 2.399_963);
        let r = (1.0 - z * z).sqrt();
        let d = DVec3::new(r * cos, r * sin, z);
        if let Some(hit) = seen(room, p, d) {
            worst =
                worst.max(deterministic_f64::atan2(d.cross(hit).length(), d.dot(hit)).to_degrees());
        }
    }
    worst
}

/// Pairs of neighbouring pixels in a row that mirror two faces of the cube and differ. Not at the rim, where a pixel mirrors much.
fn seams(scene: &Scene, shot: &Lit, picture: &Picture) -> u32 {
    let face = |p: DVec3| {
        let (n, view) = (p.normalize(), (scene.camera.eye - p).normalize());
        let d = texmap_math::reflection::reflect(view, n);
        (p.is_finite() && n.dot(view) > 0.7).then(|| EnvironmentLayout::Cube.locate(d).0)
    };
    let width = picture.width() as usize;
    let code = |i: usize| [0, 1, 2].map(|k| picture.rgba()[4 * i + k]);
    let mut count = 0;
    for i in (0..shot.position.len()).filter(|i| (i + 1) % width != 0) {
        let faces = (face(shot.position[i]), face(shot.position[i + 1]));
        if let (Some(a), Some(b)) = faces {
            let (here, next) = (code(i), code(i + 1));
            let apart = (0..3).any(|k| here[k].abs_diff(next[k]) > 48);
            count += u32::from(a != b && apart);
        }
    }
    count
}

/// The mirror with each face of its cube clamped.
fn clamp_picture(scene: &Scene, cube: &Environment, shot: &Lit) -> Picture {
    let n = f64::from(cube.size().0);
    shot.painted(|_, p| {
        let view = (scene.camera.eye - p).normalize();
        let d = texmap_math::reflection::reflect(view, p.normalize());
        let (face, uv) = EnvironmentLayout::Cube.locate(d);
        let at = (uv * n - 0.5).clamp(DVec2::ZERO, DVec2::splat(n - 1.0));
        let (low, f) = (at.floor(), at - at.floor());
        let texel = |i: f64, j: f64, k: usize| {
            let x = |c: f64| c.min(n - 1.0) as u32;
            cube.texel(face, x(low.x + i), x(low.y + j))
                .map_or(0.0, |c| f64::from(c[k]))
        };
        Some([0, 1, 2].map(|k| {
            let row = |j: f64| texel(0.0, j, k) * (1.0 - f.x) + texel(1.0, j, k) * f.x;
            (row(0.0) * (1.0 - f.y) + row(1.0) * f.y) as f32
        }))
    })
}

//! Displacement against bump mapping, both against the moved surface in f64: shading, outline and shadow.

use std::f64::consts::{PI, TAU};

use texmap_light::Light;
use texmap_math::color::linear_to_srgb8;
use texmap_math::deterministic_f64;
use texmap_math::glam::DVec3;
use texmap_sample::{Filter, Texture2d, Wrap};
use texmap_scene::{Displacement, EdgeBudget, Mesh, NormalDetail, Scene};

use super::DemoPicture;
use super::lit::{Lit, ball, difference, floor, grid, matte, wrong};
use super::sheet::sheet;
use super::stage;
use crate::LabError;
use crate::topology::open_edges;
use texmap_truth::picture::Picture;
use texmap_truth::rays::{RayObject, RayScene};

/// Texels of the height map.
const TEXELS: (u32, u32) = (1024, 512);
/// Displacement of white over black on the ball of radius 1.
const HEIGHT: f64 = 0.3;
const CENTRE: DVec3 = DVec3::new(0.0, 1.35, 0.0);

/// Waves that fade towards the poles, 0..=1.
fn height(u: f64, v: f64) -> f64 {
    let fade = deterministic_f64::sin(PI * v);
    0.5 + 0.5
        * fade
        * fade
        * deterministic_f64::sin(TAU * 10.0 * u)
        * deterministic_f64::sin(TAU * 5.0 * v)
}

/// The moved ball and its normal, from the formula.
fn surface(u: f64, v: f64) -> (DVec3, DVec3) {
    let at = |u: f64, v: f64| {
        let ((sin, cos), (out, up)) = (
            deterministic_f64::sin_cos(u * TAU),
            deterministic_f64::sin_cos(v * PI),
        );
        let radius = 1.0 + HEIGHT * (height(u, v) - 0.5);
        CENTRE + DVec3::new(out * cos, up, -out * sin) * radius
    };
    let h = 1e-5;
    let (du, dv) = (at(u + h, v) - at(u - h, v), at(u, v + h) - at(u, v - h));
    let normal = dv.cross(du);
    let from_centre = at(u, v) - CENTRE;
    // At the poles the surface is level.
    let poles = normal.length() < 1e-14;
    (
        at(u, v),
        if poles {
            from_centre.normalize()
        } else {
            normal.normalize()
        },
    )
}

fn map() -> Result<Texture2d<'static>, LabError> {
    let (width, rows) = TEXELS;
    let centre = |i: u32, n: u32| (f64::from(i) + 0.5) / f64::from(n);
    let values: Vec<f32> = (0..width * rows)
        .map(|i| height(centre(i % width, width), centre(i / width, rows)) as f32)
        .collect();
    Ok(crate::plane::floats(width, 1, &values)?.with_mips())
}

/// A ball over a floor under a low sun that casts shadows.
fn scene() -> Result<Scene, LabError> {
    let mut scene = stage::scene(DVec3::new(0.0, 2.4, 5.2), DVec3::new(0.1, 0.95, 0.0), 42.0);
    scene.lights = stage::daylight(0.12, [0.85; 3], [0.8, -0.75, -0.35]);
    scene.effects.shadows = vec![stage::shadow(1, 2048)];
    scene.textures.push(map()?);
    let stone = stage::add(&mut scene, matte([0.55, 0.48, 0.4], 0.0));
    let ground = stage::add(&mut scene, matte([0.5; 3], 0.0));
    let mut round = ball(CENTRE, 1.0, stone);
    // The seam and the poles meet to the last bit: only equal positions are one point.
    for c in round.positions.as_flattened_mut() {
        *c = if c.abs() < 1e-7 { 0.0 } else { *c };
    }
    scene.meshes = vec![round, floor(5.0, ground)];
    Ok(scene)
}

/// The f64 reference of each pixel: what its ray meets, and the colour under light and hard shadow.
struct Truth {
    picture: Picture,
    ball: Vec<Option<bool>>,
    /// True for lit pixels of the floor.
    lit: Vec<Option<bool>>,
}

fn truth(scene: &Scene, size: u32) -> Result<Truth, LabError> {
    let (around, down) = (640u32, 320u32);
    let mut fine = Mesh::default();
    for (i, j) in (0..=down).flat_map(|j| (0..=around).map(move |i| (i, j))) {
        let (p, n) = surface(
            f64::from(i) / f64::from(around),
            f64::from(j) / f64::from(down),
        );
        fine.positions.push(p.as_vec3().to_array());
        fine.normals.push(n.as_vec3().to_array());
    }
    fine.triangles = grid(around, down);
    let rays = RayScene::new([RayObject::Mesh(&fine), RayObject::Mesh(&scene.meshes[1])]);
    let sun = match scene.lights[1] {
        Light::Directional { direction, .. } => -DVec3::from(direction.map(f64::from)),
        _ => DVec3::Y,
    };
    let sky = scene.background.map(|c| (c * 255.0 + 0.5) as u8);
    let mut truth = Truth {
        picture: Picture::new(size, size, sky),
        ball: Vec::new(),
        lit: Vec::new(),
    };
    let eye = scene.camera.eye;
    for (x, y) in (0..size).flat_map(|y| (0..size).map(move |x| (x, y))) {
        let ray = scene
            .camera
            .ray(size, size, f64::from(x) + 0.5, f64::from(y) + 0.5);
        let ray = ray.map_err(texmap_scene::SceneError::Camera)?;
        let hit = rays.nearest(eye, ray, (0.0, f64::INFINITY));
        truth.ball.push(Some(hit.is_some_and(|h| h.object == 0)));
        let Some(hit) = hit else {
            truth.lit.push(None);
            continue;
        };
        let surface = scene.materials[hit.object].phong;
        let dark = rays.meets(hit.point + hit.normal * 1e-4, sun, (1e-6, f64::INFINITY));
        truth.lit.push((hit.object == 1).then_some(!dark));
        let lights = if dark {
            &scene.lights[..1]
        } else {
            &scene.lights[..]
        };
        let color =
            texmap_light::reference::illuminate(&surface, lights, hit.point, hit.normal, eye);
        let [r, g, b] = color.as_vec3().to_array().map(linear_to_srgb8);
        truth
            .picture
            .set(i64::from(x), i64::from(y), [r, g, b, 255]);
    }
    Ok(truth)
}

/// Errors of a rendered picture.
struct Faults {
    outline: f64,
    shadow: f64,
    shading: f64,
}

fn faults(shot: &Lit, truth: &Truth, size: u32) -> Faults {
    let on_ball = |p: &DVec3| p.is_finite() && (*p - CENTRE).length() < 1.3;
    let ball: Vec<bool> = shot.position.iter().map(on_ball).collect();
    let lit: Vec<bool> = (0..ball.len())
        .map(|i| f64::from(shot.picture.rgba()[4 * i + 1]) > 140.0)
        .collect();
    let both: Vec<usize> = (0..ball.len())
        .filter(|&i| ball[i] && truth.ball[i] == Some(true))
        .collect();
    let off = both
        .iter()
        .filter(|&&i| difference(&shot.picture, &truth.picture, i) > 24)
        .count();
    Faults {
        outline: f64::from(wrong(&truth.ball, &ball, size, 1)),
        shadow: f64::from(wrong(&truth.lit, &lit, size, 1)),
        shading: 100.0 * off as f64 / both.len().max(1) as f64,
    }
}

pub(super) fn displacement(size: u32) -> Result<DemoPicture, LabError> {
    let mut scene = scene()?;
    let truth = truth(&scene, size)?;
    let flat = Lit::take(&scene, size)?;
    let mut shot = |budget: Option<EdgeBudget>| -> Result<(Lit, Mesh), LabError> {
        scene.materials[0].normal_detail = None;
        scene.meshes[0].displacement = None;
        match budget {
            None => {
                scene.materials[0].normal_detail = Some(NormalDetail::Bump {
                    slot: stage::slot(0, Filter::Trilinear, Wrap::Repeat),
                    height: HEIGHT as f32,
                });
            }
            Some(budget) => {
                scene.meshes[0].displacement = Some(Displacement {
                    middle: 0.5,
                    budget,
                    ..Displacement::new(
                        stage::slot(0, Filter::Trilinear, Wrap::Repeat),
                        HEIGHT as f32,
                    )
                });
            }
        }
        let shaped = texmap_mesh::tessellate(&scene, size)?.into_owned();
        Ok((Lit::take(&shaped, size)?, shaped.meshes[0].clone()))
    };
    let (bumped, _) = shot(None)?;
    let (coarse, coarse_ball) = shot(Some(EdgeBudget::Pixels(24.0)))?;
    let (fine, fine_ball) = shot(Some(EdgeBudget::Pixels(2.0)))?;
    let open = open_edges([&coarse_ball]) + open_edges([&fine_ball]);
    let pixels = truth.ball.iter().filter(|b| **b == Some(true)).count() as f64;
    let dark = truth.lit.iter().filter(|lit| **lit == Some(false)).count() as f64;
    let [flat_faults, bump, rough, fine_faults] =
        [&flat, &bumped, &coarse, &fine].map(|shot| faults(shot, &truth, size));
    let share = |count: f64, of: f64| 100.0 * count / of.max(1.0);
    let claims = claims![
        "wrong pixels of the outline, displaced to 2 pixels" => fine_faults.outline, 0.0, 0.0;
        "of the outline under the bump map, % of the ball" => share(bump.outline, pixels), 5.5, 2.0;
        "wrong pixels of the shadow, displaced to 2 pixels, % of it" =>
            share(fine_faults.shadow, dark), 0.0, 1.0;
        "of the shadow under the bump map, % of it" => share(bump.shadow, dark), 4.5, 3.5;
        "shading off by more than 24/255, displaced to 2 pixels, % of the ball" =>
            fine_faults.shading, 0.0, 2.0;
        "the same under the bump map" => bump.shading, 14.0, 6.0;
        "the same without either" => flat_faults.shading, 52.0, 12.0;
        "edges that are not shared by two triangles" => open as f64, 0.0, 0.0;
    ];
    let count = |mesh: &Mesh| mesh.triangles.len();
    let panels = panels![
        bumped.picture => "Bump map", "Light follows the waves; outline and shadow are a ball's.";
        coarse.picture =>
            "Displaced, 24 pixels",
            format!("{} triangles; {} outline pixels are wrong.", count(&coarse_ball), rough.outline);
        fine.picture =>
            "Displaced, 2 pixels",
            format!("{} triangles; outline and shadow are the surface's.", count(&fine_ball));
        truth.picture => "Truth", "The waves' own formula by ray tracing in f64.";
    ];
    Ok(sheet("Displacement and bump mapping", panels, claims))
}

//! A flat mirror on a checkered floor: the scene drawn from behind it and laid over it (projected reflection), against mirror rays.

use texmap_bake::{PlanarMirror, capture_environment_at, with_planar_mirrors};
use texmap_light::PhongMaterial;
use texmap_math::color::{linear_to_srgb, srgb_to_linear};
use texmap_math::glam::{DMat4, DVec3};
use texmap_raster::Interp;
use texmap_sample::Filter;
use texmap_scene::{Material, Mesh, Reflection, Scene, Shading};
use texmap_truth::frame_by_rays;
use texmap_truth::picture::Picture;

use super::sheet::sheet;
use super::{DemoPicture, paint, stage};
use crate::LabError;

/// Share of mirrored light.
const SHARE: f32 = 0.6;

/// Mesh of the floor.
const FLOOR: usize = 0;

/// A checkered floor under two cubes and before a wall, each of one colour.
fn scene() -> Result<Scene, LabError> {
    let mut scene = stage::scene(DVec3::new(2.6, 2.3, 5.0), DVec3::new(0.0, 0.2, 0.0), 44.0);
    let checker = paint::checker(256, 8, [70, 70, 80, 255], [235, 230, 220, 255]);
    let checker = stage::texture(&mut scene, &checker)?;
    let floor = stage::decal(&mut scene, checker, Filter::Trilinear, Interp::Perspective);
    let corners = [(-3.0, -3.0), (3.0, -3.0), (3.0, 3.0), (-3.0, 3.0)];
    let corners = corners.map(|(x, z)| DVec3::new(x, 0.0, z));
    scene
        .meshes
        .push(stage::quad(corners, stage::UNIT_UV, floor));
    let mut plain = |color| {
        let phong = PhongMaterial {
            color,
            ..PhongMaterial::default()
        };
        let shading = Shading::Unlit;
        stage::add(
            &mut scene,
            Material {
                phong,
                shading,
                ..Material::default()
            },
        )
    };
    let (red, blue, wall) = (
        plain([0.6, 0.07, 0.05]),
        plain([0.04, 0.12, 0.5]),
        plain([0.25, 0.45, 0.2]),
    );
    // A cube hangs over the floor, one goes through it: the mirror cuts it.
    let cubes = [
        stage::cube(DVec3::new(-0.9, 1.1, -0.6), 30.0, red),
        stage::cube(DVec3::new(1.0, 0.3, 0.2), -15.0, blue),
    ];
    let cubes = cubes.map(|cube| Mesh {
        world_from_object: cube.world_from_object * DMat4::from_scale(DVec3::splat(0.55)),
        ..cube
    });
    scene.meshes.extend(cubes);
    let (low, high) = (0.0, 2.6);
    let corners = [(-3.0, high), (3.0, high), (3.0, low), (-3.0, low)];
    let corners = corners.map(|(x, y)| DVec3::new(x, y, -3.0));
    scene
        .meshes
        .push(stage::quad(corners, stage::UNIT_UV, wall));
    Ok(scene)
}

pub(super) fn planar_mirror(size: u32) -> Result<DemoPicture, LabError> {
    let failed = |e: texmap_render::RenderError| LabError::Cases(e.to_string());
    let scene = scene()?;
    let mirror = |share| PlanarMirror { mesh: FLOOR, share };
    let drawn = |scene: &Scene| stage::picture(scene, size, 1);
    let mirrored = |share| with_planar_mirrors(&scene, &[mirror(share)], (size, size));
    let (own, shown) = (drawn(&scene)?, drawn(&mirrored(SHARE).map_err(failed)?)?);

    // The same floor as a mirror of an environment around its middle, looked up and traced.
    let middle = DVec3::Y * 1e-3;
    let mut around = scene.clone();
    let environment = capture_environment_at(&scene, middle, &[FLOOR], 512).map_err(failed)?;
    around.effects.environments.push(environment);
    around.materials.push(Material {
        phong: PhongMaterial {
            color: [0.0; 3],
            ..PhongMaterial::default()
        },
        reflection: Some(Reflection {
            environment: 0,
            reflectivity: 1.0,
            within: None,
        }),
        ..Material::default()
    });
    around.meshes[FLOOR].material = around.materials.len() - 1;
    let mapped = drawn(&around)?;
    let mapped: Vec<f64> = mapped.rgba().iter().copied().map(f64::from).collect();
    let truth =
        frame_by_rays(&around, size, size, 1).map_err(|e| LabError::Cases(e.to_string()))?;
    let traced = truth.codes();
    let floor: Vec<usize> = (0..truth.seen.len())
        .filter(|i| truth.seen[*i].is_some_and(|(mesh, _)| mesh == FLOOR))
        .collect();

    let by_rays = mixed(&own, &traced, &floor);
    let by_map = mixed(&own, &mapped, &floor);
    let off = |picture: &Picture, i: usize| {
        let codes = |k: usize| f64::from(picture.rgba()[4 * i + k]);
        (0..3)
            .map(|k| (codes(k) - by_rays[4 * i + k]).abs())
            .fold(0.0, f64::max)
    };
    let by_map = rounded(&by_map, size);
    // A pixel at an outline may show either side of it.
    let width = size as usize;
    let even = |i: &&usize| {
        let (x, y) = (*i % width, *i / width);
        let around = |n: usize| n.saturating_sub(1)..(n + 2).min(width);
        let near = around(y).flat_map(|y| around(x).map(move |x| y * width + x));
        near.clone().all(|j| floor.binary_search(&j).is_ok())
            && (0..3).all(|k| {
                let all = near.clone().map(|j| traced[4 * j + k]);
                let low = all.clone().fold(f64::INFINITY, f64::min);
                all.fold(0.0, f64::max) - low <= 4.0
            })
    };
    let worst = floor.iter().filter(even).map(|i| off(&shown, *i));
    let worst = worst.fold(0.0, f64::max);
    let far = floor.iter().filter(|i| off(&by_map, **i) > 16.0).count();
    let far = 100.0 * far as f64 / floor.len().max(1) as f64;
    let judged = floor.iter().filter(even).count() as f64 / floor.len().max(1) as f64;
    let claims = claims! {
        // The surface's own colour, the mirrored one and the picture are each rounded to a code, where codes of dark colours
        // are as far apart in light as those of lighter ones.
        "planar mirror: largest difference to mirror rays on the floor, outside of outlines, /255" => worst, 0.0, 2.0;
        "part of the floor that this judges, at least" => judged.min(0.8), 0.8, 0.0;
        "environment around the floor's middle: % of the floor that is more than 16 / 255 off, at least" => far.min(10.0), 10.0, 0.0;
    };
    let panels = panels! {
        own => "Without a mirror", "A checkered floor, a cube over it and one that goes through it.";
        rounded(&by_rays, size) => "Mirror rays", format!("{SHARE} of what each ray meets, the rest the floor's own.");
        shown => "Planar mirror", "The scene from behind the floor, cut at its plane, laid over it by the pixels.";
        by_map => "Environment of the floor's middle", "Right for what is far away: here the cubes stand off their feet.";
    };
    Ok(sheet(
        "A planar mirror: projected reflection",
        panels,
        claims,
    ))
}

/// The codes of a picture with a share of other codes in some of its pixels, mixed as light.
fn mixed(own: &Picture, mirrored: &[f64], pixels: &[usize]) -> Vec<f64> {
    let mut out: Vec<f64> = own.rgba().iter().copied().map(f64::from).collect();
    let light = |code: f64| srgb_to_linear((code / 255.0) as f32);
    for at in pixels.iter().flat_map(|i| 4 * i..4 * i + 3) {
        let light = light(out[at]) * (1.0 - SHARE) + light(mirrored[at]) * SHARE;
        out[at] = f64::from(linear_to_srgb(light)) * 255.0;
    }
    out
}

fn rounded(codes: &[f64], size: u32) -> Picture {
    Picture::from_fn(size, size, |x, y| {
        let at = 4 * (y * size + x) as usize;
        [0, 1, 2, 3].map(|k| codes[at + k].round() as u8)
    })
}

//! Projectors and shadows: points that a light must not reach, and points that a shadow map must not darken.

use texmap_light::{Light, ProjectorBorder, ShadowBias};
use texmap_math::Projector;
use texmap_math::glam::DVec3;
use texmap_render::shadow_map;
use texmap_sample::{Filter, Wrap};
use texmap_scene::{ProjectorLight, ProjectorMode, Scene, Shadow, shadow_kind};

use super::lit::{Lit, ball, floor, matte, wrong};
use super::sheet::sheet;
use super::stage::{self, texture};
use super::{DemoPicture, paint};
use crate::LabError;
use texmap_truth::picture::Picture;
use texmap_truth::rays::{RayObject, RayScene};

/// A ball and a small ball on a floor.
fn table() -> Scene {
    let mut scene = stage::scene(DVec3::new(2.2, 2.4, 4.2), DVec3::new(0.0, 0.4, 0.0), 42.0);
    scene.lights.push(Light::Ambient { color: [0.12; 3] });
    let ground = stage::add(&mut scene, matte([0.6, 0.58, 0.55], 0.0));
    let red = stage::add(&mut scene, matte([0.75, 0.3, 0.2], 0.0));
    scene.meshes = vec![
        floor(4.0, ground),
        ball(DVec3::new(0.0, 0.7, 0.0), 0.7, red),
        ball(DVec3::new(-1.3, 0.35, 0.9), 0.35, red),
    ];
    scene
}

fn rays(scene: &Scene) -> RayScene {
    RayScene::new(scene.meshes.iter().map(RayObject::Mesh))
}

pub(super) fn slides(size: u32) -> Result<DemoPicture, LabError> {
    let mut scene = table();
    let index = texture(&mut scene, &paint::cow_photo(256))?;
    let position = DVec3::new(-2.6, 1.9, 2.8);
    let projector = Projector::new(position, DVec3::new(0.1, 0.35, -0.2), DVec3::Y, 0.62, 1.0)?;
    let light = |shadow, border| ProjectorLight {
        projector,
        position,
        texture: index,
        sampler: stage::sampler(Filter::Trilinear, Wrap::Repeat),
        border,
        softness: 0.0,
        mode: ProjectorMode::Light([1.0; 3]),
        shadow,
    };
    let mut take = |lights: Vec<ProjectorLight>| {
        scene.effects.projectors = lights;
        Lit::take(&scene, size)
    };
    let off = take(vec![])?;
    let on = take(vec![light(Some(1024), ProjectorBorder::Black)])?;
    let through = take(vec![light(None, ProjectorBorder::Black)])?;
    let repeated = take(vec![light(Some(1024), ProjectorBorder::Repeat)])?;
    let painted = take(vec![ProjectorLight {
        mode: ProjectorMode::Decal,
        ..light(Some(1024), ProjectorBorder::Black)
    }])?;
    // Truth by rays: the picture holds the point, and nothing stands between the point and the projector.
    let rays = rays(&table());
    let truth = off.facing(
        0.1,
        |p| position - p,
        |p, n| {
            let inside = projector
                .uv(p)
                .is_some_and(|uv| uv.min_element() >= 0.0 && uv.max_element() <= 1.0);
            inside && !rays.blocked(p + n * 1e-4, position)
        },
    );
    let reach = i64::from(size / 100);
    let count = |shot: &Lit| f64::from(wrong(&truth, &shot.changed(&off, 1), size, reach));
    let pixels = f64::from(size * size);
    let claims = claims![
        "wrong pixels, with a depth map and a black border" => count(&on), 0.0, 2e-4 * pixels;
        "wrong without the depth map, % of the picture" => 100.0 * count(&through) / pixels, 7.8, 1.5;
        "wrong where the slide repeats, % of the picture" => 100.0 * count(&repeated) / pixels, 27.0, 4.0;
    ];
    let panels = panels![
        off.picture => "Off", "Ambient light alone.";
        on.picture => "A slide as light", "Nothing behind what it meets is lit, nothing beyond its edge.";
        painted.picture => "A slide as paint", "The surface takes the colours, whatever the light.";
        through.picture => "No depth map (wrong)", "It shines through the balls.";
        repeated.picture => "Repeated (wrong for a lamp)", "A texture's wrap mode tiles the floor.";
    ];
    Ok(sheet("Slide projectors: light and paint", panels, claims))
}

pub(super) fn shadows(size: u32) -> Result<DemoPicture, LabError> {
    let mut scene = table();
    let direction = [0.8, -0.42, -0.45];
    scene.lights.push(Light::Directional {
        color: [0.9, 0.88, 0.8],
        direction,
    });
    let shadow = |bias, pcf_size| Shadow {
        light: 1,
        size: Some(512),
        bias,
        pcf_size,
        area: None,
    };
    let mut take = |shadows: Vec<Shadow>| {
        scene.effects.shadows = shadows;
        Lit::take(&scene, size)
    };
    let off = take(vec![])?;
    let none = take(vec![shadow(Some(ShadowBias::Constant(0.0)), 1)])?;
    let large = take(vec![shadow(Some(ShadowBias::Constant(0.8)), 1)])?;
    let slope = take(vec![shadow(None, 1)])?;
    let soft = take(vec![shadow(None, 5)])?;
    let toward = -DVec3::from(direction.map(f64::from));
    let scene = table();
    let rays = rays(&scene);
    let truth = off.facing(
        0.1,
        |_| toward,
        |p, n| rays.meets(p + n * 2e-3, toward, (0.0, f64::INFINITY)),
    );
    let count = |shot: &Lit| {
        f64::from(wrong(
            &truth,
            &shot.changed(&off, 4),
            size,
            i64::from(size / 80),
        ))
    };
    let pixels = f64::from(size * size);
    let claims = claims![
        "wrong pixels under the default bias" => count(&slope), 0.0, 3e-4 * pixels;
        "wrong without a bias, % of the picture" => 100.0 * count(&none) / pixels, 23.0, 5.0;
        "wrong under a constant of 0.8, % of the picture" => 100.0 * count(&large) / pixels, 0.18, 0.12;
    ];
    let depth = depth_picture(&scene_with(scene, direction), size)?;
    let panels = panels![
        off.picture => "Off", "Light goes through everything.";
        none.picture => "No bias (wrong)", "Surfaces shadow themselves: acne.";
        large.picture => "A large constant (wrong)", "No acne, but shadows stand off their things.";
        slope.picture => "The default", "Neither: the planes of both surfaces.";
        soft.picture => "5 x 5 comparisons", "The mean of comparisons softens the edge.";
        depth => "The map", "Near the light is light, far dark; white is nothing.";
    ];
    Ok(sheet("Shadow maps: bias and filter", panels, claims))
}

fn scene_with(mut scene: Scene, direction: [f32; 3]) -> Scene {
    scene.lights = vec![Light::Directional {
        color: [1.0; 3],
        direction,
    }];
    scene
}

/// The lecture's picture of a depth map: near the light is light, far dark, background white.
fn depth_picture(scene: &Scene, size: u32) -> Result<Picture, LabError> {
    let kind = shadow_kind(scene, 0, None)?;
    let map = shadow_map(scene, &kind, size, 1)?;
    let depths: Vec<f32> = (0..size * size)
        .filter_map(|i| map.depth_at(0, i % size, i / size))
        .collect();
    let seen = || depths.iter().copied().filter(|d| d.is_finite());
    let (near, far) = (
        seen().fold(f32::MAX, f32::min),
        seen().fold(f32::MIN, f32::max),
    );
    Ok(Picture::from_fn(size, size, |x, y| {
        let d = depths[(y * size + x) as usize];
        let near_is_light = || (230.0 - 210.0 * (d - near) / (far - near)) as u8;
        let c = if d.is_finite() { near_is_light() } else { 255 };
        [c, c, c, 255]
    }))
}

//! Bump and normal maps against the surface that they stand for, and baked light against light.

use texmap_bake::{BakeOptions, LightMap, bake};
use texmap_light::{Heights, Light, NormalMapGreen, Slope, encode_normal};
use texmap_math::deterministic_f64;
use texmap_math::glam::DVec3;
use texmap_render::shadow_map_for;
use texmap_sample::{ColorSpace, Filter, Origin, Texture2d, Wrap};
use texmap_scene::{LightMapSlot, NormalDetail, Scene, shadow_bias, shadow_kind};

use super::lit::{Lit, ball, difference, floor, matte};
use super::sheet::sheet;
use super::{DemoPicture, procedural_bump, stage};
use crate::LabError;
use texmap_truth::picture::Picture;

/// Texels a side of the height field, and its periods.
const TEXELS: u32 = 512;
const PERIODS: f64 = 6.0;
/// Height of its waves on a floor of side 4.
const HEIGHT: f64 = 0.08;

/// Height of the waves, 0..=1.
fn height(u: f64, v: f64) -> f64 {
    let wave = |c: f64| deterministic_f64::sin(c * PERIODS * std::f64::consts::TAU);
    0.5 + 0.25 * (wave(u) + wave(v))
}

/// Heights of the waves, row by row.
fn wave_heights() -> Vec<f32> {
    let place = |i: u32| (f64::from(i) + 0.5) / f64::from(TEXELS);
    (0..TEXELS * TEXELS)
        .map(|i| height(place(i % TEXELS), place(i / TEXELS)) as f32)
        .collect()
}

/// A floor under a low light, with two textures: heights, and their normals in 8 bits with green up.
fn waves() -> Result<Scene, LabError> {
    let mut scene = stage::scene(DVec3::new(0.0, 2.6, 3.2), DVec3::ZERO, 50.0);
    scene.lights = stage::daylight(0.1, [0.9; 3], [1.0, -0.8, 0.6]);
    let values = wave_heights();
    scene
        .textures
        .push(crate::plane::floats(TEXELS, 1, &values)?.with_mips());
    let heights = Heights {
        width: TEXELS,
        values: &values,
    };
    // Heights in texels: the floor's side of 4 holds all of them.
    let strength = (HEIGHT / 4.0 * f64::from(TEXELS)) as f32;
    let normals = heights
        .normals(Slope::Central, strength, NormalMapGreen::Up)
        .map_err(|e| LabError::Cases(e.to_string()))?;
    // The normals' y already counts up the picture; the texel stores it so.
    let bytes: Vec<u8> = normals
        .iter()
        .flat_map(|n| {
            let [r, g, b] = encode_normal(*n, NormalMapGreen::Up).map(|c| (c * 255.0 + 0.5) as u8);
            [r, g, b, 255]
        })
        .collect();
    let normals =
        Texture2d::from_rgba8(TEXELS, TEXELS, bytes, ColorSpace::Linear, Origin::TopLeft)?;
    scene.textures.push(normals.with_normal_mips());
    let stone = stage::add(&mut scene, matte([0.55, 0.5, 0.45], 0.4));
    scene.meshes = vec![
        floor(2.0, stone),
        ball(DVec3::new(0.0, 0.5, -0.4), 0.5, stone),
    ];
    Ok(scene)
}

/// The floor in f64 with the exact normal of its waves, where the floor is seen.
fn truth(scene: &Scene, flat: &Lit) -> Picture {
    let surface = scene.materials[0].phong;
    flat.painted(|_, p| {
        let (u, v) = (0.5 + p.x / 4.0, 0.5 + p.z / 4.0);
        let slope = |c: f64| {
            let w = PERIODS * std::f64::consts::TAU;
            0.25 * w * deterministic_f64::cos(c * w) * HEIGHT / 4.0
        };
        let n = DVec3::new(-slope(u), 1.0, -slope(v)).normalize();
        let eye = scene.camera.eye;
        let lit = texmap_light::reference::illuminate(&surface, &scene.lights, p, n, eye);
        (p.y.abs() <= 1e-6).then(|| lit.as_vec3().to_array())
    })
}

pub(super) fn bumps(size: u32) -> Result<DemoPicture, LabError> {
    let mut scene = waves()?;
    let mut take = |detail: Option<NormalDetail>| {
        scene.materials[0].normal_detail = detail;
        Lit::take(&scene, size)
    };
    let normal_map = |green| {
        Some(NormalDetail::NormalMap {
            slot: stage::slot(1, Filter::Trilinear, Wrap::Repeat),
            green,
            rebuild_z: false,
            object_space: false,
            strength: 1.0,
        })
    };
    let flat = take(None)?;
    let bumped = take(Some(NormalDetail::Bump {
        slot: stage::slot(0, Filter::Trilinear, Wrap::Repeat),
        height: HEIGHT as f32,
    }))?;
    let mapped = take(normal_map(NormalMapGreen::Up))?;
    let flipped = take(normal_map(NormalMapGreen::Down))?;
    let truth = truth(&waves()?, &flat);
    let on_floor: Vec<usize> = (0..flat.position.len())
        .filter(|&i| flat.position[i].is_finite() && flat.position[i].y.abs() < 1e-6)
        .collect();
    let wrong = |shot: &Lit| {
        let off = |i: &&usize| difference(&shot.picture, &truth, **i) > 6;
        on_floor.iter().filter(off).count() as f64
    };
    let floor_pixels = on_floor.len().max(1) as f64;
    let values = wave_heights();
    let heights = Heights {
        width: TEXELS,
        values: &values,
    };
    let more = [
        procedural_bump::offset_map(
            waves()?,
            &heights,
            HEIGHT,
            size,
            &wrong,
            0.01 * floor_pixels,
        )?,
        procedural_bump::pot(size)?,
        procedural_bump::words(waves()?, size)?,
    ];
    let mut claims = claims![
        "wrong pixels of the floor under the bump map" => wrong(&bumped), 0.0, 0.01 * floor_pixels;
        "wrong pixels under the normal map" => wrong(&mapped), 0.0, 0.01 * floor_pixels;
        "wrong without either, % of the floor" => 100.0 * wrong(&flat) / floor_pixels, 67.0, 10.0;
        "wrong with the green channel flipped, % of the floor" =>
            100.0 * wrong(&flipped) / floor_pixels, 65.0, 15.0;
    ];
    let mut panels = panels![
        flat.picture => "Off", "The floor is flat.";
        bumped.picture => "Bump map", "A height field by central differences, Blinn's normal.";
        mapped.picture => "Normal map", "The same field as an 8-bit normal map, MikkTSpace.";
        flipped.picture => "Green flipped (wrong)", "Along v light comes from the wrong side.";
        truth => "Truth", "The floor with the waves' exact normals, in f64.";
    ];
    for shown in more {
        panels.push(shown.panel);
        claims.extend(shown.claims);
    }
    Ok(sheet("Bump and normal maps", panels, claims))
}

/// A floor with a ball on it under a sun that casts shadows.
fn yard() -> Scene {
    let mut scene = stage::scene(DVec3::new(1.6, 2.6, 3.6), DVec3::new(0.0, 0.2, 0.0), 45.0);
    scene.lights = stage::daylight(0.1, [0.6, 0.58, 0.5], [0.7, -0.8, -0.4]);
    let ground = stage::add(&mut scene, matte([0.8; 3], 0.0));
    let red = stage::add(&mut scene, matte([0.75, 0.3, 0.2], 0.0));
    scene.meshes = vec![
        floor(2.0, ground),
        ball(DVec3::new(0.0, 0.55, 0.0), 0.5, red),
    ];
    scene
}

pub(super) fn baked(
    scene: &Scene,
    size: u32,
    lights: Option<&[usize]>,
) -> Result<LightMap, LabError> {
    let mut shadows = Vec::new();
    let counts = |light: usize| lights.is_none_or(|all| all.contains(&light));
    for (index, light) in scene.lights.iter().enumerate() {
        if counts(index) && !matches!(light, Light::Ambient { .. }) {
            let kind = shadow_kind(scene, index, None)?;
            let bias = shadow_bias(scene);
            let map = shadow_map_for(scene, &kind, 1024, bias, 3, 1)?;
            shadows.push((index, map, bias, 3));
        }
    }
    let options = BakeOptions {
        size,
        gutter: 2,
        shadows: &shadows,
        lights,
    };
    Ok(bake(scene, 0, &options)?)
}

/// The scene with its floor under a light map.
pub(super) fn under(mut scene: Scene, map: &LightMap) -> Result<Scene, LabError> {
    let texels: Vec<f32> = map
        .texels
        .iter()
        .flat_map(|c| [c[0], c[1], c[2], 1.0])
        .collect();
    scene
        .textures
        .push(crate::plane::floats(map.size, 4, &texels)?.with_mips());
    let texture = scene.textures.len() - 1;
    scene.materials[0].light_map = Some(LightMapSlot {
        slot: stage::slot(texture, Filter::Trilinear, Wrap::ClampToEdge),
        scale: 1.0,
        baked: None,
    });
    Ok(scene)
}

fn shadowed(mut scene: Scene) -> Scene {
    for light in 1..scene.lights.len() {
        scene.effects.shadows.push(stage::shadow(light, 1024));
    }
    scene
}

pub(super) fn light_maps(size: u32) -> Result<DemoPicture, LabError> {
    let direct = Lit::take(&shadowed(yard()), size)?;
    let fine = Lit::take(&shadowed(under(yard(), &baked(&yard(), 512, None)?)?), size)?;
    let coarse = Lit::take(&shadowed(under(yard(), &baked(&yard(), 24, None)?)?), size)?;
    // The fault: texel centres taken for the mesh's without a repair, so that charts end in black.
    let mut torn = baked(&yard(), 24, None)?;
    for (texel, coverage) in torn.texels.iter_mut().zip(&torn.coverage) {
        if *coverage != texmap_raster::Coverage::Centre {
            *texel = [0.0; 3];
        }
    }
    let torn = Lit::take(&shadowed(under(yard(), &torn)?), size)?;
    let floor: Vec<usize> = (0..direct.position.len())
        .filter(|&i| direct.position[i].is_finite() && direct.position[i].y.abs() < 1e-6)
        .collect();
    let wrong = |shot: &Lit| {
        let off = |i: &&usize| difference(&shot.picture, &direct.picture, **i) > 12;
        floor.iter().filter(off).count() as f64
    };
    // The moving spotlight: what it adds is baked alone and added to the resting light, in linear light.
    let resting = baked(&yard(), 96, None)?;
    let mut worst = 0.0f32;
    for frame in 0..4 {
        let mut scene = yard();
        let x = -1.2 + 0.8 * frame as f32;
        scene.lights.push(Light::spot(
            [0.5; 3],
            [x, 2.0, 1.0],
            [0.0, -1.0, -0.4],
            0.25,
            0.4,
        ));
        let spot = baked(&scene, 96, Some(&[2]))?;
        let fresh = baked(&scene, 96, None)?;
        for ((a, b), c) in resting.texels.iter().zip(&spot.texels).zip(&fresh.texels) {
            for k in 0..3 {
                worst = worst.max((a[k] + b[k] - c[k]).abs() * 255.0);
            }
        }
    }
    let count = floor.len().max(1) as f64;
    let claims = claims![
        "wrong pixels of the floor under 512 x 512 baked texels" => wrong(&fine), 0.0, 0.02 * count;
        "wrong with 24 x 24, % of the floor" => 100.0 * wrong(&coarse) / count, 2.9, 1.2;
        "wrong without repaired borders and gutters, % of the floor beyond that" =>
            100.0 * (wrong(&torn) - wrong(&coarse)) / count, 1.15, 0.7;
        "moving spotlight: resting map and spot, against a fresh bake, /255" => f64::from(worst), 0.0, 1.0;
    ];
    let panels = panels![
        direct.picture => "Computed per pixel", "Lights and shadow maps for every pixel.";
        fine.picture => "Baked, 512 x 512", "The floor reads its light from a map.";
        coarse.picture => "Baked, 24 x 24", "Low resolution blurs the shadow, nothing else.";
        torn.picture => "No repair, no gutter (wrong)", "Texels whose centre is off the chart are black.";
    ];
    Ok(sheet("Light maps", panels, claims))
}

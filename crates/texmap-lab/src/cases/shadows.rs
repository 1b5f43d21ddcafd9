//! P1 to P3 and H1 to H7: projectors and shadow maps.

use texmap_light::{
    Light, PhongMaterial, ProjectorBorder, ProjectorTexture, ShadowBias, ShadowKind, ShadowMap,
};
use texmap_math::camera::Camera;
use texmap_math::glam::{DMat4, DVec2, DVec3};
use texmap_math::{Projector, deterministic_f64};
use texmap_raster::{
    BinnedDraws, DrawCall, Fragment, NO_PRIMITIVE, NoAlphaTest, TargetSize, VisibilityBuffer,
};
use texmap_render::shadow_map;
use texmap_sample::{ColorSpace, Filter, Origin, Sampler, Texture2d};
use texmap_scene::{Material, Mesh, Scene, shadow_kind};

use super::Measurement;
use crate::LabError;
use crate::shadow_scene::{Figures, ShadowScene};

/// A projector of 45 degrees at the origin, along -Z.
fn projector() -> Result<Projector, LabError> {
    Ok(Projector::new(
        DVec3::ZERO,
        DVec3::NEG_Z,
        DVec3::Y,
        0.8,
        1.0,
    )?)
}

fn slide_light(border: ProjectorBorder, points: &[[f32; 3]]) -> Result<Vec<[f32; 4]>, LabError> {
    let texture = Texture2d::from_rgba8(4, 4, vec![255; 64], ColorSpace::Linear, Origin::TopLeft)?;
    let sampler = Sampler {
        filter: Filter::Bilinear,
        ..Sampler::default()
    };
    let picture = ProjectorTexture {
        projector: projector()?,
        texture: &texture,
        sampler: &sampler,
        border,
        softness: 0.0,
    };
    let mut out = vec![[0.0; 4]; points.len()];
    // Both slices have one length.
    let _ = picture.light_slice(points, &mut out);
    Ok(out)
}

/// Points of walls at z = `z`.
fn wall(z: f32) -> Vec<[f32; 3]> {
    let at = |i: u32| i as f32 * 0.05 - 5.0;
    (0..200 * 200)
        .map(|i| [at(i % 200), at(i / 200), z])
        .collect()
}

pub(super) fn p1() -> Result<Vec<Measurement>, LabError> {
    let behind: Vec<_> = [0.0, 1e-6, 0.5, 2.0].into_iter().flat_map(wall).collect();
    let lit = slide_light(ProjectorBorder::Black, &behind)?;
    let front = slide_light(ProjectorBorder::Black, &wall(-2.0))?;
    let projector = projector()?;
    let naive = behind.iter().filter(|p| {
        let q = projector.project(DVec3::from(p.map(f64::from)));
        let (u, v) = (q.x / q.z, q.y / q.z);
        (0.0..1.0).contains(&u) && (0.0..1.0).contains(&v)
    });
    let measure = "points behind the projector that are lit";
    Ok(measured![
        "t tested before the division", measure => count(&lit);
        "t tested before the division", "points in front that are lit" => count(&front);
        "no test of t", measure => naive.count() as f64;
    ])
}

fn count(lit: &[[f32; 4]]) -> f64 {
    lit.iter().filter(|c| c[3] > 0.0).count() as f64
}

pub(super) fn p2() -> Result<Vec<Measurement>, LabError> {
    let points = wall(-2.0);
    let half = 2.0 * deterministic_f64::tan(0.4);
    let outside: Vec<_> = points
        .into_iter()
        .filter(|p| f64::from(p[0].abs().max(p[1].abs())) > half)
        .collect();
    let measure = "points beyond the slide that are lit";
    let one = |method, border| -> Result<Measurement, LabError> {
        Ok(Measurement::new(
            method,
            measure,
            count(&slide_light(border, &outside)?),
        ))
    };
    Ok(vec![
        one("black border", ProjectorBorder::Black)?,
        one("clamped", ProjectorBorder::Clamp)?,
        one("repeated", ProjectorBorder::Repeat)?,
    ])
}

pub(super) fn p3() -> Result<Vec<Measurement>, LabError> {
    // A slanted wall seen from the side; the projector stands elsewhere.
    let projector = Projector::new(
        DVec3::new(-1.0, 2.0, 1.0),
        DVec3::new(1.0, 0.0, -4.0),
        DVec3::Y,
        1.0,
        1.0,
    )?;
    let camera = Camera {
        eye: DVec3::new(0.0, 0.3, 2.0),
        look: DVec3::new(0.5, 0.0, -3.0),
        up: DVec3::Y,
        fov_x: 1.1,
        near: 1e-3,
        far: f64::INFINITY,
    };
    let corners = [
        DVec3::new(-3.0, -1.0, -1.0),
        DVec3::new(4.0, -1.0, -9.0),
        DVec3::new(4.0, 3.0, -9.0),
    ];
    let positions = corners.map(|c| c.as_vec3().to_array());
    let mut attributes = Vec::new();
    for c in corners {
        let uv = projector.project(c);
        attributes.extend(c.as_vec3().to_array());
        attributes.extend([(uv.x / uv.z) as f32, (uv.y / uv.z) as f32]);
    }
    let draw = DrawCall {
        positions: &positions,
        indices: &[[0, 1, 2]],
        clip_from_object: camera.projection(1.0) * camera.view()?,
        attributes: &attributes,
        attribute_count: 5,
        ..DrawCall::default()
    };
    let size = 256;
    let prepared = BinnedDraws::new(TargetSize::new(size, size)?, &[draw])?;
    let pinhole = texmap_truth::caster::Pinhole::of_camera(&camera, size, size)?;
    let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
    let (mut buffers, mut fragment) = (VisibilityBuffer::new(), Fragment::default());
    let (mut worst, mut naive) = (0.0f64, 0.0f64);
    for index in 0..prepared.tiles() {
        let tile = prepared.tile(index);
        prepared.visible(index, &NoAlphaTest, &mut buffers);
        for (x, y) in (0..tile.height).flat_map(|y| (0..tile.width).map(move |x| (x, y))) {
            let id = buffers.id[(y * 64 + x) as usize];
            if id == NO_PRIMITIVE {
                continue;
            }
            let (x, y) = (tile.x0 + x, tile.y0 + y);
            prepared.evaluate(id, x, y, &mut fragment);
            let ray = pinhole.direction(f64::from(x) + 0.5, f64::from(y) + 0.5);
            let t = normal.dot(corners[0] - pinhole.eye) / normal.dot(ray);
            let Some(truth) = projector.uv(pinhole.eye + ray * t) else {
                continue;
            };
            if truth.min_element() < 0.0 || truth.max_element() > 1.0 {
                continue;
            }
            let p = DVec3::new(
                fragment.values[0].into(),
                fragment.values[1].into(),
                fragment.values[2].into(),
            );
            if let Some(found) = projector.uv(p) {
                worst = worst.max((found - truth).abs().max_element());
            }
            let early = DVec2::new(fragment.values[3].into(), fragment.values[4].into());
            naive = naive.max((early - truth).abs().max_element());
        }
    }
    let measure = "largest error of slide coordinates, texels of 512";
    Ok(measured![
        "division per pixel", measure => worst * 512.0;
        "division at the vertices", measure => naive * 512.0;
    ])
}

fn figures(method: &str, elevation: f64, size: u32, found: Figures) -> [Measurement; 2] {
    let measure = |what: &str| format!("{what}, %, elevation {elevation}, {size} texels");
    [
        Measurement::new(method, measure("false shadow"), 100.0 * found.false_shadow),
        Measurement::new(method, measure("false light"), 100.0 * found.false_light),
    ]
}

pub(super) fn h1() -> Result<Vec<Measurement>, LabError> {
    let scene = ShadowScene::ring();
    let found = scene.measure(60.0, 512, ShadowBias::Constant(0.0), 1, 256)?;
    let [acne, _] = figures("no bias", 60.0, 512, found);
    Ok(vec![acne])
}

pub(super) fn h2() -> Result<Vec<Measurement>, LabError> {
    let scene = ShadowScene::ring();
    let texel = 5.2 / 512.0;
    let mut all = Vec::new();
    for elevation in [25.0, 10.0] {
        let found = scene.measure(elevation, 512, ShadowBias::Constant(texel), 1, 256)?;
        let [acne, _] = figures("constant of a texel", elevation, 512, found);
        all.push(acne);
    }
    Ok(all)
}

pub(super) fn h3() -> Result<Vec<Measurement>, LabError> {
    let scene = ShadowScene::ring();
    let mut all = Vec::new();
    for (elevation, size) in [
        (60.0, 512),
        (25.0, 512),
        (10.0, 512),
        (25.0, 2048),
        (10.0, 2048),
    ] {
        // One pixel of 256 x 256 is more than the figure that is demanded.
        let pixels = if elevation > 30.0 { 512 } else { 256 };
        let found = scene.measure(elevation, size, ShadowBias::Slope(1e-4), 1, pixels)?;
        all.extend(figures("slope", elevation, size, found));
        if elevation > 30.0 {
            all.push(Measurement::new(
                "slope",
                "false shadow at creases, %, elevation 60, 512 texels",
                100.0 * found.creases,
            ));
        }
    }
    let found = scene.measure(10.0, 512, ShadowBias::Constant(1e-4), 1, 256)?;
    let [acne, _] = figures("constant of 1e-4", 10.0, 512, found);
    all.push(acne);
    Ok(all)
}

pub(super) fn h4() -> Result<Vec<Measurement>, LabError> {
    let scene = ShadowScene::ring();
    let (ruled, clamped) = scene.outside(60.0, 512, 256)?;
    let measure = "false shadow of points outside of the map, %";
    Ok(measured![
        "outside is lit", measure => 100.0 * ruled;
        "clamped look-up", measure => 100.0 * clamped;
    ])
}

/// A light straight down over a floor of depth 1, half the map covered by a plate of depth 0.5.
fn half_covered(size: u32) -> Result<ShadowMap, LabError> {
    let kind = ShadowKind::Directional {
        light_from_world: DMat4::IDENTITY,
        half: 1.0,
    };
    let depths = (0..size * size).map(|i| if i % size < size / 2 { 0.5 } else { 1.0 });
    ShadowMap::new(kind, size, depths.collect()).map_err(|e| LabError::Cases(e.to_string()))
}

pub(super) fn h5() -> Result<Vec<Measurement>, LabError> {
    let map = half_covered(64)?;
    let mut dark = 0;
    for k in [1e6, 1e9, 1e18, 1e30, 1e300, f64::INFINITY, f64::NAN] {
        for p in [
            DVec3::new(k, 0.0, -1.0),
            DVec3::new(-k, k, -1.0),
            DVec3::new(0.0, -k, -1.0),
        ] {
            let lit = map.visibility(p, DVec3::Z, ShadowBias::Slope(1e-4), 5);
            dark += u32::from(lit != 1.0);
        }
    }
    // The texel as an integer, then the offsets of the PCF comparisons.
    let wild = [1e6f64, 1e9, 1e18, 1e30, 1e300, f64::INFINITY];
    let overflows = wild.iter().filter(|k| {
        let texel = ((**k * 0.5 + 0.5) * 64.0) as i32;
        texel.checked_add(2).is_none()
    });
    Ok(measured![
        "clamped before the taps", "far or bad points that are not lit" => f64::from(dark);
        "taps before the clamp", "coordinates that overflow" => overflows.count() as f64;
    ])
}

fn walled(thickness: f64) -> Result<(Scene, Light), LabError> {
    let mut floor = crate::shadow_scene::floor(3.0);
    floor.name = "floor".into();
    let cube = |v: u32, size: DVec3| {
        let side = |bit: u32| if v >> bit & 1 == 0 { -0.5 } else { 0.5 };
        (size * DVec3::new(side(0), side(1), side(2)) + DVec3::Z * (size.z * 0.5)).as_vec3()
    };
    let size = DVec3::new(thickness, 2.0, 0.6);
    let wall = Mesh {
        name: "wall".into(),
        positions: (0..8).map(|v| cube(v, size).to_array()).collect(),
        triangles: vec![
            [0, 2, 1],
            [1, 2, 3],
            [4, 5, 6],
            [5, 7, 6],
            [0, 1, 4],
            [1, 5, 4],
            [2, 6, 3],
            [3, 6, 7],
            [0, 4, 2],
            [2, 4, 6],
            [1, 3, 5],
            [3, 7, 5],
        ],
        ..Mesh::default()
    };
    let (sin, cos) = deterministic_f64::sin_cos(25.0f64.to_radians());
    let light = Light::Directional {
        color: [1.0; 3],
        direction: [-cos as f32, 0.0, -sin as f32],
    };
    let scene = Scene {
        background: [0.0; 4],
        lights: vec![light],
        materials: vec![Material {
            phong: PhongMaterial::default(),
            ..Material::default()
        }],
        meshes: vec![floor, wall],
        ..Scene::new(Camera {
            eye: DVec3::new(0.0, -3.0, 2.0),
            look: DVec3::ZERO,
            up: DVec3::Z,
            fov_x: 1.0,
            near: 1e-3,
            far: f64::INFINITY,
        })
    };
    Ok((scene, light))
}

pub(super) fn h6() -> Result<Vec<Measurement>, LabError> {
    let size = 512;
    let texel = 5.2 / f64::from(size);
    let gap = |bias: ShadowBias, thickness: f64| -> Result<(f64, f64), LabError> {
        let (scene, _) = walled(thickness * texel)?;
        let kind = shadow_kind(&scene, 0, Some((DVec3::ZERO, 2.6)))?;
        let map = shadow_map(&scene, &kind, size, 1)?;
        // The light comes from +x: the shadow runs from the wall's foot at -thickness / 2 to the shadow of its top.
        let foot = -0.5 * thickness * texel;
        let end = foot - 0.6 / deterministic_f64::tan(25.0f64.to_radians());
        let (mut gap, mut leaks) = (0.0f64, 0u32);
        for i in 0..4_000 {
            let (x, y) = (
                foot - f64::from(i) * 1e-4 * 2.0 - 1e-5,
                0.003 * f64::from(i % 97),
            );
            let lit = map.visibility(DVec3::new(x, y, 0.0), DVec3::Z, bias, 1) > 0.0;
            let way = (foot - x) / texel;
            // The map's texel on the floor is longer along the light.
            let on_floor = way * deterministic_f64::sin(25.0f64.to_radians());
            if lit && way < 20.0 {
                gap = gap.max(on_floor);
            }
            leaks += u32::from(lit && way >= 20.0 && x > end + 3.0 * texel);
        }
        Ok((gap, f64::from(leaks)))
    };
    let (near, _) = gap(ShadowBias::Slope(1e-4), 4.0)?;
    let (_, thin) = gap(ShadowBias::Slope(1e-4), 2.0)?;
    let (far, _) = gap(ShadowBias::Constant(0.1), 4.0)?;
    let measure = "gap between a wall and its shadow, texels";
    Ok(measured![
        "slope", measure => near;
        "slope", "points lit behind a wall of two texels" => thin;
        "constant of ten texels", measure => far;
    ])
}

pub(super) fn h7() -> Result<Vec<Measurement>, LabError> {
    let map = half_covered(64)?;
    let stored = |x: i64, y: i64| {
        map.depth_at(0, x.clamp(0, 63) as u32, y.clamp(0, 63) as u32)
            .map_or(1.0, f64::from)
    };
    let (mut worst, mut naive) = (0.0f64, 0.0f64);
    for i in 0..600 {
        // Texels 20 to 44, away from the map's edge.
        let x = f64::from(i) / 600.0 * 0.75 - 0.375;
        let p = DVec3::new(x, 0.1, -0.9);
        let lit = f64::from(map.visibility(p, DVec3::Z, ShadowBias::Constant(1e-6), 5));
        let column = ((x * 0.5 + 0.5) * 64.0).floor() as i64;
        let row = ((0.5 - 0.05) * 64.0f64).floor() as i64;
        let offsets = (-2..=2).flat_map(|j| (-2..=2).map(move |i| (i, j)));
        let depths: Vec<f64> = offsets.map(|(i, j)| stored(column + i, row + j)).collect();
        let share = depths.iter().filter(|d| 0.9 <= **d).count() as f64 / 25.0;
        let mean = depths.iter().sum::<f64>() / 25.0;
        worst = worst.max((lit - share).abs());
        naive = naive.max((f64::from(u8::from(0.9 <= mean)) - share).abs());
    }
    let measure = "difference to the share of taps that pass";
    Ok(measured![
        "mean of comparisons", measure => worst;
        "comparison of the mean", measure => naive;
    ])
}

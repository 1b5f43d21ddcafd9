//! B1 to B3, B5 and B6: bump and normal maps.

use std::f64::consts::TAU;

use texmap_light::{
    Heights, NormalMapGreen, Slope, clamp_to_horizon, decode_normal, encode_normal,
};
use texmap_math::deterministic_f64;
use texmap_math::glam::{DMat3, DMat4, DVec3};
use texmap_scene::Mesh;
use texmap_uv::Shape;

use super::Measurement;
use super::environment::Noise;
use crate::LabError;
use texmap_truth::rays::{RayObject, RayScene};

fn degrees(a: DVec3, b: DVec3) -> f64 {
    deterministic_f64::atan2(a.cross(b).length(), a.dot(b)).to_degrees()
}

fn wide(a: [f32; 3]) -> DVec3 {
    DVec3::from(a.map(f64::from))
}

fn slope_of(values: &[f32], width: u32, x: i64, slope: Slope) -> Result<f64, LabError> {
    let heights = Heights { width, values };
    let found = heights
        .slope(x, 0, slope)
        .map_err(|e| LabError::Cases(e.to_string()))?;
    Ok(f64::from(found[0]))
}

pub(super) fn b1() -> Result<Vec<Measurement>, LabError> {
    let mut all = Vec::new();
    for n in [4u32, 8, 16, 32] {
        let w = TAU / f64::from(n);
        let row: Vec<f32> = (0..n)
            .map(|i| deterministic_f64::sin(f64::from(i) * w) as f32)
            .collect();
        let measure = format!("relative shortfall of the slope, {n} samples a period");
        let found = slope_of(&row, n, 0, Slope::Central)?;
        all.push(Measurement::new(
            "central difference",
            measure,
            1.0 - found / w,
        ));
    }
    let w = TAU / 8.0;
    let forward = deterministic_f64::sin(2.0 * w) - deterministic_f64::sin(w);
    all.push(Measurement::new(
        "forward difference",
        "relative error of the slope, 8 samples a period, an eighth on",
        (1.0 - forward / (w * deterministic_f64::cos(w))).abs(),
    ));
    Ok(all)
}

pub(super) fn b2() -> Result<Vec<Measurement>, LabError> {
    // A gentle ramp of amplitude 0.1 over 512 texels of a unit square, in 8 bits, 16 bits and floats.
    let height = |i: u32| 0.1 * (0.5 - 0.5 * deterministic_f64::cos(TAU * f64::from(i) / 512.0));
    let stored = |levels: f64| -> Vec<f32> {
        let code = |h: f64| (h / 0.1 * levels).round() / levels * 0.1;
        (0..512).map(|i| code(height(i)) as f32).collect()
    };
    let float: Vec<f32> = (0..512).map(|i| height(i) as f32).collect();
    let worst = |values: &[f32]| -> Result<f64, LabError> {
        let mut worst = 0.0f64;
        for i in 0..512u32 {
            let exact = 0.1 * 0.5 * TAU * deterministic_f64::sin(TAU * f64::from(i) / 512.0);
            let found = slope_of(values, 512, i64::from(i), Slope::Central)? * 512.0;
            worst = worst.max(
                (deterministic_f64::atan(found) - deterministic_f64::atan(exact))
                    .abs()
                    .to_degrees(),
            );
        }
        Ok(worst)
    };
    let measure = "largest angle to the true normal, degrees, 512 texels, amplitude 0.1";
    Ok(measured![
        "float heights", measure => worst(&float)?;
        "16-bit heights", measure => worst(&stored(65535.0))?;
        "8-bit heights", measure => worst(&stored(255.0))?;
    ])
}

pub(super) fn b3() -> Result<Vec<Measurement>, LabError> {
    let (mut full, mut rebuilt, mut sum, mut wrong, mut flipped) =
        (0.0f64, 0.0f64, 0.0, 0.0f64, 0.0f64);
    let count = 40_000u32;
    for i in 0..count {
        let (z, phi) = (
            (f64::from(i) + 0.5) / f64::from(count),
            f64::from(i) * 2.399_963,
        );
        let r = (1.0 - z * z).sqrt();
        let (sin, cos) = deterministic_f64::sin_cos(phi);
        let n = DVec3::new(r * cos, r * sin, z);
        let bytes = encode_normal(n.as_vec3().to_array(), NormalMapGreen::Up)
            .map(|c| (c * 255.0 + 0.5).floor() / 255.0);
        let angle = degrees(wide(decode_normal(bytes, NormalMapGreen::Up, false)), n);
        full = full.max(angle);
        sum += angle;
        rebuilt = rebuilt.max(degrees(
            wide(decode_normal(bytes, NormalMapGreen::Up, true)),
            n,
        ));
        flipped = flipped.max(degrees(
            wide(decode_normal(bytes, NormalMapGreen::Down, false)),
            n,
        ));
        // The texel taken for the normal: no 2c - 1.
        wrong = wrong.max(degrees(wide(bytes), n));
    }
    let measure = "largest error of an 8-bit normal, degrees";
    Ok(measured![
        "three channels", measure => full;
        "three channels", "mean error of an 8-bit normal, degrees" => sum / f64::from(count);
        "z rebuilt", measure => rebuilt;
        "no bias", measure => wrong;
        "green flipped", measure => flipped;
    ])
}

pub(super) fn b5() -> Result<Vec<Measurement>, LabError> {
    // A ball scaled unevenly and mirrored, by the renderer's normal AOV against the ray tracer's.
    let world = DMat4::from_scale(DVec3::new(-2.0, 0.5, 1.0));
    let solid = RayScene::new([RayObject::Solid(Shape::Sphere, world)]);
    let mut noise = Noise::new(21);
    let (mut worst, mut naive) = (0.0f64, 0.0f64);
    let (mut points, mut truths) = (Vec::new(), Vec::new());
    while points.len() < 3_000 {
        let mut next = || 2.0 * noise.unit() - 1.0;
        let o = DVec3::new(next(), next(), next()) * 5.0;
        let Some(hit) = solid.nearest(o, -o, (0.0, f64::INFINITY)) else {
            continue;
        };
        points.push(world.inverse().transform_point3(hit.point));
        truths.push(hit.normal);
    }
    // A mesh whose vertices are those points: its vertex normals go the way that the renderer sends them.
    let mesh = Mesh {
        positions: points.iter().map(|p| p.as_vec3().to_array()).collect(),
        normals: points
            .iter()
            .map(|p| (*p * 2.0).as_vec3().to_array())
            .collect(),
        triangles: (0..points.len() as u32 / 3)
            .map(|t| [3 * t, 3 * t + 1, 3 * t + 2])
            .collect(),
        world_from_object: world,
        ..Mesh::default()
    };
    for (i, found) in mesh.world_normals().iter().enumerate() {
        worst = worst.max(degrees(*found, truths[i]));
        let straight = DMat3::from_mat4(world) * points[i];
        naive = naive.max(degrees(straight, truths[i]));
    }
    let measure = "largest angle to the true normal, degrees, scaled by -2, 0.5, 1";
    Ok(measured![
        "inverse transpose", measure => worst;
        "the matrix itself", measure => naive;
    ])
}

pub(super) fn b6() -> Result<Vec<Measurement>, LabError> {
    let mut noise = Noise::new(31);
    let (mut below, mut bad, mut naive) = (0u32, 0u32, 0u32);
    for _ in 0..20_000 {
        let mut next = || 2.0 * noise.unit() - 1.0;
        // A view that grazes a face whose normal is +Z, and a bump that leans by up to 60 degrees.
        let view = DVec3::new(next(), next(), 0.02 + 0.1 * next().abs());
        let normal = DVec3::new(next(), next(), 0.6).normalize();
        let narrow = |v: DVec3| v.as_vec3().to_array();
        let kept = wide(clamp_to_horizon(narrow(normal), narrow(view)));
        below += u32::from(kept.dot(view) < 0.0);
        bad += u32::from(!kept.is_finite());
        naive += u32::from(normal.dot(view) < 0.0);
    }
    let measure = "normals turned away from the eye, of 20000";
    Ok(measured![
        "clamped to the horizon", measure => f64::from(below);
        "clamped to the horizon", "values that are not finite" => f64::from(bad);
        "the map as it is", measure => f64::from(naive);
    ])
}

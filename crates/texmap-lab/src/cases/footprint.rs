//! S6 to S9: cut-outs, turned footprints, seams and horizons.

use texmap_math::glam::{DMat2, DVec2, DVec3};
use texmap_math::{Footprint, camera::Camera, deterministic_f64};
use texmap_raster::DrawCall;
use texmap_sample::{ColorSpace, Filter, Origin, Sampler, Texture2d, Wrap};

use super::Measurement;
use super::probe::{Random, visit};
use crate::LabError;
use crate::plane::floats;

/// S6: a green disc among transparent texels of magenta, composed over white.
pub(super) fn s6() -> Result<Vec<Measurement>, LabError> {
    const SIDE: u32 = 16;
    let inside = |x: i32, y: i32| (2 * x - 15).pow(2) + (2 * y - 15).pow(2) < 12 * 12;
    let texel = |x: i32, y: i32| {
        let (x, y) = (x.clamp(0, 15), y.clamp(0, 15));
        if inside(x, y) {
            [0.0, 1.0, 0.0, 1.0]
        } else {
            [1.0, 0.0, 1.0, 0.0]
        }
    };
    let bytes: Vec<u8> = (0..SIDE * SIDE)
        .flat_map(|i| texel((i % SIDE) as i32, (i / SIDE) as i32).map(|c| (c * 255.0) as u8))
        .collect();
    let texture = Texture2d::from_rgba8(SIDE, SIDE, bytes, ColorSpace::Linear, Origin::TopLeft)?;
    let sampler = Sampler {
        filter: Filter::Bilinear,
        wrap_u: Wrap::ClampToEdge,
        wrap_v: Wrap::ClampToEdge,
        ..Sampler::default()
    };
    let mut random = Random(6);
    let (mut own, mut straight) = (0.0f64, 0.0f64);
    for _ in 0..5_000 {
        let uv = [0, 1].map(|_| random.range(0.0, 1.0));
        let [x, y] = uv.map(|c| c * f64::from(SIDE) - 0.5);
        let bilinear = |value: &dyn Fn(i32, i32) -> f64| {
            let (i, j) = (x.floor() as i32, y.floor() as i32);
            let (s, t) = (x - x.floor(), y - y.floor());
            let row = |j: i32| value(i, j) * (1.0 - s) + value(i + 1, j) * s;
            row(j) * (1.0 - t) + row(j + 1) * t
        };
        let found = sampler.sample(&texture, uv.map(|c| c as f32));
        for k in 0..3 {
            // The picture composed texel by texel, then filtered: what endless supersampling gives.
            let truth = bilinear(&|i, j| {
                let c = texel(i, j);
                c[k] * c[3] + 1.0 - c[3]
            });
            let own_value = f64::from(found[k]) + 1.0 - f64::from(found[3]);
            own = own.max((own_value - truth).abs());
            let alpha = bilinear(&|i, j| texel(i, j)[3]);
            let value = bilinear(&|i, j| texel(i, j)[k]) * alpha + 1.0 - alpha;
            straight = straight.max((value - truth).abs());
        }
    }
    let measure = "difference from the composed picture, of 255";
    Ok(measured![
        "premultiplied", measure => own * 255.0;
        "straight alpha", measure => straight * 255.0;
    ])
}

/// A footprint whose ellipse has these half axes in texels, turned by two angles: `R(a) diag R(b)`.
fn footprint(side: f64, major: f64, minor: f64, a: f64, b: f64) -> Footprint {
    let turn = |angle: f64| {
        let (sin, cos) = deterministic_f64::sin_cos(angle);
        DMat2::from_cols(DVec2::new(cos, sin), DVec2::new(-sin, cos))
    };
    let axes = DMat2::from_diagonal(DVec2::new(major, minor));
    let j = (turn(a) * axes * turn(b)).to_cols_array();
    let [ux, vx, uy, vy] = j.map(|c| (c / side) as f32);
    Footprint::new(ux, vx, uy, vy)
}

/// A texture whose value at its middle, through the mip chain, is the level of detail: rings about the middle
/// so valued that the mean over the central 2^(L+1) square is L.
fn level_gauge(side: u32) -> Result<Texture2d<'static>, LabError> {
    let texels: Vec<f32> = (0..side * side)
        .map(|i| {
            let half = i64::from(side / 2);
            let from = |c: u32| (2 * (i64::from(c) - half) + 1).unsigned_abs() as f64 / 2.0;
            let ring = from(i % side).max(from(i / side)).log2().floor();
            if ring < 0.0 {
                0.0
            } else {
                (ring + 4.0 / 3.0) as f32
            }
        })
        .collect();
    Ok(floats(side, 1, &texels)?.with_mips())
}

/// S7: footprints turned and sheared by any angle: level and axes of the ellipse, not of the columns.
pub(super) fn s7() -> Result<Vec<Measurement>, LabError> {
    const SIDE: u32 = 1024;
    // Probes for each short axis after the first.
    const PER_AXIS: f64 = 1.1;
    let gauge = level_gauge(SIDE)?;
    let sampler = |most| Sampler {
        filter: Filter::Anisotropic(most),
        ..Sampler::default()
    };
    let mut random = Random(7);
    let (mut own, mut columns) = (0.0f64, 0.0f64);
    let (mut wrong, mut wrong_columns) = (0u32, 0u32);
    for _ in 0..2_000 {
        let (a, b) = (
            random.range(0.0, std::f64::consts::TAU),
            random.range(0.0, std::f64::consts::TAU),
        );
        let level = random.range(0.5, 7.5);
        let major = deterministic_f64::exp2(level);
        let d = footprint(
            f64::from(SIDE),
            major,
            major / random.range(1.5, 12.0),
            a,
            b,
        );
        // One probe of the whole ellipse: its level is that of the long axis.
        let found = sampler(1).sample_grad(&gauge, [0.5, 0.5], d)[0];
        own = own.max((f64::from(found) - level).abs());
        columns = columns.max((f64::from(sampler(1).lod(&gauge, d)) - level).abs());
        // The number of probes is that of the ratio rounded up: at a ratio 1e-4 beside one of a whole number it must not err.
        let probes = random.range(2.0, 14.0).floor();
        let above = random.bits() & 1 == 1;
        let near = (1.0 + (probes - 1.0) / PER_AXIS) * if above { 1.0001 } else { 0.9999 };
        let d = footprint(f64::from(SIDE), 24.0, 24.0 / near, a, b);
        let expected = probes as u32 + u32::from(above);
        wrong += u32::from(sampler(16).probes(&gauge, d) != expected);
        let length = |x: f32, y: f32| f64::from(x).hypot(f64::from(y));
        let (x, y) = (length(d.du_dx, d.dv_dx), length(d.du_dy, d.dv_dy));
        let of_columns = 1.0 + PER_AXIS * (x.max(y) / x.min(y) - 1.0);
        wrong_columns += u32::from(of_columns.ceil() as u32 != expected);
    }
    let (level, count) = (
        "error of the level of detail",
        "wrong probe counts of 2000, ratios 1e-4 beside those of whole counts",
    );
    Ok(measured![
        "axes of the ellipse", level => own;
        "columns of the Jacobian", level => columns;
        "axes of the ellipse", count => wrong.into();
        "columns of the Jacobian", count => wrong_columns.into();
    ])
}

/// S8: a plane to the horizon in two charts that meet at a seam. Derivatives per triangle, and by 2x2 quads.
pub(super) fn s8() -> Result<Vec<Measurement>, LabError> {
    const SIDE: u32 = 128;
    let camera = Camera {
        eye: DVec3::new(0.1, 2.0, 8.0),
        look: DVec3::new(0.4, 1.2, 2.0),
        up: DVec3::Y,
        fov_x: 60f64.to_radians(),
        near: 1e-3,
        far: f64::INFINITY,
        lens: Default::default(),
    };
    // Both charts have u = x / 8 and v = z / 8, but the right one starts elsewhere: a seam at x = 0.
    let offset = [0.37, -0.21];
    let x = [-400.0, 0.0, 0.0, 400.0];
    let z = [-4000.0, 7.5];
    let mut mesh = (Vec::new(), Vec::new());
    for (i, x) in x.into_iter().enumerate() {
        let chart = if i < 2 { [0.0; 2] } else { offset };
        for z in z {
            mesh.0.push([x as f32, 0.0, z as f32]);
            mesh.1
                .extend([x / 8.0 + chart[0], z / 8.0 + chart[1]].map(|c| c as f32));
        }
    }
    let indices = [[0u32, 1, 3], [0, 3, 2], [4, 5, 7], [4, 7, 6]];
    let clip = camera.clip_from_world(1.0)?;
    let draw = DrawCall {
        positions: &mesh.0,
        indices: &indices,
        clip_from_object: clip,
        attributes: &mesh.1,
        attribute_count: 2,
        ..DrawCall::default()
    };
    // Value and derivatives of the plane under a pixel, whether it sees the plane or not.
    let plane = |x: f64, y: f64| -> Option<[DVec2; 3]> {
        let at = |x: f64, y: f64| camera.ray(SIDE, SIDE, x, y).ok();
        let d = at(x, y)?;
        let (dx, dy) = (
            at(x + 0.5, y)? - at(x - 0.5, y)?,
            at(x, y + 0.5)? - at(x, y - 0.5)?,
        );
        let t = -camera.eye.y / d.y;
        let slope = |step: DVec3| {
            let dt = -t * step.y / d.y;
            DVec2::new(t * step.x + dt * d.x, t * step.z + dt * d.z) / 8.0
        };
        let p = camera.eye + d * t;
        Some([DVec2::new(p.x, p.z) / 8.0, slope(dx), slope(dy)])
    };
    let lod = |d: [DVec2; 2]| 0.5 * d[0].length_squared().max(d[1].length_squared()).log2();
    let mut seen = vec![None; (SIDE * SIDE) as usize];
    visit((SIDE, SIDE), &[draw], |x, y, fragment| {
        let pair = |v: &[f32]| DVec2::new(f64::from(v[0]), f64::from(v[1]));
        let d = [pair(&fragment.ddx), pair(&fragment.ddy)];
        seen[(y * SIDE + x) as usize] = Some((pair(&fragment.values), d));
    })?;
    let (mut own, mut quads) = (0.0f64, 0.0f64);
    let (mut own_jump, mut quad_jump) = (0.0f64, 0.0f64);
    for y in 0..SIDE {
        // Level of the pixel to the left: texmap's and the quad's.
        let mut left: Option<(f64, f64)> = None;
        for x in 0..SIDE {
            let Some((value, d)) = seen[(y * SIDE + x) as usize] else {
                left = None;
                continue;
            };
            let Some([exact, tx, ty]) = plane(f64::from(x) + 0.5, f64::from(y) + 0.5) else {
                continue;
            };
            // A centre that only the snapped outline covers has no true derivative: its values are held in the hull.
            let (across, along) = (exact.x * 8.0, exact.y * 8.0);
            if across.abs() > 400.0 || !(z[0]..=z[1]).contains(&along) {
                continue;
            }
            let size = tx.length().max(ty.length());
            let relative = |d: [DVec2; 2]| (d[0] - tx).length().max((d[1] - ty).length()) / size;
            own = own.max(relative(d));
            // A quad subtracts its pixels; one that the triangles do not reach is a helper, extrapolated from
            // the plane, behind the horizon too.
            let at = |x: u32, y: u32| {
                let hit = seen.get((y * SIDE + x) as usize).copied().flatten();
                match hit {
                    Some((value, _)) if x < SIDE => value,
                    _ => plane(f64::from(x) + 0.5, f64::from(y) + 0.5).map_or(DVec2::NAN, |p| p[0]),
                }
            };
            let step = |c: u32| if c & 1 == 0 { 1.0 } else { -1.0 };
            let quad = [
                (at(x ^ 1, y) - value) * step(x),
                (at(x, y ^ 1) - value) * step(y),
            ];
            let off = relative(quad);
            quads = quads.max(if off.is_nan() { f64::INFINITY } else { off });
            let levels = (lod(d), lod(quad));
            if let Some(left) = left {
                own_jump = own_jump.max((levels.0 - left.0).abs());
                quad_jump = quad_jump.max((levels.1 - left.1).abs());
            }
            left = Some(levels);
        }
    }
    let (error, jump) = (
        "error of a derivative, of the larger one",
        "jump of the level between neighbours in a row",
    );
    Ok(measured![
        "analytic, per triangle", error => own;
        "differences in 2x2 quads", error => quads;
        "analytic, per triangle", jump => own_jump;
        "differences in 2x2 quads", jump => quad_jump;
    ])
}

/// S9: footprints towards the horizon, without a short axis, and without any.
pub(super) fn s9() -> Result<Vec<Measurement>, LabError> {
    const SIDE: u32 = 256;
    let wave = |x: f64, y: f64| {
        let turn = std::f64::consts::TAU / f64::from(SIDE);
        0.5 + 0.25 * deterministic_f64::sin(turn * (16.0 * x + 4.0 * y))
            + 0.25 * deterministic_f64::sin(turn * (3.0 * x - 20.0 * y))
    };
    let texels: Vec<f32> = (0..SIDE * SIDE)
        .map(|i| wave(f64::from(i % SIDE) + 0.5, f64::from(i / SIDE) + 0.5) as f32)
        .collect();
    let texture = floats(SIDE, 1, &texels)?.with_mips();
    let sampler = |filter| Sampler {
        filter,
        ..Sampler::default()
    };
    let (most, plain) = (sampler(Filter::Anisotropic(16)), sampler(Filter::Trilinear));
    let mut random = Random(9);
    let (mut bad, mut probes, mut unbounded) = (0u32, 0u32, 0.0f64);
    for big in [0.0f32, 1e-30, 1e-3, 1.0, 1e6, 1e30] {
        for small in [0.0f32, 1e-30, 1e-3] {
            for d in [
                Footprint::new(small, 0.0, 0.0, big),
                Footprint::new(big, 0.0, 0.0, small),
                Footprint::new(big, big, small, small),
            ] {
                for filter in [Filter::Anisotropic(16), Filter::ewa(16), Filter::Trilinear] {
                    let c = sampler(filter).sample_grad(&texture, [0.3, 0.7], d);
                    bad += u32::from(!c.iter().all(|c| c.is_finite()));
                }
                probes = probes.max(most.probes(&texture, d));
                if small > 0.0 {
                    unbounded = unbounded.max(f64::from(big / small).ceil());
                }
            }
        }
    }
    let (mut own, mut other) = (0.0, 0.0);
    for _ in 0..400 {
        let (minor, ratio) = (random.range(0.5, 2.0), random.range(4.0, 200.0));
        let d = footprint(
            f64::from(SIDE),
            minor * ratio,
            minor,
            random.range(0.0, std::f64::consts::TAU),
            0.0,
        );
        let uv = [0, 1].map(|_| random.range(0.0, 1.0));
        let mut truth = 0.0;
        for i in 0..256 {
            for j in 0..8 {
                let (s, t) = (
                    (f64::from(i) + 0.5) / 256.0 - 0.5,
                    (f64::from(j) + 0.5) / 8.0 - 0.5,
                );
                let step = |x: f32, y: f32| f64::from(x) * s + f64::from(y) * t;
                truth += wave(
                    (uv[0] + step(d.du_dx, d.du_dy)) * f64::from(SIDE),
                    (uv[1] + step(d.dv_dx, d.dv_dy)) * f64::from(SIDE),
                );
            }
        }
        truth /= 2048.0;
        let error = |s: &Sampler| {
            let found = s.sample_grad(&texture, uv.map(|c| c as f32), d)[0];
            (f64::from(found) - truth).powi(2)
        };
        own += error(&most);
        other += error(&plain);
    }
    Ok(measured![
        "anisotropic:16, ewa:16, trilinear", "colours that are not finite" => bad.into();
        "anisotropic:16", "most probes of a look-up" => probes.into();
        "a probe for each unit of the ratio", "most probes of a look-up" => unbounded;
        "anisotropic:16", "RMSE at ratios to 200, of trilinear's" => (own / other).sqrt();
    ])
}

//! Perspective interpolation against the closed forms and the f64 reference (I1, I4, I6, R8).
use texmap_math::affine_error;
use texmap_math::glam::{DMat4, DVec3};
use texmap_raster::{BinnedDraws, DrawCall, Interp, NoAlphaTest, VisibilityBuffer, reference};

use crate::support::{Owned, Rng, fragments, free_w, size};

/// A quad over the whole target: w = 1 at its left side and `ratio` at its right one, u from 0 to 1.
pub(crate) fn ratio_quad(ratio: f64) -> Owned {
    let corner = |x: f64, y: f64, w: f64| [(x * w) as f32, (y * w) as f32, w as f32];
    Owned {
        positions: vec![
            corner(-1.0, -1.0, 1.0),
            corner(1.0, -1.0, ratio),
            corner(1.0, 1.0, ratio),
            corner(-1.0, 1.0, 1.0),
        ],
        indices: vec![[0, 1, 2], [0, 2, 3]],
        attributes: vec![0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0, 1.0],
        attribute_count: 2,
    }
}

/// Largest error of u over the target, in units of u.
pub(crate) fn worst_u(mesh: &Owned, interp: Interp, width: u32, height: u32, scale: f32) -> f64 {
    let target = size(width, height);
    let matrix = free_w(0.01);
    let draw = DrawCall {
        interp,
        interp_scale: scale,
        ..mesh.draw(matrix)
    };
    let prepared = BinnedDraws::new(target, &[draw]).expect("valid");
    let mut worst = 0.0_f64;
    let mut pixels = 0;
    fragments(&prepared, |triangle, x, y, f| {
        pixels += 1;
        let clip = mesh.clip(matrix, triangle as usize);
        let u = mesh.indices[triangle as usize].map(|i| f64::from(mesh.attributes[i as usize * 2]));
        let truth =
            reference::perspective(&clip, u, target, f64::from(x) + 0.5, f64::from(y) + 0.5);
        worst = worst.max((f64::from(f.values[0]) - truth.expect("seen")).abs());
    });
    assert!(pixels > 0);
    worst
}

#[test]
fn i1_perspective_is_exact_and_affine_equals_the_closed_form() {
    for (ratio, texels) in [(2.0, 175.7), (4.0, 341.0), (8.0, 489.0), (16.0, 614.0)] {
        let mesh = ratio_quad(ratio);
        let perspective = worst_u(&mesh, Interp::Perspective, 1024, 16, 1.0);
        assert!(
            perspective <= 1e-6,
            "ratio {ratio}: {perspective} of the range"
        );
        let affine = worst_u(&mesh, Interp::Affine, 1024, 16, 1.0) * 1024.0;
        let closed = affine_error::max_error(ratio) * 1024.0;
        assert!(
            (affine - closed).abs() <= 0.01 * closed,
            "ratio {ratio}: {affine} texels, closed form {closed}"
        );
        assert!(
            (affine - texels).abs() <= 0.01 * texels,
            "ratio {ratio}: {affine} texels, known {texels}"
        );
    }
}

/// The conformance quad w = (1.3, 0.8, 0.6, 2.0) at 256^2: within 1e-6 of the range, derivatives as well.
#[test]
fn conformance_quad() {
    let target = size(256, 256);
    let w = [1.3, 0.8, 0.6, 2.0];
    let at = [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)];
    let mesh = Owned {
        positions: (0..4)
            .map(|i| [at[i].0 * w[i], at[i].1 * w[i], w[i]])
            .collect(),
        indices: vec![[0, 1, 2], [1, 3, 2]],
        ..Owned::default()
    };
    for (lo, hi) in [
        (0.0_f32, 1.0_f32),
        (-1.0, 1.0),
        (-10.0, 10.0),
        (-3000.0, 5000.0),
        (-2f32.powi(125), 2f32.powi(125)),
    ] {
        let mut mesh = mesh.clone();
        mesh.attributes = vec![lo, hi, hi, lo];
        mesh.attribute_count = 1;
        let matrix = free_w(0.01);
        let prepared = BinnedDraws::new(target, &[mesh.draw(matrix)]).expect("valid");
        let range = f64::from(hi) - f64::from(lo);
        let mut count = 0;
        fragments(&prepared, |triangle, x, y, f| {
            count += 1;
            let clip = mesh.clip(matrix, triangle as usize);
            let values =
                mesh.indices[triangle as usize].map(|i| f64::from(mesh.attributes[i as usize]));
            let at = |dx: f64, dy: f64| {
                let (px, py) = (f64::from(x) + 0.5 + dx, f64::from(y) + 0.5 + dy);
                reference::perspective(&clip, values, target, px, py).expect("seen")
            };
            let error = (f64::from(f.values[0]) - at(0.0, 0.0)).abs() / range;
            assert!(error <= 1e-6, "{lo}..{hi} at {x}, {y}: {error}");
            let h = 1e-3;
            let slopes = [
                (at(h, 0.0) - at(-h, 0.0)) / (2.0 * h),
                (at(0.0, h) - at(0.0, -h)) / (2.0 * h),
            ];
            for (found, truth) in [f.ddx[0], f.ddy[0]].into_iter().zip(slopes) {
                let error = (f64::from(found) - truth).abs() / range;
                assert!(
                    error <= 1e-6,
                    "derivative of {lo}..{hi} at {x}, {y}: {error}"
                );
            }
        });
        assert_eq!(count, 256 * 256);
    }
}

/// I4: one vertex at w = 1e-3 to 1e-6.
#[test]
fn i4_vertex_close_to_the_eye() {
    let target = size(256, 256);
    for w in [1e-3_f64, 1e-4, 1e-5, 1e-6] {
        let corner = |x: f64, y: f64, w: f64| [(x * w) as f32, (y * w) as f32, w as f32];
        let mesh = Owned {
            positions: vec![
                corner(-1.0, -1.0, w),
                corner(1.0, -1.0, 1.0),
                corner(-1.0, 1.0, 1.0),
            ],
            indices: vec![[0, 1, 2]],
            attributes: vec![0.0, 1.0, 1.0],
            attribute_count: 1,
        };
        let matrix = free_w(1e-7);
        let prepared = BinnedDraws::new(target, &[mesh.draw(matrix)]).expect("valid");
        let mut worst = 0.0_f64;
        fragments(&prepared, |_, x, y, f| {
            let clip = mesh.clip(matrix, 0);
            let truth = reference::perspective(
                &clip,
                [0.0, 1.0, 1.0],
                target,
                f64::from(x) + 0.5,
                f64::from(y) + 0.5,
            );
            worst = worst.max((f64::from(f.values[0]) - truth.expect("seen")).abs() * 1024.0);
        });
        assert!(worst <= 0.1, "w = {w}: {worst} texels");
    }
}

/// I6: extreme and equal values neither overflow nor drift.
#[test]
fn i6_extreme_and_constant_attributes() {
    let target = size(96, 96);
    let huge = 2f32.powi(125);
    for values in [
        [huge, huge, huge],
        [-huge, huge, -huge],
        [f32::MAX, f32::MAX, f32::MAX],
        [1e-40, 3e-40, 2e-40],
        [f32::from_bits(1); 3],
        [0.1; 3],
        [-7.3; 3],
        [0.0; 3],
    ] {
        for near in [1.0, 1e-4] {
            let corner = |x: f64, y: f64, w: f64| [(x * w) as f32, (y * w) as f32, w as f32];
            let mesh = Owned {
                positions: vec![
                    corner(-0.9, -0.9, near),
                    corner(0.8, -0.7, 1.0),
                    corner(-0.1, 0.9, 3.0),
                ],
                indices: vec![[0, 1, 2]],
                attributes: values.to_vec(),
                attribute_count: 1,
            };
            let matrix = free_w(1e-6);
            let prepared = BinnedDraws::new(target, &[mesh.draw(matrix)]).expect("valid");
            let (lo, hi) = values.iter().fold((values[0], values[0]), |(lo, hi), &v| {
                (lo.min(v), hi.max(v))
            });
            fragments(&prepared, |_, x, y, f| {
                let v = f.values[0];
                assert!(v >= lo && v <= hi, "{v} outside {lo}..{hi}");
                if lo == hi {
                    assert_eq!(v.to_bits(), lo.to_bits());
                }
                assert!(f.ddx[0].is_finite() && f.ddy[0].is_finite());
                let clip = mesh.clip(matrix, 0);
                let truth = reference::perspective(
                    &clip,
                    values.map(f64::from),
                    target,
                    f64::from(x) + 0.5,
                    f64::from(y) + 0.5,
                );
                let size = f64::from(lo.abs().max(hi.abs()));
                let error = (f64::from(v) - truth.expect("seen")).abs();
                assert!(
                    error <= 1e-6 * size + 2e-45,
                    "{values:?}: {v} for {truth:?}"
                );
            });
        }
    }
}

/// Values stay in the hull and agree with the reference on random triangles, slivers among them (R5).
#[test]
fn values_stay_in_the_hull_and_near_the_reference() {
    let target = size(128, 96);
    for seed in 0..1500 {
        let mut rng = Rng::new(seed);
        let reach = rng.log_range(0.01, 30.0);
        let mut mesh = Owned {
            indices: vec![[0, 1, 2]],
            attribute_count: 1,
            ..Owned::default()
        };
        for _ in 0..3 {
            let w = rng.log_range(1.0 / 128.0, 128.0);
            let [x, y] = [0, 1].map(|_| rng.range(-reach, reach));
            mesh.positions
                .push([(x * w) as f32, (y * w) as f32, w as f32]);
            mesh.attributes.push(rng.range(-500.0, 500.0) as f32);
        }
        let matrix = free_w(0.001);
        let prepared = BinnedDraws::new(target, &[mesh.draw(matrix)]).expect("valid");
        let clip = mesh.clip(matrix, 0);
        let values = [0, 1, 2].map(|i| f64::from(mesh.attributes[i]));
        let (lo, hi) = (
            values[0].min(values[1]).min(values[2]),
            values[0].max(values[1]).max(values[2]),
        );
        fragments(&prepared, |_, x, y, f| {
            let v = f64::from(f.values[0]);
            assert!(v >= lo && v <= hi, "seed {seed}: {v} outside {lo}..{hi}");
            // Pixels that only the snapped triangle covers have no truth inside the hull: compare where it is inside.
            let b = reference::weights(&clip, target, f64::from(x) + 0.5, f64::from(y) + 0.5);
            if let Some(b) = b.filter(|b| b.iter().all(|&v| v >= 0.0)) {
                let truth = b[0] * values[0] + b[1] * values[1] + b[2] * values[2];
                let error = (v - truth).abs();
                assert!(
                    error <= 1e-6 * (hi - lo) + 4e-7 * lo.abs().max(hi.abs()),
                    "seed {seed} at {x}, {y}: {v} for {truth}"
                );
                let inv_w = b[0] + b[1] + b[2];
                let w = (b[0] * clip[0].w + b[1] * clip[1].w + b[2] * clip[2].w) / inv_w;
                assert!(
                    (f64::from(f.inv_w) * w - 1.0).abs() <= 1e-6,
                    "seed {seed}: 1/w {} for w {w}",
                    f.inv_w
                );
            }
        });
    }
}

/// R8: identical triangles have bit-equal depth; coplanar meshes cut differently agree within 2^-22.
#[test]
fn r8_coplanar_depth() {
    let target = size(160, 120);
    let camera = texmap_math::Camera {
        eye: DVec3::new(1.0, 1.5, 4.0),
        look: DVec3::ZERO,
        up: DVec3::Y,
        fov_x: 1.2,
        near: 0.1,
        far: 100.0,
        lens: Default::default(),
    };
    let matrix = camera.clip_from_world(160.0 / 120.0).expect("a camera");
    let corners = [
        [-3.0, 0.0, 3.0],
        [3.0, 0.0, 3.0],
        [3.0, 0.0, -3.0],
        [-3.0, 0.0, -3.0],
    ];
    let mesh = |indices: Vec<[u32; 3]>| Owned {
        positions: corners.to_vec(),
        indices,
        ..Owned::default()
    };
    let one = mesh(vec![[0, 1, 2], [0, 2, 3]]);
    let turned = mesh(vec![[1, 2, 0], [2, 3, 0]]);
    let other = mesh(vec![[0, 1, 3], [1, 2, 3]]);
    let depth = |mesh: &Owned| {
        let prepared = BinnedDraws::new(target, &[mesh.draw(matrix)]).expect("valid");
        let mut all = Vec::new();
        let mut buffers = VisibilityBuffer::new();
        for tile in 0..prepared.tiles() {
            prepared.visible(tile, &NoAlphaTest, &mut buffers);
            all.extend_from_slice(&buffers.depth);
        }
        all
    };
    let (a, b, c) = (depth(&one), depth(&turned), depth(&other));
    assert!(a.iter().any(|&d| d > 0.0));
    assert_eq!(depth(&one), a, "the same triangles");
    for k in 0..a.len() {
        assert!(
            (a[k] - b[k]).abs() <= 2f32.powi(-22),
            "turned: {} {}",
            a[k],
            b[k]
        );
        assert!(
            (a[k] - c[k]).abs() <= 2f32.powi(-22),
            "other diagonal: {} {}",
            a[k],
            c[k]
        );
    }
}

/// Planes through snapped vertices would miss this by 5 to 500 times: a sub-pixel triangle's uv at a far pixel corner.
#[test]
fn attributes_come_from_unsnapped_vertices() {
    let target = size(64, 64);
    // 3 x 3 pixels, corners far from multiples of 1/256 pixel.
    let at = |x: f64, y: f64| [((x / 32.0) - 1.0) as f32, (1.0 - y / 32.0) as f32, 0.5];
    let e = 0.498 / 256.0;
    let mesh = Owned {
        positions: vec![
            at(10.0 + e, 10.0 + e),
            at(13.0 - e, 10.0 + e),
            at(10.0 + e, 13.0 - e),
        ],
        indices: vec![[0, 1, 2]],
        attributes: vec![0.0, 1024.0, 0.0],
        attribute_count: 1,
    };
    let prepared = BinnedDraws::new(target, &[mesh.draw(DMat4::IDENTITY)]).expect("valid");
    let clip = mesh.clip(DMat4::IDENTITY, 0);
    let mut count = 0;
    fragments(&prepared, |_, x, y, f| {
        count += 1;
        let truth = reference::affine(
            &clip,
            [0.0, 1024.0, 0.0],
            target,
            f64::from(x) + 0.5,
            f64::from(y) + 0.5,
        );
        let error = (f64::from(f.values[0]) - truth.expect("seen")).abs();
        assert!(error <= 0.01, "{error} texels");
    });
    assert!(count >= 3);
}

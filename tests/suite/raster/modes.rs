//! The named interpolations: spans, controlled error, subdivision, Gouraud (I2, I3, R7).
use texmap_math::glam::{DMat4, DVec3};
use texmap_raster::{BinnedDraws, DrawCall, Interp, reference};

use crate::interpolation::{ratio_quad, worst_u};
use crate::support::{Owned, Rng, fragments, free_w, size};

/// I2: sixteen equal spans have the known errors, and their bound r (r - 1) / (4 n^2).
#[test]
fn i2_equal_spans_report_their_error() {
    for (ratio, texels) in [(2.0, 1.8), (4.0, 9.3), (8.0, 32.0), (16.0, 87.0)] {
        let found = worst_u(&ratio_quad(ratio), Interp::Span(64), 1025, 8, 1.0) * 1024.0;
        assert!(
            (found - texels).abs() <= 0.06 * texels,
            "ratio {ratio}: {found} texels, known {texels}"
        );
        assert!(found <= 1024.0 * ratio * (ratio - 1.0) / (4.0 * 16.0 * 16.0));
        let exact = worst_u(&ratio_quad(ratio), Interp::Span(1), 1025, 8, 1.0);
        assert!(exact <= 1e-6, "spans of one pixel: {exact}");
    }
}

/// I2: the controlled mode keeps its budget on every pixel, and does use it.
#[test]
fn i2_controlled_spans_keep_their_budget() {
    for ratio in [1.02, 2.0, 4.0, 16.0, 64.0] {
        for budget in [0.25, 0.5, 4.0] {
            let found = worst_u(
                &ratio_quad(ratio),
                Interp::WithinError(budget),
                1024,
                8,
                1024.0,
            ) * 1024.0;
            assert!(
                found <= f64::from(budget),
                "ratio {ratio}, budget {budget}: {found}"
            );
            if ratio > 1.5 {
                assert!(
                    found > 0.2 * f64::from(budget),
                    "ratio {ratio}, budget {budget}: only {found} used"
                );
            }
        }
    }
}

#[test]
fn controlled_spans_keep_their_budget_on_random_triangles() {
    let target = size(200, 120);
    let budget = 0.01;
    for seed in 0..200 {
        let mut rng = Rng::new(seed);
        let mut mesh = Owned {
            indices: vec![[0, 1, 2]],
            attribute_count: 2,
            ..Owned::default()
        };
        for _ in 0..3 {
            let w = rng.log_range(0.1, 10.0);
            mesh.positions.push([
                (rng.range(-2.0, 2.0) * w) as f32,
                (rng.range(-2.0, 2.0) * w) as f32,
                w as f32,
            ]);
            mesh.attributes
                .extend([rng.range(-1.0, 1.0) as f32, rng.range(0.0, 9.0) as f32]);
        }
        let matrix = free_w(0.01);
        let draw = DrawCall {
            interp: Interp::WithinError(budget),
            ..mesh.draw(matrix)
        };
        let prepared = BinnedDraws::new(target, &[draw]).expect("valid");
        let clip = mesh.clip(matrix, 0);
        fragments(&prepared, |_, x, y, f| {
            let (px, py) = (f64::from(x) + 0.5, f64::from(y) + 0.5);
            let Some(b) =
                reference::weights(&clip, target, px, py).filter(|b| b.iter().all(|&v| v >= 0.0))
            else {
                return;
            };
            for k in 0..2 {
                let truth: f64 = (0..3)
                    .map(|i| b[i] * f64::from(mesh.attributes[i * 2 + k]))
                    .sum();
                let error = (f64::from(f.values[k]) - truth).abs();
                assert!(
                    error <= f64::from(budget) + 1e-5,
                    "seed {seed} at {x}, {y}: {error}"
                );
            }
        });
    }
}

/// Subdividing into n parts in space divides the affine error by about n^2: at most |du| (r - 1) / (4 n^2).
#[test]
fn subdivision_error_falls_as_the_square() {
    for ratio in [2.0, 4.0] {
        let mesh = ratio_quad(ratio);
        for parts in [1, 2, 4, 8] {
            let found = worst_u(&mesh, Interp::Subdivided(parts), 512, 64, 1.0);
            let bound = (ratio - 1.0) / f64::from(4 * parts * parts);
            assert!(
                found <= bound.min(1.0) + 1e-6,
                "ratio {ratio}, {parts} parts: {found}, bound {bound}"
            );
            assert!(
                found > 0.2 * bound,
                "ratio {ratio}, {parts} parts: {found} is too good for affine, bound {bound}"
            );
        }
    }
}

/// A Gouraud attribute is screen-linear while the others are not; both within one draw.
#[test]
fn gouraud_is_screen_linear() {
    let target = size(128, 32);
    let mut mesh = ratio_quad(4.0);
    mesh.attributes = vec![0.0, 0.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0];
    let matrix = free_w(0.01);
    let draw = DrawCall {
        screen_linear: 0b10,
        ..mesh.draw(matrix)
    };
    let prepared = BinnedDraws::new(target, &[draw]).expect("valid");
    let mut largest = 0.0_f64;
    fragments(&prepared, |triangle, x, y, f| {
        let clip = mesh.clip(matrix, triangle as usize);
        let u = mesh.indices[triangle as usize].map(|i| f64::from(mesh.attributes[i as usize * 2]));
        let (px, py) = (f64::from(x) + 0.5, f64::from(y) + 0.5);
        let truth = [
            reference::perspective(&clip, u, target, px, py),
            reference::affine(&clip, u, target, px, py),
        ];
        for (value, truth) in f.values.into_iter().zip(truth) {
            assert!((f64::from(value) - truth.expect("seen")).abs() < 1e-6);
        }
        largest = largest.max(f64::from((f.values[0] - f.values[1]).abs()));
    });
    assert!((largest - 1.0 / 3.0).abs() < 0.01, "{largest}");
}

/// A screen-linear attribute of a triangle that is cut at the near plane takes the values of the cut corners.
#[test]
fn screen_linear_attributes_are_cut_in_clip_space() {
    let target = size(64, 64);
    let camera = texmap_math::Camera {
        eye: DVec3::new(0.0, 1.0, 0.0),
        look: DVec3::new(0.0, 1.0, -1.0),
        up: DVec3::Y,
        fov_x: 1.5,
        near: 0.5,
        far: f64::INFINITY,
        lens: Default::default(),
    };
    let matrix = camera.clip_from_world(1.0).expect("a camera");
    // A floor strip from behind the eye to z = -8; the attribute is -z, so it is 0.5 at the near plane.
    let mesh = Owned {
        positions: vec![[-1.0, 0.0, 4.0], [1.0, 0.0, 4.0], [0.0, 0.0, -8.0]],
        indices: vec![[0, 1, 2]],
        attributes: vec![-4.0, -4.0, 8.0],
        attribute_count: 1,
    };
    for interp in [Interp::Affine, Interp::Perspective] {
        let prepared = BinnedDraws::new(
            target,
            &[DrawCall {
                interp,
                ..mesh.draw(matrix)
            }],
        )
        .expect("valid");
        assert_eq!(prepared.stats().clipped, 1);
        let (mut lo, mut hi, mut worst) = (f64::MAX, f64::MIN, 0.0_f64);
        fragments(&prepared, |_, x, y, f| {
            let v = f64::from(f.values[0]);
            (lo, hi) = (lo.min(v), hi.max(v));
            let ray = camera
                .ray(64, 64, f64::from(x) + 0.5, f64::from(y) + 0.5)
                .expect("a camera");
            worst = worst.max((v - ray.z / ray.y).abs());
        });
        assert!(lo >= 0.5 - 1e-5 && hi <= 8.0, "{interp:?}: {lo}..{hi}");
        match interp {
            Interp::Affine => assert!(worst > 0.5, "affine is too good: {worst}"),
            _ => assert!(worst < 1e-4, "{worst}"),
        }
    }
}

/// The modes agree where they must: w equal at all vertices makes affine, spans and subdivision exact.
#[test]
fn equal_w_makes_every_mode_exact() {
    let target = size(100, 60);
    let mut rng = Rng::new(3);
    let mesh = Owned {
        positions: (0..3)
            .map(|_| {
                [
                    rng.range(-1.5, 1.5) as f32,
                    rng.range(-1.5, 1.5) as f32,
                    0.5,
                ]
            })
            .collect(),
        indices: vec![[0, 1, 2]],
        attributes: vec![0.0, 1.0, 3.0, -1.0, 0.5, 0.25],
        attribute_count: 2,
    };
    for interp in [
        Interp::Perspective,
        Interp::Affine,
        Interp::Subdivided(3),
        Interp::Span(7),
        Interp::WithinError(0.5),
    ] {
        let prepared = BinnedDraws::new(
            target,
            &[DrawCall {
                interp,
                ..mesh.draw(DMat4::IDENTITY)
            }],
        )
        .expect("valid");
        let clip = mesh.clip(DMat4::IDENTITY, 0);
        fragments(&prepared, |_, x, y, f| {
            let values = [0, 1, 2].map(|i| f64::from(mesh.attributes[i * 2]));
            let truth = reference::perspective(
                &clip,
                values,
                target,
                f64::from(x) + 0.5,
                f64::from(y) + 0.5,
            );
            assert!(
                (f64::from(f.values[0]) - truth.expect("seen")).abs() < 2e-6,
                "{interp:?}"
            );
        });
    }
}

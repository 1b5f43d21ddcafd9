//! Bad input: named errors, counted drops, no panic and no NaN (R5).
use texmap_math::glam::DMat4;
use texmap_raster::reference;
use texmap_raster::{
    BinnedDraws, Cull, DepthTest, DrawCall, Interp, NoAlphaTest, Pass, RasterError, TargetSize,
    VisibilityBuffer,
};

use crate::support::{Owned, Rng, fragments, free_w, hits, size};

fn triangle() -> Owned {
    Owned {
        positions: vec![[-1.0, -1.0, 0.5], [1.0, -1.0, 0.5], [-1.0, 1.0, 0.5]],
        indices: vec![[0, 1, 2]],
        ..Owned::default()
    }
    .with_uv(|[x, y, _]| [x, y])
}

fn refusal(draw: DrawCall<'_>) -> RasterError {
    BinnedDraws::new(size(8, 8), &[DrawCall::default(), draw]).expect_err("refused")
}

#[test]
fn wrong_draws_are_refused_by_name() {
    assert_eq!(
        TargetSize::new(0, 5),
        Err(RasterError::ZeroTarget {
            width: 0,
            height: 5
        })
    );
    assert_eq!(
        TargetSize::new(5, 16385),
        Err(RasterError::TargetTooLarge {
            width: 5,
            height: 16385
        })
    );
    let mesh = triangle();
    let good = mesh.draw(DMat4::IDENTITY);
    let bad = [[0, 1, 2], [0, 3, 1]];
    assert_eq!(
        refusal(DrawCall {
            indices: &bad,
            ..good
        }),
        RasterError::IndexOutOfRange {
            draw: 1,
            triangle: 1,
            index: 3,
            vertices: 3
        }
    );
    assert_eq!(
        refusal(DrawCall {
            attributes: &mesh.attributes[..5],
            ..good
        }),
        RasterError::AttributeLength {
            draw: 1,
            expected: 6,
            found: 5
        }
    );
    assert_eq!(
        refusal(DrawCall {
            attribute_count: 21,
            ..good
        }),
        RasterError::TooManyAttributes { draw: 1, count: 21 }
    );
    for parts in [0, 257] {
        assert_eq!(
            refusal(DrawCall {
                interp: Interp::Subdivided(parts),
                ..good
            }),
            RasterError::Parts { draw: 1, parts }
        );
    }
    assert_eq!(
        refusal(DrawCall {
            interp: Interp::Span(0),
            ..good
        }),
        RasterError::ZeroSpan { draw: 1 }
    );
    for tolerance in [0.0, -1.0, f32::INFINITY] {
        assert_eq!(
            refusal(DrawCall {
                interp: Interp::WithinError(tolerance),
                ..good
            }),
            RasterError::Tolerance {
                draw: 1,
                tolerance,
                scale: 1.0
            }
        );
    }
    let text = refusal(DrawCall {
        indices: &bad,
        ..good
    })
    .to_string();
    assert_eq!(
        text,
        "draw 1, triangle 1: vertex index 3 is out of range, there are 3 vertices"
    );
}

#[test]
fn non_finite_vertices_drop_their_triangle_alone() {
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        for place in 0..5 {
            let mut mesh = triangle();
            mesh.positions.push([0.5, 0.5, 0.5]);
            mesh.attributes.extend([0.5, 0.5]);
            mesh.indices.push([1, 3, 2]);
            let expected = hits(size(16, 16), &[mesh.draw(DMat4::IDENTITY)]);
            if place < 3 {
                mesh.positions[3][place] = bad;
            } else {
                mesh.attributes[6 + place - 3] = bad;
            }
            let draw = mesh.draw(DMat4::IDENTITY);
            let prepared = BinnedDraws::new(size(16, 16), &[draw]).expect("counted, not refused");
            assert_eq!(
                (prepared.stats().submitted, prepared.stats().non_finite),
                (2, 1)
            );
            let found = hits(size(16, 16), &[draw]);
            let lone = hits(
                size(16, 16),
                &[DrawCall {
                    indices: &mesh.indices[..1],
                    ..draw
                }],
            );
            assert_eq!(found, lone);
            assert_ne!(found, expected);
        }
    }
    let mesh = triangle();
    let overflow = DMat4::from_diagonal(texmap_math::glam::DVec4::splat(1e300));
    let prepared =
        BinnedDraws::new(size(16, 16), &[mesh.draw(overflow)]).expect("counted, not refused");
    assert_eq!(prepared.stats().non_finite, 1);
}

#[test]
fn triangles_without_area_are_dropped_and_slivers_are_not() {
    let at = |x: f64, y: f64| [(x / 1024.0 - 1.0) as f32, (1.0 - y / 16.0) as f32, 0.5];
    let target = size(2048, 32);
    let degenerate = Owned {
        positions: vec![at(3.0, 3.0), at(30.0, 3.0), at(2000.0, 3.0)],
        indices: vec![[0, 1, 2], [0, 0, 1], [2, 2, 2]],
        ..Owned::default()
    };
    let prepared = BinnedDraws::new(target, &[degenerate.draw(DMat4::IDENTITY)]).expect("valid");
    assert_eq!(
        (prepared.stats().degenerate, prepared.stats().binned),
        (3, 0)
    );
    // 2000 px x 0.01 px, across pixel centres.
    let sliver = Owned {
        positions: vec![at(10.0, 10.0), at(2010.0, 11.0), at(2010.0, 11.01)],
        indices: vec![[0, 1, 2]],
        ..Owned::default()
    }
    .with_uv(|[x, y, _]| [x, y]);
    let prepared = BinnedDraws::new(target, &[sliver.draw(DMat4::IDENTITY)]).expect("valid");
    let mut count = 0;
    fragments(&prepared, |_, _, _, f| {
        count += 1;
        for k in 0..2 {
            let v = [0, 1, 2].map(|i| sliver.attributes[i * 2 + k]);
            let (lo, hi) = (v[0].min(v[1]).min(v[2]), v[0].max(v[1]).max(v[2]));
            assert!(f.values[k] >= lo && f.values[k] <= hi);
        }
    });
    assert!(count > 0);
}

#[test]
fn culling_goes_by_the_side_seen() {
    let mesh = triangle();
    let count = |cull, flip: bool| {
        let mut mesh = mesh.clone();
        if flip {
            mesh.indices[0].reverse();
        }
        let draw = DrawCall {
            cull,
            ..mesh.draw(DMat4::IDENTITY)
        };
        let mut front = None;
        let prepared = BinnedDraws::new(size(8, 8), &[draw]).expect("valid");
        fragments(&prepared, |_, _, _, f| front = Some(f.front));
        front
    };
    assert_eq!(count(Cull::None, false), Some(true));
    assert_eq!(count(Cull::None, true), Some(false));
    assert_eq!(count(Cull::Back, false), Some(true));
    assert_eq!(count(Cull::Back, true), None);
    assert_eq!(count(Cull::Front, false), None);
    assert_eq!(count(Cull::Front, true), Some(false));
}

#[test]
fn equal_depth_goes_to_the_first_or_the_last() {
    let mesh = triangle();
    for (test, winner) in [
        (DepthTest::Less, 0),
        (DepthTest::LessOrEqual, 2),
        (DepthTest::Always, 2),
    ] {
        let draw = DrawCall {
            depth_test: test,
            ..mesh.draw(DMat4::IDENTITY)
        };
        let prepared = BinnedDraws::new(size(8, 8), &[draw, draw, draw]).expect("valid");
        let mut buffers = VisibilityBuffer::new();
        prepared.visible(0, &NoAlphaTest, &mut buffers);
        assert_eq!(prepared.source(buffers.id[7 * 64]), (winner, 0));
    }
}

/// Ten thousand random meshes, hostile vertices among them: no panic, no NaN, nothing outside the hulls.
#[test]
fn hostile_meshes() {
    let special = [
        0.0,
        -0.0,
        1e-30,
        -1e-30,
        1e30,
        -1e30,
        f32::MAX,
        f32::MIN_POSITIVE,
        f32::NAN,
        f32::INFINITY,
        1e-45,
        3e4,
    ];
    let target = size(40, 70);
    for seed in 0..10_000 {
        let mut rng = Rng::new(seed);
        let mut mesh = Owned {
            attribute_count: 2,
            ..Owned::default()
        };
        let vertices = 3 + rng.bits() % 6;
        for _ in 0..vertices {
            let mut value = || {
                if rng.bits().is_multiple_of(8) {
                    special[rng.bits() as usize % special.len()]
                } else {
                    (rng.range(-1.0, 1.0) * rng.log_range(1e-6, 1e6)) as f32
                }
            };
            mesh.positions.push([value(), value(), value()]);
            mesh.attributes.extend([value(), value()]);
        }
        for _ in 0..4 {
            mesh.indices.push([0; 3].map(|_| rng.bits() % vertices));
        }
        let interp = match seed % 5 {
            0 => Interp::Perspective,
            1 => Interp::Affine,
            2 => Interp::Subdivided(1 + rng.bits() % 5),
            3 => Interp::Span(1 + rng.bits() % 9),
            _ => Interp::WithinError(rng.log_range(1e-3, 10.0) as f32),
        };
        let pass = if seed % 3 == 0 {
            Pass::CutOut
        } else {
            Pass::Opaque
        };
        let draw = DrawCall {
            interp,
            pass,
            ..mesh.draw(free_w(rng.log_range(1e-6, 1.0)))
        };
        let prepared = BinnedDraws::new(target, &[draw]).expect("valid");
        fragments(&prepared, |triangle, _, _, f| {
            for k in 0..2 {
                let v =
                    mesh.indices[triangle as usize].map(|i| mesh.attributes[i as usize * 2 + k]);
                let (lo, hi) = (v[0].min(v[1]).min(v[2]), v[0].max(v[1]).max(v[2]));
                assert!(
                    f.values[k] >= lo && f.values[k] <= hi,
                    "seed {seed}: {} of {v:?}",
                    f.values[k]
                );
                assert!(f.ddx[k].is_finite() && f.ddy[k].is_finite(), "seed {seed}");
            }
            assert!(
                f.inv_w > 0.0 && f.inv_w <= f32::MAX,
                "seed {seed}: 1/w {}",
                f.inv_w
            );
            assert!(
                (0.0..=1.0).contains(&f.depth),
                "seed {seed}: depth {}",
                f.depth
            );
        });
    }
}

/// Ten thousand random meshes of huge, tiny, sliver and non-finite triangles, some behind the eye. A pixel is covered
/// exactly where the reference says so. A triangle that crosses the eye's plane, or reaches so far out that it is clipped, is cut
/// before it is snapped: it is held against the seen side of its edges in f64, away from them.
#[test]
fn coverage_of_hostile_meshes_is_the_references() {
    let target = size(20, 70);
    let (mut snapped, mut cut, mut covered, mut behind) = (0, 0, 0, 0);
    for seed in 0..10_000 {
        let mut rng = Rng::new(seed);
        let mut mesh = Owned::default();
        // In pixels around the target: from a thousandth of one to a million.
        let spread = rng.log_range(1e-3, 1e6);
        let middle = [rng.range(-1.2, 1.2), rng.range(-1.2, 1.2)];
        for corner in 0..6 {
            let w = match rng.bits() % 6 {
                0 => rng.log_range(1e-4, 1e4),
                1 if seed % 3 == 0 => -rng.log_range(1e-3, 1e2),
                _ => 1.0,
            };
            let mut place = |middle: f64| middle + rng.range(-1.0, 1.0) * spread / 35.0;
            let (mut x, mut y) = (place(middle[0]), place(middle[1]));
            if corner == 2 {
                // A sliver: almost on the line of the first two.
                let [a, b] = [mesh.positions[0], mesh.positions[1]].map(|p| p.map(f64::from));
                let t = rng.range(-0.5, 1.5);
                let on = |k: usize| a[k] / a[2] + (b[k] / b[2] - a[k] / a[2]) * t;
                (x, y) = (on(0) + rng.range(-0.001, 0.001), on(1));
            }
            let mut p = [x * w, y * w, w].map(|c| c as f32);
            if rng.bits().is_multiple_of(40) {
                p[rng.bits() as usize % 3] =
                    [f32::NAN, f32::INFINITY, f32::NEG_INFINITY][rng.bits() as usize % 3];
            }
            mesh.positions.push(p);
        }
        mesh.indices = vec![[0, 1, 2], [3, 4, 5], [2, 1, 5], [0, 0, 4]];
        let matrix = free_w(1e-5);
        let found: Vec<Vec<u32>> = mesh
            .indices
            .iter()
            .map(|t| {
                let draw = DrawCall {
                    indices: std::slice::from_ref(t),
                    ..mesh.draw(matrix)
                };
                hits(target, &[draw])
            })
            .collect();
        for (t, found) in found.iter().enumerate() {
            let clip = mesh.clip(matrix, t);
            let finite = clip.iter().all(|v| v.is_finite());
            let corners = clip.map(|v| reference::snap(v, target));
            let near = clip.iter().all(|v| {
                // Within the guard band nothing is clipped.
                v.w > 0.0
                    && v.z >= 0.0
                    && v.z <= v.w
                    && v.x.abs() < 3000.0 * v.w
                    && v.y.abs() < 900.0 * v.w
            });
            behind += usize::from(finite && clip.iter().any(|v| v.w < 0.0));
            for (at, &count) in found.iter().enumerate() {
                let (x, y) = (at as i32 % 20, at as i32 / 20);
                assert!(
                    count <= 1,
                    "seed {seed}, face {t}: pixel {x}, {y} is hit {count} times"
                );
                if !finite {
                    assert_eq!(count, 0, "seed {seed}, face {t}: a vertex is not finite");
                } else if let ([Some(a), Some(b), Some(c)], true) = (corners, near) {
                    let expected = reference::covers([a, b, c], x, y);
                    assert_eq!(
                        count == 1,
                        expected,
                        "seed {seed}, face {t}: pixel {x}, {y}"
                    );
                    snapped += 1;
                    covered += usize::from(expected);
                } else if let Some(expected) = seen(&clip, target, x, y) {
                    assert_eq!(
                        count == 1,
                        expected,
                        "seed {seed}, face {t}: pixel {x}, {y}"
                    );
                    cut += 1;
                    covered += usize::from(expected);
                }
            }
        }
    }
    // Each kind is there.
    assert!(snapped > 10_000_000 && cut > 10_000_000, "{snapped} {cut}");
    assert!(covered > 1_000_000 && behind > 1_000, "{covered} {behind}");
}

/// True if the centre of a pixel lies in a triangle of which any part may be behind the eye. `None` near an edge, near
/// the planes of depth, or where f64 cannot say.
fn seen(clip: &[texmap_math::glam::DVec4; 3], target: TargetSize, x: i32, y: i32) -> Option<bool> {
    let (px, py) = (f64::from(x) + 0.5, f64::from(y) + 0.5);
    // Signs of the weights, whether the point lies in front of the eye, and between the planes of depth.
    let signs = |x: f64, y: f64| -> Option<[bool; 5]> {
        let b = reference::weights(clip, target, x, y)?;
        let w: f64 = b.iter().zip(clip).map(|(b, v)| b * v.w).sum();
        let z: f64 = b.iter().zip(clip).map(|(b, v)| b * v.z).sum();
        let [a, b, c] = b.map(|v| v >= 0.0);
        (w.is_finite() && z.is_finite()).then_some([a, b, c, w > 0.0, z >= 0.0 && z <= w])
    };
    let centre = signs(px, py)?;
    for (dx, dy) in [(-0.05, 0.0), (0.05, 0.0), (0.0, -0.05), (0.0, 0.05)] {
        if signs(px + dx, py + dy)? != centre {
            return None;
        }
    }
    Some(centre == [true; 5])
}

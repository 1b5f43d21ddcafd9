//! Each pixel of a shared-edge mesh is hit exactly once (R1 to R4, R7).
use texmap_math::deterministic_f64::sin_cos;
use texmap_math::glam::{DMat4, DVec3};
use texmap_raster::{DrawCall, Interp, reference};

use crate::support::{Owned, Rng, free_w, hits, jittered_grid, size};

fn assert_once(count: &[u32], what: &str) {
    let holes = count.iter().filter(|&&c| c == 0).count();
    let doubles = count.iter().filter(|&&c| c > 1).count();
    assert_eq!((holes, doubles), (0, 0), "{what}: (holes, double hits)");
}

/// Gives each vertex its own w while it stays where it is on the screen.
fn with_random_w(mesh: &mut Owned, rng: &mut Rng) {
    for p in &mut mesh.positions {
        let w = rng.log_range(0.1, 4.0) as f32;
        *p = [p[0] * w, p[1] * w, w];
    }
}

#[test]
fn a_thousand_random_meshes_leave_no_crack_and_hit_nothing_twice() {
    let target = size(100, 70);
    for seed in 0..1000 {
        let mut rng = Rng::new(seed);
        let n = 1 + rng.bits() % 24;
        let mut mesh = jittered_grid(&mut rng, n);
        // Covers the target also when turned; every fourth mesh reaches far beyond the fixed-point range and is cut.
        let scale = if seed % 4 == 0 {
            rng.log_range(100.0, 20_000.0)
        } else {
            rng.range(4.0, 8.0)
        };
        let (sin, cos) = sin_cos(rng.range(0.0, 6.3));
        // A quarter of a pixel's multiples put vertices and edges onto pixel centres.
        let shift = [
            rng.range(-60.0, 60.0).floor(),
            rng.range(-30.0, 30.0).floor(),
        ];
        for p in &mut mesh.positions {
            let [x, y] = [f64::from(p[0]) * scale, f64::from(p[1]) * scale];
            *p = [
                (x * cos - y * sin + shift[0] * 0.02) as f32,
                (x * sin + y * cos + shift[1] * (2.0 / 70.0)) as f32,
                0.5,
            ];
        }
        let matrix = if seed % 2 == 0 {
            DMat4::IDENTITY
        } else {
            with_random_w(&mut mesh, &mut rng);
            free_w(0.01)
        };
        assert_once(
            &hits(target, &[mesh.draw(matrix)]),
            &format!("seed {seed}, n {n}, scale {scale}"),
        );
    }
}

/// Integer and half-integer pixel positions: every edge runs through centres.
#[test]
fn vertices_on_pixel_centres_and_corners_are_owned_once() {
    let target = size(64, 64);
    for seed in 0..200 {
        let mut rng = Rng::new(seed);
        let mut mesh = jittered_grid(&mut rng, 8);
        let place = |v: f32| {
            let half_pixels = ((f64::from(v) + 1.0) * 64.0).round();
            (half_pixels / 64.0 - 1.0) as f32
        };
        for p in &mut mesh.positions {
            *p = [place(p[0]), place(p[1]), 0.5];
        }
        assert_once(
            &hits(target, &[mesh.draw(DMat4::IDENTITY)]),
            &format!("seed {seed}"),
        );
    }
}

/// R1: a fan over the whole viewport whose vertices lie 30,000 pixels outside.
#[test]
fn r1_fan_with_far_vertices() {
    let target = size(640, 480);
    let mut mesh = Owned {
        positions: vec![[0.013, -0.007, 0.5]],
        ..Owned::default()
    };
    let n = 61;
    for i in 0..n {
        let (sin, cos) = sin_cos(f64::from(i) * std::f64::consts::TAU / f64::from(n));
        mesh.positions.push([
            (cos * 30_000.0 / 320.0) as f32,
            (sin * 30_000.0 / 320.0) as f32,
            0.5,
        ]);
        mesh.indices.push([0, 1 + i, 1 + (i + 1) % n]);
    }
    assert_once(&hits(target, &[mesh.draw(DMat4::IDENTITY)]), "fan");
}

/// R2: moving by whole pixels moves the coverage and nothing else.
#[test]
fn r2_translation_by_whole_pixels() {
    let mut rng = Rng::new(7);
    let near = size(4200, 40);
    let mesh = jittered_grid(&mut rng, 9);
    // 32 x 32 pixels at the left end, in exact steps of 1/4096 NDC; the target is 4200 wide, so use pixel maths.
    let place = |shift: f64| {
        let mut moved = mesh.clone();
        for p in &mut moved.positions {
            let x = 20.0 + f64::from(p[0]) * 16.0 + shift;
            let y = 20.0 + f64::from(p[1]) * 16.0;
            *p = [x as f32, y as f32, 0.5];
        }
        // Pixels to clip space.
        let to_clip = DMat4::from_translation(DVec3::new(-1.0, 1.0, 0.0))
            * DMat4::from_scale(DVec3::new(2.0 / 4200.0, -2.0 / 40.0, 1.0));
        (moved, to_clip)
    };
    // f32 pixel positions near 4000 hold 1/4096 pixel: round both to that first.
    let snap_input = |mut m: Owned| {
        for p in &mut m.positions {
            p[0] = (p[0] * 1024.0).round() / 1024.0;
            p[1] = (p[1] * 1024.0).round() / 1024.0;
        }
        m
    };
    let (here, matrix) = place(0.0);
    let here = snap_input(here);
    let mut there = here.clone();
    for p in &mut there.positions {
        p[0] += 4000.0;
    }
    let (a, b) = (
        hits(near, &[here.draw(matrix)]),
        hits(near, &[there.draw(matrix)]),
    );
    for y in 0..40 {
        for x in 0..40 {
            assert_eq!(a[y * 4200 + x], b[y * 4200 + x + 4000], "pixel {x}, {y}");
        }
    }
    assert_eq!(a.iter().sum::<u32>(), 32 * 32);
}

/// R3: edges as long as the fixed-point range, under overflow checks.
#[test]
fn r3_longest_edges_do_not_overflow() {
    let target = size(64, 64);
    let reach = 32_000.0 / 32.0;
    let quad = Owned {
        positions: vec![
            [-reach, -reach, 0.5],
            [reach, -reach, 0.5],
            [reach, reach, 0.5],
            [-reach, reach, 0.5],
        ],
        indices: vec![[0, 1, 2], [0, 2, 3]],
        ..Owned::default()
    };
    assert_once(&hits(target, &[quad.draw(DMat4::IDENTITY)]), "largest quad");
    let wide = size(16_384, 1);
    assert_once(&hits(wide, &[quad.draw(DMat4::IDENTITY)]), "widest target");
}

/// R4: the fill-rule set of the Khronos conformance tests: quads of 4x4 cells at 32 rotations, forward, reversed, and with
/// w in 0.1..4, and quads over the whole viewport: nothing drawn twice, and no hole.
#[test]
fn r4_fill_rule_set() {
    let target = size(128, 128);
    for step in 0..32_u32 {
        let (sin, cos) = sin_cos(f64::from(step) * std::f64::consts::TAU / 32.0);
        for (half, full) in [(0.15, false), (1.5, true)] {
            for variant in 0..3 {
                let mut rng = Rng::new(u64::from(step * 8 + variant));
                let mut mesh = Owned::default();
                for j in 0..5 {
                    for i in 0..5 {
                        let [x, y] = [i, j].map(|k| (f64::from(k) / 2.0 - 1.0) * half);
                        mesh.positions.push([
                            (x * cos - y * sin) as f32,
                            (x * sin + y * cos) as f32,
                            0.5,
                        ]);
                    }
                }
                for j in 0..4 {
                    for i in 0..4 {
                        let a = j * 5 + i;
                        mesh.indices.push([a, a + 1, a + 6]);
                        mesh.indices.push([a, a + 6, a + 5]);
                    }
                }
                let mut matrix = DMat4::IDENTITY;
                if variant == 1 {
                    mesh.indices.iter_mut().for_each(|t| t.reverse());
                } else if variant == 2 {
                    with_random_w(&mut mesh, &mut rng);
                    matrix = free_w(0.01);
                }
                let count = hits(target, &[mesh.draw(matrix)]);
                let what = format!("rotation {step}, half side {half}, variant {variant}");
                if full {
                    assert_once(&count, &what);
                } else {
                    assert!(
                        count.iter().all(|&c| c <= 1),
                        "{what}: a pixel is drawn twice"
                    );
                    let covered = count.iter().sum::<u32>();
                    let area = (0.3 * 64.0 * 0.3 * 64.0) as u32;
                    assert!(
                        covered.abs_diff(area) <= 40,
                        "{what}: {covered} pixels, area {area}"
                    );
                }
            }
        }
    }
}

/// R7: a T-junction cracks (the negative twin), and subdivision makes none: all parts of a side are the same for both neighbours.
#[test]
fn r7_subdivision_makes_no_t_joint() {
    let target = size(90, 90);
    let (mut cracked, mut total) = (0, 0);
    for seed in 0..200 {
        let mut rng = Rng::new(seed);
        let mut mesh = jittered_grid(&mut rng, 3);
        for p in &mut mesh.positions {
            *p = [p[0] * 1.7, p[1] * 1.7, 0.5];
        }
        with_random_w(&mut mesh, &mut rng);
        for parts in [1, 2, 3, 5, 7] {
            let draw = DrawCall {
                interp: Interp::Subdivided(parts),
                ..mesh.draw(free_w(0.01))
            };
            assert_once(
                &hits(target, &[draw]),
                &format!("seed {seed}, {parts} parts"),
            );
        }
        // One big triangle against two whose shared vertex lies in the middle of its side, off by the rounding of f32.
        let corner = |rng: &mut Rng| [rng.range(-0.9, 0.9) as f32, rng.range(-0.9, 0.9) as f32];
        let (a, b) = ([-0.95, corner(&mut rng)[1]], [0.95, corner(&mut rng)[1]]);
        let t = rng.unit() as f32;
        let joint = [a[0] + (b[0] - a[0]) * t, a[1] + (b[1] - a[1]) * t];
        let at = |p: [f32; 2]| [p[0], p[1], 0.5];
        let t_joint = Owned {
            positions: vec![at(a), at(b), at([0.0, 3.0]), at([0.0, -3.0]), at(joint)],
            indices: vec![[0, 1, 2], [0, 3, 4], [3, 1, 4]],
            ..Owned::default()
        };
        let count = hits(target, &[t_joint.draw(DMat4::IDENTITY)]);
        total += 1;
        cracked += u32::from(count.iter().any(|&c| c > 1) || has_inner_hole(&count, 90));
    }
    assert!(
        cracked > 0,
        "no T-joint of {total} cracked: the count cannot see cracks"
    );
}

/// A pixel that is not covered although its upper and lower neighbours are.
fn has_inner_hole(count: &[u32], width: usize) -> bool {
    (width..count.len() - width)
        .any(|i| count[i] == 0 && count[i - width] > 0 && count[i + width] > 0)
}

#[test]
fn coverage_equals_the_reference() {
    let target = size(80, 48);
    for seed in 0..2000 {
        let mut rng = Rng::new(seed);
        let reach = rng.log_range(0.02, 900.0);
        let mut mesh = Owned {
            indices: vec![[0, 1, 2]],
            ..Owned::default()
        };
        for _ in 0..3 {
            let w = rng.log_range(0.05, 8.0);
            let [x, y] = [0, 1].map(|_| rng.range(-reach, reach) + rng.range(-0.8, 0.8));
            mesh.positions
                .push([(x * w) as f32, (y * w) as f32, w as f32]);
        }
        let matrix = free_w(0.01);
        let snapped = mesh.clip(matrix, 0).map(|v| reference::snap(v, target));
        let [Some(a), Some(b), Some(c)] = snapped else {
            continue;
        };
        // Beyond the guard band triangles are cut, which may move an edge by 1/512 pixel.
        if [a, b, c].iter().any(|p| p.x.abs().max(p.y.abs()) > 1 << 23) {
            continue;
        }
        let count = hits(target, &[mesh.draw(matrix)]);
        for y in 0..48 {
            for x in 0..80 {
                let expected = u32::from(reference::covers([a, b, c], x, y));
                assert_eq!(
                    count[(y * 80 + x) as usize],
                    expected,
                    "seed {seed}, pixel {x}, {y}"
                );
            }
        }
    }
}

//! Planes that cross the eye plane, of 200 to 1e6 units (R6, I5): coverage and uv against the analytic homography.
use texmap_math::Camera;
use texmap_math::glam::DVec3;
use texmap_raster::{BinnedDraws, DrawCall, Interp};

use crate::support::{Owned, fragments, hits, size};

const WIDTH: u32 = 480;
const HEIGHT: u32 = 270;

fn camera() -> Camera {
    // 60 degrees from top to bottom at 16:9.
    let half = texmap_math::deterministic_f64::tan(std::f64::consts::FRAC_PI_6) * 16.0 / 9.0;
    Camera {
        eye: DVec3::new(0.0, 2.0, 8.0),
        look: DVec3::new(0.0, 0.0, 2.0),
        up: DVec3::Y,
        fov_x: 2.0 * texmap_math::deterministic_f64::atan(half),
        near: 1e-4,
        far: f64::INFINITY,
        lens: Default::default(),
    }
}

fn plane(half: f32) -> Owned {
    Owned {
        positions: vec![
            [-half, 0.0, half],
            [half, 0.0, half],
            [half, 0.0, -half],
            [-half, 0.0, -half],
        ],
        indices: vec![[0, 1, 2], [0, 2, 3]],
        ..Owned::default()
    }
    .with_uv(|[x, _, z]| [x / 8.0, z / 8.0])
}

/// x and z of the plane y = 0 seen at a pixel position.
fn hit(x: f64, y: f64) -> Option<[f64; 2]> {
    let camera = camera();
    let ray = camera.ray(WIDTH, HEIGHT, x, y).expect("a camera");
    (ray.y < 0.0).then(|| {
        let t = -camera.eye.y / ray.y;
        [camera.eye.x + ray.x * t, camera.eye.z + ray.z * t]
    })
}

/// Largest error in texels of 1024 a unit, beyond one f32 step of the value.
fn worst_error(half: f32, interp: Interp) -> f64 {
    let mesh = plane(half);
    let matrix = camera()
        .clip_from_world(f64::from(WIDTH) / f64::from(HEIGHT))
        .expect("a camera");
    let prepared = BinnedDraws::new(
        size(WIDTH, HEIGHT),
        &[DrawCall {
            interp,
            ..mesh.draw(matrix)
        }],
    )
    .expect("valid");
    let (mut worst, mut pixels) = (0.0_f64, 0);
    fragments(&prepared, |_, x, y, f| {
        let Some(p) = hit(f64::from(x) + 0.5, f64::from(y) + 0.5) else {
            return;
        };
        if p.iter().any(|v| v.abs() > f64::from(half)) {
            return;
        }
        pixels += 1;
        for (value, truth) in f.values.iter().zip(p) {
            let truth = truth / 8.0;
            let step = f64::from((truth.abs() as f32).next_up() - truth.abs() as f32);
            worst = worst.max((f64::from(*value) - truth).abs() * 1024.0 - step * 1024.0);
        }
    });
    assert!(pixels > 100_000, "only {pixels} pixels");
    worst
}

#[test]
fn i5_plane_through_the_eye_plane() {
    let worst = worst_error(200.0, Interp::Perspective);
    assert!(worst <= 0.01, "{worst} texels");
    // The negative twin: affine is off by thousands.
    assert!(worst_error(200.0, Interp::Affine) > 1000.0);
}

#[test]
fn r6_plane_of_ten_thousand_units() {
    let worst = worst_error(1e4, Interp::Perspective);
    assert!(worst <= 0.01, "{worst} texels");
}

#[test]
fn r6_plane_of_a_million_units() {
    let worst = worst_error(1e6, Interp::Perspective);
    assert!(worst <= 1.0, "{worst} texels");
}

/// Every pixel whose centre is inside by more than 1/128 pixel is drawn once, every one outside by as much is not.
#[test]
fn i5_coverage_equals_the_homography() {
    for half in [200.0_f32, 1e4, 1e6] {
        let matrix = camera()
            .clip_from_world(f64::from(WIDTH) / f64::from(HEIGHT))
            .expect("a camera");
        let mesh = plane(half);
        let count = hits(size(WIDTH, HEIGHT), &[mesh.draw(matrix)]);
        let inside = |x: f64, y: f64| {
            hit(x, y).is_some_and(|p| p.iter().all(|v| v.abs() <= f64::from(half)))
        };
        let mut unsure = 0;
        for y in 0..HEIGHT {
            for x in 0..WIDTH {
                let (cx, cy) = (f64::from(x) + 0.5, f64::from(y) + 0.5);
                let d = 1.0 / 128.0;
                let around =
                    [(-d, -d), (d, -d), (-d, d), (d, d)].map(|(dx, dy)| inside(cx + dx, cy + dy));
                let here = inside(cx, cy);
                if around.iter().any(|&a| a != here) {
                    unsure += 1;
                    continue;
                }
                assert_eq!(
                    count[(y * WIDTH + x) as usize],
                    u32::from(here),
                    "half {half}, pixel {x}, {y}"
                );
            }
        }
        assert!(unsure < 500, "{unsure} pixels could not be judged");
    }
}

//! A plane in perspective against its analytic homography.

use texmap_math::Homography;
use texmap_math::glam::{DVec2, DVec3, DVec4};
use texmap_raster::Interp;
use texmap_render::Aov;
use texmap_sample::Filter;
use texmap_scene::{Material, Mesh, Scene};

use crate::scenes::{draw_aovs, faces, of, pixel, quad, slot, texture, unlit, values};

const SIZE: u32 = 256;

/// A quad that leans away from the camera, whole in view, in checkers of 1/8.
fn leaning(interp: Interp) -> Scene {
    let material = Material {
        base_color: slot(0, Filter::Nearest),
        interp,
        ..unlit([1.0; 3])
    };
    let checker = |x: u32, y: u32| {
        if (x + y).is_multiple_of(2) {
            [255; 4]
        } else {
            [0, 0, 0, 255]
        }
    };
    Scene {
        textures: vec![texture(8, 8, checker)],
        ..of(
            material,
            quad(parallelogram(
                [-0.7, -0.9, -1.05],
                [1.5, 0.1, -0.2],
                [0.3, 2.2, -3.0],
            )),
        )
    }
}

fn parallelogram(o: [f32; 3], u: [f32; 3], v: [f32; 3]) -> [[f32; 3]; 4] {
    let at = |s: f32, t: f32| [0, 1, 2].map(|i| o[i] + s * u[i] + t * v[i]);
    [at(0.0, 0.0), at(1.0, 0.0), at(1.0, 1.0), at(0.0, 1.0)]
}

/// From pixel positions to uv, by the four corners alone.
fn homography(scene: &Scene) -> Homography {
    let mesh = &scene.meshes[0];
    let clip = scene.camera.clip_from_world(1.0).unwrap();
    let corner = |i: usize| {
        let p = clip * DVec4::from((DVec3::from(mesh.positions[i].map(f64::from)), 1.0));
        DVec2::new((p.x / p.w + 1.0) * 0.5, (1.0 - p.y / p.w) * 0.5) * f64::from(SIZE)
    };
    let uv = |i: usize| DVec2::from(mesh.uvs[i].map(f64::from));
    Homography::from_quads(
        [corner(0), corner(1), corner(2), corner(3)],
        [uv(0), uv(1), uv(2), uv(3)],
    )
    .unwrap()
}

/// Largest uv error over the covered pixels, how many of them, and how many checkers have the wrong colour.
fn against_homography(interp: Interp) -> (f64, u32, u32) {
    let scene = leaning(interp);
    let frame = draw_aovs(&scene, SIZE, SIZE, &[Aov::Uv, Aov::Face]);
    let truth = homography(&scene);
    let (mut worst, mut count, mut wrong) = (0.0f64, 0, 0);
    for (i, _) in faces(&frame)
        .iter()
        .enumerate()
        .filter(|(_, face)| **face != u32::MAX)
    {
        let (x, y) = (i as u32 % SIZE, i as u32 / SIZE);
        let expected = truth
            .apply(DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5))
            .unwrap();
        let got = values(&frame, Aov::Uv, x, y);
        worst = worst
            .max((f64::from(got[0]) - expected.x).abs())
            .max((f64::from(got[1]) - expected.y).abs());
        count += 1;
        let cell = (expected * 8.0).floor();
        let white = (cell.x + cell.y) as i64 % 2 == 0;
        let near_line = (expected * 8.0 - (expected * 8.0).round())
            .abs()
            .min_element()
            < 1e-4;
        wrong += u32::from(!near_line && white != (pixel(&frame, x, y)[0] == 255));
    }
    (worst, count, wrong)
}

#[test]
fn perspective_uv_is_the_homography() {
    let (worst, count, wrong) = against_homography(Interp::Perspective);
    assert!(count > 8_000, "{count} pixels");
    assert!(worst <= 1e-6, "{worst:e}");
    assert_eq!(wrong, 0, "checkers of the wrong colour");
}

#[test]
fn affine_uv_is_not_the_homography() {
    let (worst, _, wrong) = against_homography(Interp::Affine);
    assert!(worst > 0.1, "{worst}");
    assert!(wrong > 1_000, "{wrong}");
}

/// Texel tolerance in uv for 1024 texels, or one f32 step of the value where that is more.
fn tolerance(texels: f64, value: f64) -> f64 {
    (texels / 1024.0).max(value.abs() * f64::from(f32::EPSILON))
}

/// The plane that passes under and behind the eye: uv of each pixel against its ray.
#[test]
fn plane_through_the_eye_plane_keeps_its_texels() {
    for (half, texels) in [(200.0f32, 0.01), (1e4, 0.01), (1e6, 1.0)] {
        let mut scene = of(unlit([1.0; 3]), Mesh::default());
        scene.camera.eye = DVec3::new(0.0, 2.0, 8.0);
        scene.camera.look = DVec3::new(0.0, 0.0, 2.0);
        let mut floor = quad([
            [-half, 0.0, half],
            [half, 0.0, half],
            [half, 0.0, -half],
            [-half, 0.0, -half],
        ]);
        floor.uvs = floor
            .positions
            .iter()
            .map(|p| [p[0] / 8.0, p[2] / 8.0])
            .collect();
        scene.meshes = vec![floor];
        let frame = draw_aovs(&scene, SIZE, SIZE, &[Aov::Uv]);
        let (mut covered, mut missed) = (0, 0);
        for i in 0..SIZE * SIZE {
            let (x, y) = (i % SIZE, i / SIZE);
            let ray = scene
                .camera
                .ray(SIZE, SIZE, f64::from(x) + 0.5, f64::from(y) + 0.5)
                .unwrap();
            let hit = scene.camera.eye - ray * (scene.camera.eye.y / ray.y);
            let got = values(&frame, Aov::Uv, x, y);
            let seen =
                ray.y < 0.0 && hit.x.abs() < f64::from(half) && hit.z.abs() < f64::from(half);
            missed += u32::from(seen == got[0].is_nan());
            if seen && !got[0].is_nan() {
                covered += 1;
                for (got, expected) in got.iter().zip([hit.x / 8.0, hit.z / 8.0]) {
                    let error = (f64::from(*got) - expected).abs();
                    assert!(
                        error <= tolerance(texels, expected),
                        "half {half}, pixel {x} {y}: {got} for {expected}"
                    );
                }
            }
        }
        assert!(covered > 20_000, "{covered}");
        assert_eq!(missed, 0, "coverage, half {half}");
    }
}

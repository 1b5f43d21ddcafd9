//! Parallel projections: sizes, depths and light that do not depend on the distance, and what needs an eye.

use texmap_light::{Light, PhongMaterial};
use texmap_math::camera::{Camera, Lens};
use texmap_math::glam::DVec3;
use texmap_math::texture_frame::TextureFrame;
use texmap_render::{Aov, RenderSettings, render};
use texmap_scene::{Background, Material, Scene};
use texmap_tests::levels::levels;

use crate::scenes::{draw_aovs, of, quad, unlit, values};

fn parallel(width: f64) -> Camera {
    Camera {
        far: 20.0,
        lens: Lens {
            parallel_width: Some(width),
            ..Lens::default()
        },
        ..Camera::look_at([0.0, 0.0, 4.0], [0.0; 3])
    }
}

/// A square of edge 1 at a height over the picture plane.
fn square(z: f32) -> Scene {
    let mesh = quad([
        [-0.5, -0.5, z],
        [0.5, -0.5, z],
        [0.5, 0.5, z],
        [-0.5, 0.5, z],
    ]);
    Scene {
        camera: parallel(2.0),
        ..of(unlit([1.0; 3]), mesh)
    }
}

#[test]
fn a_square_covers_its_share_at_any_distance_and_depth_is_even() {
    for (z, depth) in [(2.0, 18.0), (0.0, 16.0), (-6.0, 10.0)] {
        let frame = draw_aovs(&square(z), 64, 64, &[Aov::Depth, Aov::InvW, Aov::Position]);
        assert_eq!(frame.stats.pixels_covered, 32 * 32, "at {z}");
        let (near, far) = (4e-3, 20.0);
        let expected = depth / (far - near);
        assert!((f64::from(values(&frame, Aov::Depth, 30, 40)[0]) - expected).abs() < 1e-6);
        assert_eq!(values(&frame, Aov::InvW, 30, 40), [1.0]);
        let position = values(&frame, Aov::Position, 30, 40);
        let wanted = [30.5 / 32.0 - 1.0, 1.0 - 40.5 / 32.0, f64::from(z)];
        for (got, wanted) in position.iter().zip(wanted) {
            assert!((f64::from(*got) - wanted).abs() < 1e-6, "{position:?}");
        }
    }
    // The same squares through a pinhole shrink.
    let mut central = square(-6.0);
    central.camera.lens = Lens::default();
    let frame = draw_aovs(&central, 64, 64, &[]);
    assert!(frame.stats.pixels_covered < 32 * 32 / 2);
}

/// A plane mirrors a directional light the same way everywhere, for all eyes look along one direction.
#[test]
fn highlights_of_a_plane_are_even_and_the_same_on_every_level() {
    let mut scene = square(0.0);
    scene.materials = vec![Material {
        phong: PhongMaterial {
            color: [0.2; 3],
            ka: 0.0,
            kd: 0.2,
            ks: 0.8,
            ns: 20.0,
        },
        ..Material::default()
    }];
    scene.lights = vec![Light::Directional {
        color: [0.9; 3],
        direction: [0.2, -0.1, -1.0],
    }];
    let inner = |scene: &Scene, level| {
        let settings = RenderSettings {
            level,
            ..RenderSettings::new(64, 64)
        };
        let frame = render(scene, &settings, &|_, _| ()).unwrap();
        let pixel = |x: usize, y: usize| frame.rgba[(y * 64 + x) * 4];
        let across: Vec<u8> = (18..46).map(|i| pixel(i, i)).collect();
        (across, frame.rgba)
    };
    let all: Vec<_> = levels()
        .into_iter()
        .map(|(_, level)| inner(&scene, level))
        .collect();
    assert!(all.windows(2).all(|pair| pair[0] == pair[1]));
    let across = &all[0].0;
    assert!(
        across.iter().all(|v| v.abs_diff(across[0]) <= 1) && across[0] > 60,
        "{across:?}"
    );
    scene.camera.lens = Lens::default();
    let (central, _) = inner(&scene, levels()[0].1);
    assert!(
        central.iter().any(|v| v.abs_diff(central[0]) > 3),
        "{central:?}"
    );
}

#[test]
fn what_is_seen_along_rays_from_the_eye_is_refused_by_name() {
    let mut scene = square(0.0);
    let frame = TextureFrame {
        o: DVec3::ZERO,
        u: DVec3::X,
        v: DVec3::Y,
    };
    scene.check().unwrap();
    scene.meshes[0].texture_frame = Some(frame);
    let error = scene.check().unwrap_err();
    assert_eq!(error.code(), "render-parallel");
    assert!(error.to_string().contains("its texture frame"), "{error}");
    scene.meshes[0].texture_frame = None;
    scene.effects.background = Some(Background::Environment(0));
    assert_eq!(scene.check().unwrap_err().code(), "render-parallel");
    scene.effects.background = None;
    scene.camera.far = f64::INFINITY;
    assert_eq!(scene.check().unwrap_err().code(), "render-camera");
}

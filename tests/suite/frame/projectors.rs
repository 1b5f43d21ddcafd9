//! The light and the pictures of projectors.

use texmap_light::{Light, PhongMaterial, ProjectorBorder};
use texmap_math::Projector;
use texmap_math::glam::DVec3;
use texmap_render::{Aov, RenderSettings};
use texmap_sample::{Filter, Sampler};
use texmap_scene::{Effects, Material, ProjectorLight, ProjectorMode, Scene};
use texmap_tests::levels::levels;

use crate::effects::{projector_light, rendered};
use crate::scenes::{empty, pixel, texture, wall};

/// Property 23, lit part: what the projector lights does not depend on where the eye is.
#[test]
fn slides_do_not_follow_the_eye() {
    let mut scene = Scene {
        textures: vec![texture(32, 32, |x, _| {
            if x < 16 {
                [255, 0, 0, 255]
            } else {
                [0, 255, 0, 255]
            }
        })],
        materials: vec![Material {
            phong: PhongMaterial {
                color: [1.0; 3],
                ks: 0.0,
                ..PhongMaterial::default()
            },
            ..Material::default()
        }],
        meshes: vec![wall(4.0, 4.0)],
        effects: Effects {
            projectors: vec![ProjectorLight {
                softness: 0.0,
                sampler: Sampler {
                    filter: Filter::Nearest,
                    ..Sampler::default()
                },
                ..projector_light(0, ProjectorMode::Light([1.0; 3]), None)
            }],
            ..Effects::default()
        },
        ..empty()
    };
    let projector = scene.effects.projectors[0].projector;
    for eye in [[0.0; 3], [1.5, 0.7, -1.0], [-2.0, 0.0, 0.5]] {
        scene.camera.eye = DVec3::from(eye);
        scene.camera.look = DVec3::new(0.0, 0.0, -4.0);
        let settings = RenderSettings {
            aovs: vec![Aov::Position],
            ..RenderSettings::new(120, 120)
        };
        let frame = rendered(&scene, &settings);
        let (mut red, mut green) = (0, 0);
        for (x, y) in (0..120).flat_map(|y| (0..120).map(move |x| (x, y))) {
            let p: [f32; 3] = crate::scenes::values(&frame, Aov::Position, x, y)
                .try_into()
                .unwrap();
            let Some(uv) = projector
                .uv(DVec3::from(p.map(f64::from)))
                .filter(|uv| uv.is_finite())
            else {
                continue;
            };
            let [r, g, _, _] = pixel(&frame, x, y);
            let inside = uv.min_element() > 0.01 && uv.max_element() < 0.99;
            let outside = uv.min_element() < -0.01 || uv.max_element() > 1.01;
            if inside && (uv.x - 0.5).abs() > 0.02 {
                assert_eq!((r > 20, g > 20), (uv.x < 0.5, uv.x > 0.5), "{uv}");
                (red, green) = (red + u32::from(r > 20), green + u32::from(g > 20));
            } else if outside {
                assert_eq!((r, g), (0, 0), "{uv}");
            }
        }
        assert!(red > 100 && green > 100, "{red} {green}");
    }
}

/// A point behind a projector or beside its lens gets nothing of its picture, whatever the border rule: t is tested before the
/// division, on every level.
#[test]
fn nothing_behind_a_projector_is_lit() {
    let position = DVec3::new(0.1, 0.2, -2.0);
    let borders = [
        ProjectorBorder::Black,
        ProjectorBorder::Clamp,
        ProjectorBorder::Repeat,
    ];
    let roles = [ProjectorMode::Light([1.0; 3]), ProjectorMode::Decal];
    // Level 0 alone is looked up in lanes, levels sample by sample.
    let filters = [Filter::Bilinear, Filter::Trilinear];
    let scene = |toward: DVec3, border, role, filter| Scene {
        textures: vec![texture(8, 8, |_, _| [255; 4])],
        materials: vec![Material {
            phong: PhongMaterial {
                color: [0.25, 0.0, 0.5],
                ks: 0.0,
                ..PhongMaterial::default()
            },
            ..Material::default()
        }],
        lights: vec![Light::Ambient { color: [1.0; 3] }],
        meshes: vec![wall(3.0, 3.0)],
        effects: Effects {
            projectors: vec![ProjectorLight {
                projector: Projector::new(position, position + toward, DVec3::Y, 0.9, 1.0).unwrap(),
                position,
                border,
                sampler: Sampler {
                    filter,
                    ..Sampler::default()
                },
                ..projector_light(0, role, None)
            }],
            ..Effects::default()
        },
        ..empty()
    };
    let lit = |scene: &Scene, level| {
        let settings = RenderSettings {
            level,
            ..RenderSettings::new(80, 80)
        };
        let frame = rendered(scene, &settings);
        // The wall alone gives back a quarter of the red.
        frame.rgba.chunks_exact(4).filter(|p| p[0] > 70).count()
    };
    for (name, level) in levels() {
        let kinds = borders.into_iter().flat_map(|b| roles.map(|r| (b, r)));
        for ((border, role), filter) in kinds.flat_map(|k| filters.map(|f| (k, f))) {
            let away = scene(DVec3::Z, border, role, filter);
            assert_eq!(
                lit(&away, level),
                0,
                "{name} {border:?} {role:?} {filter:?}"
            );
            let toward = scene(DVec3::NEG_Z, border, role, filter);
            assert!(
                lit(&toward, level) > 80,
                "{name} {border:?} {role:?} {filter:?}"
            );
        }
    }
}

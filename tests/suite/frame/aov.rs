//! Every buffer beside the colour: its values, and nothing but the written constant where there are none.

use texmap_math::color::{linear_to_srgb8, unit_to_u8};
use texmap_math::glam::{DMat4, DVec3};
use texmap_render::{Aov, AovData, HOLE_BITS, RenderSettings, render};
use texmap_sample::{Filter, UvTransform};
use texmap_scene::{AlphaMode, ColorMode, Material, Mesh, Scene, TextureRole};

use crate::scenes::{draw_aovs, empty, faces, quad, slot, texture, unlit, values, wall};

const SIZE: u32 = 96;

/// A textured wall, an untextured one without uv, a mesh whose third vertex has no normal, glass, and a part of the sky.
fn mixed() -> Scene {
    let mut textured = unlit([1.0; 3]);
    textured.base_color = slot(0, Filter::Trilinear);
    let plain = Mesh {
        uvs: Vec::new(),
        material: 1,
        ..quad([
            [-1.0, -1.0, -2.0],
            [0.0, -1.0, -2.0],
            [0.0, 0.0, -2.0],
            [-1.0, 0.0, -2.0],
        ])
    };
    let odd = Mesh {
        normals: vec![[0.0, 0.0, 2.0], [0.0, 3.0, 0.0], [0.0; 3], [0.0; 3]],
        material: 1,
        ..quad([
            [0.2, -1.5, -2.0],
            [1.2, -1.5, -2.0],
            [1.2, -0.5, -3.0],
            [0.2, -0.5, -3.0],
        ])
    };
    Scene {
        textures: vec![texture(16, 16, |x, y| {
            [(x * 16) as u8, (y * 16) as u8, 9, 255]
        })],
        materials: vec![
            textured,
            unlit([0.5; 3]),
            Material {
                alpha: AlphaMode::Blend,
                opacity: 0.5,
                ..unlit([1.0; 3])
            },
        ],
        meshes: vec![
            Mesh {
                world_from_object: DMat4::from_translation(DVec3::new(0.9, 0.9, 0.0)),
                faces: vec![40, 41],
                ..wall(0.7, 1.6)
            },
            plain,
            odd,
            Mesh {
                material: 2,
                ..wall(0.5, 1.0)
            },
        ],
        ..empty()
    }
}

#[test]
fn holes_are_one_constant_and_values_are_finite() {
    let frame = draw_aovs(&mixed(), SIZE, SIZE, &Aov::ALL);
    let covered: Vec<bool> = faces(&frame).iter().map(|face| *face != u32::MAX).collect();
    let count = covered.iter().filter(|c| **c).count();
    assert!(count > 2_000 && count < covered.len() - 2_000, "{count}");
    for (aov, channels, data) in &frame.aovs {
        let AovData::F32(data) = data else { continue };
        let mut filled = 0;
        for (pixel, covered) in data.chunks_exact(*channels).zip(&covered) {
            let holes = pixel.iter().filter(|v| v.to_bits() == HOLE_BITS).count();
            assert!(holes == 0 || holes == *channels, "{aov}: a hole in part");
            assert!(
                holes > 0 || pixel.iter().all(|v| v.is_finite()),
                "{aov}: {pixel:?}"
            );
            assert!(*covered || holes > 0, "{aov}: a value where nothing is");
            filled += usize::from(holes == 0);
        }
        match aov {
            Aov::Lod | Aov::Uv => {
                assert!(filled > 500 && filled < count, "{aov}: {filled} of {count}");
            }
            Aov::Normal => assert!(filled > count * 9 / 10, "{aov}: {filled} of {count}"),
            _ => assert_eq!(filled, count, "{aov}"),
        }
    }
}

#[test]
fn values_are_those_of_the_scene() {
    let frame = draw_aovs(&mixed(), SIZE, SIZE, &Aov::ALL);
    let mut seen = 0;
    for i in 0..SIZE * SIZE {
        let face = faces(&frame)[i as usize];
        if face != 40 && face != 41 {
            continue;
        }
        seen += 1;
        let (x, y) = (i % SIZE, i / SIZE);
        let (sx, sy) = (
            2.0 * (f64::from(x) + 0.5) / 96.0 - 1.0,
            1.0 - 2.0 * (f64::from(y) + 0.5) / 96.0,
        );
        let near = |aov, expected: &[f64]| {
            for (got, expected) in values(&frame, aov, x, y).iter().zip(expected) {
                assert!(
                    (f64::from(*got) - expected).abs() < 1e-6,
                    "{aov} at {x} {y}: {got} for {expected}"
                );
            }
        };
        near(Aov::Depth, &[1e-4 / 1.6]);
        near(Aov::InvW, &[1.0 / 1.6]);
        near(Aov::Position, &[1.6 * sx, 1.6 * sy, -1.6]);
        near(Aov::Normal, &[0.0, 0.0, 1.0]);
        let uv = [(1.6 * sx - 0.2) / 1.4, 1.0 - (1.6 * sy - 0.2) / 1.4];
        near(Aov::Uv, &uv);
        // A pixel is 1.6 * 2 / 96 wide, a texel 1.4 / 16.
        near(Aov::Lod, &[0.0]);
        let diagonal = uv[0] + uv[1] - 1.0;
        assert!(
            diagonal.abs() < 1e-6 || face == if diagonal > 0.0 { 40 } else { 41 },
            "{x} {y}"
        );
    }
    assert!(seen > 700, "{seen}");
}

#[test]
fn lod_counts_texels_of_the_transformed_coordinates() {
    let mut scene = mixed();
    let slot = scene.materials[0].base_color.as_mut().unwrap();
    slot.transform = UvTransform {
        scale: [64.0, 64.0],
        ..UvTransform::default()
    };
    let frame = draw_aovs(&scene, SIZE, SIZE, &[Aov::Lod, Aov::Uv]);
    // 64 x 16 texels on 1.4 units; a pixel is 3.2 / 96.
    let expected = (1024.0f32 / 1.4 * 3.2 / 96.0).log2();
    let got = values(&frame, Aov::Lod, 70, 20)[0];
    assert!((got - expected).abs() < 1e-3, "{got} for {expected}");
    assert!(
        values(&frame, Aov::Uv, 70, 20)
            .iter()
            .all(|c| (0.0..=1.0).contains(c)),
        "uv is the mesh's own"
    );
}

#[test]
fn normals_face_the_eye_and_follow_the_inverse_transpose() {
    let tilted = quad([
        [-1.0, -1.0, -3.0],
        [1.0, -1.0, -3.0],
        [1.0, 1.0, -4.0],
        [-1.0, 1.0, -4.0],
    ]);
    let normal = |world_from_object: DMat4, flip: bool| {
        let mut mesh = Mesh {
            world_from_object,
            ..tilted.clone()
        };
        if flip {
            mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        }
        let scene = Scene {
            materials: vec![unlit([1.0; 3])],
            meshes: vec![mesh],
            ..empty()
        };
        let got = values(
            &draw_aovs(&scene, 33, 33, &[Aov::Normal]),
            Aov::Normal,
            16,
            16,
        );
        DVec3::new(got[0].into(), got[1].into(), got[2].into())
    };
    let near = |a: DVec3, b: DVec3| assert!((a - b.normalize()).length() < 1e-6, "{a} for {b}");
    near(normal(DMat4::IDENTITY, false), DVec3::new(0.0, 1.0, 2.0));
    // The other winding shows its back: the normal turns to the eye.
    near(normal(DMat4::IDENTITY, true), DVec3::new(0.0, 1.0, 2.0));
    // Twice as high: the plane is steeper, its normal flatter.
    near(
        normal(DMat4::from_scale(DVec3::new(1.0, 2.0, 1.0)), false),
        DVec3::new(0.0, 0.5, 2.0),
    );
    // A mirror keeps the front the front.
    near(
        normal(DMat4::from_scale(DVec3::new(-1.0, 1.0, 1.0)), false),
        DVec3::new(0.0, 1.0, 2.0),
    );
}

#[test]
fn decals_and_blended_panes_leave_no_trace() {
    let mut scene = mixed();
    let with = draw_aovs(&scene, SIZE, SIZE, &Aov::ALL);
    scene.meshes.truncate(3);
    scene.materials[0].texture_role = TextureRole::Decal;
    let without = draw_aovs(&scene, SIZE, SIZE, &Aov::ALL);
    assert_eq!(crate::scenes::bits(&with), crate::scenes::bits(&without));
}

#[test]
fn mesh_ids_are_those_of_the_scene() {
    let mut scene = mixed();
    let ids = |scene: &Scene| match draw_aovs(scene, SIZE, SIZE, &[Aov::Mesh]).aovs.remove(0).2 {
        AovData::U32(ids) => ids,
        AovData::F32(_) => panic!("whole numbers"),
    };
    let of = |ids: &[u32]| {
        let mut seen = ids.to_vec();
        seen.sort_unstable();
        seen.dedup();
        seen
    };
    // The pane blends and leaves no trace.
    assert_eq!(of(&ids(&scene)), [0, 1, 2, u32::MAX]);
    scene.meshes.swap(0, 1);
    assert_eq!(of(&ids(&scene)), [0, 1, 2, u32::MAX]);
    let (before, after) = (ids(&mixed()), ids(&scene));
    let swapped = |id: &u32| match id {
        0 => 1,
        1 => 0,
        other => *other,
    };
    assert_eq!(before.iter().map(swapped).collect::<Vec<_>>(), after);
}

/// The colour array is what the bytes are encoded from, whatever the samples, and asking for it changes no byte.
#[test]
fn colours_are_the_light_behind_the_bytes() {
    let mut scene = mixed();
    scene.background = [0.2, 0.4, 0.6, 0.5];
    for (color, supersample, msaa) in [
        (ColorMode::Raw, 1, 1),
        (ColorMode::Srgb, 1, 1),
        (ColorMode::Srgb, 1, 4),
        (ColorMode::Raw, 1, 4),
        (ColorMode::Srgb, 2, 1),
    ] {
        scene.color = color;
        let settings = RenderSettings {
            supersample,
            msaa,
            ..RenderSettings::new(SIZE, SIZE)
        };
        let plain = render(&scene, &settings, &texmap_render::no_progress).unwrap();
        for aovs in [vec![Aov::Color], vec![Aov::Depth, Aov::Color, Aov::Mesh]] {
            let asked = RenderSettings {
                aovs,
                ..settings.clone()
            };
            let frame = render(&scene, &asked, &texmap_render::no_progress).unwrap();
            assert!(frame.rgba == plain.rgba, "{supersample} {msaa}");
            let array = frame.aovs.iter().find(|(aov, ..)| *aov == Aov::Color);
            let Some((_, 4, AovData::F32(pixels))) = array else {
                panic!("four floats")
            };
            for (light, bytes) in pixels.chunks(4).zip(plain.rgba.chunks(4)) {
                let alpha = light[3];
                let encoded = [0, 1, 2].map(|k| match color {
                    ColorMode::Srgb => linear_to_srgb8(light[k] / alpha),
                    ColorMode::Raw => unit_to_u8(light[k] / alpha),
                });
                assert_eq!(
                    (encoded, unit_to_u8(alpha)),
                    ([bytes[0], bytes[1], bytes[2]], bytes[3])
                );
            }
        }
    }
}

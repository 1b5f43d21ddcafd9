//! Displaced, skinned and turned meshes in whole frames: one picture everywhere, and edges within their budget.

use texmap_light::{Light, PhongMaterial};
use texmap_math::glam::{DMat4, DVec3};
use texmap_mesh::tessellate;
use texmap_mesh::{Bone, Skeleton, SkinBlend, rotation};
use texmap_render::{Aov, AovData, RenderSettings, Renderer, render, render_ordered};
use texmap_sample::Filter;
use texmap_scene::{Billboard, Displacement, EdgeBudget, Facing, Material, Mesh, Scene, Shadow};
use texmap_tests::levels::levels;

use crate::scenes::{bits, empty, quad, slot, texture, wall};

fn displaced(mesh: Mesh, texture: usize, height: f32, budget: EdgeBudget) -> Mesh {
    let slot = slot(texture, Filter::Trilinear).expect("a slot");
    Mesh {
        displacement: Some(Displacement {
            budget,
            ..Displacement::new(slot, height)
        }),
        ..mesh
    }
}

fn waves(x: u32, y: u32) -> [u8; 4] {
    [((x * 37 + y * 11) % 256) as u8, 0, 0, 255]
}

/// A displaced wall and floor that meet at an edge, trees of both kinds, and a bent strip, under a light with shadows.
fn everything() -> Scene {
    let white = PhongMaterial {
        color: [0.9, 0.8, 0.7],
        ..PhongMaterial::default()
    };
    let back = wall(1.5, 4.0);
    let floor = quad([
        [-1.5, -1.5, -2.0],
        [1.5, -1.5, -2.0],
        [1.5, -1.5, -4.0],
        [-1.5, -1.5, -4.0],
    ]);
    let cards =
        [(-0.8, Facing::Screen), (0.8, Facing::Axis(DVec3::Y))].map(|(x, facing)| Billboard {
            position: DVec3::new(x, -0.9, -2.8),
            size: [0.8, 1.0],
            facing,
        });
    let strip = Mesh {
        positions: (0..40)
            .map(|i| [(i / 2) as f32 * 0.1 - 1.0, 0.6 + (i % 2) as f32 * 0.2, -2.5])
            .collect(),
        uvs: (0..40)
            .map(|i| [(i / 2) as f32 * 0.1, (i % 2) as f32])
            .collect(),
        triangles: (0..38)
            .map(|i| {
                if i % 2 == 0 {
                    [i, i + 2, i + 1]
                } else {
                    [i, i + 1, i + 2]
                }
            })
            .collect(),
        ..Mesh::default()
    };
    let bone = |from: f64, to: f64, parent| Bone {
        head: DVec3::new(from, 0.7, -2.5),
        tail: DVec3::new(to, 0.7, -2.5),
        parent,
    };
    let skeleton = Skeleton {
        bones: vec![bone(-1.0, 0.0, None), bone(0.0, 1.0, Some(0))],
    };
    let pose = skeleton
        .pose(&[DMat4::IDENTITY, rotation(DVec3::Y, 0.9)])
        .expect("a pose");
    let bent = skeleton
        .skin(&strip.positions, SkinBlend::Smooth(0.6))
        .bend(&strip, &pose)
        .expect("good weights");
    let cut = texture(16, 16, |x, y| {
        [90, 160, 60, if (x + y) % 5 == 0 { 0 } else { 255 }]
    });
    Scene {
        lights: vec![
            Light::Ambient { color: [0.2; 3] },
            Light::Directional {
                color: [0.8; 3],
                direction: [0.4, -1.0, -0.7],
            },
        ],
        textures: vec![texture(32, 32, waves), cut],
        materials: vec![
            Material {
                phong: white,
                ..Material::default()
            },
            Material {
                phong: white,
                base_color: slot(1, Filter::Nearest),
                alpha: texmap_scene::AlphaMode::Test(0.0),
                ..Material::default()
            },
        ],
        meshes: vec![
            displaced(back, 0, 0.4, EdgeBudget::Pixels(3.0)),
            displaced(floor, 0, 0.3, EdgeBudget::Texels(2.0)),
            texmap_mesh::billboards("trees", cards.to_vec(), 1),
            Mesh {
                material: 1,
                ..bent
            },
        ],
        effects: texmap_scene::Effects {
            shadows: vec![Shadow {
                light: 1,
                size: Some(256),
                bias: None,
                pcf_size: 3,
                area: None,
            }],
            ..Default::default()
        },
        ..empty()
    }
}

#[test]
fn shapes_have_one_picture_on_every_level_and_number_of_threads() {
    let scene = everything();
    let settings = RenderSettings {
        aovs: Aov::ALL.to_vec(),
        ..RenderSettings::new(100, 80)
    };
    let scene = tessellate(scene, 100).expect("a good scene");
    let expected = render(&scene, &settings, &texmap_render::no_progress).expect("a good scene");
    assert!(
        expected.stats.triangles_submitted > 2_000,
        "{}",
        expected.stats.triangles_submitted
    );
    for (name, level) in levels() {
        let settings = RenderSettings {
            level,
            ..settings.clone()
        };
        let frame = render(&scene, &settings, &texmap_render::no_progress).expect("a good scene");
        assert_eq!(bits(&frame), bits(&expected), "{name}");
    }
    for threads in [1, 2, 5] {
        let settings = RenderSettings {
            threads: Some(threads),
            ..settings.clone()
        };
        let backwards = |n: usize| (0..n).rev().collect();
        let frame = render_ordered(&scene, &settings, &texmap_render::no_progress, &backwards)
            .expect("a good scene");
        assert_eq!(bits(&frame), bits(&expected), "{threads} threads");
    }
    // A scene of triangles is left as it is.
    assert!(matches!(
        tessellate(&*scene, 100),
        Ok(std::borrow::Cow::Borrowed(_))
    ));
}

/// No edge is longer than its budget, and none of them was needed: twice the length would not do.
#[test]
fn edges_keep_within_their_budget_of_pixels() {
    let tilted = quad([
        [-2.0, -1.0, -1.0],
        [2.0, -1.0, -1.0],
        [2.0, 1.0, -9.0],
        [-2.0, 1.0, -9.0],
    ]);
    let count = |pixels: f32, height: f32| {
        let mut scene = empty();
        scene.textures = vec![texture(512, 512, waves)];
        scene.materials = vec![Material::default()];
        scene.meshes = vec![displaced(
            tilted.clone(),
            0,
            height,
            EdgeBudget::Pixels(pixels),
        )];
        let shaped = tessellate(&scene, 200).expect("a good scene").into_owned();
        let mesh = &shaped.meshes[0];
        let at = |v: u32| DVec3::from(mesh.positions[v as usize].map(f64::from));
        // 200 pixels see 90 degrees: 100 pixels for a length of 1 at distance 1.
        let pixels_of = |a: DVec3, b: DVec3| 100.0 * (b - a).length() / (0.5 * (a + b)).length();
        let edges = mesh
            .triangles
            .iter()
            .flat_map(|t| [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])]);
        let longest = edges
            .map(|(a, b)| pixels_of(at(a), at(b)))
            .fold(0.0, f64::max);
        (mesh.triangles.len(), longest)
    };
    for pixels in [40.0, 12.0, 5.0] {
        let (_, longest) = count(pixels, 0.0);
        assert!(
            longest <= f64::from(pixels) * 1.000_001 && longest > 0.6 * f64::from(pixels),
            "{pixels}: {longest}"
        );
    }
    let (few, many) = (count(12.0, 0.0).0, count(6.0, 0.0).0);
    assert!((3 * few..6 * few).contains(&many), "{few} {many}");
    // The count does not depend on the heights.
    assert_eq!(count(12.0, 0.5).0, few);
}

/// A displacement of nothing changes neither coverage nor faces, and coordinates and light by rounding alone.
#[test]
fn a_height_of_zero_changes_no_picture() {
    let resting = |height: Option<f32>| {
        let mut scene = everything();
        scene.effects = Default::default();
        for mesh in &mut scene.meshes[..2] {
            match height {
                Some(height) => mesh.displacement.as_mut().expect("displaced").height = height,
                None => mesh.displacement = None,
            }
        }
        let settings = RenderSettings {
            aovs: vec![Aov::Face],
            ..RenderSettings::new(100, 80)
        };
        let scene = tessellate(scene, 100).expect("a good scene");
        render(&scene, &settings, &texmap_render::no_progress).expect("a good scene")
    };
    let (none, zero, some) = (resting(None), resting(Some(0.0)), resting(Some(0.3)));
    let far = |a: &texmap_render::Frame, b: &texmap_render::Frame| {
        let pairs = a.rgba.iter().zip(&b.rgba);
        pairs.filter(|(a, b)| a.abs_diff(**b) > 1).count()
    };
    assert_eq!(far(&none, &zero), 0);
    assert!(far(&none, &some) > 5_000, "{}", far(&none, &some));
    let faces = |frame: &texmap_render::Frame| match &frame.aovs[0] {
        (Aov::Face, 1, AovData::U32(faces)) => faces.clone(),
        other => panic!("{other:?}"),
    };
    // Positions are rounded at every cut, so a pixel on the diagonal may change sides.
    let other = faces(&none)
        .iter()
        .zip(&faces(&zero))
        .filter(|(a, b)| a != b)
        .count();
    assert!(other <= 8, "{other} pixels have another face");
}

/// The normals of a displaced plane are those of the waves, better the finer it is cut.
#[test]
fn normals_follow_the_moved_surface() {
    let wave = |x: u32| 0.5 + 0.5 * (std::f64::consts::TAU * (f64::from(x) + 0.5) / 128.0).sin();
    let map = texture(128, 4, |x, _| [(wave(x) * 255.0).round() as u8, 0, 0, 255]);
    let worst = |texels: f32| {
        let mut scene = empty();
        scene.textures = vec![map.clone()];
        scene.materials = vec![Material::default()];
        scene.meshes = vec![displaced(
            wall(1.0, 2.0),
            0,
            0.2,
            EdgeBudget::Texels(texels),
        )];
        let shaped = tessellate(&scene, 64).expect("a good scene").into_owned();
        let mesh = &shaped.meshes[0];
        let inner = mesh
            .positions
            .iter()
            .zip(&mesh.normals)
            .filter(|(p, _)| p[0].abs() < 0.9 && p[1].abs() < 0.9);
        let angle = |(p, n): (&[f32; 3], &[f32; 3])| {
            let slope = 0.2
                * 0.5
                * std::f64::consts::PI
                * (std::f64::consts::PI * (f64::from(p[0]) + 1.0)).cos();
            let truth = DVec3::new(-slope, 0.0, 1.0).normalize();
            truth
                .cross(DVec3::from(n.map(f64::from)))
                .length()
                .asin()
                .to_degrees()
        };
        inner.map(angle).fold(0.0, f64::max)
    };
    let (fine, coarse) = (worst(4.0), worst(32.0));
    assert!(fine < 1.2 && coarse > 2.0 * fine, "{fine} {coarse}");
}

/// A cube of side 2; `apart`: each triangle has vertices of its own.
fn cube(apart: bool) -> Mesh {
    let axes = [DVec3::X, DVec3::Y, DVec3::Z];
    let mut mesh = Mesh::default();
    for (axis, side) in [0, 1, 2].into_iter().flat_map(|a| [(a, 1.0), (a, -1.0)]) {
        let out = axes[axis] * side;
        let (right, up) = (axes[(axis + 1) % 3], axes[(axis + 2) % 3] * side);
        let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
        let parts: &[&[usize]] = if apart {
            &[&[0, 1, 2], &[0, 2, 3]]
        } else {
            &[&[0, 1, 2, 3]]
        };
        for part in parts {
            let first = mesh.positions.len() as u32;
            for &k in *part {
                let (x, y) = corners[k];
                mesh.positions
                    .push((out + right * x + up * y).as_vec3().to_array());
                mesh.normals.push(out.as_vec3().to_array());
                mesh.uvs.push([0.5 + 0.5 * x as f32, 0.5 + 0.5 * y as f32]);
            }
            mesh.triangles.push([first, first + 1, first + 2]);
            if !apart {
                mesh.triangles.push([first, first + 2, first + 3]);
            }
        }
    }
    mesh
}

/// Positions of a mesh after its displacement by a map.
fn moved(mesh: Mesh, map: texmap_sample::Texture2d<'static>, height: f32) -> Vec<[f32; 3]> {
    let mut scene = empty();
    scene.textures = vec![map];
    scene.materials = vec![Material::default()];
    scene.meshes = vec![displaced(mesh, 0, height, EdgeBudget::Texels(100.0))];
    tessellate(&scene, 64).expect("a good scene").meshes[0]
        .positions
        .clone()
}

/// Each different normal counts once at a corner, however many triangles bring it.
#[test]
fn corners_move_along_the_mean_of_their_different_normals() {
    let white = || texture(4, 4, |_, _| [255; 4]);
    for apart in [false, true] {
        for (p, from) in moved(cube(apart), white(), 0.3)
            .iter()
            .zip(cube(apart).positions)
        {
            let expected = from.map(|c| c * (1.0 + 0.3 / 3f32.sqrt()));
            assert!(
                (0..3).all(|i| (p[i] - expected[i]).abs() < 1e-6),
                "{apart}: {p:?} {expected:?}"
            );
        }
    }
}

/// At a jump of the coordinates, both sides go by the mean of their heights.
#[test]
fn seams_move_by_the_mean_of_their_heights() {
    let halves = texture(2, 1, |x, _| if x == 0 { [0, 0, 0, 255] } else { [255; 4] });
    let mut strip = quad([
        [-1.0, 0.0, 0.0],
        [0.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [-1.0, 1.0, 0.0],
    ]);
    strip.uvs = vec![[0.25, 0.5]; 4];
    let right = strip
        .positions
        .clone()
        .into_iter()
        .map(|[x, y, z]| [x + 1.0, y, z]);
    strip.positions.extend(right);
    strip.uvs.extend([[0.75, 0.5]; 4]);
    strip.triangles.extend([[4, 5, 6], [4, 6, 7]]);
    for (p, height) in moved(strip, halves, 0.4)
        .iter()
        .map(|p| (p, [0.0, 0.2, 0.4][(p[0] + 1.0) as usize]))
    {
        assert!((p[2] - height).abs() < 1e-6, "{p:?}");
    }
}

#[test]
fn a_scene_of_descriptions_is_refused_and_bad_displacements_are_named() {
    let scene = everything();
    let error = Renderer::new(&scene, &RenderSettings::new(8, 8))
        .expect_err("refused")
        .to_string();
    assert!(error.contains("texmap_mesh::tessellate"), "{error}");
    let refused = |change: fn(&mut Mesh)| {
        let mut scene = everything();
        scene.meshes[0].name = "wall".to_owned();
        change(&mut scene.meshes[0]);
        tessellate(scene, 8).expect_err("refused").to_string()
    };
    for (change, word) in [
        (
            (|m| m.displacement.as_mut().unwrap().height = f32::INFINITY) as fn(&mut Mesh),
            "height",
        ),
        (
            |m| m.displacement.as_mut().unwrap().middle = f32::NAN,
            "height",
        ),
        (
            |m| m.displacement.as_mut().unwrap().budget = EdgeBudget::Pixels(0.0),
            "longest edge",
        ),
        (
            |m| m.displacement.as_mut().unwrap().budget = EdgeBudget::Texels(f32::NAN),
            "longest edge",
        ),
        (
            |m| m.displacement.as_mut().unwrap().slot.texture = 9,
            "texture 9 does not exist",
        ),
        (
            |m| m.displacement.as_mut().unwrap().max_triangles = 50,
            "more than 50 triangles",
        ),
        (|m| m.uvs.clear(), "texture coordinates"),
    ] {
        let error = refused(change);
        assert!(error.contains("'wall'") && error.contains(word), "{error}");
    }
}

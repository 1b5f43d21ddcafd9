//! Environments captured from a point of a scene, and mirrors that lead their rays to the walls of a box.

use texmap_bake::{
    PlanarMirror, capture_environment, capture_environment_at, center_of, with_planar_mirrors,
};
use texmap_light::{Environment, Light, ReflectionBox};
use texmap_math::camera::Camera;
use texmap_math::glam::DVec3;
use texmap_render::{Aov, AovData, Frame, RenderSettings, no_progress, render};
use texmap_sample::{Alpha, ColorSpace, Image, Origin, TexelData, Texture2d};
use texmap_scene::{Emission, Material, Mesh, Reflection, Scene, Shading, TextureSlot};
use texmap_truth::{frame, frame_by_rays};

const HALF: f32 = 2.0;

/// A closed room whose walls shine in six colours, and a mirror away from its middle.
fn room() -> Scene {
    let camera = Camera {
        eye: DVec3::new(0.2, 0.3, 1.8),
        look: DVec3::new(0.9, -0.2, 0.1),
        up: DVec3::Y,
        fov_x: 0.9,
        near: 1e-3,
        far: f64::INFINITY,
        lens: Default::default(),
    };
    let mut scene = Scene::new(camera);
    scene.lights = vec![Light::Ambient { color: [0.0; 3] }];
    let colors = [
        [0.9, 0.1, 0.1],
        [0.1, 0.8, 0.2],
        [0.2, 0.2, 0.9],
        [0.8, 0.8, 0.1],
        [0.1, 0.7, 0.8],
        // Brighter than white.
        [2.5, 1.5, 3.0],
    ];
    for (side, color) in colors.into_iter().enumerate() {
        let (axis, sign) = (side / 2, if side % 2 == 0 { HALF } else { -HALF });
        let corner = |s: f32, t: f32| {
            let mut p = [0.0; 3];
            p[axis] = sign;
            p[(axis + 1) % 3] = s * HALF;
            p[(axis + 2) % 3] = t * HALF;
            p
        };
        scene.materials.push(Material {
            shading: Shading::PerPixel,
            emission: Some(Emission { color, map: None }),
            phong: texmap_light::PhongMaterial {
                color: [0.0; 3],
                ..Default::default()
            },
            ..Material::default()
        });
        scene.meshes.push(Mesh {
            name: format!("wall {side}"),
            material: side,
            ..Mesh::quad([
                corner(-1.0, -1.0),
                corner(1.0, -1.0),
                corner(1.0, 1.0),
                corner(-1.0, 1.0),
            ])
        });
    }
    scene
}

/// A surface that shows nothing but what it mirrors.
fn black(reflection: Option<Reflection>) -> Material {
    Material {
        phong: texmap_light::PhongMaterial {
            color: [0.0; 3],
            ..Default::default()
        },
        reflection,
        ..Material::default()
    }
}

/// A mirror of the first environment.
fn mirror(reflectivity: f32, within: Option<ReflectionBox>) -> Option<Reflection> {
    Some(Reflection {
        environment: 0,
        reflectivity,
        within,
    })
}

/// Puts a ball away from the middle of the room that mirrors what a point beside it sees, led to the walls. Gives the walls.
fn add_ball(
    scene: &mut Scene,
    reflectivity: f32,
    (around, up): (u32, u32),
    seen: impl Fn(&Scene, DVec3) -> Environment,
) -> ReflectionBox {
    let center = [0.0, 0.2, -0.1];
    let environment = seen(scene, DVec3::from(center.map(f64::from)));
    scene.effects.environments.push(environment);
    let walls = ReflectionBox {
        low: [-HALF; 3],
        high: [HALF; 3],
        center,
    };
    scene
        .materials
        .push(black(mirror(reflectivity, Some(walls))));
    let mut ball = Mesh::sphere(around, up);
    ball.world_from_object = texmap_math::glam::DMat4::from_scale_rotation_translation(
        DVec3::splat(0.5),
        Default::default(),
        DVec3::new(0.9, -0.2, 0.1),
    );
    ball.material = scene.materials.len() - 1;
    scene.meshes.push(ball);
    walls
}

#[test]
fn a_point_sees_the_walls_in_linear_light() {
    let scene = room();
    let point = DVec3::new(0.4, -0.3, 0.5);
    let seen = capture_environment_at(&scene, point, &[], 16).unwrap();
    let colors = [
        [0.9, 0.1, 0.1],
        [0.1, 0.8, 0.2],
        [0.2, 0.2, 0.9],
        [0.8, 0.8, 0.1],
        [0.1, 0.7, 0.8],
        [2.5, 1.5, 3.0],
    ];
    let directions = [
        DVec3::X,
        -DVec3::X,
        DVec3::Y,
        -DVec3::Y,
        DVec3::Z,
        -DVec3::Z,
    ];
    for (direction, color) in directions.into_iter().zip(colors) {
        let light = seen.radiance(direction.as_vec3().to_array());
        let apart = (0..3)
            .map(|k| (light[k] - color[k]).abs())
            .fold(0.0, f32::max);
        assert!(apart < 1e-5, "{direction}: {light:?}");
    }
    // Edges of walls lie where the point sees them, not where the middle does.
    let edge = DVec3::new(2.0, 1.5, 0.0) - point;
    let light = seen.radiance(edge.as_vec3().to_array());
    assert!(light[0] > light[2], "{light:?}");
    // The environment of a mesh is that of its middle in codes of 8 bits, which end at 1.
    let clipped = capture_environment(&scene, 0, 16).unwrap();
    assert_eq!(center_of(&scene, &[0]).unwrap(), DVec3::new(2.0, 0.0, 0.0));
    let most = clipped.radiance([0.0, 0.0, -1.0]);
    assert!(most.iter().all(|c| *c <= 1.0), "{most:?}");
    assert!(capture_environment_at(&scene, point, &[6], 16).is_err());
    assert!(capture_environment_at(&scene, DVec3::NAN, &[], 16).is_err());
}

/// Mirror rays show the room itself: a mirror that leads its rays to the walls shows what they meet, and an environment that is infinitely
/// far does not.
#[test]
fn led_mirrors_show_what_rays_meet() {
    let mut scene = room();
    // Nothing is clipped on the way: light ends at 1.
    for material in &mut scene.materials {
        if let Some(emission) = &mut material.emission {
            emission.color = emission.color.map(|c| c.min(0.9));
        }
    }
    add_ball(&mut scene, 1.0, (32, 16), |scene, center| {
        capture_environment_at(scene, center, &[], 256).unwrap()
    });
    let size = (64, 48);
    let traced = frame_by_rays(&scene, size.0, size.1, 1).unwrap();
    let differing = |scene: &Scene| {
        let mapped = frame(scene, size.0, size.1, 1).unwrap();
        let codes = mapped.codes().into_iter().zip(traced.codes());
        codes.filter(|(a, b)| (a - b).abs() > 8.0).count()
    };
    // Walls of one colour each differ at their edges alone.
    let led = differing(&scene);
    scene.materials[6].reflection = mirror(1.0, None);
    let far = differing(&scene);
    assert!(led * 5 < far && far > 300, "{led} {far}");
    let plain = frame(&room(), size.0, size.1, 1).unwrap();
    let same = frame_by_rays(&room(), size.0, size.1, 1).unwrap();
    assert_eq!(
        plain.codes(),
        same.codes(),
        "without mirrors nothing changes"
    );
}

/// A mirror that leads its rays to the walls is that of the f64 frame, and without the walls it is another picture.
#[test]
fn led_mirrors_are_those_of_the_reference() {
    let mut scene = room();
    let walls = add_ball(&mut scene, 0.8, (24, 12), |scene, center| {
        let seen = capture_environment_at(scene, center, &[], 64).unwrap();
        seen.with_mips()
    });
    let settings = RenderSettings::new(96, 72);
    let drawn = render(&scene, &settings, &no_progress).unwrap();
    let truth = frame(&scene, 96, 72, 1).unwrap();
    let codes = truth.codes();
    let mut over = 0;
    for (i, (got, want)) in drawn.rgba.iter().zip(&codes).enumerate() {
        let pixel = i / 4;
        let (x, y) = (pixel % 96, pixel / 96);
        let inside = (1..95).contains(&x) && (1..71).contains(&y);
        let same = |p: usize| truth.seen[p] == truth.seen[pixel];
        if inside && same(pixel - 1) && same(pixel + 1) && same(pixel - 96) && same(pixel + 96) {
            // Levels of detail are f32 and their logarithm is off by .005 of a level.
            over += usize::from((f64::from(*got) - want).abs() > 2.01);
        }
    }
    assert!(over < 8, "{over} values");
    scene.materials[6].reflection = mirror(0.8, None);
    let far = render(&scene, &settings, &no_progress).unwrap();
    let differ = far
        .rgba
        .iter()
        .zip(&drawn.rgba)
        .filter(|(a, b)| a.abs_diff(**b) > 40);
    assert!(differ.count() > 300);
    // A point of capture outside of the walls is refused.
    let outside = ReflectionBox {
        center: [3.0, 0.0, 0.0],
        ..walls
    };
    scene.materials[6].reflection = mirror(0.8, Some(outside));
    let error = scene.check().unwrap_err().to_string();
    assert!(error.contains("box of the reflection"), "{error}");
}

/// A flat mirror shows what mirror rays meet, and nothing that lies behind it.
#[test]
fn flat_mirrors_show_what_rays_meet() {
    let mut scene = room();
    for material in &mut scene.materials {
        if let Some(emission) = &mut material.emission {
            emission.color = emission.color.map(|c| c.min(0.9));
        }
    }
    scene.materials.push(black(None));
    scene.camera.eye = DVec3::new(-1.2, 0.3, 1.2);
    scene.camera.look = DVec3::new(1.0, -0.1, 0.2);
    scene.camera.lens.center = [0.1, -0.05];
    // A tilted mirror in the room, and a board that reaches through its plane.
    let tilted = Mesh {
        name: "mirror".into(),
        material: 6,
        ..Mesh::quad([
            [0.9, -0.8, 0.9],
            [1.2, -0.8, -0.6],
            [1.3, 0.7, -0.6],
            [1.0, 0.7, 0.9],
        ])
    };
    let board = Mesh {
        name: "board".into(),
        material: 2,
        ..Mesh::quad([
            [0.2, -0.2, 0.1],
            [1.9, -0.2, 0.3],
            [1.9, 0.0, 0.3],
            [0.2, 0.0, 0.1],
        ])
    };
    scene.meshes.extend([tilted, board]);
    let size = (96, 72);
    let whole = |mesh| [PlanarMirror { mesh, share: 1.0 }];
    let mirrored = with_planar_mirrors(&scene, &whole(6), size).unwrap();
    assert!(
        mirrored
            .check()
            .unwrap()
            .iter()
            .all(|w| !w.contains("texture frame"))
    );
    let drawn = render(
        &mirrored,
        &RenderSettings::new(size.0, size.1),
        &no_progress,
    )
    .unwrap();
    // The reference: the same mesh as a mirror of an environment, traced.
    let sky = capture_environment_at(&scene, DVec3::ZERO, &[], 4).unwrap();
    scene.effects.environments.push(sky);
    scene.materials[6] = black(mirror(1.0, None));
    let truth = frame_by_rays(&scene, size.0, size.1, 1).unwrap();
    let codes = truth.codes();
    let (mut mirror_pixels, mut off) = (0, 0);
    for (i, seen) in truth.seen.iter().enumerate() {
        if seen.is_some_and(|(mesh, _)| mesh == 6) {
            mirror_pixels += 1;
            off += usize::from(
                (0..3).any(|k| (f64::from(drawn.rgba[4 * i + k]) - codes[4 * i + k]).abs() > 4.0),
            );
        }
    }
    // Pixels at the edges of walls, where half a pixel decides.
    assert!(
        mirror_pixels > 800 && off * 25 < mirror_pixels,
        "{off} of {mirror_pixels}"
    );
    // The side from which it is seen does not matter; a bent mesh and one with textures are refused.
    let bent = {
        let mut scene = scene.clone();
        scene.materials[6] = black(None);
        scene.meshes[6].positions[2][0] += 0.3;
        with_planar_mirrors(&scene, &whole(6), size)
            .unwrap_err()
            .to_string()
    };
    assert!(bent.contains("not flat"), "{bent}");
    let clear = {
        let mut scene = scene.clone();
        scene.materials[6].alpha = texmap_scene::AlphaMode::Blend;
        with_planar_mirrors(&scene, &whole(6), size)
            .unwrap_err()
            .to_string()
    };
    assert!(clear.contains("opaque"), "{clear}");
    assert!(with_planar_mirrors(&scene, &whole(9), size).is_err());
}

/// A mirror on a textured surface shows shares of its own colours and of what it mirrors, and the tiles of a floor mirror as one.
#[test]
fn textured_mirrors_mix_their_colours_with_what_they_mirror() {
    const FLOOR: usize = 3;
    const SHARE: f32 = 0.4;
    let mut scene = room();
    for material in &mut scene.materials {
        if let Some(emission) = &mut material.emission {
            emission.color = emission.color.map(|c| c.min(0.9));
        }
    }
    let texels: Vec<u8> = (0..64u32)
        .flat_map(|i| [40 + 3 * i as u8, 255 - 2 * i as u8, 90])
        .collect();
    scene.textures.push(
        Texture2d::new(&Image {
            width: 8,
            height: 8,
            channels: 3,
            texels: TexelData::U8(&texels),
            color: ColorSpace::Srgb,
            alpha: Alpha::Data,
            origin: Origin::TopLeft,
        })
        .unwrap(),
    );
    scene.materials[FLOOR] = Material {
        shading: Shading::Unlit,
        base_color: Some(TextureSlot::new(0)),
        ..Material::default()
    };
    scene.camera.eye = DVec3::new(-1.2, 0.3, 1.2);
    scene.camera.look = DVec3::new(1.0, -1.4, 0.2);
    scene.meshes.push(Mesh {
        name: "board".into(),
        material: 2,
        ..Mesh::quad([
            [0.2, -1.7, 0.1],
            [1.2, -1.7, 0.3],
            [1.2, -1.0, 0.3],
            [0.2, -1.0, 0.1],
        ])
    });
    let size = (96, 72);
    let draw = |scene: &Scene, share: f32, meshes: &[usize]| {
        let mirrors: Vec<_> = meshes
            .iter()
            .map(|mesh| PlanarMirror { mesh: *mesh, share })
            .collect();
        let scene = with_planar_mirrors(scene, &mirrors, size).unwrap();
        let mut settings = RenderSettings::new(size.0, size.1);
        settings.aovs.push(Aov::Mesh);
        render(&scene, &settings, &no_progress).unwrap()
    };
    let none = draw(&scene, SHARE, &[]);
    let own = draw(&scene, 0.0, &[FLOOR]);
    assert_eq!(own.rgba, none.rgba);
    let (all, some) = (draw(&scene, 1.0, &[FLOOR]), draw(&scene, SHARE, &[FLOOR]));
    // The layer leaves no trace in the arrays of what is seen.
    let AovData::U32(seen) = &some.aovs[0].2 else {
        panic!("numbers of meshes")
    };
    assert!(none.aovs[0].2 == some.aovs[0].2);
    let linear = |frame: &Frame, i: usize, k: usize| {
        f64::from(texmap_math::color::srgb_to_linear(
            f32::from(frame.rgba[4 * i + k]) / 255.0,
        ))
    };
    let share = f64::from(SHARE);
    let (mut pixels, mut added) = (0, 0);
    for (i, mesh) in seen.iter().enumerate() {
        let on_floor = *mesh == FLOOR as u32;
        for k in 0..3 {
            let (shown, a, b) = (linear(&some, i, k), linear(&own, i, k), linear(&all, i, k));
            let off = |light: f64| {
                let code = |x: f64| texmap_math::color::linear_to_srgb(x as f32) * 255.0;
                (code(light.min(1.0)) - code(shown)).abs()
            };
            match on_floor {
                // Each of the three frames is rounded to its codes.
                true => assert!(off(a * (1.0 - share) + b * share) <= 1.5, "pixel {i}"),
                false => assert_eq!(some.rgba[4 * i + k], none.rgba[4 * i + k]),
            }
            added += usize::from(on_floor && off(a + b * share) > 8.0);
        }
        pixels += usize::from(on_floor);
    }
    // Light that were added would be seen.
    assert!(pixels > 1000 && added > pixels, "{added} of {pixels}");
    let differs = |a: &Frame, b: &Frame| {
        let pixels = a
            .rgba
            .as_chunks::<4>()
            .0
            .iter()
            .zip(b.rgba.as_chunks::<4>().0);
        pixels
            .filter(|(a, b)| (0..3).any(|k| a[k].abs_diff(b[k]) > 2))
            .count()
    };
    assert!(differs(&own, &all) > 800);

    // Half of the floor is a mesh of its own, a little beside the plane by rounding.
    let mut tiles = scene.clone();
    let low = -HALF + 1e-6;
    tiles.meshes[FLOOR] = Mesh {
        material: FLOOR,
        ..Mesh::quad([
            [-HALF, -HALF, 0.0],
            [HALF, -HALF, 0.0],
            [HALF, -HALF, -HALF],
            [-HALF, -HALF, -HALF],
        ])
    };
    tiles.meshes.push(Mesh {
        material: FLOOR,
        ..Mesh::quad([
            [-HALF, low, HALF],
            [HALF, low, HALF],
            [HALF, low, 0.0],
            [-HALF, low, 0.0],
        ])
    });
    let both = draw(&tiles, 1.0, &[FLOOR, tiles.meshes.len() - 1]);
    let apart = differs(&both, &all);
    assert!(apart <= 12, "{apart} pixels");
}

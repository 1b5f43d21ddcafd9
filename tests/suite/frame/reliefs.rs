//! Turned normals: offset maps, procedural heights, and the units of a bump.

use texmap_light::{
    Heights, Light, NormalMapGreen, PhongMaterial, ShadowBias, Slope, encode_normal, encode_offsets,
};
use texmap_math::glam::{DMat4, DVec3};
use texmap_render::{Aov, Frame};
use texmap_sample::{
    Alpha, ColorSpace, Filter, Image, Origin, Pattern, TexelData, Texture2d, UvTransform,
};
use texmap_scene::SceneError;
use texmap_scene::{Material, Mesh, NormalDetail, ProceduralHeight, Scene, Shadow};
use texmap_tests::levels::levels;

use crate::scenes::{draw, draw_aovs, empty, of, pixel, quad, slot, values, wall};

const SIDE: u32 = 64;

fn floats(channels: u32, texels: &[f32]) -> Texture2d<'static> {
    let image = Image {
        width: SIDE,
        height: texels.len() as u32 / SIDE / channels,
        channels,
        texels: TexelData::F32(texels),
        color: ColorSpace::Linear,
        alpha: Alpha::Straight,
        origin: Origin::TopLeft,
    };
    Texture2d::new(&image).unwrap()
}

fn matte(detail: NormalDetail) -> Material {
    Material {
        phong: PhongMaterial {
            color: [1.0; 3],
            ka: 0.0,
            kd: 1.0,
            ks: 0.0,
            ns: 1.0,
        },
        normal_detail: Some(detail),
        ..Material::default()
    }
}

/// Heights of uneven waves, twice as wide as high: four across, one down.
fn waves() -> Vec<f32> {
    let turn = |i: u32, of: u32| (f64::from(i) + 0.5) / f64::from(of) * std::f64::consts::TAU;
    (0..SIDE * SIDE / 2)
        .map(|i| {
            let (u, v) = (4.0 * turn(i % SIDE, SIDE), turn(i / SIDE, SIDE / 2));
            (0.5 + 0.3 * u.sin() + 0.2 * v.cos()) as f32
        })
        .collect()
}

/// Uneven waves on a wall, as heights, as offsets in floats and as offsets in bytes; and the slope of the latter two.
fn wavy() -> (Scene, f32) {
    let grid = waves();
    let heights = Heights {
        width: SIDE,
        values: &grid,
    };
    let (offsets, slope) = heights
        .offsets(Slope::Central, 0.4, NormalMapGreen::Up)
        .unwrap();
    let pairs: Vec<f32> = offsets
        .iter()
        .flat_map(|o| {
            let [r, g] = encode_offsets(*o);
            [r, g, 0.0]
        })
        .collect();
    let bytes = offsets
        .iter()
        .flat_map(|o| {
            let [r, g] = encode_offsets(*o).map(|c| (c * 255.0 + 0.5) as u8);
            [r, g, 0, 255]
        })
        .collect();
    let bytes =
        Texture2d::from_rgba8(SIDE, SIDE / 2, bytes, ColorSpace::Linear, Origin::TopLeft).unwrap();
    let scene = Scene {
        lights: vec![Light::Directional {
            color: [0.8; 3],
            direction: [0.5, -0.4, -1.0],
        }],
        textures: vec![floats(1, &grid), floats(3, &pairs), bytes],
        ..of(Material::default(), wall(2.0, 2.5))
    };
    (scene, slope)
}

fn bump() -> NormalDetail {
    NormalDetail::Bump {
        slot: slot(0, Filter::Bilinear).unwrap(),
        height: 0.4,
    }
}

fn offsets(texture: usize, slope: f32, green: NormalMapGreen) -> NormalDetail {
    NormalDetail::Offsets {
        slot: slot(texture, Filter::Bilinear).unwrap(),
        slope,
        green,
    }
}

fn most(a: &Frame, b: &Frame) -> u8 {
    let each = a.rgba.iter().zip(&b.rgba).map(|(a, b)| a.abs_diff(*b));
    each.max().unwrap()
}

/// An offset map of a height field is that height field's bump map. Texel centres hold its differences, bilinear filters of both
/// agree between them.
#[test]
fn offsets_are_the_bump_map_of_their_heights() {
    for origin in [Origin::TopLeft, Origin::BottomLeft] {
        let (mut scene, slope) = wavy();
        scene.meshes[0].uv_origin = origin;
        let mut with = |detail: NormalDetail| {
            scene.materials[0] = matte(detail);
            draw(&scene, 120, 120)
        };
        let bumped = with(bump());
        let flat = with(offsets(1, 0.0, NormalMapGreen::Up));
        assert!(most(&bumped, &flat) > 40, "the waves are seen");
        let exact = with(offsets(1, slope, NormalMapGreen::Up));
        assert!(most(&bumped, &exact) <= 1, "{}", most(&bumped, &exact));
        let coarse = with(offsets(2, slope, NormalMapGreen::Up));
        assert!(most(&bumped, &coarse) <= 4, "{}", most(&bumped, &coarse));
        // Negative twins: green the wrong way round, and inside out.
        for wrong in [
            offsets(1, slope, NormalMapGreen::Down),
            offsets(1, -slope, NormalMapGreen::Up),
        ] {
            assert!(most(&bumped, &with(wrong)) > 10);
        }
    }
}

/// So is its normal map, whichever way v grows: the green channel means the picture's own up.
#[test]
fn normals_are_the_bump_map_of_their_heights() {
    let (mut scene, _) = wavy();
    let grid = waves();
    let heights = Heights {
        width: SIDE,
        values: &grid,
    };
    // Texels are squares of 4 / 64 on this wall.
    let strength = 0.4 / 4.0 * SIDE as f32;
    let normals = heights
        .normals(Slope::Central, strength, NormalMapGreen::Up)
        .unwrap();
    let texels: Vec<f32> = normals
        .iter()
        .flat_map(|n| encode_normal(*n, NormalMapGreen::Up))
        .collect();
    scene.textures.push(floats(3, &texels));
    scene.meshes[0] = quad([
        [-2.0, -1.0, -2.5],
        [2.0, -1.0, -2.5],
        [2.0, 1.0, -2.5],
        [-2.0, 1.0, -2.5],
    ]);
    let map = |green| NormalDetail::NormalMap {
        slot: slot(3, Filter::Bilinear).unwrap(),
        green,
        rebuild_z: false,
        object_space: false,
        strength: 1.0,
    };
    for origin in [Origin::TopLeft, Origin::BottomLeft] {
        scene.meshes[0].uv_origin = origin;
        let mut with = |detail: NormalDetail| {
            scene.materials[0] = matte(detail);
            draw(&scene, 120, 120)
        };
        let bumped = with(bump());
        let mapped = with(map(NormalMapGreen::Up));
        assert!(most(&bumped, &mapped) <= 3, "{}", most(&bumped, &mapped));
        assert!(most(&bumped, &with(map(NormalMapGreen::Down))) > 10);
    }
}

/// Normals of the object go to the world by the inverse transpose. Under an uneven scale a map of them is what the mesh's own normals
/// are, and the matrix itself would be another picture.
#[test]
fn object_space_normals_follow_an_uneven_scale() {
    let normal = DVec3::new(0.3, 0.5, 1.0).normalize();
    let (right, up) = normal.any_orthonormal_pair();
    let corner = |s: f64, t: f64| {
        let p = right * s + up * t;
        p.as_vec3().to_array()
    };
    let mut mesh = quad([
        corner(-1.0, -1.0),
        corner(1.0, -1.0),
        corner(1.0, 1.0),
        corner(-1.0, 1.0),
    ]);
    mesh.normals = vec![normal.as_vec3().to_array(); 4];
    let scale = DVec3::new(3.0, 0.5, 1.0);
    mesh.world_from_object =
        DMat4::from_translation(DVec3::new(0.0, 0.0, -3.0)) * DMat4::from_scale(scale);
    let texel = encode_normal(normal.as_vec3().to_array(), NormalMapGreen::Up);
    let texels = texel.repeat((SIDE * 2) as usize);
    let detail = NormalDetail::NormalMap {
        slot: slot(0, Filter::Bilinear).unwrap(),
        green: NormalMapGreen::Up,
        rebuild_z: false,
        object_space: true,
        strength: 1.0,
    };
    let mut scene = Scene {
        lights: vec![Light::Directional {
            color: [0.9; 3],
            direction: [0.5, -0.6, -1.0],
        }],
        textures: vec![floats(3, &texels)],
        ..of(matte(detail), mesh)
    };
    let mapped = draw(&scene, 60, 60);
    scene.materials[0].normal_detail = None;
    let own = draw(&scene, 60, 60);
    assert!(most(&mapped, &own) <= 1, "{}", most(&mapped, &own));
    let truth = (normal / scale)
        .normalize()
        .dot(DVec3::new(-0.5, 0.6, 1.0).normalize());
    let [code, ..] = pixel(&own, 30, 30);
    assert!(
        (f64::from(code) - 0.9 * 255.0 * truth).abs() <= 1.0,
        "{code}"
    );
    let wrong = (normal * scale)
        .normalize()
        .dot(DVec3::new(-0.5, 0.6, 1.0).normalize());
    assert!((wrong - truth).abs() > 0.1, "the matrix itself is far off");
}

/// A lone plane under an uneven scale casts no shadow on itself. The slope of the bias is that of its plane in the world.
#[test]
fn the_slope_of_a_scaled_plane_keeps_it_lit() {
    let mut mesh = quad([
        [-2.0, -2.0, 2.0],
        [2.0, -2.0, 2.0],
        [2.0, 2.0, -2.0],
        [-2.0, 2.0, -2.0],
    ]);
    mesh.world_from_object = DMat4::from_translation(DVec3::new(0.0, -0.5, -4.0))
        * DMat4::from_scale(DVec3::new(1.0, 0.15, 1.0));
    let mut scene = Scene {
        lights: vec![Light::Directional {
            color: [1.0; 3],
            direction: [0.0, -0.3, -1.0],
        }],
        ..of(Material::default(), mesh)
    };
    scene.effects.shadows = vec![Shadow {
        light: 0,
        size: Some(48),
        bias: None,
        pcf_size: 1,
        area: None,
    }];
    let dark = |scene: &Scene| {
        let frame = draw_aovs(scene, 120, 120, &[Aov::Shadow(0)]);
        let shares = (0..120 * 120).map(|i| values(&frame, Aov::Shadow(0), i % 120, i / 120)[0]);
        let seen = shares.filter(|s| s.is_finite());
        let (dark, all) = seen.fold((0, 0), |(d, n), s| (d + u32::from(s < 1.0), n + 1));
        assert!(all > 500, "{all}");
        dark
    };
    assert_eq!(dark(&scene), 0);
    scene.effects.shadows[0].bias = Some(ShadowBias::Constant(1e-4));
    assert!(dark(&scene) > 100, "without the slope there is acne");
}

/// Heights count in the mesh's own units: a model ten times as large, seen from ten times as far, looks the same.
#[test]
fn heights_grow_with_the_model() {
    let (scene, slope) = wavy();
    let carved = NormalDetail::Procedural {
        heights: ProceduralHeight::Pattern(Pattern::Noise { octaves: 3 }),
        world_from_solid: DMat4::from_scale(DVec3::splat(0.3)),
        height: 0.1,
    };
    for detail in [bump(), offsets(1, slope, NormalMapGreen::Up), carved] {
        let mut small = scene.clone();
        small.materials[0] = matte(detail.clone());
        let mut large = small.clone();
        let ten = DMat4::from_scale(DVec3::splat(10.0));
        large.meshes[0].world_from_object = ten;
        if let Some(NormalDetail::Procedural {
            world_from_solid, ..
        }) = &mut large.materials[0].normal_detail
        {
            *world_from_solid = ten * *world_from_solid;
        }
        let small = draw(&small, 90, 90);
        let difference = most(&small, &draw(&large, 90, 90));
        assert!(difference <= 1, "{detail:?}: {difference}");
    }
    // A tenth of the height is another picture.
    let mut low = scene.clone();
    low.materials[0] = matte(NormalDetail::Bump {
        slot: slot(0, Filter::Bilinear).unwrap(),
        height: 0.04,
    });
    let mut high = scene;
    high.materials[0] = matte(bump());
    assert!(most(&draw(&low, 90, 90), &draw(&high, 90, 90)) > 30);
}

/// A pipe of radius 1 about the y axis before the camera, with smooth normals.
fn pipe() -> Mesh {
    let around = 256u32;
    let mut mesh = Mesh::default();
    for i in 0..=around {
        let a = f64::from(i % around) / f64::from(around) * std::f64::consts::TAU;
        for y in [-2.0, 2.0] {
            mesh.positions
                .push([a.cos() as f32, y, a.sin() as f32 - 3.0]);
            mesh.normals.push([a.cos() as f32, 0.0, a.sin() as f32]);
        }
    }
    for i in 0..around {
        let a = 2 * i;
        mesh.triangles
            .extend([[a, a + 1, a + 3], [a, a + 3, a + 2]]);
    }
    mesh
}

fn dimples(around: u16, fold: f32) -> NormalDetail {
    NormalDetail::Procedural {
        heights: ProceduralHeight::Waves { around, fold },
        world_from_solid: DMat4::from_translation(DVec3::new(0.0, 0.0, -3.0))
            * DMat4::from_scale(DVec3::new(1.0, 0.5, 1.0)),
        height: 0.04,
    }
}

/// Waves in cylindrical space leave the normal of the displaced pipe, by the derivative of its closed form; also across the seam.
#[test]
fn waves_in_cylindrical_space_have_their_exact_normals() {
    let toward = DVec3::new(0.4, 0.5, 1.0).normalize();
    let mut scene = Scene {
        lights: vec![Light::Directional {
            color: [1.0; 3],
            direction: (-toward).as_vec3().to_array(),
        }],
        ..of(matte(dimples(12, 0.0)), pipe())
    };
    let truth = |p: DVec3, around: f64| {
        let angle = (p.z + 3.0).atan2(p.x);
        let (out, turn) = (
            DVec3::new(angle.cos(), 0.0, angle.sin()),
            DVec3::new(-angle.sin(), 0.0, angle.cos()),
        );
        let wave = std::f64::consts::TAU / 0.5;
        let by_angle = -0.02 * around * (around * angle).sin() * (wave * p.y).cos();
        let by_y = -0.02 * wave * (around * angle).cos() * (wave * p.y).sin();
        let n = (out - turn * by_angle - DVec3::Y * by_y).normalize();
        n.dot(toward).max(0.0) * 255.0
    };
    // The middle of the picture sees a = pi / 2; turned by half a turn it sees the seam of the angle.
    for turned in [false, true] {
        if turned {
            scene.camera.eye = DVec3::new(-3.0, 0.0, -3.0);
            scene.camera.look = DVec3::new(0.0, 0.0, -3.0);
        }
        let frame = draw_aovs(&scene, 200, 200, &[Aov::Position]);
        let (mut seen, mut worst, mut other) = (0, 0.0f64, 0.0f64);
        for (x, y) in (0..200).flat_map(|y| (0..200).map(move |x| (x, y))) {
            let p = values(&frame, Aov::Position, x, y);
            let p = DVec3::new(p[0].into(), p[1].into(), p[2].into());
            // At the outline pixels are wide, and waves fade.
            let facing = DVec3::new(p.x, 0.0, p.z + 3.0).normalize_or_zero();
            let facing = facing.dot((scene.camera.eye - p).normalize_or_zero());
            if !p.is_finite() || facing < 0.5 {
                continue;
            }
            seen += 1;
            let found = f64::from(pixel(&frame, x, y)[0]);
            worst = worst.max((found - truth(p, 12.0)).abs());
            other = other.max((found - truth(p, 11.0)).abs());
        }
        assert!(seen > 5_000, "{seen}");
        assert!(worst < 4.0, "{worst}");
        assert!(other > 60.0, "a wave less is another picture: {other}");
    }
}

/// Every formula leaves something, the same on all levels and threads, and nothing that is not finite: at the axis, at one pixel
/// for many waves, on a face without a normal.
#[test]
fn carved_heights_are_steady_everywhere() {
    let formulas = [
        ProceduralHeight::Waves {
            around: 9,
            fold: 0.3,
        },
        ProceduralHeight::Pattern(Pattern::Noise { octaves: 4 }),
        ProceduralHeight::Pattern(Pattern::Marble {
            octaves: 3,
            turbulence: 0.5,
        }),
        ProceduralHeight::Pattern(Pattern::Wood { grain: 0.2 }),
    ];
    let lights = vec![Light::Point {
        color: [1.0; 3],
        position: [1.0, 1.0, 0.0],
    }];
    for heights in formulas {
        let detail = |height| NormalDetail::Procedural {
            heights,
            // The axis of the waves stands on the wall.
            world_from_solid: DMat4::from_rotation_x(std::f64::consts::FRAC_PI_2)
                * DMat4::from_scale(DVec3::splat(0.4)),
            height,
        };
        let mut scene = Scene {
            lights: lights.clone(),
            ..of(matte(detail(0.05)), wall(2.0, 2.0))
        };
        let bumped = draw(&scene, 80, 80);
        for (name, level) in levels() {
            let settings = texmap_render::RenderSettings {
                level,
                threads: Some(3),
                ..texmap_render::RenderSettings::new(80, 80)
            };
            let frame =
                texmap_render::render(&scene, &settings, &texmap_render::no_progress).unwrap();
            assert!(frame.rgba == bumped.rgba, "{heights:?} {name}");
        }
        scene.materials[0] = matte(detail(0.0));
        let flat = draw(&scene, 80, 80);
        assert!(most(&bumped, &flat) > 10, "{heights:?}");
        // From afar a pixel sees many waves: their mean.
        scene.materials[0] = matte(NormalDetail::Procedural {
            heights,
            world_from_solid: DMat4::from_scale(DVec3::splat(1e-4)),
            height: 1e-5,
        });
        let far = draw(&scene, 80, 80);
        let quiet = far.rgba.iter().zip(&flat.rgba);
        assert!(
            quiet.clone().all(|(a, b)| a.abs_diff(*b) <= 12),
            "{heights:?}"
        );
        scene.meshes[0].normals = vec![[0.0; 3]; 4];
        scene.lights.push(Light::Ambient { color: [0.1; 3] });
        draw(&scene, 80, 80);
    }
}

#[test]
fn faults_of_reliefs_are_named() {
    let refused = |detail: NormalDetail| {
        let (mut scene, _) = wavy();
        scene.materials[0] = matte(detail);
        scene.check().unwrap_err()
    };
    let text = |detail: NormalDetail| refused(detail).to_string();
    assert!(text(offsets(1, f32::NAN, NormalMapGreen::Up)).contains("slope of the offset map"));
    assert!(matches!(
        refused(offsets(9, 1.0, NormalMapGreen::Up)),
        SceneError::Index { .. }
    ));
    assert!(text(dimples(0, 0.0)).contains("waves around"));
    assert!(text(dimples(3, f32::INFINITY)).contains("fold"));
    let carved = |world_from_solid, height| NormalDetail::Procedural {
        heights: ProceduralHeight::Pattern(Pattern::Noise { octaves: 1 }),
        world_from_solid,
        height,
    };
    assert!(text(carved(DMat4::IDENTITY, f32::NAN)).contains("carved height"));
    let flat = DMat4::from_scale(DVec3::new(1.0, 0.0, 1.0));
    assert!(text(carved(flat, 1.0)).contains("placement of the carved height"));
    // An offset map needs coordinates, a formula none.
    let (mut scene, _) = wavy();
    scene.meshes[0].uvs.clear();
    scene.materials[0] = matte(carved(DMat4::IDENTITY, 1.0));
    assert!(scene.check().is_ok());
    scene.materials[0] = matte(offsets(1, 1.0, NormalMapGreen::Up));
    assert!(matches!(scene.check(), Err(SceneError::MissingUv { .. })));
}

/// Names of lights lead to their shadows, and what is wrong with them is said.
#[test]
fn lights_have_names() {
    let mut scene = Scene {
        lights: vec![Light::Ambient { color: [0.1; 3] }; 3],
        ..empty()
    };
    let error = Aov::shadow_of(&scene, "sun").unwrap_err();
    assert!(
        error
            .to_string()
            .contains("no light is called 'sun'; there are no names")
    );
    scene.effects.light_names = vec![String::new(), "sun".into(), "lamp-2".into()];
    assert_eq!(Aov::shadow_of(&scene, "lamp-2"), Ok(Aov::Shadow(2)));
    let error = Aov::shadow_of(&scene, "moon").unwrap_err();
    assert_eq!(
        error.to_string(),
        "no light is called 'moon'; there are 'sun' (light 1), 'lamp-2' (light 2)"
    );
    assert!(scene.check().is_ok());
    for names in [&["a", "a"][..], &["1"], &["a b"], &["", "", "", "lost"]] {
        scene.effects.light_names = names.iter().map(ToString::to_string).collect();
        let error = scene.check().unwrap_err();
        assert!(error.to_string().contains("name is '"), "{error}");
    }
}

/// Relief belongs to the front of a surface. Seen from behind, a tilt of the front's normals is that of the same sheet, by its closed form, and
/// the picture of waves is that of the turned mesh with dents instead.
#[test]
fn bumps_of_the_front_are_dents_of_the_back() {
    let (mut scene, slope) = wavy();
    scene.camera.look = DVec3::new(0.0, 0.0, -2.5);
    let eyes = [DVec3::ZERO, DVec3::new(0.0, 0.0, -5.0)];
    // A rise of 1 in 4 to the right (u), of 1 in 8 up, on a wall of 4 x 4 units in the plane z = -2.5.
    let tilted = DVec3::new(-0.25, -0.125, 1.0).normalize();
    let code = encode_normal(tilted.as_vec3().to_array(), NormalMapGreen::Up);
    let offset = encode_offsets([1.0, 0.5]);
    scene.textures.push(floats(3, &code.repeat(SIDE as usize)));
    let offset = [offset[0], offset[1], 0.0];
    scene
        .textures
        .push(floats(3, &offset.repeat(SIDE as usize)));
    let map = |object_space| NormalDetail::NormalMap {
        slot: slot(3, Filter::Bilinear).unwrap(),
        green: NormalMapGreen::Up,
        rebuild_z: false,
        object_space,
        strength: 1.0,
    };
    for detail in [map(false), map(true), offsets(4, 1.0, NormalMapGreen::Up)] {
        for (eye, side) in eyes.into_iter().zip([1.0, -1.0]) {
            let toward = DVec3::new(0.7, 0.3, 0.6 * side).normalize();
            scene.lights = vec![Light::Directional {
                color: [1.0; 3],
                direction: (-toward).as_vec3().to_array(),
            }];
            scene.camera.eye = eye;
            scene.materials[0] = matte(detail.clone());
            let found = f64::from(pixel(&draw(&scene, 60, 60), 30, 30)[0]);
            let cosine = |n: DVec3| 255.0 * n.dot(toward);
            let truth = cosine(tilted * side);
            assert!(
                (found - truth).abs() <= 1.0,
                "{detail:?} {side}: {found} {truth}"
            );
            // A bump of both sides.
            let twin = cosine(DVec3::new(tilted.x, tilted.y, tilted.z * side));
            assert!(side > 0.0 || (found - twin).abs() > 20.0, "{twin}");
        }
    }
    scene.camera.eye = eyes[1];
    let carved = |height| NormalDetail::Procedural {
        heights: ProceduralHeight::Pattern(Pattern::Noise { octaves: 3 }),
        world_from_solid: DMat4::from_scale(DVec3::splat(0.3)),
        height,
    };
    let bumped = |height| NormalDetail::Bump {
        slot: slot(0, Filter::Bilinear).unwrap(),
        height,
    };
    let sloping = |slope| offsets(1, slope, NormalMapGreen::Up);
    let mut turned = scene.clone();
    for triangle in &mut turned.meshes[0].triangles {
        triangle.swap(1, 2);
    }
    for (bump, dent) in [
        (carved(0.1), carved(-0.1)),
        (bumped(0.4), bumped(-0.4)),
        (sloping(slope), sloping(-slope)),
    ] {
        scene.materials[0] = matte(bump.clone());
        let back = draw(&scene, 90, 90);
        let mut with = |detail| {
            turned.materials[0] = matte(detail);
            most(&back, &draw(&turned, 90, 90))
        };
        let difference = with(dent);
        assert!(difference <= 1, "{bump:?}: {difference}");
        assert!(with(bump) > 20);
    }
}

/// A normal map whose slot turns and mirrors its coordinates is the map on coordinates that are so already: made tangents follow.
#[test]
fn made_tangents_follow_the_transform_of_their_map() {
    let (mut scene, _) = wavy();
    let tilted = DVec3::new(-0.5, -0.2, 1.0).normalize();
    let code = encode_normal(tilted.as_vec3().to_array(), NormalMapGreen::Up);
    scene.textures.push(floats(3, &code.repeat(SIDE as usize)));
    let picture = |transform: UvTransform, baked: bool| {
        let mut scene = scene.clone();
        let mut map = slot(3, Filter::Bilinear).unwrap();
        if baked {
            for uv in &mut scene.meshes[0].uvs {
                *uv = transform.apply(*uv);
            }
        } else {
            map.transform = transform;
        }
        scene.materials[0] = matte(NormalDetail::NormalMap {
            slot: map,
            green: NormalMapGreen::Up,
            rebuild_z: false,
            object_space: false,
            strength: 1.0,
        });
        draw(&scene, 40, 40)
    };
    let plain = picture(UvTransform::default(), false);
    let turned = |rotation, scale| UvTransform {
        rotation,
        scale,
        ..UvTransform::default()
    };
    for transform in [
        turned(std::f32::consts::FRAC_PI_2, [1.0, 1.0]),
        turned(0.3, [2.0, 0.5]),
        turned(0.0, [-1.0, 1.0]),
        turned(0.0, [1.0, -3.0]),
    ] {
        let (found, expected) = (picture(transform, false), picture(transform, true));
        assert!(most(&found, &expected) <= 1, "{transform:?}");
        assert!(most(&found, &plain) > 10, "{transform:?}");
    }
    // Scales alone turn nothing.
    let scaled = picture(turned(0.0, [3.0, 0.7]), false);
    assert_eq!(most(&scaled, &plain), 0);
}

//! Metallic-roughness surfaces under lights and environments, second sets of coordinates, and tone mapping.

use texmap_light::reference::metallic_roughness::Reflectance;
use texmap_light::{
    Environment, EnvironmentLayout, EnvironmentLight, Light, MetallicRoughnessSurface,
    NormalMapGreen, PhongMaterial, ToneMap, dielectric_f0, lanes,
};
use texmap_math::glam::DVec3;
use texmap_render::{Aov, RenderSettings, Renderer, no_progress, render};
use texmap_sample::Filter;
use texmap_scene::{
    AlphaMode, Background, Clearcoat, ColorMode, Effects, Emission, Material, Mesh,
    MetallicRoughness, NormalDetail, Scene, SceneError, Shading, Shadow, Sheen, TextureSlot,
    ToneMapping, Transmission, UvSet,
};
use texmap_tests::levels::levels;

use crate::scenes::{self, draw, draw_aovs, pixel, slot, texture, values, wall};

fn metallic(color: [f32; 3], model: MetallicRoughness) -> Material {
    Material {
        phong: PhongMaterial {
            color,
            ..PhongMaterial::default()
        },
        metallic_roughness: Some(model),
        ..Material::default()
    }
}

/// A mesh of one material, with colours in sRGB.
fn of(material: Material, mesh: Mesh) -> Scene {
    Scene {
        color: ColorMode::Srgb,
        ..scenes::of(material, mesh)
    }
}

fn sun(color: [f32; 3]) -> Light {
    Light::Directional {
        color,
        direction: [0.3, -0.4, -1.0],
    }
}

fn second(texture: usize) -> Option<TextureSlot> {
    slot(texture, Filter::Trilinear).map(|slot| TextureSlot {
        uv_set: UvSet::Second,
        ..slot
    })
}

/// A linear value as a byte of sRGB.
fn stored(c: f64) -> f64 {
    let c = c.clamp(0.0, 1.0);
    255.0
        * if c <= 0.003_130_8 {
            12.92 * c
        } else {
            1.055 * texmap_math::deterministic_f64::pow(c, 1.0 / 2.4) - 0.055
        }
}

#[test]
fn a_light_gives_each_pixel_what_the_reference_says() {
    for (metalness, roughness) in [(0.0f32, 0.3f32), (1.0, 0.5), (0.5, 0.9)] {
        let color = [0.8, 0.4, 0.2];
        let model = MetallicRoughness {
            metallic: metalness,
            roughness,
            ..MetallicRoughness::default()
        };
        let scene = Scene {
            lights: vec![sun([0.6, 0.5, 0.4])],
            ..of(metallic(color, model), wall(1.5, 1.5))
        };
        let surface = MetallicRoughnessSurface {
            f0: dielectric_f0(1.5, 1.0, [1.0; 3]),
            ..MetallicRoughnessSurface::new(texmap_math::simd::Scalar, color, metalness, roughness)
        };
        let reflectance = Reflectance::new(&surface);
        let frame = draw_aovs(&scene, 33, 33, &[Aov::Position]);
        for (x, y) in [(2, 3), (16, 16), (30, 9), (20, 28)] {
            let point = values(&frame, Aov::Position, x, y);
            let view = -DVec3::new(point[0].into(), point[1].into(), point[2].into()).normalize();
            let toward = DVec3::new(-0.3, 0.4, 1.0).normalize();
            let light = reflectance.brdf(DVec3::Z, DVec3::Z, view, toward)
                * (std::f64::consts::PI * toward.z);
            for (k, color) in [0.6, 0.5, 0.4].into_iter().enumerate() {
                let expected = stored(light[k] * color);
                let got = f64::from(pixel(&frame, x, y)[k]);
                assert!(
                    (got - expected).abs() < 1.5,
                    "{metalness} {roughness} {x} {y}: {got} {expected}"
                );
            }
        }
    }
}

/// Each pixel of the background is the environment light as a mirror shows it, turned with it and under exposure and curve.
#[test]
fn the_light_behind_a_scene_is_that_of_its_mirrors() {
    let sky = |d: DVec3| [0.5 + 0.4 * d.x, 0.5 + 0.4 * d.y, 0.4 + 0.3 * d.z].map(|c| c as f32);
    let sky = Environment::from_fn(EnvironmentLayout::Cube, 64, sky).unwrap();
    let light = EnvironmentLight::new(&sky, 64).unwrap().turned(0.7);
    for (light, exposure, map) in [
        (light.clone(), 1.0, ToneMap::None),
        (light.clone().upright_on_z(), 0.8, ToneMap::PbrNeutral),
    ] {
        let mut scene = of(scenes::unlit([1.0; 3]), wall(0.2, 5.0));
        scene.effects.background = Some(Background::EnvironmentLight);
        assert!(scene.check().is_err(), "there is none yet");
        scene.effects.environment_light = Some(light.clone());
        scene.effects.tone_mapping = ToneMapping { exposure, map };
        scene.camera.look = scene.camera.eye + DVec3::new(0.6, 0.3, -1.0);
        let frames = levels().into_iter().map(|(_, level)| {
            let settings = RenderSettings {
                level,
                ..RenderSettings::new(32, 24)
            };
            render(&scene, &settings, &no_progress).unwrap()
        });
        let frames: Vec<_> = frames.collect();
        assert!(frames.iter().all(|frame| frame.rgba == frames[0].rgba));
        for (x, y) in [(1, 1), (30, 3), (5, 20), (29, 22)] {
            let (u, v) = (f64::from(x) + 0.5, f64::from(y) + 0.5);
            let d = scene.camera.ray(32, 24, u, v).unwrap();
            let d = d.to_array().map(|c| c as f32);
            let seen = map.apply(exposure, light.radiance(0.0, d));
            let unturned = map.apply(exposure, light.clone().turned(0.0).radiance(0.0, d));
            let off = |light: [f32; 3]| {
                let each = (0..3).map(|k| {
                    (f64::from(pixel(&frames[0], x, y)[k]) - stored(light[k].into())).abs()
                });
                each.fold(0.0, f64::max)
            };
            assert!(off(seen) < 1.5, "{x} {y}: {}", off(seen));
            assert!(off(unturned) > 5.0, "{x} {y}");
        }
    }
}

/// Every map, both sets of coordinates, every layer, a shadow, an environment and a curve.
fn everything() -> Scene {
    let picture = texture(32, 32, |x, y| [(x * 8) as u8, (y * 8) as u8, 200, 255]);
    let numbers = texture(16, 16, |x, y| {
        [(x * 16) as u8, (y * 16) as u8, (x * y) as u8, 255]
    });
    let normals = texture(16, 16, |x, y| {
        [(100 + x * 4) as u8, (100 + y * 4) as u8, 240, 255]
    });
    let holes = texture(8, 8, |x, y| {
        [255, 255, 255, if (x + y) % 2 == 0 { 255 } else { 0 }]
    });
    let bilinear = |texture| slot(texture, Filter::Bilinear);
    let model = MetallicRoughness {
        metallic: 0.9,
        roughness: 0.8,
        map: bilinear(1),
        occlusion: bilinear(1).map(|slot| (slot, 0.7)),
        ior: 1.6,
        specular: 0.9,
        specular_map: second(1),
        specular_color: [1.0, 0.8, 0.7],
        specular_color_map: bilinear(0),
        clearcoat: Some(Clearcoat {
            factor: 0.6,
            map: bilinear(1),
            roughness: 0.4,
            roughness_map: second(1),
        }),
        sheen: Some(Sheen {
            color: [0.3, 0.2, 0.4],
            color_map: bilinear(0),
            roughness: 0.6,
            roughness_map: bilinear(1),
        }),
        transmission: None,
    };
    let floor = Material {
        base_color: second(0),
        normal_detail: Some(NormalDetail::NormalMap {
            slot: second(2).unwrap(),
            green: NormalMapGreen::Up,
            rebuild_z: false,
            object_space: false,
            strength: 1.0,
        }),
        emission: Some(Emission {
            color: [0.05, 0.0, 0.02],
            map: second(0),
        }),
        ..metallic([0.9, 0.8, 0.7], model.clone())
    };
    let plate = Material {
        base_color: second(3),
        alpha: AlphaMode::Test(0.5),
        ..metallic(
            [0.7; 3],
            MetallicRoughness {
                occlusion: second(1).map(|slot| (slot, 1.0)),
                ..model.clone()
            },
        )
    };
    let pane = Material {
        alpha: AlphaMode::Blend,
        opacity: 0.9,
        ..metallic(
            [0.6, 0.9, 0.7],
            MetallicRoughness {
                metallic: 0.1,
                roughness: 0.4,
                transmission: Some(Transmission {
                    factor: 0.9,
                    map: second(1),
                }),
                ..model
            },
        )
    };
    let mut back = wall(1.6, 3.0);
    back.lightmap_uvs = back.uvs.iter().map(|[u, v]| [v * 2.0, 1.0 - u]).collect();
    back.colors = vec![[1.0, 0.9, 0.8]; back.positions.len()];
    let mut front = wall(0.5, 1.8);
    front.lightmap_uvs = front.uvs.iter().map(|[u, v]| [u * 0.7, v * 0.8]).collect();
    front.material = 1;
    let mut glass = wall(0.4, 1.4);
    glass.lightmap_uvs = glass.uvs.iter().map(|[u, v]| [*v, *u]).collect();
    glass.material = 2;
    Scene {
        lights: vec![
            Light::Ambient { color: [0.1; 3] },
            sun([0.8; 3]),
            Light::Punctual {
                intensity: [3.0, 2.0, 1.0],
                position: [0.8, 0.5, -1.0],
                range: 6.0,
                cone: None,
            },
        ],
        textures: vec![picture, numbers, normals, holes],
        materials: vec![floor, plate, pane],
        meshes: vec![back, front, glass],
        effects: Effects {
            shadows: vec![Shadow {
                light: 1,
                size: Some(256),
                bias: None,
                pcf_size: 3,
                area: None,
            }],
            environment_light: Some(EnvironmentLight::studio().turned(0.7)),
            tone_mapping: ToneMapping {
                exposure: 0.8,
                map: ToneMap::PbrNeutral,
            },
            ..Effects::default()
        },
        ..scenes::empty()
    }
}

#[test]
fn levels_and_threads_give_the_same_bytes() {
    let scene = everything();
    let settings = RenderSettings::new(70, 50);
    let first = render(&scene, &settings, &no_progress).unwrap();
    for (name, level) in levels() {
        for threads in [Some(1), Some(2)] {
            let settings = RenderSettings {
                level,
                threads,
                ..settings.clone()
            };
            let frame = render(&scene, &settings, &no_progress).unwrap();
            assert_eq!(frame.rgba, first.rgba, "{name} {threads:?}");
        }
    }
    // The picture has many colors.
    let mut colors: Vec<&[u8]> = first.rgba.chunks(4).collect();
    colors.sort_unstable();
    colors.dedup();
    assert!(colors.len() > 1000, "{}", colors.len());
}

/// Second sets of coordinates give the picture of first ones on a mesh whose sets are exchanged.
#[test]
fn second_sets_are_read_by_every_slot() {
    let exchange = |slot: &mut TextureSlot| {
        slot.uv_set = match slot.uv_set {
            UvSet::First => UvSet::Second,
            UvSet::Second => UvSet::First,
        };
    };
    let scene = everything();
    let mut exchanged = scene.clone();
    for mesh in &mut exchanged.meshes {
        std::mem::swap(&mut mesh.uvs, &mut mesh.lightmap_uvs);
    }
    for material in &mut exchanged.materials {
        let model = material.metallic_roughness.as_mut().unwrap();
        let (coat, sheen) = (model.clearcoat.as_mut(), model.sheen.as_mut());
        let layers = coat
            .into_iter()
            .flat_map(|c| [&mut c.map, &mut c.roughness_map])
            .chain(
                sheen
                    .into_iter()
                    .flat_map(|s| [&mut s.color_map, &mut s.roughness_map]),
            );
        let maps = [
            &mut model.map,
            &mut model.specular_map,
            &mut model.specular_color_map,
        ];
        let sheet = model.transmission.as_mut().and_then(|t| t.map.as_mut());
        sheet.into_iter().for_each(exchange);
        maps.into_iter().chain(layers).flatten().for_each(exchange);
        exchange(&mut model.occlusion.as_mut().unwrap().0);
        material.base_color.iter_mut().for_each(exchange);
        let emission = material.emission.as_mut();
        emission
            .and_then(|e| e.map.as_mut())
            .into_iter()
            .for_each(exchange);
        if let Some(NormalDetail::NormalMap { slot, .. }) = &mut material.normal_detail {
            exchange(slot);
        }
    }
    let (a, b) = (draw(&scene, 60, 40), draw(&exchanged, 60, 40));
    let off = a.rgba.iter().zip(&b.rgba).filter(|(a, b)| a != b).count();
    assert_eq!(off, 0);
    // And the sets differ.
    let mut mixed = scene.clone();
    for mesh in &mut mixed.meshes {
        mesh.lightmap_uvs.clone_from(&mesh.uvs);
    }
    assert_ne!(draw(&mixed, 60, 40).rgba, a.rgba);
}

#[test]
fn missing_sets_are_named() {
    let mut scene = everything();
    scene.meshes[0].lightmap_uvs.clear();
    let error = render(&scene, &RenderSettings::new(8, 8), &no_progress).unwrap_err();
    assert!(
        matches!(
            &error,
            texmap_render::RenderError::Scene(SceneError::MissingLightMapUv { .. })
        ),
        "{error}"
    );
    let mut scene = everything();
    scene.effects.tone_mapping.exposure = f32::NAN;
    assert!(scene.check().unwrap_err().to_string().contains("exposure"));
}

/// A black occlusion map takes the environment and ambient light, and leaves the sun.
#[test]
fn occlusion_is_of_indirect_light() {
    let model = |strength| MetallicRoughness {
        occlusion: slot(0, Filter::Nearest).map(|slot| (slot, strength)),
        ..MetallicRoughness::default()
    };
    let scene = |strength, lights, environment| Scene {
        lights,
        textures: vec![texture(1, 1, |_, _| [0, 255, 255, 255])],
        effects: Effects {
            environment_light: environment,
            ..Effects::default()
        },
        ..of(metallic([0.5; 3], model(strength)), wall(1.5, 1.5))
    };
    let at = |scene: &Scene| pixel(&draw(scene, 9, 9), 4, 4)[0];
    let (sunny, ambient) = (
        vec![sun([0.6; 3])],
        vec![Light::Ambient { color: [0.4; 3] }],
    );
    let studio = || Some(EnvironmentLight::studio());
    assert_eq!(at(&scene(1.0, Vec::new(), studio())), 0);
    assert_eq!(at(&scene(1.0, ambient.clone(), None)), 0);
    assert!(at(&scene(0.0, Vec::new(), studio())) > 100);
    assert!(at(&scene(0.0, ambient, None)) > 100);
    assert!(at(&scene(1.0, sunny.clone(), None)) > 100);
    assert_eq!(
        at(&scene(1.0, sunny.clone(), studio())),
        at(&scene(0.0, sunny, None))
    );
}

/// Phong's light under a curve, and colors that are display light already.
#[test]
fn tone_mapping_is_of_lit_surfaces() {
    let material = Material {
        phong: PhongMaterial {
            color: [0.9, 0.5, 0.1],
            ka: 1.0,
            kd: 0.0,
            ks: 0.0,
            ns: 1.0,
        },
        ..Material::default()
    };
    for map in ToneMap::ALL {
        let tone_mapping = ToneMapping { exposure: 1.5, map };
        let mut scene = Scene {
            lights: vec![Light::Ambient { color: [2.0; 3] }],
            effects: Effects {
                tone_mapping,
                ..Effects::default()
            },
            ..of(material.clone(), wall(1.5, 1.5))
        };
        let got = pixel(&draw(&scene, 5, 5), 2, 2);
        let expected = map.apply(1.5, [1.8, 1.0, 0.2]);
        for (got, expected) in got.into_iter().zip(expected) {
            let expected = stored(expected.into());
            assert!(
                (f64::from(got) - expected).abs() < 0.51,
                "{map:?}: {got} {expected}"
            );
        }
        scene.materials[0].shading = Shading::Unlit;
        let unlit = pixel(&draw(&scene, 5, 5), 2, 2);
        scene.effects.tone_mapping = ToneMapping::default();
        assert_eq!(unlit, pixel(&draw(&scene, 5, 5), 2, 2), "{map:?}");
    }
}

#[test]
fn shadows_fall_on_metallic_roughness() {
    let mut scene = Scene {
        lights: vec![Light::Directional {
            color: [1.0; 3],
            direction: [0.0, 0.0, -1.0],
        }],
        ..of(
            metallic([0.8; 3], MetallicRoughness::default()),
            wall(1.5, 3.0),
        )
    };
    scene.meshes.push(wall(0.4, 2.0));
    let lit = draw(&scene, 33, 33);
    scene.effects.shadows = vec![Shadow {
        light: 0,
        size: Some(256),
        bias: None,
        pcf_size: 1,
        area: None,
    }];
    scene.camera.eye = DVec3::new(0.9, 0.0, 0.0);
    scene.camera.look = DVec3::new(0.0, 0.0, -3.0);
    let frame = draw(&scene, 33, 33);
    let dark = frame.rgba.chunks(4).filter(|p| p[..3] == [0; 3]).count();
    let before = lit.rgba.chunks(4).filter(|p| p[..3] == [0; 3]).count();
    assert!(dark > before + 5, "{dark} {before}");
}

/// The lanes at a width of one are what the renderer stores.
#[test]
fn one_point_is_the_lanes() {
    let surface = MetallicRoughnessSurface::new(texmap_math::simd::Scalar, [0.5; 3], 0.0, 0.6);
    let up = [0.0, 0.0, 1.0];
    let ready = lanes::ReflectanceLanes::new(texmap_math::simd::Scalar, &surface, up, up, up);
    let (light, lit) = ready.under_light(texmap_math::simd::Scalar, &sun([0.6; 3]), [0.0; 3]);
    assert!(lit);
    let model = MetallicRoughness {
        roughness: 0.6,
        ..MetallicRoughness::default()
    };
    let scene = Scene {
        lights: vec![sun([0.6; 3])],
        ..of(metallic([0.5; 3], model), wall(1.5, 1.5))
    };
    let got = pixel(&draw(&scene, 9, 9), 4, 4);
    assert!(
        (f64::from(got[0]) - stored(light[0].into())).abs() < 0.51,
        "{got:?} {light:?}"
    );
}

/// A floor of 32 x 12 units in the plane y = 0 before a wall of height 2 on its far side, z = -4.
fn floor_and_wall(model: MetallicRoughness) -> Scene {
    let mut mesh = scenes::quad([
        [-16.0, 0.0, 8.0],
        [16.0, 0.0, 8.0],
        [16.0, 0.0, -4.0],
        [-16.0, 0.0, -4.0],
    ]);
    let wall = scenes::quad([
        [-16.0, 0.0, -4.0],
        [16.0, 0.0, -4.0],
        [16.0, 2.0, -4.0],
        [-16.0, 2.0, -4.0],
    ]);
    mesh.positions.extend(wall.positions);
    mesh.uvs.extend(wall.uvs);
    let corners = wall.triangles.iter();
    mesh.triangles
        .extend(corners.map(|triangle| triangle.map(|corner| corner + 4)));
    let even = Environment::from_fn(EnvironmentLayout::Cube, 32, |_| [0.5; 3]).unwrap();
    let mut scene = of(metallic([1.0; 3], model), mesh);
    scene.effects.environment_light = EnvironmentLight::new(&even, 32).ok();
    scene.camera.eye = DVec3::new(0.0, 6.0, 8.0);
    scene.camera.look = DVec3::new(0.0, 0.0, -2.0);
    scene
}

/// Light of the floor under 256 samples of the environment over that without shadows, with its distance from the wall; by rows of the middle.
fn shadowed_floor(mut scene: Scene) -> Vec<(f64, f64)> {
    let draw = |scene: &Scene| draw_aovs(scene, 80, 80, &[Aov::Color, Aov::Position]);
    let open = draw(&scene);
    scene.effects.environment_shadows = 256;
    let shadowed = draw(&scene);
    let rows = (0..80).filter_map(|y| {
        let [_, height, z] = values(&open, Aov::Position, 40, y)[..] else {
            return None;
        };
        let lit = |frame| f64::from(values(frame, Aov::Color, 40, y)[1]);
        let way = f64::from(z) + 4.0;
        (height.abs() < 1e-3 && way > 0.2).then(|| (way, lit(&shadowed) / lit(&open)))
    });
    rows.collect()
}

/// Before a long wall of height h the share (1 + d / sqrt(d^2 + h^2)) / 2 of an even sky lights a diffuse floor at the distance d.
#[test]
fn environment_shadows_leave_the_sky_that_is_seen() {
    let matte = MetallicRoughness {
        roughness: 1.0,
        specular: 0.0,
        ..MetallicRoughness::default()
    };
    let floor = shadowed_floor(floor_and_wall(matte));
    assert!(floor.len() > 20, "{}", floor.len());
    let share = |way: f64, height: f64| 0.5 * (1.0 + way / way.hypot(height));
    let worst = |height: f64| {
        let each = floor
            .iter()
            .map(|(way, seen)| (seen - share(*way, height)).abs());
        each.fold(0.0, f64::max)
    };
    assert!(worst(2.0) < 0.04, "{}", worst(2.0));
    // Of a wall half as high, and of none.
    assert!(worst(1.0) > 0.1 && worst(0.0) > 0.3);
}

/// A smooth metal floor loses the light that the wall stands before, and keeps that over it.
#[test]
fn environment_shadows_of_mirrors_are_where_they_look() {
    let mirror = MetallicRoughness {
        metallic: 1.0,
        roughness: 0.1,
        ..MetallicRoughness::default()
    };
    let floor = shadowed_floor(floor_and_wall(mirror));
    let eye = DVec3::new(0.0, 6.0, 8.0);
    for (way, seen) in floor {
        // Height at which the mirrored ray passes the wall.
        let height = 6.0 * way / (eye.z - (way - 4.0));
        if height < 0.6 {
            assert!(seen < 0.3, "{way} {height} {seen}");
        } else if height > 5.0 {
            assert!(seen > 0.8, "{way} {height} {seen}");
        }
    }
}

/// Environment shadows are the same bytes on every level and for all threads; an occlusion map that is darker wins.
#[test]
fn environment_shadows_are_the_same_everywhere() {
    let coated = MetallicRoughness {
        roughness: 0.4,
        clearcoat: Some(Clearcoat::default()),
        ..MetallicRoughness::default()
    };
    let mut scene = floor_and_wall(coated);
    scene.effects.environment_shadows = 40;
    let expected = draw(&scene, 70, 50);
    for (name, level) in levels() {
        let settings = RenderSettings {
            level,
            threads: Some(3),
            ..RenderSettings::new(70, 50)
        };
        let frame = render(&scene, &settings, &no_progress).unwrap();
        assert!(frame.rgba == expected.rgba, "{name}");
    }
    scene.textures.push(texture(1, 1, |_, _| [0, 0, 0, 255]));
    if let Some(model) = &mut scene.materials[0].metallic_roughness {
        let map = slot(scene.textures.len() - 1, Filter::Nearest).unwrap();
        model.occlusion = Some((map, 1.0));
    }
    let dark = draw(&scene, 70, 50);
    assert_eq!(pixel(&dark, 35, 40)[..3], [0; 3]);
    scene.effects.environment_shadows = 257;
    assert!(scene.check().unwrap_err().to_string().contains("0 to 256"));
}

/// Pictures by other cameras share the maps; maps of another light, of another count and of other bounds are not read.
#[test]
fn environment_shadows_serve_further_cameras() {
    let mut scene = floor_and_wall(MetallicRoughness::default());
    scene.effects.environment_shadows = 24;
    let settings = RenderSettings::new(70, 50);
    let first = Renderer::new(&scene, &settings).unwrap();
    let sharing = RenderSettings {
        environment_shadows: Some(first.environment_shadows()),
        ..settings
    };
    let differs = |scene: &Scene| {
        let shared = render(scene, &sharing, &no_progress).unwrap();
        shared.rgba != draw(scene, 70, 50).rgba
    };
    let mut further = scene.clone();
    further.camera.eye = DVec3::new(3.0, 2.0, 6.0);
    assert!(!differs(&further));
    let mut moved = further.clone();
    moved.meshes[0].world_from_object.w_axis.y += 4.0;
    let mut turned = further.clone();
    let half = |d: DVec3| if d.x > 0.0 { [2.0; 3] } else { [0.1; 3] };
    let light = Environment::from_fn(EnvironmentLayout::Cube, 32, half).unwrap();
    turned.effects.environment_light = EnvironmentLight::new(&light, 32).ok();
    let mut fewer = further.clone();
    fewer.effects.environment_shadows = 8;
    for scene in [moved, turned, fewer] {
        assert!(!differs(&scene));
    }
    // A corner of the wall that comes down within the bounds is not noticed.
    further.meshes[0].positions[6][1] = 0.2;
    assert!(differs(&further));
}

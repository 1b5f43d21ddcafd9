//! Shadows, projectors, environments, bump and light maps together in whole frames.

use texmap_light::{
    Environment, EnvironmentLayout, Light, NormalMapGreen, PhongMaterial, ProjectorBorder,
    ShadowBias, SpecularModel,
};
use texmap_math::Projector;
use texmap_math::glam::{DMat4, DVec3};
use texmap_render::{Aov, AovData, Frame, HOLE_BITS, RenderSettings, render};
use texmap_sample::{Filter, Sampler};
use texmap_scene::SceneError;
use texmap_scene::{
    Effects, LightMapSlot, Material, Mesh, NormalDetail, ProceduralHeight, ProjectorLight,
    ProjectorMode, Reflection, Scene, Shading, Shadow, SurfaceMaps,
};
use texmap_tests::levels::levels;

use crate::scenes::{bits, draw, empty, pixel, quad, slot, texture, wall};

fn shadow(light: usize) -> Shadow {
    Shadow {
        light,
        size: Some(256),
        bias: None,
        pcf_size: 3,
        area: None,
    }
}

pub(crate) fn projector_light(
    texture: usize,
    role: ProjectorMode,
    map: Option<u32>,
) -> ProjectorLight {
    let position = DVec3::new(0.5, 1.5, -0.5);
    ProjectorLight {
        projector: Projector::new(position, DVec3::new(0.0, -0.3, -3.0), DVec3::Y, 0.9, 1.5)
            .unwrap(),
        position,
        texture,
        sampler: Sampler::default(),
        border: ProjectorBorder::Black,
        softness: 0.1,
        mode: role,
        shadow: map,
    }
}

/// A floor, a wall and a plate before it, with every effect at once.
pub(crate) fn all() -> Scene {
    let picture = texture(32, 32, |x, y| [(x * 8) as u8, (y * 8) as u8, 200, 255]);
    let heights = texture(32, 32, |x, y| [((x * y) % 256) as u8, 0, 0, 255]);
    let normals = texture(16, 16, |x, y| {
        [(100 + x * 4) as u8, (100 + y * 4) as u8, 240, 255]
    });
    let white = PhongMaterial {
        color: [1.0, 0.9, 0.8],
        ..PhongMaterial::default()
    };
    let bump = Material {
        phong: white,
        normal_detail: Some(NormalDetail::Bump {
            slot: slot(1, Filter::Bilinear).unwrap(),
            height: 0.05,
        }),
        light_map: Some(LightMapSlot {
            slot: slot(0, Filter::Bilinear).unwrap(),
            scale: 0.3,
            baked: Some(vec![1]),
        }),
        ..Material::default()
    };
    let mapped = Material {
        phong: white,
        base_color: slot(0, Filter::Trilinear),
        specular_model: SpecularModel::Blinn,
        maps: SurfaceMaps {
            ambient: slot(0, Filter::Nearest),
            specular: slot(1, Filter::Bilinear),
            exponent: slot(0, Filter::Bilinear),
            reflectivity: slot(1, Filter::Bilinear),
        },
        normal_detail: Some(NormalDetail::NormalMap {
            slot: slot(2, Filter::Trilinear).unwrap(),
            green: NormalMapGreen::Up,
            rebuild_z: false,
            object_space: false,
            strength: 1.0,
        }),
        reflection: Some(Reflection {
            environment: 0,
            reflectivity: 0.5,
            within: None,
        }),
        specular_map: Some(0),
        ..Material::default()
    };
    let sky = Environment::from_fn(EnvironmentLayout::TanCube, 8, |d| {
        [0.5 + 0.5 * d.x, 0.5 + 0.5 * d.y, 0.5 + 0.5 * d.z].map(|c| c as f32)
    })
    .unwrap();
    let floor = quad([
        [-3.0, -1.0, 0.0],
        [3.0, -1.0, 0.0],
        [3.0, -1.0, -6.0],
        [-3.0, -1.0, -6.0],
    ]);
    Scene {
        lights: vec![
            Light::Ambient { color: [0.2; 3] },
            Light::Directional {
                color: [0.5; 3],
                direction: [0.5, -1.0, -0.6],
            },
            Light::Point {
                color: [0.3, 0.2, 0.4],
                position: [1.0, 1.0, -1.5],
            },
            Light::spot([0.4; 3], [-1.5, 1.5, -1.0], [0.5, -1.0, -0.5], 0.4, 0.7),
        ],
        textures: vec![picture, heights, normals],
        materials: vec![bump, mapped],
        meshes: vec![
            Mesh {
                lightmap_uvs: floor.uvs.clone(),
                ..floor
            },
            Mesh {
                material: 1,
                ..wall(2.5, 5.0)
            },
            Mesh {
                material: 1,
                ..wall(0.5, 3.0)
            },
        ],
        effects: Effects {
            shadows: vec![shadow(1), shadow(2), shadow(3)],
            projectors: vec![
                projector_light(0, ProjectorMode::Light([0.6; 3]), Some(128)),
                projector_light(2, ProjectorMode::Decal, None),
            ],
            environments: vec![sky],
            ..Effects::default()
        },
        ..empty()
    }
}

fn settings() -> RenderSettings {
    let shadows = (0..4).map(Aov::Shadow);
    RenderSettings {
        aovs: Aov::ALL.into_iter().chain(shadows).collect(),
        ..RenderSettings::new(150, 110)
    }
}

pub(crate) fn rendered(scene: &Scene, settings: &RenderSettings) -> Frame {
    render(scene, settings, &texmap_render::no_progress).unwrap()
}

/// The law of the same bytes holds with every effect on.
#[test]
fn effects_are_the_same_on_every_level_and_thread_count() {
    let scene = all();
    let expected = rendered(&scene, &settings());
    for threads in [1, 3] {
        let settings = RenderSettings {
            threads: Some(threads),
            ..settings()
        };
        let frame = rendered(&scene, &settings);
        assert!(
            frame.rgba == expected.rgba && bits(&frame) == bits(&expected),
            "{threads} threads"
        );
    }
    for (name, level) in levels() {
        let frame = rendered(
            &scene,
            &RenderSettings {
                level,
                ..settings()
            },
        );
        assert!(
            frame.rgba == expected.rgba && bits(&frame) == bits(&expected),
            "{name}"
        );
    }
}

type Change = fn(&mut Scene);

/// Each effect reaches the picture: leaving one out changes it.
#[test]
fn every_effect_is_seen() {
    let with = rendered(&all(), &settings()).rgba;
    let changes: [(&str, Change); 12] = [
        ("shadows", |s| s.effects.shadows.clear()),
        ("projectors", |s| s.effects.projectors.clear()),
        ("paint", |s| s.effects.projectors.truncate(1)),
        ("projector shadow", |s| {
            s.effects.projectors[0].shadow = None;
        }),
        ("bump", |s| s.materials[0].normal_detail = None),
        ("light map", |s| s.materials[0].light_map = None),
        ("normal map", |s| s.materials[1].normal_detail = None),
        ("reflection", |s| s.materials[1].reflection = None),
        ("specular map", |s| s.materials[1].specular_map = None),
        ("highlight", |s| {
            s.materials[1].specular_model = SpecularModel::Phong;
        }),
        ("ambient map", |s| s.materials[1].maps.ambient = None),
        ("exponent map", |s| s.materials[1].maps.exponent = None),
    ];
    for (name, change) in changes {
        let mut scene = all();
        change(&mut scene);
        assert_ne!(rendered(&scene, &settings()).rgba, with, "{name}");
    }
}

/// No computed NaN in any buffer: holes have the one pattern, and everything else is finite.
#[test]
fn no_buffer_holds_a_nan_of_its_own() {
    let mut hostile = all();
    // Normals without length, coordinates without area, a projected picture seen edge-on, a light in a vertex.
    hostile.meshes[1].normals = vec![[0.0; 3]; 4];
    hostile.meshes[2].uvs = vec![[0.5, 0.5]; 4];
    hostile.lights[2] = Light::Point {
        color: [1.0; 3],
        position: hostile.meshes[2].positions[0],
    };
    let mut scenes = vec![all(), hostile];
    // Bumps beyond all measure, on a floor whose coordinates collapse at one corner.
    let slot = || slot(1, Filter::Bilinear).unwrap();
    for size in [1e30, -1e30, 1e-30] {
        for detail in [
            NormalDetail::Bump {
                slot: slot(),
                height: size,
            },
            NormalDetail::Offsets {
                slot: slot(),
                slope: size,
                green: NormalMapGreen::Up,
            },
            NormalDetail::Procedural {
                heights: ProceduralHeight::Waves {
                    around: 3,
                    fold: 1e20,
                },
                world_from_solid: DMat4::from_scale(DVec3::splat(f64::from(size.abs()))),
                height: size,
            },
        ] {
            let mut scene = all();
            scene.meshes[0].uvs[2] = scene.meshes[0].uvs[1];
            scene.materials[0].normal_detail = Some(detail);
            scenes.push(scene);
        }
    }
    for scene in scenes {
        let frame = rendered(&scene, &settings());
        for (aov, _, data) in &frame.aovs {
            if let AovData::F32(values) = data {
                let bad = values
                    .iter()
                    .find(|v| !v.is_finite() && v.to_bits() != HOLE_BITS);
                assert!(bad.is_none(), "{aov}: {bad:?}");
                assert!(
                    // Light 0 is ambient: it casts no shadow.
                    values.iter().any(|v| v.is_finite()) || *aov == Aov::Shadow(0),
                    "{aov}"
                );
            }
        }
    }
}

/// Property 24: a blocker only takes light away, and a lone plane is fully lit.
#[test]
fn blockers_only_darken() {
    let mut scene = all();
    scene.meshes.truncate(1);
    let alone = rendered(&scene, &settings());
    let with = rendered(&all(), &settings());
    let share = |frame: &Frame, light: u8| -> Vec<f32> {
        let found = frame
            .aovs
            .iter()
            .find(|(aov, ..)| *aov == Aov::Shadow(light));
        match found {
            Some((_, _, AovData::F32(values))) => values.clone(),
            _ => Vec::new(),
        }
    };
    for light in 1..4 {
        let (a, b) = (share(&alone, light), share(&with, light));
        assert!(a.iter().all(|v| v.is_nan() || *v == 1.0), "light {light}");
        let darker = a.iter().zip(&b).filter(|(a, b)| b < a).count();
        assert!(darker > 50, "light {light}: {darker}");
        assert!(
            a.iter()
                .zip(&b)
                .all(|(a, b)| a.is_nan() || b.is_nan() || b <= a)
        );
    }
}

/// A projector as light is the light's own formula at each pixel. Property 31: a light map of ones is the surface itself.
#[test]
fn a_white_light_map_is_the_surface() {
    let white = texture(4, 4, |_, _| [255; 4]);
    let mapped = Material {
        phong: PhongMaterial {
            color: [0.25, 0.5, 1.0],
            ka: 1.0,
            kd: 1.0,
            ks: 0.0,
            ns: 1.0,
        },
        light_map: Some(LightMapSlot {
            slot: slot(0, Filter::Bilinear).unwrap(),
            scale: 1.0,
            baked: None,
        }),
        ..Material::default()
    };
    let mesh = wall(5.0, 2.0);
    let scene = Scene {
        lights: vec![Light::Ambient { color: [0.3; 3] }],
        textures: vec![white],
        materials: vec![mapped],
        meshes: vec![Mesh {
            lightmap_uvs: mesh.uvs.clone(),
            ..mesh
        }],
        ..empty()
    };
    let frame = draw(&scene, 9, 9);
    assert_eq!(pixel(&frame, 4, 4)[..3], [64, 128, 255]);
    let mut dark = scene.clone();
    dark.materials[0].light_map.as_mut().unwrap().scale = 0.5;
    assert_eq!(pixel(&draw(&dark, 9, 9), 4, 4)[..3], [32, 64, 128]);
}

#[test]
fn faults_of_effects_are_named() {
    let refused = |change: Change| {
        let mut scene = all();
        change(&mut scene);
        scene.check().unwrap_err()
    };
    let text = |change: Change| refused(change).to_string();
    assert!(text(|s| s.effects.shadows[0].light = 9).contains("light 9 does not exist"));
    assert!(text(|s| s.effects.shadows[0].light = 0).contains("only directional"));
    assert!(text(|s| s.effects.shadows[0].pcf_size = 4).contains("odd"));
    let bias = |bias| {
        let mut scene = all();
        scene.effects.shadows[0].bias = Some(bias);
        scene.check().unwrap_err().to_string()
    };
    assert!(bias(ShadowBias::Constant(f64::NAN)).contains("bias"));
    assert!(bias(ShadowBias::Planes(f64::INFINITY)).contains("bias"));
    assert!(text(|s| s.effects.shadows[0].size = Some(0)).contains("16384"));
    assert!(text(|s| s.effects.projectors[0].texture = 7).contains("texture 7"));
    assert!(text(|s| s.effects.projectors[1].softness = 2.0).contains("softness"));
    assert!(text(|s| s.effects.environments.clear()).contains("does not exist"));
    assert!(text(|s| s.materials[0].light_map.as_mut().unwrap().scale = -1.0).contains("scale"));
    // A picture of no size, a projector that looks nowhere.
    let bad_projector = |look: DVec3, up: DVec3, fov: f64, aspect: f64| {
        Projector::new(DVec3::ZERO, look, up, fov, aspect)
            .unwrap_err()
            .to_string()
    };
    for aspect in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(bad_projector(DVec3::Z, DVec3::Y, 1.0, aspect).contains("width over height"));
    }
    assert!(bad_projector(DVec3::Z, DVec3::Z, 1.0, 1.0).contains("parallel"));
    assert!(bad_projector(DVec3::ZERO, DVec3::Y, 1.0, 1.0).contains("same point"));
    assert!(bad_projector(DVec3::Z, DVec3::Y, 0.0, 1.0).contains("field of view"));
    assert!(matches!(
        refused(|s| s.meshes[0].lightmap_uvs.clear()),
        SceneError::MissingLightMapUv { .. }
    ));
    assert!(matches!(
        refused(|s| s.meshes[0].uvs.clear()),
        SceneError::MissingUv { .. }
    ));
    assert!(matches!(
        refused(|s| s.meshes[0].lightmap_uvs[0][1] = f32::NAN),
        SceneError::Value { .. }
    ));
    // Wrong but drawable: a warning.
    let mut inside = all();
    if let Light::Point { position, .. } = &mut inside.lights[2] {
        *position = [0.0, 0.0, -3.0];
    }
    let cube = |v: u32| [0, 1, 2].map(|k| if v >> k & 1 == 0 { -0.2 } else { 0.2f32 });
    inside.meshes.push(Mesh {
        name: "lampshade".into(),
        positions: (0..8)
            .map(|v| cube(v).map(|c| c))
            .map(|[x, y, z]| [x, y, z - 3.0])
            .collect(),
        triangles: vec![
            [0, 2, 1],
            [1, 2, 3],
            [4, 5, 6],
            [5, 7, 6],
            [0, 1, 4],
            [1, 5, 4],
            [2, 6, 3],
            [3, 6, 7],
            [0, 4, 2],
            [2, 4, 6],
            [1, 3, 5],
            [3, 7, 5],
        ],
        material: 1,
        uvs: vec![[0.5; 2]; 8],
        ..Mesh::default()
    });
    let told = |scene: &Scene| {
        let warnings = scene.check().unwrap();
        warnings
            .iter()
            .any(|w| w.contains("light 2 stands inside of mesh 'lampshade'"))
    };
    assert!(told(&inside));
    if let Light::Point { position, .. } = &mut inside.lights[2] {
        *position = [0.0, 0.5, -3.0];
    }
    assert!(!told(&inside), "above it is not inside");
    let mut vertex = all();
    vertex.materials[0].shading = Shading::PerVertex;
    assert!(
        vertex
            .check()
            .unwrap()
            .iter()
            .any(|w| w.contains("not lit per pixel"))
    );
    let bias = ShadowBias::Constant(0.0);
    let mut acne = all();
    acne.effects
        .shadows
        .iter_mut()
        .for_each(|s| s.bias = Some(bias));
    assert!(acne.check().is_ok());
}

//! Light above 1 in arrays of floats: kept by [`ToneMap::Unclipped`], clipped by [`ToneMap::None`].

use texmap_light::{Light, PhongMaterial, ToneMap};
use texmap_render::{Aov, Frame, RenderSettings, render};
use texmap_sample::{Alpha, ColorSpace, Filter, Image, Origin, TexelData, Texture2d};
use texmap_scene::{
    Background, Emission, Material, MetallicRoughness, Scene, Shading, TextureRole, TextureSlot,
};
use texmap_tests::levels::levels;

use crate::scenes::{draw_aovs, glowing, of, slot, unlit, values, wall};

const BRIGHT: [f32; 3] = [0.5, 3.0, 40.0];

/// A texture of one colour far above white.
fn bright_texture() -> Texture2d<'static> {
    Texture2d::new(&Image {
        width: 1,
        height: 1,
        channels: 3,
        texels: TexelData::F32(&BRIGHT),
        color: ColorSpace::Linear,
        alpha: Alpha::Straight,
        origin: Origin::TopLeft,
    })
    .unwrap()
}

fn drawn(scene: &Scene, map: ToneMap) -> Frame {
    let mut scene = scene.clone();
    scene.effects.tone_mapping.map = map;
    let frame = draw_aovs(&scene, 6, 6, &[Aov::Color]);
    for (name, level) in levels() {
        let settings = RenderSettings {
            level,
            aovs: vec![Aov::Color],
            ..RenderSettings::new(6, 6)
        };
        let other = render(&scene, &settings, &texmap_render::no_progress).unwrap();
        assert_eq!(frame.rgba, other.rgba, "{name}");
        assert_eq!(
            values(&frame, Aov::Color, 3, 3),
            values(&other, Aov::Color, 3, 3),
            "{name}"
        );
    }
    frame
}

/// The middle of a scene has this light, which ends at 1 where it is clipped; bytes are the same.
fn check(what: &str, scene: &Scene, light: [f32; 3]) {
    let (kept, clipped) = (
        drawn(scene, ToneMap::Unclipped),
        drawn(scene, ToneMap::None),
    );
    let [kept_light, clipped_light] = [&kept, &clipped].map(|f| values(f, Aov::Color, 3, 3));
    for k in 0..3 {
        let near = |got: f32, expected: f32| (got - expected).abs() <= 1e-5 * expected.max(1.0);
        assert!(near(kept_light[k], light[k]), "{what}: {kept_light:?}");
        let expected = light[k].min(1.0);
        assert!(
            near(clipped_light[k], expected),
            "{what}: {clipped_light:?}"
        );
    }
    assert_eq!(kept.rgba, clipped.rgba, "{what}");
    let mut scene = scene.clone();
    scene.effects.tone_mapping.map = ToneMap::Unclipped;
    let truth = texmap_truth::frame(&scene, 6, 6, 1).unwrap();
    let truth = truth.color[3 * 6 + 3].to_array();
    for k in 0..3 {
        let off = (truth[k] - f64::from(kept_light[k])).abs();
        assert!(
            off < 1e-4 * f64::from(light[k].max(1.0)),
            "{what}: {truth:?}"
        );
    }
}

#[test]
fn light_of_lit_and_unlit_surfaces_is_kept() {
    let base = [0.2, 0.4, 0.6];
    let emission = [0.5, 1.0, 2.0];
    for (shading, received) in [
        (Shading::Unlit, 1.0f32),
        (Shading::PerVertex, 0.5),
        (Shading::PerPixel, 3.0),
    ] {
        let light = Emission {
            color: emission,
            map: None,
        };
        let material = glowing(base, shading, light);
        let scene = Scene {
            lights: vec![Light::Ambient {
                color: [received; 3],
            }],
            ..of(material, wall(2.0, 1.0))
        };
        let light = [0, 1, 2].map(|k| base[k] * received + emission[k]);
        check(&format!("{shading:?}"), &scene, light);
    }
}

#[test]
fn light_of_models_and_bright_textures_is_kept() {
    let textured = |material: Material| Scene {
        textures: vec![bright_texture()],
        ..of(
            Material {
                base_color: slot(0, Filter::Bilinear),
                ..material
            },
            wall(2.0, 1.0),
        )
    };
    check("unlit", &textured(unlit([1.0; 3])), BRIGHT);
    let label = Material {
        texture_role: TextureRole::Decal,
        ..unlit([1.0; 3])
    };
    check("decal", &textured(label), BRIGHT);
    let backdrop = Scene {
        textures: vec![bright_texture()],
        ..of(unlit([1.0; 3]), wall(0.01, 10.0))
    };
    let mut backdrop = backdrop;
    backdrop.meshes.clear();
    backdrop.effects.background = Some(Background::Picture(TextureSlot::new(0)));
    check("background", &backdrop, BRIGHT);
    // A matte model under even light above 1.
    let model = Material {
        phong: PhongMaterial {
            color: [0.5, 0.25, 1.0],
            ..PhongMaterial::default()
        },
        metallic_roughness: Some(MetallicRoughness {
            metallic: 0.0,
            specular: 0.0,
            ..MetallicRoughness::default()
        }),
        ..Material::default()
    };
    let model = Scene {
        lights: vec![Light::Ambient { color: [8.0; 3] }],
        ..of(model, wall(2.0, 1.0))
    };
    check("model", &model, [4.0, 2.0, 8.0]);
}

/// Colours that are lit at vertices are finished there.
#[test]
fn light_at_vertices_stays_clipped() {
    let material = Material {
        phong: PhongMaterial {
            color: [0.5; 3],
            ka: 1.0,
            ..PhongMaterial::default()
        },
        shading: Shading::PerVertex,
        ..Material::default()
    };
    let scene = Scene {
        lights: vec![Light::Ambient { color: [8.0; 3] }],
        ..of(material, wall(2.0, 1.0))
    };
    check("vertices", &scene, [1.0; 3]);
}

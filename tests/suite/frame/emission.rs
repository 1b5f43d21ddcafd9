//! Light that surfaces give off.

use texmap_light::Light;
use texmap_render::{RenderSettings, render};
use texmap_sample::Filter;
use texmap_scene::{Emission, Material, Scene, SceneError, Shading};
use texmap_tests::levels::levels;

use crate::scenes::{draw, glowing, of, pixel, slot, texture, wall};

/// Emission is added to what a surface receives, under every kind of shading, and clipped with it. The bytes are those of
/// its own formula.
#[test]
fn surfaces_give_off_light_of_their_own() {
    let picture = texture(2, 1, |x, _| {
        [[255, 51, 0, 255], [51, 255, 102, 255]][x as usize]
    });
    let base = [0.2, 0.4, 0.6];
    let color = [0.5, 1.0, 2.0];
    let frame = |shading, map: bool| {
        let light = Emission {
            color,
            map: map.then(|| slot(0, Filter::Nearest).unwrap()),
        };
        let material = glowing(base, shading, light);
        let scene = Scene {
            lights: vec![Light::Ambient { color: [0.5; 3] }],
            textures: vec![picture.clone()],
            ..of(material, wall(2.0, 1.0))
        };
        let frame = draw(&scene, 16, 8);
        for (name, level) in levels() {
            let settings = RenderSettings {
                level,
                ..RenderSettings::new(16, 8)
            };
            let other = render(&scene, &settings, &texmap_render::no_progress).expect("a picture");
            assert_eq!(frame.rgba, other.rgba, "{shading:?} {name}");
        }
        frame
    };
    for (shading, light) in [
        (Shading::Unlit, 1.0f32),
        (Shading::PerVertex, 0.5),
        (Shading::PerPixel, 0.5),
    ] {
        for map in [false, true] {
            let frame = frame(shading, map);
            for (x, texel) in [(4, [1.0, 0.2, 0.0]), (11, [0.2, 1.0, 0.4])] {
                let texel = if map { texel } else { [1.0; 3] };
                let expected =
                    [0, 1, 2].map(|k| (base[k] * light + color[k] * texel[k]).min(1.0) * 255.0);
                let found = pixel(&frame, x, 4);
                for k in 0..3 {
                    assert!(
                        (f32::from(found[k]) - expected[k]).abs() <= 0.51,
                        "{shading:?} {map} {found:?} {expected:?}"
                    );
                }
            }
        }
    }
}

#[test]
fn emission_must_be_light() {
    let material = Material {
        emission: Some(Emission {
            color: [0.0, f32::NAN, 0.0],
            map: None,
        }),
        ..Material::default()
    };
    let error = of(material, wall(1.0, 1.0)).check().unwrap_err();
    assert!(matches!(error, SceneError::Value { what, .. } if what == "emission"));
}

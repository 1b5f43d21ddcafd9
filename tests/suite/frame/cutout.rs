//! The alpha test: holes show what is behind, in colour and in depth.

use texmap_render::{Aov, RenderSettings, render};
use texmap_sample::{Filter, Texture2d};
use texmap_scene::{AlphaMode, Material, Mesh, Scene, TextureRole};

use crate::scenes::{draw, draw_aovs, empty, faces, pixel, slot, texture, unlit, values, wall};

/// A fence of 4 columns, the odd ones holes with a hidden colour, before a wall.
fn fence(alpha: AlphaMode, filter: Filter) -> Scene {
    let front = Material {
        alpha,
        base_color: slot(0, filter),
        texture_role: TextureRole::Decal,
        ..unlit([1.0; 3])
    };
    Scene {
        textures: vec![columns()],
        materials: vec![front, unlit([0.0, 0.0, 1.0])],
        meshes: vec![
            Mesh {
                faces: vec![7, 7],
                ..wall(1.0, 1.0)
            },
            Mesh {
                material: 1,
                faces: vec![9, 9],
                ..wall(2.0, 2.0)
            },
        ],
        ..empty()
    }
}

fn columns() -> Texture2d<'static> {
    texture(4, 1, |x, _| {
        if x % 2 == 0 {
            [255, 0, 0, 255]
        } else {
            [0, 255, 0, 0]
        }
    })
}

#[test]
fn holes_write_neither_colour_nor_depth() {
    let frame = draw_aovs(
        &fence(AlphaMode::Test(0.0), Filter::Nearest),
        64,
        64,
        &[Aov::Depth, Aov::Face],
    );
    let near = 1e-4;
    for (x, color, depth, face) in [
        (8, [255, 0, 0, 255], near, 7),
        (24, [0, 0, 255, 255], near / 2.0, 9),
    ] {
        assert_eq!(pixel(&frame, x, 32), color);
        assert!((values(&frame, Aov::Depth, x, 32)[0] - depth).abs() < 1e-9);
        assert_eq!(faces(&frame)[32 * 64 + x as usize], face);
    }
}

/// The negative twin: without the test the hole hides the wall.
#[test]
fn an_opaque_fence_has_no_holes() {
    let frame = draw_aovs(
        &fence(AlphaMode::Opaque, Filter::Nearest),
        64,
        64,
        &[Aov::Face],
    );
    assert!(faces(&frame).iter().all(|face| *face == 7));
}

/// Filtered alpha is cut at one half, wherever the fence is drawn in the order. Nearest cuts above zero.
#[test]
fn filtered_alpha_is_cut_at_one_half() {
    let columns_of = |alpha, filter| {
        let frame = draw_aovs(&fence(alpha, filter), 256, 4, &[Aov::Face]);
        (0..256).filter(|x| faces(&frame)[2 * 256 + x] == 7).count()
    };
    let rule = AlphaMode::Test(0.0);
    assert_eq!(columns_of(rule, Filter::Nearest), 128);
    // Alpha is a triangle wave between texel centres: half of it is at least one half.
    assert!(
        (127..=129).contains(&columns_of(rule, Filter::Bilinear)),
        "{}",
        columns_of(rule, Filter::Bilinear)
    );
    let quarter = columns_of(AlphaMode::Test(0.25), Filter::Bilinear);
    assert!((190..=194).contains(&quarter), "{quarter}");
}

#[test]
fn an_override_of_the_filter_moves_the_rule_with_it() {
    let settings = RenderSettings {
        filter: Some(Filter::Bilinear),
        aovs: vec![Aov::Face],
        ..RenderSettings::new(256, 4)
    };
    let frame = render(
        &fence(AlphaMode::Test(0.0), Filter::Nearest),
        &settings,
        &texmap_render::no_progress,
    )
    .unwrap();
    let kept = faces(&frame)[512..768]
        .iter()
        .filter(|face| **face == 7)
        .count();
    assert!((127..=129).contains(&kept), "{kept}");
}

/// The colour hidden in transparent texels (green) never shows: no halo (case S6).
#[test]
fn hidden_colours_make_no_halo() {
    for filter in [Filter::Nearest, Filter::Bilinear, Filter::Trilinear] {
        let frame = draw(&fence(AlphaMode::Test(0.0), filter), 61, 61);
        assert!(frame.rgba.chunks_exact(4).all(|p| p[1] == 0), "{filter:?}");
    }
}

/// Opacity below the threshold removes everything; an opacity map cuts by its red channel.
#[test]
fn opacity_and_its_map_take_part() {
    let mut scene = fence(AlphaMode::Test(0.5), Filter::Nearest);
    scene.materials[0].opacity = 0.4;
    assert_eq!(pixel(&draw(&scene, 64, 64), 8, 32), [0, 0, 255, 255]);
    scene.materials[0].opacity = 1.0;
    scene.textures.push(texture(1, 2, |_, y| {
        [if y == 0 { 255 } else { 0 }, 0, 0, 255]
    }));
    scene.materials[0].opacity_map = slot(1, Filter::Nearest);
    let frame = draw(&scene, 64, 64);
    assert_eq!(pixel(&frame, 8, 16), [255, 0, 0, 255]);
    assert_eq!(pixel(&frame, 8, 48), [0, 0, 255, 255]);
}

/// A fence casts the shadow of its boards: light goes through the holes that the camera sees.
#[test]
fn holes_let_light_through() {
    let mut scene = fence(AlphaMode::Test(0.0), Filter::Nearest);
    scene.materials[1].shading = texmap_scene::Shading::PerPixel;
    // A point of the fence at x casts its shadow to x + 0.5 on the wall.
    scene.lights = vec![texmap_light::Light::Directional {
        color: [1.0; 3],
        direction: [0.5, 0.0, -1.0],
    }];
    let shadow = |threads: usize| {
        let mut scene = scene.clone();
        scene.effects.shadows = vec![texmap_scene::Shadow {
            light: 0,
            size: Some(512),
            bias: None,
            pcf_size: 1,
            area: None,
        }];
        let settings = RenderSettings {
            aovs: vec![Aov::Shadow(0)],
            threads: Some(threads),
            ..RenderSettings::new(160, 160)
        };
        render(&scene, &settings, &texmap_render::no_progress).expect("a good scene")
    };
    let frame = shadow(1);
    // Two world units from the eye, 90 degrees wide.
    let at = |x: f32| values(&frame, Aov::Shadow(0), (80.0 + 40.0 * x) as u32, 80)[0];
    for (x, lit) in [
        (-0.75, 1.0),
        (-0.25, 0.0),
        (1.25, 1.0),
        (1.1, 1.0),
        (1.75, 1.0),
    ] {
        assert_eq!(at(x), lit, "{x}");
    }
    assert_eq!(frame.rgba, shadow(3).rgba);
}

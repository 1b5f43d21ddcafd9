//! sRGB and raw values, supersampling, decals and modulation.

use texmap_light::{Light, PhongMaterial};
use texmap_math::{Level, color};
use texmap_render::{Aov, RenderSettings, render};
use texmap_sample::{Alpha, ColorSpace, Filter, Image, Origin, TexelData, Texture2d, Wrap};
use texmap_scene::{AlphaMode, ColorMode, Material, Mesh, Scene, Shading, TextureRole};
use texmap_tests::levels::levels;

use crate::scenes::{bits, draw, of, pixel, slot, texture, unlit, wall};

/// A white square whose right edge halves the middle column of pixels.
fn half_covered(color: ColorMode) -> Scene {
    let mut wall = wall(1.5, 1.0);
    (wall.positions[1][0], wall.positions[2][0]) = (0.0, 0.0);
    Scene {
        color,
        ..of(unlit([1.0; 3]), wall)
    }
}

#[test]
fn supersampling_averages_light_not_codes() {
    for (mode, expected) in [(ColorMode::Srgb, 188), (ColorMode::Raw, 128)] {
        for supersample in [2, 4] {
            let settings = RenderSettings {
                supersample,
                ..RenderSettings::new(9, 9)
            };
            let frame =
                render(&half_covered(mode), &settings, &texmap_render::no_progress).unwrap();
            assert_eq!(
                pixel(&frame, 4, 4),
                [expected, expected, expected, 255],
                "{mode:?} {supersample}"
            );
            assert_eq!((pixel(&frame, 3, 4)[0], pixel(&frame, 5, 4)[0]), (255, 0));
        }
    }
}

#[test]
fn every_number_of_samples_fills_its_blocks() {
    let scene = Scene {
        background: [0.0, 0.0, 1.0, 1.0],
        ..of(unlit([1.0, 0.0, 0.0]), wall(9.0, 1.0))
    };
    for supersample in [1, 2, 3, 5, 8] {
        let settings = RenderSettings {
            supersample,
            ..RenderSettings::new(131, 67)
        };
        let frame = render(&scene, &settings, &texmap_render::no_progress).unwrap();
        assert!(
            frame.rgba.chunks_exact(4).all(|p| p == [255, 0, 0, 255]),
            "{supersample}"
        );
        assert_eq!(frame.stats.pixels_covered, 131 * 67);
    }
}

/// AOVs are of the pixel's centre: supersampling does not move them.
#[test]
fn supersampling_leaves_the_aovs_alone() {
    let scene = half_covered(ColorMode::Srgb);
    let at = |supersample| {
        let settings = RenderSettings {
            supersample,
            aovs: Aov::ALL.to_vec(),
            ..RenderSettings::new(33, 21)
        };
        bits(&render(&scene, &settings, &texmap_render::no_progress).unwrap())
    };
    assert_eq!(at(2), at(1));
    assert_eq!(at(3), at(1));
}

#[test]
fn srgb_bytes_survive_the_way_and_raw_bytes_too() {
    let bytes = |x: u32| [(x * 5) as u8, 255 - (x * 5) as u8, 77, 255];
    for (mode, space) in [
        (ColorMode::Srgb, ColorSpace::Srgb),
        (ColorMode::Raw, ColorSpace::Linear),
    ] {
        let texels = (0..51).flat_map(bytes).collect();
        let texture = Texture2d::from_rgba8(51, 1, texels, space, Origin::TopLeft).unwrap();
        let material = Material {
            base_color: slot(0, Filter::Nearest),
            texture_role: TextureRole::Decal,
            ..unlit([1.0; 3])
        };
        let scene = Scene {
            color: mode,
            textures: vec![texture],
            ..of(material, wall(1.0, 1.0))
        };
        let frame = draw(&scene, 51, 51);
        for x in 0..51 {
            assert_eq!(pixel(&frame, x, 20), bytes(x), "{mode:?}");
        }
    }
}

/// Nearest texels that were encoded once give the pixels that are encoded one by one: a clear pane in front of everything keeps the
/// light, and with it the encoding of each pixel. A tint takes effect on both ways.
#[test]
fn texels_encoded_once_are_the_pixels_encoded_one_by_one() {
    let texels: Vec<u16> = (0..64 * 64 * 3u32)
        .map(|i| (i.wrapping_mul(2_654_435_761) >> 16) as u16)
        .collect();
    let image = Image {
        width: 64,
        height: 64,
        channels: 3,
        texels: TexelData::U16(&texels),
        color: ColorSpace::Srgb,
        alpha: Alpha::Straight,
        origin: Origin::TopLeft,
    };
    let wide = Texture2d::new(&image).unwrap();
    let bytes = texels.chunks_exact(3);
    let bytes = bytes.flat_map(|t| [t[0] as u8, t[1] as u8, t[2] as u8, 255]);
    let narrow =
        Texture2d::from_rgba8(64, 64, bytes.collect(), ColorSpace::Srgb, Origin::TopLeft).unwrap();
    let pane = Material {
        alpha: AlphaMode::Blend,
        opacity: 0.0,
        ..unlit([1.0; 3])
    };
    let mut pictures = Vec::new();
    for texture in [wide, narrow] {
        for (wrap, tint) in [
            (Wrap::Repeat, 1.0),
            (Wrap::MirroredRepeat, 1.0),
            (Wrap::ClampToBorder, 1.0),
            (Wrap::Repeat, 0.5),
        ] {
            let mut base = slot(0, Filter::Nearest);
            let sampler = &mut base.as_mut().unwrap().sampler;
            (sampler.wrap_u, sampler.wrap_v) = (wrap, wrap);
            let material = Material {
                base_color: base,
                ..unlit([tint; 3])
            };
            let mut mesh = wall(0.9, 1.0);
            // A slanted quad, so that texels are read in perspective.
            mesh.positions[2][2] = -3.0;
            mesh.uvs = vec![[-0.4, -0.3], [1.7, -0.2], [1.4, 1.6], [-0.2, 1.3]];
            let scene = Scene {
                textures: vec![texture.clone()],
                ..of(material, mesh)
            };
            let mut behind_glass = scene.clone();
            behind_glass.materials.push(pane.clone());
            behind_glass.meshes.push(Mesh {
                material: 1,
                ..wall(0.5, 0.2)
            });
            for (name, level) in levels() {
                for (msaa, threads) in [(1, 1), (1, 3), (4, 1)] {
                    let settings = RenderSettings {
                        level,
                        msaa,
                        threads: Some(threads),
                        ..RenderSettings::new(96, 70)
                    };
                    let bytes = |scene: &Scene| {
                        render(scene, &settings, &texmap_render::no_progress)
                            .unwrap()
                            .rgba
                    };
                    let picture = bytes(&scene);
                    let same = picture == bytes(&behind_glass);
                    assert!(same, "{wrap:?} {tint} {name} {msaa}");
                    pictures.push((wrap, tint, msaa, picture));
                }
            }
        }
    }
    let plain = |tint: f32| {
        let found = pictures
            .iter()
            .find(|(wrap, t, msaa, _)| *wrap == Wrap::Repeat && *t == tint && *msaa == 1);
        found.unwrap().3.clone()
    };
    assert_ne!(plain(1.0), plain(0.5));
}

#[test]
fn background_is_srgb_or_raw() {
    for mode in [ColorMode::Srgb, ColorMode::Raw] {
        let scene = Scene {
            color: mode,
            background: [0.2, 0.6, 0.8, 0.4],
            ..crate::scenes::empty()
        };
        assert_eq!(
            pixel(&draw(&scene, 3, 3), 1, 1),
            [51, 153, 204, 102],
            "{mode:?}"
        );
    }
}

/// A half-lit surface of (.5, .5, .5) under texels red, and green at half alpha.
fn label(role: TextureRole, alpha: AlphaMode) -> Scene {
    let texels = texture(2, 1, |x, _| {
        if x == 0 {
            [255, 0, 0, 255]
        } else {
            [0, 255, 0, 128]
        }
    });
    let material = Material {
        phong: PhongMaterial {
            color: [0.5; 3],
            ka: 1.0,
            kd: 0.0,
            ks: 0.0,
            ns: 1.0,
        },
        base_color: slot(0, Filter::Nearest),
        texture_role: role,
        shading: Shading::PerPixel,
        alpha,
        ..Material::default()
    };
    let lights = vec![Light::Ambient { color: [0.5; 3] }];
    Scene {
        lights,
        textures: vec![texels],
        ..of(material, wall(1.0, 1.0))
    }
}

#[test]
fn a_decal_ignores_light_and_modulation_does_not() {
    let row = |role| {
        let frame = draw(&label(role, AlphaMode::Opaque), 8, 8);
        (pixel(&frame, 2, 4), pixel(&frame, 6, 4))
    };
    // Under the half-transparent texel of the label lies the lit surface, .25 grey.
    let (solid, half) = row(TextureRole::Decal);
    assert_eq!(solid, [255, 0, 0, 255]);
    assert_eq!(half, [32, 128 + 32, 32, 255]);
    // .5 surface x .5 light x texel; alpha plays no part.
    let (solid, half) = row(TextureRole::Modulate);
    assert_eq!(solid, [64, 0, 0, 255]);
    assert_eq!(half, [0, 64, 0, 255]);
}

#[test]
fn a_blended_decal_is_the_texel_over_the_background() {
    let frame = draw(&label(TextureRole::Decal, AlphaMode::Blend), 8, 8);
    assert_eq!(pixel(&frame, 6, 4), [0, 128, 0, 255]);
    assert_eq!(pixel(&frame, 2, 4), [255, 0, 0, 255]);
}

/// sRGB shading happens in linear light: half the light is code 188, not 128.
#[test]
fn light_is_linear() {
    let mut scene = label(TextureRole::Modulate, AlphaMode::Opaque);
    scene.color = ColorMode::Srgb;
    scene.materials[0].phong.color = [1.0; 3];
    let expected = color::linear_to_srgb8(0.5);
    assert_eq!(expected, 188);
    assert_eq!(pixel(&draw(&scene, 8, 8), 2, 4), [expected, 0, 0, 255]);
}

/// Float texels of any size light what they modulate, in the same bits on every level.
#[test]
fn float_texels_are_not_clipped_on_any_level() {
    let image = |texels: &[f32], alpha| {
        Texture2d::new(&Image {
            width: 2,
            height: 1,
            channels: 4,
            texels: TexelData::F32(texels),
            color: ColorSpace::Linear,
            alpha,
            origin: Origin::TopLeft,
        })
        .unwrap()
        .with_mips()
    };
    for (role, alpha) in [
        (TextureRole::Modulate, AlphaMode::Opaque),
        (TextureRole::Decal, AlphaMode::Blend),
        (TextureRole::Decal, AlphaMode::Opaque),
    ] {
        let mut scene = label(role, alpha);
        let texels = [8.0, 0.5, -2.0, 1.0, 0.25, 2.0, 0.0, 0.5];
        scene.textures = vec![image(&texels, Alpha::Premultiplied)];
        scene.materials[0].phong.color = [0.05; 3];
        for filter in [
            Filter::Nearest,
            Filter::Bilinear,
            Filter::Trilinear,
            Filter::Anisotropic(8),
        ] {
            scene.materials[0].base_color = slot(0, filter);
            for msaa in [1, 4] {
                let frame = |level| {
                    let settings = RenderSettings {
                        level,
                        msaa,
                        ..RenderSettings::new(96, 70)
                    };
                    render(&scene, &settings, &texmap_render::no_progress).unwrap()
                };
                let best = frame(Level::new());
                for (name, level) in levels() {
                    let found = frame(level);
                    assert!(found.rgba == best.rgba, "{role:?} {filter:?} {msaa} {name}");
                }
                if role == TextureRole::Modulate && filter == Filter::Nearest && msaa == 1 {
                    // .05 of surface x .5 of light x 8, .5 and -2.
                    assert_eq!(pixel(&best, 20, 35), [51, 3, 0, 255]);
                }
            }
        }
    }
}

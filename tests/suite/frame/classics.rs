//! Solid textures, ramps, decals, letters, skies and volumes: laws, and the same bytes whatever draws them.

use texmap_light::{Environment, EnvironmentLayout, Light};
use texmap_math::glam::{DMat4, DVec3};
use texmap_mesh::Font;
use texmap_render::{Aov, RenderSettings, Renderer, pixel_hash, render, render_ordered};
use texmap_sample::{
    Alpha, ColorSpace, Filter, Image, Origin, Pattern, Sampler, TexelData, Texture2d, Texture3d,
    Wrap,
};
use texmap_scene::{
    AlphaMode, Background, Material, Scene, Shading, SolidTexture, SolidTextureSource, TextureSlot,
    Volume,
};
use texmap_tests::levels::levels;

use crate::scenes::{bits, empty, quad, unlit, values, wall};

fn grid(size: u32, channels: u32) -> Texture3d<'static> {
    let count = size * size * size * channels;
    let texels: Vec<u8> = (0..count)
        .map(|i| (i.wrapping_mul(2_654_435_761) >> 24) as u8)
        .collect();
    let slices = Image {
        width: size,
        height: size,
        channels,
        texels: TexelData::U8(&texels),
        color: ColorSpace::Linear,
        alpha: Alpha::Straight,
        origin: Origin::TopLeft,
    };
    Texture3d::new(size, &slices)
        .expect("a good grid")
        .with_mips()
}

fn row(texels: &[[u8; 4]]) -> Texture2d<'static> {
    let width = texels.len() as u32;
    Texture2d::from_rgba8(
        width,
        1,
        texels.concat(),
        ColorSpace::Linear,
        Origin::TopLeft,
    )
    .expect("a row")
}

fn slot(texture: usize, filter: Filter, wrap: Wrap) -> TextureSlot {
    TextureSlot {
        sampler: Sampler {
            filter,
            wrap_u: wrap,
            wrap_v: wrap,
            ..Sampler::default()
        },
        ..TextureSlot::new(texture)
    }
}

fn fog(density: f32, step: f32) -> Volume {
    Volume {
        grid: 0,
        sampler: Sampler::default(),
        transfer: None,
        density,
        step,
        // From 1 to 3 before the eye, as wide as the view.
        world_from_volume: DMat4::from_translation(DVec3::new(-8.0, -8.0, -3.0))
            * DMat4::from_scale(DVec3::new(16.0, 16.0, 2.0)),
    }
}

fn uniform(value: f32) -> Texture3d<'static> {
    let slices = Image {
        width: 1,
        height: 1,
        channels: 1,
        texels: TexelData::F32(&[value]),
        color: ColorSpace::Linear,
        alpha: Alpha::Data,
        origin: Origin::TopLeft,
    };
    Texture3d::new(1, &slices).expect("one voxel")
}

/// All of them at once.
fn everything(seed: u32) -> Scene {
    let mut scene = Scene {
        background: [0.1, 0.2, 0.3, 1.0],
        lights: vec![
            Light::Ambient { color: [0.3; 3] },
            Light::Directional {
                color: [0.7; 3],
                direction: [-0.3, -1.0, -0.8],
            },
        ],
        textures: vec![
            row(&[[0, 0, 40, 0], [200, 60, 10, 120], [255, 240, 80, 255]]),
            row(&[
                [60, 60, 90, 255],
                [150, 150, 160, 255],
                [255, 255, 255, 255],
            ]),
            Texture2d::from_rgba8(
                16,
                16,
                (0..1024u32)
                    .map(|i| (i.wrapping_mul(2_246_822_519) >> 23) as u8)
                    .collect(),
                ColorSpace::Srgb,
                Origin::TopLeft,
            )
            .expect("a picture"),
        ],
        ..empty()
    };
    scene.effects.grids = vec![grid(7, 1), grid(5, 4)];
    scene.effects.environments = vec![
        Environment::from_fn(EnvironmentLayout::Octahedron, 24, |d| {
            [d.x * d.x, d.y * d.y, d.z * d.z].map(|c| c as f32)
        })
        .expect("a chart"),
    ];
    scene.effects.background = Some(match seed % 2 {
        0 => Background::Environment(0),
        _ => Background::Picture(slot(2, Filter::Trilinear, Wrap::ClampToEdge)),
    });
    let patterns = [
        Pattern::Noise { octaves: 3 },
        Pattern::Marble {
            octaves: 4,
            turbulence: 1.0,
        },
        Pattern::Wood { grain: 0.3 },
    ];
    let mut solid = |source: SolidTextureSource, shading: Shading, ramp: bool| {
        scene.materials.push(Material {
            solid: Some(SolidTexture {
                source,
                world_from_solid: DMat4::from_translation(DVec3::new(0.1, 0.2, -2.0))
                    * DMat4::from_scale(DVec3::splat(0.7)),
            }),
            color_ramp: ramp.then(|| slot(0, Filter::Bilinear, Wrap::ClampToEdge)),
            light_ramp: (shading != Shading::Unlit)
                .then(|| slot(1, Filter::Nearest, Wrap::ClampToEdge)),
            shading,
            ..Material::default()
        });
    };
    for (i, pattern) in patterns.into_iter().enumerate() {
        let shading = [Shading::Unlit, Shading::PerVertex, Shading::PerPixel][i];
        solid(SolidTextureSource::Pattern(pattern), shading, i != 1);
    }
    let sampler = Sampler {
        wrap_u: Wrap::MirroredRepeat,
        ..Sampler::default()
    };
    let source = SolidTextureSource::Grid {
        grid: 1,
        sampler,
        wrap_w: Wrap::Repeat,
    };
    solid(source, Shading::PerPixel, false);
    let textured = Material {
        base_color: Some(slot(2, Filter::Trilinear, Wrap::Repeat)),
        ..Material::default()
    };
    scene.materials.push(Material {
        decal: Some(slot(2, Filter::Bilinear, Wrap::ClampToBorder)),
        ..textured.clone()
    });
    scene.materials.push(Material {
        antialiased_alpha: true,
        alpha: AlphaMode::Blend,
        shading: Shading::Unlit,
        ..textured.clone()
    });
    scene.materials.push(Material {
        color_ramp: Some(slot(0, Filter::Trilinear, Wrap::ClampToEdge)),
        texture_role: texmap_scene::TextureRole::Decal,
        ..textured
    });
    for material in 0..scene.materials.len() - 2 {
        let x = -1.8 + 0.7 * material as f32;
        let z = -1.6 - 0.4 * ((material as u32 + seed) % 3) as f32;
        let mut mesh = quad([
            [x, -1.0, z],
            [x + 0.8, -0.9, z - 0.9],
            [x + 0.7, 0.9, z - 0.6],
            [x - 0.1, 0.8, z],
        ]);
        mesh.material = material;
        scene.meshes.push(mesh);
    }
    let mut heat = wall(0.4, 1.3);
    heat.material = scene.materials.len() - 1;
    scene.meshes.push(heat);
    let font = Font::whole(4, 4, 48);
    let words = font.mesh(
        "03\n85",
        DVec3::new(-0.5, 0.4, -1.2),
        DVec3::X * 0.4,
        DVec3::new(0.1, 0.4, 0.1),
        scene.materials.len() - 2,
    );
    scene.meshes.push(words);
    let mut cloud = fog(1.5, 0.21);
    cloud.transfer = Some(slot(0, Filter::Bilinear, Wrap::ClampToEdge));
    let mut glass = fog(0.8, 0.3);
    glass.grid = 1;
    glass.world_from_volume =
        DMat4::from_rotation_y(0.6) * DMat4::from_translation(DVec3::new(-0.5, -0.7, -1.5));
    scene.effects.volumes = vec![cloud, glass];
    scene
}

#[test]
fn they_have_the_same_bytes_everywhere() {
    let mut colours = std::collections::BTreeSet::new();
    for seed in 0..6 {
        let scene = everything(seed);
        let settings = RenderSettings {
            aovs: Aov::ALL.to_vec(),
            msaa: if seed / 2 == 1 { 4 } else { 1 },
            supersample: if seed / 2 == 2 { 2 } else { 1 },
            ..RenderSettings::new(90, 70)
        };
        let expected =
            render(&scene, &settings, &texmap_render::no_progress).expect("a good scene");
        colours.extend(expected.rgba.chunks_exact(4).map(<[u8]>::to_vec));
        let same = |frame: texmap_render::Frame, what: &str| {
            assert_eq!(
                pixel_hash(&frame),
                pixel_hash(&expected),
                "seed {seed}, {what}"
            );
            assert_eq!(bits(&frame), bits(&expected), "seed {seed}, {what}");
        };
        let general = Renderer::new(&scene, &settings)
            .expect("a good scene")
            .staged();
        same(
            general
                .draw(&texmap_render::no_progress)
                .expect("a good scene"),
            "all stages",
        );
        for (name, level) in levels() {
            let settings = RenderSettings {
                level,
                ..settings.clone()
            };
            same(
                render(&scene, &settings, &texmap_render::no_progress).expect("a good scene"),
                name,
            );
        }
        for threads in [1, 2, 5] {
            let settings = RenderSettings {
                threads: Some(threads),
                ..settings.clone()
            };
            let backwards = |n: usize| (0..n).rev().collect();
            let frame = render_ordered(&scene, &settings, &texmap_render::no_progress, &backwards);
            same(frame.expect("a good scene"), &format!("{threads} threads"));
        }
    }
    assert!(colours.len() > 4000, "{} colours", colours.len());
}

/// Fog before a wall hides what the law of Beer and Lambert says, and behind the wall nothing.
#[test]
fn a_volume_ends_at_what_is_solid() {
    for (distance, inside) in [(0.5f32, 0.0f64), (2.0, 1.0), (5.0, 2.0)] {
        let mut scene = Scene {
            materials: vec![unlit([0.0, 0.0, 0.0])],
            meshes: vec![wall(20.0, distance)],
            ..empty()
        };
        scene.effects.grids = vec![uniform(1.0)];
        for step in [0.05, 100.0] {
            scene.effects.volumes = vec![fog(0.7, step)];
            let frame = render(
                &scene,
                &RenderSettings::new(65, 65),
                &texmap_render::no_progress,
            )
            .expect("a good scene");
            for (x, y) in [(32u32, 32u32), (50, 10), (3, 60)] {
                let slope = |i: u32| (f64::from(i) + 0.5 - 32.5) / 32.5;
                let length = inside * (1.0 + slope(x).powi(2) + slope(y).powi(2)).sqrt();
                let expected = 255.0 * (1.0 - (-0.7 * length).exp());
                let found = f64::from(frame.rgba[((y * 65 + x) * 4) as usize]);
                assert!(
                    (found - expected).abs() <= 0.6,
                    "{distance} {step} ({x}, {y}): {found} {expected}"
                );
            }
        }
        // With a far plane, too.
        scene.camera.far = 50.0;
        let frame = render(
            &scene,
            &RenderSettings::new(65, 65),
            &texmap_render::no_progress,
        )
        .expect("a good scene");
        let found = f64::from(frame.rgba[(32 * 65 + 32) * 4]);
        assert!((found - 255.0 * (1.0 - (-0.7 * inside).exp())).abs() <= 0.6);
    }
}

/// A sky is behind everything and leaves the arrays alone.
#[test]
fn a_backdrop_is_background() {
    let mut scene = Scene {
        materials: vec![unlit([0.0, 1.0, 0.0])],
        meshes: vec![wall(0.5, 1.0)],
        textures: vec![row(&[[255, 0, 0, 255], [0, 0, 255, 255]])],
        ..empty()
    };
    let aovs = vec![Aov::Depth, Aov::Face];
    let settings = RenderSettings {
        aovs,
        ..RenderSettings::new(64, 64)
    };
    let bare = render(&scene, &settings, &texmap_render::no_progress).expect("a good scene");
    scene.effects.background = Some(Background::Picture(slot(
        0,
        Filter::Nearest,
        Wrap::ClampToEdge,
    )));
    for depth_test in [
        texmap_raster::DepthTest::Less,
        texmap_raster::DepthTest::LessOrEqual,
    ] {
        scene.depth_test = depth_test;
        let frame = render(&scene, &settings, &texmap_render::no_progress).expect("a good scene");
        let at = |x: usize, y: usize| &frame.rgba[(y * 64 + x) * 4..][..3];
        assert_eq!(
            (at(2, 2), at(61, 40), at(32, 32)),
            (&[255, 0, 0][..], &[0, 0, 255][..], &[0, 255, 0][..])
        );
        assert_eq!(bits(&frame), bits(&bare));
        assert!(values(&frame, Aov::Depth, 2, 2)[0].is_nan());
    }
}

/// An outline magnified forty times is one pixel soft; the filtered alpha is not.
#[test]
fn crisp_edges_are_one_pixel_wide() {
    let mask = row(&[[255, 255, 255, 0], [255, 255, 255, 255]]);
    let partial = |crisp: bool| {
        let mut material = unlit([1.0; 3]);
        material.base_color = Some(slot(0, Filter::Bilinear, Wrap::ClampToEdge));
        material.alpha = AlphaMode::Blend;
        material.antialiased_alpha = crisp;
        let scene = Scene {
            materials: vec![material],
            meshes: vec![wall(1.0, 1.0)],
            textures: vec![mask.clone()],
            ..empty()
        };
        let frame = render(
            &scene,
            &RenderSettings::new(64, 64),
            &texmap_render::no_progress,
        )
        .expect("a good scene");
        let row = &frame.rgba[32 * 64 * 4..33 * 64 * 4];
        row.chunks_exact(4)
            .filter(|p| p[0] > 0 && p[0] < 255)
            .count()
    };
    assert!(partial(true) <= 2, "{}", partial(true));
    assert!(partial(false) >= 30, "{}", partial(false));
}

#[test]
fn faults_are_named_before_the_first_pixel() {
    let base = || {
        let mut scene = Scene {
            materials: vec![unlit([1.0; 3])],
            meshes: vec![wall(1.0, 2.0)],
            ..empty()
        };
        scene.effects.grids = vec![uniform(1.0)];
        scene
    };
    let says = |scene: Scene, words: &str| {
        let error = render(
            &scene,
            &RenderSettings::new(8, 8),
            &texmap_render::no_progress,
        )
        .expect_err(words)
        .to_string();
        assert!(error.contains(words), "{error} / {words}");
    };
    let with_volume = |volume: Volume| {
        let mut scene = base();
        scene.effects.volumes = vec![volume];
        scene
    };
    says(
        with_volume(Volume {
            grid: 3,
            ..fog(1.0, 1.0)
        }),
        "grid",
    );
    says(with_volume(fog(f32::NAN, 1.0)), "density");
    says(with_volume(fog(1.0, 0.0)), "step");
    let flat = DMat4::from_scale(DVec3::new(1.0, 0.0, 1.0));
    says(
        with_volume(Volume {
            world_from_volume: flat,
            ..fog(1.0, 1.0)
        }),
        "placement",
    );
    let mut scene = base();
    scene.effects.background = Some(Background::Environment(0));
    says(scene, "backdrop");
    let mut scene = base();
    scene.materials[0].solid = Some(SolidTexture {
        source: SolidTextureSource::Pattern(Pattern::Wood { grain: f32::NAN }),
        world_from_solid: DMat4::IDENTITY,
    });
    says(scene, "fold");
    let mut scene = base();
    scene.materials[0].solid = Some(SolidTexture {
        source: SolidTextureSource::Pattern(Pattern::Wood { grain: 0.0 }),
        world_from_solid: flat,
    });
    says(scene, "solid texture");
    let mut scene = base();
    scene.materials[0].decal = Some(slot(7, Filter::Nearest, Wrap::Repeat));
    says(scene, "texture");
}

/// A row of one colour and half its alpha, along a texture without alpha.
fn ramped(texel: [u8; 4]) -> Scene {
    let mut scene = Scene {
        background: [0.0, 0.0, 1.0, 1.0],
        textures: vec![row(&[texel; 2]), row(&[[128, 0, 0, 255]; 2])],
        materials: vec![Material {
            base_color: Some(slot(1, Filter::Bilinear, Wrap::ClampToEdge)),
            color_ramp: Some(slot(0, Filter::Bilinear, Wrap::ClampToEdge)),
            shading: Shading::Unlit,
            phong: texmap_light::PhongMaterial {
                color: [1.0; 3],
                ..Default::default()
            },
            ..Material::default()
        }],
        meshes: vec![wall(9.0, 2.0)],
        color: texmap_scene::ColorMode::Raw,
        ..empty()
    };
    scene.meshes[0].material = 0;
    scene
}

#[test]
fn the_colour_of_a_ramp_is_not_darkened_by_its_alpha() {
    let texel = [200, 100, 50, 128];
    for (name, level) in levels() {
        let middle = |scene: &Scene| {
            let settings = RenderSettings {
                level,
                ..RenderSettings::new(9, 9)
            };
            let frame = render(scene, &settings, &texmap_render::no_progress).unwrap();
            frame.rgba.as_chunks::<4>().0[40]
        };
        let mut scene = ramped(texel);
        // An opaque surface has the colour, and no use for the alpha.
        let near = |a: [u8; 4], b: [u8; 4]| (0..4).all(|k| a[k].abs_diff(b[k]) <= 1);
        let found = middle(&scene);
        assert!(near(found, [200, 100, 50, 255]), "{name}: {found:?}");
        // Negative twin: a blended one shows what is behind, by 127 parts of 255.
        scene.materials[0].alpha = AlphaMode::Blend;
        let blended = [100, 50, 25 + 127, 255];
        let found = middle(&scene);
        assert!(near(found, blended), "{name}: {found:?}");
        // A row without alpha is drawn as ever.
        let found = middle(&ramped([200, 100, 50, 255]));
        assert!(near(found, [200, 100, 50, 255]), "{name}: {found:?}");
    }
}

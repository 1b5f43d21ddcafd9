//! The same scene gives the same bytes, however the work is handed out.

use std::ops::ControlFlow;

use texmap_benches::bench_scenes::{Content, Hidden, SCENES};
use texmap_light::{
    Environment, EnvironmentLayout, Light, NormalMapGreen, PhongMaterial, ProjectorBorder,
    ShadowBias, SpecularModel,
};
use texmap_math::glam::{DMat4, DVec3};
use texmap_math::{Level, Projector};
use texmap_raster::Cull;
use texmap_render::{
    Aov, Frame, RenderError, RenderSettings, Renderer, pixel_hash, render, render_ordered,
};
use texmap_sample::{Filter, Precision, Sampler};
use texmap_scene::{
    AlphaMode, Effects, LightMapSlot, Material, Mesh, NormalDetail, ProjectorLight, ProjectorMode,
    Reflection, Scene, Shading, Shadow, TextureRole,
};
use texmap_tests::levels::levels;

use crate::scenes::{bits, empty, quad, slot, texture, unlit, wall};

/// Everything at once: cut-outs, blending, both kinds of lighting, a shared material, a frame that ends inside a block.
fn busy() -> Scene {
    let checker = texture(64, 64, |x, y| {
        if (x / 8 + y / 8) % 2 == 0 {
            [230, 220, 200, 255]
        } else {
            [40, 60, 90, 255]
        }
    });
    let leaf = texture(33, 17, |x, y| {
        [40, 160, 60, ((x * 37 + y * 91) % 256) as u8]
    });
    let white = PhongMaterial {
        color: [1.0; 3],
        ..PhongMaterial::default()
    };
    let floor = Material {
        phong: white,
        base_color: slot(0, Filter::Trilinear),
        ..Material::default()
    };
    let leaves = Material {
        base_color: slot(1, Filter::Bilinear),
        texture_role: TextureRole::Decal,
        alpha: AlphaMode::Test(0.0),
        ..unlit([1.0; 3])
    };
    let glass = Material {
        alpha: AlphaMode::Blend,
        opacity: 0.4,
        ..unlit([0.9, 0.1, 0.2])
    };
    let clay = Material {
        shading: Shading::PerVertex,
        base_color: slot(0, Filter::Nearest),
        ..Material::default()
    };
    let ball = ball(16);
    Scene {
        background: [0.2, 0.3, 0.4, 0.5],
        lights: vec![
            Light::Ambient { color: [0.2; 3] },
            Light::Directional {
                color: [0.6; 3],
                direction: [1.0, -2.0, -1.0],
            },
            Light::Point {
                color: [0.2, 0.3, 0.4],
                position: [0.0, 1.0, -1.0],
            },
        ],
        textures: vec![checker, leaf],
        materials: vec![floor, leaves, glass, clay],
        meshes: vec![
            ground(),
            Mesh {
                material: 1,
                ..wall(0.6, 1.7)
            },
            Mesh {
                material: 3,
                ..ball
            },
            Mesh {
                material: 2,
                ..quad([
                    [-0.9, -0.5, -1.5],
                    [0.2, -0.5, -1.0],
                    [0.2, 0.4, -1.0],
                    [-0.9, 0.4, -1.5],
                ])
            },
            Mesh {
                material: 2,
                ..quad([
                    [-0.5, -0.7, -1.2],
                    [0.9, -0.7, -1.9],
                    [0.9, 0.6, -1.9],
                    [-0.5, 0.6, -1.2],
                ])
            },
        ],
        ..empty()
    }
}

fn ground() -> Mesh {
    quad([
        [-9.0, -1.0, 1.0],
        [9.0, -1.0, 1.0],
        [9.0, -1.0, -40.0],
        [-9.0, -1.0, -40.0],
    ])
}

fn ball(n: u32) -> Mesh {
    let mut mesh = Mesh::default();
    for i in 0..=n {
        for j in 0..=n {
            let (v, u) = (f64::from(i) / f64::from(n), f64::from(j) / f64::from(n));
            let (theta, phi) = (v * std::f64::consts::PI, u * std::f64::consts::TAU);
            let normal = [
                theta.sin() * phi.cos(),
                theta.cos(),
                -theta.sin() * phi.sin(),
            ];
            mesh.positions.push([
                normal[0] as f32 + 0.8,
                normal[1] as f32,
                normal[2] as f32 - 3.0,
            ]);
            mesh.normals.push(normal.map(|x| x as f32));
            mesh.uvs.push([u as f32 * 4.0, v as f32 * 2.0]);
        }
    }
    for i in 0..n {
        for j in 0..n {
            let a = i * (n + 1) + j;
            mesh.triangles.push([a, a + n + 1, a + 1]);
            mesh.triangles.push([a + 1, a + n + 1, a + n + 2]);
        }
    }
    mesh
}

fn settings(supersample: u32) -> RenderSettings {
    RenderSettings {
        supersample,
        aovs: Aov::ALL.to_vec(),
        ..RenderSettings::new(200, 150)
    }
}

fn assert_same(frame: &Frame, expected: &Frame, what: &str) {
    assert_eq!(pixel_hash(frame), pixel_hash(expected), "{what}");
    assert_eq!(bits(frame), bits(expected), "{what}");
    assert_eq!(
        frame.stats.pixels_covered, expected.stats.pixels_covered,
        "{what}"
    );
}

/// Bands of any heights, with samples of any kind, are the rows of the whole picture and of its arrays.
#[test]
fn bands_are_the_rows_of_the_whole() {
    let scene = busy();
    for (supersample, msaa) in [(1, 1), (2, 1), (1, 4)] {
        let settings = RenderSettings {
            msaa,
            ..settings(supersample)
        };
        let draw = |rows: std::ops::Range<u32>| {
            let settings = RenderSettings {
                tile_rows: Some(rows),
                ..settings.clone()
            };
            render(&scene, &settings, &texmap_render::no_progress)
        };
        let whole = render(&scene, &settings, &texmap_render::no_progress).unwrap();
        // 150 rows of pixels are three rows of tiles, the last one cut.
        let bands = [draw(0..1).unwrap(), draw(1..3).unwrap()];
        assert_eq!(bands.each_ref().map(|b| b.height), [64, 86]);
        let joined: Vec<u8> = bands.iter().flat_map(|b| b.rgba.clone()).collect();
        assert!(joined == whole.rgba);
        let [first, second] = bands.each_ref().map(bits);
        for (index, values) in bits(&whole).into_iter().enumerate() {
            assert!(
                [&first[index][..], &second[index]].concat() == values,
                "{index}"
            );
        }
        // A band is not its neighbour.
        assert!(bands[0].rgba != bands[1].rgba[..bands[0].rgba.len()]);
        for bad in [0..4, 2..2, 3..4] {
            let error = draw(bad).unwrap_err();
            assert_eq!(error.code(), "render-value");
        }
    }
}

#[test]
fn threads_levels_and_block_order_reach_no_pixel() {
    let scene = busy();
    for supersample in [1, 3] {
        let settings = settings(supersample);
        let expected = render(&scene, &settings, &texmap_render::no_progress).unwrap();
        for threads in [1, 2, 3, 8] {
            let settings = RenderSettings {
                threads: Some(threads),
                ..settings.clone()
            };
            assert_same(
                &render(&scene, &settings, &texmap_render::no_progress).unwrap(),
                &expected,
                &format!("{threads} threads"),
            );
        }
        for (name, level) in levels() {
            let settings = RenderSettings {
                level,
                ..settings.clone()
            };
            assert_same(
                &render(&scene, &settings, &texmap_render::no_progress).unwrap(),
                &expected,
                name,
            );
        }
        let backwards = |n: usize| (0..n).rev().collect();
        let strided = |n: usize| {
            (0..n)
                .filter(|i| i % 3 == 1)
                .chain((0..n).filter(|i| i % 3 != 1))
                .collect()
        };
        let orders: [&(dyn Fn(usize) -> Vec<usize> + Sync); 2] = [&backwards, &strided];
        for order in orders {
            let settings = RenderSettings {
                threads: Some(1),
                ..settings.clone()
            };
            assert_same(
                &render_ordered(&scene, &settings, &texmap_render::no_progress, order).unwrap(),
                &expected,
                "block order",
            );
        }
    }
}

/// Every stage of lit surfaces that has lanes: normal maps on both sides, spot, directional and point lights with all biases,
/// projectors with and without shadows, real and whole exponents, mirrors with and without bumps, normals in object space, baked
/// light beside computed.
fn lit() -> Scene {
    let bumps = texture(64, 64, |x, y| {
        [
            (64 + 2 * x) as u8,
            (60 + 2 * (y ^ x)) as u8,
            200 + (x % 8) as u8,
            255,
        ]
    });
    let checker = texture(64, 64, |x, y| {
        if (x / 8 + y / 8) % 2 == 0 {
            [230, 220, 200, 255]
        } else {
            [40, 60, 90, 255]
        }
    });
    let detail = |green, rebuild_z| {
        Some(NormalDetail::NormalMap {
            slot: slot(0, Filter::Trilinear).unwrap(),
            green,
            rebuild_z,
            object_space: false,
            strength: 1.5,
        })
    };
    let sky = Environment::from_fn(EnvironmentLayout::Cube, 32, |d| {
        [d.x, d.y, d.z].map(|c| 0.5 + 0.4 * c as f32)
    });
    let reflection = Some(Reflection {
        environment: 0,
        reflectivity: 0.3,
        within: None,
    });
    let floor = Material {
        base_color: slot(1, Filter::Trilinear),
        normal_detail: detail(NormalMapGreen::Up, false),
        specular_model: SpecularModel::Blinn,
        phong: PhongMaterial {
            ns: 20.5,
            ..PhongMaterial::default()
        },
        ..Material::default()
    };
    let metal = Material {
        normal_detail: detail(NormalMapGreen::Down, true),
        horizon_clamp: false,
        reflection,
        phong: PhongMaterial {
            ns: 32.0,
            ..PhongMaterial::default()
        },
        ..Material::default()
    };
    let mirror = Material {
        base_color: slot(1, Filter::Bilinear),
        cull: Cull::Front,
        reflection,
        ..Material::default()
    };
    let carved = Material {
        normal_detail: Some(NormalDetail::NormalMap {
            slot: slot(0, Filter::Bilinear).unwrap(),
            green: NormalMapGreen::Up,
            rebuild_z: false,
            object_space: true,
            strength: 1.0,
        }),
        ..Material::default()
    };
    // Of a texture with alpha, of which only the colour counts.
    let opacity = texture(16, 16, |x, y| {
        [(x * 16) as u8, (y * 13) as u8, 90, 100 + (8 * x) as u8]
    });
    let baked = Material {
        base_color: slot(1, Filter::Trilinear),
        light_map: Some(LightMapSlot {
            slot: slot(2, Filter::Trilinear).unwrap(),
            scale: 1.3,
            baked: Some(vec![0, 1]),
        }),
        ..Material::default()
    };
    let projector = |x: f64, border, softness, shadow, role| {
        let position = DVec3::new(x, 3.0, 1.0);
        let look = DVec3::new(0.0, -0.5, -4.0);
        ProjectorLight {
            projector: Projector::new(position, look, DVec3::Y, 0.7, 1.0).unwrap(),
            position,
            texture: 1,
            sampler: Sampler {
                filter: Filter::Bilinear,
                ..Sampler::default()
            },
            border,
            softness,
            mode: role,
            shadow,
        }
    };
    let shadow = |light, bias, pcf_size| Shadow {
        light,
        size: Some(256),
        bias: Some(bias),
        pcf_size,
        area: (light == 3).then_some((DVec3::new(0.0, 0.0, -3.0), 2.0)),
    };
    let light = ProjectorMode::Light([0.4, 0.5, 0.3]);
    let painted = ball(20);
    let light_uvs = painted.uvs.iter().map(|[u, v]| [v * 0.9, u * 0.8 + 0.1]);
    let light_uvs = light_uvs.collect();
    Scene {
        lights: vec![
            Light::Ambient { color: [0.2; 3] },
            Light::Directional {
                color: [0.4; 3],
                direction: [1.0, -2.0, -1.0],
            },
            Light::spot(
                [0.5, 0.4, 0.3],
                [1.5, 3.0, 0.0],
                [-0.4, -1.0, -0.8],
                0.3,
                0.6,
            ),
            Light::Point {
                color: [0.2, 0.3, 0.4],
                position: [0.0, 2.5, -1.0],
            },
        ],
        textures: vec![bumps, checker, opacity],
        materials: vec![floor, metal, mirror, carved, baked],
        meshes: vec![
            ground(),
            Mesh {
                material: 1,
                ..ball(24)
            },
            Mesh {
                material: 2,
                world_from_object: DMat4::from_translation(DVec3::new(-1.9, 0.0, 0.0)),
                ..ball(24)
            },
            Mesh {
                material: 3,
                world_from_object: DMat4::from_translation(DVec3::new(1.9, 0.3, 0.0))
                    * DMat4::from_scale(DVec3::new(0.5, 0.9, 0.6)),
                ..ball(16)
            },
            Mesh {
                material: 4,
                lightmap_uvs: light_uvs,
                world_from_object: DMat4::from_translation(DVec3::new(0.0, 1.1, -1.0)),
                ..painted
            },
        ],
        effects: Effects {
            shadows: vec![
                shadow(1, ShadowBias::Slope(1e-3), 3),
                shadow(2, ShadowBias::NormalOffset(1.5), 5),
                shadow(3, ShadowBias::Constant(0.02), 1),
            ],
            projectors: vec![
                projector(1.0, ProjectorBorder::Black, 0.1, Some(128), light),
                projector(-1.0, ProjectorBorder::Repeat, 0.0, None, light),
            ],
            environments: vec![sky.unwrap().with_mips()],
            ..Effects::default()
        },
        ..empty()
    }
}

#[test]
fn lit_surfaces_have_the_same_bytes_sample_by_sample_and_in_lanes() {
    let scene = lit();
    let settings = RenderSettings::new(200, 150);
    let expected = render(&scene, &settings, &texmap_render::no_progress).unwrap();
    for (name, level) in levels() {
        for (supersample, msaa) in [(1, 1), (1, 4), (2, 1)] {
            let settings = |level| RenderSettings {
                level,
                supersample,
                msaa,
                ..settings.clone()
            };
            let one = render(&scene, &settings(level), &texmap_render::no_progress).unwrap();
            let best =
                render(&scene, &settings(Level::new()), &texmap_render::no_progress).unwrap();
            assert_same(&one, &best, name);
        }
    }
    // Each effect is there to be compared.
    let without = |change: &dyn Fn(&mut Scene)| {
        let mut scene = lit();
        change(&mut scene);
        let frame = render(&scene, &settings, &texmap_render::no_progress).unwrap();
        let pairs = frame.rgba.chunks(4).zip(expected.rgba.chunks(4));
        assert!(pairs.filter(|(a, b)| a != b).count() > 100);
    };
    for i in 0..3 {
        without(&|scene| {
            scene.effects.shadows.remove(i);
        });
    }
    for i in 0..2 {
        without(&|scene| {
            scene.effects.projectors.remove(i);
        });
        without(&|scene| scene.materials[i].normal_detail = None);
        without(&|scene| scene.materials[i + 1].reflection = None);
    }
    without(&|scene| scene.materials[3].normal_detail = None);
    without(&|scene| {
        scene.materials[4].light_map.as_mut().unwrap().scale = 0.2;
    });
}

/// The scenes of the race, smaller; two million triangles stand in for by two hundred thousand.
#[test]
fn benchmark_scenes_have_the_same_bytes_everywhere() {
    let mut rows = 0;
    for row in SCENES {
        let redrawn = row.content == (Content::Lit { shadow_pass: true });
        let large = matches!(
            row.content,
            Content::Sphere {
                thousands: 2000,
                ..
            }
        );
        let layered = matches!(row.content, Content::Layers { blend: false, .. });
        let modes = [
            (Precision::Fast, Hidden::Skipped, true),
            (Precision::Exact, Hidden::Skipped, !redrawn),
            (Precision::Fast, Hidden::Shaded, layered),
        ];
        for (precision, hidden, _) in modes.into_iter().filter(|mode| mode.2 && !large) {
            let Some(scene) = row.scene(precision, hidden).unwrap() else {
                continue;
            };
            rows += 1;
            let hash = |level, threads, backwards| {
                let mut settings = RenderSettings {
                    level,
                    threads: Some(threads),
                    ..RenderSettings::new(320, 180)
                };
                if let Content::Sphere { samples, .. } = row.content {
                    settings.msaa = samples;
                }
                let mut renderer = Renderer::new(&scene, &settings).unwrap();
                if redrawn {
                    renderer.redraw_shadows().unwrap();
                }
                let mut frame = renderer.draw(&texmap_render::no_progress).unwrap();
                if backwards {
                    // Another order of tiles, over what the frame before has left in the buffers.
                    let order = |blocks| (0..blocks).rev().collect();
                    renderer
                        .draw_into(&mut frame, &texmap_render::no_progress, &order)
                        .unwrap();
                }
                pixel_hash(&frame)
            };
            let mut expected = None;
            // Every level, and every count of threads in one order of tiles or the other.
            for ((name, level), threads) in
                levels().into_iter().zip([1, 8, 3, 2].into_iter().cycle())
            {
                let found = hash(level, threads, threads > 2);
                let what = format!("{} at {name} on {threads} threads", row.key());
                assert_eq!(
                    expected.get_or_insert_with(|| found.clone()),
                    &found,
                    "{what}"
                );
            }
        }
    }
    assert!(rows > 30, "{rows} scenes");
}

/// The negative twin: the comparison above is not one of empty or constant frames, and the hash sees one pixel.
#[test]
fn a_change_of_the_scene_reaches_the_hash() {
    let scene = busy();
    let frame = render(&scene, &settings(1), &texmap_render::no_progress).unwrap();
    let mut seen: Vec<_> = frame.rgba.chunks_exact(4).collect();
    seen.sort_unstable();
    seen.dedup();
    assert!(seen.len() > 500, "only {} colours", seen.len());
    let mut moved = busy();
    moved.meshes[3].positions[0][0] += 0.02;
    assert_ne!(
        pixel_hash(&render(&moved, &settings(1), &texmap_render::no_progress).unwrap()),
        pixel_hash(&frame)
    );
}

/// Blocks are split in halves, and a thread that waits for one half takes blocks of another: only the innermost draws.
#[test]
fn many_blocks_are_drawn_on_a_small_stack() {
    let settings = RenderSettings::new(2048, 2048);
    let scene = busy();
    let draw = || render(&scene, &settings, &texmap_render::no_progress).unwrap();
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(2)
        .stack_size(600 << 10)
        .build()
        .unwrap();
    assert_eq!(pixel_hash(&pool.install(draw)), pixel_hash(&draw()));
}

#[test]
fn progress_counts_every_block_once() {
    let calls = std::sync::Mutex::new(Vec::new());
    let note = |done, of| {
        calls.lock().unwrap().push((done, of));
        ControlFlow::Continue(())
    };
    render(&busy(), &settings(2), &note).unwrap();
    let mut calls = calls.into_inner().unwrap();
    calls.sort_unstable();
    // 4 x 3 blocks, twice: AOVs have their own pass under supersampling.
    assert_eq!(calls, (1..=24).map(|done| (done, 24)).collect::<Vec<_>>());
}

/// A break ends the work before every block is drawn, with an error of its own; without one the same callback draws all.
#[test]
fn a_break_of_the_callback_cancels_the_frame() {
    let calls = std::sync::atomic::AtomicUsize::new(0);
    let after_three = |_, of| {
        let done = calls.fetch_add(1, std::sync::atomic::Ordering::Relaxed) + 1;
        assert_eq!(of, 24);
        match done {
            ..3 => ControlFlow::Continue(()),
            _ => ControlFlow::Break(()),
        }
    };
    let two = RenderSettings {
        threads: Some(2),
        ..settings(2)
    };
    let error = render(&busy(), &two, &after_three).unwrap_err();
    assert_eq!(error, RenderError::Cancelled);
    assert_eq!(error.code(), "cancelled");
    // Each thread may have one block under way.
    let calls = calls.into_inner();
    assert!((3..=3 + 2).contains(&calls), "{calls}");
}

#[test]
fn no_threads_is_an_error() {
    let error = render(
        &busy(),
        &RenderSettings {
            threads: Some(0),
            ..settings(1)
        },
        &texmap_render::no_progress,
    )
    .unwrap_err();
    assert!(
        matches!(error, RenderError::Threads { threads: 0, .. }),
        "{error}"
    );
}

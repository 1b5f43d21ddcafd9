//! The same scene gives the same bytes, however the work is handed out.

use texmap_light::{Light, Surface};
use texmap_render::{
    AlphaMode, Aov, Frame, Material, Mesh, RenderError, Scene, Settings, Shading, TextureRole,
    pixel_hash, render, render_ordered,
};
use texmap_sample::Filter;
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
    let white = Surface {
        color: [1.0; 3],
        ..Surface::default()
    };
    let floor = Material {
        surface: white,
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
            quad([
                [-9.0, -1.0, 1.0],
                [9.0, -1.0, 1.0],
                [9.0, -1.0, -40.0],
                [-9.0, -1.0, -40.0],
            ]),
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

fn settings(supersample: u32) -> Settings {
    Settings {
        supersample,
        aovs: Aov::ALL.to_vec(),
        ..Settings::new(200, 150)
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

#[test]
fn threads_levels_and_block_order_reach_no_pixel() {
    let scene = busy();
    for supersample in [1, 3] {
        let settings = settings(supersample);
        let expected = render(&scene, &settings, &|_, _| ()).unwrap();
        for threads in [1, 2, 3, 8] {
            let settings = Settings {
                threads: Some(threads),
                ..settings.clone()
            };
            assert_same(
                &render(&scene, &settings, &|_, _| ()).unwrap(),
                &expected,
                &format!("{threads} threads"),
            );
        }
        for (name, level) in levels() {
            let settings = Settings {
                level,
                ..settings.clone()
            };
            assert_same(
                &render(&scene, &settings, &|_, _| ()).unwrap(),
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
            let settings = Settings {
                threads: Some(1),
                ..settings.clone()
            };
            assert_same(
                &render_ordered(&scene, &settings, &|_, _| (), order).unwrap(),
                &expected,
                "block order",
            );
        }
    }
}

/// The negative twin: the comparison above is not one of empty or constant frames, and the hash sees one pixel.
#[test]
fn a_change_of_the_scene_reaches_the_hash() {
    let scene = busy();
    let frame = render(&scene, &settings(1), &|_, _| ()).unwrap();
    let mut seen: Vec<_> = frame.rgba.chunks_exact(4).collect();
    seen.sort_unstable();
    seen.dedup();
    assert!(seen.len() > 500, "only {} colours", seen.len());
    let mut moved = busy();
    moved.meshes[3].positions[0][0] += 0.02;
    assert_ne!(
        pixel_hash(&render(&moved, &settings(1), &|_, _| ()).unwrap()),
        pixel_hash(&frame)
    );
}

#[test]
fn progress_counts_every_block_once() {
    let calls = std::sync::Mutex::new(Vec::new());
    let note = |done, of| calls.lock().unwrap().push((done, of));
    render(&busy(), &settings(2), &note).unwrap();
    let mut calls = calls.into_inner().unwrap();
    calls.sort_unstable();
    // 4 x 3 blocks, twice: AOVs have their own pass under supersampling.
    assert_eq!(calls, (1..=24).map(|done| (done, 24)).collect::<Vec<_>>());
}

#[test]
fn no_threads_is_an_error() {
    let error = render(
        &busy(),
        &Settings {
            threads: Some(0),
            ..settings(1)
        },
        &|_, _| (),
    )
    .unwrap_err();
    assert!(
        matches!(error, RenderError::Threads { threads: 0, .. }),
        "{error}"
    );
}

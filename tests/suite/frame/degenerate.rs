//! Scenes in which nothing can be seen: a frame of background that says why, never a silent black one.

use texmap_light::Light;
use texmap_math::glam::{DMat4, DVec3};
use texmap_raster::{Cull, Interp};
use texmap_render::Frame;
use texmap_sample::Filter;
use texmap_scene::{AlphaMode, Material, Mesh, Scene, Shading};

use crate::scenes::{draw, empty, of, slot, texture, unlit, wall};

const BACKGROUND: [f32; 4] = [0.2, 0.4, 0.6, 1.0];

/// Draws, checks that the background is all there is, and returns the last warning.
fn nothing(scene: Scene) -> String {
    let frame: Frame = draw(
        &Scene {
            background: BACKGROUND,
            ..scene
        },
        70,
        40,
    );
    assert!(frame.rgba.chunks_exact(4).all(|p| p == [51, 102, 153, 255]));
    assert_eq!(frame.stats.pixels_covered, 0);
    let warning = frame.warnings.last().unwrap().clone();
    assert!(warning.starts_with("nothing was drawn: "), "{warning}");
    warning
}

#[test]
fn the_reason_is_named() {
    let white = || unlit([1.0; 3]);
    assert!(nothing(empty()).contains("no meshes"));
    assert!(nothing(of(white(), Mesh::default())).contains("no mesh has a triangle"));
    assert!(nothing(of(white(), wall(1.0, -3.0))).contains("behind the eye"));
    let culled = Material {
        cull: Cull::Front,
        ..white()
    };
    assert!(nothing(of(culled, wall(1.0, 3.0))).contains("culled"));
    let line = Mesh {
        triangles: vec![[0, 0, 1], [1, 2, 2]],
        ..wall(1.0, 3.0)
    };
    assert!(nothing(of(white(), line)).contains("no area"));
    // A sliver between two columns of pixel centres.
    let thin = Mesh {
        world_from_object: DMat4::from_scale(DVec3::new(1e-3, 1.0, 1.0)),
        ..wall(1.0, 3.0)
    };
    assert!(nothing(of(white(), thin)).contains("between pixel centres"));
    let clear = Material {
        alpha: AlphaMode::Test(0.0),
        base_color: slot(0, Filter::Nearest),
        ..white()
    };
    let transparent = Scene {
        textures: vec![texture(1, 1, |_, _| [255, 0, 0, 0])],
        ..of(clear, wall(1.0, 3.0))
    };
    assert!(nothing(transparent).contains("alpha"));
}

#[test]
fn huge_vertices_are_dropped_by_count() {
    let mesh = Mesh {
        world_from_object: DMat4::from_scale(DVec3::splat(1e60)),
        ..wall(1.0, 3.0)
    };
    // World positions do not fit f32; only light asks for them.
    let light = Light::Point {
        color: [1.0; 3],
        position: [0.0; 3],
    };
    let lit = Material {
        shading: Shading::PerPixel,
        ..unlit([1.0; 3])
    };
    assert!(
        nothing(Scene {
            lights: vec![light],
            ..of(lit, mesh)
        })
        .contains("overflow")
    );
    let far = Mesh {
        world_from_object: DMat4::from_scale(DVec3::splat(1e30)),
        ..wall(1.0, 3.0)
    };
    assert!(draw(&of(unlit([1.0; 3]), far), 9, 9).stats.pixels_covered > 0);
}

/// One pixel, one column, one row, and every interpolation by name.
#[test]
fn small_pictures_and_every_interpolation_draw() {
    let mut scene = of(unlit([1.0; 3]), wall(900.0, 3.0));
    scene.textures = vec![texture(1, 7, |_, _| [255; 4])];
    scene.materials[0].base_color = slot(0, Filter::Anisotropic(16));
    let ways = [
        Interp::Perspective,
        Interp::Affine,
        Interp::Subdivided(3),
        Interp::Span(16),
        Interp::WithinError(0.5),
    ];
    for interp in ways {
        scene.materials[0].interp = interp;
        for (width, height) in [(1, 1), (1, 90), (200, 1), (65, 65)] {
            let frame = draw(&scene, width, height);
            assert!(
                frame.rgba.iter().all(|byte| *byte == 255),
                "{interp:?} {width} x {height}"
            );
        }
    }
}

//! Light per vertex and per pixel, on the side that is seen.

use texmap_light::{Light, PhongMaterial, illuminate};
use texmap_math::glam::{DMat4, DVec3};
use texmap_raster::Cull;
use texmap_render::Aov;
use texmap_sample::Filter;
use texmap_scene::{Material, Mesh, Scene, Shading, VertexColorInterp};

use crate::scenes::{draw, draw_aovs, of, pixel, slot, texture, values, wall};

const SHINY: PhongMaterial = PhongMaterial {
    color: [0.6, 0.4, 0.2],
    ka: 1.0,
    kd: 0.7,
    ks: 0.5,
    ns: 12.0,
};

fn lights() -> Vec<Light> {
    vec![
        Light::Ambient { color: [0.1; 3] },
        Light::Directional {
            color: [0.3, 0.4, 0.5],
            direction: [1.0, -1.0, -2.0],
        },
        Light::Point {
            color: [0.4, 0.3, 0.2],
            position: [0.3, 0.4, -0.5],
        },
    ]
}

fn lit(shading: Shading) -> Scene {
    let material = Material {
        phong: SHINY,
        shading,
        ..Material::default()
    };
    Scene {
        lights: lights(),
        ..of(material, wall(1.5, 1.5))
    }
}

#[test]
fn per_pixel_light_is_the_formula_at_each_pixel() {
    let scene = lit(Shading::PerPixel);
    let frame = draw_aovs(&scene, 65, 65, &[Aov::Position]);
    let mut brightest = 0;
    for (x, y) in (0..65).flat_map(|x| (0..65).map(move |y| (x, y))) {
        let point: [f32; 3] = values(&frame, Aov::Position, x, y).try_into().unwrap();
        let expected = illuminate(&SHINY, &lights(), point, [0.0, 0.0, 1.0], [0.0; 3]);
        let got = pixel(&frame, x, y);
        for (got, expected) in got.iter().zip(expected) {
            assert!(
                (f32::from(*got) - expected * 255.0).abs() <= 0.501,
                "{x} {y}: {got} for {}",
                expected * 255.0
            );
        }
        brightest = brightest.max(got[0]);
    }
    assert!(brightest > 110, "the highlight is missing: {brightest}");
}

/// Corners carry the light of the corners; the highlight in the middle, which no corner sees, is lost.
#[test]
fn per_vertex_light_is_interpolated_from_the_corners() {
    let (vertex, fragment) = (
        draw(&lit(Shading::PerVertex), 65, 65),
        draw(&lit(Shading::PerPixel), 65, 65),
    );
    for (x, y) in [(0, 0), (64, 0), (0, 64), (64, 64)] {
        for (a, b) in pixel(&vertex, x, y).iter().zip(pixel(&fragment, x, y)) {
            assert!(a.abs_diff(b) <= 4, "corner {x} {y}");
        }
    }
    let middle = |frame| pixel(frame, 40, 24)[0];
    assert!(
        middle(&fragment) > middle(&vertex) + 20,
        "{} {}",
        middle(&fragment),
        middle(&vertex)
    );
}

/// White texels change nothing, whether the texel goes between the light terms or there is none.
#[test]
fn a_white_texture_modulates_by_one() {
    for shading in [Shading::PerVertex, Shading::PerPixel] {
        let plain = lit(shading);
        let mut textured = lit(shading);
        textured.textures = vec![texture(2, 2, |_, _| [255; 4])];
        textured.materials[0].base_color = slot(0, Filter::Trilinear);
        let (a, b) = (draw(&plain, 33, 33), draw(&textured, 33, 33));
        let worst = a
            .rgba
            .iter()
            .zip(&b.rgba)
            .map(|(a, b)| a.abs_diff(*b))
            .max()
            .unwrap();
        assert!(worst <= 1, "{shading:?}: {worst}");
    }
}

#[test]
fn vertex_colours_tint_the_surface_under_any_shading() {
    for shading in [Shading::Unlit, Shading::PerVertex, Shading::PerPixel] {
        for textured in [false, true] {
            let mut scene = lit(shading);
            scene.materials[0].phong = PhongMaterial { ks: 0.0, ..SHINY };
            scene.materials[0].vertex_color_interp = VertexColorInterp::Perspective;
            if textured {
                scene.textures = vec![texture(1, 1, |_, _| [255; 4])];
                scene.materials[0].base_color = slot(0, Filter::Nearest);
            }
            let plain = draw(&scene, 17, 17);
            scene.meshes[0].colors = vec![[0.5, 1.0, 0.25]; 4];
            let tinted = draw(&scene, 17, 17);
            for (p, t) in plain.rgba.chunks_exact(4).zip(tinted.rgba.chunks_exact(4)) {
                for (i, k) in [0.5, 1.0, 0.25].into_iter().enumerate() {
                    assert!(
                        (f32::from(t[i]) - f32::from(p[i]) * k).abs() <= 1.0,
                        "{shading:?} {textured}"
                    );
                }
            }
        }
    }
}

/// A face seen from behind is lit as the face turned round.
#[test]
fn both_sides_light_the_side_that_is_seen() {
    for shading in [Shading::PerVertex, Shading::PerPixel] {
        let front = draw(&lit(shading), 33, 33);
        let mut scene = lit(shading);
        scene.meshes[0]
            .triangles
            .iter_mut()
            .for_each(|t| t.swap(1, 2));
        assert!(draw(&scene, 33, 33).rgba == front.rgba, "{shading:?}");
        // Negative twin: culling shows that the back was drawn.
        scene.materials[0].cull = Cull::Back;
        assert_eq!(pixel(&draw(&scene, 33, 33), 16, 16), [0, 0, 0, 255]);
    }
}

/// A mirrored object shows its front to back-face culling and is lit like an unmirrored one (case B5).
#[test]
fn a_mirror_keeps_front_and_light() {
    for shading in [Shading::PerVertex, Shading::PerPixel] {
        let mut scene = lit(shading);
        scene.materials[0].cull = Cull::Back;
        let expected = draw(&scene, 33, 33);
        let mesh = &mut scene.meshes[0];
        mesh.world_from_object = DMat4::from_scale(DVec3::new(-1.0, 1.0, 1.0));
        mesh.positions.iter_mut().for_each(|p| p[0] = -p[0]);
        mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        assert!(draw(&scene, 33, 33).rgba == expected.rgba, "{shading:?}");
    }
}

/// Given and computed normals agree where the mesh is flat.
#[test]
fn missing_normals_are_computed() {
    let computed = lit(Shading::PerPixel);
    let mut given = lit(Shading::PerPixel);
    given.meshes[0].normals = vec![[0.0, 0.0, 7.0]; 4];
    assert_eq!(draw(&given, 33, 33).rgba, draw(&computed, 33, 33).rgba);
    // Negative twin: other normals are used.
    given.meshes[0].normals = vec![[1.0, 0.0, 0.1]; 4];
    assert_ne!(draw(&given, 33, 33).rgba, draw(&computed, 33, 33).rgba);
}

#[test]
fn a_vertex_without_triangles_needs_no_normal() {
    let mut scene = lit(Shading::PerPixel);
    let expected = draw(&scene, 9, 9);
    let mesh: &mut Mesh = &mut scene.meshes[0];
    mesh.positions.push([5.0, 5.0, 5.0]);
    mesh.uvs.push([0.0; 2]);
    assert!(draw(&scene, 9, 9).rgba == expected.rgba);
}

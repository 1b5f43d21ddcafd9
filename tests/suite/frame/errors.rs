//! Faults are found before the first pixel and named by mesh, material, vertex, triangle and face.

use texmap_light::Light;
use texmap_math::glam::{DMat4, DVec3};
use texmap_raster::Interp;
use texmap_render::{RenderError, RenderSettings, render};
use texmap_sample::Filter;
use texmap_scene::{Mesh, Scene};
use texmap_uv::Projection;

use crate::scenes::{draw, of, slot, texture, unlit, wall};

fn good() -> Scene {
    let mut scene = of(
        unlit([1.0; 3]),
        Mesh {
            name: "wall".into(),
            faces: vec![5, 6],
            ..wall(1.0, 2.0)
        },
    );
    scene.materials[0].name = "paint".into();
    scene
}

/// The code and message that a change of the good scene brings.
fn fault(change: impl FnOnce(&mut Scene)) -> (&'static str, String) {
    let mut scene = good();
    change(&mut scene);
    let progress = |_, _| panic!("a pixel was drawn");
    let error: RenderError = render(&scene, &RenderSettings::new(8, 8), &progress).unwrap_err();
    (error.code(), error.to_string())
}

fn assert_fault(change: impl FnOnce(&mut Scene), code: &str, words: &[&str]) {
    let (got, message) = fault(change);
    assert_eq!(got, code, "{message}");
    assert!(words.iter().all(|word| message.contains(word)), "{message}");
}

#[test]
fn the_good_scene_is_good() {
    assert!(draw(&good(), 8, 8).warnings.is_empty());
}

#[test]
fn numbers_that_are_not_finite_are_named() {
    let value = "render-value";
    assert_fault(
        |s| s.meshes[0].positions[2][1] = f32::NAN,
        value,
        &["wall", "vertex 2", "position", "NaN"],
    );
    assert_fault(
        |s| s.meshes[0].uvs[3][0] = f32::INFINITY,
        value,
        &["wall", "vertex 3", "uv", "inf"],
    );
    assert_fault(
        |s| s.meshes[0].normals = vec![[f32::NAN; 3]; 4],
        value,
        &["vertex 0", "normal"],
    );
    assert_fault(
        |s| s.meshes[0].colors = vec![[f32::NAN; 3]; 4],
        value,
        &["vertex 0", "colour"],
    );
    assert_fault(
        |s| s.meshes[0].world_from_object.w_axis.x = f64::NAN,
        value,
        &["wall", "transform"],
    );
    assert_fault(
        |s| s.materials[0].phong.ns = f32::NAN,
        value,
        &["paint", "surface"],
    );
    assert_fault(
        |s| s.materials[0].opacity = 1.5,
        value,
        &["paint", "opacity", "1.5"],
    );
    assert_fault(|s| s.background[1] = -0.1, value, &["background", "-0.1"]);
    assert_fault(
        |s| {
            s.lights = vec![Light::Ambient {
                color: [f32::NAN; 3],
            }];
        },
        value,
        &["light 0"],
    );
    let still = Light::Directional {
        color: [1.0; 3],
        direction: [0.0; 3],
    };
    assert_fault(
        |s| s.lights = vec![still],
        value,
        &["light 0", "directions"],
    );
}

#[test]
fn a_flat_transform_is_refused() {
    let flat = DMat4::from_scale(DVec3::new(1.0, 0.0, 1.0));
    assert_fault(
        |s| s.meshes[0].world_from_object = flat,
        "render-value",
        &["wall", "determinant", "0"],
    );
}

#[test]
fn indices_without_a_target_are_named() {
    let index = "render-index";
    assert_fault(
        |s| s.meshes[0].triangles[1][2] = 9,
        index,
        &["wall", "triangle 1", "face 6", "vertex 9", "4"],
    );
    assert_fault(
        |s| s.meshes[0].triangles[0][0] = u32::MAX,
        index,
        &["4294967295"],
    );
    assert_fault(
        |s| s.meshes[0].material = 3,
        index,
        &["wall", "material 3", "1"],
    );
    assert_fault(
        |s| s.materials[0].base_color = slot(2, Filter::Nearest),
        index,
        &["paint", "texture 2", "0"],
    );
}

#[test]
fn counts_that_do_not_match_are_named() {
    let count = "render-count";
    assert_fault(
        |s| s.meshes[0].uvs.truncate(3),
        count,
        &["wall", "3 uvs", "4 vertices"],
    );
    assert_fault(
        |s| s.meshes[0].normals = vec![[0.0; 3]],
        count,
        &["1 normals"],
    );
    assert_fault(
        |s| s.meshes[0].colors = vec![[0.0; 3]; 5],
        count,
        &["5 colours"],
    );
    assert_fault(
        |s| s.meshes[0].faces.push(1),
        count,
        &["3 face numbers", "2 triangles"],
    );
}

#[test]
fn a_texture_needs_coordinates_and_a_projection_gives_them() {
    let strip = |s: &mut Scene| {
        s.textures = vec![texture(2, 2, |_, _| [255; 4])];
        s.materials[0].base_color = slot(0, Filter::Nearest);
        s.meshes[0].uvs.clear();
    };
    assert_fault(strip, "render-missing-uv", &["wall", "paint", "project"]);
    let mut scene = good();
    strip(&mut scene);
    scene.meshes[0].project_uvs(Projection::Plane);
    assert_eq!(scene.meshes[0].uvs, wall(1.0, 2.0).uvs);
    draw(&scene, 8, 8);
}

#[test]
fn cameras_without_a_view_are_refused() {
    assert_fault(
        |s| s.camera.up = DVec3::Z,
        "render-camera",
        &["up", "parallel"],
    );
    assert_fault(
        |s| s.camera.look = s.camera.eye,
        "render-camera",
        &["eye", "look"],
    );
    assert_fault(
        |s| s.camera.fov_x = 4.0,
        "render-camera",
        &["field of view"],
    );
    assert_fault(|s| s.camera.near = 0.0, "render-camera", &["near"]);
    assert_fault(
        |s| s.camera.eye.x = f64::NAN,
        "render-value",
        &["camera", "eye"],
    );
}

#[test]
fn modes_of_the_rasterizer_name_their_mesh() {
    assert_fault(
        |s| s.materials[0].interp = Interp::Span(0),
        "render-raster",
        &["wall", "span"],
    );
    assert_fault(
        |s| s.materials[0].interp = Interp::WithinError(0.0),
        "render-raster",
        &["wall", "tolerance"],
    );
}

#[test]
fn sizes_out_of_range_are_refused() {
    for (width, height, supersample) in [
        (0, 8, 1),
        (8, 0, 1),
        (8, 8, 0),
        (16385, 8, 1),
        (8, 8193, 2),
        (u32::MAX, 1, u32::MAX),
    ] {
        let settings = RenderSettings {
            supersample,
            ..RenderSettings::new(width, height)
        };
        let error = render(&good(), &settings, &texmap_render::no_progress).unwrap_err();
        assert_eq!(error.code(), "render-size", "{error}");
    }
}

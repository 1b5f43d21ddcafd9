//! Texture coordinates from O, U and V per pixel (Brackeen 2003, chapter 8).

use texmap_math::TextureFrame;
use texmap_math::glam::{DMat4, DVec2, DVec3};
use texmap_render::{Aov, Frame};
use texmap_sample::Filter;
use texmap_scene::{Mesh, Scene};

use crate::scenes::{draw, draw_aovs, of, quad, slot, texture, unlit, values};

const SIZE: u32 = 160;

/// A pentagon in a tilted plane under a turned, scaled and moved object, with a skewed frame for its texture.
fn pentagon() -> Scene {
    let frame = TextureFrame::new(
        DVec3::new(-0.5, -0.25, 0.0),
        DVec3::new(0.8, 0.1, 0.0),
        DVec3::new(0.3, -0.5, 0.0),
    )
    .unwrap();
    let corners = [
        [-1.0, -0.8],
        [0.9, -0.9],
        [1.2, 0.3],
        [0.1, 1.1],
        [-1.1, 0.4],
    ];
    let mut material = unlit([1.0; 3]);
    material.base_color = slot(0, Filter::Trilinear);
    let mesh = Mesh {
        positions: corners.map(|[x, y]| [x, y, 0.0]).to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3], [0, 3, 4]],
        world_from_object: DMat4::from_translation(DVec3::new(0.2, 0.1, -2.0))
            * DMat4::from_rotation_x(-1.0)
            * DMat4::from_rotation_z(0.4)
            * DMat4::from_scale(DVec3::new(1.2, 0.9, 1.0)),
        texture_frame: Some(frame),
        ..Mesh::default()
    };
    let checker = texture(32, 32, |x, y| {
        if (x / 4 + y / 4) % 2 == 0 {
            [255; 4]
        } else {
            [0, 40, 90, 255]
        }
    });
    Scene {
        textures: vec![checker],
        ..of(material, mesh)
    }
}

/// The same pentagon with the frame's uv at its vertices.
fn by_vertices(mut scene: Scene) -> Scene {
    let mesh = &mut scene.meshes[0];
    let frame = mesh.texture_frame.take().unwrap();
    let uv = |p: &[f32; 3]| {
        frame
            .uv(DVec3::from(p.map(f64::from)))
            .to_array()
            .map(|c| c as f32)
    };
    mesh.uvs = mesh.positions.iter().map(uv).collect();
    scene
}

/// Largest difference of two AOVs over the pixels that have them, relative to the range 1, and how many those are.
fn difference(a: &Frame, b: &Frame, aov: Aov) -> (f32, u32) {
    let (mut worst, mut count) = (0.0f32, 0);
    for (x, y) in (0..SIZE).flat_map(|x| (0..SIZE).map(move |y| (x, y))) {
        let (a, b) = (values(a, aov, x, y), values(b, aov, x, y));
        assert_eq!(a[0].is_nan(), b[0].is_nan());
        if !a[0].is_nan() {
            count += 1;
            worst = a
                .iter()
                .zip(&b)
                .fold(worst, |worst, (a, b)| worst.max((a - b).abs()));
        }
    }
    (worst, count)
}

#[test]
fn per_pixel_uv_equals_the_vertex_path() {
    let aovs = [Aov::Uv, Aov::Lod];
    let (frame, vertices) = (
        draw_aovs(&pentagon(), SIZE, SIZE, &aovs),
        draw_aovs(&by_vertices(pentagon()), SIZE, SIZE, &aovs),
    );
    let (worst, count) = difference(&frame, &vertices, Aov::Uv);
    assert!(worst <= 1e-6 && count > 3_000, "{worst:e} over {count}");
    let (worst, _) = difference(&frame, &vertices, Aov::Lod);
    assert!(worst <= 1e-4, "derivatives: {worst:e} levels");
    let changed = frame
        .rgba
        .iter()
        .zip(&vertices.rgba)
        .filter(|(a, b)| a.abs_diff(**b) > 1)
        .count();
    assert_eq!(changed, 0, "bytes");
}

/// Moving O by U moves every u by -1, and turning the texture in its plane is seen.
#[test]
fn moving_the_origin_moves_the_coordinates() {
    let still = draw_aovs(&pentagon(), SIZE, SIZE, &[Aov::Uv]);
    let mut scene = pentagon();
    let frame = scene.meshes[0].texture_frame.as_mut().unwrap();
    frame.o += frame.u;
    let moved = draw_aovs(&scene, SIZE, SIZE, &[Aov::Uv]);
    let (a, b) = (
        values(&still, Aov::Uv, 85, 80),
        values(&moved, Aov::Uv, 85, 80),
    );
    let step = DVec2::new(f64::from(b[0] - a[0]), f64::from(b[1] - a[1]));
    assert!((step - DVec2::NEG_X).length() < 1e-5, "{step}");
}

#[test]
fn a_tilted_frame_is_drawn_and_warned_of() {
    assert_eq!(draw(&pentagon(), 8, 8).warnings, Vec::<String>::new());
    for degrees in [0.5f64, 20.0] {
        let mut scene = pentagon();
        let turn = DMat4::from_rotation_x(degrees.to_radians());
        scene.meshes[0].texture_frame = scene.meshes[0]
            .texture_frame
            .map(|frame| frame.transform(turn));
        let tilt = scene.meshes[0].frame_tilt().unwrap();
        assert!((tilt.to_degrees() - degrees).abs() < 1e-5, "{tilt}");
        let frame = draw(&scene, SIZE, SIZE);
        assert!(frame.stats.pixels_covered > 3_000);
        let warning = &frame.warnings[0];
        assert!(
            warning.contains("degrees") && warning.contains(&format!("{degrees:.3}")),
            "{warning}"
        );
    }
}

/// A frame whose plane passes through the eye has no uv: a hole, and a finite colour.
#[test]
fn a_frame_edge_on_to_the_eye_is_a_hole_in_uv() {
    let mut scene = of(
        unlit([1.0; 3]),
        quad([
            [-1.0, -1.0, -1.0],
            [1.0, -1.0, -1.0],
            [1.0, 1.0, -1.0],
            [-1.0, 1.0, -1.0],
        ]),
    );
    scene.textures = vec![texture(2, 2, |_, _| [9, 9, 9, 255])];
    scene.materials[0].base_color = slot(0, Filter::Trilinear);
    scene.meshes[0].texture_frame =
        Some(TextureFrame::new(DVec3::ZERO, DVec3::X, DVec3::Z).unwrap());
    // Odd height: the middle row looks along the plane.
    let frame = draw_aovs(&scene, 31, 31, &[Aov::Uv, Aov::Lod]);
    assert!(values(&frame, Aov::Uv, 3, 15).iter().all(|v| v.is_nan()));
    assert!(frame.rgba.chunks_exact(4).all(|p| p == [9, 9, 9, 255]));
}

//! Colours interpolated on the screen tear at T-junctions by a known amount (MIT 6.837, lecture 18, slides 14-15).

use texmap_scene::{Material, Mesh, Scene, VertexColorInterp};

use crate::scenes::{draw, of, pixel, unlit};

const SIZE: u32 = 512;

/// An upright edge in the middle of the picture from grey 0 at distance 2 to grey 1 at distance 2r: one triangle on its
/// left, two on its right that meet in its midpoint in space.
fn t_joint(ratio: f32, gouraud: VertexColorInterp) -> Scene {
    let (near, far) = (2.0, 2.0 * ratio);
    let (a, b) = ([0.0, -0.8 * near, -near], [0.0, 0.8 * far, -far]);
    let middle = [0.0, (a[1] + b[1]) / 2.0, (a[2] + b[2]) / 2.0];
    let mesh = Mesh {
        positions: vec![a, b, [-1.9, 0.0, -2.0], middle, [1.9, 0.0, -2.0]],
        colors: vec![[0.0; 3], [1.0; 3], [0.5; 3], [0.5; 3], [0.5; 3]],
        triangles: vec![[0, 1, 2], [0, 4, 3], [3, 4, 1]],
        ..Mesh::default()
    };
    of(
        Material {
            vertex_color_interp: gouraud,
            ..unlit([1.0; 3])
        },
        mesh,
    )
}

/// Step of grey across the edge at the joint.
fn mismatch(ratio: f32, gouraud: VertexColorInterp) -> f32 {
    let frame = draw(&t_joint(ratio, gouraud), SIZE, SIZE);
    // y / z of the midpoint, from -1 to 1 over the picture.
    let height = 0.8 * (ratio - 1.0) / (ratio + 1.0);
    let row = ((1.0 - height) * 0.5 * SIZE as f32) as u32;
    let grey = |x: u32| f32::from(pixel(&frame, x, row)[0]) / 255.0;
    assert_ne!(grey(SIZE / 2 - 1), 0.0);
    grey(SIZE / 2 - 1) - grey(SIZE / 2)
}

#[test]
fn screen_linear_colours_tear_by_the_closed_form() {
    for ratio in [1.5f32, 2.0, 4.0, 8.0] {
        let expected = ((1.0 - ratio) / (2.0 * (1.0 + ratio))).abs();
        let got = mismatch(ratio, VertexColorInterp::ScreenLinear);
        assert!(
            (got - expected).abs() < 0.012,
            "ratio {ratio}: {got}, closed form {expected}"
        );
    }
}

#[test]
fn perspective_colours_do_not_tear() {
    for ratio in [1.5, 2.0, 4.0, 8.0] {
        let got = mismatch(ratio, VertexColorInterp::Perspective);
        assert!(got.abs() < 0.012, "ratio {ratio}: {got}");
    }
}

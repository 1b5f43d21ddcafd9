//! The six views from within a mesh.

use texmap_bake::capture_environment;
use texmap_light::EnvironmentLayout;
use texmap_math::glam::{DVec2, DVec3};
use texmap_scene::{ColorMode, Mesh, Scene};

use crate::scenes::{empty, unlit};

/// A box of six colours around a small triangle: each direction sees the colour of its wall.
#[test]
fn six_views_are_a_cube_map() {
    let colors = [
        [1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, 0.0, 1.0],
        [1.0, 1.0, 0.0],
        [0.0, 1.0, 1.0],
        [1.0, 0.0, 1.0],
    ];
    let wall = |face: usize| {
        let at = |u: f64, v: f64| {
            let d = EnvironmentLayout::Cube.direction(face, DVec2::new(u, v));
            (d / d.abs().max_element() * 5.0 + DVec3::new(1.0, 2.0, 3.0))
                .as_vec3()
                .to_array()
        };
        Mesh {
            positions: vec![at(0.0, 0.0), at(1.0, 0.0), at(1.0, 1.0), at(0.0, 1.0)],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            material: face,
            ..Mesh::default()
        }
    };
    let own = Mesh {
        positions: vec![[0.5, 1.5, 2.5], [1.5, 2.5, 3.5], [0.5, 2.5, 3.0]],
        triangles: vec![[0, 1, 2]],
        ..Mesh::default()
    };
    let scene = Scene {
        background: [0.0; 4],
        color: ColorMode::Srgb,
        materials: colors.map(unlit).to_vec(),
        meshes: (0..6).map(wall).chain([own]).collect(),
        ..empty()
    };
    let found = capture_environment(&scene, 6, 16).unwrap();
    // A quarter of a wall has another colour: which way up and round each face is.
    let mut marked = scene.clone();
    marked.meshes.push(Mesh {
        positions: [[0.0, 0.0], [0.5, 0.0], [0.5, 0.5], [0.0, 0.5]]
            .map(|[u, v]| {
                let d = EnvironmentLayout::Cube.direction(4, DVec2::new(u, v));
                (d / d.abs().max_element() * 4.0 + DVec3::new(1.0, 2.0, 3.0))
                    .as_vec3()
                    .to_array()
            })
            .to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        material: 0,
        ..Mesh::default()
    });
    let quarter = capture_environment(&marked, 6, 16).unwrap();
    for (face, color) in colors.into_iter().enumerate() {
        for (u, v) in [(0.2, 0.3), (0.8, 0.3), (0.2, 0.8), (0.8, 0.8)] {
            let d = EnvironmentLayout::Cube.direction(face, DVec2::new(u, v));
            let d = d.as_vec3().to_array();
            assert_eq!(found.radiance(d), color, "{face} {u} {v}");
            let expected = if face == 4 && u < 0.5 && v < 0.5 {
                colors[0]
            } else {
                color
            };
            assert_eq!(quarter.radiance(d), expected, "{face} {u} {v}");
        }
    }
    assert!(capture_environment(&scene, 9, 16).is_err());
    assert!(
        capture_environment(&scene, 6, 0).is_err()
            && capture_environment(&scene, 6, u32::MAX).is_err()
    );
}

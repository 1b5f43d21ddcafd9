//! Blended surfaces: composed in submission order, tested against depth, leaving none.

use texmap_render::Aov;
use texmap_scene::{AlphaMode, Material, Mesh, Scene};

use crate::scenes::{draw, draw_aovs, empty, pixel, unlit, values, wall};

fn pane(color: [f32; 3]) -> Material {
    Material {
        alpha: AlphaMode::Blend,
        opacity: 0.5,
        ..unlit(color)
    }
}

/// Panes of material 0 and 1 at the given distances, submitted in that order, before a white wall at distance 4.
fn panes(first: f32, second: f32) -> Scene {
    Scene {
        materials: vec![
            pane([1.0, 0.0, 0.0]),
            pane([0.0, 1.0, 0.0]),
            unlit([1.0; 3]),
        ],
        meshes: vec![
            wall(5.0, first),
            Mesh {
                material: 1,
                ..wall(5.0, second)
            },
            Mesh {
                material: 2,
                ..wall(5.0, 4.0)
            },
        ],
        ..empty()
    }
}

#[test]
fn later_covers_earlier_whatever_the_depth() {
    // White halved to (1, .5, .5) by red, then to (.5, .75, .25) by green; values round half up.
    for (first, second) in [(3.0, 2.0), (2.0, 3.0)] {
        assert_eq!(
            pixel(&draw(&panes(first, second), 8, 8), 4, 4),
            [128, 191, 64, 255]
        );
    }
    let mut swapped = panes(3.0, 2.0);
    swapped.meshes.swap(0, 1);
    assert_eq!(pixel(&draw(&swapped, 8, 8), 4, 4), [191, 128, 64, 255]);
}

#[test]
fn panes_behind_the_wall_are_hidden_and_leave_no_depth() {
    let scene = panes(2.0, 5.0);
    let frame = draw_aovs(&scene, 8, 8, &[Aov::Depth]);
    assert_eq!(pixel(&frame, 4, 4), [255, 128, 128, 255]);
    assert_eq!(values(&frame, Aov::Depth, 4, 4), [1e-4 / 4.0]);
}

#[test]
fn panes_over_a_clear_background_stay_transparent() {
    let mut scene = panes(2.0, 3.0);
    scene.background = [1.0, 1.0, 1.0, 0.0];
    scene.meshes.truncate(1);
    let frame = draw(&scene, 8, 8);
    assert_eq!(pixel(&frame, 4, 4), [255, 0, 0, 128]);
    scene.meshes.clear();
    assert_eq!(pixel(&draw(&scene, 8, 8), 4, 4), [0; 4]);
}

#[test]
fn a_run_longer_than_the_stages_take_is_composed_whole() {
    let frame = draw(&panes(3.0, 2.0), 150, 130);
    assert!(frame.rgba.chunks_exact(4).all(|p| p == [128, 191, 64, 255]));
}

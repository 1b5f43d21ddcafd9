//! Grazing facets in shadow maps: walls that are thinner than a texel hide nothing of the floor behind them, and let no light through.

use texmap_light::{Light, ShadowBias, ShadowKind};
use texmap_math::camera::Camera;
use texmap_math::glam::DVec3;
use texmap_render::{shadow_map, shadow_map_for};
use texmap_scene::shadow_fit::shadow_kind;
use texmap_scene::{Material, Mesh, Scene};

/// Two floors, the second `drop` lower, joined by a wall of two halves that is `width` wide as a light from above
/// sees it.
fn step(width: f32, drop: f32) -> Scene {
    let (top, foot) = (0.013, 0.013 + width);
    let middle = 0.5 * (top + foot);
    let row = |x: f32, y: f32| [[x, y, -1.0], [x, y, 1.0]];
    let rows = [
        row(-1.0, 0.0),
        row(top, 0.0),
        row(middle, -0.5 * drop),
        row(foot, -drop),
        row(1.0, -drop),
    ];
    // The lower half of the wall first.
    let triangles = [4, 2, 0, 6u32].map(|k| [[k, k + 1, k + 2], [k + 1, k + 3, k + 2]]);
    let mesh = Mesh {
        positions: rows.concat(),
        triangles: triangles.concat(),
        ..Mesh::default()
    };
    Scene {
        lights: vec![Light::Directional {
            color: [1.0; 3],
            direction: [0.0, -1.0, 0.0],
        }],
        materials: vec![Material::default()],
        meshes: vec![mesh],
        ..Scene::new(Camera::look_at(DVec3::new(0.0, 2.0, 5.0), DVec3::ZERO))
    }
}

const BIAS: ShadowBias = ShadowBias::Planes(1e-4);

fn kind_of(scene: &Scene) -> ShadowKind {
    shadow_kind(scene, 0, Some((DVec3::ZERO, 1.0))).unwrap()
}

/// Every filter sees as much of the light at all of the points, which lie on level floors.
#[track_caller]
fn assert_visibility(scene: &Scene, expected: f32, points: impl Iterator<Item = DVec3> + Clone) {
    let kind = kind_of(scene);
    for taps in [1, 3, 5] {
        let map = shadow_map_for(scene, &kind, 64, BIAS, taps, 1).unwrap();
        for at in points.clone() {
            assert_eq!(
                map.visibility(at, DVec3::Y, BIAS, taps),
                expected,
                "{taps} {at}"
            );
        }
    }
}

/// A wall thinner than a texel hides none of the floor behind it, which a light from above reaches. The depths without this pass, that
/// move each caster by its own slope alone, put it in the shadow of the upper floor.
#[test]
fn thin_walls_hide_no_floor() {
    let scene = step(1e-3, 0.02);
    let kind = kind_of(&scene);
    let size = 64;
    for (taps, by_hand) in [(1, false), (3, false), (5, false), (3, true)] {
        let map = if by_hand {
            shadow_map(&scene, &kind, size, 1).unwrap()
        } else {
            shadow_map_for(&scene, &kind, size, BIAS, taps, 1).unwrap()
        };
        let dark = (0..500).filter(|i| {
            let x = 0.0141 + f64::from(*i) * 4e-4;
            let at = DVec3::new(x, -0.02, 0.1 + f64::from(i % 7) * 0.01);
            map.visibility(at, DVec3::Y, BIAS, taps) < 1.0
        });
        let dark = dark.count();
        assert!(
            if by_hand { dark > 20 } else { dark == 0 },
            "{taps}: {dark}"
        );
    }
}

/// A wall that hangs above the floor casts no shadow that its few texels would not: its foot is not moved up into a texel of the floor.
#[test]
fn thin_walls_in_the_air_darken_no_floor() {
    let mut scene = step(1e-3, 0.2);
    let mesh = &mut scene.meshes[0];
    mesh.triangles.truncate(4);
    for y in mesh.positions.iter_mut().map(|p| &mut p[1]) {
        *y += 0.5;
    }
    let mut floor = step(0.0, 0.0).meshes.remove(0);
    floor.triangles = vec![[0, 1, 8], [1, 9, 8]];
    scene.meshes.push(floor);
    let points = (-200..200).map(|x| DVec3::new(f64::from(x) * 1e-3, 0.0, 0.1));
    assert_visibility(&scene, 1.0, points);
}

/// A roof over the wall keeps its shadow on the floor at the foot of the wall.
#[test]
fn thin_walls_under_a_roof_are_dark() {
    let mut scene = step(1e-3, 0.02);
    let mut roof = step(0.0, 0.0).meshes.remove(0);
    roof.positions.iter_mut().for_each(|p| p[1] = 0.5);
    scene.meshes.push(roof);
    let points = (0..200).map(|x| DVec3::new(0.0141 + f64::from(x) * 1e-3, -0.02, 0.1));
    assert_visibility(&scene, 0.0, points);
}

/// A roof that starts at half the height of a wall keeps its shadow on the wall under it.
#[test]
fn walls_under_a_roof_between_their_ends_are_dark() {
    // In the texel whose centre is at 3/64: from 0.034 to 0.059, with the halves meeting before the centre.
    let (width, drop, moved) = (0.025, 0.2, 0.021);
    let mut scene = step(width, drop);
    scene.meshes[0]
        .positions
        .iter_mut()
        .for_each(|p| p[0] += moved);
    let slope = f64::from(drop / width);
    let mut roof = step(0.0, 0.0).meshes.remove(0);
    for p in &mut roof.positions {
        *p = [0.043 + 0.5 * p[0].max(0.0), -0.07, p[2]];
    }
    let kind = kind_of(&scene);
    let lit = |scene: &Scene| {
        let map = shadow_map_for(scene, &kind, 64, BIAS, 1, 1).unwrap();
        let of_wall = (0..25).map(|x| {
            let x = 0.0475 + f64::from(x) * 4e-4;
            let at = DVec3::new(x, -slope * (x - 0.034), 0.1);
            map.visibility(at, DVec3::new(slope, 1.0, 0.0).normalize(), BIAS, 1)
        });
        of_wall.sum::<f32>()
    };
    assert_eq!(lit(&scene), 25.0);
    scene.meshes.push(roof);
    assert_eq!(lit(&scene), 0.0);
}

/// What lies deeper than the foot of the wall keeps its shadow: the upper floor hides a floor under it up to its edge.
#[test]
fn thin_walls_let_no_light_through() {
    let scene = step(1e-3, 0.02);
    let points = (-20..20).map(|x| DVec3::new(f64::from(x) * 0.01, -0.2, 0.1));
    assert_visibility(&scene, 0.0, points);
}

#[test]
fn threads_agree() {
    let scene = step(1e-3, 0.02);
    let kind = kind_of(&scene);
    let map = |threads| shadow_map_for(&scene, &kind, 300, BIAS, 5, threads).unwrap();
    assert_eq!(map(1), map(2));
}

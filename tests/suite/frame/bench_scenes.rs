//! The scenes of the race with other renderers are what their table says.

use texmap_benches::bench_scenes::{
    GlMatrix, LIGHT, LIGHT_AREA, MIDDLE, mip_chain, normal, slide, sphere,
};
use texmap_math::glam::{DVec3, DVec4};

#[test]
fn triangle_counts_are_those_of_the_scene_table() {
    assert_eq!(sphere(142, 71).triangles.len(), 19_880);
    assert_eq!(sphere(448, 224).triangles.len(), 199_808);
    assert_eq!(sphere(1416, 708).triangles.len(), 2_002_224);
}

#[test]
fn spheres_face_outwards() {
    let sphere = sphere(16, 8);
    for triangle in &sphere.triangles {
        let [a, b, c] = triangle.map(|i| DVec3::from(sphere.positions[i as usize].map(f64::from)));
        let normal = (b - a).cross(c - a);
        assert!(normal.dot(a) > 0.0, "{triangle:?} faces inwards");
    }
}

#[test]
fn the_light_sees_fifteen_degrees_to_each_side() {
    let distance = (DVec3::from(LIGHT) - DVec3::from(MIDDLE)).length();
    let half = distance * texmap_math::deterministic_f64::tan(15f64.to_radians());
    assert!((half - LIGHT_AREA).abs() < 1e-6, "{half}");
}

#[test]
fn reversed_depth_is_one_at_near_and_zero_at_far() {
    let m = GlMatrix::perspective(60.0, 1.0, 0.5, 8.0).reversed_depth();
    for (z, depth) in [(-0.5, 1.0), (-8.0, 0.0)] {
        let p = m * DVec4::new(0.0, 0.0, z, 1.0);
        assert!((p.z / p.w - depth).abs() < 1e-6, "{p:?}");
    }
}

#[test]
fn the_eye_looks_along_minus_z() {
    let m = GlMatrix::look_at([0.0, 2.0, 8.0], [0.0, 0.0, 2.0]).reversed_depth();
    let p = m * DVec4::new(0.0, 2.0, 8.0, 1.0);
    assert!(p.x.abs() < 1e-6 && p.y.abs() < 1e-6, "{p:?}");
}

#[test]
fn mips_keep_a_constant_and_end_at_one_texel() {
    let levels = mip_chain(vec![77; 8 * 8 * 4], 8);
    assert_eq!(levels.len(), 4);
    assert_eq!(levels[3], vec![77; 4]);
}

#[test]
fn projector_border_is_black_and_rings_are_not() {
    let picture = slide();
    assert_eq!(&picture[..3], &[0, 0, 0]);
    let centre = (256 * 512 + 256) * 4;
    assert_eq!(&picture[centre..centre + 3], &[255, 40, 40]);
}

#[test]
fn flat_parts_of_the_normal_map_point_up() {
    let blue: Vec<f64> = normal().chunks_exact(4).map(|t| f64::from(t[2])).collect();
    let mean = blue.iter().sum::<f64>() / blue.len() as f64;
    assert!(mean > 180.0, "mean of blue is {mean}");
}

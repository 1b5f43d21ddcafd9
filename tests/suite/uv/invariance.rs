//! The same bytes on every SIMD level and thread count: mapping, seam repair, automatic planes, packing, report.

use texmap_math::glam::DVec3;
use texmap_tests::levels::levels;
use texmap_uv::{
    AtlasSize, Mapping, Mesh, Origin, Placement, ProjectionSource, ReportOptions, Shape,
    auto_planes, report, t_junctions,
};

use crate::meshes::ball;

/// Everything about a mesh as text, so that a NaN equals itself.
fn all(level: texmap_math::Level, mesh: &Mesh<'_>) -> Vec<String> {
    let mut out = Vec::new();
    let frame = Placement::upright(DVec3::new(0.1, 0.0, -0.2), DVec3::new(3.0, 2.5, 3.5));
    for (shape, by) in [
        (Shape::Sphere, ProjectionSource::Position),
        (Shape::Cylinder, ProjectionSource::Position),
        (Shape::Cone, ProjectionSource::Centroid),
        (Shape::Plane, ProjectionSource::Position),
        (Shape::Box, ProjectionSource::Normal),
    ] {
        let mapping = Mapping {
            by,
            frame: Some(frame),
            repeat: [3.0, 1.5],
            ..Mapping::new(shape)
        };
        let mapped = mapping.map(level, mesh, &[]).expect("a mapping");
        let found = report(mesh, &mapped.set, &ReportOptions::default()).expect("a report");
        out.push(format!("{mapped:?}"));
        out.push(format!("{found:?}"));
    }
    let packed = auto_planes(mesh, AtlasSize::default(), Origin::TopLeft).expect("an atlas");
    out.push(format!("{packed:?}"));
    out.push(format!("{:?}", t_junctions(mesh)));
    out
}

#[test]
fn no_byte_depends_on_level_or_threads() {
    // Several chunks of work, with poles, a seam through faces and, by plane, two layers.
    let (positions, faces) = ball(131, 67, 1.7);
    let mesh = Mesh::new(&positions, &faces).expect("a sound mesh");
    let pool = |threads| {
        rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .expect("a pool")
    };
    let best = texmap_math::Level::new();
    let one = pool(1).install(|| all(best, &mesh));
    assert!(faces.len() > 4 * 4096, "fewer faces than chunks of work");
    assert!(
        one[7].contains("overlapping: true"),
        "the plane folds the ball"
    );
    for threads in [2, 3, 8] {
        let many = pool(threads).install(|| all(best, &mesh));
        assert!(many == one, "{threads} threads");
    }
    for (name, level) in levels() {
        assert!(pool(2).install(|| all(level, &mesh)) == one, "{name}");
    }
    // Negative twin: another frame is another text.
    let moved: Vec<[f32; 3]> = positions
        .iter()
        .map(|p| [p[0] + 1e-6, p[1], p[2]])
        .collect();
    let other = Mesh::new(&moved, &faces).expect("a sound mesh");
    assert!(pool(1).install(|| all(best, &other)) != one);
}

//! Property 26 (solids), lanes, frames, entities.

use proptest::prelude::*;
use texmap_math::glam::DVec3;
use texmap_math::{Level, deterministic_f64};
use texmap_tests::levels::levels;
use texmap_uv::{
    Faces, Mapping, Mesh, Origin, Placement, ProjectionSource, Shape, ShapeFace, cylinder_uv_at,
    cylinder_uv_batch, sphere_uv_at, sphere_uv_batch,
};

use crate::meshes::{ball, tube};

const ORIGINS: [Origin; 2] = [Origin::TopLeft, Origin::BottomLeft];

fn direction() -> impl Strategy<Value = DVec3> {
    (-1.0..1.0f64, -1.0..1.0f64, -1.0..1.0f64)
        .prop_map(DVec3::from)
        .prop_filter("not too short", |d| d.length_squared() > 1e-2)
}

proptest! {
    #[test]
    fn uv_is_in_the_unit_square_and_the_inverse_returns_the_point(d in direction(), shape in 0..5usize) {
        let shape = [Shape::Plane, Shape::Cylinder, Shape::Cone, Shape::Sphere, Shape::Box][shape];
        // A point on the solid: scale the direction until it meets the surface.
        let p = match shape {
            Shape::Plane => DVec3::new(d.x * 0.5, d.y * 0.5, 0.0),
            Shape::Sphere => d * (0.5 / d.length()),
            Shape::Box => d * (0.5 / d.abs().max_element()),
            Shape::Cylinder => {
                let out = (d.x * d.x + d.z * d.z).sqrt();
                d * (0.5 / out.max(d.y.abs()))
            }
            Shape::Cone => {
                let out = (d.x * d.x + d.z * d.z).sqrt();
                if -d.y >= out { d * (0.5 / -d.y) } else { d * (0.5 / (2.0 * out + d.y)) }
            }
        };
        prop_assume!(shape == Shape::Plane || shape == Shape::Box || p.x * p.x + p.z * p.z > 1e-4);
        for origin in ORIGINS {
            let (part, uv) = shape.uv(p, origin);
            prop_assert!(uv.iter().all(|c| (-1e-12..=1.0 + 1e-12).contains(c)), "{shape:?} {uv:?}");
            let back = shape.point(part, uv, origin);
            prop_assert!((back - p).abs().max_element() < 1e-12, "{shape:?} {part:?} {uv:?} {p} {back}");
        }
    }

    #[test]
    fn sphere_uv_does_not_know_the_radius(d in direction(), k in -20..20i32, r in 0.01..100.0f64) {
        let (_, uv) = Shape::Sphere.uv(d, Origin::TopLeft);
        let (_, scaled) = Shape::Sphere.uv(d * r, Origin::TopLeft);
        prop_assert!((uv[0] - scaled[0]).abs() < 1e-12 && (uv[1] - scaled[1]).abs() < 1e-12);
        let (_, exact) = Shape::Sphere.uv(d * 2f64.powi(k), Origin::TopLeft);
        prop_assert_eq!(uv, exact);
        // Negative twin: a cylinder does know it, through the height.
        let low = DVec3::new(d.x, 0.2 + 0.1 * d.y, d.z);
        let [a, b] = [low, low * 0.5].map(|p| Shape::Cylinder.uv(p, Origin::TopLeft).1[1]);
        prop_assert!((a - b).abs() > 0.04);
    }

    #[test]
    fn u_is_continuous_but_for_the_seam_and_rises_to_the_right(angle in -3.1..3.1f64, y in -0.4..0.4f64) {
        let step = 1e-6;
        let at = |a: f64| {
            let (sin, cos) = deterministic_f64::sin_cos(a);
            Shape::Cylinder.uv(DVec3::new(0.5 * cos, y, 0.5 * sin), Origin::TopLeft).1[0]
        };
        prop_assume!(angle.abs() > 1e-5);
        // atan2(z, x) grows to the left of a viewer outside (right-handed, y up).
        let gain = at(angle) - at(angle + step);
        prop_assert!((gain * std::f64::consts::TAU / step - 1.0).abs() < 1e-4, "{gain}");
    }

    #[test]
    fn f32_agrees_with_the_formula_and_scalar_with_lanes(
        points in prop::collection::vec((-2.0..2.0f32, -2.0..2.0f32, -2.0..2.0f32), 1..70), scale in -30..30i32
    ) {
        let points: Vec<[f32; 3]> = points.iter().map(|p| [p.0, p.1, p.2].map(|c| c * 2f32.powi(scale))).collect();
        for origin in ORIGINS {
            let one: Vec<[f32; 2]> = points.iter().map(|p| sphere_uv_at(*p, origin)).collect();
            for (p, uv) in points.iter().zip(&one) {
                let d = DVec3::from(p.map(f64::from));
                if d.x.abs() + d.z.abs() > 1e-3 * d.y.abs() {
                    let (_, exact) = Shape::Sphere.uv(d, origin);
                    prop_assert!((f64::from(uv[0]) - exact[0]).abs() < 1e-6, "{p:?} {uv:?} {exact:?}");
                    prop_assert!((f64::from(uv[1]) - exact[1]).abs() < 1e-6, "{p:?} {uv:?} {exact:?}");
                }
            }
            for (name, level) in levels() {
                let mut out = vec![[0.0; 2]; points.len()];
                sphere_uv_batch(level, &points, origin, &mut out).unwrap();
                prop_assert_eq!(bits(&out), bits(&one), "sphere {}", name);
                cylinder_uv_batch(level, &points, origin, &mut out).unwrap();
                let side: Vec<[f32; 2]> = points.iter().map(|p| cylinder_uv_at(*p, origin)).collect();
                prop_assert_eq!(bits(&out), bits(&side), "cylinder {}", name);
            }
        }
    }
}

fn bits(uvs: &[[f32; 2]]) -> Vec<[u32; 2]> {
    uvs.iter().map(|uv| uv.map(f32::to_bits)).collect()
}

#[test]
fn senseless_vectors_have_the_same_bits_on_every_level() {
    let odd: &[f32] = &[
        0.0,
        -0.0,
        1.0,
        -1.0,
        1e30,
        -1e30,
        3e38,
        1e-40,
        f32::MIN_POSITIVE,
        f32::INFINITY,
        f32::NAN,
    ];
    let all: Vec<[f32; 3]> = odd
        .iter()
        .flat_map(move |&x| {
            odd.iter()
                .flat_map(move |&y| odd.iter().map(move |&z| [x, y, z]))
        })
        .collect();
    // NaN payloads are not part of the contract.
    let calm = |uvs: &[[f32; 2]]| -> Vec<[u32; 2]> {
        uvs.iter()
            .map(|uv| uv.map(|c| if c.is_nan() { u32::MAX } else { c.to_bits() }))
            .collect()
    };
    let one: Vec<[f32; 2]> = all
        .iter()
        .map(|p| sphere_uv_at(*p, Origin::TopLeft))
        .collect();
    for (name, level) in levels() {
        let mut out = vec![[0.0; 2]; all.len()];
        sphere_uv_batch(level, &all, Origin::TopLeft, &mut out).unwrap();
        assert_eq!(calm(&out), calm(&one), "{name}");
    }
    for (p, uv) in all
        .iter()
        .zip(&one)
        .filter(|(p, _)| p.iter().all(|c| c.is_finite()))
    {
        assert!(uv.iter().all(|c| (0.0..=1.0).contains(c)), "{p:?} {uv:?}");
    }
    assert!(sphere_uv_batch(Level::new(), &all, Origin::TopLeft, &mut []).is_err());
}

#[test]
fn every_shape_and_entity_maps_a_ball_without_a_nan() {
    let (positions, faces) = ball(24, 12, 2.0);
    let mesh = Mesh::new(&positions, &faces).unwrap();
    let eye = DVec3::new(5.0, 2.0, 3.0);
    for shape in [
        Shape::Plane,
        Shape::Cylinder,
        Shape::Cone,
        Shape::Sphere,
        Shape::Box,
    ] {
        for by in [
            ProjectionSource::Position,
            ProjectionSource::Normal,
            ProjectionSource::Centroid,
            ProjectionSource::Reflection { eye },
        ] {
            let mapping = Mapping {
                by,
                ..Mapping::new(shape)
            };
            let mapped = mapping.map(Level::new(), &mesh, &[]).unwrap();
            mapped.set.check(&mesh).unwrap();
            // The same with the lanes of every level.
            for (name, level) in levels() {
                assert_eq!(
                    mapping.map(level, &mesh, &[]).unwrap(),
                    mapped,
                    "{shape:?} {by:?} {name}"
                );
            }
        }
    }
}

#[test]
fn a_ball_is_one_ball_by_position_by_normal_and_by_centroid() {
    let (positions, faces) = ball(16, 8, 3.0);
    let mesh = Mesh::new(&positions, &faces).unwrap();
    let uv = |by: ProjectionSource| {
        Mapping {
            by,
            ..Mapping::new(Shape::Sphere)
        }
        .map(Level::new(), &mesh, &[])
        .unwrap()
        .set
        .per_corner()
    };
    let (a, b, c) = (
        uv(ProjectionSource::Position),
        uv(ProjectionSource::Normal),
        uv(ProjectionSource::Centroid),
    );
    let far = |p: &[[f32; 2]], q: &[[f32; 2]]| {
        p.iter()
            .zip(q)
            .map(|(p, q)| {
                let d = (p[0] - q[0]).rem_euclid(1.0);
                d.min(1.0 - d).max((p[1] - q[1]).abs())
            })
            .fold(0.0, f32::max)
    };
    assert!(
        far(&a, &c) < 1e-5 && far(&a, &b) < 4e-2,
        "{} {}",
        far(&a, &b),
        far(&a, &c)
    );
    // Reflection is another thing.
    assert!(
        far(
            &a,
            &uv(ProjectionSource::Reflection {
                eye: DVec3::Z * 9.0
            })
        ) > 0.1
    );
}

#[test]
fn a_frame_moves_turns_and_scales_the_shape() {
    let (positions, faces) = tube(24, 4, 1.0, 2.0);
    let mesh = Mesh::new(&positions, &faces).unwrap();
    let plain = Mapping::new(Shape::Cylinder)
        .map(Level::new(), &mesh, &[])
        .unwrap()
        .set
        .per_corner();
    // A quarter turn of the shape about y moves u by a quarter.
    let frame = Placement {
        yaw: std::f64::consts::FRAC_PI_2,
        ..Placement::upright(DVec3::ZERO, DVec3::splat(2.0))
    };
    let turned = Mapping {
        frame: Some(frame),
        ..Mapping::new(Shape::Cylinder)
    };
    let turned = turned
        .map(Level::new(), &mesh, &[])
        .unwrap()
        .set
        .per_corner();
    for (p, q) in plain.iter().zip(&turned) {
        let d = (q[0] - p[0]).rem_euclid(1.0);
        assert!(
            (d - 0.75).abs() < 1e-5 && (p[1] - q[1]).abs() < 1e-6,
            "{p:?} {q:?}"
        );
    }
    // Twice the height: half the range of v around the middle.
    let tall = Mapping {
        frame: Some(Placement::upright(DVec3::ZERO, DVec3::new(2.0, 4.0, 2.0))),
        ..Mapping::new(Shape::Cylinder)
    };
    let tall = tall.map(Level::new(), &mesh, &[]).unwrap().set.per_corner();
    assert!(
        tall.iter()
            .all(|uv| (0.25 - 1e-6..=0.75 + 1e-6).contains(&uv[1]))
    );
    let repeated = Mapping {
        repeat: [3.0, 2.0],
        ..Mapping::new(Shape::Cylinder)
    };
    let repeated = repeated
        .map(Level::new(), &mesh, &[])
        .unwrap()
        .set
        .per_corner();
    for (p, q) in plain.iter().zip(&repeated) {
        assert!((q[0] - 3.0 * p[0]).abs() < 1e-5 && (q[1] - 2.0 * p[1]).abs() < 1e-5);
    }
}

#[test]
fn a_plane_by_tile_size_counts_tiles() {
    let positions = [
        [-1.5, -0.5, 0.0],
        [2.5, -0.5, 0.0],
        [2.5, 1.5, 3.0],
        [-1.5, 1.5, 3.0],
    ];
    let mut faces = Faces::new();
    faces.push(&[0, 1, 2, 3]);
    let mesh = Mesh::new(&positions, &faces).unwrap();
    let mapping = Mapping {
        tile: Some([0.5, 2.0]),
        origin: Origin::BottomLeft,
        ..Mapping::slide_projector()
    };
    let set = mapping.map(Level::new(), &mesh, &[]).unwrap().set;
    assert_eq!(
        set.per_corner(),
        [[-3.0, -0.25], [5.0, -0.25], [5.0, 0.75], [-3.0, 0.75]]
    );
}

#[test]
fn a_flat_axis_and_a_point_map_to_the_middle() {
    let positions = [[1.0, 5.0, 0.0], [2.0, 5.0, 0.0], [1.0, 5.0, 1.0], [7.0; 3]];
    let faces = Faces::from_triangles(&[[0, 1, 2], [3, 3, 3]]);
    let flat = Faces::from_triangles(&[[0, 1, 2]]);
    for shape in [
        Shape::Plane,
        Shape::Cylinder,
        Shape::Cone,
        Shape::Sphere,
        Shape::Box,
    ] {
        for faces in [&faces, &flat] {
            let mesh = Mesh::new(&positions, faces).unwrap();
            Mapping::new(shape)
                .map(Level::new(), &mesh, &[])
                .unwrap()
                .set
                .check(&mesh)
                .unwrap();
        }
    }
    let plane = |positions: &[[f32; 3]]| {
        let mesh = Mesh::new(positions, &flat).unwrap();
        let mapped = Mapping::new(Shape::Plane).map(Level::new(), &mesh, &[]);
        mapped.unwrap().set.per_corner()
    };
    // A floor is seen from above (here from below, since it faces down), a line has a width at most.
    assert_eq!(plane(&positions[..3]), [[0.0, 1.0], [1.0, 1.0], [0.0, 0.0]]);
    let line = [[1.0, 5.0, 0.0], [2.0, 5.0, 0.0], [1.5, 5.0, 0.0]];
    assert_eq!(plane(&line), [[0.0, 0.5], [1.0, 0.5], [0.5, 0.5]]);
    assert_eq!(Shape::Box.uv(DVec3::X, Origin::TopLeft).0, ShapeFace::Right);
}

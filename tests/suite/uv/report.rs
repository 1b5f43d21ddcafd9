//! The report equals closed forms.

use texmap_math::Level;
use texmap_uv::{Faces, Mapping, Mesh, Origin, ReportOptions, Shape, UvSet, report};

use crate::meshes::{ball, ramp, tube};

const UPWARD: ReportOptions = ReportOptions {
    origin: Origin::BottomLeft,
    texture_size: 1000,
    views: true,
};

fn flat(positions: &[[f32; 3]], faces: &Faces, uv: impl Fn([f32; 3]) -> [f32; 2]) -> UvSet {
    UvSet {
        uvs: positions.iter().map(|p| uv(*p)).collect(),
        corners: faces.corners().to_vec(),
    }
}

#[test]
fn a_cylinder_unrolls_without_distortion() {
    let (around, radius) = (96, 0.7);
    // A polygon's circumference, so that its flat faces unroll exactly.
    let side = 2.0
        * radius
        * texmap_math::deterministic_f64::sin(std::f64::consts::PI / f64::from(around));
    let height = side * f64::from(around);
    let (positions, faces) = tube(around, 6, radius, height);
    let mesh = Mesh::new(&positions, &faces).unwrap();
    let set = Mapping {
        origin: Origin::BottomLeft,
        ..Mapping::new(Shape::Cylinder)
    }
    .map(Level::new(), &mesh, &[])
    .unwrap()
    .set;
    let r = report(&mesh, &set, &UPWARD).unwrap();
    for figure in [
        r.stretch_l2,
        r.stretch_linf,
        r.angle_mean,
        r.angle_max,
        r.area_mean,
        r.area_max,
    ] {
        assert!((figure - 1.0).abs() < 1e-4, "{r:?}");
    }
    assert_eq!(
        (r.flipped, r.overlapping, r.collapsed, r.wide, r.islands),
        (0, 0, 0, 0, 1)
    );
    assert!((r.seam_length - height).abs() < 1e-5 && (r.rim_length - 2.0 * height).abs() < 1e-3);
    assert!((r.density[1] * height - 1000.0).abs() < 0.1);
}

#[test]
fn a_plane_map_of_a_slope_stretches_by_one_over_its_cosine() {
    for slope in [0.0, 0.5, 1.0, 2.0, 5.0] {
        let (positions, faces) = ramp(5, slope);
        let mesh = Mesh::new(&positions, &faces).unwrap();
        let set = flat(&positions, &faces, |p| [p[0], p[1]]);
        let r = report(&mesh, &set, &UPWARD).unwrap();
        let stretch = (1.0 + slope * slope).sqrt();
        // Angle distortion is the ratio of the two stretches; areas shrink alike, so they are not distorted.
        assert!(
            (r.angle_max / stretch - 1.0).abs() < 1e-6
                && (r.angle_mean / stretch - 1.0).abs() < 1e-6
        );
        assert!((r.area_max - 1.0).abs() < 1e-6);
        // Normalised by the mean scale, the square root of 1 / stretch.
        let scale = (1.0 / stretch).sqrt();
        assert!((r.stretch_linf / (stretch * scale) - 1.0).abs() < 1e-6);
        let l2 = ((stretch * stretch + 1.0) / 2.0).sqrt() * scale;
        assert!((r.stretch_l2 / l2 - 1.0).abs() < 1e-6);
        // Negative twin: the map along the slope has none.
        let along = flat(&positions, &faces, |p| [p[0] * stretch as f32, p[1]]);
        assert!((report(&mesh, &along, &UPWARD).unwrap().angle_max - 1.0).abs() < 1e-5);
    }
}

#[test]
fn the_latitudes_of_a_sphere_stretch_by_their_cosine() {
    let (positions, faces) = ball(256, 128, 1.0);
    let mesh = Mesh::new(&positions, &faces).unwrap();
    let set = Mapping {
        origin: Origin::BottomLeft,
        ..Mapping::new(Shape::Sphere)
    }
    .map(Level::new(), &mesh, &[])
    .unwrap()
    .set;
    let r = report(&mesh, &set, &UPWARD).unwrap();
    // Along u a unit is 2 pi cos(latitude), along v it is pi: equal at 60 degrees.
    for t in r.triangles.iter().filter(|t| t.face % 7 == 0) {
        let mean: f64 = t
            .corners
            .iter()
            .map(|k| f64::from(positions[faces.corners()[*k as usize] as usize][1]))
            .sum::<f64>()
            / 3.0;
        if mean.abs() < 0.95 {
            let ratio = 2.0 * (1.0 - mean * mean).sqrt();
            let expected = if ratio > 1.0 { ratio } else { 1.0 / ratio };
            assert!(
                (f64::from(t.angle) / expected - 1.0).abs() < 0.05,
                "{} {expected} at {mean}",
                t.angle
            );
        }
    }
    assert_eq!((r.flipped, r.overlapping), (0, 0));
}

#[test]
fn mirrored_collapsed_and_repeated_triangles_are_counted() {
    let (positions, faces) = ramp(4, 0.0);
    let mesh = Mesh::new(&positions, &faces).unwrap();
    let count = |uv: &dyn Fn([f32; 3]) -> [f32; 2]| {
        report(&mesh, &flat(&positions, &faces, uv), &UPWARD).unwrap()
    };
    let straight = count(&|p| [p[0], p[1]]);
    assert_eq!(
        (straight.flipped, straight.collapsed, straight.outside),
        (0, 0, 0)
    );
    let mirrored = count(&|p| [1.0 - p[0], p[1]]);
    assert_eq!((mirrored.flipped, mirrored.collapsed), (32, 0));
    let line = count(&|p| [p[0] + p[1], p[0] + p[1]]);
    assert_eq!(line.collapsed, 32);
    assert!(
        line.stretch_l2.is_infinite()
            && line.stretch_linf.is_infinite()
            && !line.angle_max.is_nan()
    );
    let outside = count(&|p| [2.0 * p[0], p[1] - 0.5]);
    assert_eq!(outside.outside, 32 - 8);
    // Folded in the middle: every triangle of the right half lies on one of the left.
    let folded = count(&|p| [if p[0] > 0.5 { 1.0 - p[0] } else { p[0] }, p[1]]);
    assert_eq!((folded.overlapping, folded.flipped), (32, 16));
    assert!(
        (folded.overlap_area - 0.5).abs() < 1e-9,
        "{}",
        folded.overlap_area
    );
}

#[test]
fn seams_are_seen_from_outside_and_not_from_inside() {
    // A closed box with a seam everywhere: from a corner view three of six sides show; edges of the rim show too.
    let (positions, faces) = ball(32, 16, 1.0);
    let mesh = Mesh::new(&positions, &faces).unwrap();
    let set = Mapping {
        origin: Origin::BottomLeft,
        ..Mapping::new(Shape::Sphere)
    }
    .map(Level::new(), &mesh, &[])
    .unwrap()
    .set;
    let r = report(&mesh, &set, &UPWARD).unwrap();
    // A meridian and the spokes of the poles: about half of the 14 views see any of it.
    assert!((0.3..0.7).contains(&r.seam_seen), "{}", r.seam_seen);
    assert!(
        report(
            &mesh,
            &set,
            &ReportOptions {
                views: false,
                ..UPWARD
            }
        )
        .unwrap()
        .seam_seen
        .is_nan()
    );
}

#[test]
fn degenerate_and_non_manifold_meshes_are_reported_not_refused() {
    let positions = [
        [0.0; 3],
        [0.0, 1.0, 0.0],
        [1.0, 0.0, 0.0],
        [-1.0, 0.0, 0.0],
        [0.0, 0.0, 1.0],
    ];
    let faces = Faces::from_triangles(&[[0, 1, 2], [1, 0, 3], [0, 1, 4], [2, 2, 2], [0, 1, 1]]);
    let mesh = Mesh::new(&positions, &faces).unwrap();
    let r = report(
        &mesh,
        &flat(&positions, &faces, |p| [p[0] + 0.1 * p[2], p[1]]),
        &UPWARD,
    )
    .unwrap();
    assert_eq!((r.non_manifold_edges, r.degenerate), (1, 2));
    assert!(r.t_junctions.list.is_empty());
    assert!(r.stretch_l2.is_finite() && r.seam_length > 0.9);
    let broken = UvSet {
        uvs: vec![[f32::NAN, 0.0]],
        corners: vec![0; 15],
    };
    assert!(report(&mesh, &broken, &UPWARD).is_err());
}

/// The loader divides quads into triangles; at the poles of the teapot some of them have no area. They tear nothing.
#[test]
fn a_plane_map_of_the_teapot_has_no_seam_however_it_is_read() {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../assets/models/teapot.obj");
    let scene = texmap_io::load_model(&path, &texmap_io::LoadOptions::default()).unwrap();
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for mesh in &scene.meshes {
        let base = positions.len() as u32;
        positions.extend(&mesh.positions);
        triangles.extend(mesh.triangles.iter().map(|t| t.map(|i| i + base)));
    }
    let faces = Faces::from_triangles(&triangles);
    let mesh = Mesh::new(&positions, &faces).unwrap();
    let of = |shape| {
        let mapping = Mapping {
            origin: Origin::BottomLeft,
            ..Mapping::new(shape)
        };
        let set = mapping.map(Level::new(), &mesh, &[]).unwrap().set;
        report(&mesh, &set, &UPWARD).unwrap()
    };
    let plane = of(Shape::Plane);
    assert!(
        plane.degenerate > 0,
        "the case needs triangles without area"
    );
    assert_eq!((plane.seam_length, plane.non_manifold_edges), (0.0, 0));
    // As many islands as the surface has pieces: body with bottom, lid, handle, spout at most.
    assert!(plane.islands <= 5, "{} islands", plane.islands);
    // Negative twin: a box tears it.
    assert!(of(Shape::Box).seam_length > 10.0);
}

/// Two squares with a face without area between them, cut apart on both of its sides: one seam, two islands.
#[test]
fn a_face_without_area_between_two_others_makes_one_seam() {
    let positions = [
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [1.0, 1.0, 0.0],
        [0.0, 1.0, 0.0],
        [2.0, 0.0, 0.0],
        [2.0, 1.0, 0.0],
        [1.0, 1.0, 0.0],
    ];
    let mut faces = Faces::new();
    faces.push(&[0, 1, 2, 3]);
    faces.push(&[1, 4, 5, 6]);
    faces.push(&[2, 1, 6]);
    let mesh = Mesh::new(&positions, &faces).unwrap();
    let by_face = |shift: [f32; 3]| {
        let corners = (0..faces.len()).flat_map(|f| faces.face(f).iter().map(move |&i| (f, i)));
        UvSet {
            uvs: corners
                .map(|(f, i)| {
                    [
                        positions[i as usize][0] + shift[f],
                        positions[i as usize][1],
                    ]
                })
                .collect(),
            corners: (0..faces.corners().len() as u32).collect(),
        }
    };
    for (shift, seam, islands) in [
        ([0.0, 0.0, 0.0], 0.0, 1),
        ([0.0, 0.0, 5.0], 1.0, 2),
        ([0.0, 5.0, 5.0], 1.0, 2),
        ([0.0, 5.0, 0.0], 1.0, 2),
    ] {
        let r = report(&mesh, &by_face(shift), &UPWARD).unwrap();
        assert_eq!(
            (r.seam_length, r.islands, r.degenerate),
            (seam, islands, 1),
            "{shift:?}"
        );
    }
    // A third square on the middle edge: an edge of three faces is one seam, too.
    let mut three = positions.to_vec();
    three.extend([[1.0, 0.0, 1.0], [1.0, 1.0, 1.0]]);
    faces.push(&[1, 7, 8, 2]);
    let mesh = Mesh::new(&three, &faces).unwrap();
    let set = flat(&three, &faces, |p| [p[0] + p[2], p[1]]);
    let r = report(&mesh, &set, &UPWARD).unwrap();
    assert_eq!((r.seam_length, r.non_manifold_edges), (1.0, 1));
}

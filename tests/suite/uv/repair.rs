//! Seams, poles, cutting, packing, unwrapping, tangents: what must hold afterwards.

use std::ops::ControlFlow;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use texmap_math::Level;
use texmap_math::glam::DVec3;
use texmap_uv::{
    AtlasSize, Faces, Mapping, Mesh, Origin, Placement, ReportOptions, SeamEdges, Shape, UvError,
    UvSet, auto_planes, cut_seams, pack, report, tangents, unwrap,
};

use crate::meshes::{ball, ramp, tube};

fn mapped(mesh: &Mesh<'_>, shape: Shape, fix_seams: bool) -> UvSet {
    // A box around an odd number of meridians has its middle off the axis: the shape's position is set by hand.
    let frame = (shape == Shape::Sphere).then(|| Placement::upright(DVec3::ZERO, DVec3::ONE));
    Mapping {
        fix_seams,
        frame,
        ..Mapping::new(shape)
    }
    .map(Level::new(), mesh, &[])
    .unwrap()
    .set
}

#[test]
fn no_triangle_is_torn_after_the_repair_poles_included() {
    for (around, down) in [(24, 12), (7, 5), (3, 2), (64, 33)] {
        let (positions, faces) = ball(around, down, 1.5);
        let mesh = Mesh::new(&positions, &faces).unwrap();
        let torn = |fix: bool| {
            report(
                &mesh,
                &mapped(&mesh, Shape::Sphere, fix),
                &ReportOptions::default(),
            )
            .unwrap()
            .wide
        };
        assert_eq!(torn(true), 0, "{around} x {down}");
        // Negative twin: the plain formula tears the seam.
        assert!(torn(false) > 0);
    }
}

#[test]
fn vertices_are_split_only_along_the_seam_and_at_the_poles() {
    let (positions, faces) = ball(24, 12, 1.0);
    let mesh = Mesh::new(&positions, &faces).unwrap();
    let set = mapped(&mesh, Shape::Sphere, true);
    // 11 vertices of the seam meridian twice, each pole once per triangle.
    assert_eq!(set.uvs.len(), positions.len() + 11 + 2 * (24 - 1));
    let plain = mapped(&mesh, Shape::Sphere, false);
    assert_eq!(plain.uvs.len(), positions.len());
}

#[test]
fn a_face_around_the_axis_is_named() {
    let positions = [
        [1.0, 1.0, 0.0],
        [-0.6, 1.0, 0.8],
        [-0.6, 1.0, -0.8],
        [0.0, -1.0, 0.0],
    ];
    let faces = Faces::from_triangles(&[[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]);
    let mesh = Mesh::new(&positions, &faces).unwrap();
    let frame = Some(Placement::upright(DVec3::ZERO, DVec3::ONE));
    let mapped = Mapping {
        frame,
        ..Mapping::new(Shape::Sphere)
    }
    .map(Level::new(), &mesh, &[])
    .unwrap();
    assert_eq!(mapped.around_axis, [0]);
}

#[test]
fn packed_unwrapped_and_automatic_layouts_are_free_of_overlaps() {
    let atlas = AtlasSize {
        size: 512,
        gutter: 4,
    };
    for (positions, faces) in [ball(20, 12, 1.0), tube(20, 5, 1.0, 3.0), ramp(6, 2.0)] {
        let mesh = Mesh::new(&positions, &faces).unwrap();
        let boxed = mapped(&mesh, Shape::Box, true);
        let sets = [
            ("auto", auto_planes(&mesh, atlas, Origin::TopLeft).unwrap()),
            (
                "unwrap",
                unwrap(
                    &mesh,
                    &SeamEdges::default(),
                    atlas,
                    Origin::TopLeft,
                    &|_, _| ControlFlow::Continue(()),
                )
                .unwrap(),
            ),
            ("packed box", pack(&mesh, &boxed, atlas).unwrap()),
        ];
        for (name, set) in sets {
            let r = report(&mesh, &set, &ReportOptions::default()).unwrap();
            assert_eq!(
                (r.overlapping, r.outside, r.collapsed, r.flipped),
                (0, 0, 0, 0),
                "{name}"
            );
        }
        // Negative twin: a sphere around a plane folds onto itself.
        let plane = mapped(&mesh, Shape::Plane, true);
        let folded = report(&mesh, &plane, &ReportOptions::default())
            .unwrap()
            .overlapping
            > 0;
        assert_eq!(
            folded,
            positions[0][1] != 0.0,
            "the ramp alone is flat enough"
        );
    }
}

#[test]
fn a_tube_cut_along_its_length_and_rings_comes_apart() {
    let (positions, faces) = tube(8, 3, 1.0, 3.0);
    let mesh = Mesh::new(&positions, &faces).unwrap();
    let set = mapped(&mesh, Shape::Cylinder, true);
    let islands = |set: &UvSet| {
        report(
            &mesh,
            &pack(&mesh, set, AtlasSize::default()).unwrap(),
            &ReportOptions::default(),
        )
        .unwrap()
        .islands
    };
    assert_eq!(islands(&set), 1);
    let ring: Vec<[u32; 2]> = (0..8).map(|i| [8 + i, 8 + (i + 1) % 8]).collect();
    let parted = cut_seams(
        &mesh,
        &set,
        &SeamEdges {
            pairs: &ring,
            angle: None,
        },
    )
    .unwrap();
    assert_eq!(islands(&parted), 2);
    let creased = cut_seams(
        &mesh,
        &set,
        &SeamEdges {
            pairs: &[],
            angle: Some(0.5),
        },
    )
    .unwrap();
    assert_eq!(islands(&creased), 8);
}

#[test]
fn required_cuts_part_the_unwrapped_charts() {
    let (positions, faces) = ramp(4, 0.0);
    let mesh = Mesh::new(&positions, &faces).unwrap();
    let charts = |pairs: &[[u32; 2]]| {
        let set = unwrap(
            &mesh,
            &SeamEdges { pairs, angle: None },
            AtlasSize::default(),
            Origin::BottomLeft,
            &|_, _| ControlFlow::Continue(()),
        )
        .unwrap();
        report(
            &mesh,
            &set,
            &ReportOptions {
                origin: Origin::BottomLeft,
                ..ReportOptions::default()
            },
        )
        .unwrap()
        .islands
    };
    assert_eq!(charts(&[]), 1);
    let across: Vec<[u32; 2]> = (0..4).map(|i| [10 + i, 11 + i]).collect();
    assert_eq!(charts(&across), 2);
}

/// Progress counts up within a stage and ends at its total. A break ends the work with an error of its own.
#[test]
fn unwrapping_reports_progress_and_can_be_cancelled() {
    let (positions, faces) = ball(24, 12, 1.0);
    let mesh = Mesh::new(&positions, &faces).unwrap();
    let run = |progress: &(dyn Fn(usize, Option<usize>) -> ControlFlow<()> + Sync)| {
        let (cuts, atlas) = (SeamEdges::default(), AtlasSize::default());
        unwrap(&mesh, &cuts, atlas, Origin::BottomLeft, progress)
    };
    let heard = Mutex::new(Vec::new());
    run(&|done, of| {
        heard.lock().unwrap().push((done, of));
        ControlFlow::Continue(())
    })
    .unwrap();
    let heard = heard.into_inner().unwrap();
    assert!(heard.iter().any(|(done, of)| Some(*done) == *of));
    assert!(
        heard
            .iter()
            .all(|(done, of)| of.is_none_or(|of| *done <= of))
    );
    for steps in [0, heard.len() / 2, heard.len() - 1] {
        let calls = AtomicUsize::new(0);
        let ended = run(&|_, _| {
            if calls.fetch_add(1, Ordering::Relaxed) == steps {
                return ControlFlow::Break(());
            }
            ControlFlow::Continue(())
        });
        assert_eq!(ended, Err(UvError::Cancelled), "after {steps} steps");
        assert_eq!(
            calls.into_inner(),
            steps + 1,
            "nothing is told after a break"
        );
    }
}

#[test]
fn tangents_are_unit_square_to_the_normal_and_follow_u() {
    let (positions, faces) = ball(24, 12, 1.0);
    let mesh = Mesh::new(&positions, &faces).unwrap();
    let set = mapped(&mesh, Shape::Sphere, true);
    let normals: Vec<[f32; 3]> = faces
        .corners()
        .iter()
        .map(|&i| positions[i as usize])
        .collect();
    let found = tangents(&mesh, &set, &normals).unwrap();
    for ((t, n), &i) in found.iter().zip(&normals).zip(faces.corners()) {
        let (t3, n) = (
            DVec3::new(t[0].into(), t[1].into(), t[2].into()),
            DVec3::from(n.map(f64::from)),
        );
        assert!((t3.length() - 1.0).abs() < 1e-6 && t3.dot(n).abs() < 1e-5 && t[3].abs() == 1.0);
        let p = positions[i as usize].map(f64::from);
        // Away from the poles u runs along the circle of latitude, to the viewer's right.
        if p[1].abs() < 0.9 {
            let along = DVec3::new(p[2], 0.0, -p[0]).normalize();
            assert!(t3.dot(along) > 0.99, "{t3} at {p:?}");
        }
    }
}

#[test]
fn tangents_of_senseless_coordinates_are_finite() {
    let (positions, faces) = ramp(3, 0.5);
    let mesh = Mesh::new(&positions, &faces).unwrap();
    let corners = faces.corners().len();
    let up = vec![[0.0, 0.0, 1.0]; corners];
    let zero = vec![[0.0; 3]; corners];
    let collapsed = UvSet {
        uvs: vec![[0.3, 0.3]],
        corners: vec![0; corners],
    };
    let line = UvSet {
        uvs: positions.iter().map(|p| [p[0], p[0]]).collect(),
        corners: faces.corners().to_vec(),
    };
    let mirrored = UvSet {
        uvs: positions.iter().map(|p| [-p[0], p[1]]).collect(),
        corners: faces.corners().to_vec(),
    };
    for (set, normals) in [
        (&collapsed, &up),
        (&line, &zero),
        (&mirrored, &up),
        (&collapsed, &zero),
    ] {
        let found = tangents(&mesh, set, normals).unwrap();
        assert!(found.as_flattened().iter().all(|c| c.is_finite()));
        assert!(
            found
                .iter()
                .all(|t| (t[0] * t[0] + t[1] * t[1] + t[2] * t[2] - 1.0).abs() < 1e-5)
        );
    }
    let signs = |set: &UvSet| tangents(&mesh, set, &up).unwrap()[0][3];
    let straight = UvSet {
        uvs: positions.iter().map(|p| [p[0], p[1]]).collect(),
        corners: faces.corners().to_vec(),
    };
    assert_eq!(signs(&straight), -signs(&mirrored));
}

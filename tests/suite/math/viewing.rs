//! Cameras, projectors (the matrix part of property 23) and mirror directions (property 29).

use proptest::prelude::*;
use texmap_math::bary;
use texmap_math::camera::{Camera, CameraError};
use texmap_math::glam::{DVec2, DVec3};
use texmap_math::projector::{Projector, projector_uv};
use texmap_math::reflection::reflect;

use crate::strategies::{at, config, point2, point3, unit3, weights};

fn viewer() -> impl Strategy<Value = (DVec3, DVec3, DVec3)> {
    (point3(5.0), unit3(), point3(1.0), 0.5..5.0f64).prop_filter_map(
        "up along the line of sight",
        |(eye, l, up, distance)| {
            (l.cross(up).length() > 0.1).then(|| (eye, eye + l * distance, up))
        },
    )
}

fn camera() -> impl Strategy<Value = Camera> {
    (viewer(), 0.2..2.5f64, 1e-3..1.0f64, any::<bool>()).prop_map(
        |((eye, look, up), fov_x, near, infinite)| Camera {
            eye,
            look,
            up,
            fov_x,
            near,
            far: if infinite { f64::INFINITY } else { 100.0 },
        },
    )
}

proptest! {
    #![proptest_config(config())]

    /// The matrix and the ray are one camera: a point along the ray of a pixel lands on that pixel, its w the distance.
    #[test]
    fn rays_and_matrices_agree(camera in camera(), x in 0.0..640.0f64, y in 0.0..360.0f64, distance in 0.01..50.0f64) {
        let ray = camera.ray(640, 360, x, y).expect("a good camera");
        let clip = camera.clip_from_world(640.0 / 360.0).expect("a good camera") * (camera.eye + ray * distance).extend(1.0);
        prop_assert!((clip.w - distance).abs() <= 1e-12 * (1.0 + distance) * 20.0);
        let seen = DVec2::new(clip.x, clip.y) / clip.w;
        let want = DVec2::new(x / 320.0 - 1.0, 1.0 - y / 180.0);
        prop_assert!((seen - want).abs().max_element() <= 1e-11 * (1.0 + 1.0 / distance) * (1.0 + 1.0 / camera.fov_x), "{seen} {want}");
        // Depth: 1 at the near plane, 0 at the far one.
        let depth = |d: f64| { let c = camera.projection(1.0) * DVec3::new(0.0, 0.0, -d).extend(1.0); c.z / c.w };
        prop_assert!((depth(camera.near) - 1.0).abs() <= 1e-12);
        if camera.far.is_finite() {
            prop_assert!(depth(camera.far).abs() <= 1e-12);
        } else {
            prop_assert!(depth(1e12) > 0.0 && depth(1e12) < 1e-9);
        }
        prop_assert!(depth(distance) > depth(distance * 1.1), "nearer is larger");
        // The view matrix keeps lengths and handedness.
        let view = camera.view().expect("a good camera");
        prop_assert!((view.determinant() - 1.0).abs() <= 1e-12);
        prop_assert!(view.transform_point3(camera.look).truncate().length() <= 1e-11);
        prop_assert!(view.transform_point3(camera.look).z < 0.0);
    }

    /// Property 23: axis, edges, scale, and what lies behind.
    #[test]
    fn projectors_map_their_frustum((eye, look, up) in viewer(), fov in 0.2..2.5f64, aspect in 0.3..3.0f64, k in 1e-3..1e3f64, p in point2(1.0)) {
        let projector = Projector::new(eye, look, up, fov, aspect).expect("a good projector");
        let centre = projector.uv(look).expect("in front");
        prop_assert!((centre - DVec2::splat(0.5)).abs().max_element() <= 1e-12);
        let l = (look - eye).normalize();
        let right = l.cross(up).normalize();
        let down = l.cross(right);
        let tan = (0.5 * fov).tan();
        let toward = |x: f64, y: f64| eye + (l + right * (tan * x) + down * (tan / aspect * y)) * 2.0;
        for (x, y) in [(-1.0, 0.0), (1.0, 0.0), (0.0, -1.0), (0.0, 1.0), (p.x, p.y)] {
            let uv = projector.uv(toward(x, y)).expect("in front");
            prop_assert!((uv - DVec2::new(x + 1.0, y + 1.0) * 0.5).abs().max_element() <= 1e-12 * (1.0 + 1.0 / fov) * 4.0, "{uv}");
        }
        let qst = projector.project(toward(p.x, p.y));
        let (uv, scaled) = (projector_uv(qst).expect("in front"), projector_uv(qst * k).expect("in front"));
        prop_assert!((uv - scaled).abs().max_element() <= 1e-12);
        // t is the distance along the axis; behind it nothing is lit.
        prop_assert!((qst.z - 2.0).abs() <= 1e-11);
        prop_assert_eq!(projector.uv(eye - (toward(p.x, p.y) - eye)), None);
    }

    /// Property 23: interpolated homogeneously (times the eye's 1/w) a projected picture does not depend on the eye's camera;
    /// without the factor, or divided at the vertices, it does.
    #[test]
    fn slides_do_not_depend_on_the_eye(camera in camera(), other in camera(), triangle in [point3(4.0), point3(4.0), point3(4.0)], l in weights()) {
        let projector = Projector::new(DVec3::new(0.0, 0.0, 9.0), DVec3::ZERO, DVec3::Y, 1.0, 1.5).expect("a good projector");
        let qst = triangle.map(|p| projector.project(p));
        let point = triangle[0] * l[0] + triangle[1] * l[1] + triangle[2] * l[2];
        let want = projector.uv(point).expect("in front");
        for camera in [camera, other] {
            let clip_from_world = camera.clip_from_world(1.0).expect("a good camera");
            let clip = triangle.map(|p| clip_from_world * p.extend(1.0));
            if clip.iter().any(|c| c.w < 0.1) {
                continue;
            }
            let screen = clip.map(|c| DVec2::new(c.x, c.y) / c.w);
            let seen = clip_from_world * point.extend(1.0);
            let seen = DVec2::new(seen.x, seen.y) / seen.w;
            if crate::strategies::area2(screen) < 0.05 {
                continue;
            }
            let b = bary::perspective(bary::screen(screen, seen).expect("area"), clip.map(|c| 1.0 / c.w)).expect("in front");
            let got = DVec3::from(std::array::from_fn::<f64, 3, _>(|k| bary::blend(b, qst.map(|q| q[k]))));
            prop_assert!((projector_uv(got).expect("in front") - want).abs().max_element() <= 1e-9);
        }
    }

    /// Property 29.
    #[test]
    fn reflection_keeps_length_and_angle(v in point3(3.0), n in unit3()) {
        let r = reflect(v, n);
        prop_assert!((r.length() - v.length()).abs() <= 1e-14 * 10.0);
        prop_assert!((n.dot(r) - n.dot(v)).abs() <= 1e-14 * 10.0);
        prop_assert!((reflect(r, n) - v).length() <= 1e-14 * 10.0);
    }
}

/// Negative twins of the projected picture: screen-linear q, s, t without 1/w, and division at the vertices.
#[test]
fn early_division_bends_a_slide() {
    let projector = Projector::new(DVec3::new(3.0, 2.0, 3.0), DVec3::ZERO, DVec3::Y, 1.0, 1.0)
        .expect("a good projector");
    let camera = Camera {
        eye: DVec3::new(0.0, 1.0, 4.0),
        look: DVec3::ZERO,
        up: DVec3::Y,
        fov_x: 1.0,
        near: 0.1,
        far: 100.0,
    };
    let clip_from_world = camera.clip_from_world(1.0).expect("a good camera");
    let triangle = [
        DVec3::new(-1.0, 0.0, -3.0),
        DVec3::new(1.0, 0.0, -3.0),
        DVec3::new(0.0, 0.0, 2.0),
    ];
    let clip = triangle.map(|p| clip_from_world * p.extend(1.0));
    let screen = clip.map(|c| DVec2::new(c.x, c.y) / c.w);
    let l = [0.3, 0.3, 0.4];
    let b = bary::perspective(l, clip.map(|c| 1.0 / c.w)).expect("in front");
    let point = triangle[0] * b[0] + triangle[1] * b[1] + triangle[2] * b[2];
    let want = projector.uv(point).expect("in front");
    let qst = triangle.map(|p| projector.project(p));
    let blend = |w: [f64; 3]| {
        DVec3::from(std::array::from_fn::<f64, 3, _>(|k| {
            bary::blend(w, qst.map(|q| q[k]))
        }))
    };
    assert!((projector_uv(blend(b)).expect("in front") - want).length() < 1e-12);
    assert!(
        (projector_uv(blend(l)).expect("in front") - want).length() > 0.05,
        "no 1/w"
    );
    let divided = qst.map(|q| projector_uv(q).expect("in front"));
    let early = DVec2::new(
        bary::blend(b, divided.map(|d| d.x)),
        bary::blend(b, divided.map(|d| d.y)),
    );
    assert!((early - want).length() > 0.05, "divided at the vertices");
    assert!((at(screen, l) - screen[2]).length() > 0.0);
}

#[test]
fn unusable_cameras_are_refused_by_name() {
    let good = Camera {
        eye: DVec3::ZERO,
        look: DVec3::NEG_Z,
        up: DVec3::Y,
        fov_x: 1.0,
        near: 0.1,
        far: 10.0,
    };
    good.view().expect("a good camera");
    let with = |f: fn(&mut Camera)| {
        let mut camera = good;
        f(&mut camera);
        camera.view().expect_err("unusable")
    };
    assert!(matches!(
        with(|c| c.look = c.eye),
        CameraError::EyeIsLook { .. }
    ));
    assert!(matches!(
        with(|c| c.up = DVec3::Z),
        CameraError::UpParallel { .. }
    ));
    assert!(matches!(
        with(|c| c.up = DVec3::ZERO),
        CameraError::UpParallel { .. }
    ));
    assert!(matches!(
        with(|c| c.up = DVec3::new(1e-12, 0.0, -5.0)),
        CameraError::UpParallel { .. }
    ));
    assert_eq!(with(|c| c.eye.x = f64::NAN), CameraError::NonFinite);
    for fov_x in [0.0, -1.0, std::f64::consts::PI, f64::NAN, 7.0] {
        let camera = Camera { fov_x, ..good };
        assert!(
            matches!(camera.view(), Err(CameraError::FieldOfView { .. })),
            "{fov_x}"
        );
    }
    for (near, far) in [
        (0.0, 1.0),
        (-1.0, 1.0),
        (1.0, 1.0),
        (2.0, 1.0),
        (f64::NAN, 1.0),
        (0.1, f64::NAN),
        (f64::INFINITY, f64::INFINITY),
    ] {
        let camera = Camera { near, far, ..good };
        assert!(
            matches!(camera.view(), Err(CameraError::NearFar { .. })),
            "{near} {far}"
        );
    }
    assert!(Projector::new(DVec3::ZERO, DVec3::ZERO, DVec3::Y, 1.0, 1.0).is_err());
    assert!(Projector::new(DVec3::ZERO, DVec3::X, DVec3::X, 1.0, 1.0).is_err());
    assert!(Projector::new(DVec3::ZERO, DVec3::X, DVec3::Y, 4.0, 1.0).is_err());
    assert!(Projector::new(DVec3::ZERO, DVec3::X, DVec3::Y, 1.0, 0.0).is_err());
    // Beside the projector and in it nothing is lit.
    let projector =
        Projector::new(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, 1.0, 1.0).expect("a good projector");
    assert_eq!(
        (
            projector.uv(DVec3::X),
            projector.uv(DVec3::ZERO),
            projector.uv(DVec3::NAN)
        ),
        (None, None, None)
    );
    // Length alone is no reason.
    Camera {
        look: DVec3::NEG_Z * 1e-200,
        up: DVec3::Y * 1e200,
        ..good
    }
    .view()
    .expect("a good camera");
    let said = CameraError::FieldOfView {
        fov_x: std::f64::consts::PI,
    }
    .to_string();
    assert!(said.contains("180"), "{said}");
}

/// The assignment's frustum takes the sine where the tangent is meant: fov 60 would draw 53.13 degrees.
#[test]
fn the_field_of_view_is_a_true_tangent() {
    let camera = Camera {
        eye: DVec3::ZERO,
        look: DVec3::NEG_Z,
        up: DVec3::Y,
        fov_x: 60f64.to_radians(),
        near: 0.1,
        far: 10.0,
    };
    let edge = camera.ray(100, 50, 100.0, 25.0).expect("a good camera");
    assert!((edge.x / -edge.z - 30f64.to_radians().tan()).abs() < 1e-15);
    assert!((edge.x.atan2(-edge.z).to_degrees() - 30.0).abs() < 1e-12);
}

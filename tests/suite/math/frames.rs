//! Texture frames and magic vectors.

use proptest::prelude::*;
use texmap_math::bary;
use texmap_math::glam::{DMat4, DVec2, DVec3};
use texmap_math::texture_frame::{FrameError, TextureFrame};

use crate::strategies::{area2, config, point2, point3, unit3, weights};

/// Independent U and V that are neither unit nor at a right angle.
fn frame() -> impl Strategy<Value = TextureFrame> {
    (point3(5.0), point3(2.0), point3(2.0)).prop_filter_map("nearly parallel", |(o, u, v)| {
        (u.cross(v).length() > 0.1 * u.length() * v.length()
            && u.length() > 0.2
            && v.length() > 0.2)
            .then(|| TextureFrame::new(o, u, v).expect("independent"))
    })
}

fn orthonormal() -> impl Strategy<Value = TextureFrame> {
    (point3(5.0), unit3(), unit3()).prop_filter_map("nearly parallel", |(o, u, n)| {
        let v = n.cross(u);
        (v.length() > 0.1).then(|| TextureFrame::new(o, u, v.normalize()).expect("independent"))
    })
}

fn seen_well(frame: &TextureFrame, w: DVec3) -> bool {
    let c = frame.texgen().c;
    c.dot(w).abs() > 1e-2 * c.length() * w.length()
}

proptest! {
    #![proptest_config(config())]

    /// Property 8: A.W/C.W are the coefficients of U and V, for any independent U, V and any length and sign of W; moving O moves them.
    #[test]
    fn magic_vectors_solve_the_plane(frame in frame(), uv in point2(3.0), k in 0.01..100.0f64, back: bool, shift in -3.0..3.0f64) {
        let w = frame.point(uv);
        prop_assume!(seen_well(&frame, w));
        let k = if back { -k } else { k };
        let tolerance = 1e-11 * (1.0 + uv.x.abs() + uv.y.abs());
        let got = frame.texgen().uv(w * k).expect("not edge-on");
        prop_assert!((got - uv).abs().max_element() <= tolerance, "{got} {uv}");
        let moved = TextureFrame::new(frame.o + frame.u * shift, frame.u, frame.v).expect("independent");
        let got = moved.texgen().uv(w).expect("not edge-on");
        prop_assert!((got - DVec2::new(uv.x - shift, uv.y)).abs().max_element() <= 1e-11 * (1.0 + uv.x.abs() + uv.y.abs() + shift.abs()));
    }

    /// Property 8: the same as interpolating the vertices of that plane.
    #[test]
    fn magic_vectors_equal_vertex_interpolation(frame in frame(), l in weights()) {
        let corners = [DVec2::ZERO, DVec2::X, DVec2::Y];
        let points = corners.map(|uv| frame.point(uv));
        prop_assume!(points.iter().all(|p| p.z < -0.1));
        let screen = points.map(|p| p.truncate() / -p.z);
        prop_assume!(area2(screen) > 0.02);
        let p = screen[0] * l[0] + screen[1] * l[1] + screen[2] * l[2];
        let w = p.extend(-1.0);
        prop_assume!(seen_well(&frame, w));
        let b = bary::perspective(bary::screen(screen, p).expect("area"), points.map(|p| -1.0 / p.z)).expect("in front");
        let want = DVec2::new(bary::blend(b, corners.map(|c| c.x)), bary::blend(b, corners.map(|c| c.y)));
        let got = frame.texgen().uv(w).expect("not edge-on");
        prop_assert!((got - want).abs().max_element() <= 1e-11, "{got} {want}");
    }

    /// Property 9: the dot products U.(P - O), V.(P - O) are right for an orthonormal frame, and wrong for any other.
    #[test]
    fn dot_products_need_an_orthonormal_frame(frame in orthonormal(), uv in point2(3.0)) {
        let p = frame.point(uv);
        let dots = |f: &TextureFrame| DVec2::new(f.u.dot(p - f.o), f.v.dot(p - f.o));
        prop_assert!((dots(&frame) - uv).abs().max_element() <= 1e-12);
        prop_assume!(uv.x.abs() > 0.1 && seen_well(&frame, p));
        for wrong in [
            TextureFrame::new(frame.o, frame.u * 2.0, frame.v).expect("independent"),
            TextureFrame::new(frame.o, frame.u, frame.v + frame.u).expect("independent"),
        ] {
            let right = wrong.texgen().uv(p).expect("not edge-on");
            prop_assert!((wrong.point(right) - p).length() <= 1e-10 * (1.0 + p.length()));
            prop_assert!((dots(&wrong) - right).abs().max_element() > 1e-3);
        }
    }

    /// A frame made from a triangle gives its vertices their uv; a matrix moves frame and points together.
    #[test]
    fn triangles_make_frames(p in [point3(5.0), point3(5.0), point3(5.0)], uv in [point2(2.0), point2(2.0), point2(2.0)], at in point2(2.0)) {
        let normal = (p[1] - p[0]).cross(p[2] - p[0]);
        prop_assume!(normal.length() > 1.0 && area2(uv) > 0.1);
        let frame = TextureFrame::from_triangle(p, uv).expect("area");
        for i in 0..3 {
            prop_assert!((frame.point(uv[i]) - p[i]).length() < 1e-11);
            prop_assert!((frame.uv(p[i]) - uv[i]).length() < 1e-11);
        }
        // A point off the plane has the uv of its foot.
        prop_assert!((frame.uv(frame.point(at) + frame.normal().normalize() * 3.0) - at).length() < 1e-9);
        let m = DMat4::from_translation(p[2]) * DMat4::from_cols_array(&[0.0, 2.0, 0.0, 0.0, -1.0, 0.0, 0.5, 0.0, 0.0, 0.0, 3.0, 0.0, 0.0, 0.0, 0.0, 1.0]);
        prop_assert!((frame.transform(m).point(at) - m.transform_point3(frame.point(at))).length() < 1e-10);
    }
}

#[test]
fn degenerate_frames_are_refused() {
    let o = DVec3::new(1.0, 2.0, -3.0);
    for (u, v) in [
        (DVec3::ZERO, DVec3::X),
        (DVec3::X, DVec3::ZERO),
        (DVec3::X, DVec3::X * -2.0),
        (DVec3::X, DVec3::new(1.0, 1e-12, 0.0)),
    ] {
        assert!(
            matches!(
                TextureFrame::new(o, u, v),
                Err(FrameError::DegenerateAxes { .. })
            ),
            "{u} {v}"
        );
    }
    assert_eq!(
        TextureFrame::new(o, DVec3::X, DVec3::NAN),
        Err(FrameError::NonFinite)
    );
    assert_eq!(
        TextureFrame::new(DVec3::INFINITY, DVec3::X, DVec3::Y),
        Err(FrameError::NonFinite)
    );
    // Size alone is no reason: 1e-150 and 1e150 are fine.
    for size in [1e-150, 1e150] {
        TextureFrame::new(DVec3::ZERO, DVec3::X * size, DVec3::Y * size).expect("independent");
    }
    let line = [DVec3::ZERO, DVec3::ONE, DVec3::ONE * 2.0];
    let triangle = [DVec3::ZERO, DVec3::X, DVec3::Y];
    let uv = [DVec2::ZERO, DVec2::X, DVec2::Y];
    assert_eq!(
        TextureFrame::from_triangle(line, uv),
        Err(FrameError::DegenerateTriangle)
    );
    assert_eq!(
        TextureFrame::from_triangle([DVec3::ONE; 3], uv),
        Err(FrameError::DegenerateTriangle)
    );
    assert_eq!(
        TextureFrame::from_triangle(triangle, [DVec2::ONE; 3]),
        Err(FrameError::DegenerateUv)
    );
    assert_eq!(
        TextureFrame::from_triangle(triangle, [DVec2::ZERO, DVec2::ONE, DVec2::ONE * 3.0]),
        Err(FrameError::DegenerateUv)
    );
    assert_eq!(
        TextureFrame::from_triangle(triangle, [DVec2::NAN; 3]),
        Err(FrameError::NonFinite)
    );
}

#[test]
fn the_horizon_and_a_plane_through_the_eye_have_no_uv() {
    let floor =
        TextureFrame::new(DVec3::new(0.0, -1.0, -5.0), DVec3::X, DVec3::Z).expect("independent");
    assert_eq!(
        floor.texgen().uv(DVec3::NEG_Z),
        None,
        "parallel to the floor"
    );
    assert_eq!(floor.texgen().uv(DVec3::ZERO), None);
    assert_eq!(floor.texgen().uv(DVec3::NAN), None);
    let through_the_eye = TextureFrame::new(DVec3::NEG_Z, DVec3::X, DVec3::Z).expect("independent");
    assert_eq!(
        through_the_eye.texgen().uv(DVec3::new(0.3, 0.0, -1.0)),
        None,
        "seen edge-on"
    );
}

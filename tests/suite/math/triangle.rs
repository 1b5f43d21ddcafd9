//! Barycentric coordinates, planes and derivatives over a triangle.

use proptest::prelude::*;
use texmap_math::bary;
use texmap_math::edge::TriangleEdges;
use texmap_math::fixed::{FixedPoint, snap_point};
use texmap_math::glam::{DMat3, DVec2, DVec3};
use texmap_math::plane::{PlaneSetup, perspective_gradient, plane_from_vertices};

use crate::strategies::{EPS32, at, config, inverse_w, largest, point3, triangle, weights};

const ORDERS: [[usize; 3]; 6] = [
    [0, 1, 2],
    [0, 2, 1],
    [1, 0, 2],
    [1, 2, 0],
    [2, 0, 1],
    [2, 1, 0],
];

fn inverse_ws(exponent: f64) -> impl Strategy<Value = [f64; 3]> {
    [
        inverse_w(exponent),
        inverse_w(exponent),
        inverse_w(exponent),
    ]
}

/// The perspective-correct value at a screen point.
fn value(p: [DVec2; 3], inv_w: [f64; 3], u: [f64; 3], at: DVec2) -> f64 {
    bary::blend(
        bary::perspective(bary::screen(p, at).expect("area"), inv_w).expect("in front"),
        u,
    )
}

/// The same in f32: three edge functions over their sum, or the third weight as one minus the others.
fn value_f32(p: [DVec2; 3], inv_w: [f64; 3], u: [f64; 3], at: DVec2, by_difference: bool) -> f64 {
    let narrow = |v: DVec2| [v.x as f32, v.y as f32];
    let mut l = bary::screen_f32(p.map(narrow), narrow(at)).expect("area");
    if by_difference {
        l[2] = 1.0 - l[0] - l[1];
    }
    let b = bary::perspective_f32(l, inv_w.map(|w| w as f32)).expect("in front");
    f64::from(bary::blend_f32(b, u.map(|u| u as f32)))
}

/// Inputs that f32 holds exactly, so that its errors are those of the arithmetic.
fn exact_in_f32(v: DVec2) -> DVec2 {
    DVec2::new(f64::from(v.x as f32), f64::from(v.y as f32))
}

fn permuted<T: Copy>(v: [T; 3], order: [usize; 3]) -> [T; 3] {
    order.map(|i| v[i])
}

proptest! {
    #![proptest_config(config())]

    /// Property 10: weights sum to 1, in the plane as on the screen, and reproduce the vertices exactly.
    #[test]
    fn weights_sum_to_one(p in triangle(3.0, 1e-2), l in weights(), inv_w in inverse_ws(7.0)) {
        let x = at(p, l);
        let screen = bary::screen(p, x).expect("area");
        let plane = bary::perspective(screen, inv_w).expect("in front");
        for b in [screen, plane] {
            prop_assert!((b[0] + b[1] + b[2] - 1.0).abs() <= 1e-13);
        }
        let narrow = |v: DVec2| [v.x as f32, v.y as f32];
        let b = bary::screen_f32(p.map(narrow), narrow(x)).expect("area");
        let b32 = bary::perspective_f32(b, inv_w.map(|w| w as f32)).expect("in front");
        for b in [b, b32] {
            prop_assert!((b.iter().map(|b| f64::from(*b)).sum::<f64>() - 1.0).abs() <= 4.0 * EPS32);
        }
        for i in 0..3 {
            let mut corner = [0.0; 3];
            corner[i] = 1.0;
            prop_assert_eq!(bary::screen(p, p[i]), Some(corner));
        }
        // Moving towards a near vertex: its weight in the plane rises above that on the screen.
        let near = (0..3).max_by(|a, b| inv_w[*a].total_cmp(&inv_w[*b])).expect("three");
        prop_assert!(plane[near] >= screen[near] * (1.0 - 1e-13));
    }

    /// Property 11: a linear function of space is reproduced at every interior point.
    #[test]
    fn linear_functions_are_reproduced(p in triangle(3.0, 1e-2), inv_w in inverse_ws(3.0), l in weights(), g in point3(1.0), c in -1.0..1.0f64) {
        let space: Vec<DVec3> = p.iter().zip(inv_w).map(|(p, w)| p.extend(1.0) / w).collect();
        let u: [f64; 3] = std::array::from_fn(|i| g.dot(space[i]) + c);
        // Weights in space, so that no perspective formula is on the side of the answer.
        let x = space[0] * l[0] + space[1] * l[1] + space[2] * l[2];
        let seen = x.truncate() / x.z;
        let size = largest(&u).max(c.abs());
        let got = value(p, inv_w, u, seen);
        prop_assert!((got - (g.dot(x) + c)).abs() <= 1e-12 * size, "{got}");
        // Planes of u/w and 1/w give the same.
        let setup = PlaneSetup::new(p).expect("area");
        let planes = perspective_gradient(&setup.plane(std::array::from_fn(|i| u[i] * inv_w[i])), &setup.plane(inv_w), seen.x, seen.y);
        prop_assert!((planes.value - got).abs() <= 1e-11 * size);
    }

    /// Property 11 in f32, for both forms.
    #[test]
    fn linear_functions_in_f32(p in triangle(3.0, 2e-2), inv_w in inverse_ws(3.0), l in weights(), u in [-1.0..1.0f64, -1.0..1.0, -1.0..1.0]) {
        let p = p.map(exact_in_f32);
        let (inv_w, u) = (inv_w.map(|w| f64::from(w as f32)), u.map(|u| f64::from(u as f32)));
        let x = exact_in_f32(at(p, l));
        let want = value(p, inv_w, u, x);
        let size = largest(&u);
        prop_assert!((value_f32(p, inv_w, u, x, false) - want).abs() <= 400.0 * EPS32 * size);
        prop_assert!((value_f32(p, inv_w, u, x, true) - want).abs() <= 800.0 * EPS32 * size);
    }

    /// Property 12: the order of the vertices changes neither coverage nor value.
    #[test]
    fn vertex_order_means_nothing(
        p in triangle(3.0, 2e-2), inv_w in inverse_ws(3.0), l in weights(), u in [-1.0..1.0f64, -1.0..1.0, -1.0..1.0],
        pixel in (-200..200i32, -200..200i32),
    ) {
        let x = at(p, l);
        let want = value(p, inv_w, u, x);
        let snapped = p.map(|v| snap_point((v * 64.0).round() * 0.5).expect("in range"));
        let centre = FixedPoint::pixel_centre(pixel.0, pixel.1);
        let covers = TriangleEdges::new(snapped).map(|e| e.covers(centre));
        for order in ORDERS {
            let (p, inv_w, u) = (permuted(p, order), permuted(inv_w, order), permuted(u, order));
            prop_assert!((value(p, inv_w, u, x) - want).abs() <= 1e-12 * largest(&u));
            prop_assert!((value_f32(p, inv_w, u, x, false) - want).abs() <= 800.0 * EPS32 * largest(&u));
            prop_assert_eq!(TriangleEdges::new(permuted(snapped, order)).map(|e| e.covers(centre)), covers);
        }
    }

    /// Property 13: a common factor of 1/w changes nothing; a factor of one vertex does.
    #[test]
    fn only_common_factors_cancel(p in triangle(3.0, 1e-2), inv_w in inverse_ws(7.0), l in weights(), k in 1e-3..1e3f64, n in -30..30i32) {
        let u = [0.0, 1.0, 0.5];
        let x = at(p, l);
        let want = value(p, inv_w, u, x);
        prop_assert!((value(p, inv_w.map(|w| w * k), u, x) - want).abs() <= 1e-13);
        prop_assert_eq!(value(p, inv_w.map(|w| w * 2f64.powi(n)), u, x).to_bits(), want.to_bits());
        prop_assume!(want < 0.9);
        let b = bary::perspective(bary::screen(p, x).expect("area"), inv_w).expect("in front");
        prop_assume!(b[1] > 0.01);
        prop_assert!((value(p, [inv_w[0], inv_w[1] * 3.0, inv_w[2]], u, x) - want).abs() > 1e-4);
    }

    /// Property 18: the quotient rule against central differences, and the determinant of the Jacobian.
    #[test]
    fn derivatives_follow_the_quotient_rule(
        p in triangle(3.0, 0.1), inv_w in inverse_ws(2.0), l in weights(), u in [-1.0..1.0f64, -1.0..1.0, -1.0..1.0], v in [-1.0..1.0f64, -1.0..1.0, -1.0..1.0],
    ) {
        let setup = PlaneSetup::new(p).expect("area");
        let plane = |a: [f64; 3]| setup.plane(std::array::from_fn(|i| a[i] * inv_w[i]));
        let (pu, pv, pw) = (plane(u), plane(v), setup.plane(inv_w));
        let x = at(p, l);
        let here = perspective_gradient(&pu, &pw, x.x, x.y);
        let h = 1e-5;
        let step = |dx: f64, dy: f64| perspective_gradient(&pu, &pw, x.x + dx, x.y + dy).value;
        let (dx, dy) = ((step(h, 0.0) - step(-h, 0.0)) / (2.0 * h), (step(0.0, h) - step(0.0, -h)) / (2.0 * h));
        let size = largest(&u);
        prop_assert!((here.dx - dx).abs() <= 1e-5 * (size + dx.abs()), "{here:?} {dx}");
        prop_assert!((here.dy - dy).abs() <= 1e-5 * (size + dy.abs()), "{here:?} {dy}");
        let there = perspective_gradient(&pv, &pw, x.x, x.y);
        let rows = [pu, pv, pw].map(|q| DVec3::new(q.dx, q.dy, q.at(0.0, 0.0)));
        let h = DMat3::from_cols(rows[0], rows[1], rows[2]).transpose();
        let jacobian = here.dx * there.dy - here.dy * there.dx;
        let want = h.determinant() / pw.at(x.x, x.y).powi(3);
        prop_assert!((jacobian - want).abs() <= 1e-9 * (1.0 + here.dx.abs() + here.dy.abs()) * (1.0 + there.dx.abs() + there.dy.abs()));
    }

    /// Property 19: stepping along a row in f32 stays within a quarter texel of direct evaluation over 1024 pixels; f64 within 1e-9.
    #[test]
    fn stepping_drifts(u0 in 0.0..1024.0f64, u1 in 0.0..1024.0f64) {
        let plane = plane_from_vertices([DVec2::ZERO, DVec2::new(1024.0, 0.0), DVec2::new(0.0, 64.0)], [u0, u1, u0]).expect("area");
        let narrow = plane.to_f32(0.0, 0.0);
        let (mut stepped, mut stepped32) = (plane.value, narrow.value);
        for x in 0..1024u16 {
            let exact = plane.at(f64::from(x), 0.0);
            prop_assert!((stepped - exact).abs() <= 1e-9);
            prop_assert!((f64::from(stepped32) - exact).abs() <= 0.25);
            // The direct form does not drift.
            prop_assert!((f64::from(narrow.at(f32::from(x), 0.0)) - exact).abs() <= 0.0005);
            stepped += plane.dx;
            stepped32 += narrow.dx;
        }
    }

    /// Planes give the vertex values, and the same value from any anchor.
    #[test]
    fn planes_pass_through_their_vertices(p in triangle(1000.0, 10.0), u in [-1.0..1.0f64, -1.0..1.0, -1.0..1.0], a in triangle(1000.0, 1.0)) {
        let plane = plane_from_vertices(p, u).expect("area");
        prop_assert_eq!(plane.at(p[0].x, p[0].y), u[0]);
        let slope = 1e-13 * (1.0 + 2000.0 * (plane.dx.abs() + plane.dy.abs()));
        for i in 0..3 {
            prop_assert!((plane.at(p[i].x, p[i].y) - u[i]).abs() <= slope);
            prop_assert!((plane.anchored(a[0].x, a[0].y).at(p[i].x, p[i].y) - u[i]).abs() <= 4.0 * slope);
        }
    }
}

/// Property 19, negative: over 4096 pixels stepping drifts hundreds of times further than direct evaluation errs.
#[test]
fn a_wide_row_drifts_visibly() {
    let (mut drift, mut direct) = (0.0f64, 0.0f64);
    for end in 0..64u16 {
        let end = 1023.0 - 7.3 * f64::from(end);
        let plane = plane_from_vertices(
            [DVec2::ZERO, DVec2::new(4096.0, 0.0), DVec2::Y],
            [0.1, end, 0.1],
        )
        .expect("area");
        let narrow = plane.to_f32(0.0, 0.0);
        let mut stepped = narrow.value;
        for x in 0..4096u16 {
            let exact = plane.at(f64::from(x), 0.0);
            drift = drift.max((f64::from(stepped) - exact).abs());
            direct = direct.max((f64::from(narrow.at(f32::from(x), 0.0)) - exact).abs());
            stepped += narrow.dx;
        }
    }
    assert!(direct < 1e-4 && drift > 0.02, "{direct} {drift}");
}

/// Planes through snapped positions miss: the mutant that attributes must not be.
#[test]
fn planes_through_snapped_vertices_miss() {
    let p = [
        DVec2::new(10.0017, 11.0019),
        DVec2::new(90.0021, 12.0018),
        DVec2::new(11.0018, 95.0017),
    ];
    let (inv_w, u) = ([1.0, 0.1, 0.5], [0.0, 1024.0, 512.0]);
    let snapped = p.map(|v| {
        let s = snap_point(v).expect("in range");
        DVec2::new(f64::from(s.x), f64::from(s.y)) / 256.0
    });
    let at_pixel = |p: [DVec2; 3], x: DVec2| {
        let setup = PlaneSetup::new(p).expect("area");
        perspective_gradient(
            &setup.plane(std::array::from_fn(|i| u[i] * inv_w[i])),
            &setup.plane(inv_w),
            x.x,
            x.y,
        )
        .value
    };
    let x = DVec2::new(60.5, 25.5);
    let exact = value(p, inv_w, u, x);
    assert!((at_pixel(p, x) - exact).abs() < 1e-9);
    assert!(
        (at_pixel(snapped, x) - exact).abs() > 1e-3,
        "snapping moved nothing"
    );
}

#[test]
fn triangles_without_area_have_no_planes() {
    let line = [DVec2::ZERO, DVec2::ONE, DVec2::ONE * 2.0];
    assert_eq!(PlaneSetup::new(line), None);
    assert_eq!(PlaneSetup::new([DVec2::ZERO, DVec2::X, DVec2::NAN]), None);
    assert_eq!(
        PlaneSetup::new([DVec2::ZERO, DVec2::X * 1e-200, DVec2::Y * 1e-200]),
        None,
        "the area underflows"
    );
    assert_eq!(bary::screen(line, DVec2::X), None);
    assert_eq!(bary::screen_f32([[0.0; 2]; 3], [1.0, 1.0]), None);
    assert_eq!(
        bary::perspective([0.25, 0.5, 0.25], [1.0, -1.0, 1.0]),
        None,
        "the sum is 0: a vertex behind the eye"
    );
}

//! Quads: diagonals and homographies.

use proptest::prelude::*;
use texmap_math::bary;
use texmap_math::glam::{DMat3, DVec2, DVec3};
use texmap_math::homography::{Homography, HomographyError};
use texmap_math::plane::PlaneSetup;

use crate::strategies::{config, point2, point3};

const SQUARE: [DVec2; 4] = [DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y];

/// A convex quad around the origin, either way round, corner cross products above 0.02 of a size of about 1.
fn convex_quad() -> impl Strategy<Value = [DVec2; 4]> {
    (
        [0.3..1.5f64, 0.3..1.5, 0.3..1.5, 0.3..1.5],
        [-0.6..0.6f64, -0.6..0.6, -0.6..0.6, -0.6..0.6],
        any::<bool>(),
        point2(2.0),
    )
        .prop_filter_map("not convex enough", |(r, a, mirrored, centre)| {
            let mut q: [DVec2; 4] = std::array::from_fn(|i| {
                let angle = std::f64::consts::FRAC_PI_2 * i as f64 + a[i];
                DVec2::new(angle.cos(), angle.sin()) * r[i] + centre
            });
            let good =
                (0..4).all(|i| (q[i] - q[(i + 3) % 4]).perp_dot(q[(i + 1) % 4] - q[i]) > 0.05);
            if mirrored {
                q.reverse();
            }
            good.then_some(q)
        })
}

/// The general case by Gaussian elimination of the eight linear equations: another way to the same map.
fn by_linear_solve(from: [DVec2; 4], to: [DVec2; 4]) -> DMat3 {
    let mut m = [[0.0; 9]; 8];
    for i in 0..4 {
        let (p, q) = (from[i], to[i]);
        m[2 * i] = [p.x, p.y, 1.0, 0.0, 0.0, 0.0, -p.x * q.x, -p.y * q.x, q.x];
        m[2 * i + 1] = [0.0, 0.0, 0.0, p.x, p.y, 1.0, -p.x * q.y, -p.y * q.y, q.y];
    }
    for column in 0..8 {
        let pivot = (column..8)
            .max_by(|a, b| m[*a][column].abs().total_cmp(&m[*b][column].abs()))
            .expect("rows");
        m.swap(column, pivot);
        for row in 0..8 {
            if row != column {
                let pivot = m[column];
                let factor = m[row][column] / pivot[column];
                for (value, above) in m[row].iter_mut().zip(pivot).skip(column) {
                    *value -= factor * above;
                }
            }
        }
    }
    let h: [f64; 8] = std::array::from_fn(|i| m[i][8] / m[i][i]);
    DMat3::from_cols_array(&[h[0], h[3], h[6], h[1], h[4], h[7], h[2], h[5], 1.0])
}

fn apply(h: &Homography, p: DVec2) -> DVec2 {
    h.apply(p).expect("inside")
}

/// The corners of a parallelogram in space, all in front, with screen positions and 1/z.
fn planar_quad() -> impl Strategy<Value = ([DVec2; 4], [f64; 4])> {
    (point3(2.0), point3(1.5), point3(1.5), 2.5..6.0f64).prop_filter_map(
        "behind, thin or edge-on",
        |(o, u, v, far)| {
            let o = o + DVec3::Z * far;
            let points = SQUARE.map(|c| o + u * c.x + v * c.y);
            let screen = points.map(|p| p.truncate() / p.z);
            let turns = |i: usize| {
                (screen[i] - screen[(i + 3) % 4]).perp_dot(screen[(i + 1) % 4] - screen[i])
            };
            (points.iter().all(|p| p.z > 0.3) && (0..4).all(|i| turns(i).abs() > 0.01))
                .then(|| (screen, points.map(|p| 1.0 / p.z)))
        },
    )
}

/// uv at a screen point of the quad, cut along the diagonal 0-2 or 1-3. None outside the triangles tried.
fn through_diagonal(
    screen: [DVec2; 4],
    inv_w: [f64; 4],
    x: DVec2,
    other: bool,
    affine: bool,
) -> DVec2 {
    let halves = if other {
        [[1, 2, 3], [3, 0, 1]]
    } else {
        [[0, 1, 2], [2, 3, 0]]
    };
    let inside = |t: [usize; 3]| {
        bary::screen(t.map(|i| screen[i]), x).filter(|l| l.iter().all(|l| *l >= -1e-12))
    };
    let (triangle, l) = halves
        .into_iter()
        .find_map(|t| Some((t, inside(t)?)))
        .expect("inside the quad");
    let b = if affine {
        l
    } else {
        bary::perspective(l, triangle.map(|i| inv_w[i])).expect("in front")
    };
    DVec2::new(
        bary::blend(b, triangle.map(|i| SQUARE[i].x)),
        bary::blend(b, triangle.map(|i| SQUARE[i].y)),
    )
}

proptest! {
    #![proptest_config(config())]

    /// Property 15: a planar quad looks the same whichever diagonal cuts it. Affine does not, unless it faces the eye.
    #[test]
    fn the_diagonal_does_not_show((screen, inv_w) in planar_quad(), at in (0.05..0.95, 0.05..0.95)) {
        let h = Homography::from_square(screen).expect("convex");
        let x = apply(&h, DVec2::from(at));
        let (a, b) = (through_diagonal(screen, inv_w, x, false, false), through_diagonal(screen, inv_w, x, true, false));
        prop_assert!((a - b).abs().max_element() <= 1e-12, "{a} {b}");
        prop_assert!((a - DVec2::from(at)).abs().max_element() <= 1e-11);
        // Near the crossing of the diagonals the two affine pictures differ most.
        let x = apply(&h, DVec2::splat(0.5));
        let (a, b) = (through_diagonal(screen, inv_w, x, false, true), through_diagonal(screen, inv_w, x, true, true));
        let parallelogram = (screen[0] - screen[1] + screen[2] - screen[3]).length();
        if parallelogram > 0.05 {
            prop_assert!((a - b).length() > 1e-4, "{a} {b} {parallelogram}");
        } else if parallelogram < 1e-12 {
            prop_assert!((a - b).length() < 1e-9);
        }
    }

    /// Property 16: corners, round trip, composition, the general solve, lines, cross ratio.
    #[test]
    fn homographies_from_four_points(from in convex_quad(), to in convex_quad(), other in convex_quad(), at in (0.0..=1.0, 0.0..=1.0)) {
        let square = Homography::from_square(to).expect("convex");
        let h = Homography::from_quads(from, to).expect("convex");
        for i in 0..4 {
            prop_assert!((apply(&square, SQUARE[i]) - to[i]).length() <= 1e-13 * 5.0);
            prop_assert!((apply(&h, from[i]) - to[i]).length() <= 1e-11);
        }
        let p = apply(&Homography::from_square(from).expect("convex"), DVec2::from(at));
        prop_assert!((apply(&h.inverse(), apply(&h, p)) - p).length() <= 1e-11);
        prop_assert!((apply(&h.then(&h.inverse()), p) - p).length() <= 1e-11);
        let onward = Homography::from_quads(to, other).expect("convex");
        prop_assert!((apply(&h.then(&onward), p) - apply(&onward, apply(&h, p))).length() <= 1e-11);
        prop_assert!(h.apply_homogeneous(p).z > 0.0 && h.inverse().apply_homogeneous(apply(&h, p)).z > 0.0);
        let solved = by_linear_solve(from, to) * p.extend(1.0);
        prop_assert!((solved.truncate() / solved.z - apply(&h, p)).length() <= 1e-9);
        let scaled = Homography::from_matrix(h.matrix() * -3.7).expect("regular");
        prop_assert!((apply(&scaled, p) - apply(&h, p)).length() <= 1e-12);
        prop_assert!((scaled.condition() - h.condition()).abs() <= 1e-9 * h.condition());
    }

    /// Property 16: lines stay lines, and four points of one keep their cross ratio.
    #[test]
    fn lines_and_cross_ratios_are_kept(to in convex_quad(), a in (0.0..=1.0, 0.0..=1.0), b in (0.0..=1.0, 0.0..=1.0), s in [0.1..0.4f64, 0.5..0.9f64]) {
        let h = Homography::from_square(to).expect("convex");
        let (a, b) = (DVec2::from(a), DVec2::from(b));
        prop_assume!((b - a).length() > 0.2);
        let t = [0.0, s[0], s[1], 1.0];
        let q = t.map(|t| apply(&h, a + (b - a) * t));
        let along = q[3] - q[0];
        for p in q {
            prop_assert!((p - q[0]).perp_dot(along).abs() <= 1e-11);
        }
        let cross = |x: [f64; 4]| (x[2] - x[0]) * (x[3] - x[1]) / ((x[2] - x[1]) * (x[3] - x[0]));
        let seen = cross(q.map(|p| (p - q[0]).dot(along)));
        prop_assert!((seen - cross(t)).abs() <= 1e-9 * cross(t).abs());
    }

    /// Property 17: the planes of u/w, v/w, 1/w of a triangle are the rows of the homography back to the texture; the quad's
    /// centre is not its bilinear centre.
    #[test]
    fn planes_are_the_rows_of_a_homography((screen, inv_w) in planar_quad(), at in (0.05..0.95, 0.05..0.95)) {
        let h = Homography::from_square(screen).expect("convex");
        let setup = PlaneSetup::new([screen[0], screen[1], screen[2]]).expect("area");
        let row = |a: [f64; 3]| {
            let plane = setup.plane(std::array::from_fn(|i| a[i] * inv_w[i]));
            DVec3::new(plane.dx, plane.dy, plane.at(0.0, 0.0))
        };
        let corners = [SQUARE[0], SQUARE[1], SQUARE[2]];
        let rows = [row(corners.map(|c| c.x)), row(corners.map(|c| c.y)), row([1.0; 3])];
        let back = Homography::from_matrix(DMat3::from_cols(rows[0], rows[1], rows[2]).transpose()).expect("regular");
        let x = apply(&h, DVec2::from(at));
        let scale = 1.0 + h.condition() * 1e-2;
        prop_assert!((apply(&back, x) - apply(&h.inverse(), x)).length() <= 1e-12 * scale);
        prop_assert!((apply(&back, x) - DVec2::from(at)).length() <= 1e-12 * scale);
        let bilinear = (screen[0] + screen[1] + screen[2] + screen[3]) / 4.0;
        if (screen[0] - screen[1] + screen[2] - screen[3]).length() > 0.05 {
            prop_assert!((apply(&h, DVec2::splat(0.5)) - bilinear).length() > 1e-4);
        }
    }
}

#[test]
fn bad_quads_are_refused() {
    let quad = |p: [(f64, f64); 4]| Homography::from_square(p.map(DVec2::from));
    assert!(matches!(
        quad([(0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (0.0, 1.0)]),
        Err(HomographyError::Collinear { corner: 1, .. })
    ));
    assert!(matches!(
        quad([(0.0, 0.0), (1.0, 1e-12), (2.0, 0.0), (0.0, 1.0)]),
        Err(HomographyError::Collinear { corner: 1, .. })
    ));
    assert!(matches!(
        quad([(0.0, 0.0), (1.0, 0.0), (0.25, 0.25), (0.0, 1.0)]),
        Err(HomographyError::NotConvex { corner: 2 })
    ));
    // The bow tie: two corners in the wrong order.
    assert!(matches!(
        quad([(0.0, 0.0), (1.0, 1.0), (1.0, 0.0), (0.0, 1.0)]),
        Err(HomographyError::NotConvex { .. })
    ));
    assert!(matches!(
        quad([(3.0, 3.0); 4]),
        Err(HomographyError::Collinear { .. })
    ));
    assert!(matches!(
        quad([(0.0, 0.0), (1.0, 0.0), (1.0, f64::NAN), (0.0, 1.0)]),
        Err(HomographyError::NonFinite)
    ));
    assert!(
        matches!(
            quad([(-1e308, 0.0), (1e308, 0.0), (1e308, 1e308), (0.0, 1e308)]),
            Err(HomographyError::Collinear { .. })
        ),
        "overflow"
    );
    // Size and position alone are no reason.
    quad([
        (5.0, 5.0),
        (5.0 + 1e-5, 5.0),
        (5.0 + 1e-5, 5.0 + 1e-5),
        (5.0, 5.0 + 1e-5),
    ])
    .expect("a small square");
    quad([(0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.0)]).expect("mirrored");
    assert!(matches!(
        Homography::from_matrix(DMat3::ZERO),
        Err(HomographyError::Singular { .. })
    ));
    let rank_two = DMat3::from_cols(DVec3::X, DVec3::Y, DVec3::X + DVec3::Y);
    assert!(matches!(
        Homography::from_matrix(rank_two),
        Err(HomographyError::Singular { .. })
    ));
    assert_eq!(
        Homography::from_matrix(DMat3::IDENTITY * f64::NAN),
        Err(HomographyError::NonFinite)
    );
    assert!((Homography::IDENTITY.condition() - 3.0).abs() < 1e-12);
}

#[test]
fn the_vanishing_line_has_no_image() {
    let h = Homography::from_matrix(DMat3::from_cols(
        DVec3::new(1.0, 0.0, 1.0),
        DVec3::Y,
        DVec3::Z,
    ))
    .expect("regular");
    assert_eq!(h.apply(DVec2::new(-1.0, 0.3)), None);
    assert!(h.apply(DVec2::new(-0.999, 0.3)).is_some());
}

/// The scale of a matrix means nothing, nor does the size of a quad, however large or small.
#[test]
fn homographies_of_any_size() {
    let plain = Homography::from_matrix(DMat3::from_cols_array(&[
        2.0, 0.1, 0.01, -0.3, 1.5, 0.02, 4.0, -1.0, 1.0,
    ]))
    .expect("regular");
    let at = DVec2::new(2.0, 3.0);
    for scale in [1e-200, -1e-120, 1e120, -1e200] {
        let h = Homography::from_matrix(plain.matrix() * scale).expect("regular");
        for (got, right) in [
            (h.inverse().apply(at), plain.inverse().apply(at)),
            (h.then(&h).apply(at), plain.then(&plain).apply(at)),
        ] {
            let off = got.expect("finite") - right.expect("finite");
            assert!(off.length() < 1e-12, "{scale}: {off}");
        }
        // W is above 0 where it was.
        let w = |h: &Homography| h.apply_homogeneous(at).z.signum();
        let (image, back) = (h.apply(at).expect("finite"), h.inverse());
        assert_eq!(back.apply_homogeneous(image).z.signum(), w(&h), "{scale}");
    }
    let square = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(DVec2::from);
    for side in [1e-170, 1e-100, 1.0, 1e155, 1e300] {
        let h = Homography::from_square(square.map(|p| p * side)).expect("a square");
        let middle = h.apply(DVec2::splat(0.5)).expect("finite");
        assert!(
            (middle / side - DVec2::splat(0.5)).length() < 1e-12,
            "{side}"
        );
        let flat = [square[0], square[1], square[1] * 0.5, square[3]].map(|p| p * side);
        assert!(Homography::from_square(flat).is_err(), "{side}");
    }
}

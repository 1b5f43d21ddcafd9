//! Interpolation along a span, and what affine interpolation gets wrong.

use proptest::prelude::*;
use texmap_math::affine_error::{
    error_at, max_error, max_error_at, screen_subdivision_bound, screen_subdivision_error,
    screen_subdivisions_for, world_subdivision_bound, world_subdivision_error,
    world_subdivisions_for,
};
use texmap_math::camera::Camera;
use texmap_math::glam::{DVec2, DVec3};
use texmap_math::interpolation::{
    Premultiplied, lerp_two_product, perspective, screen_from_world_inv_w, screen_from_world_z,
    world_from_screen_inv_w, world_from_screen_z,
};

use crate::strategies::{EPS32, EPS64, config, inverse_w, largest, point2, point3};

/// `a + t (b - a)` after premultiplication: the form that loses digits, in f32.
fn perspective_difference_form(a: f32, wa: f32, b: f32, wb: f32, t: f32) -> f32 {
    let (ua, ub) = (a * wa, b * wb);
    (ua + t * (ub - ua)) / (wa + t * (wb - wa))
}

fn perspective_f32(a: f32, wa: f32, b: f32, wb: f32, t: f32) -> f32 {
    perspective([a], wa, [b], wb, t)[0]
}

/// The exact value for f32 inputs, near enough.
fn perspective_exact(a: f32, wa: f32, b: f32, wb: f32, t: f32) -> f64 {
    perspective(
        [f64::from(a)],
        f64::from(wa),
        [f64::from(b)],
        f64::from(wb),
        f64::from(t),
    )[0]
}

proptest! {
    #![proptest_config(config())]

    /// Property 1: even steps on the screen are the projection of uneven steps in space.
    #[test]
    fn screen_steps_are_projected_space_steps(
        a in point2(5.0), b in point2(5.0), z1 in inverse_w(5.0), z2 in inverse_w(5.0), t in 0.0..=1.0,
    ) {
        let (p1, p2) = (a / z1, b / z2);
        let s = world_from_screen_z(t, z1, z2);
        let seen = DVec2::new(lerp_two_product(a.x, b.x, s), lerp_two_product(a.y, b.y, s)) / lerp_two_product(z1, z2, s);
        let want = p1 + (p2 - p1) * t;
        let size = largest(&[p1.x, p1.y, p2.x, p2.y]);
        prop_assert!((seen - want).abs().max_element() <= 1e-12 * size, "{seen} {want}");
    }

    /// Property 2: ends, order, both forms, the inverse, and the span read from its other end.
    #[test]
    fn s_runs_from_zero_to_one(w1 in inverse_w(7.0), w2 in inverse_w(7.0), t in 0.0..0.999f64, rest in 0.01..=1.0f64) {
        prop_assert_eq!(world_from_screen_inv_w(0.0, w1, w2), 0.0);
        prop_assert_eq!(world_from_screen_inv_w(1.0, w1, w2), 1.0);
        prop_assert_eq!(world_from_screen_z(1.0, w1, w2), 1.0);
        prop_assert_eq!(screen_from_world_inv_w(1.0, w1, w2), 1.0);
        let s = world_from_screen_inv_w(t, w1, w2);
        prop_assert!((0.0..=1.0).contains(&s));
        prop_assert!(world_from_screen_inv_w(t + (1.0 - t) * rest, w1, w2) > s);
        // The division 1/w itself rounds: twice 4 ulp.
        prop_assert!((world_from_screen_z(t, 1.0 / w1, 1.0 / w2) - s).abs() <= 4.0 * EPS64 * s);
        prop_assert!((s + world_from_screen_inv_w(1.0 - t, w2, w1) - 1.0).abs() <= 4.0 * EPS64);
        // One ulp of s is r ulps of t at the steep end.
        let r = (w1 / w2).max(w2 / w1);
        prop_assert!((screen_from_world_inv_w(s, w1, w2) - t).abs() <= 4.0 * EPS64 * r);
        prop_assert!((screen_from_world_z(s, 1.0 / w1, 1.0 / w2) - t).abs() <= 8.0 * EPS64 * r);
    }

    /// Property 3 in f64: the premultiplied form is interpolation by s, for several attributes at once.
    #[test]
    fn premultiplied_is_interpolation_in_space(
        a in point3(10.0), b in point3(10.0), w1 in inverse_w(5.0), w2 in inverse_w(5.0), t in 0.0..=1.0,
    ) {
        let got = DVec3::from(perspective(a.to_array(), w1, b.to_array(), w2, t));
        let want = a + (b - a) * world_from_screen_inv_w(t, w1, w2);
        prop_assert!((got - want).abs().max_element() <= 1e-12 * 10.0);
        let half = Premultiplied::new(a.to_array(), w1).lerp(&Premultiplied::new(b.to_array(), w2), t);
        prop_assert_eq!(half.divide(), got.to_array());
    }

    /// Properties 3 and 4 in f32: within 4 units of rounding, ratio up to 1000, and so never further outside its ends.
    #[test]
    fn two_products_keep_their_digits_in_f32(
        a in -1024.0f32..1024.0, b in -1024.0f32..1024.0, w in inverse_w(2.0), r in 0.0..3.0, t in 0.0f32..=1.0,
    ) {
        let (wa, wb) = (w as f32, (w * 10f64.powf(r)) as f32);
        let size = f64::from(a.abs().max(b.abs()));
        let got = f64::from(perspective_f32(a, wa, b, wb, t));
        prop_assert!((got - perspective_exact(a, wa, b, wb, t)).abs() <= 4.0 * EPS32 * size);
        let slack = 4.0 * EPS32 * size;
        prop_assert!(got >= f64::from(a.min(b)) - slack && got <= f64::from(a.max(b)) + slack);
    }

    /// Property 4 in f64: a value stays between its ends.
    #[test]
    fn values_stay_between_the_ends(a in -10.0..10.0f64, b in -10.0..10.0f64, w1 in inverse_w(7.0), w2 in inverse_w(7.0), t in 0.0..=1.0) {
        let u = perspective([a], w1, [b], w2, t)[0];
        let slack = 4.0 * EPS64 * largest(&[a, b]);
        prop_assert!(u >= a.min(b) - slack && u <= a.max(b) + slack);
    }

    /// Property 5: affine is perspective where 1/w is equal, and only there.
    #[test]
    fn affine_is_right_only_at_one_distance(
        a in -10.0..10.0f64, b in -10.0..10.0f64, w in inverse_w(7.0), r in 0.0151..7.0, t in 0.1..0.9,
    ) {
        let size = largest(&[a, b]);
        let affine = lerp_two_product(a, b, t);
        prop_assert!((perspective([a], w, [b], w, t)[0] - affine).abs() <= 4.0 * EPS64 * size);
        prop_assume!((a - b).abs() > 0.1 * size);
        prop_assert!((perspective([a], w, [b], w * f64::exp2(r), t)[0] - affine).abs() > 1e-6 * size);
    }

    /// Property 20: 1/w and depth are linear on the screen, the distance itself is not.
    #[test]
    fn depth_is_linear_on_the_screen(
        a in point2(1.0), b in point2(1.0), z1 in inverse_w(4.0), z2 in inverse_w(4.0), t in 0.0..=1.0, infinite: bool,
    ) {
        let far = if infinite { f64::INFINITY } else { 100.0 };
        let camera = Camera { eye: DVec3::ZERO, look: DVec3::NEG_Z, up: DVec3::Y, fov_x: 1.0, near: 0.01, far };
        let clip = camera.clip_from_world(1.5).expect("a good camera");
        let (p, q) = ((a * z1).extend(-z1), (b * z2).extend(-z2));
        let s = world_from_screen_z(t, z1, z2);
        let [p, q, m] = [p, q, p + (q - p) * s].map(|v| clip * v.extend(1.0));
        let depth = |v: texmap_math::glam::DVec4| v.z / v.w;
        prop_assert!((depth(m) - lerp_two_product(depth(p), depth(q), t)).abs() <= 1e-12);
        prop_assert!((1.0 / m.w - lerp_two_product(1.0 / p.w, 1.0 / q.w, t)).abs() <= 1e-12 * (1.0 / p.w).max(1.0 / q.w));
        // Distance interpolated on the screen is too large by this factor.
        let r = z2 / z1;
        let factor = 1.0 + t * (1.0 - t) * (r - 1.0) * (r - 1.0) / r;
        prop_assert!((lerp_two_product(p.w, q.w, t) / m.w - factor).abs() <= 1e-11 * factor);
    }

    /// Property 6: the closed form is reached where it says, and never passed.
    #[test]
    fn the_largest_error_has_a_closed_form(w in inverse_w(7.0), t in 0.0..=1.0, x in 0.0..0.01f64) {
        let max = max_error(w);
        prop_assert!((error_at(max_error_at(w), w).abs() - max).abs() <= 1e-14);
        prop_assert!(error_at(t, w).abs() <= max + 1e-14);
        let direct = world_from_screen_inv_w(t, 1.0, w) - t;
        prop_assert!((error_at(t, w) - direct).abs() <= 1e-13);
        // In space the largest error lies at 1 - t.
        let s = world_from_screen_inv_w(max_error_at(w), 1.0, w);
        prop_assert!((s - (1.0 - max_error_at(w))).abs() <= 1e-14);
        // Near 1 the form keeps its digits: (r - 1)/4 to first order.
        prop_assert!((max_error(1.0 + x) - 0.25 * x).abs() <= 0.13 * x * x);
    }

    /// Property 7: n parts of the screen or of space, part by part.
    #[test]
    fn parts_have_their_closed_forms(r in inverse_w(6.0), n in 1u32..200) {
        let part = |i: u32| f64::from(i) / f64::from(n);
        let w = |t: f64| lerp_two_product(1.0, r, t);
        let screen = (0..n).map(|i| {
            let (t0, t1) = (part(i), part(i + 1));
            (world_from_screen_inv_w(t1, 1.0, r) - world_from_screen_inv_w(t0, 1.0, r)) * max_error(w(t1) / w(t0))
        });
        let worst = screen.fold(0.0, f64::max);
        let closed = screen_subdivision_error(r, n);
        prop_assert!((worst - closed).abs() <= 1e-9 * closed.max(1e-3), "{worst} {closed}");
        prop_assert!(closed <= screen_subdivision_bound(r, n) * (1.0 + 1e-12));
        let worst = (0..n).map(|i| max_error(w(part(i + 1)) / w(part(i))) / f64::from(n)).fold(0.0, f64::max);
        let closed = world_subdivision_error(r, n);
        prop_assert!((worst - closed).abs() <= 1e-9 * closed.max(1e-3), "{worst} {closed}");
        prop_assert!(closed <= world_subdivision_bound(r, n) * (1.0 + 1e-12));
        prop_assert!(closed <= screen_subdivision_error(r, n) * (1.0 + 1e-12), "space parts are never worse");
    }

    /// The smallest n that meets a budget: one less does not.
    #[test]
    fn the_fewest_parts_are_the_fewest(r in inverse_w(6.0), change in 1.0..4096.0, budget in 0.01..2.0) {
        for (parts, error) in [
            (screen_subdivisions_for(r, change, budget), screen_subdivision_error as fn(f64, u32) -> f64),
            (world_subdivisions_for(r, change, budget), world_subdivision_error),
        ] {
            let n = parts.expect("a budget that can be met");
            prop_assert!(error(r, n) * change <= budget);
            prop_assert!(n == 1 || error(r, n - 1) * change > budget);
        }
    }
}

/// Property 3, negative: the difference form loses what the two products keep, the more the larger the ratio.
#[test]
fn the_difference_form_loses_digits() {
    for (r, least) in [(100.0f32, 20.0), (1000.0, 100.0)] {
        let worst = (0..200_000).fold(0.0, |worst: f64, i| {
            let t = (i as f32 * 0.618_034).fract();
            let (a, b) = (
                1024.0 * (i as f32 * 0.754_877_7).fract(),
                1024.0 * (i as f32 * 0.569_840_3).fract(),
            );
            let error = f64::from(perspective_difference_form(a, r, b, 1.0, t))
                - perspective_exact(a, r, b, 1.0, t);
            worst.max(error.abs() / (EPS32 * 1024.0))
        });
        assert!(worst > least, "ratio {r}: only {worst} units lost");
    }
}

/// Property 6 by 10,000 samples, and the published values of both closed forms.
#[test]
fn samples_reach_the_closed_form() {
    for (r, t, error) in [
        (2.0, 0.4142, 0.1716),
        (4.0, 1.0 / 3.0, 1.0 / 3.0),
        (10.0, 0.2403, 0.5195),
        (16.0, 0.2, 0.6),
        (100.0, 1.0 / 11.0, 9.0 / 11.0),
    ] {
        assert!((max_error(r) - error).abs() < 5e-5 && (max_error_at(r) - t).abs() < 5e-5);
        let sampled = (0..=10_000)
            .map(|i| error_at(f64::from(i) / 10_000.0, r).abs())
            .fold(0.0, f64::max);
        assert!(max_error(r) - sampled < 1e-6);
    }
    for (r, n, error) in [
        (2.0, 1, 0.17157),
        (2.0, 2, 0.06735),
        (2.0, 4, 0.02229),
        (2.0, 8, 0.00654),
        (10.0, 16, 0.04444),
    ] {
        assert!(
            (screen_subdivision_error(r, n) - error).abs() < 5e-6,
            "{r} {n}"
        );
    }
    assert_eq!(screen_subdivisions_for(2.0, 256.0, 0.5), Some(16));
    assert_eq!(screen_subdivisions_for(4.0, 256.0, 0.5), Some(37));
    // The error falls with the square of n.
    assert!(
        (screen_subdivision_error(4.0, 512) / screen_subdivision_error(4.0, 1024) - 4.0).abs()
            < 0.05
    );
}

#[test]
fn budgets_that_cannot_be_met_have_no_answer() {
    for (r, change, budget) in [
        (2.0, 1.0, 0.0),
        (2.0, 1.0, -1.0),
        (2.0, 1.0, f64::NAN),
        (f64::NAN, 1.0, 1.0),
        (2.0, f64::INFINITY, 1.0),
        (-1.0, 1.0, 1.0),
        (1e300, 1e300, 1e-300),
    ] {
        assert_eq!(screen_subdivisions_for(r, change, budget), None);
        assert_eq!(world_subdivisions_for(r, change, budget), None);
    }
    assert_eq!(screen_subdivisions_for(1.0, 1e6, 1e-9), Some(1));
}

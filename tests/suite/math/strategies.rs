//! Generators that the laws share. Preconditions are met by rejecting inputs, never by looser tolerances.

use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use texmap_math::glam::{DVec2, DVec3};

/// One unit of rounding of f32.
pub(crate) const EPS32: f64 = 1.0 / 8_388_608.0;
/// One unit of rounding of f64.
pub(crate) const EPS64: f64 = f64::EPSILON;

/// The same cases in every run; `PROPTEST_RNG_SEED` and `PROPTEST_CASES` choose others.
pub(crate) fn config() -> ProptestConfig {
    let config = ProptestConfig {
        failure_persistence: None,
        max_global_rejects: 1_000_000,
        ..ProptestConfig::default()
    };
    if matches!(config.rng_seed, RngSeed::Random) {
        return ProptestConfig {
            rng_seed: RngSeed::Fixed(6_837),
            ..config
        };
    }
    config
}

/// 1/w, log-uniform in [2^-exponent, 2^exponent].
pub(crate) fn inverse_w(exponent: f64) -> impl Strategy<Value = f64> {
    (-exponent..exponent).prop_map(f64::exp2)
}

pub(crate) fn point2(size: f64) -> impl Strategy<Value = DVec2> {
    (-size..size, -size..size).prop_map(DVec2::from)
}

pub(crate) fn point3(size: f64) -> impl Strategy<Value = DVec3> {
    (-size..size, -size..size, -size..size).prop_map(DVec3::from)
}

pub(crate) fn unit3() -> impl Strategy<Value = DVec3> {
    point3(1.0)
        .prop_filter("too short for a direction", |v| v.length() > 0.1)
        .prop_map(DVec3::normalize)
}

/// Twice the area, without its sign.
pub(crate) fn area2(p: [DVec2; 3]) -> f64 {
    (p[1] - p[0]).perp_dot(p[2] - p[0]).abs()
}

/// A triangle on the screen with coordinates up to `size` and an area of at least `area`.
pub(crate) fn triangle(size: f64, area: f64) -> impl Strategy<Value = [DVec2; 3]> {
    [point2(size), point2(size), point2(size)]
        .prop_filter("too thin", move |p| area2(*p) >= 2.0 * area)
}

/// Weights of a point inside a triangle, at least 0.02 from its edges.
pub(crate) fn weights() -> impl Strategy<Value = [f64; 3]> {
    (0.02..0.96, 0.0..1.0).prop_filter_map("near an edge", |(a, s): (f64, f64)| {
        let b = (1.0 - a) * s;
        let c = 1.0 - a - b;
        (b > 0.02 && c > 0.02).then_some([a, b, c])
    })
}

/// The point of a triangle with these weights.
pub(crate) fn at(p: [DVec2; 3], l: [f64; 3]) -> DVec2 {
    p[0] * l[0] + p[1] * l[1] + p[2] * l[2]
}

pub(crate) fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |m: f64, v| m.max(v.abs()))
}

//! Texel choice and tiling (properties 21 and 22).

use proptest::prelude::*;
use texmap_math::float::{fract, fract_f32};
use texmap_math::wrap::{texel, tile};

use crate::strategies::config;

/// The lecture's loop, one step per repeat.
fn tile_by_steps(mut value: i64, size: i64) -> i64 {
    while value < 0 {
        value += size;
    }
    while value >= size {
        value -= size;
    }
    value
}

proptest! {
    #![proptest_config(config())]

    #[test]
    fn tiling_is_the_floored_remainder(value in -100_000..100_000i32, size in 1..5000i32, repeats in -1000..1000i32) {
        let t = tile(value, size).expect("a size");
        prop_assert!((0..size).contains(&t));
        prop_assert_eq!(i64::from(t), tile_by_steps(i64::from(value), i64::from(size)));
        prop_assert_eq!(tile(value.wrapping_add(repeats.wrapping_mul(size)), size), Some(t));
    }

    /// Each texel is one unit wide, also below zero; truncation makes texel 0 two units wide.
    #[test]
    fn floor_gives_every_texel_its_width(k in -1000..1000i32, size in 1..512u32, inside in 1e-9..(1.0 - 1e-9)) {
        let n = f64::from(size);
        prop_assert_eq!(texel((f64::from(k) + inside) / n, size), k);
        // Exactly on the border, where k/n*n is exact.
        let n = size.next_power_of_two();
        prop_assert_eq!(texel(f64::from(k) / f64::from(n), n), k);
        let truncated = ((f64::from(k) + inside) / f64::from(size) * f64::from(size)) as i32;
        prop_assert_eq!(truncated == k, k >= 0, "truncation is right for positive coordinates only");
    }

    #[test]
    fn fractions_lie_in_the_unit_interval(x in any::<f64>(), y in any::<f32>()) {
        prop_assume!(x.is_finite() && y.is_finite());
        prop_assert!((0.0..1.0).contains(&fract(x)) && (0.0..1.0).contains(&fract_f32(y)));
    }
}

#[test]
fn ends_and_errors() {
    for size in [1, 2, 3, 64, 1000, i32::MAX] {
        for value in [i32::MIN, i32::MIN + 1, -1, 0, 1, i32::MAX - 1, i32::MAX] {
            assert_eq!(
                i64::from(tile(value, size).expect("a size")),
                i64::from(value).rem_euclid(i64::from(size))
            );
        }
    }
    for size in [0, -1, -64, i32::MIN] {
        assert_eq!(tile(5, size), None);
    }
    // The remainder of f64 leaves [0, 1): the trap that `fract` closes.
    assert_eq!((-1e-17f64).rem_euclid(1.0), 1.0);
    assert_eq!(fract(-1e-17), 0.0);
    assert_eq!(texel(f64::NAN, 64), 0);
    assert_eq!(texel(1e30, 64), i32::MAX);
    assert_eq!(texel(f64::NEG_INFINITY, 64), i32::MIN);
    // (1, 1) of a 200 x 100 texture is texel (200, 100): out of range by one, to be wrapped or clamped by name.
    assert_eq!(
        (texel(0.7, 200), texel(0.45, 100), texel(1.0, 200)),
        (140, 45, 200)
    );
}

//! The f32 functions: lanes equal the scalars on every level, and the error against f64 stays within the stated bound.

use texmap_math::deterministic_f32::{self, MAX_ULPS};
use texmap_math::dispatch_simd;
use texmap_math::simd::{Isa, prelude::*};
use texmap_tests::levels::levels;

/// Values at which formulas break: zeros, subnormals, the ends of each range, reduction limits, whole and half numbers.
const HARD: [f32; 56] = [
    0.0,
    -0.0,
    1e-45,
    -1e-45,
    1.1754942e-38,
    1.1754944e-38,
    -1.1754944e-38,
    1e-30,
    -1e-20,
    0.25,
    0.414_213_57,
    0.414_213_54,
    0.5,
    -0.5,
    0.707_106_77,
    std::f32::consts::FRAC_1_SQRT_2,
    std::f32::consts::FRAC_PI_4,
    0.999_999_94,
    -0.999_999_94,
    1.0,
    -1.0,
    1.000_000_1,
    -1.000_000_1,
    std::f32::consts::SQRT_2,
    1.5,
    -1.5,
    std::f32::consts::FRAC_PI_2,
    1.570_796_4,
    2.0,
    -2.0,
    2.5,
    3.0,
    -3.0,
    std::f32::consts::PI,
    -std::f32::consts::PI,
    7.0,
    127.5,
    128.0,
    -126.0,
    -126.5,
    -149.0,
    -149.5,
    -150.5,
    1000.0,
    1_599_999.9,
    1_600_000.1,
    8_388_607.5,
    8_388_609.0,
    16_777_215.0,
    -16_777_217.0,
    1e10,
    3.402_823_5e38,
    -3.402_823_5e38,
    f32::INFINITY,
    f32::NEG_INFINITY,
    f32::NAN,
];

/// All bit patterns with this stride: about 1 million values.
const STRIDE: usize = 4_099;

type Scalar1 = fn(f32) -> f32;
type Oracle1 = fn(f64) -> f64;

const ONE_ARGUMENT: [(&str, Scalar1, Oracle1); 10] = [
    ("sin", deterministic_f32::sin, f64::sin),
    ("cos", deterministic_f32::cos, f64::cos),
    ("tan", deterministic_f32::tan, f64::tan),
    ("asin", deterministic_f32::asin, f64::asin),
    ("acos", deterministic_f32::acos, f64::acos),
    ("atan", deterministic_f32::atan, f64::atan),
    ("exp", deterministic_f32::exp, f64::exp),
    ("exp2", deterministic_f32::exp2, f64::exp2),
    ("ln", deterministic_f32::ln, f64::ln),
    ("log2", deterministic_f32::log2, f64::log2),
];

/// Distance in units in the last place of f32 at the exact value. Infinite where one is NaN or infinite and the other is not.
fn ulps(got: f32, exact: f64) -> f64 {
    let rounded = exact as f32;
    if got.to_bits() == rounded.to_bits() || (got.is_nan() && exact.is_nan()) {
        return 0.0;
    }
    if !got.is_finite() || !rounded.is_finite() {
        return f64::INFINITY;
    }
    let size = rounded.abs();
    let ulp = if size < f32::MIN_POSITIVE {
        f64::from(f32::from_bits(1))
    } else {
        f64::from(size.next_up()) - f64::from(size)
    };
    (f64::from(got) - exact).abs() / ulp
}

fn worst(f: Scalar1, oracle: Oracle1, values: impl Iterator<Item = f32>) -> (f64, f32) {
    values.fold((0.0, 0.0), |worst, x| {
        let e = ulps(f(x), oracle(f64::from(x)));
        if e > worst.0 { (e, x) } else { worst }
    })
}

fn patterns(stride: usize) -> impl Iterator<Item = f32> {
    (0..=u32::MAX).step_by(stride).map(f32::from_bits)
}

#[test]
fn errors_stay_within_the_stated_bound() {
    for (name, f, oracle) in ONE_ARGUMENT {
        let (e, at) = worst(f, oracle, patterns(STRIDE).chain(HARD));
        assert!(
            e <= MAX_ULPS,
            "{name}({at:e}) = {:e} is off by {e} ulp",
            f(at)
        );
    }
    let mut state = 1u64;
    let (mut worst_atan2, mut worst_pow) = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0));
    let mut check = |x: f32, y: f32| {
        let e = ulps(
            deterministic_f32::atan2(x, y),
            f64::from(x).atan2(f64::from(y)),
        );
        if e > worst_atan2.0 {
            worst_atan2 = (e, x, y);
        }
        let e = ulps(
            deterministic_f32::pow(x, y),
            f64::from(x).powf(f64::from(y)),
        );
        if e > worst_pow.0 {
            worst_pow = (e, x, y);
        }
    };
    for x in HARD {
        for y in HARD {
            check(x, y);
        }
    }
    for _ in 0..500_000 {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        let (a, b) = (
            (state >> 40) as f32 / 16_777_216.0,
            (state >> 16) as u16 as f32 / 65_536.0,
        );
        check(a, b);
        check(a * 2.0, (b - 0.5) * 200.0);
        check(a * 1e6, (b - 0.5) * 10.0);
    }
    assert!(worst_atan2.0 <= MAX_ULPS, "atan2: {worst_atan2:?}");
    assert!(worst_pow.0 <= MAX_ULPS, "pow: {worst_pow:?}");
}

/// `cargo test --release -p texmap-tests --test math exhaustive -- --ignored --nocapture`, some minutes.
#[test]
#[ignore = "all 2^32 values of ten functions take minutes"]
fn exhaustive() {
    for (name, f, oracle) in ONE_ARGUMENT {
        let (e, at) = worst(f, oracle, patterns(1));
        eprintln!("{name}: {e:.6} ulp at {at:e}");
        assert!(
            e <= MAX_ULPS,
            "{name}({at:e}) = {:e} is off by {e} ulp",
            f(at)
        );
    }
}

#[inline(always)]
fn one_argument<I: Isa>(i: I, x: &[f32; 16]) -> [[f32; 16]; 7] {
    let mut out = [[0.0; 16]; 7];
    for at in (0..16).step_by(I::LANES) {
        let x = i.load_f32(&x[at..]);
        let results = [
            deterministic_f32::sin_lanes(i, x),
            deterministic_f32::cos_lanes(i, x),
            deterministic_f32::asin_lanes(i, x),
            deterministic_f32::cos_lanes(i, x * 3.0),
            deterministic_f32::exp2_lanes(i, x),
            deterministic_f32::log2_lanes(i, x),
            deterministic_f32::sin_lanes(i, x * 0.5),
        ];
        for (out, result) in out.iter_mut().zip(results) {
            result.store(&mut out[at..]);
        }
    }
    out
}

fn one_argument_scalar(x: f32) -> [f32; 7] {
    [
        deterministic_f32::sin(x),
        deterministic_f32::cos(x),
        deterministic_f32::asin(x),
        deterministic_f32::cos(x * 3.0),
        deterministic_f32::exp2(x),
        deterministic_f32::log2(x),
        deterministic_f32::sin(x * 0.5),
    ]
}

#[inline(always)]
fn two_arguments<I: Isa>(i: I, x: &[f32; 16], y: &[f32; 16]) -> [[f32; 16]; 2] {
    let mut out = [[0.0; 16]; 2];
    for at in (0..16).step_by(I::LANES) {
        let (x, y) = (i.load_f32(&x[at..]), i.load_f32(&y[at..]));
        deterministic_f32::atan2_lanes(i, x, y).store(&mut out[0][at..]);
        deterministic_f32::pow_lanes(i, x, y).store(&mut out[1][at..]);
    }
    out
}

fn bits(values: &[f32]) -> Vec<u32> {
    values.iter().map(|x| x.to_bits()).collect()
}

#[test]
fn lanes_equal_scalars_on_every_level() {
    // The large stride is odd, so that all exponents and mantissas mix in one block of sixteen.
    let mut values: Vec<f32> = patterns(150_001)
        .chain(HARD)
        .chain((0..4000).map(|i| (i - 2000) as f32 * 0.01))
        .collect();
    values.resize(values.len().next_multiple_of(16), f32::NAN);
    let turned: Vec<f32> = values.iter().rev().copied().collect();
    for (name, level) in levels() {
        for (x, y) in values
            .as_chunks::<16>()
            .0
            .iter()
            .zip(turned.as_chunks::<16>().0)
        {
            let one = dispatch_simd!(level, i => one_argument(i, x));
            let wide = dispatch_simd!(level, wide i => one_argument(i, x));
            let two = dispatch_simd!(level, i => two_arguments(i, x, y));
            let wide_two = dispatch_simd!(level, wide i => two_arguments(i, x, y));
            assert_eq!(
                bits(one.as_flattened()),
                bits(wide.as_flattened()),
                "{name}, {x:?}"
            );
            assert_eq!(
                bits(two.as_flattened()),
                bits(wide_two.as_flattened()),
                "{name}, {x:?}"
            );
            for i in 0..16 {
                let want = one_argument_scalar(x[i]);
                for (k, want) in want.into_iter().enumerate() {
                    assert_eq!(
                        one[k][i].to_bits(),
                        want.to_bits(),
                        "{name}, function {k} of {:e}",
                        x[i]
                    );
                }
                assert_eq!(
                    two[0][i].to_bits(),
                    deterministic_f32::atan2(x[i], y[i]).to_bits(),
                    "{name}, atan2({:e}, {:e})",
                    x[i],
                    y[i]
                );
                assert_eq!(
                    two[1][i].to_bits(),
                    deterministic_f32::pow(x[i], y[i]).to_bits(),
                    "{name}, pow({:e}, {:e})",
                    x[i],
                    y[i]
                );
            }
        }
    }
    for (name, level) in levels() {
        for x in HARD {
            for y in HARD.as_chunks::<8>().0 {
                let y: [f32; 16] = std::array::from_fn(|i| y[i / 2]);
                let two = dispatch_simd!(level, i => two_arguments(i, &[x; 16], &y));
                for i in 0..16 {
                    assert_eq!(
                        two[0][i].to_bits(),
                        deterministic_f32::atan2(x, y[i]).to_bits(),
                        "{name}, atan2({x:e}, {:e})",
                        y[i]
                    );
                    assert_eq!(
                        two[1][i].to_bits(),
                        deterministic_f32::pow(x, y[i]).to_bits(),
                        "{name}, pow({x:e}, {:e})",
                        y[i]
                    );
                }
            }
        }
    }
}

//! The f64 functions against exact values, the platform's, and the special values of IEEE 754-2019, section 9.2.

use texmap_math::deterministic_f64;

type Function = fn(f64, f64) -> f64;

/// Name, function, the platform's function, stated bound in ulp.
const FUNCTIONS: [(&str, Function, Function, f64); 12] = [
    ("sin", |x, _| deterministic_f64::sin(x), |x, _| x.sin(), 0.8),
    ("cos", |x, _| deterministic_f64::cos(x), |x, _| x.cos(), 0.8),
    ("tan", |x, _| deterministic_f64::tan(x), |x, _| x.tan(), 2.5),
    (
        "asin",
        |x, _| deterministic_f64::asin(x),
        |x, _| x.asin(),
        2.5,
    ),
    (
        "acos",
        |x, _| deterministic_f64::acos(x),
        |x, _| x.acos(),
        2.5,
    ),
    (
        "atan",
        |x, _| deterministic_f64::atan(x),
        |x, _| x.atan(),
        2.0,
    ),
    ("atan2", deterministic_f64::atan2, f64::atan2, 2.0),
    (
        "exp",
        |x, _| deterministic_f64::exp(x),
        |x, _| x.exp(),
        0.75,
    ),
    (
        "exp2",
        |x, _| deterministic_f64::exp2(x),
        |x, _| x.exp2(),
        0.75,
    ),
    ("ln", |x, _| deterministic_f64::ln(x), |x, _| x.ln(), 1.0),
    (
        "log2",
        |x, _| deterministic_f64::log2(x),
        |x, _| x.log2(),
        0.75,
    ),
    ("pow", deterministic_f64::pow, f64::powf, 0.75),
];

/// Signed distance in units in the last place of `b`; 0 for equal numbers and two NaN.
fn ulps(a: f64, b: f64) -> f64 {
    if a == b || (a.is_nan() && b.is_nan()) {
        return 0.0;
    }
    let ulp = (b.abs().next_up() - b.abs()).max(f64::from_bits(1));
    (a - b) / ulp
}

#[test]
fn exact_values_are_met_within_the_stated_bounds() {
    let mut rows = 0;
    for line in include_str!("det_values.txt")
        .lines()
        .filter(|l| !l.starts_with('#'))
    {
        let field: Vec<&str> = line.split(' ').collect();
        let bits =
            |i: usize| f64::from_bits(u64::from_str_radix(field[i], 16).expect("hexadecimal"));
        let (x, y, nearest) = (bits(1), bits(2), bits(3));
        let rest: f64 = field[4].parse().expect("a number");
        let (name, ours, _, bound) = FUNCTIONS
            .iter()
            .find(|f| f.0 == field[0])
            .expect("a function");
        let error = (ulps(ours(x, y), nearest) - rest).abs();
        assert!(
            error <= *bound,
            "{name}({x:e}, {y:e}) is off by {error} ulp"
        );
        rows += 1;
    }
    assert!(rows > 250);
}

/// The platform's functions are within about 1 ulp, so twelve times 200,000 values may differ by one more than the stated bound.
#[test]
fn the_platform_agrees() {
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    let mut next = || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        state
    };
    for (name, ours, platform, bound) in FUNCTIONS {
        for i in 0..200_000 {
            let (a, b) = (next(), next());
            let any = f64::from_bits(a);
            let unit = (b >> 11) as f64 / (1u64 << 53) as f64 * 2.0 - 1.0;
            let (x, y) = match (name, i % 3) {
                ("asin" | "acos", _) => (unit, 0.0),
                ("exp" | "exp2", _) => (unit * 745.0, 0.0),
                ("pow", 0) => (any.abs(), unit * 3.0),
                ("pow", _) => (1.0 + unit, (a >> 40) as f64 * 1e-5 - 80.0),
                (_, 0) => (any, unit),
                (_, 1) => (unit * 1000.0, any),
                _ => (unit, (a >> 11) as f64 / (1u64 << 53) as f64),
            };
            let error = ulps(ours(x, y), platform(x, y)).abs();
            assert!(
                error <= bound + 1.0,
                "{name}({x:e}, {y:e}) = {:e}: {error} ulp",
                ours(x, y)
            );
        }
    }
}

#[test]
fn special_values() {
    let (inf, nan) = (f64::INFINITY, f64::NAN);
    let pi = std::f64::consts::PI;
    let same = |got: f64, want: f64| {
        assert!(
            got.to_bits() == want.to_bits() || (got.is_nan() && want.is_nan()),
            "{got:e}, not {want:e}"
        );
    };
    for f in [
        deterministic_f64::sin,
        deterministic_f64::cos,
        deterministic_f64::tan,
    ] {
        same(f(inf), nan);
        same(f(-inf), nan);
        same(f(nan), nan);
    }
    same(deterministic_f64::sin(-0.0), -0.0);
    same(deterministic_f64::tan(-0.0), -0.0);
    same(deterministic_f64::cos(0.0), 1.0);
    // Every pair of specials, as the platform has them by C's annex F.
    let specials = [
        0.0,
        -0.0,
        1.0,
        -1.0,
        0.5,
        -0.5,
        2.0,
        -2.0,
        3.0,
        -3.0,
        2.5,
        -2.5,
        1e300,
        -1e300,
        5e-324,
        9_007_199_254_740_993.0,
        inf,
        -inf,
        nan,
    ];
    for y in specials {
        for x in specials {
            let (got, want) = (deterministic_f64::atan2(y, x), y.atan2(x));
            assert!(
                ulps(got, want).abs() <= 2.0
                    && (got.is_nan() || got.is_sign_negative() == want.is_sign_negative()),
                "atan2({y}, {x})"
            );
            let (got, want) = (deterministic_f64::pow(x, y), x.powf(y));
            assert!(
                ulps(got, want).abs() <= 1.0
                    && (got.is_nan() || got.is_sign_negative() == want.is_sign_negative()),
                "pow({x}, {y})"
            );
        }
        for f in [
            (
                deterministic_f64::asin as fn(f64) -> f64,
                f64::asin as fn(f64) -> f64,
            ),
            (deterministic_f64::acos, f64::acos),
            (deterministic_f64::exp, f64::exp),
            (deterministic_f64::exp2, f64::exp2),
            (deterministic_f64::ln, f64::ln),
            (deterministic_f64::log2, f64::log2),
        ] {
            assert!(ulps((f.0)(y), (f.1)(y)).abs() <= 2.0, "{y}");
        }
    }
    same(deterministic_f64::atan2(0.0, -0.0), pi);
    same(deterministic_f64::exp(710.0), inf);
    same(deterministic_f64::exp(-746.0), 0.0);
    same(deterministic_f64::exp2(1024.0), inf);
    same(deterministic_f64::exp2(-1074.0), f64::from_bits(1));
    same(deterministic_f64::exp2(-1076.0), 0.0);
    for n in -1074..1024 {
        same(
            deterministic_f64::log2(deterministic_f64::exp2(f64::from(n))),
            f64::from(n),
        );
    }
}

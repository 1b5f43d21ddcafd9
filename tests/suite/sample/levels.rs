//! Mip chains (S4) and level of detail (S7, S9).

use crate::support::{Random, SIZES, random_floats};
use texmap_math::Footprint;
use texmap_sample::{Filter, Lod, Sampler, Texture2d, reference};

fn mean(t: &Texture2d<'_>, level: u32) -> [f64; 4] {
    let (w, h) = t.level_size(level).unwrap();
    let mut sum = [0.0; 4];
    for y in 0..h {
        for x in 0..w {
            let c = t.texel(level, x, y).unwrap();
            for k in 0..4 {
                sum[k] += f64::from(c[k]);
            }
        }
    }
    sum.map(|s| s / f64::from(w * h))
}

/// S4. Area weights: the mean of every level is the mean of the base, at any size.
#[test]
fn every_level_keeps_the_mean() {
    for (width, height) in SIZES {
        let t = random_floats(width, height, 31).with_mips();
        let base = mean(&t, 0);
        let (mut w, mut h) = (width, height);
        for level in 0..t.levels() {
            assert_eq!(t.level_size(level), Some((w, h)));
            for (a, b) in mean(&t, level).into_iter().zip(base) {
                assert!(
                    (a - b).abs() < 1e-6,
                    "{width}x{height} level {level}: {a} {b}"
                );
            }
            (w, h) = ((w / 2).max(1), (h / 2).max(1));
        }
        assert_eq!(t.level_size(t.levels() - 1), Some((1, 1)));
    }
}

/// Negative twin of S4: dropping the odd column moves the mean.
#[test]
fn dropping_the_odd_column_would_be_seen() {
    let t = random_floats(7, 3, 31);
    let kept: f64 = (0..3)
        .flat_map(|y| (0..6).map(move |x| (x, y)))
        .map(|(x, y)| f64::from(t.texel(0, x, y).unwrap()[0]))
        .sum::<f64>()
        / 18.0;
    assert!((kept - mean(&t, 0)[0]).abs() > 1e-3);
}

/// S7. The level is the formula's within 2^-8, sheared or turned.
#[test]
fn levels_follow_the_formula() {
    let t = random_floats(512, 128, 1).with_mips();
    let s = Sampler {
        lod: Lod {
            min: -100.0,
            ..Lod::default()
        },
        ..Sampler::default()
    };
    let mut random = Random::new(77);
    for _ in 0..20_000 {
        let mut d = || random.range(-1.0, 1.0) * 2.0_f32.powi((random.word() % 24) as i32 - 16);
        let d = Footprint {
            du_dx: d(),
            dv_dx: d(),
            du_dy: d(),
            dv_dy: d(),
        };
        let truth = reference::lod(&s, &t, [d.du_dx, d.dv_dx, d.du_dy, d.dv_dy].map(f64::from));
        assert!(
            (f64::from(s.lod(&t, d)) - truth).abs() < 1.0 / 256.0,
            "{d:?}"
        );
    }
}

#[test]
fn bias_and_limits_apply_in_that_order() {
    let t = random_floats(64, 64, 1).with_mips();
    let d = Footprint {
        du_dx: 1.0 / 16.0,
        dv_dx: 0.0,
        du_dy: 0.0,
        dv_dy: 1.0 / 16.0,
    };
    let lod = |lod| {
        Sampler {
            lod,
            ..Sampler::default()
        }
        .lod(&t, d)
    };
    assert_eq!(lod(Lod::default()), 2.0);
    assert_eq!(
        lod(Lod {
            bias: 1.5,
            ..Lod::default()
        }),
        3.5
    );
    assert_eq!(
        lod(Lod {
            bias: 1.5,
            max: 3.0,
            ..Lod::default()
        }),
        3.0
    );
    assert_eq!(
        lod(Lod {
            bias: -9.0,
            min: 0.5,
            ..Lod::default()
        }),
        0.5
    );
}

/// A turned square footprint has no long axis. Anisotropic filtering must see one probe's worth, the
/// column lengths of a sheared one must not be mistaken for its axes.
#[test]
fn anisotropy_comes_from_the_true_axes() {
    let t = random_floats(256, 256, 3).with_mips();
    let trilinear = Sampler {
        filter: Filter::Trilinear,
        ..Sampler::default()
    };
    let anisotropic = Sampler {
        filter: Filter::Anisotropic(16),
        ..Sampler::default()
    };
    let (c, s) = (0.6_f32 / 64.0, 0.8_f32 / 64.0);
    let turned = Footprint {
        du_dx: c,
        dv_dx: s,
        du_dy: -s,
        dv_dy: c,
    };
    let uv = [0.3, 0.7];
    let (a, b) = (
        trilinear.sample_grad(&t, uv, turned),
        anisotropic.sample_grad(&t, uv, turned),
    );
    for (a, b) in a.into_iter().zip(b) {
        assert!((a - b).abs() < 2e-3, "{a} {b}");
    }
    // Columns (1, 0) and (1, 0.1): equal lengths, axes 14 to 1.
    let sheared = Footprint {
        du_dx: 1.0 / 32.0,
        dv_dx: 0.0,
        du_dy: 1.0 / 32.0,
        dv_dy: 0.1 / 32.0,
    };
    let (a, b) = (
        trilinear.sample_grad(&t, uv, sheared),
        anisotropic.sample_grad(&t, uv, sheared),
    );
    assert!(a.iter().zip(b).any(|(a, b)| (a - b).abs() > 0.01));
}

/// S9. No footprint costs more than its probes or leaves the range; zero means level 0.
#[test]
fn the_horizon_is_finite() {
    let t = random_floats(64, 64, 3).with_mips();
    for filter in [Filter::Trilinear, Filter::Anisotropic(16), Filter::ewa(16)] {
        let s = Sampler {
            filter,
            ..Sampler::default()
        };
        let zero = s.sample_grad(&t, [0.3, 0.7], Footprint::default());
        if filter != Filter::ewa(16) {
            assert_eq!(
                zero,
                Sampler {
                    filter: Filter::Bilinear,
                    ..Sampler::default()
                }
                .sample(&t, [0.3, 0.7])
            );
        }
        for long in [1.0, 1e3, 1e9, 1e30, f32::INFINITY] {
            for short in [0.0, 1e-30, 1.0 / 64.0] {
                let d = Footprint {
                    du_dx: long,
                    dv_dx: 0.0,
                    du_dy: 0.0,
                    dv_dy: short,
                };
                let c = s.sample_grad(&t, [0.3, 0.7], d);
                assert!(
                    c.iter().all(|c| (0.0..=1.0).contains(c)),
                    "{filter:?} {d:?} {c:?}"
                );
            }
        }
    }
}

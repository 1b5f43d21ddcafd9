//! Wrap modes and texel choice: cases S1, S2, S3.

use crate::support::{Random, SIZES, WRAPS, filters, largest_difference, random_floats};
use texmap_math::Footprint;
use texmap_sample::{Filter, Mip, Sampler, TexelFilter, Wrap, reference};

/// S1. The f64 definition, at coordinates moved by up to half a 2^-16 texel, must hold the f32 value.
#[test]
fn every_wrap_finds_the_texel_of_the_definition() {
    for (width, height) in SIZES {
        let t = random_floats(width, height, 7);
        for wrap_u in WRAPS {
            for wrap_v in WRAPS {
                let s = Sampler {
                    filter: Filter::Nearest,
                    wrap_u,
                    wrap_v,
                    border: [0.5; 4],
                    ..Sampler::default()
                };
                let mut random = Random::new(11);
                for _ in 0..800 {
                    let uv = [random.range(-3.0, 4.0), random.range(-3.0, 4.0)];
                    let got = s.sample(&t, uv);
                    let near = |du: f64, dv: f64| {
                        let uv = [f64::from(uv[0]) + du, f64::from(uv[1]) + dv];
                        largest_difference(got, reference::sample(&s, &t, uv)) < 1e-6
                    };
                    let (du, dv) = (
                        1.0 / 65536.0 / f64::from(width),
                        1.0 / 65536.0 / f64::from(height),
                    );
                    let valid = near(0.0, 0.0)
                        || [-du, du]
                            .iter()
                            .any(|&du| [-dv, dv].iter().any(|&dv| near(du, dv)));
                    assert!(valid, "{width}x{height} {wrap_u:?} {wrap_v:?} {uv:?}");
                }
            }
        }
    }
}

/// S1 for bilinear: 20,000 look-ups a mode, threshold 1e-5 plus what 16 texel bits allow.
#[test]
fn every_wrap_blends_the_texels_of_the_definition() {
    for (width, height) in SIZES {
        let t = random_floats(width, height, 3);
        for wrap in WRAPS {
            let s = Sampler {
                filter: Filter::Bilinear,
                wrap_u: wrap,
                wrap_v: wrap,
                border: [0.25; 4],
                ..Sampler::default()
            };
            let mut random = Random::new(5);
            let mut invalid = 0;
            for _ in 0..20_000 {
                let uv = [random.range(-3.0, 4.0), random.range(-3.0, 4.0)];
                let truth = reference::sample(&s, &t, uv.map(f64::from));
                let tolerance = 1e-5 + 2.0 / 65536.0;
                invalid += u32::from(largest_difference(s.sample(&t, uv), truth) > tolerance);
            }
            assert_eq!(invalid, 0, "{width}x{height} {wrap:?}");
        }
    }
}

/// The grid of the Khronos conformance suite: each wrap with each filter and mip mode at the sizes that
/// hurt, 20,000 look-ups each, none invalid at 16 texel bits. A look-up is valid if the definition gives
/// its colour at the coordinate or 2^-16 texels beside it.
#[test]
fn the_conformance_grid_has_no_invalid_look_up() {
    for (width, height) in &SIZES[..6] {
        let t = random_floats(*width, *height, 13).with_mips();
        for wrap in WRAPS {
            for (min, mip) in [TexelFilter::Nearest, TexelFilter::Linear]
                .into_iter()
                .flat_map(|min| [Mip::None, Mip::Nearest, Mip::Linear].map(|mip| (min, mip)))
            {
                let s = Sampler {
                    filter: Filter::Gl { mag: min, min, mip },
                    wrap_u: wrap,
                    wrap_v: wrap,
                    border: [0.5; 4],
                    ..Sampler::default()
                };
                let tolerance = 1e-5 + 2.0 / 65536.0;
                let steps = [*width, *height].map(|n| 1.0 / 65536.0 / f64::from(n));
                let mut random = Random::new(17);
                let mut invalid = 0;
                for _ in 0..20_000 {
                    let uv = [random.range(-3.0, 4.0), random.range(-3.0, 4.0)];
                    let lod = random.range(-1.0, 7.5);
                    let got = s.sample_lod(&t, uv, lod);
                    let valid = [(0, 0), (-1, -1), (1, -1), (-1, 1), (1, 1)]
                        .into_iter()
                        .any(|(i, j)| {
                            let at = [
                                f64::from(uv[0]) + f64::from(i) * steps[0],
                                f64::from(uv[1]) + f64::from(j) * steps[1],
                            ];
                            let truth = reference::sample_lod(&s, &t, at, f64::from(lod));
                            largest_difference(got, truth) <= tolerance
                        });
                    invalid += u32::from(!valid);
                }
                assert_eq!(invalid, 0, "{width}x{height} {wrap:?} {min:?} {mip:?}");
            }
        }
    }
}

/// Negative twin: a sampler half a texel off must fail the same test.
#[test]
fn a_half_texel_shift_is_seen() {
    let (width, height) = (63, 57);
    let t = random_floats(width, height, 3);
    let s = Sampler {
        filter: Filter::Bilinear,
        ..Sampler::default()
    };
    let mut random = Random::new(5);
    let mut invalid = 0;
    for _ in 0..2_000 {
        let uv = [random.range(-3.0, 4.0), random.range(-3.0, 4.0)];
        let shifted = [uv[0] + 0.5 / width as f32, uv[1] + 0.5 / height as f32];
        let truth = reference::sample(&s, &t, uv.map(f64::from));
        invalid += u32::from(largest_difference(s.sample(&t, shifted), truth) > 1e-3);
    }
    assert!(invalid > 1_900, "{invalid}");
}

/// S1. The last texel holds everything just below a whole number, negative zero included.
#[test]
fn texels_are_half_open_to_the_last_bit() {
    for n in [1_u32, 3, 63, 64, 1000] {
        let ramp: Vec<f32> = (0..n).map(|i| i as f32).collect();
        let t = crate::support::float_texture(n, 1, 1, &ramp);
        let s = Sampler {
            filter: Filter::Nearest,
            ..Sampler::default()
        };
        let last = (n - 1) as f32;
        for (u, want) in [
            (-1e-30_f32, last),
            (-0.001 / n as f32, last),
            (-1.0, 0.0),
            (1.0 - f32::EPSILON / 2.0, last),
            (1.0, 0.0),
            (0.0, 0.0),
            (-0.0, 0.0),
            (-1.0 - 1e-6, last),
        ] {
            assert_eq!(s.sample(&t, [u, 0.5])[0], want, "n {n} u {u:e}");
        }
    }
}

/// S2. Far from the origin the coordinate's own steps are the only error.
#[test]
fn large_coordinates_keep_their_precision() {
    let n = 1024;
    // A ramp makes the value the coordinate: texel x holds x.
    let ramp: Vec<f32> = (0..n).map(|i| i as f32).collect();
    let t = crate::support::float_texture(n, 1, 1, &ramp);
    let s = Sampler {
        filter: Filter::Bilinear,
        ..Sampler::default()
    };
    for base in [4096.0_f32, 65536.0, 1e6] {
        for k in 0..512 {
            let u = base + (k as f32 + 0.37) / 1024.0;
            let place = (f64::from(u) - f64::from(u).floor()) * f64::from(n) - 0.5;
            if place < 1.0 || place > f64::from(n) - 2.0 {
                continue;
            }
            let got = f64::from(s.sample(&t, [u, 0.5])[0]);
            assert!((got - place).abs() < 0.01, "u {u} {got} {place}");
        }
    }
}

/// Mirroring keeps every bit of a coordinate that repeating keeps.
#[test]
fn mirrored_coordinates_keep_every_bit() {
    let sampler = |wrap, filter| Sampler {
        filter,
        wrap_u: wrap,
        wrap_v: wrap,
        ..Sampler::default()
    };
    for n in [63, 255, 1000] {
        // A ramp makes the value the coordinate.
        let ramp: Vec<f32> = (0..n).map(|i| i as f32).collect();
        let t = crate::support::float_texture(n, 1, 1, &ramp);
        for (low, high) in [(-3.0, 4.0), (-0.5, 0.5), (-1.0, 0.0)] {
            let error = |wrap| {
                let s = sampler(wrap, Filter::Bilinear);
                let mut random = Random::new(3);
                (0..60_000).fold(0.0, |most: f64, _| {
                    let u = random.range(low, high);
                    let truth = reference::sample(&s, &t, [f64::from(u), 0.5])[0];
                    // Repeating jumps between the ends of the ramp.
                    let inside = truth > 1.0 && truth < f64::from(n) - 2.0;
                    let error = (f64::from(s.sample(&t, [u, 0.5])[0]) - truth).abs();
                    if inside { most.max(error) } else { most }
                })
            };
            let (mirrored, repeated) = (error(Wrap::MirroredRepeat), error(Wrap::Repeat));
            assert!(
                mirrored <= repeated,
                "{n} {low} to {high}: {mirrored:e} {repeated:e}"
            );
        }
    }
    let t = random_floats(255, 130, 5);
    let s = sampler(Wrap::MirroredRepeat, Filter::Nearest);
    let mut random = Random::new(3);
    for _ in 0..60_000 {
        let uv = [random.range(-3.0, 4.0), random.range(-3.0, 4.0)];
        let truth = reference::sample(&s, &t, uv.map(f64::from));
        assert!(largest_difference(s.sample(&t, uv), truth) < 1e-6, "{uv:?}");
    }
}

/// S3. Anything at all may come in; what comes out is a colour of the texture.
#[test]
fn no_coordinate_or_derivative_breaks_a_filter() {
    let values = [
        f32::NAN,
        f32::INFINITY,
        f32::NEG_INFINITY,
        1e30,
        -1e30,
        f32::MAX,
        -f32::MAX,
        f32::MIN_POSITIVE,
        1e-45,
        0.0,
        -0.0,
        0.3,
        16_777_216.0,
    ];
    for (width, height) in [(5, 3), (1, 1), (1, 8), (64, 64)] {
        let t = random_floats(width, height, 1)
            .with_mips()
            .with_summed_area();
        for filter in filters() {
            for wrap in WRAPS {
                let s = Sampler {
                    filter,
                    wrap_u: wrap,
                    wrap_v: wrap,
                    border: [0.5; 4],
                    ..Sampler::default()
                };
                for u in values {
                    for v in [0.4, f32::NAN, f32::NEG_INFINITY, 1e30] {
                        for d in values {
                            let d = Footprint {
                                du_dx: d,
                                dv_dx: 0.01,
                                du_dy: -0.5 * d,
                                dv_dy: d,
                            };
                            let c = s.sample_grad(&t, [u, v], d);
                            assert!(
                                c.iter().all(|c| (-0.5..=1.5).contains(c)),
                                "{filter:?} {wrap:?} {u} {v} {d:?} {c:?}"
                            );
                        }
                    }
                }
            }
        }
    }
}

/// S3. The documented value: NaN and infinities read as 0 where the axis repeats.
#[test]
fn a_nan_coordinate_reads_as_zero() {
    let t = random_floats(5, 3, 9);
    for wrap in WRAPS {
        let s = Sampler {
            filter: Filter::Bilinear,
            wrap_u: wrap,
            wrap_v: wrap,
            ..Sampler::default()
        };
        assert_eq!(
            s.sample(&t, [f32::NAN, f32::NAN]),
            s.sample(&t, [0.0, 0.0]),
            "{wrap:?}"
        );
    }
    let s = Sampler {
        filter: Filter::Bilinear,
        wrap_u: Wrap::ClampToEdge,
        wrap_v: Wrap::Repeat,
        ..Sampler::default()
    };
    assert_eq!(
        s.sample(&t, [f32::INFINITY, f32::INFINITY]),
        s.sample(&t, [1.0, 0.0])
    );
}

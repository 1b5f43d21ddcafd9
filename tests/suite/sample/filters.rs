//! Invariants of every filter: constants, texels at centres, weights that sum to one (S10, property 30).

use crate::support::{
    Random, SIZES, WRAPS, filters, float_texture, largest_difference, random_bytes, random_floats,
};
use texmap_math::{Footprint, color};
use texmap_sample::{
    ColorSpace, Cubic, Filter, Origin, Precision, Sampler, Texture2d, Wrap, reference,
};

fn random_footprint(random: &mut Random) -> Footprint {
    let mut d = || random.range(-1.0, 1.0) * 0.5_f32.powi((random.word() % 9) as i32);
    Footprint {
        du_dx: d(),
        dv_dx: d(),
        du_dy: d(),
        dv_dy: d(),
    }
}

/// S10, in f32 to one step of the value.
#[test]
fn a_constant_texture_stays_constant() {
    for (width, height) in SIZES {
        let value = [0.2, 0.7, 1.0 / 3.0, 0.9];
        let texels: Vec<f32> = (0..width * height).flat_map(|_| value).collect();
        let t = float_texture(width, height, 4, &texels)
            .with_mips()
            .with_summed_area();
        for filter in filters() {
            for precision in [Precision::Exact, Precision::Fast] {
                let s = Sampler {
                    filter,
                    precision,
                    border: value,
                    wrap_v: Wrap::ClampToBorder,
                    ..Sampler::default()
                };
                let mut random = Random::new(2);
                for _ in 0..200 {
                    let uv = [random.range(-2.0, 2.0), random.range(-2.0, 2.0)];
                    let got = s.sample_grad(&t, uv, random_footprint(&mut random));
                    for (got, want) in got.into_iter().zip(value) {
                        let step = f32::from_bits(want.to_bits() + 1) - want;
                        assert!(
                            (got - want).abs() <= step,
                            "{width}x{height} {filter:?} {got} {want}"
                        );
                    }
                }
            }
        }
    }
}

/// S10 in bytes: exact, whatever the filter.
#[test]
fn a_constant_byte_texture_stays_constant_in_bytes() {
    for value in 0..=255_u8 {
        let texels = [value, 255 - value, 128, 255].repeat(7 * 5);
        let t = Texture2d::from_rgba8(7, 5, texels, ColorSpace::Linear, Origin::TopLeft)
            .unwrap()
            .with_mips()
            .with_summed_area();
        for filter in filters() {
            let s = Sampler {
                filter,
                ..Sampler::default()
            };
            let mut random = Random::new(u64::from(value));
            for _ in 0..8 {
                let uv = [random.range(-2.0, 2.0), random.range(-2.0, 2.0)];
                let got = s
                    .sample_grad(&t, uv, random_footprint(&mut random))
                    .map(color::unit_to_u8);
                assert_eq!(got, [value, 255 - value, 128, 255], "{filter:?}");
            }
        }
    }
}

/// Property 30: interpolating filters return the texel at its centre.
#[test]
fn texels_return_at_their_centres() {
    for (width, height) in SIZES {
        let t = random_floats(width, height, 4);
        for filter in [
            Filter::Nearest,
            Filter::Bilinear,
            Filter::Bicubic(Cubic::CatmullRom),
            Filter::Trilinear,
        ] {
            for wrap in WRAPS {
                let s = Sampler {
                    filter,
                    wrap_u: wrap,
                    wrap_v: wrap,
                    ..Sampler::default()
                };
                for y in 0..height {
                    for x in 0..width {
                        let uv = [
                            (x as f32 + 0.5) / width as f32,
                            (y as f32 + 0.5) / height as f32,
                        ];
                        let (got, want) = (s.sample(&t, uv), t.texel(0, x, y).unwrap());
                        let error = got
                            .iter()
                            .zip(want)
                            .map(|(a, b)| (a - b).abs())
                            .fold(0.0, f32::max);
                        // The centre itself is rounded to f32: 2^-24 of the side.
                        assert!(error < 2e-5, "{filter:?} {wrap:?} ({x}, {y}) {error:e}");
                    }
                }
            }
        }
    }
}

/// Property 30: an affine image is reproduced away from the borders, by cubics too.
#[test]
fn affine_images_are_reproduced() {
    let (width, height) = (16, 9);
    let texels: Vec<f32> = (0..width * height)
        .map(|i| 0.03 * (i % width) as f32 - 0.05 * (i / width) as f32)
        .collect();
    let t = float_texture(width, height, 1, &texels);
    let mut random = Random::new(8);
    for _ in 0..1000 {
        let (x, y) = (random.range(2.5, 12.5), random.range(2.5, 5.5));
        let uv = [x / width as f32, y / height as f32];
        let want = 0.03 * (f64::from(x) - 0.5) - 0.05 * (f64::from(y) - 0.5);
        for filter in [
            Filter::Bilinear,
            Filter::Bicubic(Cubic::CatmullRom),
            Filter::Bicubic(Cubic::Mitchell),
            Filter::Bicubic(Cubic::BSpline),
        ] {
            let got = Sampler {
                filter,
                ..Sampler::default()
            }
            .sample(&t, uv)[0];
            assert!(
                (f64::from(got) - want).abs() < 2e-6,
                "{filter:?} {got} {want}"
            );
        }
    }
}

/// Nearest equals bilinear where there is nothing to blend, and differs where there is.
#[test]
fn nearest_and_bilinear_agree_on_constants_only() {
    let flat = float_texture(4, 4, 1, &[0.3; 16]);
    let rough = random_floats(4, 4, 6);
    let nearest = Sampler {
        filter: Filter::Nearest,
        ..Sampler::default()
    };
    let bilinear = Sampler {
        filter: Filter::Bilinear,
        ..Sampler::default()
    };
    assert_eq!(
        nearest.sample(&flat, [0.4, 0.6]),
        bilinear.sample(&flat, [0.4, 0.6])
    );
    assert_ne!(
        nearest.sample(&rough, [0.4, 0.6]),
        bilinear.sample(&rough, [0.4, 0.6])
    );
}

/// Every filter in f32 lies within its bound of the f64 definition.
#[test]
fn filters_follow_their_definitions() {
    for (width, height) in SIZES {
        for t in [
            random_floats(width, height, 12)
                .with_mips()
                .with_summed_area(),
            random_bytes(width, height, 13)
                .with_mips()
                .with_summed_area(),
        ] {
            for filter in filters() {
                for wrap in WRAPS {
                    let s = Sampler {
                        filter,
                        wrap_u: wrap,
                        wrap_v: wrap,
                        border: [0.5; 4],
                        ..Sampler::default()
                    };
                    let mut random = Random::new(21);
                    let mut wrong = 0;
                    for _ in 0..150 {
                        let uv = [random.range(-2.0, 2.0), random.range(-2.0, 2.0)];
                        let d = random_footprint(&mut random);
                        let got = s.sample_grad(&t, uv, d);
                        let exact = [d.du_dx, d.dv_dx, d.du_dy, d.dv_dy].map(f64::from);
                        let truth = reference::sample_grad(&s, &t, uv.map(f64::from), exact);
                        wrong += u32::from(largest_difference(got, truth) > bound(filter));
                    }
                    // A choice (nearest texel, probe count) may fall the other way where it is a tie.
                    assert!(
                        wrong <= 1,
                        "{width}x{height} {filter:?} {wrap:?}: {wrong} of 150"
                    );
                }
            }
        }
    }
}

pub(crate) fn bound(filter: Filter) -> f64 {
    match filter {
        Filter::Nearest | Filter::Bilinear | Filter::MipNearest | Filter::BilinearMipNearest => {
            4e-5
        }
        Filter::Bicubic(_) => 8e-5,
        // Sides are rounded to 2^-24 of themselves, twice at most; the mean and its scale once each.
        Filter::SummedArea => 1e-6,
        // The weight table has 128 steps.
        Filter::Ewa { .. } => 6e-3,
        _ => 1e-4,
    }
}

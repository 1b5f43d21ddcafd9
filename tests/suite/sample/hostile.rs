//! Any value in any public field of a sampler and in any texel. Lanes and scalar agree, f64 agrees with both, nothing is NaN.

use crate::filters::bound;
use crate::support::{Random, WRAPS, filters, float_texture, largest_difference, random_floats};
use texmap_math::Footprint;
use texmap_sample::{
    Alpha, ColorSpace, Filter, Image, Lod, Origin, Precision, SampleError, Sampler, TexelData,
    Texture2d, Texture3d, UvwBatch, Wrap, reference, sample_3d_soa, sample_slice,
};
use texmap_tests::levels::levels;

/// Numbers that limits, levels and borders may be.
const NUMBERS: [f32; 14] = [
    f32::NAN,
    f32::INFINITY,
    f32::NEG_INFINITY,
    f32::MAX,
    f32::MIN,
    1e30,
    -1e30,
    -33.0,
    -0.0,
    0.0,
    1e-45,
    0.7,
    1.5,
    3.2,
];

/// Texels up to the limit of the format, alphas above one and below zero.
const TEXELS: [f32; 10] = [
    0.0,
    -0.0,
    1.0,
    1.0,
    2.0,
    -1.0,
    0.4,
    1e-40,
    1.329_228e36,
    -1.329_228e36,
];

fn pick<T: Copy>(random: &mut Random, from: &[T]) -> T {
    from[random.word() as usize % from.len()]
}

fn any_filter(random: &mut Random) -> Filter {
    match random.word() % 6 {
        0 => Filter::Anisotropic(random.word() as u8),
        1 => Filter::Ewa {
            // Ellipses of any size take long one by one.
            ratio: (random.word() % 5) as u8,
            percent: random.word() as u8,
        },
        _ => pick(random, &filters()),
    }
}

fn any_sampler(random: &mut Random) -> Sampler {
    // Some fields stay as they are, so that the others are not hidden by them.
    let mut number = |usual: f32| match random.word() % 3 {
        0 => usual,
        _ => pick(random, &NUMBERS),
    };
    let lod = Lod {
        bias: number(0.0),
        min: number(0.0),
        max: number(1000.0),
    };
    let border = [(); 4].map(|()| number(0.5));
    Sampler {
        filter: any_filter(random),
        wrap_u: pick(random, &WRAPS),
        wrap_v: pick(random, &WRAPS),
        border,
        lod,
        precision: pick(random, &[Precision::Exact, Precision::Fast]),
    }
}

/// A texture of any kind; floats are within `texels`.
fn any_texture(random: &mut Random, texels: &[f32]) -> Texture2d<'static> {
    let side = |random: &mut Random| match random.word() % 3 {
        0 => 1 << (random.word() % 6),
        _ => 1 + random.word() % 21,
    };
    let (width, height) = (side(random), side(random));
    let channels = 1 + random.word() % 4;
    let count = (width * height * channels) as usize;
    let origin = pick(random, &[Origin::TopLeft, Origin::BottomLeft]);
    let color = pick(random, &[ColorSpace::Linear, ColorSpace::Srgb]);
    // Whole textures of one alpha are what is stored in fewer bits.
    let opaque = random.word().is_multiple_of(2);
    let bytes: Vec<u8> = (0..count as u32)
        .map(|i| match i % channels {
            3 if opaque => 255,
            _ => random.word() as u8,
        })
        .collect();
    let words: Vec<u16> = bytes.iter().map(|c| u16::from(*c) * 257).collect();
    let floats: Vec<f32> = (0..count as u32)
        .map(|i| match i % channels {
            3 if opaque => pick(random, &[1.0, 1.0, 1.0, 7.0]),
            _ => pick(random, texels),
        })
        .collect();
    let kind = random.word() % 4;
    let image = Image {
        width,
        height,
        channels,
        texels: match kind {
            0 => TexelData::U8(&bytes),
            1 => TexelData::U16(&words),
            _ => TexelData::F32(&floats),
        },
        // Curve and opacity take large floats out of the range, which is refused.
        color: if kind < 2 { color } else { ColorSpace::Linear },
        alpha: if kind < 2 {
            pick(
                random,
                &[Alpha::Straight, Alpha::Premultiplied, Alpha::Data],
            )
        } else {
            Alpha::Premultiplied
        },
        origin,
    };
    let t = if kind == 0 && random.word().is_multiple_of(4) {
        Texture2d::from_encoded8((width, height), channels, bytes.clone(), color, origin)
    } else {
        Texture2d::new(&image)
    };
    let t = t.unwrap();
    match random.word() % 5 {
        0 => t,
        1 => t.with_normal_mips(),
        2 => {
            let threshold = pick(random, &[0.5, 0.0, -1.0, 1.5, f32::NAN, f32::INFINITY]);
            t.with_coverage_mips(threshold)
        }
        _ => t.with_mips().with_summed_area(),
    }
}

fn coordinate(random: &mut Random) -> f32 {
    match random.word() % 8 {
        0 => pick(random, &NUMBERS),
        _ => random.range(-3.0, 4.0),
    }
}

fn derivative(random: &mut Random) -> f32 {
    match random.word() % 8 {
        0 => pick(random, &NUMBERS),
        _ => random.range(-1.0, 1.0) * 0.5_f32.powi((random.word() % 8) as i32),
    }
}

#[test]
fn no_field_or_texel_parts_lanes_from_scalar() {
    const COUNT: usize = 35;
    let mut random = Random::new(29);
    for round in 0..1500 {
        let (s, t) = (any_sampler(&mut random), any_texture(&mut random, &TEXELS));
        let [u, v] = [(); 2].map(|()| {
            (0..COUNT)
                .map(|_| coordinate(&mut random))
                .collect::<Vec<_>>()
        });
        let d: Vec<Footprint> = (0..COUNT)
            .map(|_| {
                let mut c = || derivative(&mut random);
                Footprint::new(c(), c(), c(), c())
            })
            .collect();
        let mut out = vec![[0.0; 4]; COUNT];
        for grads in [Some(&d[..]), None] {
            let truth: Vec<_> = (0..COUNT)
                .map(|i| match grads {
                    Some(d) => s.sample_grad(&t, [u[i], v[i]], d[i]),
                    None => s.sample(&t, [u[i], v[i]]),
                })
                .collect();
            for (name, level) in levels() {
                sample_slice(level, &s, &t, &u, &v, grads, &mut out).unwrap();
                for i in 0..COUNT {
                    let place = [u[i], v[i]];
                    assert!(
                        truth[i].iter().all(|c| c.is_finite())
                            && out[i].map(f32::to_bits) == truth[i].map(f32::to_bits),
                        "round {round} {name} {s:?} {}x{} {} levels at {place:?} {:?}: {:?} against {:?}",
                        t.width(),
                        t.height(),
                        t.levels(),
                        grads.map(|d| d[i]),
                        out[i],
                        truth[i]
                    );
                }
            }
        }
    }
}

#[test]
fn no_field_parts_volumes_from_scalar() {
    const COUNT: usize = 19;
    let mut random = Random::new(31);
    for round in 0..400 {
        let s = any_sampler(&mut random);
        let wrap_w = pick(&mut random, &WRAPS);
        let [w, h, depth] = [(); 3].map(|()| 1 + random.word() % 6);
        let texels: Vec<f32> = (0..w * h * depth * 4)
            .map(|_| pick(&mut random, &TEXELS))
            .collect();
        let slices = Image {
            width: w,
            height: h,
            channels: 4,
            texels: TexelData::F32(&texels),
            color: ColorSpace::Linear,
            alpha: Alpha::Data,
            origin: Origin::TopLeft,
        };
        let t = Texture3d::new(depth, &slices).unwrap().with_mips();
        let [u, v, w, lod] = [(); 4].map(|()| {
            (0..COUNT)
                .map(|_| coordinate(&mut random))
                .collect::<Vec<_>>()
        });
        let at = UvwBatch {
            u: &u,
            v: &v,
            w: &w,
            lod: Some(&lod),
        };
        let mut out = [[0.0; COUNT]; 4];
        for (name, level) in levels() {
            let columns = out.each_mut().map(|c| &mut c[..]);
            sample_3d_soa(level, &s, &t, wrap_w, &at, columns).unwrap();
            for i in 0..COUNT {
                let one = s.sample_3d(&t, [u[i], v[i], w[i]], wrap_w, lod[i]);
                let found = [0, 1, 2, 3].map(|k| out[k][i]);
                assert!(
                    one.iter().all(|c| c.is_finite())
                        && found.map(f32::to_bits) == one.map(f32::to_bits),
                    "round {round} {name} {s:?} {wrap_w:?} at {i}: {found:?} against {one:?}"
                );
            }
        }
    }
}

/// Limits, bias and border of any value mean the same in f64.
#[test]
fn hostile_fields_mean_what_the_definition_says() {
    let mut random = Random::new(37);
    let (mut wrong, mut total) = (0, 0);
    for _ in 0..1200 {
        let width = 1 + random.word() % 40;
        let t = random_floats(width, 1 + random.word() % 40, 5)
            .with_mips()
            .with_summed_area();
        let mut s = any_sampler(&mut random);
        s.precision = Precision::Exact;
        // Ellipses and rectangles on levels far from theirs are larger than what is read of them.
        if let Filter::Ewa { .. } | Filter::SummedArea = s.filter {
            s.lod = Lod::default();
        }
        // A border of 2^100 is finite, and no more than that can be said of its neighbours' weights.
        s.border = s.border.map(|c| if c.abs() > 2.0 { f32::NAN } else { c });
        for _ in 0..20 {
            let uv = [random.range(-2.0, 3.0), random.range(-2.0, 3.0)];
            let mut c = || random.range(-1.0, 1.0) * 0.5_f32.powi((random.word() % 6) as i32);
            let d = Footprint::new(c(), c(), c(), c());
            let exact = [d.du_dx, d.dv_dx, d.du_dy, d.dv_dy].map(f64::from);
            let truth = reference::sample_grad(&s, &t, uv.map(f64::from), exact);
            let got = s.sample_grad(&t, uv, d);
            total += 1;
            wrong += u32::from(!(largest_difference(got, truth) <= 4.0 * bound(s.filter)));
        }
    }
    // Choices of texels, probes and levels may fall the other way where they are ties.
    assert!(wrong * 400 < total, "{wrong} of {total}");
}

/// The three that were found first.
#[test]
fn limits_of_nan_limit_nothing() {
    let t = random_floats(8, 8, 3).with_mips().with_summed_area();
    let d = Footprint::new(0.5, 0.0, 0.0, 0.5);
    let plain = Sampler::default();
    for filter in filters() {
        let base = Sampler {
            filter,
            ..plain.clone()
        };
        for lod in [
            Lod {
                min: f32::NAN,
                ..Lod::default()
            },
            Lod {
                max: f32::NAN,
                ..Lod::default()
            },
            Lod {
                bias: f32::NAN,
                ..Lod::default()
            },
        ] {
            let s = Sampler {
                lod,
                ..base.clone()
            };
            let (got, want) = (
                s.sample_grad(&t, [0.3, 0.6], d),
                base.sample_grad(&t, [0.3, 0.6], d),
            );
            assert_eq!(got, want, "{filter:?} {lod:?}");
        }
    }
}

#[test]
fn alphas_above_one_are_filtered_on_every_level() {
    let texels = [[0.5, 0.5, 0.5, 1.0], [0.5, 0.5, 0.5, 3.0]].concat();
    let t = float_texture(2, 1, 4, &texels);
    assert!(!t.has_alpha());
    let s = Sampler {
        filter: Filter::Bilinear,
        wrap_u: Wrap::ClampToEdge,
        ..Sampler::default()
    };
    for (name, level) in levels() {
        let mut out = [[0.0; 4]; 1];
        sample_slice(level, &s, &t, &[0.5], &[0.5], None, &mut out).unwrap();
        assert_eq!(out[0][3], 2.0, "{name}");
    }
}

#[test]
fn floats_that_leave_the_range_on_their_way_in_are_refused() {
    let refused = |texels: &[f32], channels: u32, color: ColorSpace, alpha: Alpha| {
        let image = Image {
            width: 2,
            height: 1,
            channels,
            texels: TexelData::F32(texels),
            color,
            alpha,
            origin: Origin::TopLeft,
        };
        Texture2d::new(&image).map(|_| ())
    };
    let second = Err(SampleError::Texel { x: 1, y: 0 });
    let (linear, srgb) = (ColorSpace::Linear, ColorSpace::Srgb);
    let large = [0.0, 1e30];
    assert_eq!(refused(&large, 1, srgb, Alpha::Data), second);
    assert_eq!(refused(&large, 1, linear, Alpha::Data), Ok(()));
    let bright = [0.0, 1.0, 1e30, 1e30];
    assert_eq!(refused(&bright, 2, linear, Alpha::Straight), second);
    assert_eq!(refused(&bright, 2, linear, Alpha::Premultiplied), Ok(()));
    let negative = [0.5, -1e30];
    assert_eq!(refused(&negative, 1, srgb, Alpha::Data), Ok(()));
}

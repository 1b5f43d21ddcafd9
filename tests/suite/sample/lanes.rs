//! Every SIMD level, the forced fallback among them, and every number of lanes gives the bits of single look-ups.

use crate::support::{Random, WRAPS, filters, random_bytes, random_floats};
use texmap_math::simd::{ByteIsa, prelude::*};
use texmap_math::{Footprint, Level, dispatch_simd};
use texmap_sample::lanes::packed::{self, FootprintLanes};
use texmap_sample::lanes::{BoundTexture, Kernel};
use texmap_sample::{
    Alpha, ColorSpace, Filter, Image, Lod, Origin, Places as Columns, Precision, Sampler,
    TexelData, Texture2d, Wrap, is_exact_in_rgba8, sample_rgba8_slice, sample_rgba8_soa,
    sample_slice, sample_soa,
};
use texmap_tests::levels::levels;

/// Coordinates and footprints: smooth runs, random ones, and the numbers that break things.
struct Places {
    u: Vec<f32>,
    v: Vec<f32>,
    d: Vec<Footprint>,
}

fn places(seed: u64) -> Places {
    let mut random = Random::new(seed);
    let (mut u, mut v, mut d) = (Vec::new(), Vec::new(), Vec::new());
    // Runs of one level, magnified or minified, as a floor has them.
    for run in 0..6 {
        let size = 0.5_f32.powi(run * 2 + 1);
        for k in 0..16 {
            u.push(0.013 * k as f32 - 0.4);
            v.push(3.7 - 0.021 * k as f32);
            d.push(Footprint::new(size, 0.1 * size, -0.2 * size, 0.7 * size));
        }
    }
    for _ in 0..160 {
        u.push(random.range(-3.0, 4.0));
        v.push(random.range(-3.0, 4.0));
        let mut d1 = || random.range(-1.0, 1.0) * 0.5_f32.powi((random.word() % 12) as i32);
        d.push(Footprint::new(d1(), d1(), d1(), d1()));
    }
    let hard = [
        f32::NAN,
        f32::INFINITY,
        f32::NEG_INFINITY,
        1e30,
        -1e30,
        0.0,
        -0.0,
        -1e-30,
        1e-45,
        1.0,
        65536.25,
        1e6,
        0.999_999_94,
        -0.5,
    ];
    for (i, a) in hard.into_iter().enumerate() {
        for (j, b) in hard.into_iter().enumerate() {
            u.push(a);
            v.push(b);
            let (p, q) = (hard[(i + j) % hard.len()], hard[(3 * i + j) % hard.len()]);
            d.push(Footprint::new(p, 0.01, q, p));
        }
    }
    // Not a whole number of vectors.
    u.push(0.3);
    v.push(0.3);
    d.push(Footprint::default());
    assert_ne!(u.len() % 16, 0);
    Places { u, v, d }
}

fn textures() -> Vec<(&'static str, Texture2d<'static>)> {
    let mut random = Random::new(1);
    let mut coloured = |w: u32, h: u32, soft: bool| -> Vec<u8> {
        (0..w * h)
            .flat_map(|_| {
                let a = if soft {
                    random.word() as u8
                } else {
                    if random.word() & 1 == 0 { 0 } else { 255 }
                };
                let c = random.word();
                [c as u8, (c >> 8) as u8, (c >> 16) as u8, a]
            })
            .collect()
    };
    let keyed = Texture2d::from_rgba8(
        16,
        8,
        coloured(16, 8, false),
        ColorSpace::Linear,
        Origin::TopLeft,
    );
    let soft = Texture2d::from_rgba8(
        32,
        32,
        coloured(32, 32, true),
        ColorSpace::Srgb,
        Origin::BottomLeft,
    );
    let odd = Texture2d::from_rgba8(
        13,
        7,
        coloured(13, 7, true),
        ColorSpace::Srgb,
        Origin::TopLeft,
    );
    let heights: Vec<f32> = (0..16 * 16).map(|i| (i * 37 % 101) as f32).collect();
    let mut words = Random::new(2);
    let mut kept = |size: (u32, u32), channels: u32, origin| {
        let texels = (0..size.0 * size.1 * channels).map(|_| words.word() as u8);
        Texture2d::from_encoded8(size, channels, texels.collect(), ColorSpace::Srgb, origin)
            .unwrap()
    };
    let kept_with_levels = kept((37, 21), 3, Origin::BottomLeft).with_mips();
    let kept_with_alpha = kept((16, 8), 4, Origin::TopLeft);
    // Four numbers a texel: the last is no opacity, and not 255.
    let data = Texture2d::new(&Image {
        width: 8,
        height: 8,
        channels: 4,
        texels: TexelData::U8(&coloured(8, 8, true)),
        color: ColorSpace::Linear,
        alpha: Alpha::Data,
        origin: Origin::TopLeft,
    });
    vec![
        ("data 8x8", data.unwrap().with_mips()),
        ("bytes 64x32", random_bytes(64, 32, 3).with_mips()),
        (
            "bytes 64x64 flipped, no mips",
            random_bytes(64, 64, 3).with_origin(Origin::BottomLeft),
        ),
        ("bytes 63x57", random_bytes(63, 57, 4).with_mips()),
        (
            "bytes 5x3 flipped",
            random_bytes(5, 3, 4)
                .with_origin(Origin::BottomLeft)
                .with_mips(),
        ),
        // Cubics reach over the whole texture, and beyond its mirror.
        ("bytes 3x2", random_bytes(3, 2, 4).with_mips()),
        ("bytes 1x1", random_bytes(1, 1, 5)),
        ("bytes 1x9", random_bytes(1, 9, 5).with_mips()),
        // Levels of half the length whose width stays one.
        ("bytes 16x1", random_bytes(16, 1, 6).with_mips()),
        ("bytes 2x32", random_bytes(2, 32, 7).with_mips()),
        ("keyed 16x8", keyed.unwrap().with_mips()),
        ("soft 32x32", soft.unwrap().with_mips()),
        ("soft 13x7", odd.unwrap().with_mips()),
        ("kept 37x21 flipped", kept_with_levels),
        ("kept 16x8, no mips", kept_with_alpha),
        ("floats 31x16", random_floats(31, 16, 6).with_mips()),
        (
            "heights 16x16",
            Texture2d::borrow_r32(16, 16, &heights, Origin::TopLeft)
                .unwrap()
                .with_mips(),
        ),
    ]
}

fn same_bits(a: [f32; 4], b: [f32; 4]) -> bool {
    a.map(f32::to_bits) == b.map(f32::to_bits)
}

#[test]
fn slices_equal_single_samples_on_every_level() {
    let places = places(9);
    let n = places.u.len();
    let mut out = vec![[0.0; 4]; n];
    for (name, t) in textures() {
        let t = t.with_summed_area();
        for (k, filter) in filters().into_iter().enumerate() {
            for (j, wrap) in WRAPS.into_iter().enumerate() {
                for precision in [Precision::Exact, Precision::Fast] {
                    let s = Sampler {
                        filter,
                        wrap_u: wrap,
                        // Every pair of wraps comes by.
                        wrap_v: WRAPS[(j + k) % 5],
                        border: [0.3, 0.5, 0.7, 0.9],
                        lod: if k % 3 == 1 {
                            Lod {
                                bias: 0.7,
                                min: 0.2,
                                max: 3.3,
                            }
                        } else {
                            Lod::default()
                        },
                        precision,
                    };
                    let truth: Vec<_> = (0..n)
                        .map(|i| {
                            let uv = [places.u[i], places.v[i]];
                            (s.sample_grad(&t, uv, places.d[i]), s.sample(&t, uv))
                        })
                        .collect();
                    for (level_name, level) in levels() {
                        for with_grads in [true, false] {
                            let grads = with_grads.then_some(&places.d[..]);
                            sample_slice(level, &s, &t, &places.u, &places.v, grads, &mut out)
                                .unwrap();
                            for i in 0..n {
                                let want = if with_grads { truth[i].0 } else { truth[i].1 };
                                assert!(
                                    same_bits(out[i], want),
                                    "{name} {filter:?} {precision:?} {wrap:?} {:?} {level_name} at {i} \
                                     ({}, {}) {:?}: {:?} against {want:?}",
                                    s.wrap_v,
                                    places.u[i],
                                    places.v[i],
                                    with_grads.then_some(places.d[i]),
                                    out[i]
                                );
                            }
                        }
                    }
                }
            }
        }
    }
}

/// The path for powers of two gives the bits of the general one: the same texture under a wrap that
/// never shows (coordinates inside) must agree with repeat away from the edges.
#[test]
fn the_masked_path_agrees_with_the_general_one() {
    let t = random_bytes(64, 64, 8);
    let mut random = Random::new(4);
    for filter in [Filter::Nearest, Filter::Bilinear] {
        for precision in [Precision::Exact, Precision::Fast] {
            let masked = Sampler {
                filter,
                precision,
                ..Sampler::default()
            };
            let general = Sampler {
                wrap_u: Wrap::ClampToEdge,
                wrap_v: Wrap::ClampToEdge,
                ..masked.clone()
            };
            for _ in 0..1000 {
                let uv = [random.range(0.02, 0.98), random.range(0.02, 0.98)];
                assert!(
                    same_bits(masked.sample(&t, uv), general.sample(&t, uv)),
                    "{filter:?} {uv:?}"
                );
            }
        }
    }
}

#[test]
fn slices_of_different_lengths_are_refused() {
    let t = random_bytes(4, 4, 1);
    let s = Sampler::default();
    let level = Level::new();
    let mut out = [[0.0; 4]; 2];
    let e = sample_slice(level, &s, &t, &[0.0; 2], &[0.0; 3], None, &mut out).unwrap_err();
    assert_eq!(e.to_string(), "v holds 3 entries, the coordinates have 2");
    assert!(
        sample_slice(
            level,
            &s,
            &t,
            &[0.0; 2],
            &[0.0; 2],
            Some(&[Footprint::default()]),
            &mut out
        )
        .is_err()
    );
    assert!(sample_slice(level, &s, &t, &[0.0; 3], &[0.0; 3], None, &mut out).is_err());
    assert!(sample_slice(level, &s, &t, &[], &[], None, &mut []).is_ok());
}

/// Fast stays within what 8-bit weights allow of Exact on bytes.
#[test]
fn fast_stays_near_exact() {
    let t = random_bytes(64, 64, 2).with_mips().with_summed_area();
    let mut random = Random::new(6);
    for (filter, bound) in [
        (Filter::Nearest, 0.0),
        (Filter::Bilinear, 3.0 / 255.0),
        (Filter::Trilinear, 0.06),
    ] {
        let exact = Sampler {
            filter,
            ..Sampler::default()
        };
        let fast = Sampler {
            precision: Precision::Fast,
            ..exact.clone()
        };
        for _ in 0..2000 {
            let uv = [random.range(-2.0, 2.0), random.range(-2.0, 2.0)];
            let size = 0.5_f32.powi((random.word() % 9) as i32);
            let d = Footprint::new(size, 0.0, 0.0, size * 0.8);
            let (a, b) = (exact.sample_grad(&t, uv, d), fast.sample_grad(&t, uv, d));
            let error = a
                .iter()
                .zip(b)
                .map(|(a, b)| (a - b).abs())
                .fold(0.0, f32::max);
            assert!(error <= bound + 1e-6, "{filter:?} {error}");
        }
    }
}

/// Columns are slices turned over.
#[test]
fn columns_equal_slices() {
    let places = places(6);
    let n = places.u.len();
    let column = |of: &dyn Fn(&Footprint) -> f32| places.d.iter().map(of).collect::<Vec<_>>();
    let gradients = [
        column(&|d| d.du_dx),
        column(&|d| d.dv_dx),
        column(&|d| d.du_dy),
        column(&|d| d.dv_dy),
    ];
    let (mut colors, mut columns) = (vec![[0.0; 4]; n], [(); 4].map(|()| vec![0.0; n]));
    let (mut bytes, mut byte_columns) = (vec![0; n], vec![0; n]);
    for (name, t) in textures() {
        for filter in filters() {
            for precision in [Precision::Exact, Precision::Fast] {
                let s = Sampler {
                    filter,
                    precision,
                    ..Sampler::default()
                };
                for (level_name, level) in levels() {
                    for with_grads in [true, false] {
                        let what = format!("{name} {filter:?} {precision:?} {level_name}");
                        let grads = with_grads.then_some(&places.d[..]);
                        let (u, v) = (&places.u[..], &places.v[..]);
                        let at = Columns {
                            u,
                            v,
                            gradients: with_grads.then(|| gradients.each_ref().map(|c| &c[..])),
                        };
                        sample_slice(level, &s, &t, u, v, grads, &mut colors).unwrap();
                        let out = columns.each_mut().map(|c| &mut c[..]);
                        sample_soa(level, &s, &t, &at, out).unwrap();
                        for (i, want) in colors.iter().enumerate() {
                            let found = columns.each_ref().map(|c| c[i]);
                            assert!(same_bits(found, *want), "{what} {i}: {found:?} {want:?}");
                        }
                        sample_rgba8_slice(level, &s, &t, u, v, grads, &mut bytes).unwrap();
                        sample_rgba8_soa(level, &s, &t, &at, &mut byte_columns).unwrap();
                        assert_eq!(byte_columns, bytes, "{what}");
                        // Bytes are the whole colour where the sampler says so, and only there.
                        let whole = bytes.iter().zip(&colors).all(|(b, c)| {
                            b.to_le_bytes().map(|b| f32::from(b) * (1.0 / 255.0)) == *c
                        });
                        assert!(whole || !is_exact_in_rgba8(&s, &t), "{what}");
                    }
                }
            }
        }
    }
    let s = Sampler::default();
    let (_, t) = textures().remove(0);
    let at = Columns {
        u: &[0.0; 3],
        v: &[0.0; 3],
        gradients: Some([&[0.0; 3], &[0.0; 3], &[0.0; 2], &[0.0; 3]]),
    };
    let e = sample_rgba8_soa(Level::new(), &s, &t, &at, &mut [0; 3]).unwrap_err();
    assert!(e.to_string().contains("gradients"), "{e}");
}

/// The byte form gives the bytes of the float form.
#[test]
fn byte_slices_equal_float_slices() {
    let places = places(5);
    let n = places.u.len();
    let (mut bytes, mut colors) = (vec![0; n], vec![[0.0; 4]; n]);
    for (name, t) in textures() {
        for filter in filters() {
            let s = Sampler {
                filter,
                precision: Precision::Fast,
                ..Sampler::default()
            };
            for (level_name, level) in levels() {
                sample_rgba8_slice(
                    level,
                    &s,
                    &t,
                    &places.u,
                    &places.v,
                    Some(&places.d),
                    &mut bytes,
                )
                .unwrap();
                sample_slice(
                    level,
                    &s,
                    &t,
                    &places.u,
                    &places.v,
                    Some(&places.d),
                    &mut colors,
                )
                .unwrap();
                for (a, b) in bytes.iter().zip(&colors) {
                    let b = u32::from_le_bytes(b.map(texmap_math::color::unit_to_u8));
                    assert_eq!(*a, b, "{name} {filter:?} {level_name}");
                }
            }
        }
    }
}

/// Look-ups by a function for stages of one's own, as many at a time as there are lanes.
#[inline(always)]
fn stage<I: ByteIsa>(
    i: I,
    at: &Places,
    d: &[Vec<f32>; 4],
    out: &mut [u32],
    look_up: impl Fn([I::F32; 2], [I::F32; 4]) -> I::U32,
) {
    for (k, out) in out.chunks_exact_mut(I::LANES).enumerate() {
        let k = k * I::LANES;
        let uv = [i.load_f32(&at.u[k..]), i.load_f32(&at.v[k..])];
        look_up(uv, d.each_ref().map(|d| i.load_f32(&d[k..]))).store(out);
    }
}

/// [`stage`] by the kernel of a bound texture. Each kernel is a function of its own: one with all of them takes minutes to compile. The
/// long ones exist at the width of their level alone, for the same reason.
macro_rules! stages {
    ($($name:ident($($wide:ident)?): $i:ident, $view:ident, $uv:ident, $d:ident => $look_up:expr;)*) => {$(
        #[inline(never)]
        fn $name(
            level: Level,
            $view: &BoundTexture<'_>,
            at: &Places,
            d: &[Vec<f32>; 4],
            out: &mut [u32],
        ) {
            #[inline(always)]
            fn run<I: ByteIsa>(
                $i: I,
                $view: &BoundTexture<'_>,
                at: &Places,
                d: &[Vec<f32>; 4],
                out: &mut [u32],
            ) {
                stage($i, at, d, out, #[inline(always)] |$uv, $d| $look_up);
            }
            dispatch_simd!(level, $($wide)? i => run(i, $view, at, d, out));
        }
    )*};
}

/// A kernel of [`stages`]: level, texture, coordinates, derivatives, and the words that it gives.
type StageFn = fn(Level, &BoundTexture<'_>, &Places, &[Vec<f32>; 4], &mut [u32]);

stages! {
    nearest(): i, view, uv, _d => packed::nearest_lanes(i, view, uv[0], uv[1]);
    nearest_wide(wide): i, view, uv, _d => packed::nearest_lanes(i, view, uv[0], uv[1]);
    bilinear(): i, view, uv, _d => packed::bilinear_lanes(i, view, uv[0], uv[1]);
    bilinear_wide(wide): i, view, uv, _d => packed::bilinear_lanes(i, view, uv[0], uv[1]);
    trilinear(): i, view, uv, d => {
        let d = FootprintLanes::new(i, view, d[0], d[1], d[2], d[3]);
        packed::trilinear_lanes(i, view, uv[0], uv[1], packed::lod_lanes(i, view, &d))
    };
    anisotropic(): i, view, uv, d => {
        let d = FootprintLanes::new(i, view, d[0], d[1], d[2], d[3]);
        packed::anisotropic_lanes(i, view, uv[0], uv[1], &d)
    };
}

#[test]
fn stages_give_the_bits_of_single_samples_on_every_level_and_width() {
    let places = places(3);
    let d = [
        places.d.iter().map(|d| d.du_dx).collect::<Vec<_>>(),
        places.d.iter().map(|d| d.dv_dx).collect(),
        places.d.iter().map(|d| d.du_dy).collect(),
        places.d.iter().map(|d| d.dv_dy).collect(),
    ];
    let mut out = vec![0; places.u.len() / 16 * 16];
    for t in [random_bytes(64, 32, 3), random_bytes(63, 57, 4)] {
        let t = t.with_mips().with_summed_area();
        for filter in [
            Filter::Nearest,
            Filter::Bilinear,
            Filter::Trilinear,
            Filter::Anisotropic(16),
        ] {
            for wrap_u in WRAPS {
                let s = Sampler {
                    filter,
                    wrap_u,
                    precision: Precision::Fast,
                    ..Sampler::default()
                };
                let view = BoundTexture::new(&s, &t).expect("a texture has texels");
                let want: Vec<u32> = (0..out.len())
                    .map(|i| {
                        let c = s.sample_grad(&t, [places.u[i], places.v[i]], places.d[i]);
                        u32::from_le_bytes(c.map(texmap_math::color::unit_to_u8))
                    })
                    .collect();
                let stages: &[StageFn] = match view.kind {
                    Kernel::Nearest => &[nearest, nearest_wide],
                    Kernel::Bilinear => &[bilinear, bilinear_wide],
                    Kernel::Trilinear => &[trilinear],
                    _ => &[anisotropic],
                };
                for (name, level) in levels() {
                    for (form, stage) in stages.iter().enumerate() {
                        out.fill(0);
                        stage(level, &view, &places, &d, &mut out);
                        assert_eq!(out, want, "{filter:?} {wrap_u:?} {name}, form {form}");
                    }
                }
            }
        }
    }
}

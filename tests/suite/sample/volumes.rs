//! Batches of look-ups in volumes, and rays through them: the bits of one at a time, on every SIMD level and the forced fallback.

use crate::support::{Random, WRAPS, filters};
use texmap_sample::{
    Alpha, ColorSpace, Filter, Image, Lod, Origin, Sampler, TexelData, Texture2d, Texture3d,
    UvwBatch, VolumeIntegrator, Wrap, sample_3d_soa,
};
use texmap_tests::levels::levels;

fn bytes([w, h, d]: [u32; 3], color: ColorSpace, alpha: Alpha) -> Texture3d<'static> {
    let mut random = Random::new(u64::from(w * h));
    let texels: Vec<u8> = (0..w * h * d * 4).map(|_| random.word() as u8).collect();
    let slices = Image {
        width: w,
        height: h,
        channels: 4,
        texels: TexelData::U8(&texels),
        color,
        alpha,
        origin: Origin::BottomLeft,
    };
    Texture3d::new(d, &slices).unwrap()
}

fn floats([w, h, d]: [u32; 3], channels: u32) -> Texture3d<'static> {
    let mut random = Random::new(u64::from(w));
    let texels: Vec<f32> = (0..w * h * d * channels)
        .map(|_| random.range(0.0, 3.0))
        .collect();
    let slices = Image {
        width: w,
        height: h,
        channels,
        texels: TexelData::F32(&texels),
        color: ColorSpace::Linear,
        alpha: Alpha::Data,
        origin: Origin::TopLeft,
    };
    Texture3d::new(d, &slices).unwrap()
}

pub(super) fn volumes() -> [(&'static str, Texture3d<'static>); 5] {
    let linear = ColorSpace::Linear;
    [
        (
            "data 8x8x4",
            bytes([8, 8, 4], linear, Alpha::Data).with_mips(),
        ),
        (
            "soft 7x5x9",
            bytes([7, 5, 9], ColorSpace::Srgb, Alpha::Straight).with_mips(),
        ),
        (
            "data 16x2x3, no levels",
            bytes([16, 2, 3], linear, Alpha::Data),
        ),
        ("floats 5x6x7", floats([5, 6, 7], 3).with_mips()),
        ("one row of floats", floats([9, 1, 1], 1).with_mips()),
    ]
}

/// Sweeps, random points near and far, and the numbers that break things.
fn points() -> [Vec<f32>; 4] {
    let mut random = Random::new(5);
    let mut all = [const { Vec::new() }; 4];
    let mut push = |p: [f32; 4]| all.iter_mut().zip(p).for_each(|(all, c)| all.push(c));
    for i in 0..160 {
        let t = i as f32 * 0.0131 - 0.4;
        push([t, 0.3 + 0.7 * t, 1.0 - t, (i / 16) as f32 * 0.5 - 1.0]);
    }
    for _ in 0..200 {
        let mut c = |reach: f32| random.range(-reach, reach);
        push([c(3.0), c(3.0), c(3.0), c(4.0)]);
    }
    let hard = [
        f32::NAN,
        f32::INFINITY,
        f32::NEG_INFINITY,
        1e30,
        -1e-30,
        0.0,
        1.0,
        65536.25,
        0.999_999_94,
    ];
    for a in hard {
        for b in hard {
            push([a, b, 0.3, 0.7]);
            push([b, 0.7, a, b]);
        }
    }
    assert_ne!(all[0].len() % 16, 0);
    all
}

#[test]
fn batches_of_volumes_equal_single_look_ups_on_every_level() {
    let [u, v, w, lod] = points();
    let mut out = [(); 4].map(|()| vec![0.0; u.len()]);
    for (name, t) in &volumes() {
        for (k, filter) in filters().into_iter().enumerate() {
            for (j, wrap_w) in WRAPS.into_iter().enumerate() {
                let s = Sampler {
                    filter,
                    wrap_u: WRAPS[(j + k) % 5],
                    wrap_v: WRAPS[(2 * j + k) % 5],
                    border: [0.3, 0.5, 0.7, 0.9],
                    lod: Lod {
                        bias: 0.3,
                        ..Lod::default()
                    },
                    ..Sampler::default()
                };
                for lod in [None, Some(&lod[..])] {
                    let at = UvwBatch {
                        u: &u,
                        v: &v,
                        w: &w,
                        lod,
                    };
                    for (level_name, level) in levels() {
                        let columns = out.each_mut().map(|c| &mut c[..]);
                        sample_3d_soa(level, &s, t, wrap_w, &at, columns).unwrap();
                        for i in 0..u.len() {
                            let level_of = lod.map_or(0.0, |lod| lod[i]);
                            let one = s.sample_3d(t, [u[i], v[i], w[i]], wrap_w, level_of);
                            let found = [0, 1, 2, 3].map(|k| out[k][i]);
                            assert_eq!(
                                found.map(f32::to_bits),
                                one.map(f32::to_bits),
                                "{name} {filter:?} {wrap_w:?} {level_name} {:?} {level_of}: {found:?} {one:?}",
                                [u[i], v[i], w[i]]
                            );
                        }
                    }
                }
            }
        }
    }
}

#[test]
fn rays_see_the_same_on_every_level() {
    let ramp = Texture2d::from_rgba8(
        3,
        1,
        [[0, 0, 0, 0], [90, 20, 10, 30], [255, 255, 220, 255]].concat(),
        ColorSpace::Srgb,
        Origin::TopLeft,
    )
    .unwrap();
    let along = Sampler {
        filter: Filter::Bilinear,
        wrap_u: Wrap::ClampToEdge,
        ..Sampler::default()
    };
    for (name, t) in &volumes() {
        for filter in [Filter::Nearest, Filter::Trilinear] {
            for transfer in [None, Some((&ramp, &along))] {
                // Thin, and so dense that rays end within a vector of steps.
                for density in [0.7, 60.0] {
                    let s = Sampler {
                        filter,
                        ..Sampler::default()
                    };
                    let one = VolumeIntegrator::new(t, &s, transfer, density, 0.03).unwrap();
                    for (level_name, level) in levels() {
                        let lanes = one.clone().on_level(level);
                        let mut seen = 0;
                        for i in 0..20 {
                            let at = f64::from(i) / 20.0;
                            let ray = ([-1.0, 0.9 * at, 0.9 - 0.5 * at], [0.9, 0.05, -0.02]);
                            let span = (0.0, if i % 3 == 0 { 1.37 } else { 1e9 });
                            let (a, b) = (
                                one.integrate(ray.0, ray.1, span),
                                lanes.integrate(ray.0, ray.1, span),
                            );
                            assert_eq!(
                                (a.color.map(f32::to_bits), a.steps),
                                (b.color.map(f32::to_bits), b.steps),
                                "{name} {filter:?} {density} {level_name} {i}"
                            );
                            seen += usize::from(a.color[3] > 0.0);
                        }
                        assert!(seen > 10, "{name}: rays see what is there");
                    }
                }
            }
        }
    }
}

#[test]
fn columns_of_different_lengths_are_named() {
    let (_, t) = &volumes()[0];
    let (long, short) = ([0.0; 3], [0.0; 2]);
    let at = UvwBatch {
        u: &long,
        v: &long,
        w: &short,
        lod: None,
    };
    let mut out = [[0.0; 3]; 4];
    let columns = out.each_mut().map(|c| &mut c[..]);
    let s = Sampler::default();
    let error = sample_3d_soa(levels()[0].1, &s, t, Wrap::Repeat, &at, columns);
    assert_eq!(
        error.unwrap_err().to_string(),
        "w holds 2 entries, the coordinates have 3"
    );
}

//! Textures that are not a plain plane: lines, volumes, cubes, atlases, tables. Comparison and
//! dependent look-ups.

use crate::support::{Random, WRAPS, float_texture, random_bytes, random_floats};
use texmap_math::Footprint;
use texmap_sample::{
    Alpha, AtlasRect, ColorSpace, Compare, Filter, Image, Origin, Sampler, TexelData, Texture1d,
    Texture3d, TextureCube, Wrap, cube_direction, cube_face,
};

fn floats<'a>(width: u32, height: u32, channels: u32, texels: &'a [f32]) -> Image<'a> {
    Image {
        width,
        height,
        channels,
        texels: TexelData::F32(texels),
        color: ColorSpace::Linear,
        alpha: Alpha::Data,
        origin: Origin::TopLeft,
    }
}

#[test]
fn a_line_is_a_texture_of_one_row() {
    let ramp: Vec<f32> = (0..8).map(|i| i as f32).collect();
    let t = Texture1d::new(&floats(8, 1, 1, &ramp)).unwrap();
    let s = Sampler {
        filter: Filter::Bilinear,
        wrap_u: Wrap::ClampToEdge,
        ..Sampler::default()
    };
    for k in 0..=64 {
        let u = k as f32 / 64.0;
        let want = (u * 8.0 - 0.5).clamp(0.0, 7.0);
        assert!((s.sample_1d(&t, u, 0.0)[0] - want).abs() < 1e-5);
    }
    assert!(Texture1d::new(&floats(4, 2, 1, &ramp)).is_err());
}

/// Trilinear in 3D against the eight texels written out in f64; every level keeps the mean.
#[test]
fn volumes_blend_eight_texels() {
    let (w, h, d) = (5_u32, 4, 3);
    let mut random = Random::new(3);
    let texels: Vec<f32> = (0..w * h * d).map(|_| random.unit()).collect();
    let t = Texture3d::new(d, &floats(w, h, 1, &texels)).unwrap();
    let s = Sampler {
        filter: Filter::Bilinear,
        ..Sampler::default()
    };
    let texel = |x: i64, y: i64, z: i64| {
        let (x, y, z) = (x.rem_euclid(5), y.rem_euclid(4), z.rem_euclid(3));
        f64::from(texels[((z * 4 + y) * 5 + x) as usize])
    };
    for _ in 0..2000 {
        let p = [
            random.range(-2.0, 2.0),
            random.range(-2.0, 2.0),
            random.range(-2.0, 2.0),
        ];
        let q = [
            f64::from(p[0]) * 5.0 - 0.5,
            f64::from(p[1]) * 4.0 - 0.5,
            f64::from(p[2]) * 3.0 - 0.5,
        ];
        let mut want = 0.0;
        for k in 0..8_i64 {
            let at = [
                q[0].floor() as i64 + (k & 1),
                q[1].floor() as i64 + (k >> 1 & 1),
                q[2].floor() as i64 + (k >> 2),
            ];
            let w: f64 = (0..3).map(|a| 1.0 - (q[a] - at[a] as f64).abs()).product();
            want += w * texel(at[0], at[1], at[2]);
        }
        let got = f64::from(s.sample_3d(&t, p, Wrap::Repeat, 0.0)[0]);
        assert!((got - want).abs() < 2e-5, "{p:?} {got} {want}");
    }
    let mips = t.with_mips();
    assert_eq!(mips.levels(), 3);
    assert_eq!(mips.level_size(2), Some([1, 1, 1]));
    let mean = texels.iter().map(|t| f64::from(*t)).sum::<f64>() / 60.0;
    let s = Sampler {
        filter: Filter::MipNearest,
        ..Sampler::default()
    };
    assert!((f64::from(s.sample_3d(&mips, [0.3; 3], Wrap::Repeat, 9.0)[0]) - mean).abs() < 1e-6);
    for bad in [f32::NAN, f32::INFINITY, 1e30] {
        for wrap in WRAPS {
            assert!(s.sample_3d(&mips, [bad; 3], wrap, bad)[0].is_finite());
        }
    }
}

fn directions(count: u32) -> impl Iterator<Item = [f32; 3]> {
    let mut random = Random::new(17);
    (0..count).map(move |_| {
        [
            random.range(-1.0, 1.0),
            random.range(-1.0, 1.0),
            random.range(-1.0, 1.0),
        ]
    })
}

/// Property 27: scale invariance, range, round trip.
#[test]
fn cube_coordinates_round_trip() {
    for d in directions(20_000) {
        let (face, [s, t]) = cube_face(d);
        assert!((0.0..=1.0).contains(&s) && (0.0..=1.0).contains(&t));
        assert_eq!(cube_face(d.map(|c| c * 4.0)), (face, [s, t]));
        let back = cube_direction(face, [f64::from(s), f64::from(t)]);
        let d = d.map(f64::from);
        let major = d.iter().fold(0.0_f64, |m, c| m.max(c.abs()));
        for k in 0..3 {
            // Twice the bound of s and t.
            assert!(
                (back[k] - d[k] / major).abs() <= 2.0_f64.powi(-22),
                "{d:?} {back:?}"
            );
        }
    }
    // Ties: z before y before x; nothing and not-a-number look along +z.
    assert_eq!(cube_face([1.0, 1.0, 1.0]).0, 4);
    assert_eq!(cube_face([1.0, -1.0, 0.5]).0, 3);
    assert_eq!(cube_face([-1.0, 0.5, 0.5]).0, 1);
    assert_eq!(cube_face([0.0; 3]).0, 4);
    assert_eq!(cube_face([f32::NAN, 1.0, 0.0]).0, 4);
}

/// Property 27: neighbours agree on their shared edges, in f64.
#[test]
fn faces_share_their_edges() {
    for face in 0..6 {
        for k in 1..20 {
            let a = f64::from(k) / 20.0;
            for place in [[0.0, a], [1.0, a], [a, 0.0], [a, 1.0]] {
                let d = cube_direction(face, place);
                let ties = d.iter().filter(|c| (c.abs() - 1.0).abs() < 1e-12).count();
                assert_eq!(ties, 2, "face {face} {place:?}");
            }
        }
    }
}

/// A plane-wave sum on directions, as the environment scenes have it.
fn waves(f: f64) -> impl Fn([f64; 3]) -> f64 {
    let mut random = Random::new(64);
    let terms: Vec<([f64; 3], f64)> = (0..64)
        .map(|_| {
            loop {
                let k = [0; 3].map(|_| f64::from(random.range(-1.0, 1.0)));
                let l = k.iter().map(|c| c * c).sum::<f64>().sqrt();
                if (0.1..=1.0).contains(&l) {
                    break (
                        k.map(|c| c / l),
                        f64::from(random.range(0.0, core::f32::consts::TAU)),
                    );
                }
            }
        })
        .collect();
    move |d| {
        let l = d.iter().map(|c| c * c).sum::<f64>().sqrt();
        let sum: f64 = terms
            .iter()
            .map(|(k, p)| (f / l * (k[0] * d[0] + k[1] * d[1] + k[2] * d[2]) + p).cos())
            .sum();
        (2.0_f64 / 64.0).sqrt() * sum
    }
}

fn wave_cube(n: u32, f: f64) -> TextureCube<'static> {
    let wave = waves(f);
    let faces: Vec<Vec<f32>> = (0..6)
        .map(|face| {
            (0..n * n)
                .map(|i| {
                    let place = [i % n, i / n].map(|k| (f64::from(k) + 0.5) / f64::from(n));
                    wave(cube_direction(face, place)) as f32
                })
                .collect()
        })
        .collect();
    TextureCube::new(&[0, 1, 2, 3, 4, 5].map(|i: usize| floats(n, n, 1, &faces[i]))).unwrap()
}

/// E1. Near edges and corners the seamless look-up errs no more than its measured figure; a clamped
/// one (here: each direction pushed half a texel into its face) errs twice as much.
#[test]
fn cube_edges_are_seamless() {
    let n = 64;
    let t = wave_cube(n, 10.0);
    let wave = waves(10.0);
    let s = Sampler {
        filter: Filter::Bilinear,
        ..Sampler::default()
    };
    let mut random = Random::new(5);
    let (mut seamless, mut clamped) = (0.0_f64, 0.0_f64);
    for k in 0..60_000 {
        let mut d = [
            random.range(-1.0, 1.0),
            random.range(-1.0, 1.0),
            random.range(-1.0, 1.0),
        ];
        // Onto an edge, every fourth onto a corner, off by 1e-3.
        let (i, j) = (k % 3, (k + 1) % 3);
        d[i] = random.range(0.999, 1.001);
        d[j] = random.range(0.999, 1.001) * if k & 8 == 0 { 1.0 } else { -1.0 };
        if k % 4 == 0 {
            d[(k + 2) % 3] = random.range(0.999, 1.001);
        }
        let truth = wave(d.map(f64::from));
        seamless = seamless.max((f64::from(s.sample_cube(&t, d, 0.0)[0]) - truth).abs());
        let (face, place) = cube_face(d);
        let inner = place.map(|c| f64::from(c.clamp(0.5 / n as f32, 1.0 - 0.5 / n as f32)));
        let pushed = cube_direction(face, inner).map(|c| c as f32);
        clamped = clamped.max((f64::from(s.sample_cube(&t, pushed, 0.0)[0]) - truth).abs());
    }
    assert!(seamless <= 1.1 * 0.051, "{seamless}");
    assert!(clamped > 1.8 * seamless, "{clamped} {seamless}");
}

/// No jump across any edge or corner: the two sides of a seam differ by rounding alone.
#[test]
fn no_jump_crosses_a_seam() {
    let mut random = Random::new(8);
    let faces: Vec<Vec<f32>> = (0..6)
        .map(|_| (0..16 * 16).map(|_| random.unit()).collect())
        .collect();
    let t = TextureCube::new(&[0, 1, 2, 3, 4, 5].map(|i: usize| floats(16, 16, 1, &faces[i])))
        .unwrap()
        .with_mips();
    for filter in [Filter::Bilinear, Filter::Trilinear] {
        let s = Sampler {
            filter,
            ..Sampler::default()
        };
        for k in 0..3000 {
            let mut a = [random.range(-1.0, 1.0); 3];
            let (i, j) = (k % 3, (k + 1) % 3);
            a[i] = 1.0;
            a[j] = if k & 4 == 0 { 1.0 } else { -1.0 };
            let mut b = a;
            a[i] += 1e-5;
            b[j] *= 1.0 + 1e-5;
            let lod = random.range(0.0, 2.0);
            let (x, y) = (s.sample_cube(&t, a, lod)[0], s.sample_cube(&t, b, lod)[0]);
            assert!((x - y).abs() < 2e-3, "{a:?} {b:?} {x} {y}");
        }
    }
}

#[test]
fn a_constant_cube_is_constant() {
    let face = vec![0.3_f32; 7 * 7 * 4];
    let t = TextureCube::new(&[floats(7, 7, 4, &face); 6])
        .unwrap()
        .with_mips();
    let s = Sampler::default();
    for d in directions(5000) {
        let c = s.sample_cube_grad(&t, d, [0.3, 0.0, 0.1], [0.0, 0.2, 0.0]);
        assert!(c.iter().all(|c| (c - 0.3).abs() < 1e-7), "{d:?} {c:?}");
    }
    assert!(s.sample_cube_grad(&t, [f32::NAN; 3], [f32::INFINITY; 3], [1e30; 3])[0].is_finite());
}

/// H7. The mean of comparisons, not the comparison of the mean.
#[test]
fn shadows_compare_before_they_filter() {
    let t = float_texture(2, 1, 1, &[0.2, 0.8]);
    let s = Sampler {
        filter: Filter::Bilinear,
        wrap_u: Wrap::ClampToEdge,
        wrap_v: Wrap::ClampToEdge,
        ..Sampler::default()
    };
    for k in 0..=32 {
        let u = k as f32 / 32.0;
        let lit = s.sample_compare(&t, [u, 0.5], 0.5, Compare::LessEqual);
        let want = (u * 2.0 - 0.5).clamp(0.0, 1.0);
        assert!((lit - want).abs() < 1e-6, "{u} {lit}");
        let other = s.sample_compare(&t, [u, 0.5], 0.5, Compare::GreaterEqual);
        assert!((lit + other - 1.0).abs() < 1e-6);
    }
    // Outside a map with a border of "nothing near" all is lit; not-a-number is dark.
    let s = Sampler {
        wrap_u: Wrap::ClampToBorder,
        wrap_v: Wrap::ClampToBorder,
        border: [1.0; 4],
        ..s
    };
    assert_eq!(
        s.sample_compare(&t, [5.0, 0.5], 0.9, Compare::LessEqual),
        1.0
    );
    assert_eq!(
        s.sample_compare(&t, [1e30, f32::NAN], 0.9, Compare::LessEqual),
        1.0
    );
    assert_eq!(
        s.sample_compare(&t, [0.5, 0.5], f32::NAN, Compare::LessEqual),
        0.0
    );
}

/// E6. Nothing of the neighbours shows inside a rectangle with a gutter, at the levels used.
#[test]
fn atlas_rectangles_do_not_bleed() {
    // A white 8x8 rectangle with a white gutter of 4 in a black 32x32 atlas.
    let texels: Vec<f32> = (0..32 * 32)
        .map(|i| {
            f32::from(u8::from(
                (4..20).contains(&(i % 32)) && (4..20).contains(&(i / 32)),
            ))
        })
        .collect();
    let atlas = float_texture(32, 32, 1, &texels).with_mips();
    let rect = AtlasRect::new(&atlas, 8, 8, 8, 8, 4).unwrap();
    assert_eq!(rect.max_lod(), 2.0);
    let s = Sampler {
        filter: Filter::Trilinear,
        ..Sampler::default()
    };
    let mut random = Random::new(6);
    for _ in 0..3000 {
        let uv = [random.range(-2.0, 3.0), random.range(-2.0, 3.0)];
        let d = Footprint::new(random.range(0.0, 3.0), 0.0, 0.0, 0.1);
        let c = rect.sample_grad(&s, &atlas, uv, d)[0];
        assert!(c > 1.0 - 1.0 / 255.0, "{uv:?} {d:?} {c}");
    }
    // A rectangle that does not begin with a texel of a level, and filters with long footprints.
    let texels: Vec<f32> = (0..32 * 32)
        .map(|i| f32::from(u8::from(i % 32 > 0)))
        .collect();
    let atlas = float_texture(32, 32, 1, &texels).with_mips();
    for (x, gutter, most) in [(5, 4, 1.0), (2, 1, 0.0), (8, 4, 2.0), (9, 6, 2.0)] {
        let rect = AtlasRect::new(&atlas, x, 8, 8, 8, gutter).unwrap();
        assert_eq!(rect.max_lod(), most, "{x} {gutter}");
        for filter in [
            Filter::Trilinear,
            Filter::Anisotropic(16),
            Filter::Ewa {
                ratio: 16,
                percent: 75,
            },
        ] {
            let s = Sampler {
                filter,
                ..Sampler::default()
            };
            for _ in 0..300 {
                let uv = [random.range(0.0, 1.0), random.range(0.0, 1.0)];
                let d = Footprint::new(random.range(0.0, 3.0), 0.0, 0.0, 0.05);
                let c = rect.sample_grad(&s, &atlas, uv, d)[0];
                assert!(c > 0.999, "{x} {gutter} {filter:?} {uv:?} {d:?}: {c}");
            }
        }
    }
    assert!(AtlasRect::new(&atlas, 2, 8, 8, 8, 4).is_err());
    assert!(AtlasRect::new(&atlas, 8, 8, 0, 8, 4).is_err());
}

/// Repeating inside a rectangle takes the texels of a texture of its own.
#[test]
fn atlas_rectangles_wrap_within() {
    let atlas = random_bytes(32, 16, 3);
    let rect = AtlasRect::new(&atlas, 4, 3, 8, 6, 0).unwrap();
    let s = Sampler {
        filter: Filter::Nearest,
        ..Sampler::default()
    };
    let mut random = Random::new(2);
    for _ in 0..1000 {
        let (i, j) = (random.word() % 8, random.word() % 6);
        let turns = [
            (random.word() % 5) as f32 - 2.0,
            (random.word() % 5) as f32 - 2.0,
        ];
        let uv = [
            turns[0] + (i as f32 + 0.5) / 8.0,
            turns[1] + (j as f32 + 0.5) / 6.0,
        ];
        let c = rect.sample_grad(&s, &atlas, uv, Footprint::default());
        assert_eq!(Some(c), atlas.texel(0, 4 + i, 3 + j));
    }
}

/// The footprint of the second look-up is the finite difference of the first.
#[test]
fn dependent_look_ups_carry_their_derivative() {
    let texels: Vec<f32> = (0..16 * 16)
        .flat_map(|i| {
            let (x, y) = ((i % 16) as f32 / 16.0, (i / 16) as f32 / 16.0);
            [0.5 * x + 0.2 * y, 0.9 * y - 0.1 * x]
        })
        .collect();
    let first = texmap_sample::Texture2d::new(&floats(16, 16, 2, &texels)).unwrap();
    let s = Sampler {
        filter: Filter::Bilinear,
        ..Sampler::default()
    };
    let [value, du, dv] = s.sample_with_gradient(&first, [0.41, 0.57], 0.0);
    let h = 1.0 / 512.0;
    let (a, b) = (
        s.sample(&first, [0.41 + h, 0.57]),
        s.sample(&first, [0.41, 0.57 + h]),
    );
    for k in 0..2 {
        assert!(
            ((a[k] - value[k]) / h - du[k]).abs() < 1e-3
                && ((b[k] - value[k]) / h - dv[k]).abs() < 1e-3
        );
    }
    // Through the affine first texture, the look-up equals one with the composed footprint.
    let second = random_floats(64, 64, 9).with_mips();
    let t = Sampler {
        filter: Filter::Trilinear,
        ..Sampler::default()
    };
    let d = Footprint::new(0.02, 0.01, -0.01, 0.03);
    let got = s.sample_through_ramp(&first, [0.41, 0.57], d, &t, &second);
    let inner = Footprint::new(
        0.5 * d.du_dx + 0.2 * d.dv_dx,
        -0.1 * d.du_dx + 0.9 * d.dv_dx,
        0.5 * d.du_dy + 0.2 * d.dv_dy,
        -0.1 * d.du_dy + 0.9 * d.dv_dy,
    );
    let want = t.sample_grad(&second, [value[0], value[1]], inner);
    for k in 0..4 {
        assert!((got[k] - want[k]).abs() < 1e-3, "{got:?} {want:?}");
    }
    // Negative twin: with the outer footprint it would be another colour.
    let wrong = t.sample_grad(&second, [value[0], value[1]], d);
    assert!((0..4).any(|k| (wrong[k] - want[k]).abs() > 5e-3));
}

//! Batches of look-ups in cubes: the bits of one at a time, on every SIMD level and the forced fallback.

use crate::support::{Random, filters};
use texmap_sample::{
    Alpha, ColorSpace, DirectionBatch, Filter, Image, Lod, Origin, Sampler, TexelData, TextureCube,
    Wrap, cube_direction, sample_cube_soa,
};
use texmap_tests::levels::levels;

/// Random bytes; opaque, of one of two alphas, or of any.
pub(super) fn cube(
    side: u32,
    color: ColorSpace,
    alpha: impl Fn(u32) -> u8,
) -> TextureCube<'static> {
    let mut random = Random::new(u64::from(side));
    let faces: Vec<Vec<u8>> = (0..6)
        .map(|_| {
            let texel = |_| {
                let c = random.word();
                [c as u8, (c >> 8) as u8, (c >> 16) as u8, alpha(c >> 24)]
            };
            (0..side * side).flat_map(texel).collect()
        })
        .collect();
    let image = |face: usize| Image {
        width: side,
        height: side,
        channels: 4,
        texels: TexelData::U8(&faces[face]),
        color,
        alpha: Alpha::Straight,
        origin: Origin::TopLeft,
    };
    let cube = TextureCube::new(&[0, 1, 2, 3, 4, 5].map(image));
    cube.unwrap().with_mips()
}

/// Random light beyond one, and below none.
fn bright(side: u32) -> TextureCube<'static> {
    let mut random = Random::new(u64::from(side));
    let faces: Vec<Vec<f32>> = (0..6)
        .map(|_| {
            (0..side * side * 3)
                .map(|_| random.range(-1.0, 90.0))
                .collect()
        })
        .collect();
    let image = |face: usize| Image {
        width: side,
        height: side,
        channels: 3,
        texels: TexelData::F32(&faces[face]),
        color: ColorSpace::Linear,
        alpha: Alpha::Straight,
        origin: Origin::TopLeft,
    };
    let cube = TextureCube::new(&[0, 1, 2, 3, 4, 5].map(image));
    cube.unwrap().with_mips()
}

/// Sweeps over faces and across edges, corners, random directions of any length, and the numbers that break things.
fn directions() -> Vec<[f32; 3]> {
    let mut random = Random::new(7);
    let mut all = Vec::new();
    for i in 0..400 {
        let turn = i as f32 * 0.031;
        all.push([turn.cos(), 0.8 * (turn * 0.7).sin(), turn.sin()]);
    }
    for _ in 0..600 {
        let mut c = || random.range(-1.0, 1.0);
        let (d, scale) = (
            [c(), c(), c()],
            4.0_f32.powi((random.word() % 9) as i32 - 4),
        );
        all.push(d.map(|c| c * scale));
    }
    for face in 0..6 {
        for (s, t) in [
            (0.0, 0.0),
            (0.5, 0.0),
            (1.0, 0.999),
            (0.25, 0.75),
            (0.003, 0.5),
        ] {
            all.push(cube_direction(face, [s, t]).map(|c| c as f32));
        }
    }
    let hard = [
        0.0,
        -0.0,
        1.0,
        -1.0,
        f32::NAN,
        f32::INFINITY,
        1e30,
        -1e-40,
        1e-45,
        f32::MAX,
    ];
    for x in hard {
        for y in hard {
            all.extend(hard.map(|z| [x, y, z]));
        }
    }
    assert_ne!(all.len() % 16, 0);
    all
}

#[test]
fn batches_of_cubes_equal_single_look_ups_on_every_level() {
    let directions = directions();
    let [x, y, z] = [0, 1, 2].map(|k| directions.iter().map(|d| d[k]).collect::<Vec<f32>>());
    let mut random = Random::new(3);
    let hard = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -0.0, 2.0, 3.0];
    let lods: Vec<f32> = (0..x.len())
        .map(|i| match i / 32 % 3 {
            0 => 1.25,
            1 => random.range(-1.0, 8.0),
            _ => hard[i % hard.len()],
        })
        .collect();
    let cubes = [
        ("opaque", cube(16, ColorSpace::Linear, |_| 255)),
        (
            "keyed",
            cube(13, ColorSpace::Linear, |a| if a > 99 { 255 } else { 0 }),
        ),
        ("soft", cube(32, ColorSpace::Srgb, |a| a as u8)),
        ("one texel", cube(1, ColorSpace::Srgb, |_| 255)),
        ("floats", bright(11)),
    ];
    let mut out = [(); 4].map(|()| vec![0.0; x.len()]);
    for (name, t) in &cubes {
        for filter in filters() {
            for (lod, bias) in [(None, 0.0), (Some(&lods[..]), 0.3)] {
                let sampler = Sampler {
                    filter,
                    // Cubes have no wrap.
                    wrap_u: Wrap::ClampToBorder,
                    lod: Lod {
                        bias,
                        ..Lod::default()
                    },
                    ..Sampler::default()
                };
                let at = DirectionBatch {
                    x: &x,
                    y: &y,
                    z: &z,
                    lod,
                };
                for (name_of_level, level) in levels() {
                    let columns = out.each_mut().map(|c| &mut c[..]);
                    sample_cube_soa(level, &sampler, t, &at, columns).unwrap();
                    for (i, d) in directions.iter().enumerate() {
                        let one = sampler.sample_cube(t, *d, lod.map_or(0.0, |lod| lod[i]));
                        let batch = [0, 1, 2, 3].map(|k| out[k][i]);
                        assert_eq!(
                            batch.map(f32::to_bits),
                            one.map(f32::to_bits),
                            "{name} {filter:?} {name_of_level} {d:?} {lod:?}",
                            lod = lod.map(|lod| lod[i]),
                        );
                    }
                }
            }
        }
    }
}

#[test]
fn columns_of_different_lengths_are_named() {
    let t = cube(2, ColorSpace::Linear, |_| 255);
    let (long, short) = ([0.0; 3], [0.0; 2]);
    let at = DirectionBatch {
        x: &long,
        y: &long,
        z: &short,
        lod: None,
    };
    let mut out = [[0.0; 3]; 4];
    let columns = out.each_mut().map(|c| &mut c[..]);
    let error = sample_cube_soa(levels()[0].1, &Sampler::default(), &t, &at, columns);
    assert_eq!(
        error.unwrap_err().to_string(),
        "z holds 2 entries, the coordinates have 3"
    );
}

/// The rows of a face lie from the top, whatever the origin of its image, also where faces of other channels are beside it.
#[test]
fn faces_have_their_rows_from_the_top() {
    let cube = |origin: Origin, soft: bool| {
        let texels = |face: usize| -> Vec<f32> {
            let alpha = if soft && face == 3 { 0.5 } else { 1.0 };
            let upper = [1.0, 0.0, 0.0, alpha].map(|c| c * alpha);
            let lower = [0.0, 0.0, 1.0, alpha].map(|c| c * alpha);
            [upper, upper, lower, lower].into_iter().flatten().collect()
        };
        let faces: Vec<Vec<f32>> = (0..6).map(texels).collect();
        let image = |face: usize| Image {
            width: 2,
            height: 2,
            channels: 4,
            texels: TexelData::F32(&faces[face]),
            color: ColorSpace::Linear,
            alpha: Alpha::Straight,
            origin,
        };
        TextureCube::new(&[0, 1, 2, 3, 4, 5].map(image)).unwrap()
    };
    let sampler = Sampler {
        filter: Filter::Nearest,
        ..Sampler::default()
    };
    for soft in [false, true] {
        for origin in [Origin::TopLeft, Origin::BottomLeft] {
            let up = sampler.sample_cube(&cube(origin, soft), [0.1, 0.5, 1.0], 0.0);
            assert!(up[0] > 0.9 && up[2] < 0.1, "{origin:?} {soft}: {up:?}");
        }
    }
}

//! Lane helpers give the bits of their scalar versions on every level.

use texmap_math::fearless_simd::{dispatch, f32x16, prelude::*, u16x32, u32x16};
use texmap_math::lanes;
use texmap_math::simd::{Scalar, X16, encode_srgb8, encode_unorm8, prelude::*};
use texmap_math::{color, dispatch_simd};
use texmap_tests::levels::levels;

const HARD: [f32; 16] = [
    0.0,
    -0.0,
    0.5,
    -0.5,
    0.999_999_94,
    -1e-30,
    1.0,
    -1.0,
    2.5,
    -2.5,
    8_388_607.5,
    -8_388_607.5,
    2_147_483_500.0,
    -2_147_483_500.0,
    1e-45,
    -255.5,
];

#[test]
fn gathers_read_the_same_words_and_stay_inside() {
    let data: Vec<u32> = (0..1000u32).map(|i| i.wrapping_mul(0x9e37_79b9)).collect();
    let words = lanes::GatherTable::new(&data).expect("not empty");
    let one = lanes::GatherTable::new(&data[..1]).expect("not empty");
    assert!(lanes::GatherTable::new(&[]).is_none());
    let indices = [
        0,
        1,
        2,
        999,
        1000,
        1001,
        0x7fff_ffff,
        0x8000_0000,
        u32::MAX,
        u32::MAX - 1,
        500,
        499,
        7,
        7,
        7,
        998,
    ];
    for (name, level) in levels() {
        for source in [words, one] {
            let want = indices.map(|i| source.get(i));
            let read = dispatch!(level, s => {
                <[u32; 16]>::from(lanes::gather(s, source, u32x16::from_slice(s, &indices)))
            });
            assert_eq!(read, want, "{name}");
        }
        let pairs = [0, 1, 2, 997, 998, 500, 499, 7, 7, 7, 0, 996, 33, 64, 65, 66];
        let read = dispatch!(level, s => {
            lanes::gather_pairs(s, words, u32x16::from_slice(s, &pairs)).map(<[u32; 16]>::from)
        });
        let want = [0, 1].map(|next| pairs.map(|i| words.get(i + next)));
        assert_eq!(read, want, "{name}");
        let through_memory = dispatch!(level, s => {
            X16(s).gather_pairs_at(words, &pairs).map(<[u32; 16]>::from)
        });
        assert_eq!(through_memory, want, "{name}");
        // Fours, the last of which ends with the last word, and indices that reach beyond it.
        let quads = pairs.map(|i| i.min(996));
        let want = [0, 1, 2, 3].map(|next| quads.map(|i| words.get(i + next)));
        dispatch!(level, s => {
            let index = u32x16::from_slice(s, &quads);
            let found = lanes::gather_quads(s, words, index);
            let through_memory = lanes::gather_quads_at(s, words, &quads);
            assert_eq!(found.is_some(), lanes::is_wide(s), "{name}");
            assert_eq!(through_memory.is_some(), lanes::is_wide(s), "{name}");
            for found in [found, through_memory].into_iter().flatten() {
                assert_eq!(found.map(<[u32; 16]>::from), want, "{name}");
            }
            for lane in [0, 7, 8, 15] {
                let mut beyond = quads;
                beyond[lane] = 997;
                let index = u32x16::from_slice(s, &beyond);
                assert!(lanes::gather_quads(s, words, index).is_none(), "{name} {lane}");
                assert!(lanes::gather_quads_at(s, words, &beyond).is_none(), "{name} {lane}");
                beyond[lane] = 999;
                assert!(lanes::gather_pairs_at(s, words, &beyond).is_none(), "{name} {lane}");
            }
            assert!(lanes::gather_quads_at(s, one, &[0; 16]).is_none(), "{name}");
            assert!(lanes::gather_pairs_at(s, one, &[0; 16]).is_none(), "{name}");
        });
        // The last triple ends with the last word: a load of four would go beyond it.
        let triples = [0, 1, 2, 993, 997, 500, 499, 7, 7, 7, 0, 996, 33, 64, 65, 66];
        for triples in [
            triples,
            triples.map(|i| i.min(996)),
            indices.map(|i| i & i32::MAX as u32),
        ] {
            for (source, len) in [(words, 1000), (one, 1)] {
                let read = dispatch!(level, s => {
                    X16(s).gather_triples(source, u32x16::from_slice(s, &triples)).map(<[u32; 16]>::from)
                });
                let want = [0, 1, 2].map(|next| triples.map(|i| source.get(i + next)));
                assert_eq!(read, want, "{name}");
                let quads = dispatch!(level, s => {
                    lanes::gather_quads(s, source, u32x16::from_slice(s, &triples)).map(|quads| quads.map(<[u32; 16]>::from))
                });
                let within = triples.iter().all(|i| *i as usize + 4 <= len);
                assert!(within || quads.is_none(), "{name}");
                if let Some(quads) = quads {
                    assert_eq!(
                        quads,
                        [0, 1, 2, 3].map(|next| triples.map(|i| source.get(i + next))),
                        "{name}"
                    );
                }
            }
        }
        // Beyond the end: nothing that counts, and no fault.
        for source in [words, one] {
            dispatch!(level, s => {
                _ = lanes::gather_pairs(s, source, u32x16::from_slice(s, &indices));
            });
        }
    }
}

#[test]
fn small_tables_are_read_by_index() {
    let table: [u32; 16] = std::array::from_fn(|i| 0x9e37_79b9_u32.wrapping_mul(i as u32 + 1));
    let index = [15, 0, 8, 7, 3, 3, 12, 1, 9, 14, 2, 11, 4, 5, 13, 6];
    for (name, level) in levels() {
        let read = dispatch!(level, s => {
            <[u32; 16]>::from(lanes::lookup16(s, &table, u32x16::from_slice(s, &index)))
        });
        assert_eq!(read, index.map(|i| table[i as usize]), "{name}");
    }
}

#[test]
fn octets_are_read_by_index() {
    let table: [f32; 8] = std::array::from_fn(|i| HARD[i]);
    for (name, level) in levels() {
        for turn in 0..8 {
            let index: [u32; 16] = std::array::from_fn(|i| (i as u32 * 5 + turn) % 8);
            let read = dispatch!(level, s => {
                <[f32; 16]>::from(lanes::lookup8(s, &table, u32x16::from_slice(s, &index)))
            });
            for (read, i) in read.into_iter().zip(index) {
                assert_eq!(read.to_bits(), table[i as usize].to_bits(), "{name} {i}");
            }
        }
    }
}

#[inline(always)]
fn helpers<I: Isa>(i: I, x: &[f32; 16]) -> ([i32; 16], [u32; 16], [f32; 16]) {
    let mut out = ([0; 16], [0; 16], [0.0; 16]);
    for at in (0..16).step_by(I::LANES) {
        let x = i.load_f32(&x[at..]);
        x.floor_to_i32().store(&mut out.0[at..]);
        encode_unorm8(i, x).store(&mut out.1[at..]);
        x.clamp(i.f32(-0.25), i.f32(3.0)).store(&mut out.2[at..]);
    }
    out
}

#[test]
fn helpers_equal_their_scalar_forms() {
    for (name, level) in levels() {
        for wide in [false, true] {
            let run = |x: &[f32; 16]| match wide {
                true => dispatch_simd!(level, wide i => helpers(i, x)),
                false => dispatch_simd!(level, i => helpers(i, x)),
            };
            let (floor, unit, clamped) = run(&HARD);
            for (i, x) in HARD.into_iter().enumerate() {
                assert_eq!(floor[i], F32s::<Scalar>::floor_to_i32(x).0, "{name} {x}");
                assert_eq!(
                    i64::from(floor[i]),
                    f64::from(x).floor() as i64,
                    "{name} {x}"
                );
                assert_eq!(unit[i], u32::from(color::unit_to_u8(x)), "{name} {x}");
                let want = F32s::<Scalar>::clamp(x, -0.25, 3.0);
                assert_eq!(clamped[i].to_bits(), want.to_bits(), "{name} {x}");
            }
            let nan = run(&[f32::NAN; 16]);
            assert_eq!(nan.1, [0; 16], "{name}: NaN stores as 0");
            assert_eq!(nan.2, [-0.25; 16], "{name}: NaN clamps to the low end");
        }
    }
}

/// Zeros of both signs and NaN on either side: the second operand wherever the comparison is not true.
#[test]
fn above_and_below_are_comparison_and_selection() {
    let pick = |x: f32, y: f32, first: bool| if first { x } else { y }.to_bits();
    let hard = HARD.into_iter().chain([f32::NAN, -f32::NAN, f32::INFINITY]);
    let turned: [f32; 16] = std::array::from_fn(|i| HARD[(i * 7 + 1) % 16]);
    for (name, level) in levels() {
        for x in hard.clone() {
            for others in [HARD, turned, [f32::NAN; 16]] {
                let (over, under, swapped) = dispatch!(level, s => {
                    let (x, y) = (f32x16::splat(s, x), f32x16::from_slice(s, &others));
                    let array = |v| <[f32; 16]>::from(v);
                    (
                        array(F32s::<X16<_>>::above(x, y)),
                        array(F32s::<X16<_>>::below(x, y)),
                        array(F32s::<X16<_>>::above(y, x)),
                    )
                });
                for (i, y) in others.into_iter().enumerate() {
                    assert_eq!(over[i].to_bits(), pick(x, y, x > y), "{name} {x} {y}");
                    assert_eq!(under[i].to_bits(), pick(x, y, x < y), "{name} {x} {y}");
                    assert_eq!(swapped[i].to_bits(), pick(y, x, y > x), "{name} {y} {x}");
                }
            }
        }
    }
}

/// All bytes between all others, at all weights.
#[test]
fn bytes_are_mixed_alike_on_every_level() {
    for (name, level) in levels() {
        for a in 0..=255_u16 {
            for b in (0..=255_u16).step_by(if a % 15 == 0 { 1 } else { 51 }) {
                for first in (0..256_u16).step_by(32) {
                    let w: [u16; 32] = std::array::from_fn(|i| first + i as u16);
                    let mixed: [u16; 32] = dispatch!(level, s => {
                        let (a, b) = (u16x32::splat(s, a), u16x32::splat(s, b));
                        lanes::lerp_bytes(s, a, b, u16x32::from_slice(s, &w)).into()
                    });
                    for (mixed, w) in mixed.into_iter().zip(w.map(u32::from)) {
                        let want = (u32::from(a) * (256 - w) + u32::from(b) * w + 128) >> 8;
                        assert_eq!(u32::from(mixed), want, "{name}: {a} {b} {w}");
                    }
                }
            }
        }
    }
}

#[test]
fn srgb_codes_in_lanes_are_those_of_the_scalar_form_for_every_f32() {
    for (name, level) in levels() {
        dispatch_simd!(level, i => compare_all_codes(i, name));
        for x in [
            0.0,
            -0.0,
            -1.0,
            2.0,
            f32::INFINITY,
            -f32::INFINITY,
            f32::NAN,
            1e-30,
        ] {
            dispatch_simd!(level, i => compare_codes(i, name, [x, 0.2, 0.2]));
            dispatch_simd!(level, i => compare_codes(i, name, [0.2, x, 0.2]));
            dispatch_simd!(level, i => compare_codes(i, name, [0.2, 0.2, x]));
        }
    }
}

/// All floats between the one that is sRGB 0 for sure and 1, each channel the lanes behind those of the one before.
#[inline(always)]
fn compare_all_codes<I: Isa>(i: I, name: &str) {
    let mut bits = [0, 1, 2].map(|k| i.iota().to_u32() + (0x38ff_ffd0 + k * I::LANES as u32));
    for first in (0x38ff_ffd0..0x3f80_0030_u32).step_by(3 * I::LANES) {
        let codes = encode_srgb8(i, bits.map(|bits| bits.to_f32_bits()));
        let code = |bits| u32::from(color::linear_to_srgb8(f32::from_bits(bits)));
        // The scalar form never falls: what is equal at both ends is equal between them.
        let last = first + 3 * I::LANES as u32 - 1;
        if code(first) == code(last) {
            let expected = code(first) * 0x1_0101;
            assert!(codes.simd_eq(expected).all_true(), "{name} {first:x}");
        } else {
            for k in 0..I::LANES as u32 {
                let at = [0, 1, 2].map(|channel| first + channel * I::LANES as u32 + k);
                let [r, g, b] = at.map(code);
                let expected = r | (g << 8) | (b << 16);
                assert_eq!(lane(i, codes, k), expected, "{name} {at:x?}");
            }
        }
        bits = bits.map(|bits| bits + 3 * I::LANES as u32);
    }
}

#[inline(always)]
fn compare_codes<I: Isa>(i: I, name: &str, colour: [f32; 3]) {
    let [r, g, b] = colour.map(|c| u32::from(color::linear_to_srgb8(c)));
    let codes = encode_srgb8(i, colour.map(|c| i.f32(c)));
    let equal = codes.simd_eq(r | (g << 8) | (b << 16));
    assert!(equal.all_true(), "{name} {colour:?}: {codes:?}");
}

fn lane<I: Isa>(_: I, x: I::U32, k: u32) -> u32 {
    let mut lanes = [0; 16];
    x.store(&mut lanes);
    lanes[k as usize]
}

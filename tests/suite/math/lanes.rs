//! Lane helpers give the bits of their scalar twins on every level.

use texmap_math::color;
use texmap_math::fearless_simd::{Simd, dispatch, f32x16, i32x16, prelude::*, u16x32, u32x16};
use texmap_math::lanes;
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
        // The last triple ends with the last word: a load of four would go beyond it.
        let triples = [0, 1, 2, 993, 997, 500, 499, 7, 7, 7, 0, 996, 33, 64, 65, 66];
        for triples in [
            triples,
            triples.map(|i| i.min(996)),
            indices.map(|i| i & i32::MAX as u32),
        ] {
            for (source, len) in [(words, 1000), (one, 1)] {
                let read = dispatch!(level, s => {
                    lanes::gather_triples(s, source, u32x16::from_slice(s, &triples)).map(<[u32; 16]>::from)
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
fn helpers<S: Simd>(s: S, x: [f32; 16]) -> ([i32; 16], [u32; 16], [f32; 16], [f32; 16]) {
    let x = f32x16::from_slice(s, &x);
    let floor: i32x16<S> = lanes::floor_to_i32(s, x);
    let unit = lanes::unit_to_u8(s, x);
    let clamped = lanes::clamp(x, f32x16::splat(s, -0.25), f32x16::splat(s, 3.0));
    let lerp = lanes::lerp_two_product(x, f32x16::splat(s, 7.0), f32x16::splat(s, 0.3));
    (floor.into(), unit.into(), clamped.into(), lerp.into())
}

#[test]
fn helpers_equal_their_scalar_twins() {
    for (name, level) in levels() {
        let (floor, unit, clamped, lerp) = dispatch!(level, s => helpers(s, HARD));
        for (i, x) in HARD.into_iter().enumerate() {
            assert_eq!(floor[i], lanes::floor_to_i32_scalar(x), "{name} {x}");
            assert_eq!(
                i64::from(floor[i]),
                f64::from(x).floor() as i64,
                "{name} {x}"
            );
            assert_eq!(unit[i], u32::from(color::unit_to_u8(x)), "{name} {x}");
            assert_eq!(
                clamped[i].to_bits(),
                lanes::clamp_scalar(x, -0.25, 3.0).to_bits(),
                "{name} {x}"
            );
            let want = texmap_math::interpolation::lerp_two_product(x, 7.0, 0.3);
            assert_eq!(lerp[i].to_bits(), want.to_bits(), "{name} {x}");
        }
        let nan = dispatch!(level, s => helpers(s, [f32::NAN; 16]));
        assert_eq!(nan.1, [0; 16], "{name}: NaN stores as 0");
        assert_eq!(nan.2, [-0.25; 16], "{name}: NaN clamps to the low end");
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
                    (array(lanes::above(x, y)), array(lanes::below(x, y)), array(lanes::above(y, x)))
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

/// Every part of the table from edge to edge, both sides of every place where the scalar form steps, and what lies outside.
#[test]
fn srgb_bytes_in_lanes_equal_the_scalar_form() {
    let mut hard = vec![
        0.0,
        -0.0,
        -1.0,
        1.0,
        2.0,
        f32::INFINITY,
        f32::NAN,
        1e-30,
        1e-4,
    ];
    for part in 0x3900_u32..=0x3f80 {
        let start = part << 16;
        hard.extend([0, 1, 0x7fff, 0xffff].map(|low| f32::from_bits(start + low)));
    }
    for byte in 0..255_u8 {
        // The step between two bytes by bisection of the bits.
        let (mut low, mut high) = (0, 1.0_f32.to_bits());
        while low + 1 < high {
            let middle = low.midpoint(high);
            if color::linear_to_srgb8(f32::from_bits(middle)) > byte {
                high = middle;
            } else {
                low = middle;
            }
        }
        hard.extend([low, high].map(f32::from_bits));
    }
    for (name, level) in levels() {
        for sixteen in hard.chunks(16) {
            let found: [u32; 16] = dispatch!(level, s => {
                lanes::linear_to_srgb8(s, lanes::load_tail(s, sixteen)).into()
            });
            for (&x, found) in sixteen.iter().zip(found) {
                assert_eq!(found, u32::from(color::linear_to_srgb8(x)), "{name} {x:e}");
            }
        }
    }
}

#[test]
fn tails_keep_their_values() {
    for (name, level) in levels() {
        for n in 0..=16 {
            let mut out = vec![0.0; n];
            dispatch!(level, s => lanes::store_tail(lanes::load_tail(s, &HARD[..n]), &mut out));
            assert_eq!(out, HARD[..n], "{name}");
        }
    }
}

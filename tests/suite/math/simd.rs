//! Kernels over lane widths. Each operation gives the scalar's bits in every lane, on every level and width.

use texmap_math::lanes::GatherTable;
use texmap_math::simd::{ByteIsa, Isa, Scalar, prelude::*};
use texmap_math::{dispatch_simd, float};
use texmap_tests::levels::levels;

const LEFT: [f32; 16] = [
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
    f32::NAN,
];
const RIGHT: [f32; 16] = [
    -0.0,
    0.0,
    f32::NAN,
    3.0,
    -7.25,
    1e30,
    1.0,
    -1.0,
    -2.5,
    0.1,
    1e-38,
    255.5,
    -3.0,
    f32::INFINITY,
    f32::NEG_INFINITY,
    1.0,
];
const WORDS: [u32; 16] = [
    0,
    1,
    2,
    7,
    999,
    1000,
    0x7fff_ffff,
    0x8000_0000,
    u32::MAX,
    31,
    255,
    256,
    65_535,
    65_536,
    0xdead_beef,
    42,
];

/// Every operation of one lane, as words: NaN as one word, since its payload is no result.
const RESULTS: usize = 61;

/// Vectors from the numbers at `at` on, then once more from the first.
fn vectors(at: usize) -> [[f32; 3]; 16] {
    std::array::from_fn(|k| [0, 5, 9].map(|c| LEFT[(at + k + c) % 16] * 0.5))
}

#[inline(always)]
fn every_operation<I: ByteIsa>(i: I, at: usize, table: &[u32], out: &mut [[u32; 16]; RESULTS]) {
    let (x, y) = (i.load_f32(&LEFT[at..]), i.load_f32(&RIGHT[at..]));
    let small = x.above(i.f32(-1e9)).below(i.f32(1e9));
    let n = small.to_i32();
    let w = i.load_u32(&WORDS[at..]);
    let v = (w >> 2) & 31;
    let words = GatherTable::new(table).expect("not empty");
    let [first, second] = i.gather_pairs(words, w & 511);
    let wide = i.widen(x) * 3.0 + i.widen(y) / 7.0 - i.f64(0.25);
    let vector = i.load_xyz(&vectors(at)[..I::LANES]);
    let triple = i.gather_triples(words, w & 1023);
    let mut by_turns = [0; 32];
    let [low, high] = i.interleave(w, v);
    low.store(&mut by_turns);
    high.store(&mut by_turns[I::LANES..]);
    let mut apart = [0; 32];
    let [even, odd] = i.deinterleave(low, high);
    even.store(&mut apart);
    odd.store(&mut apart[I::LANES..]);
    let positive = wide.simd_gt(0.0).select(wide, i.f64(2.0)).sqrt();
    let floats = [
        x + y,
        x + 0.1,
        x - y,
        x - 0.1,
        x * y,
        x * 0.1,
        x / y,
        x / 0.3,
        -x,
        x.abs(),
        x.abs().sqrt(),
        x.above(y),
        y.below(x),
        x.clamp(i.f32(-1.0), i.f32(2.0)),
        x.simd_eq(y).select(x, y),
        x.simd_lt(y).select(x, y),
        x.simd_le(y).select(x, y),
        x.simd_gt(0.5).select(x, y),
        x.simd_ge(y).select(x, y),
        n.to_f32(),
        i.narrow(wide),
        i.narrow(positive),
        i.table8(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0], w & 7),
        (w & 0x3fff_ffff).to_f32_bits(),
        vector[0],
        vector[1],
        vector[2],
    ];
    let (left, right) = (i.bytes(w), i.bytes(first));
    let [a, b, c, d] = i.byte_sums(i.add_bytes(left, right, n.simd_lt(4)));
    let weights = i.weights((v << 3).to_i32());
    let integers = [
        (small * 0.7).floor_to_i32().to_u32(),
        n.to_u32(),
        (n + n).to_u32(),
        (n - 7).to_u32(),
        (n * n).to_u32(),
        (-n).to_u32(),
        n.min(n * 3).to_u32(),
        n.max(i.i32(-5)).to_u32(),
        (n >> 3).to_u32(),
        (n << 3).to_u32(),
        n.simd_lt(4).select(n, i.i32(4)).to_u32(),
        w + w,
        w * 0x9e37_79b9,
        w - 1,
        (w & 0xff) | (w ^ v),
        w >> 3,
        w << 5,
        w.min(v).max(i.u32(3)),
        w.simd_gt(0x7fff_ffff).select(w, v),
        i.gather(words, w),
        first,
        second,
        i.table16(&WORDS, w & 15),
        small.floor().to_bits(),
        (n >> v.to_i32()).to_u32(),
        i.words(i.lerp_bytes(left, right, weights)),
        a,
        b,
        c,
        d,
        triple[0],
        triple[1],
        triple[2],
    ];
    let mut ints = [0; 16];
    n.store(&mut ints);
    assert_eq!(i.first(n), ints[0]);
    let mut lanes = [0.0; 16];
    let mut k = 0;
    for x in floats {
        x.store(&mut lanes);
        for lane in 0..I::LANES {
            let x = lanes[lane];
            out[k][at + lane] = if x.is_nan() { 0x7fc0_0000 } else { x.to_bits() };
        }
        k += 1;
    }
    for x in integers {
        x.store(&mut out[k][at..]);
        k += 1;
    }
    let masks = [
        x.simd_lt(y) & !x.simd_eq(0.0) | w.simd_eq(42) ^ i.mask(true),
        i.mask_from_bits(0x5af3 >> at),
    ];
    for lane in 0..I::LANES {
        out[k][at + lane] = masks
            .iter()
            .enumerate()
            .map(|(bit, mask)| (mask.to_bitmask() >> lane & 1) << bit)
            .sum();
    }
    for mask in masks {
        let bits = mask.to_bitmask();
        assert_eq!(mask.any_true(), bits != 0);
        assert_eq!(mask.all_true(), bits == ((1_u64 << I::LANES) - 1) as u32);
    }
    for lane in 0..I::LANES {
        let pair = [WORDS[at + lane], WORDS[at + lane] >> 2 & 31];
        assert_eq!(by_turns[2 * lane..2 * lane + 2], pair);
        assert_eq!([apart[lane], apart[I::LANES + lane]], pair);
    }
    let pairs = wide.simd_lt(positive) | !wide.simd_ge(0.0);
    assert_eq!(pairs.any_true(), pairs.to_bitmask() != 0);
}

#[inline(always)]
fn all<I: ByteIsa>(i: I, table: &[u32], out: &mut [[u32; 16]; RESULTS]) {
    for at in (0..16).step_by(I::LANES) {
        every_operation(i, at, table, out);
    }
}

#[test]
fn every_operation_is_that_of_the_scalar_on_every_level_and_width() {
    let table: Vec<u32> = (0..1000_u32).map(|i| i.wrapping_mul(0x9e37_79b9)).collect();
    let mut want = [[0; 16]; RESULTS];
    all(Scalar, &table, &mut want);
    for (name, level) in levels() {
        let mut narrow = [[1; 16]; RESULTS];
        dispatch_simd!(level, i => all(i, &table, &mut narrow));
        assert_eq!(narrow, want, "{name}");
        let mut wide = [[1; 16]; RESULTS];
        dispatch_simd!(level, wide i => all(i, &table, &mut wide));
        assert_eq!(wide, want, "{name}, wide");
    }
    // The scalars themselves, by Rust's own words.
    assert_eq!(want[0][3], (LEFT[3] + RIGHT[3]).to_bits());
    assert_eq!(want[10][8], float::sqrt_f32(2.5).to_bits());
    assert_eq!(want[27][3] as i32, -1, "floor of -0.35");
    assert_eq!(want[38][8], u32::MAX.wrapping_add(u32::MAX));
}

/// The table of [`dispatch_simd`] gives the widths that it promises.
#[test]
fn levels_take_the_lanes_of_the_table() {
    for (name, level) in levels() {
        let lanes = dispatch_simd!(level, i => lanes_of(i));
        let wide = dispatch_simd!(level, wide i => lanes_of(i));
        let want = match name {
            "avx512" | "avx2" => (16, 16),
            "fallback" => (1, 1),
            _ => (4, 16),
        };
        assert_eq!((lanes, wide), want, "{name}");
    }
}

#[inline(always)]
fn lanes_of<I: Isa>(_: I) -> usize {
    I::LANES
}

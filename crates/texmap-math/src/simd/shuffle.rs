//! Reordering of lanes: vectors of three components in memory to one register a component.

use fearless_simd::{Simd, SimdBase, f32x4, f32x16};

/// The x, the y and the z of four vectors.
#[inline(always)]
pub(super) fn load_xyz_x4<S: Simd>(s: S, words: &[f32]) -> [f32x4<S>; 3] {
    let a = f32x4::from_slice(s, &words[..4]);
    let b = f32x4::from_slice(s, &words[4..8]);
    let c = f32x4::from_slice(s, &words[8..12]);
    // Each round doubles the distance between neighbours; four words need two rounds.
    let [a, b, c] = spread(s, a, b, c);
    spread(s, a, b, c)
}

/// The x, the y and the z of sixteen vectors. Scalar stores before wide loads would stall for longer than a formula takes.
#[inline(always)]
pub(super) fn load_xyz_x16<S: Simd>(s: S, words: &[f32]) -> [f32x16<S>; 3] {
    let [x0, y0, z0] = load_xyz_x4(s, &words[..12]);
    let [x1, y1, z1] = load_xyz_x4(s, &words[12..24]);
    let [x2, y2, z2] = load_xyz_x4(s, &words[24..36]);
    let [x3, y3, z3] = load_xyz_x4(s, &words[36..48]);
    [
        join(s, x0, x1, x2, x3),
        join(s, y0, y1, y2, y3),
        join(s, z0, z1, z2, z3),
    ]
}

#[inline(always)]
fn join<S: Simd>(s: S, a: f32x4<S>, b: f32x4<S>, c: f32x4<S>, d: f32x4<S>) -> f32x16<S> {
    s.combine_f32x8(s.combine_f32x4(a, b), s.combine_f32x4(c, d))
}

#[inline(always)]
fn spread<S: Simd>(s: S, a: f32x4<S>, b: f32x4<S>, c: f32x4<S>) -> [f32x4<S>; 3] {
    [
        s.zip_low_f32x4(a, s.slide_f32x4::<2>(b, b)),
        s.zip_low_f32x4(s.slide_f32x4::<2>(a, a), c),
        s.zip_low_f32x4(b, s.slide_f32x4::<2>(c, c)),
    ]
}

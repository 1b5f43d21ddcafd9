//! Bilinear look-ups in the faces of an environment, the border among the texels.

use texmap_math::fearless_simd::{Simd, f32x16, i32x16, prelude::*};
use texmap_math::lanes::{Words, floor_to_i32, floor_to_i32_scalar, gather_pairs, gather_triples};

use crate::environment::Level;
use crate::lanes::V3;
use crate::packed::unpack_lanes;

/// Four texels of a face.
pub(super) fn on_face(
    level: Level,
    face: usize,
    place: [f32; 2],
    texel: impl Fn(usize) -> [f32; 3],
) -> [f32; 3] {
    let split = |c: f32, n: u32| {
        let c = c * n as f32 + 0.5;
        let low = floor_to_i32_scalar(c);
        let low = if low < n as i32 { low } else { n as i32 };
        (low, c - low as f32)
    };
    let ((x, a), (y, b)) = (split(place[0], level.width), split(place[1], level.height));
    let stride = level.width as usize + 2;
    let first = level.index(face, x as usize, y as usize);
    let row = |at: usize| {
        let (p, q) = (texel(at), texel(at + 1));
        [0, 1, 2].map(|i| p[i] * (1.0 - a) + q[i] * a)
    };
    let (p, q) = (row(first), row(first + stride));
    [0, 1, 2].map(|i| p[i] * (1.0 - b) + q[i] * b)
}

/// Where the texels of a level begin, and how large its faces are.
pub(super) struct LevelLanes<S: Simd> {
    pub(super) start: i32x16<S>,
    pub(super) width: i32x16<S>,
    pub(super) height: i32x16<S>,
}

/// [`on_face`] for sixteen.
#[inline(always)]
pub(super) fn on_face_lanes<S: Simd, const PACKED: bool>(
    s: S,
    words: Words<'_>,
    level: &LevelLanes<S>,
    face: i32x16<S>,
    u: f32x16<S>,
    v: f32x16<S>,
) -> V3<S> {
    let (x, a) = split_lanes(s, u, level.width);
    let (y, b) = split_lanes(s, v, level.height);
    let stride = level.width + 2;
    let first = level.start + (face * (level.height + 2) + y) * stride + x;
    let one = f32x16::splat(s, 1.0);
    let (a1, b1) = (one - a, one - b);
    let [p, q] = two_lanes::<S, PACKED>(s, words, first);
    let mut top = p;
    for i in 0..3 {
        top[i] = p[i] * a1 + q[i] * a;
    }
    let [p, q] = two_lanes::<S, PACKED>(s, words, first + stride);
    let mut out = top;
    for i in 0..3 {
        let bottom = p[i] * a1 + q[i] * a;
        out[i] = top[i] * b1 + bottom * b;
    }
    out
}

/// A texel and the one to its right.
#[inline(always)]
fn two_lanes<S: Simd, const PACKED: bool>(s: S, words: Words<'_>, at: i32x16<S>) -> [V3<S>; 2] {
    if PACKED {
        let [left, right] = gather_pairs(s, words, at.bitcast());
        return [unpack_lanes(s, left), unpack_lanes(s, right)];
    }
    [texel_lanes(s, words, at), texel_lanes(s, words, at + 1)]
}

#[inline(always)]
fn texel_lanes<S: Simd>(s: S, words: Words<'_>, at: i32x16<S>) -> V3<S> {
    let [r, g, b] = gather_triples(s, words, (at * 3).bitcast());
    [r.bitcast(), g.bitcast(), b.bitcast()]
}

/// Column or row of a coordinate, and how far it is to the next.
#[inline(always)]
fn split_lanes<S: Simd>(s: S, c: f32x16<S>, n: i32x16<S>) -> (i32x16<S>, f32x16<S>) {
    let c = c * n.to_float::<f32x16<S>>() + 0.5;
    let low = floor_to_i32(s, c);
    let low = low.simd_lt(n).select(low, n);
    (low, c - low.to_float::<f32x16<S>>())
}

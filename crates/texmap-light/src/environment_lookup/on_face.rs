//! Bilinear look-ups in the faces of an environment, the border among the texels.

use texmap_math::lanes::GatherTable;
use texmap_math::simd::{Isa, prelude::*};

use crate::lanes::Vector;
use crate::{packed, shared_exponent};

/// A form in which texels are stored.
pub(crate) trait Texels {
    /// A texel and the one to its right, in the units of the texels.
    fn two<I: Isa>(i: I, words: GatherTable<'_>, at: I::I32) -> [Vector<I>; 2];
}

/// Three floats.
pub(crate) struct Floats;

/// The words of [`packed`].
pub(crate) struct Steps;

/// The words of [`shared_exponent`].
pub(crate) struct SharedExponent;

/// Start of the texels of a level, and size of its faces.
pub(super) struct LevelLanes<I: Isa> {
    pub(super) start: I::I32,
    pub(super) width: I::I32,
    pub(super) height: I::I32,
}

/// Four texels of a face, weighted; in the units of the texels.
#[inline(always)]
pub(super) fn on_face<I: Isa, T: Texels>(
    i: I,
    words: GatherTable<'_>,
    level: &LevelLanes<I>,
    face: I::I32,
    u: I::F32,
    v: I::F32,
) -> Vector<I> {
    let (x, a) = split(i, u, level.width);
    let (y, b) = split(i, v, level.height);
    let stride = level.width + 2;
    let first = level.start + (face * (level.height + 2) + y) * stride + x;
    let (a1, b1) = (i.f32(1.0) - a, i.f32(1.0) - b);
    let [p, q] = T::two(i, words, first);
    let mut top = p;
    for k in 0..3 {
        top[k] = p[k] * a1 + q[k] * a;
    }
    let [p, q] = T::two(i, words, first + stride);
    let mut out = top;
    for k in 0..3 {
        let bottom = p[k] * a1 + q[k] * a;
        out[k] = top[k] * b1 + bottom * b;
    }
    out
}

impl Texels for Floats {
    #[inline(always)]
    fn two<I: Isa>(i: I, words: GatherTable<'_>, at: I::I32) -> [Vector<I>; 2] {
        [texel(i, words, at), texel(i, words, at + 1)]
    }
}

impl Texels for Steps {
    #[inline(always)]
    fn two<I: Isa>(i: I, words: GatherTable<'_>, at: I::I32) -> [Vector<I>; 2] {
        let [left, right] = i.gather_pairs(words, at.to_u32());
        [packed::unpack(i, left), packed::unpack(i, right)]
    }
}

impl Texels for SharedExponent {
    #[inline(always)]
    fn two<I: Isa>(i: I, words: GatherTable<'_>, at: I::I32) -> [Vector<I>; 2] {
        let [left, right] = i.gather_pairs(words, at.to_u32());
        [
            shared_exponent::unpack(i, left),
            shared_exponent::unpack(i, right),
        ]
    }
}

#[inline(always)]
fn texel<I: Isa>(i: I, words: GatherTable<'_>, at: I::I32) -> Vector<I> {
    let at = (at * 3).to_u32();
    let [r, g, b] = match i.gather_quads(words, at) {
        Some([r, g, b, _]) => [r, g, b],
        None => [
            i.gather(words, at),
            i.gather(words, at + 1),
            i.gather(words, at + 2),
        ],
    };
    [r.to_f32_bits(), g.to_f32_bits(), b.to_f32_bits()]
}

/// Column or row of a coordinate, and its distance from there.
#[inline(always)]
fn split<I: Isa>(_: I, c: I::F32, n: I::I32) -> (I::I32, I::F32) {
    let c = c * n.to_f32() + 0.5;
    let low = c.floor_to_i32().min(n);
    (low, c - low.to_f32())
}

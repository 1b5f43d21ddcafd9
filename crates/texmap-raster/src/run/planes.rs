//! Planes on their way from the table into lanes.

use texmap_math::fearless_simd::{Simd, f32x16, mask32x16, prelude::*, u32x16};
use texmap_math::lanes::{LANES, clamp, octet};

use super::BlockValues;
use crate::plane_table::COEFFICIENTS;

/// A plane of sixteen slots.
pub(crate) type Plane16 = [[f32; LANES]; COEFFICIENTS];

const NO_PLANE: &Plane16 = &[[0.0; LANES]; COEFFICIENTS];

/// The planes of one slot, where they lie: each block spreads them anew, since a load that spreads costs less than two registers'
/// worth of memory.
#[derive(Clone, Copy)]
pub(crate) struct OnePlanes<'t, const N: usize> {
    pub(crate) w: &'t Plane16,
    pub(crate) attribute: [&'t Plane16; N],
    pub(super) lane: usize,
    pub(super) level: Option<[f32; 2]>,
}

impl<const N: usize> OnePlanes<'_, N> {
    pub(super) const NONE: Self = Self {
        w: NO_PLANE,
        attribute: [NO_PLANE; N],
        lane: 0,
        level: None,
    };

    /// The slot's coefficients of one of the planes.
    #[inline(always)]
    pub(crate) fn own(&self, plane: &Plane16) -> [f32; COEFFICIENTS] {
        plane.each_ref().map(|c| c[self.lane % LANES])
    }

    /// In every lane.
    #[inline(always)]
    pub(super) fn lanes<S: Simd>(&self, s: S) -> Planes<S, N> {
        let (mut planes, lane) = (Planes::zero(s), self.lane % LANES);
        for (to, from) in planes.w.iter_mut().zip(self.w) {
            *to = f32x16::splat(s, from[lane]);
        }
        for (to, from) in planes.attribute.iter_mut().zip(&self.attribute) {
            for (to, from) in to.iter_mut().zip(*from) {
                *to = f32x16::splat(s, from[lane]);
            }
        }
        if let Some([w, r]) = self.level {
            planes.level = Some([f32x16::splat(s, w), f32x16::splat(s, r)]);
        }
        planes
    }

    /// Replaces the values of attributes that are linear on the screen, by their bits of `linear`.
    #[inline(always)]
    pub(super) fn straighten<S: Simd, const D: bool>(
        &self,
        s: S,
        [px, py]: [f32x16<S>; 2],
        linear: u32,
        wanted: &[usize; N],
        values: &mut BlockValues<S, N>,
    ) {
        let planes = self.lanes(s);
        for (k, attribute) in wanted.iter().enumerate() {
            if linear >> attribute & 1 == 1 {
                let [u, a, b] = planes.straight(k, px, py);
                values.value[k] = u;
                if D {
                    (values.ddx[k], values.ddy[k]) = (a, b);
                }
            }
        }
    }
}

/// The planes of sixteen lanes: a, b, c, lo, hi of 1/w and of each attribute.
pub(super) struct Planes<S: Simd, const N: usize> {
    pub(super) w: [f32x16<S>; COEFFICIENTS],
    pub(super) attribute: [[f32x16<S>; COEFFICIENTS]; N],
    /// The planes' 1 / clip w, and its reciprocal, where they are the same at all pixels: their division is the dearest step.
    pub(super) level: Option<[f32x16<S>; 2]>,
}

impl<S: Simd, const N: usize> Planes<S, N> {
    #[inline(always)]
    pub(super) fn zero(s: S) -> Self {
        let zero = f32x16::splat(s, 0.0);
        Self {
            w: [zero; COEFFICIENTS],
            attribute: [[zero; COEFFICIENTS]; N],
            level: None,
        }
    }

    /// Takes over the planes of some pixels.
    #[inline(always)]
    pub(super) fn put(&mut self, pixels: mask32x16<S>, other: &Self) {
        for c in 0..COEFFICIENTS {
            self.w[c] = pixels.select(other.w[c], self.w[c]);
        }
        for k in 0..N {
            for c in 0..COEFFICIENTS {
                self.attribute[k][c] = pixels.select(other.attribute[k][c], self.attribute[k][c]);
            }
        }
    }

    /// Takes over the planes of the pixels whose slots lie in one half of a group, or of all: `within` are their places in it.
    #[inline(always)]
    pub(super) fn put_octet(
        &mut self,
        s: S,
        (words, half): (&[[f32; LANES]], usize),
        within: u32x16<S>,
        wanted: &[usize; N],
        pixels: Option<mask32x16<S>>,
    ) {
        pick(s, &mut self.w, (plane(words, 0), half), within, pixels);
        for (to, k) in self.attribute.iter_mut().zip(wanted) {
            pick(s, to, (plane(words, 1 + k), half), within, pixels);
        }
    }

    /// Wanted attribute `k` as if it were linear on the screen: its value, and its changes to the right and down.
    #[inline(always)]
    pub(super) fn straight(&self, k: usize, px: f32x16<S>, py: f32x16<S>) -> [f32x16<S>; 3] {
        let [a, b, c, lo, hi] = self.attribute[k];
        [clamp((c + b * py) + a * px, lo, hi), a, b]
    }

    /// 1 / clip w at pixels, and its reciprocal.
    #[inline(always)]
    pub(super) fn depth(&self, s: S, px: f32x16<S>, py: f32x16<S>) -> [f32x16<S>; 2] {
        if let Some(level) = self.level {
            return level;
        }
        let [a, b, c, lo, hi] = self.w;
        let w = clamp((c + b * py) + a * px, lo, hi);
        [w, f32x16::splat(s, 1.0) / w]
    }

    #[inline(always)]
    pub(super) fn values<const D: bool>(
        &self,
        s: S,
        px: f32x16<S>,
        py: f32x16<S>,
    ) -> BlockValues<S, N> {
        let [wa, wb, ..] = self.w;
        let [w, r] = self.depth(s, px, py);
        let mut out = BlockValues::zero(s);
        out.inv_w = w;
        for k in 0..N {
            let [a, b, c, lo, hi] = self.attribute[k];
            let u = clamp(((c + b * py) + a * px) * r, lo, hi);
            out.value[k] = u;
            if D {
                out.ddx[k] = (a - u * wa) * r;
                out.ddy[k] = (b - u * wb) * r;
            }
        }
        out
    }
}

/// The coefficients at places in half a group, for some lanes or all. (No closures: they would lose the level's instructions.)
#[inline(always)]
fn pick<S: Simd>(
    s: S,
    to: &mut [f32x16<S>; COEFFICIENTS],
    (from, half): (&Plane16, usize),
    within: u32x16<S>,
    pixels: Option<mask32x16<S>>,
) {
    for (to, from) in to.iter_mut().zip(from) {
        let table = from.as_chunks().0[half % 2];
        let value = octet(s, &table, within);
        *to = match pixels {
            Some(pixels) => pixels.select(value, *to),
            None => value,
        };
    }
}

/// Plane `k` of sixteen slots.
#[inline(always)]
pub(super) fn plane(words: &[[f32; LANES]], k: usize) -> &Plane16 {
    let plane = words.get(k * COEFFICIENTS..).and_then(|w| w.first_chunk());
    plane.unwrap_or(NO_PLANE)
}

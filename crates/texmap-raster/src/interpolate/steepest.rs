//! Bounds on the derivatives of attributes over a triangle's part of a tile: if a bound is small enough, a stage need not ask for
//! derivatives pixel by pixel.

use texmap_math::simd::Isa;

use crate::coverage::stamp::BLOCK_PIXELS;
use crate::interpolate::{FragmentBlock, One, Part};
use crate::setup::TILE;
use crate::setup::plane_table::AttributePlanes;
use crate::{NO_PRIMITIVE, TileVisibility};

/// Part of its terms below which 1/w is too close to the eye's plane to say anything.
const NEAR_ZERO: f32 = 1e-3;
/// Error that rounding may add, as a part of the terms and of the result.
const ROUNDING: f32 = 1e-5;
const SLACK: f32 = 1.01;

impl AttributePlanes {
    /// The slot of all pixels of a block, if they have one.
    #[inline(always)]
    pub fn single_primitive<I: Isa>(
        &self,
        i: I,
        blocks: &TileVisibility,
        block: FragmentBlock,
    ) -> Option<u32> {
        let mut only = None;
        for at in (0..BLOCK_PIXELS).step_by(I::LANES) {
            let part = Part { block, at };
            if I::LANES < BLOCK_PIXELS && part.mask(i) == 0 {
                continue;
            }
            let slots = self.slots_of(i, blocks, part);
            if !slots.one || only.is_some_and(|only| only != slots.first) {
                return None;
            }
            only = Some(slots.first);
        }
        only.filter(|slot| *slot != NO_PRIMITIVE)
    }

    /// Largest magnitudes of the derivatives of attributes `wanted` on a slot's triangle in this tile. Derivatives are changes
    /// per pixel to the right and down, as [`each_block`](Self::each_block) finds them. `None` where f32 planes do not serve the
    /// slot, and near the eye's plane.
    #[must_use]
    pub fn max_gradient<const N: usize>(
        &self,
        slot: u32,
        wanted: [usize; N],
    ) -> Option<[[f32; 2]; N]> {
        if self.odd_setup(slot).is_some() {
            return None;
        }
        let planes = One::new(self, slot);
        let [wa, wb, wc, w_lo, w_hi] = planes.own(0);
        let reach = TILE as f32 / 2.0 - 0.5;
        let corners = [
            (-reach, -reach),
            (reach, -reach),
            (-reach, reach),
            (reach, reach),
        ];
        let w = corners.map(|(x, y)| (wc + wb * y) + wa * x);
        let size = wc.abs() + (wa.abs() + wb.abs()) * reach;
        let least = w.into_iter().fold(f32::INFINITY, f32::min);
        // On the triangle 1/w lies in its hull, whatever it is at the tile's corners.
        let floor = least.max(w_lo);
        if !(least >= NEAR_ZERO * size && floor > 0.0 && w_hi.is_finite()) {
            return None;
        }
        let mut out = [[0.0; 2]; N];
        for (out, k) in out.iter_mut().zip(wanted) {
            let [a, b, c, lo, hi] = planes.own(1 + k);
            if planes.has_linear(k) {
                *out = [a.abs(), b.abs()];
                continue;
            }
            // A quotient of planes is greatest and least at corners.
            let mut range = (f32::INFINITY, f32::NEG_INFINITY);
            for ((x, y), w) in corners.into_iter().zip(w) {
                let u = ((c + b * y) + a * x) / w;
                range = (range.0.min(u), range.1.max(u));
            }
            let (low, high) = (range.0.max(lo), range.1.min(hi));
            let far = low.abs().max(high.abs());
            let change = |a: f32, w: f32| {
                let most = (a - low * w).abs().max((a - high * w).abs());
                (most + (a.abs() + far * w.abs()) * ROUNDING) / floor * SLACK
            };
            *out = [change(a, wa), change(b, wb)];
        }
        out.as_flattened()
            .iter()
            .all(|d| d.is_finite())
            .then_some(out)
    }
}

//! How the triangles of a block are seen: which side, and the normals of their planes.

use texmap_light::lanes::V3;
use texmap_math::fearless_simd::{Simd, f32x16, prelude::*};
use texmap_raster::{Cull, NONE, RunBlock};

use super::LitLanes;
use crate::canvas::{LANES, bits};
use crate::shade::{Facing, Run};
use texmap_math::narrow;

/// A vector of each pixel of a block.
pub(super) type Three = [[f32; LANES]; 3];

/// How a block's triangles are seen.
pub(super) struct Side {
    /// Pixels that show the back of theirs.
    pub(super) back: u16,
    /// Normals of their planes, where shadows read them.
    plane: Three,
    /// The slot that was asked about last.
    last: Seen,
    /// The one that all pixels have, or [`NONE`].
    whole: u32,
}

/// How the triangle of a slot is seen.
#[derive(Clone, Copy)]
struct Seen {
    slot: u32,
    front: bool,
    plane: [f32; 3],
}

impl Side {
    pub(super) fn new() -> Self {
        Self {
            back: 0,
            plane: [[0.0; LANES]; 3],
            last: Seen {
                slot: NONE,
                front: true,
                plane: [0.0; 3],
            },
            whole: NONE,
        }
    }

    #[inline(always)]
    pub(super) fn plane<S: Simd>(&self, s: S) -> V3<S> {
        load(s, &self.plane)
    }
}

impl LitLanes<'_> {
    /// `side` is that of an earlier block of the run.
    pub(super) fn look_aside(&self, run: &Run<'_>, at: RunBlock, side: &mut Side) {
        if self.surface.material.cull == Cull::Back && !self.planes {
            // All show their fronts, as the side says from the start.
            return;
        }
        if at.slot != NONE {
            if side.whole != at.slot {
                side.whole = at.slot;
                let seen = self.seen(run, at.slot, &side.last);
                side.back = if seen.front { 0 } else { u16::MAX };
                side.plane = seen.plane.map(|c| [c; LANES]);
                side.last = seen;
            }
            return;
        }
        (side.whole, side.back) = (NONE, 0);
        for bit in bits(at.mask) {
            side.last = self.seen(run, run.slot(at, bit), &side.last);
            side.back |= u16::from(!side.last.front) << bit;
            for (column, c) in side.plane.iter_mut().zip(side.last.plane) {
                column[bit] = c;
            }
        }
    }

    fn seen(&self, run: &Run<'_>, slot: u32, last: &Seen) -> Seen {
        if slot == last.slot {
            return *last;
        }
        let front = Facing::new(self.surface.material.cull).is_front(run, slot);
        let effects = self.surface.effects.as_ref().filter(|_| self.planes);
        let plane = effects.map_or([0.0; 3], |effects| {
            let (_, triangle) = run.prepared.source(run.blocks.ids[slot as usize]);
            narrow(effects.plane(triangle, front))
        });
        Seen { slot, front, plane }
    }
}

/// A vector of each pixel in lanes.
#[inline(always)]
pub(super) fn load<S: Simd>(s: S, [x, y, z]: &Three) -> V3<S> {
    [
        f32x16::from_slice(s, x),
        f32x16::from_slice(s, y),
        f32x16::from_slice(s, z),
    ]
}

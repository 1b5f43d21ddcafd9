//! The triangles of a block: which side is seen, and the normals of their planes.

use texmap_light::lanes::Vector;
use texmap_math::glam::DVec3;
use texmap_math::narrow;
use texmap_math::simd::Isa;
use texmap_raster::{Cull, FragmentBlock, NO_PRIMITIVE};

use super::batch::{Batch, Facing, LANES, Part, set_bits};

/// The facing stage of a surface.
pub(crate) struct FacingStage<'a> {
    pub(crate) cull: Cull,
    /// Unit normals of the planes of the mesh's triangles, where shadows or painted projectors read them.
    pub(crate) planes: Option<&'a [DVec3]>,
}

/// The side of the triangles of a block that is seen.
pub(crate) struct Side {
    /// Pixels that show the back of theirs.
    pub(crate) back: u16,
    /// Normals of their planes on the side that is seen.
    plane: [[f32; LANES]; 3],
    /// The slot that was asked about last.
    last: Seen,
    /// The slot of all pixels, or [`NO_PRIMITIVE`].
    whole: u32,
}

/// The side of the triangle of a slot.
#[derive(Clone, Copy)]
struct Seen {
    slot: u32,
    front: bool,
    plane: [f32; 3],
}

impl Default for Side {
    fn default() -> Self {
        Self {
            back: 0,
            plane: [[0.0; LANES]; 3],
            last: Seen {
                slot: NO_PRIMITIVE,
                front: true,
                plane: [0.0; 3],
            },
            whole: NO_PRIMITIVE,
        }
    }
}

impl Side {
    #[inline(always)]
    pub(crate) fn plane<I: Isa>(&self, i: I, part: &Part) -> Vector<I> {
        let [x, y, z] = &self.plane;
        [
            i.load_f32(&x[part.pixel..]),
            i.load_f32(&y[part.pixel..]),
            i.load_f32(&z[part.pixel..]),
        ]
    }
}

impl FacingStage<'_> {
    /// `side` is that of an earlier block of the batch.
    pub(crate) fn update(&self, batch: &Batch<'_>, at: FragmentBlock, side: &mut Side) {
        if self.cull == Cull::Back && self.planes.is_none() {
            // All show their fronts, as the side says from the start.
            return;
        }
        if at.slot != NO_PRIMITIVE {
            if side.whole != at.slot {
                side.whole = at.slot;
                let seen = self.seen(batch, at.slot, &side.last);
                side.back = if seen.front { 0 } else { u16::MAX };
                side.plane = seen.plane.map(|c| [c; LANES]);
                side.last = seen;
            }
            return;
        }
        (side.whole, side.back) = (NO_PRIMITIVE, 0);
        for bit in set_bits(at.mask) {
            side.last = self.seen(batch, batch.slot(at, bit), &side.last);
            side.back |= u16::from(!side.last.front) << bit;
            for (column, c) in side.plane.iter_mut().zip(side.last.plane) {
                column[bit] = c;
            }
        }
    }

    fn seen(&self, batch: &Batch<'_>, slot: u32, last: &Seen) -> Seen {
        if slot == last.slot {
            return *last;
        }
        let front = Facing::new(self.cull).is_front(batch, slot);
        let plane = self.planes.map_or([0.0; 3], |planes| {
            let (_, triangle) = batch.prepared.source(batch.blocks.ids[slot as usize]);
            let plane = planes[triangle as usize];
            narrow(if front { plane } else { -plane })
        });
        Seen { slot, front, plane }
    }
}

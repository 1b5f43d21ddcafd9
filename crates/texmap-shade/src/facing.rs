//! Facing of the triangles of a block, and the normals of their planes.

use texmap_math::glam::DVec3;
use texmap_math::narrow;
use texmap_raster::{BATCH_PIXELS, Cull, NO_PRIMITIVE};

use crate::batch::{Batch, Columns, Facing, LANES, set_bits};

/// The facing stage of a surface.
pub struct FacingStage<'a> {
    /// Sides that are drawn.
    pub cull: Cull,
    /// Unit normals of the planes of the mesh's triangles, where shadows or painted projectors read them.
    pub planes: Option<&'a [DVec3]>,
}

/// The sides of the triangles of a batch that are seen.
#[derive(Default)]
pub(crate) struct Sides {
    /// A mask of each block with the pixels that show the back of their triangle.
    pub(crate) back: [u16; BATCH_PIXELS / LANES],
    /// Normals of the planes on the side that is seen; no meaning where nothing reads them.
    pub(crate) plane: Columns<3>,
}

/// The side of the triangle of a slot.
#[derive(Clone, Copy)]
struct Seen {
    slot: u32,
    front: bool,
    plane: [f32; 3],
}

impl FacingStage<'_> {
    /// Finds the sides of a batch.
    pub(crate) fn see(&self, batch: &Batch<'_>, out: &mut Sides) {
        out.back.fill(0);
        if self.cull == Cull::Back && self.planes.is_none() {
            return;
        }
        let mut seen = Seen {
            slot: NO_PRIMITIVE,
            front: true,
            plane: [0.0; 3],
        };
        for (index, at) in batch.list.iter().enumerate() {
            let first = index * LANES;
            if at.slot != NO_PRIMITIVE {
                seen = self.seen(batch, at.slot, &seen);
                out.back[index] = if seen.front { 0 } else { u16::MAX };
                if self.planes.is_some() {
                    for (column, c) in out.plane.0.iter_mut().zip(seen.plane) {
                        column[first..first + LANES].fill(c);
                    }
                }
                continue;
            }
            for bit in set_bits(at.mask) {
                seen = self.seen(batch, batch.slot(*at, bit), &seen);
                out.back[index] |= u16::from(!seen.front) << bit;
                if self.planes.is_some() {
                    out.plane.set(first + bit, seen.plane);
                }
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

//! Depth for a whole tile: what lies behind a triangle that covers all of it needs no look at any pixel.
use texmap_math::simd::{Isa, prelude::*};

use crate::setup::group::{GROUP, Group};
use crate::{DepthTest, DrawCall, Pass};

/// The least depth that is stored anywhere in a tile, as far as it is known: that of triangles that cover all of it.
#[derive(Debug, Default)]
pub(crate) struct Floor(f32);

impl Floor {
    /// Drops triangles that lie behind all that is stored.
    #[inline(always)]
    pub(crate) fn drop_hidden<I: Isa>(&self, i: I, draw: &DrawCall<'_>, group: &mut Group) {
        if self.0 <= 0.0 || draw.depth_test == DepthTest::Always {
            return;
        }
        for at in (0..GROUP).step_by(I::LANES) {
            let nearest = i.load_f32(&group.z_hi[at..]);
            let hidden = match draw.depth_test {
                DepthTest::Less => nearest.simd_le(self.0),
                _ => nearest.simd_lt(self.0),
            };
            group.live &= !(hidden.to_bitmask() << at);
        }
    }

    /// Raises or resets the bound after a group was drawn.
    #[inline(always)]
    pub(crate) fn rise(&mut self, draw: &DrawCall<'_>, group: &Group) {
        if !draw.depth_write {
            return;
        }
        if draw.depth_test == DepthTest::Always {
            // Stored depths may have become farther.
            self.0 = 0.0;
        } else if draw.pass == Pass::Opaque {
            let mut large = group.live & !group.small;
            while large != 0 {
                let lane = large.trailing_zeros() as usize;
                large &= large - 1;
                if group.z_lo[lane] > self.0 && group.covers_tile(lane) {
                    self.0 = group.z_lo[lane];
                }
            }
        }
    }
}

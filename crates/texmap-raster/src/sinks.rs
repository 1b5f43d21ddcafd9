//! What becomes of covered pixels: the nearest is kept, the last, all of one triangle, or what passes is handed out.
use alloc::vec::Vec;

use texmap_math::fearless_simd::{Simd, f32x16, mask32x16, prelude::*, u32x16};
use texmap_math::lanes::LANES;

use crate::blocks::pixel_of;
use crate::prepared::Tile;
use crate::run::RunBlock;
use crate::setup::{Fragment, TILE, TriangleSetup};
use crate::stamp::Sink;
use crate::visible::{AlphaTest, NONE, passes};
use crate::{DepthTest, Prepared};

/// Depth test and write of sixteen pixels.
#[inline(always)]
pub(crate) fn test_block<S: Simd>(
    test: DepthTest,
    covered: mask32x16<S>,
    depth: f32x16<S>,
    stored: f32x16<S>,
) -> mask32x16<S> {
    match test {
        DepthTest::Less => covered & depth.simd_gt(stored),
        DepthTest::LessOrEqual => covered & depth.simd_ge(stored),
        DepthTest::Always => covered,
    }
}

/// Keeps the nearest fragment.
pub(crate) struct Visible<'b, 'p> {
    pub(crate) depth: &'b mut [f32],
    pub(crate) slots: &'b mut [u32],
    pub(crate) masks: &'b mut [u16],
    pub(crate) touched: &'b mut [bool],
    pub(crate) first_slot: u32,
    pub(crate) test: DepthTest,
    pub(crate) write: bool,
    pub(crate) cut: Option<CutOut<'p>>,
}

impl Visible<'_, '_> {
    #[inline(always)]
    fn store<S: Simd>(
        &mut self,
        s: S,
        lane: usize,
        block: usize,
        covered: mask32x16<S>,
        depth: f32x16<S>,
    ) {
        let at = block * LANES..(block + 1) * LANES;
        let (Some(stored), Some(slots), Some(mask), Some(touched)) = (
            self.depth.get_mut(at.clone()),
            self.slots.get_mut(at),
            self.masks.get_mut(block),
            self.touched.get_mut(block),
        ) else {
            return;
        };
        let (old, old_slots) = if *touched {
            (f32x16::from_slice(s, stored), u32x16::from_slice(s, slots))
        } else {
            (f32x16::splat(s, 0.0), u32x16::splat(s, NONE))
        };
        let mut pass = test_block(self.test, covered, depth, old);
        if !pass.any_true() {
            return;
        }
        if let Some(cut) = &mut self.cut {
            let bits = cut.keep(lane, block, pass.to_bitmask() as u32);
            pass = mask32x16::from_bitmask(s, u64::from(bits));
        }
        if self.write {
            pass.select(depth, old).store_slice(stored);
        } else if !*touched {
            old.store_slice(stored);
        }
        let slot = u32x16::splat(s, self.first_slot + lane as u32);
        pass.select(slot, old_slots).store_slice(slots);
        *mask |= pass.to_bitmask() as u16;
        *touched = true;
    }
}

impl<S: Simd> Sink<S> for Visible<'_, '_> {
    #[inline(always)]
    fn block(&mut self, s: S, lane: usize, block: usize, covered: mask32x16<S>, depth: f32x16<S>) {
        self.store(s, lane, block, covered, depth);
    }

    #[inline(always)]
    fn pixel(&mut self, lane: usize, index: usize, depth: f32) {
        let block = index / LANES;
        if !self.touched[block] {
            self.touched[block] = true;
            self.depth[block * LANES..(block + 1) * LANES].fill(0.0);
            self.slots[block * LANES..(block + 1) * LANES].fill(NONE);
        }
        if !passes(self.test, depth, self.depth[index]) {
            return;
        }
        if let Some(cut) = &mut self.cut
            && cut.keep(lane, block, 1 << (index % LANES)) == 0
        {
            return;
        }
        if self.write {
            self.depth[index] = depth;
        }
        self.slots[index] = self.first_slot + lane as u32;
        self.masks[block] |= 1 << (index % LANES);
    }

    /// Cut-outs are asked about as blocks.
    #[inline(always)]
    fn takes_pixels(&self) -> bool {
        self.cut.is_none()
    }
}

/// Keeps what one triangle covers.
pub(crate) struct Alone<'b> {
    pub(crate) masks: &'b mut [u16],
}

impl<S: Simd> Sink<S> for Alone<'_> {
    #[inline(always)]
    fn block(&mut self, _: S, _: usize, block: usize, covered: mask32x16<S>, _: f32x16<S>) {
        self.masks[block] |= covered.to_bitmask() as u16;
    }

    #[inline(always)]
    fn full_block(&mut self, _: S, _: usize, block: usize, _: f32x16<S>) {
        self.masks[block] = u16::MAX;
    }

    #[inline(always)]
    fn pixel(&mut self, _: usize, index: usize, _: f32) {
        self.masks[index / LANES] |= 1 << (index % LANES);
    }

    #[inline(always)]
    fn takes_pixels(&self) -> bool {
        true
    }
}

/// Keeps the first fragment that it is shown.
pub(crate) struct Last<'b> {
    pub(crate) depth: &'b mut [f32],
    pub(crate) slots: &'b mut [u32],
    pub(crate) masks: &'b mut [u16],
    pub(crate) touched: &'b mut [bool],
    /// Blocks that are covered wholly.
    pub(crate) full: usize,
    pub(crate) first_slot: u32,
    pub(crate) write: bool,
}

impl Last<'_> {
    /// The pixels of `covered` that show nothing yet; they are marked.
    #[inline(always)]
    fn take(&mut self, block: usize, covered: u16) -> u16 {
        let seen = &mut self.masks[block];
        let new = covered & !*seen;
        *seen |= new;
        self.full += usize::from(new != 0 && *seen == u16::MAX);
        if new != 0 && !self.touched[block] {
            self.touched[block] = true;
            self.depth[block * LANES..(block + 1) * LANES].fill(0.0);
            self.slots[block * LANES..(block + 1) * LANES].fill(NONE);
        }
        new
    }
}

impl<S: Simd> Sink<S> for Last<'_> {
    #[inline(always)]
    fn block(&mut self, s: S, lane: usize, block: usize, covered: mask32x16<S>, depth: f32x16<S>) {
        let new = self.take(block, covered.to_bitmask() as u16);
        if new == 0 {
            return;
        }
        let pixels = mask32x16::<S>::from_bitmask(s, u64::from(new));
        let at = block * LANES..(block + 1) * LANES;
        let slots = &mut self.slots[at.clone()];
        let slot = u32x16::splat(s, self.first_slot + lane as u32);
        pixels
            .select(slot, u32x16::from_slice(s, slots))
            .store_slice(slots);
        if self.write {
            let stored = &mut self.depth[at];
            pixels
                .select(depth, f32x16::from_slice(s, stored))
                .store_slice(stored);
        }
    }

    #[inline(always)]
    fn pixel(&mut self, lane: usize, index: usize, depth: f32) {
        if self.take(index / LANES, 1 << (index % LANES)) != 0 {
            self.slots[index] = self.first_slot + lane as u32;
            if self.write {
                self.depth[index] = depth;
            }
        }
    }

    #[inline(always)]
    fn takes_pixels(&self) -> bool {
        true
    }
}

/// From so many pixels on a block is asked about as a whole.
const FEW_PIXELS: u32 = 3;

/// Asks the alpha test.
pub(crate) struct CutOut<'p> {
    pub(crate) prepared: &'p Prepared<'p>,
    pub(crate) ids: &'p [u32],
    pub(crate) tile: Tile,
    pub(crate) draw: u32,
    pub(crate) alpha: &'p dyn AlphaTest,
    /// The last lane's set-up.
    pub(crate) setup: Option<(usize, u32, TriangleSetup)>,
}

impl CutOut<'_> {
    /// The bits of `pass` that the test keeps.
    #[inline(never)]
    fn keep(&mut self, lane: usize, block: usize, pass: u32) -> u32 {
        let id = self.ids[lane];
        let (tile_x, tile_y) = (self.tile.x0 / TILE, self.tile.y0 / TILE);
        if self.setup.as_ref().is_none_or(|s| s.0 != lane) {
            self.setup = Some((
                lane,
                self.prepared.source(id).1,
                self.prepared.setup(id, tile_x, tile_y),
            ));
        }
        let Some((_, triangle, setup)) = &self.setup else {
            return 0;
        };
        let corner = pixel_of(block, 0);
        let [x, y] = [self.tile.x0 + corner.0, self.tile.y0 + corner.1];
        if pass.count_ones() >= FEW_PIXELS
            && let Some(at) = setup.uv_block(x, y)
            && let Some(kept) = self.alpha.keep_by_uv(self.draw, &at, pass as u16)
        {
            return u32::from(kept) & pass;
        }
        let mut fragment = Fragment::default();
        let mut kept = 0;
        let mut left = pass;
        while left != 0 {
            let bit = left.trailing_zeros();
            left &= left - 1;
            let (x, y) = pixel_of(block, bit);
            if x < self.tile.width && y < self.tile.height {
                setup.evaluate(self.tile.x0 + x, self.tile.y0 + y, &mut fragment);
                if self.alpha.keep(self.draw, *triangle, &fragment) {
                    kept |= 1 << bit;
                }
            }
        }
        kept
    }
}

/// Hands out what passes.
pub(crate) struct Forward<'b, 'f> {
    pub(crate) depth: &'b mut [f32],
    pub(crate) first_slot: u32,
    pub(crate) test: DepthTest,
    pub(crate) write: bool,
    pub(crate) tile: Tile,
    /// The tile is of full size.
    pub(crate) whole: bool,
    pub(crate) out: &'f mut Vec<RunBlock>,
}

impl Forward<'_, '_> {
    /// Bits of a block that lie in the target.
    #[inline(always)]
    fn inside(&self, block: usize) -> u32 {
        if self.whole {
            return u32::from(u16::MAX);
        }
        let (x, y) = pixel_of(block, 0);
        let (across, down) = (
            self.tile.width.saturating_sub(x).min(4),
            self.tile.height.saturating_sub(y).min(4),
        );
        let row = (1u32 << across) - 1;
        (row * 0x1111) & ((1u32 << (4 * down)) - 1)
    }
}

impl<S: Simd> Sink<S> for Forward<'_, '_> {
    #[inline(always)]
    fn block(&mut self, s: S, lane: usize, block: usize, covered: mask32x16<S>, depth: f32x16<S>) {
        let inside = self.inside(block);
        let Some(stored) = self.depth.get_mut(block * LANES..(block + 1) * LANES) else {
            return;
        };
        let old = f32x16::from_slice(s, stored);
        let pass = test_block(self.test, covered, depth, old);
        let bits = pass.to_bitmask() as u32 & inside;
        if bits != 0 {
            if self.write {
                pass.select(depth, old).store_slice(stored);
            }
            self.out.push(RunBlock {
                block: block as u16,
                mask: bits as u16,
                slot: self.first_slot + lane as u32,
            });
        }
    }

    #[inline(always)]
    fn pixel(&mut self, lane: usize, index: usize, depth: f32) {
        if passes(self.test, depth, self.depth[index]) {
            if self.write {
                self.depth[index] = depth;
            }
            self.out.push(RunBlock {
                block: (index / LANES) as u16,
                mask: 1 << (index % LANES),
                slot: self.first_slot + lane as u32,
            });
        }
    }

    /// Each would be shaded by itself.
    #[inline(always)]
    fn takes_pixels(&self) -> bool {
        false
    }
}

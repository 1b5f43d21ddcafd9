//! Depth policies for covered pixels: keep the nearest, keep the last, keep all of one triangle, or forward what passes.
use alloc::vec::Vec;

use texmap_math::simd::{Isa, Scalar, prelude::*};

use crate::coverage::stamp::{BLOCK_PIXELS, Sink};
use crate::front_end::prepared::Tile;
use crate::interpolate::FragmentBlock;
use crate::setup::{Fragment, TILE, TriangleSetup};
use crate::visibility::blocks::{PIXELS, pixel_of};
use crate::visibility::visible::{AlphaTest, NO_PRIMITIVE};
use crate::{BinnedDraws, DepthTest};

/// The depth test; depth is reversed, so nearer is larger.
#[inline(always)]
pub(crate) fn passes<I: Isa>(i: I, test: DepthTest, depth: I::F32, stored: I::F32) -> I::Mask {
    match test {
        DepthTest::Less => depth.simd_gt(stored),
        DepthTest::LessOrEqual => depth.simd_ge(stored),
        DepthTest::Always => i.mask(true),
    }
}

/// Readies a block that is touched for the first time.
#[inline(always)]
fn touch(block: usize, depth: &mut [f32], slots: &mut [u32], touched: &mut [bool]) {
    if !touched[block] {
        touched[block] = true;
        depth[block * BLOCK_PIXELS..(block + 1) * BLOCK_PIXELS].fill(0.0);
        slots[block * BLOCK_PIXELS..(block + 1) * BLOCK_PIXELS].fill(NO_PRIMITIVE);
    }
}

/// Keeps the nearest fragment. `PLAIN` is for [`DepthTest::Less`] with depths written and nothing cut out, as most draws are: the
/// choices below are made when the code is compiled then.
pub(crate) struct Visible<'b, 'p, const PLAIN: bool> {
    pub(crate) depth: &'b mut [f32; PIXELS],
    pub(crate) slots: &'b mut [u32; PIXELS],
    pub(crate) masks: &'b mut [u16; PIXELS / BLOCK_PIXELS],
    pub(crate) touched: &'b mut [bool; PIXELS / BLOCK_PIXELS],
    pub(crate) first_slot: u32,
    pub(crate) test: DepthTest,
    pub(crate) write: bool,
    pub(crate) cut: Option<CutOut<'p>>,
}

impl<const PLAIN: bool> Visible<'_, '_, PLAIN> {
    #[inline(always)]
    fn test(&self) -> DepthTest {
        if PLAIN { DepthTest::Less } else { self.test }
    }

    #[inline(always)]
    fn writes(&self) -> bool {
        PLAIN || self.write
    }
}

impl<I: Isa, const PLAIN: bool> Sink<I> for Visible<'_, '_, PLAIN> {
    #[inline(always)]
    fn pixels(&mut self, i: I, triangle: usize, index: usize, covered: I::Mask, depth: I::F32) {
        let (block, bit) = (index / BLOCK_PIXELS, index % BLOCK_PIXELS);
        let (test, write) = (self.test(), self.writes());
        if I::LANES < BLOCK_PIXELS {
            touch(block, self.depth, self.slots, self.touched);
        }
        let at = index..index + I::LANES;
        let (Some(stored), Some(slots), Some(mask), Some(touched)) = (
            self.depth.get_mut(at.clone()),
            self.slots.get_mut(at),
            self.masks.get_mut(block),
            self.touched.get_mut(block),
        ) else {
            return;
        };
        let (old, old_slots) = if *touched {
            (i.load_f32(stored), i.load_u32(slots))
        } else {
            (i.f32(0.0), i.u32(NO_PRIMITIVE))
        };
        let mut pass = covered & passes(i, test, depth, old);
        if !pass.any_true() {
            return;
        }
        if !PLAIN && let Some(cut) = &mut self.cut {
            let bits = cut.keep(i, triangle, block, pass.to_bitmask() << bit);
            pass = i.mask_from_bits(bits >> bit);
        }
        if write {
            pass.select(depth, old).store(stored);
        } else if !*touched {
            old.store(stored);
        }
        let slot = i.u32(self.first_slot + triangle as u32);
        pass.select(slot, old_slots).store(slots);
        *mask |= (pass.to_bitmask() << bit) as u16;
        *touched = true;
    }

    #[inline(always)]
    fn pixel(&mut self, triangle: usize, index: usize, depth: f32) {
        let (block, bit) = (index / BLOCK_PIXELS, index % BLOCK_PIXELS);
        touch(block, self.depth, self.slots, self.touched);
        if !passes(Scalar, self.test(), depth, self.depth[index]) {
            return;
        }
        if !PLAIN
            && let Some(cut) = &mut self.cut
            && cut.keep(Scalar, triangle, block, 1 << bit) == 0
        {
            return;
        }
        if self.writes() {
            self.depth[index] = depth;
        }
        self.slots[index] = self.first_slot + triangle as u32;
        self.masks[block] |= 1 << bit;
    }

    /// Cut-outs are asked about as blocks.
    #[inline(always)]
    fn takes_pixels(&self) -> bool {
        PLAIN || self.cut.is_none()
    }
}

/// Keeps what one triangle covers.
pub(crate) struct Alone<'b> {
    pub(crate) masks: &'b mut [u16],
}

impl<I: Isa> Sink<I> for Alone<'_> {
    #[inline(always)]
    fn pixels(&mut self, _: I, _: usize, index: usize, covered: I::Mask, _: I::F32) {
        self.masks[index / BLOCK_PIXELS] |= (covered.to_bitmask() << (index % BLOCK_PIXELS)) as u16;
    }

    #[inline(always)]
    fn pixel(&mut self, _: usize, index: usize, _: f32) {
        self.masks[index / BLOCK_PIXELS] |= 1 << (index % BLOCK_PIXELS);
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
        if new != 0 {
            touch(block, self.depth, self.slots, self.touched);
        }
        new
    }
}

impl<I: Isa> Sink<I> for Last<'_> {
    #[inline(always)]
    fn pixels(&mut self, i: I, triangle: usize, index: usize, covered: I::Mask, depth: I::F32) {
        let (block, bit) = (index / BLOCK_PIXELS, index % BLOCK_PIXELS);
        let new = self.take(block, (covered.to_bitmask() << bit) as u16);
        if new == 0 {
            return;
        }
        let pixels = i.mask_from_bits(u32::from(new) >> bit);
        let at = index..index + I::LANES;
        let slots = &mut self.slots[at.clone()];
        let slot = i.u32(self.first_slot + triangle as u32);
        pixels.select(slot, i.load_u32(slots)).store(slots);
        if self.write {
            let stored = &mut self.depth[at];
            pixels.select(depth, i.load_f32(stored)).store(stored);
        }
    }

    #[inline(always)]
    fn pixel(&mut self, triangle: usize, index: usize, depth: f32) {
        if self.take(index / BLOCK_PIXELS, 1 << (index % BLOCK_PIXELS)) != 0 {
            self.slots[index] = self.first_slot + triangle as u32;
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
    pub(crate) prepared: &'p BinnedDraws<'p>,
    pub(crate) ids: &'p [u32],
    pub(crate) tile: Tile,
    pub(crate) draw: u32,
    pub(crate) alpha: &'p dyn AlphaTest,
    /// The set-up of the last triangle asked about.
    pub(crate) setup: Option<(usize, u32, TriangleSetup)>,
}

impl CutOut<'_> {
    /// The bits of `pass`, pixels of a block, that the test keeps.
    #[inline(never)]
    fn keep<I: Isa>(&mut self, i: I, lane: usize, block: usize, pass: u32) -> u32 {
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
            && let Some(at) = i.vectorize(
                #[inline(always)]
                || setup.uv_block(i, x, y),
            )
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
    pub(crate) out: &'f mut Vec<FragmentBlock>,
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

impl<I: Isa> Sink<I> for Forward<'_, '_> {
    #[inline(always)]
    fn pixels(&mut self, i: I, triangle: usize, index: usize, covered: I::Mask, depth: I::F32) {
        let (block, bit) = (index / BLOCK_PIXELS, index % BLOCK_PIXELS);
        let inside = self.inside(block);
        let Some(stored) = self.depth.get_mut(index..index + I::LANES) else {
            return;
        };
        let old = i.load_f32(stored);
        let pass = covered & passes(i, self.test, depth, old);
        let bits = (pass.to_bitmask() << bit) & inside;
        if bits == 0 {
            return;
        }
        if self.write {
            pass.select(depth, old).store(stored);
        }
        let at = FragmentBlock {
            block: block as u16,
            mask: bits as u16,
            slot: self.first_slot + triangle as u32,
        };
        match self.out.last_mut() {
            // A further part of the same block.
            Some(last) if bit > 0 && (last.block, last.slot) == (at.block, at.slot) => {
                last.mask |= at.mask;
            }
            _ => self.out.push(at),
        }
    }

    #[inline(always)]
    fn pixel(&mut self, triangle: usize, index: usize, depth: f32) {
        if passes(Scalar, self.test, depth, self.depth[index]) {
            if self.write {
                self.depth[index] = depth;
            }
            self.out.push(FragmentBlock {
                block: (index / BLOCK_PIXELS) as u16,
                mask: 1 << (index % BLOCK_PIXELS),
                slot: self.first_slot + triangle as u32,
            });
        }
    }

    /// Each would be shaded by itself.
    #[inline(always)]
    fn takes_pixels(&self) -> bool {
        false
    }
}

//! The fragments of a tile that are to be shaded: blocks of 4x4 pixels, surface by surface.

use texmap_raster::{BinnedDraws, FragmentBlock, NO_PRIMITIVE, Pass, TileVisibility};

use crate::plan::Plan;
use texmap_shade::batch::LANES;

pub(super) const EMPTY: FragmentBlock = FragmentBlock {
    block: 0,
    mask: 0,
    slot: NO_PRIMITIVE,
};

/// True if every pixel of every block is covered.
pub(crate) fn is_whole(masks: &[u16]) -> bool {
    // All, without stopping at the first that is not: many at a time.
    masks.iter().fold(u16::MAX, |all, mask| all & mask) == u16::MAX
}

/// Property of all blended surfaces of a tile.
#[derive(Clone, Copy)]
pub(super) struct Blended {
    /// All are opaque after all.
    pub(super) opaque: bool,
}

/// `None` if nothing blends.
pub(super) fn blended(plan: &Plan<'_>, blocks: &TileVisibility) -> Option<Blended> {
    let mut found = None;
    for draw in &blocks.draws {
        let surface = &plan.surfaces[*draw as usize];
        if surface.pass == Pass::Blended {
            let opaque = surface.unlit.is_some_and(|t| t.is_opaque());
            let before = found.is_none_or(|b: Blended| b.opaque);
            found = Some(Blended {
                opaque: before && opaque,
            });
        }
    }
    found
}

/// Blocks to shade, by draw.
#[derive(Default)]
pub(super) struct FragmentList {
    pub(super) blocks: Vec<FragmentBlock>,
    /// A draw, and where its blocks end.
    parts: Vec<(u32, usize)>,
    /// Blocks by draw while they are sorted.
    loose: Vec<(u32, FragmentBlock)>,
    /// The draw and the slot of which these are all blocks in full: most tiles of a near surface have one list.
    whole: Option<(u32, u32)>,
}

impl FragmentList {
    /// The blocks of each draw, draw after draw.
    pub(super) fn parts(&self) -> impl Iterator<Item = (u32, &[FragmentBlock])> {
        let starts = std::iter::once(0).chain(self.parts.iter().map(|(_, end)| *end));
        let parts = starts.zip(&self.parts);
        parts.map(|(start, (draw, end))| (*draw, &self.blocks[start..*end]))
    }

    fn clear(&mut self) {
        self.blocks.clear();
        self.parts.clear();
    }

    fn push(&mut self, draw: u32, at: FragmentBlock) {
        self.blocks.push(at);
        let end = self.blocks.len();
        match self.parts.last_mut() {
            Some(last) if last.0 == draw => last.1 = end,
            _ => self.parts.push((draw, end)),
        }
    }

    /// The pixels of `masks` by draw; all are of `slot`, or each has its own.
    pub(super) fn visible(&mut self, blocks: &TileVisibility, masks: &[u16], slot: u32) {
        let before = self.whole.take();
        let some = masks.iter().enumerate().filter(|(_, mask)| **mask != 0);
        let at = |block: usize, mask| FragmentBlock {
            block: block as u16,
            mask,
            slot,
        };
        let Some(&first) = blocks.draws.first() else {
            self.clear();
            return;
        };
        if blocks.draws.iter().all(|draw| *draw == first) {
            self.whole = is_whole(masks).then_some((first, slot));
            if before.is_some() && before == self.whole {
                return;
            }
            self.clear();
            // Each is put down, and kept if it has pixels.
            self.blocks.resize(masks.len(), EMPTY);
            let mut count = 0;
            for (block, mask) in masks.iter().enumerate() {
                self.blocks[count] = at(block, *mask);
                count += usize::from(*mask != 0);
            }
            self.blocks.truncate(count);
            self.parts.push((first, count));
            return;
        }
        self.clear();
        self.loose.clear();
        for (block, &mask) in some {
            let slots = &blocks.slot[block * LANES..(block + 1) * LANES];
            let draw_of = |bit: u32| blocks.draws[slots[bit as usize] as usize / LANES];
            let mut left = mask;
            while left != 0 {
                let draw = draw_of(left.trailing_zeros());
                let mut mine = 0;
                let mut rest = left;
                while rest != 0 {
                    let bit = rest.trailing_zeros();
                    rest &= rest - 1;
                    mine |= u16::from(draw_of(bit) == draw) << bit;
                }
                left &= !mine;
                self.loose.push((draw, at(block, mine)));
            }
        }
        let mut loose = std::mem::take(&mut self.loose);
        loose.sort_by_key(|(draw, _)| *draw);
        loose.iter().for_each(|(draw, at)| self.push(*draw, *at));
        self.loose = loose;
    }

    /// The blocks of the blended draws in submitted order.
    pub(super) fn blended(
        &mut self,
        prepared: &BinnedDraws<'_>,
        tile: usize,
        offset: [i32; 2],
        blocks: &mut TileVisibility,
    ) {
        self.clear();
        self.whole = None;
        let wanted = |draw: &texmap_raster::DrawCall<'_>| draw.pass == Pass::Blended;
        prepared.forward_sample(tile, offset, blocks, &wanted, &mut self.blocks);
        // Slots rise from block to block, and sixteen of them belong to one draw.
        let mut end = 0;
        while let Some(first) = self.blocks.get(end) {
            let sixteen = first.slot as usize / LANES;
            let same = |at: &FragmentBlock| at.slot as usize / LANES == sixteen;
            end += self.blocks[end..].partition_point(same);
            let draw = blocks.draws[sixteen];
            match self.parts.last_mut() {
                Some(last) if last.0 == draw => last.1 = end,
                _ => self.parts.push((draw, end)),
            }
        }
    }
}

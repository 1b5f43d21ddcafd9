//! The triangles of a tile's bin in runs of one draw.

use crate::BinnedDraws;
use crate::setup::group::GROUP;

/// A bin cut into runs of up to sixteen ids of one draw. Run k holds slots 16 k, 16 k + 1, ...
pub(crate) struct Runs<'p, 'a> {
    prepared: &'p BinnedDraws<'a>,
    ids: &'p [u32],
    at: usize,
    run: usize,
}

/// Up to sixteen ids of one draw.
pub(crate) struct Run<'p> {
    pub draw: usize,
    pub first_slot: usize,
    pub ids: &'p [u32],
}

impl<'p, 'a> Runs<'p, 'a> {
    pub(crate) fn new(prepared: &'p BinnedDraws<'a>, tile: usize) -> Self {
        Self {
            prepared,
            ids: prepared.bin_of(tile),
            at: 0,
            run: 0,
        }
    }

    pub(crate) fn next(&mut self) -> Option<Run<'p>> {
        let start = self.at;
        let &id = self.ids.get(start)?;
        let draw = self.prepared.source(id).0;
        let range = self.prepared.id_range(draw as usize);
        let rest = &self.ids[start + 1..self.ids.len().min(start + GROUP)];
        let same = rest
            .iter()
            .take_while(|&&id| range.contains(&id) || self.prepared.is_piece_of(id, draw))
            .count();
        self.at = start + 1 + same;
        self.run += 1;
        Some(Run {
            draw: draw as usize,
            first_slot: (self.run - 1) * GROUP,
            ids: &self.ids[start..self.at],
        })
    }
}

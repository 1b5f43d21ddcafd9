//! Vectors of a lit run, from their attributes to columns and from there into lanes.

use texmap_light::lanes::V3;
use texmap_math::fearless_simd::{Simd, f32x16, prelude::*};
use texmap_raster::{BlockSink, BlockValues, Column, RUN_ROOM, RunBlock, RunValues, TilePlanes};

use super::{LitLanes, Relief};
use crate::canvas::{LANES, vector};
use crate::lit_texels::SlideTexels;
use crate::relief::Space;
use crate::shade::Run;

/// Columns of vectors.
pub(super) const NORMAL: usize = 0;
pub(super) const POSITION: usize = 3;
pub(super) const TANGENT: usize = 6;
const COLUMNS: usize = TANGENT + 4;

/// Blocks of a run that some slide reaches, and their places in it.
#[derive(Default)]
pub(super) struct Reached {
    blocks: Vec<RunBlock>,
    places: Vec<usize>,
}

impl LitLanes<'_> {
    /// The vectors of a surface that reads no more, in columns of their own, and its slides.
    #[inline(always)]
    pub(super) fn few_attributes<S: Simd>(
        &self,
        s: S,
        planes: &TilePlanes,
        run: &Run<'_>,
        out: &mut RunValues,
        slides: &mut [SlideTexels],
        reached: &mut Reached,
    ) {
        if out.columns.len() < COLUMNS {
            out.columns.resize(COLUMNS, Column::ZERO);
        }
        let late = !self.turned && matches!(self.relief, Relief::None);
        if let (true, Some(first)) = (late, self.position_attribute()) {
            self.three(s, planes, run, [first, POSITION], run.run, &[], out);
        } else {
            self.vectors(s, planes, run, out);
        }
        self.look_up_slides(s, out, run.run.len(), slides);
        if let (true, Some(normal)) = (late, self.surface.normal) {
            // Few blocks ask for a normal.
            reached.blocks.clear();
            reached.places.clear();
            for (i, at) in run.run.iter().enumerate() {
                if slides.iter().any(|slide| slide.reaches(i)) {
                    reached.blocks.push(*at);
                    reached.places.push(i);
                }
            }
            let Reached { blocks, places } = reached;
            self.three(s, planes, run, [normal, NORMAL], blocks, places, out);
        }
    }

    /// The slides of a run, at the positions in its columns.
    #[inline(always)]
    pub(super) fn look_up_slides<S: Simd>(
        &self,
        s: S,
        values: &RunValues,
        blocks: usize,
        out: &mut [SlideTexels],
    ) {
        let Some(first) = self.position else { return };
        let Some([x, y, z]) = values.columns[first..].first_chunk() else {
            return;
        };
        for ((slide, leveled), out) in self.slides().zip(out) {
            let points = [&x.value, &y.value, &z.value];
            let changes = leveled.then_some([[&x.ddx, &y.ddx, &z.ddx], [&x.ddy, &y.ddy, &z.ddy]]);
            slide.run(s, self.level, blocks, points, changes, out);
        }
    }

    /// First attribute of the positions, where any stage reads them.
    fn position_attribute(&self) -> Option<usize> {
        self.position.and(self.surface.position)
    }

    /// One vector of some blocks, from its attribute to its column, without its changes. The blocks stand at `places` in the run, or where
    /// they are in the list if there are none.
    #[inline(always)]
    fn three<S: Simd>(
        &self,
        s: S,
        planes: &TilePlanes,
        run: &Run<'_>,
        [attribute, column]: [usize; 2],
        list: &[RunBlock],
        places: &[usize],
        out: &mut RunValues,
    ) {
        if let Some(columns) = out.columns[column..].first_chunk_mut() {
            let columns = Store::<3, false>(columns.each_mut());
            let mut sink = Placed { columns, places };
            let all = [attribute, attribute + 1, attribute + 2];
            planes.each_block::<_, 3, false, _>(s, run.blocks, list, all, &mut sink);
        }
    }

    /// Normals, positions and tangents of a run. The changes of normals are read by mirrors.
    #[inline(always)]
    fn vectors<S: Simd>(&self, s: S, planes: &TilePlanes, run: &Run<'_>, out: &mut RunValues) {
        let (blocks, list) = (run.blocks, run.run);
        let Some(n) = self.surface.normal else { return };
        let columns = &mut out.columns[..];
        let tangent = match self.relief {
            Relief::Normals(_, _, Space::Tangent(first), _) => Some(first),
            _ => None,
        };
        let Some(p) = self.position_attribute() else {
            // Nothing but a mirror asks for no position, or light that is the same everywhere.
            if let Some(normals) = columns.first_chunk_mut() {
                let mut sink = Store::<3, true>(normals.each_mut());
                let all = [n, n + 1, n + 2];
                planes.each_block::<_, 3, true, _>(s, blocks, list, all, &mut sink);
            }
            return;
        };
        match (tangent, self.has_mirrors()) {
            (Some(t), false) => {
                if let Some(vectors) = columns.first_chunk_mut() {
                    let mut sink = Store::<10, false>(vectors.each_mut());
                    let all = [n, n + 1, n + 2, p, p + 1, p + 2, t, t + 1, t + 2, t + 3];
                    planes.each_block::<_, 10, false, _>(s, blocks, list, all, &mut sink);
                }
            }
            (None, false) => {
                if let Some(vectors) = columns.first_chunk_mut() {
                    let mut sink = Store::<6, false>(vectors.each_mut());
                    let all = [n, n + 1, n + 2, p, p + 1, p + 2];
                    planes.each_block::<_, 6, false, _>(s, blocks, list, all, &mut sink);
                }
            }
            (tangent, true) => {
                if let Some(vectors) = columns.first_chunk_mut() {
                    let mut sink = Store::<6, true>(vectors.each_mut());
                    let all = [n, n + 1, n + 2, p, p + 1, p + 2];
                    planes.each_block::<_, 6, true, _>(s, blocks, list, all, &mut sink);
                }
                if let (Some(t), Some(tangents)) = (tangent, columns[TANGENT..].first_chunk_mut()) {
                    let mut sink = Store::<4, false>(tangents.each_mut());
                    let all = [t, t + 1, t + 2, t + 3];
                    planes.each_block::<_, 4, false, _>(s, blocks, list, all, &mut sink);
                }
            }
        }
    }
}

/// Stores values in columns, and their changes if `D` asks for that.
struct Store<'a, const N: usize, const D: bool>([&'a mut Column; N]);

impl<S: Simd, const N: usize, const D: bool> BlockSink<S, N> for Store<'_, N, D> {
    #[inline(always)]
    fn block(&mut self, _s: S, i: usize, _at: RunBlock, values: &BlockValues<S, N>) {
        let at = i * LANES..(i + 1) * LANES;
        for (k, column) in self.0.iter_mut().enumerate() {
            values.value[k].store_slice(&mut column.value[at.clone()]);
            if D {
                values.ddx[k].store_slice(&mut column.ddx[at.clone()]);
                values.ddy[k].store_slice(&mut column.ddy[at.clone()]);
            }
        }
    }
}

/// Stores values at other places of the run than they are asked for at.
struct Placed<'a> {
    columns: Store<'a, 3, false>,
    places: &'a [usize],
}

impl<S: Simd> BlockSink<S, 3> for Placed<'_> {
    #[inline(always)]
    fn block(&mut self, s: S, i: usize, at: RunBlock, values: &BlockValues<S, 3>) {
        let i = self.places.get(i).copied().unwrap_or(i);
        self.columns.block(s, i, at, values);
    }
}

/// A column of a block.
#[inline(always)]
pub(super) fn column<S: Simd>(s: S, values: &[f32; RUN_ROOM], i: usize) -> f32x16<S> {
    f32x16::from_slice(s, &values[i * LANES..(i + 1) * LANES])
}

/// A vector of a block.
#[inline(always)]
pub(super) fn three<S: Simd>(s: S, values: &RunValues, first: usize, i: usize) -> V3<S> {
    let columns = &values.columns[first..first + 3];
    vector(
        s,
        [&columns[0].value, &columns[1].value, &columns[2].value],
        i,
    )
}

/// Changes of a vector to the right and down.
#[inline(always)]
pub(super) fn changes<S: Simd>(s: S, values: &RunValues, first: usize, i: usize) -> [V3<S>; 2] {
    let columns = &values.columns[first..first + 3];
    [
        vector(s, [&columns[0].ddx, &columns[1].ddx, &columns[2].ddx], i),
        vector(s, [&columns[0].ddy, &columns[1].ddy, &columns[2].ddy], i),
    ]
}

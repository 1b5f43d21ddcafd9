//! Vectors of a lit run, from their attributes to columns and from there into lanes.

use texmap_light::lanes::V3;
use texmap_math::fearless_simd::{Simd, f32x16, prelude::*};
use texmap_math::simd::X16;
use texmap_raster::{Column, RUN_ROOM, RunBlock, RunValues, TilePlanes};

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
        reached: &mut Vec<RunBlock>,
    ) {
        if out.columns.len() < COLUMNS {
            out.columns.resize(COLUMNS, Column::ZERO);
        }
        let late = !self.turned && matches!(self.relief, Relief::None);
        // Some slide's filter asks how large a pixel is.
        let leveled = self.slides().any(|cast| cast.thrown.reads_derivatives());
        if let (true, Some(p)) = (late, self.position_attribute()) {
            let all = [p, p + 1, p + 2];
            each(s, planes, run, (run.run, leveled), &all, POSITION, out);
        } else {
            self.vectors(s, planes, run, leveled, out);
        }
        self.look_up_slides(s, out, run.run.len(), slides);
        if let (true, Some(n)) = (late, self.surface.normal) {
            // Few blocks ask for a normal.
            reached.clear();
            reached.extend_from_slice(run.run);
            for (i, at) in reached.iter_mut().enumerate() {
                if !slides.iter().any(|slide| slide.reaches(i)) {
                    at.mask = 0;
                }
            }
            let all = [n, n + 1, n + 2];
            each(s, planes, run, (reached, false), &all, NORMAL, out);
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
        for (cast, out) in self.slides().zip(out) {
            let points = [&x.value, &y.value, &z.value];
            let leveled = cast.thrown.reads_derivatives();
            let changes = leveled.then_some([[&x.ddx, &y.ddx, &z.ddx], [&x.ddy, &y.ddy, &z.ddy]]);
            cast.look_up
                .run(s, self.level, blocks, points, changes, out);
        }
    }

    /// First attribute of the positions, where any stage reads them.
    fn position_attribute(&self) -> Option<usize> {
        self.position.and(self.surface.position)
    }

    /// Normals, positions and tangents of a run. The changes of normals are read by mirrors.
    #[inline(always)]
    fn vectors<S: Simd>(
        &self,
        s: S,
        planes: &TilePlanes,
        run: &Run<'_>,
        leveled: bool,
        out: &mut RunValues,
    ) {
        let (blocks, list, mirrors) = (run.blocks, run.run, self.has_mirrors());
        let Some(n) = self.surface.normal else { return };
        let tangent = match self.relief {
            Relief::Normals(_, _, Space::Tangent(first), _) => Some(first),
            _ => None,
        };
        // Without a position there is no relief, and nothing but a mirror or light that is the same everywhere.
        let (position, t) = (self.position_attribute(), tangent.unwrap_or(0));
        let p = position.unwrap_or(0);
        let all = [n, n + 1, n + 2, p, p + 1, p + 2, t, t + 1, t + 2, t + 3];
        let wanted = match (position, tangent) {
            (None, _) => &all[..POSITION],
            (_, None) => &all[..TANGENT],
            _ => &all[..],
        };
        if !mirrors && !leveled {
            return planes.each_column::<_, false>(X16(s), blocks, list, wanted, NORMAL, out);
        }
        let (normal, rest) = wanted.split_at(POSITION);
        let (position, tangent) = rest.split_at(rest.len().min(TANGENT - POSITION));
        each(s, planes, run, (list, mirrors), normal, NORMAL, out);
        each(s, planes, run, (list, leveled), position, POSITION, out);
        each(s, planes, run, (list, false), tangent, TANGENT, out);
    }
}

/// Attributes of a list of blocks, with their changes or without.
#[inline(always)]
fn each<S: Simd>(
    s: S,
    planes: &TilePlanes,
    run: &Run<'_>,
    (list, derivatives): (&[RunBlock], bool),
    wanted: &[usize],
    first: usize,
    out: &mut RunValues,
) {
    if wanted.is_empty() {
        return;
    }
    if derivatives {
        planes.each_column::<_, true>(X16(s), run.blocks, list, wanted, first, out);
    } else {
        planes.each_column::<_, false>(X16(s), run.blocks, list, wanted, first, out);
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

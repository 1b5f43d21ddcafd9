//! Texels straight onto the canvas: the way of unlit surfaces whose look-ups are bytes, without a column in between.

use texmap_math::Level;
use texmap_math::fearless_simd::{Simd, f32x16, i32x16, prelude::*, u32x16};
use texmap_math::simd::X16;
use texmap_raster::{
    BlockSink, BlockValues, NONE, RUN, RUN_ROOM, RunBlock, TileBlocks, TilePlanes,
};
use texmap_sample::lanes::packed::{self, FootprintLanes};
use texmap_sample::lanes::{Kind, View};

use crate::canvas::{Canvas, LANES, over_block, put_block, put_block_rows};
use crate::plan::Surface;
use crate::texel::{RunUv, TexelStage};
use texmap_math::on_wide_level;

/// What a surface's texels are painted with.
#[derive(Debug)]
pub(crate) struct Direct<'a> {
    stage: TexelStage,
    view: View<'a>,
}

/// Places and levels of a run: with the derivatives done, fewer registers are wanted at a time.
pub(crate) struct Levels {
    uv: RunUv,
    lod: [i32; RUN_ROOM],
    /// Slots in a row of which not all texels were magnified.
    refusals: u32,
}

/// What [`Source::is_magnified`] was asked last.
pub(crate) struct Asked {
    slot: u32,
    near: bool,
    refusals: u32,
}

/// So many refusals in a row, and only one block of so many is asked about: few surfaces of small triangles are that near.
const PATIENCE: u32 = 4;
const SELDOM: u16 = 8;

impl Levels {
    pub(crate) fn new() -> Self {
        Self {
            uv: RunUv::default(),
            lod: [0; RUN_ROOM],
            refusals: 0,
        }
    }
}

impl<'a> Direct<'a> {
    /// `None` where a surface needs more than that, or has no lanes.
    pub(crate) fn new(surface: &'a Surface<'_>) -> Option<Self> {
        let (stage, slot) = (surface.texel?, surface.base_color.as_ref()?);
        if !stage.looks_up_bytes() || slot.is_transformed() {
            return None;
        }
        let view = View::new(&slot.sampler, &slot.texture)?;
        view.kind.is_plain().then_some(Self { stage, view })
    }

    /// Puts finished pixels, where the look-up's bytes are that; false if nothing was done.
    pub(crate) fn put(
        &self,
        level: Level,
        from: &mut From<'_>,
        run: &[RunBlock],
        canvas: &mut Canvas,
    ) -> bool {
        if !self.stage.gives_words() {
            return false;
        }
        let words = canvas.words_mut();
        on_wide_level!(
            level,
            s => {
                self.paint(s, &from.source(), from.levels, run, &mut Put { words });
                true
            },
            else false
        )
    }

    /// Whether [`put_rows`](Self::put_rows) serves.
    pub(crate) fn gives_rows(&self, level: Level) -> bool {
        self.stage.gives_words() && on_wide_level!(level, _s => true, else false)
    }

    /// [`put`](Self::put) without a canvas in between, where that [serves](Self::gives_rows).
    pub(crate) fn put_rows(
        &self,
        level: Level,
        from: &mut From<'_>,
        run: &[RunBlock],
        rows: &mut [&mut [u8]],
    ) {
        on_wide_level!(
            level,
            s => self.paint(s, &from.source(), from.levels, run, &mut PutRows { rows }),
            else debug_assert!(false, "asked before")
        );
    }

    /// Lays light over that of the canvas, block by block, and marks in `covered` the pixels that are not all clear; false if
    /// nothing was done.
    pub(crate) fn over(
        &self,
        level: Level,
        from: &mut From<'_>,
        run: &[RunBlock],
        canvas: &mut Canvas,
        covered: &mut [u16],
    ) -> bool {
        let stage = &self.stage;
        let light = canvas.light_mut();
        on_wide_level!(
            level,
            s => {
                self.paint(s, &from.source(), from.levels, run, &mut Over { stage, light, covered });
                true
            },
            else false
        )
    }

    /// Whether the bytes of a look-up are the finished pixels.
    pub(crate) fn gives_words(&self) -> bool {
        self.stage.gives_words()
    }

    /// Shows `brush` the texels of a run.
    #[inline(always)]
    pub(crate) fn paint<S: Simd, P: Source<S>, B: Brush<S>>(
        &self,
        s: S,
        source: &P,
        levels: &mut Levels,
        run: &[RunBlock],
        brush: &mut B,
    ) {
        paint(s, &self.view, source, levels, run, brush);
    }
}

/// Where the places of a run come from.
pub(crate) struct From<'a> {
    pub(crate) planes: &'a TilePlanes,
    pub(crate) blocks: &'a TileBlocks,
    pub(crate) levels: &'a mut Levels,
}

impl<'a> From<'a> {
    pub(crate) fn source(&self) -> Blocks<'a> {
        Blocks {
            planes: self.planes,
            blocks: self.blocks,
        }
    }
}

/// Shows the values of blocks.
pub(crate) trait Source<S: Simd> {
    fn each<const D: bool, K: BlockSink<X16<S>>>(&self, s: S, run: &[RunBlock], sink: &mut K);

    /// [`each`](Self::each) in a loop that leaves registers to the sink; false, with nothing done, where it does not serve.
    #[inline(always)]
    fn each_named<const D: bool, K: BlockSink<X16<S>>>(
        &self,
        _s: S,
        _run: &[RunBlock],
        _sink: &mut K,
    ) -> bool {
        false
    }

    /// Whether all texels of the first block of `run` are surely magnified, and it is worth knowing.
    fn is_magnified(&self, s: S, run: &[RunBlock], view: &View<'_>, asked: &mut Asked) -> bool;
}

/// Blocks after the first that a slot must have alone for [`Source::is_magnified`] to be asked.
const ALIKE: usize = 3;

/// Blocks of a tile.
pub(crate) struct Blocks<'a> {
    planes: &'a TilePlanes,
    blocks: &'a TileBlocks,
}

impl Blocks<'_> {
    #[inline(always)]
    fn only_slot<S: Simd>(&self, s: S, at: Option<&RunBlock>) -> Option<u32> {
        self.planes.only_slot(X16(s), self.blocks, *at?)
    }
}

impl<S: Simd> Source<S> for Blocks<'_> {
    #[inline(always)]
    fn each<const D: bool, K: BlockSink<X16<S>>>(&self, s: S, run: &[RunBlock], sink: &mut K) {
        if !self.each_named::<D, K>(s, run, sink) {
            self.planes
                .each_block::<_, D, _>(X16(s), self.blocks, run, [0, 1], sink);
        }
    }

    #[inline(always)]
    fn each_named<const D: bool, K: BlockSink<X16<S>>>(
        &self,
        s: S,
        run: &[RunBlock],
        sink: &mut K,
    ) -> bool {
        let named = self.planes.is_plain() && run.iter().all(|at| at.slot != NONE);
        if named {
            self.planes.each_named::<_, D, _>(X16(s), run, [0, 1], sink);
        }
        named
    }

    #[inline(always)]
    fn is_magnified(&self, s: S, run: &[RunBlock], view: &View<'_>, asked: &mut Asked) -> bool {
        let seldom = |at: &RunBlock| !at.block.is_multiple_of(SELDOM);
        if asked.refusals >= PATIENCE && run.first().is_none_or(seldom) {
            return false;
        }
        let Some(slot) = self.only_slot(s, run.first()) else {
            return false;
        };
        if slot != asked.slot {
            // The question costs as much as the derivatives of a few blocks.
            if self.only_slot(s, run.get(ALIKE)) != Some(slot) {
                return false;
            }
            let steepest = self.planes.steepest(slot, [0, 1]);
            let near = steepest.is_some_and(|[u, v]| magnifies(s, view, u, v));
            let refusals = if near { 0 } else { asked.refusals + 1 };
            *asked = Asked {
                slot,
                near,
                refusals,
            };
        }
        asked.near
    }
}

/// Takes texels.
pub(crate) trait Brush<S: Simd> {
    fn block(&mut self, s: S, at: RunBlock, texels: u32x16<S>);
}

#[inline(always)]
fn paint<S: Simd, P: Source<S>, B: Brush<S>>(
    s: S,
    view: &View<'_>,
    source: &P,
    levels: &mut Levels,
    run: &[RunBlock],
    brush: &mut B,
) {
    match view.kind {
        Kind::Nearest => {
            if let Some(texels) = packed::Masked::new(s, view)
                && source.each_named::<false, _>(s, run, &mut Nearest { texels, brush })
            {
                return;
            }
            for run in run.chunks(RUN / LANES) {
                source.each::<false, _>(s, run, &mut Placed { levels });
                for (i, at) in run.iter().enumerate() {
                    let [u, v] = levels.uv.at(s, i);
                    brush.block(s, *at, packed::nearest_lanes(s, view, u, v));
                }
            }
        }
        Kind::Bilinear => {
            for run in run.chunks(RUN / LANES) {
                bilinear(s, view, source, levels, run, brush);
            }
        }
        _ => {
            let mut asked = Asked {
                slot: NONE,
                near: false,
                refusals: levels.refusals,
            };
            for mut run in run.chunks(RUN / LANES) {
                while !run.is_empty() {
                    // Neither derivatives nor levels are asked for where the bits do not depend on them.
                    let near = source.is_magnified(s, run, view, &mut asked);
                    let mut alike = 1;
                    while alike < run.len()
                        && source.is_magnified(s, &run[alike..], view, &mut asked) == near
                    {
                        alike += 1;
                    }
                    let (part, rest) = run.split_at(alike);
                    if near {
                        bilinear(s, view, source, levels, part, brush);
                    } else {
                        trilinear(s, view, source, levels, part, brush);
                    }
                    run = rest;
                }
            }
            levels.refusals = asked.refusals;
        }
    }
}

#[inline(always)]
fn bilinear<S: Simd, P: Source<S>, B: Brush<S>>(
    s: S,
    view: &View<'_>,
    source: &P,
    levels: &mut Levels,
    run: &[RunBlock],
    brush: &mut B,
) {
    let mut sink = Placed { levels };
    source.each::<false, _>(s, run, &mut sink);
    for (i, at) in run.iter().enumerate() {
        let [u, v] = levels.uv.at(s, i);
        brush.block(s, *at, packed::bilinear_lanes(s, view, u, v));
    }
}

#[inline(always)]
fn trilinear<S: Simd, P: Source<S>, B: Brush<S>>(
    s: S,
    view: &View<'_>,
    source: &P,
    levels: &mut Levels,
    run: &[RunBlock],
    brush: &mut B,
) {
    let mut sink = Leveled { view, levels };
    source.each::<true, _>(s, run, &mut sink);
    for (i, at) in run.iter().enumerate() {
        let [u, v] = levels.uv.at(s, i);
        let lod = i32x16::from_slice(s, &levels.lod[i * LANES..(i + 1) * LANES]);
        brush.block(s, *at, packed::trilinear_lanes(s, view, u, v, lod));
    }
}

/// Whether a footprint within these changes of u and v to the right and down takes the finest level alone.
#[inline(always)]
fn magnifies<S: Simd>(s: S, view: &View<'_>, [ux, uy]: [f32; 2], [vx, vy]: [f32; 2]) -> bool {
    let footprint = FootprintLanes::new(
        s,
        view,
        f32x16::splat(s, ux),
        f32x16::splat(s, vx),
        f32x16::splat(s, uy),
        f32x16::splat(s, vy),
    );
    packed::lod_lanes(s, view, &footprint)[0] <= 0
}

struct Put<'a> {
    words: &'a mut [u32],
}

impl<S: Simd> Brush<S> for Put<'_> {
    #[inline(always)]
    fn block(&mut self, s: S, at: RunBlock, texels: u32x16<S>) {
        put_block(s, self.words, at, texels);
    }
}

struct PutRows<'a, 'r> {
    rows: &'a mut [&'r mut [u8]],
}

impl<S: Simd> Brush<S> for PutRows<'_, '_> {
    #[inline(always)]
    fn block(&mut self, s: S, at: RunBlock, texels: u32x16<S>) {
        put_block_rows(s, self.rows, at, texels);
    }
}

struct Over<'a> {
    stage: &'a TexelStage,
    light: &'a mut [f32],
    covered: &'a mut [u16],
}

impl<S: Simd> Brush<S> for Over<'_> {
    #[inline(always)]
    fn block(&mut self, s: S, at: RunBlock, texels: u32x16<S>) {
        let color = self.stage.tint_block(s, packed::unpack_lanes(s, texels));
        over_block(s, self.light, at, color, self.covered);
    }
}

struct Nearest<'a, 'v, S: Simd, B> {
    texels: packed::Masked<'v, S>,
    brush: &'a mut B,
}

impl<S: Simd, B: Brush<S>> BlockSink<X16<S>> for Nearest<'_, '_, S, B> {
    #[inline(always)]
    fn pixels(&mut self, X16(s): X16<S>, _: usize, at: RunBlock, values: &BlockValues<X16<S>>) {
        let [u, v] = values.value;
        self.brush.block(s, at, self.texels.nearest(s, u, v));
    }
}

struct Placed<'a> {
    levels: &'a mut Levels,
}

impl<S: Simd> BlockSink<X16<S>> for Placed<'_> {
    #[inline(always)]
    fn pixels(&mut self, _: X16<S>, place: usize, _at: RunBlock, values: &BlockValues<X16<S>>) {
        self.levels.uv.put(place / LANES, values.value);
    }
}

struct Leveled<'a> {
    view: &'a View<'a>,
    levels: &'a mut Levels,
}

impl<S: Simd> BlockSink<X16<S>> for Leveled<'_> {
    #[inline(always)]
    fn pixels(
        &mut self,
        X16(s): X16<S>,
        place: usize,
        _at: RunBlock,
        values: &BlockValues<X16<S>>,
    ) {
        let ([ux, vx], [uy, vy]) = (values.ddx, values.ddy);
        let lod = packed::lod_lanes(
            s,
            self.view,
            &FootprintLanes::new(s, self.view, ux, vx, uy, vy),
        );
        self.levels.uv.put(place / LANES, values.value);
        lod.store_slice(&mut self.levels.lod[place..place + LANES]);
    }
}

//! One tile of samples: visibility first, then each visible pixel shaded once, then what blends, in its order.

use texmap_math::Level;
use texmap_math::lanes::prefetch;
use texmap_raster::{
    NONE, Pass, Prepared, RUN, RUN_ROOM, RunBlock, RunValues, SampleSetup, TileBlocks, TilePlanes,
};

use crate::canvas::{Canvas, Colors, LANES, finish, rows_fit};
use crate::direct::{Direct, From, Levels};
use crate::lit_lanes::{LitLanes, LitScratch};
use crate::plan::Plan;
use crate::shade::{Run, Stages};
use crate::texel::TexelStage;
use texmap_scene::ColorMode;

mod multisample;

use multisample::{Sharing, Strays};

/// Blocks a run.
const RUN_BLOCKS: usize = RUN / LANES;
/// Blocks of a tile.
const BLOCKS: usize = 256;
/// Attributes in order.
pub(crate) const ATTRIBUTES: [usize; texmap_raster::MAX_ATTRIBUTES] = {
    let mut all = [0; texmap_raster::MAX_ATTRIBUTES];
    let mut i = 0;
    while i < all.len() {
        all[i] = i;
        i += 1;
    }
    all
};

/// What is painted, and how.
pub(crate) struct Scenery<'a> {
    pub(crate) plan: &'a Plan<'a>,
    /// Surfaces whose texels go straight onto the canvas.
    pub(crate) direct: Vec<Option<Direct<'a>>>,
    /// Surfaces that are lit sixteen pixels at a time.
    pub(crate) lit: Vec<Option<LitLanes<'a>>>,
    pub(crate) prepared: &'a Prepared<'a>,
    pub(crate) mode: ColorMode,
    /// Linear (or raw), premultiplied.
    pub(crate) background: [f32; 4],
    /// Where the four samples of a pixel lie, if it has four.
    pub(crate) samples: Option<[[i32; 2]; 4]>,
}

/// A tile's buffers; a thread keeps them from tile to tile.
pub(crate) struct Painter {
    /// One, or four of four samples.
    samples: Vec<Sample>,
    resolved: Canvas,
    shader: Shader,
    listed: Listed,
    /// All that was seen is one triangle.
    alone: bool,
    /// [`Sharing`] of each block.
    sharing: Vec<Sharing>,
    strays: Strays,
    shared: SampleSetup,
    /// Of each block, a bit per pixel that is not all background.
    covered: Vec<u16>,
}

struct Sample {
    blocks: TileBlocks,
    canvas: Canvas,
}

impl Painter {
    pub(crate) fn new() -> Self {
        Self {
            samples: vec![Sample::new()],
            resolved: Canvas::new(),
            shader: Shader::new(),
            listed: Listed::default(),
            alone: false,
            sharing: Vec::new(),
            strays: Strays::default(),
            shared: SampleSetup::default(),
            covered: vec![0; BLOCKS],
        }
    }

    /// Visibility alone; where only [`paint`](Self::paint) needs to know, in short.
    pub(crate) fn see(
        &mut self,
        scenery: &Scenery<'_>,
        tile: usize,
        in_short: bool,
    ) -> &TileBlocks {
        let blocks = &mut self.samples[0].blocks;
        self.alone = in_short && scenery.prepared.visible_alone(tile, blocks);
        if !self.alone {
            scenery.prepared.visible_blocks(tile, scenery.plan, blocks);
        }
        blocks
    }

    /// Paints what [`see`](Self::see) saw and the blended surfaces onto the tile's rows of the frame.
    pub(crate) fn paint_rows(
        &mut self,
        scenery: &Scenery<'_>,
        tile: usize,
        rows: &mut [&mut [u8]],
    ) {
        if !self.paint_straight(scenery, tile, rows) {
            let canvas = self.paint(scenery, tile, Some(rows));
            canvas.copy_to(scenery.plan.level, rows);
        }
    }

    /// Paints without a canvas in between, where a whole tile is nothing but texels and there are lanes for them; false, with nothing
    /// done, elsewhere.
    fn paint_straight(
        &mut self,
        scenery: &Scenery<'_>,
        tile: usize,
        rows: &mut [&mut [u8]],
    ) -> bool {
        let blocks = &self.samples[0].blocks;
        let straight = |draw: &u32| {
            let direct = scenery.direct[*draw as usize].as_ref();
            direct.is_some_and(|direct| direct.gives_rows(scenery.plan.level))
        };
        if !rows_fit(rows)
            || !is_whole(&blocks.masks)
            || !blocks.draws.iter().all(straight)
            || blended(scenery.plan, blocks).is_some()
        {
            return false;
        }
        self.prepare(scenery, tile);
        let Self {
            samples,
            shader,
            listed,
            ..
        } = self;
        for (draw, blocks_of) in listed.parts() {
            let Some(direct) = &scenery.direct[draw as usize] else {
                continue;
            };
            for run in blocks_of.chunks(RUN_BLOCKS) {
                ask_for(rows, run);
                let mut from = From {
                    planes: &shader.planes,
                    blocks: &samples[0].blocks,
                    levels: &mut shader.levels,
                };
                direct.put_rows(scenery.plan.level, &mut from, run, rows);
            }
        }
        true
    }

    /// The planes of a tile, and the list of what is visible in it.
    fn prepare(&mut self, scenery: &Scenery<'_>, tile: usize) {
        scenery.prepared.planes(tile, &mut self.shader.planes);
        let blocks = &self.samples[0].blocks;
        self.covered.copy_from_slice(&blocks.masks);
        let slot = if self.alone { 0 } else { NONE };
        self.listed.visible(blocks, &blocks.masks, slot);
    }

    /// Paints what [`see`](Self::see) saw and the blended surfaces: the finished tile for these rows of the frame, or its light if
    /// there are none.
    pub(crate) fn paint(
        &mut self,
        scenery: &Scenery<'_>,
        tile: usize,
        rows: Option<&[&mut [u8]]>,
    ) -> &Canvas {
        let (level, mode) = (scenery.plan.level, scenery.mode);
        self.prepare(scenery, tile);
        let Sample { blocks, canvas } = &mut self.samples[0];
        let blended = blended(scenery.plan, blocks);
        // Where nothing mixes, pixels can be finished one by one.
        let finished = rows.is_some() && blended.is_none_or(|b| b.opaque);
        if !finished {
            canvas.fill_light(scenery.background);
        } else if !is_whole(&blocks.masks) {
            canvas.fill_words(finish(mode, scenery.background));
        }
        self.shader.lay(
            scenery,
            tile,
            blocks,
            &self.listed,
            finished,
            canvas,
            None,
            rows.unwrap_or_default(),
        );
        if blended.is_some() {
            self.listed.blended(scenery, tile, [0; 2], blocks);
            let covered = Some(&mut self.covered[..]);
            self.shader.lay(
                scenery,
                tile,
                blocks,
                &self.listed,
                finished,
                canvas,
                covered,
                &[],
            );
        }
        if !finished && rows.is_some() {
            canvas.finish(level, mode);
        }
        canvas
    }

    /// What [`paint_multisampled`](Self::paint_multisampled) painted.
    pub(crate) fn resolved(&self) -> &Canvas {
        &self.resolved
    }

    /// What [`paint`](Self::paint) painted, and where it is not all background.
    pub(crate) fn light(&self) -> (&Canvas, &[u16]) {
        (&self.samples[0].canvas, &self.covered)
    }

    /// Of each block, the pixels that are not all background.
    pub(crate) fn covered(&self) -> &[u16] {
        &self.covered
    }
}

impl Sample {
    fn new() -> Self {
        Self {
            blocks: TileBlocks::new(),
            canvas: Canvas::new(),
        }
    }
}

const EMPTY: RunBlock = RunBlock {
    block: 0,
    mask: 0,
    slot: NONE,
};

/// Whether every pixel of every block is there.
pub(crate) fn is_whole(masks: &[u16]) -> bool {
    // All, without stopping at the first that is not: many at a time.
    masks.iter().fold(u16::MAX, |all, mask| all & mask) == u16::MAX
}

/// What the blended surfaces of a tile have in common.
#[derive(Clone, Copy)]
struct Blended {
    /// All are opaque after all.
    opaque: bool,
}

/// `None` if nothing blends.
fn blended(plan: &Plan<'_>, blocks: &TileBlocks) -> Option<Blended> {
    let mut found = None;
    for draw in &blocks.draws {
        let surface = &plan.surfaces[*draw as usize];
        if surface.pass == Pass::Blended {
            let opaque = surface.texel.is_some_and(|t| t.is_opaque());
            let before = found.is_none_or(|b: Blended| b.opaque);
            found = Some(Blended {
                opaque: before && opaque,
            });
        }
    }
    found
}

/// Blocks to shade, by surface.
#[derive(Default)]
struct Listed {
    blocks: Vec<RunBlock>,
    /// A draw, and where its blocks end.
    parts: Vec<(u32, usize)>,
    /// Blocks by draw while they are sorted.
    loose: Vec<(u32, RunBlock)>,
    /// The draw and the slot of which these are all blocks in full: most tiles of a near surface have one list.
    whole: Option<(u32, u32)>,
}

impl Listed {
    /// The blocks of each draw, draw after draw.
    fn parts(&self) -> impl Iterator<Item = (u32, &[RunBlock])> {
        let starts = std::iter::once(0).chain(self.parts.iter().map(|(_, end)| *end));
        let parts = starts.zip(&self.parts);
        parts.map(|(start, (draw, end))| (*draw, &self.blocks[start..*end]))
    }

    fn clear(&mut self) {
        self.blocks.clear();
        self.parts.clear();
    }

    fn push(&mut self, draw: u32, at: RunBlock) {
        self.blocks.push(at);
        let end = self.blocks.len();
        match self.parts.last_mut() {
            Some(last) if last.0 == draw => last.1 = end,
            _ => self.parts.push((draw, end)),
        }
    }

    /// The pixels of `masks` by draw; all are of `slot`, or each has its own.
    fn visible(&mut self, blocks: &TileBlocks, masks: &[u16], slot: u32) {
        let before = self.whole.take();
        let some = masks.iter().enumerate().filter(|(_, mask)| **mask != 0);
        let at = |block: usize, mask| RunBlock {
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
    fn blended(
        &mut self,
        scenery: &Scenery<'_>,
        tile: usize,
        offset: [i32; 2],
        blocks: &mut TileBlocks,
    ) {
        self.clear();
        self.whole = None;
        let wanted = |draw: &texmap_raster::Draw<'_>| draw.pass == Pass::Blended;
        let prepared = scenery.prepared;
        prepared.forward_sample(tile, offset, blocks, &wanted, &mut self.blocks);
        // Slots rise from block to block, and sixteen of them belong to one draw.
        let mut end = 0;
        while let Some(first) = self.blocks.get(end) {
            let sixteen = first.slot as usize / LANES;
            let same = |at: &RunBlock| at.slot as usize / LANES == sixteen;
            end += self.blocks[end..].partition_point(same);
            let draw = blocks.draws[sixteen];
            match self.parts.last_mut() {
                Some(last) if last.0 == draw => last.1 = end,
                _ => self.parts.push((draw, end)),
            }
        }
    }
}

/// Shades runs.
struct Shader {
    planes: TilePlanes,
    values: RunValues,
    levels: Levels,
    stages: Stages,
    lit: LitScratch,
    colors: Colors,
    words: [u32; RUN_ROOM],
}

/// A shaded run.
enum Shown<'a> {
    /// One finished pixel; opaque.
    Word(u32),
    /// Finished pixels; opaque.
    Words(&'a [u32]),
    /// Opaque light that is to be finished.
    Unfinished(&'a Colors),
    Light(&'a Colors),
}

impl Shown<'_> {
    fn put(&self, level: Level, mode: ColorMode, run: &[RunBlock], canvas: &mut Canvas) {
        match self {
            Self::Word(word) => canvas.put_word(level, run, *word),
            Self::Words(words) => canvas.put_words(run, words),
            Self::Unfinished(colors) => canvas.put_finished(level, mode, run, colors),
            Self::Light(colors) => canvas.put(level, run, colors),
        }
    }
}

/// Asks for the lines of the frame's rows that a run's blocks are copied to in the end: they come while it is shaded. Sixteen blocks side
/// by side lie in sixteen lines, so that each asks for one.
fn ask_for(rows: &[&mut [u8]], run: &[RunBlock]) {
    if rows.is_empty() {
        return;
    }
    // Most runs are a row of blocks: its sixteen lines in order.
    if let [first, .., last] = run
        && first.block % 16 == 0
        && (run.len(), last.block) == (16, first.block + 15)
    {
        let four = rows.iter().skip(usize::from(first.block) / 4).take(4);
        four.for_each(|row| row.chunks(64).for_each(prefetch));
        return;
    }
    for at in run {
        let (column, row) = (usize::from(at.block) % 16, usize::from(at.block) / 16);
        let line = rows
            .get(row * 4 + column % 4)
            .and_then(|row| row.get(column / 4 * 64..));
        if let Some(line) = line {
            prefetch(line);
        }
    }
}

fn mark(run: &[RunBlock], covered: &mut [u16]) {
    for at in run {
        covered[at.block as usize] |= at.mask;
    }
}

impl Shader {
    fn new() -> Self {
        Self {
            planes: TilePlanes::new(),
            values: RunValues::default(),
            levels: Levels::new(),
            stages: Stages::default(),
            lit: LitScratch::default(),
            colors: Colors::new(),
            words: [0; RUN_ROOM],
        }
    }

    /// Paints the listed blocks, in order: in place of what is there, or `over` it, where pixels that are not all clear are marked;
    /// `finished` if the tile holds finished pixels.
    fn lay(
        &mut self,
        scenery: &Scenery<'_>,
        tile: usize,
        blocks: &TileBlocks,
        listed: &Listed,
        finished: bool,
        canvas: &mut Canvas,
        mut over: Option<&mut [u16]>,
        ahead: &[&mut [u8]],
    ) {
        for (draw, blocks_of) in listed.parts() {
            // Most tiles are soon covered.
            let unmarked = over.as_ref().is_some_and(|covered| !is_whole(covered));
            for run in blocks_of.chunks(RUN_BLOCKS) {
                ask_for(ahead, run);
                let (part, covered) = ((draw, run), over.as_deref_mut());
                let put = self.lay_run(scenery, tile, blocks, part, finished, canvas, covered);
                if put
                    && unmarked
                    && let Some(covered) = &mut over
                {
                    mark(run, covered);
                }
            }
        }
    }

    /// Paints a run of a draw; whether it has taken the place of what was there: else it lies over that, and is marked.
    fn lay_run(
        &mut self,
        scenery: &Scenery<'_>,
        tile: usize,
        blocks: &TileBlocks,
        (draw, run): (u32, &[RunBlock]),
        finished: bool,
        canvas: &mut Canvas,
        mut over: Option<&mut [u16]>,
    ) -> bool {
        let (level, mode) = (scenery.plan.level, scenery.mode);
        if let Some(direct) = &scenery.direct[draw as usize] {
            let mut from = From {
                planes: &self.planes,
                blocks,
                levels: &mut self.levels,
            };
            if finished {
                if direct.put(level, &mut from, run, canvas) {
                    return true;
                }
            } else if let Some(covered) = over.as_deref_mut()
                && direct.over(level, &mut from, run, canvas, covered)
            {
                return false;
            }
        }
        let shown = self.shade(scenery, tile, draw, blocks, run, finished);
        if let (Shown::Light(colors), Some(covered)) = (&shown, over) {
            canvas.over(level, run, colors, covered);
            return false;
        }
        shown.put(level, mode, run, canvas);
        true
    }

    /// Shades the listed blocks in runs of one surface, in order, and shows each to `sink`.
    fn each_run(
        &mut self,
        scenery: &Scenery<'_>,
        tile: usize,
        blocks: &TileBlocks,
        listed: &Listed,
        mut sink: impl FnMut(Shown<'_>, &[RunBlock]),
    ) {
        for (draw, blocks_of) in listed.parts() {
            for run in blocks_of.chunks(RUN_BLOCKS) {
                sink(self.shade(scenery, tile, draw, blocks, run, false), run);
            }
        }
    }

    fn shade(
        &mut self,
        scenery: &Scenery<'_>,
        tile: usize,
        draw: u32,
        blocks: &TileBlocks,
        run: &[RunBlock],
        finished: bool,
    ) -> Shown<'_> {
        let (plan, level) = (scenery.plan, scenery.plan.level);
        let surface = &plan.surfaces[draw as usize];
        if let Some(lit) = &scenery.lit[draw as usize] {
            if lit.reads_all() {
                let (wanted, values) = (&ATTRIBUTES[..surface.shaded], &mut self.values);
                self.planes.values(level, blocks, run, wanted, true, values);
            }
            let run = Run {
                prepared: scenery.prepared,
                tile: scenery.prepared.tile(tile),
                blocks,
                run,
                values: &self.values,
            };
            let (stages, lit_scratch) = (&mut self.stages, &mut self.lit);
            lit.shade(
                plan,
                &self.planes,
                &run,
                stages,
                lit_scratch,
                &mut self.colors,
            );
            return if finished {
                Shown::Unfinished(&self.colors)
            } else {
                Shown::Light(&self.colors)
            };
        }
        let count = run.len() * LANES;
        let slot = surface.base_color.as_ref();
        let (wanted, derivatives) = match &surface.texel {
            Some(_) => (
                &ATTRIBUTES[..if slot.is_some() { 2 } else { 0 }],
                slot.is_some_and(|slot| slot.reads_derivatives()),
            ),
            None => (&ATTRIBUTES[..surface.shaded], true),
        };
        if !wanted.is_empty() {
            let values = &mut self.values;
            self.planes
                .values(level, blocks, run, wanted, derivatives, values);
        }
        match (&surface.texel, slot) {
            (Some(stage), Some(slot)) if finished && stage.gives_words() => {
                TexelStage::words(level, slot, &mut self.values, count, &mut self.words);
                return Shown::Words(&self.words[..count]);
            }
            (Some(stage), None) if finished => return Shown::Word(stage.word()),
            (Some(stage), _) => {
                stage.colors(level, slot, &mut self.values, count, &mut self.colors);
            }
            (None, _) => {
                let run = Run {
                    prepared: scenery.prepared,
                    tile: scenery.prepared.tile(tile),
                    blocks,
                    run,
                    values: &self.values,
                };
                self.stages.shade(plan, surface, &run, &mut self.colors);
            }
        }
        if finished {
            Shown::Unfinished(&self.colors)
        } else {
            Shown::Light(&self.colors)
        }
    }
}

//! One tile of samples: visibility first, then each visible pixel is shaded once, then the blended surfaces in their order.

mod fragments;
pub(crate) mod job;
mod msaa;
mod supersample;

use texmap_math::lanes::prefetch;
use texmap_raster::{
    AttributePlanes, BATCH_PIXELS, BATCH_STRIDE, BinnedDraws, FragmentBlock, NO_PRIMITIVE,
    SampleSetup, TileVisibility, Varyings,
};

use crate::Aov;
use crate::plan::{BoundAlphaTests, Plan, Shader};
use crate::resolve::aov::write_batch;
use crate::resolve::copy::{put_block_rows, put_pixels_rows, rows_fit};
use crate::resolve::encode::encode;
use crate::resolve::rows::AovRows;
use crate::resolve::tile_buffer::{Shaded, TileBuffer};
pub(crate) use fragments::is_whole;
use fragments::{FragmentList, blended};
use msaa::{SampleReuse, Strays};
use texmap_scene::ColorMode;
use texmap_shade::batch::{Batch, Colors, LANES};
use texmap_shade::surface::SurfaceScratch;
use texmap_shade::texels::{Pixels, read_nearest, read_texels};
use texmap_shade::unlit::{Unlit, UnlitScratch};

/// Blocks of a batch.
const BATCH_BLOCKS: usize = BATCH_PIXELS / LANES;
/// Blocks of a tile.
const BLOCKS: usize = 256;
/// Attributes in order.
pub(crate) const ATTRIBUTES: [usize; texmap_raster::MAX_ATTRIBUTES] = {
    let mut all = [0; texmap_raster::MAX_ATTRIBUTES];
    let mut k = 0;
    while k < all.len() {
        all[k] = k;
        k += 1;
    }
    all
};

/// Common data of all tiles of a pass.
pub(crate) struct Context<'a> {
    pub(crate) plan: &'a Plan<'a>,
    /// The stages of each draw, and its encoded color where it is unlit and has no texture.
    pub(crate) shaders: Vec<(Shader<'a>, u32)>,
    pub(crate) prepared: &'a BinnedDraws<'a>,
    pub(crate) alpha: BoundAlphaTests<'a>,
    pub(crate) mode: ColorMode,
    /// Linear (or raw), premultiplied.
    pub(crate) background: [f32; 4],
    /// The positions of the four samples of a pixel, if it has four.
    pub(crate) samples: Option<[[i32; 2]; 4]>,
}

/// The buffers of a tile; a thread keeps them from tile to tile.
pub(crate) struct Painter {
    /// One, or four of four samples.
    samples: Vec<Sample>,
    resolved: TileBuffer,
    shader: BatchShader,
    list: FragmentList,
    /// One triangle covers the tile.
    alone: bool,
    /// [`SampleReuse`] of each block.
    reuse: Vec<SampleReuse>,
    strays: Strays,
    shared: SampleSetup,
    /// A mask of each block with the pixels that are not all background.
    covered: Vec<u16>,
}

/// A sample of each pixel of a tile.
struct Sample {
    blocks: TileVisibility,
    buffer: TileBuffer,
}

/// A tile whose visibility is known.
#[derive(Clone, Copy)]
struct Tile<'a> {
    context: &'a Context<'a>,
    index: usize,
    blocks: &'a TileVisibility,
}

/// Buffer and mode in which batches are stored.
struct Target<'a> {
    buffer: &'a mut TileBuffer,
    /// The buffer holds encoded pixels, else light.
    encoded: bool,
    /// Batches are blended over the buffer; pixels that are not all transparent are marked.
    covered: Option<&'a mut [u16]>,
    /// Rows of the frame to prefetch.
    rows: &'a [&'a mut [u8]],
}

impl Painter {
    pub(crate) fn new() -> Self {
        Self {
            samples: vec![Sample::new()],
            resolved: TileBuffer::new(),
            shader: BatchShader::default(),
            list: FragmentList::default(),
            alone: false,
            reuse: Vec::new(),
            strays: Strays::default(),
            shared: SampleSetup::default(),
            covered: vec![0; BLOCKS],
        }
    }

    /// Finds the visible triangle of each pixel; `brief` if nothing but [`paint`](Self::paint) reads them.
    pub(crate) fn see(&mut self, context: &Context<'_>, tile: usize, brief: bool) {
        let blocks = &mut self.samples[0].blocks;
        self.alone = brief && context.prepared.covering_primitive(tile, blocks);
        if !self.alone {
            context
                .prepared
                .visible_blocks(tile, &context.alpha, blocks);
        }
        context.prepared.planes(tile, &mut self.shader.planes);
        self.covered.copy_from_slice(&blocks.masks);
        let slot = if self.alone { 0 } else { NO_PRIMITIVE };
        self.list.visible(blocks, &blocks.masks, slot);
    }

    /// Writes the output arrays of the visible fragments.
    pub(crate) fn write_aovs(
        &mut self,
        context: &Context<'_>,
        index: usize,
        aovs: &mut [(Aov, AovRows<'_, '_>)],
    ) {
        let (level, blocks) = (context.plan.level, &self.samples[0].blocks);
        let BatchShader { planes, values, .. } = &mut self.shader;
        for (draw, blocks_of) in self.list.parts() {
            let surface = &context.plan.surfaces[draw as usize];
            let wanted = &ATTRIBUTES[..surface.vertices.attribute_count];
            for batch in blocks_of.chunks(BATCH_BLOCKS) {
                planes.values(level, blocks, batch, wanted, true, values);
                let batch = Batch {
                    prepared: context.prepared,
                    tile: context.prepared.tile(index),
                    blocks,
                    list: batch,
                    values,
                };
                write_batch(context.plan, surface, &batch, aovs);
            }
        }
    }

    /// Paints the tile into its rows of the frame.
    pub(crate) fn paint_rows(
        &mut self,
        context: &Context<'_>,
        tile: usize,
        rows: &mut [&mut [u8]],
    ) {
        if !self.paint_straight(context, rows) {
            let buffer = self.paint(context, tile, Some(rows));
            buffer.copy_to(context.plan.level, rows);
        }
    }

    /// Paints a tile in which every pixel is an encoded texel, without a tile buffer. False, with nothing done, for other tiles.
    fn paint_straight(&mut self, context: &Context<'_>, rows: &mut [&mut [u8]]) -> bool {
        let blocks = &self.samples[0].blocks;
        let exact = |draw: &u32| {
            let unlit = context.shaders[*draw as usize].0.unlit();
            unlit.is_some_and(|unlit| unlit.encoded_view().is_some())
        };
        if !rows_fit(rows)
            || !is_whole(&blocks.masks)
            || !blocks.draws.iter().all(exact)
            || blended(context.plan, blocks).is_some()
        {
            return false;
        }
        let BatchShader {
            planes,
            unlit: scratch,
            words,
            ..
        } = &mut self.shader;
        let (level, pixels) = (context.plan.level, Pixels::Blocks(planes, blocks));
        for (draw, blocks_of) in self.list.parts() {
            let unlit = context.shaders[draw as usize].0.unlit();
            let Some(view) = unlit.and_then(Unlit::encoded_view) else {
                continue;
            };
            for batch in blocks_of.chunks(BATCH_BLOCKS) {
                prefetch_rows(rows, batch);
                let stored = read_nearest(
                    level,
                    view,
                    &pixels,
                    batch,
                    #[inline(always)]
                    |at, pixel, words| put_pixels_rows(rows, at, pixel % LANES, words),
                );
                if stored {
                    continue;
                }
                read_texels(level, view, &pixels, batch, &mut scratch.addresses, words);
                for (at, words) in batch.iter().zip(words.as_chunks().0) {
                    put_block_rows(rows, *at, words);
                }
            }
        }
        true
    }

    /// Paints the visible and then the blended surfaces: encoded for these rows of the frame, or as light if there are none.
    pub(crate) fn paint(
        &mut self,
        context: &Context<'_>,
        index: usize,
        rows: Option<&[&mut [u8]]>,
    ) -> &TileBuffer {
        let (level, mode) = (context.plan.level, context.mode);
        let Sample { blocks, buffer } = &mut self.samples[0];
        let blended = blended(context.plan, blocks);
        // Without blending, pixels can be encoded one by one.
        let encoded = rows.is_some() && blended.is_none_or(|b| b.opaque);
        if !encoded {
            buffer.fill_light(context.background);
        } else if !is_whole(&blocks.masks) {
            buffer.fill_words(encode(mode, context.background));
        }
        let tile = Tile {
            context,
            index,
            blocks,
        };
        let mut target = Target {
            buffer,
            encoded,
            covered: None,
            rows: rows.unwrap_or_default(),
        };
        self.shader.draw(tile, &self.list, &mut target);
        if blended.is_some() {
            self.list.blended(context.prepared, index, [0; 2], blocks);
            let tile = Tile {
                context,
                index,
                blocks,
            };
            let mut target = Target {
                buffer,
                encoded,
                covered: Some(&mut self.covered),
                rows: &[],
            };
            self.shader.draw(tile, &self.list, &mut target);
        }
        if !encoded && rows.is_some() {
            buffer.encode_all(level, mode);
        }
        buffer
    }

    /// [`paint_rows`](Self::paint_rows) by way of light, which [`light_at`](Self::light_at) reads.
    pub(crate) fn paint_light(
        &mut self,
        context: &Context<'_>,
        tile: usize,
        rows: &mut [&mut [u8]],
    ) {
        self.paint(context, tile, None);
        let (level, buffer) = (context.plan.level, &mut self.samples[0].buffer);
        buffer.encode_all(level, context.mode);
        buffer.copy_to(level, rows);
    }

    /// The light of a pixel by its index in the blocks of the tile that was painted as light.
    pub(crate) fn light_at(&self, index: usize) -> [f32; 4] {
        self.samples[0].buffer.light_at(index)
    }

    /// The tile that [`paint_multisampled`](Self::paint_multisampled) painted.
    pub(crate) fn resolved(&self) -> &TileBuffer {
        &self.resolved
    }

    /// A mask of each block with the pixels that are not all background.
    pub(crate) fn covered(&self) -> &[u16] {
        &self.covered
    }
}

impl Sample {
    fn new() -> Self {
        Self {
            blocks: TileVisibility::new(),
            buffer: TileBuffer::new(),
        }
    }
}

/// Prefetches the lines of the frame's rows that the blocks of a batch are copied to in the end: they come while it is shaded.
/// Sixteen blocks side by side lie in sixteen lines, so that each asks for one.
fn prefetch_rows(rows: &[&mut [u8]], batch: &[FragmentBlock]) {
    if rows.is_empty() {
        return;
    }
    // Most batches are a row of blocks: its sixteen lines in order.
    if let [first, .., last] = batch
        && first.block % 16 == 0
        && (batch.len(), last.block) == (16, first.block + 15)
    {
        let four = rows.iter().skip(usize::from(first.block) / 4).take(4);
        four.for_each(|row| row.chunks(64).for_each(prefetch));
        return;
    }
    for at in batch {
        let (column, row) = (usize::from(at.block) % 16, usize::from(at.block) / 16);
        let line = rows
            .get(row * 4 + column % 4)
            .and_then(|row| row.get(column / 4 * 64..));
        if let Some(line) = line {
            prefetch(line);
        }
    }
}

/// Shades batches.
struct BatchShader {
    planes: AttributePlanes,
    values: Varyings,
    unlit: UnlitScratch,
    surface: SurfaceScratch,
    colors: Colors,
    words: [u32; BATCH_STRIDE],
}

impl Default for BatchShader {
    fn default() -> Self {
        Self {
            planes: AttributePlanes::new(),
            values: Varyings::default(),
            unlit: UnlitScratch::default(),
            surface: SurfaceScratch::default(),
            colors: Colors::default(),
            words: [0; BATCH_STRIDE],
        }
    }
}

impl BatchShader {
    /// Shades the listed blocks, in order, and stores them.
    fn draw(&mut self, tile: Tile<'_>, list: &FragmentList, target: &mut Target<'_>) {
        let (level, mode) = (tile.context.plan.level, tile.context.mode);
        for (draw, blocks_of) in list.parts() {
            for batch in blocks_of.chunks(BATCH_BLOCKS) {
                prefetch_rows(target.rows, batch);
                let shaded = self.shade(tile, draw, batch, target.encoded);
                let buffer = &mut *target.buffer;
                match (&shaded, &mut target.covered) {
                    (Shaded::Word(word), _) => buffer.put_word(batch, *word),
                    (Shaded::Words(words), _) => buffer.put_words(batch, words),
                    _ if target.encoded => buffer.put_encoded(level, mode, batch, &shaded),
                    (_, Some(covered)) => {
                        buffer.blend(level, batch, &shaded, covered);
                        continue;
                    }
                    (_, None) => buffer.put_light(level, batch, &shaded),
                }
                if let Some(covered) = &mut target.covered {
                    batch
                        .iter()
                        .for_each(|at| covered[usize::from(at.block)] |= at.mask);
                }
            }
        }
    }

    /// The colors of a batch; encoded where that costs nothing more and `encoded` asks for it.
    fn shade(
        &mut self,
        tile: Tile<'_>,
        draw: u32,
        batch: &[FragmentBlock],
        encoded: bool,
    ) -> Shaded<'_> {
        let Tile {
            context,
            index,
            blocks,
        } = tile;
        let level = context.plan.level;
        let (shader, word) = &context.shaders[draw as usize];
        if let Shader::Unlit(unlit) = shader {
            let pixels = Pixels::Blocks(&self.planes, blocks);
            if let Some(view) = unlit.encoded_view().filter(|_| encoded) {
                let addresses = &mut self.unlit.addresses;
                read_texels(level, view, &pixels, batch, addresses, &mut self.words);
                return Shaded::Words(&self.words);
            }
            if unlit.gives_words() {
                unlit.read_words(level, &pixels, batch, &mut self.unlit, &mut self.words);
                return if encoded && unlit.color().is_exact() {
                    Shaded::Words(&self.words)
                } else {
                    Shaded::Texels(*unlit.color(), &self.words)
                };
            }
            if encoded && !unlit.has_texture() {
                return Shaded::Word(*word);
            }
            unlit.shade(level, &pixels, batch, &mut self.unlit, &mut self.colors);
            return Shaded::Untinted(*unlit.color(), &self.colors);
        }
        if let Shader::Surface(surface) = shader
            && let Some(count) = surface.attributes.filter(|count| *count > 0)
        {
            let wanted = &ATTRIBUTES[..count];
            let values = &mut self.values;
            self.planes
                .values(level, blocks, batch, wanted, true, values);
        }
        let batch = Batch {
            prepared: context.prepared,
            tile: context.prepared.tile(index),
            blocks,
            list: batch,
            values: &self.values,
        };
        match shader {
            Shader::Surface(surface) => {
                let scratch = &mut self.surface;
                return Shaded::Light(surface.shade(&self.planes, &batch, scratch));
            }
            Shader::Sky(sky) => sky.shade(level, &batch, &mut self.colors),
            Shader::Volume(volume) => volume.shade(&batch, &mut self.colors),
            Shader::Unlit(_) => {}
        }
        Shaded::Light(&self.colors)
    }
}

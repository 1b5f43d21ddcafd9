//! One block of 64 x 64 pixels: its tile of samples, or the mean of several tiles, and the AOVs.

use texmap_math::color;
use texmap_raster::{Fragment, NONE, Prepared, TILE, TileBlocks, TriangleSetup, block_index};

use crate::canvas::{fill_rows, finish};
use crate::direct::Direct;
use crate::lit_lanes::LitLanes;
use crate::plan::{Plan, Surface};
use crate::rows::AovRows;
use crate::shade::{facing_normal, three};
use crate::tile::{Painter, Scenery, is_whole};
use crate::{Aov, HOLE_BITS, Settings};
use texmap_scene::{ColorMode, Scene};

/// Pixels of a block and samples of a tile.
const PIXELS: usize = (TILE * TILE) as usize;

/// One pass over the frame.
pub(crate) struct Job<'a> {
    scenery: Scenery<'a>,
    /// Samples per pixel and axis of this pass, each in a tile of its own.
    samples: u32,
    /// Tiles across the grid of samples.
    tiles_across: u32,
}

/// A block and the parts of the frame that it owns.
pub(crate) struct Block<'r, 'a> {
    /// In blocks, from the left and from the top.
    column: u32,
    row: u32,
    /// Empty if this pass has no colour.
    pub(crate) rgba: &'r mut [&'a mut [u8]],
    pub(crate) aovs: Vec<(Aov, AovRows<'r, 'a>)>,
}

impl Block<'_, '_> {
    /// All blocks of a frame, row by row from the top left, without buffers.
    pub(crate) fn all(width: u32, height: u32) -> impl Iterator<Item = Self> {
        let across = width.div_ceil(TILE);
        (0..across * height.div_ceil(TILE)).map(move |i| Self {
            column: i % across,
            row: i / across,
            rgba: &mut [],
            aovs: Vec::new(),
        })
    }
}

/// What a thread keeps between blocks.
pub(crate) struct Scratch {
    painter: Painter,
    setups: SetupCache,
    /// Sums over the samples of each pixel; empty for one sample.
    sums: Vec<[f32; 4]>,
    covered: Vec<bool>,
}

impl Scratch {
    pub(crate) fn new() -> Self {
        Self {
            painter: Painter::new(),
            setups: SetupCache::new(),
            sums: Vec::new(),
            covered: Vec::new(),
        }
    }
}

impl<'a> Job<'a> {
    pub(crate) fn new(
        scene: &Scene,
        settings: &Settings,
        plan: &'a Plan<'a>,
        prepared: &'a Prepared<'a>,
        samples: Option<[[i32; 2]; 4]>,
    ) -> Self {
        let [r, g, b, a] = scene.background;
        let light = |c: f32| {
            if scene.color == ColorMode::Srgb {
                color::srgb_to_linear(c)
            } else {
                c
            }
        };
        Self {
            scenery: Scenery {
                plan,
                direct: plan.surfaces.iter().map(Direct::new).collect(),
                lit: plan
                    .surfaces
                    .iter()
                    .map(|surface| LitLanes::new(plan, surface))
                    .collect(),
                prepared,
                mode: scene.color,
                background: [light(r) * a, light(g) * a, light(b) * a, a],
                samples,
            },
            samples: prepared.size().width() / settings.width,
            tiles_across: prepared.size().width().div_ceil(TILE),
        }
    }

    /// Draws a block and returns how many of its pixels are covered.
    pub(crate) fn draw(&self, mut block: Block<'_, '_>, scratch: &mut Scratch) -> u64 {
        if self.samples > 1 {
            return self.draw_supersampled(block, scratch);
        }
        let index = (block.row * self.tiles_across + block.column) as usize;
        if self.scenery.prepared.is_empty(index) {
            let word = finish(self.scenery.mode, self.scenery.background);
            fill_rows(self.scenery.plan.level, block.rgba, word);
            return 0;
        }
        if let Some(places) = self.scenery.samples {
            let painter = &mut scratch.painter;
            painter.paint_multisampled(&self.scenery, places, index);
        } else {
            let in_short = block.aovs.is_empty();
            let blocks = scratch.painter.see(&self.scenery, index, in_short);
            if !block.aovs.is_empty() {
                scratch.setups.clear();
                write_aovs(
                    &self.scenery,
                    index,
                    blocks,
                    &mut block,
                    &mut scratch.setups,
                );
            }
            if block.rgba.is_empty() {
                return 0;
            }
        }
        let painter = &mut scratch.painter;
        if self.scenery.samples.is_some() {
            let level = self.scenery.plan.level;
            painter.resolved().copy_to(level, block.rgba);
        } else {
            painter.paint_rows(&self.scenery, index, block.rgba);
        }
        count_ones(scratch.painter.covered())
    }

    /// The mean, in linear light, of n x n tiles of samples.
    fn draw_supersampled(&self, block: Block<'_, '_>, scratch: &mut Scratch) -> u64 {
        let n = self.samples;
        let Scratch {
            painter,
            sums,
            covered,
            ..
        } = scratch;
        sums.clear();
        sums.resize(PIXELS, [0.0; 4]);
        covered.clear();
        covered.resize(PIXELS, false);
        for y in block.row * n..(block.row + 1) * n {
            for x in block.column * n..(block.column + 1) * n {
                let index = (y * self.tiles_across + x) as usize;
                if x < self.tiles_across && index < self.scenery.prepared.tiles() {
                    self.add_tile(index, &block, painter, sums, covered);
                }
            }
        }
        let samples = (n * n) as f32;
        for (y, row) in block.rgba.iter_mut().enumerate() {
            for (x, pixel) in row.chunks_exact_mut(4).enumerate() {
                let mean = sums[y * TILE as usize + x].map(|sum| sum / samples);
                pixel.copy_from_slice(&finish(self.scenery.mode, mean).to_le_bytes());
            }
        }
        covered.iter().filter(|covered| **covered).count() as u64
    }

    fn add_tile(
        &self,
        index: usize,
        block: &Block<'_, '_>,
        painter: &mut Painter,
        sums: &mut [[f32; 4]],
        covered: &mut [bool],
    ) {
        painter.see(&self.scenery, index, true);
        painter.paint(&self.scenery, index, None);
        let tile = self.scenery.prepared.tile(index);
        let (canvas, masks) = painter.light();
        for y in 0..tile.height {
            for x in 0..tile.width {
                let at = block_index(x, y);
                let pixel_x = (tile.x0 + x) / self.samples - block.column * TILE;
                let pixel_y = (tile.y0 + y) / self.samples - block.row * TILE;
                let pixel = (pixel_y * TILE + pixel_x) as usize;
                for (sum, value) in sums[pixel].iter_mut().zip(canvas.light_at(at)) {
                    *sum += value;
                }
                covered[pixel] |= masks[at / 16] >> (at % 16) & 1 == 1;
            }
        }
    }
}

/// Four masks at a time.
fn count_ones(masks: &[u16]) -> u64 {
    if is_whole(masks) {
        return masks.len() as u64 * u64::from(u16::BITS);
    }
    let four = masks.chunks(4).map(|four| {
        let all = four
            .iter()
            .fold(0, |all, mask| all << 16 | u64::from(*mask));
        u64::from(all.count_ones())
    });
    four.sum()
}

/// Set-ups of the triangles met last, for one tile.
struct SetupCache {
    slots: Vec<Option<(u32, TriangleSetup)>>,
}

impl SetupCache {
    const SLOTS: usize = 64;

    fn new() -> Self {
        Self {
            slots: vec![None; Self::SLOTS],
        }
    }

    /// To be called when the tile changes.
    fn clear(&mut self) {
        self.slots.fill(None);
    }

    fn evaluate(&mut self, prepared: &Prepared<'_>, id: u32, [x, y]: [u32; 2], out: &mut Fragment) {
        let slot = &mut self.slots[id as usize % Self::SLOTS];
        let setup = match slot {
            Some((of, setup)) if *of == id => setup,
            _ => &mut slot.insert((id, prepared.setup(id, x / TILE, y / TILE))).1,
        };
        setup.evaluate(x, y, out);
    }
}

fn write_aovs(
    scenery: &Scenery<'_>,
    index: usize,
    blocks: &TileBlocks,
    block: &mut Block<'_, '_>,
    setups: &mut SetupCache,
) {
    let tile = scenery.prepared.tile(index);
    let mut fragment = Fragment::default();
    for y in 0..tile.height {
        for x in 0..tile.width {
            let slot = blocks.slot[block_index(x, y)];
            if slot == NONE {
                continue;
            }
            let id = blocks.ids[slot as usize];
            setups.evaluate(
                scenery.prepared,
                id,
                [tile.x0 + x, tile.y0 + y],
                &mut fragment,
            );
            let (draw, triangle) = scenery.prepared.source(id);
            let surface = &scenery.plan.surfaces[draw as usize];
            let (x, y) = (x as usize, y as usize);
            for (aov, rows) in &mut block.aovs {
                match rows {
                    AovRows::U32(rows) => rows[y][x] = surface.mesh.face(triangle),
                    AovRows::F32(rows) => {
                        let channels = aov.channels();
                        let values = aov_values(*aov, scenery.plan, surface, &fragment, triangle);
                        rows[y][x * channels..][..channels].copy_from_slice(&values[..channels]);
                    }
                }
            }
        }
    }
}

/// Values of an f32 AOV, holes where the surface has none (or none that is finite).
fn aov_values(
    aov: Aov,
    plan: &Plan<'_>,
    surface: &Surface<'_>,
    fragment: &Fragment,
    triangle: u32,
) -> [f32; 3] {
    let hole = f32::from_bits(HOLE_BITS);
    let values = match aov {
        Aov::Depth => Some([fragment.depth, hole, hole]),
        Aov::InvW => Some([fragment.inv_w, hole, hole]),
        Aov::Uv => surface.uv.at(fragment).map(|(uv, _)| [uv[0], uv[1], hole]),
        Aov::Lod => surface
            .base_color
            .as_ref()
            .zip(surface.uv.at(fragment))
            .map(|(slot, (uv, d))| {
                let (_, d) = slot.place(uv, d);
                [slot.sampler.lod(&slot.texture, d), hole, hole]
            }),
        Aov::Normal => surface
            .normal
            .and_then(|first| unit(facing_normal(fragment, first))),
        Aov::Position => surface.position.map(|first| three(fragment, first)),
        Aov::Shadow(light) => surface.effects.as_ref().and_then(|effects| {
            let point = three(fragment, surface.position?);
            let plane = effects.plane(triangle, fragment.front);
            let share = plan.ready.shadow(usize::from(light), point, plane)?;
            Some([share, hole, hole])
        }),
        Aov::Face => None,
    };
    let channels = aov.channels();
    values
        .filter(|v| v[..channels].iter().all(|v| v.is_finite()))
        .unwrap_or([hole; 3])
}

fn unit(v: [f32; 3]) -> Option<[f32; 3]> {
    let length = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
    (length > 0.0).then(|| v.map(|x| x / length))
}

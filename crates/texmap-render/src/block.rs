//! One block of 64 x 64 pixels: visibility, shading and blending of its samples, their mean, and the AOVs.

use texmap_math::color;
use texmap_raster::{Fragment, NONE, Prepared, TILE, TileBuffers};

use crate::plan::{Plan, Surface};
use crate::rows::AovRows;
use crate::shade::{Hit, RUN, SetupCache, Stages, facing_normal, straight, three};
use crate::{Aov, ColorMode, HOLE_BITS, Scene, Settings};

/// Pixels of a block and samples of a tile.
const PIXELS: usize = (TILE * TILE) as usize;

/// One pass over the frame.
pub(crate) struct Job<'a> {
    plan: &'a Plan<'a>,
    prepared: &'a Prepared<'a>,
    /// Linear (or raw), premultiplied.
    background: [f32; 4],
    color: ColorMode,
    /// Samples per pixel and axis of this pass.
    samples: u32,
    /// Tiles across the grid of samples.
    tiles_across: u32,
}

/// A block and the parts of the frame that it owns.
pub(crate) struct Block<'a> {
    /// In blocks, from the left and from the top.
    column: u32,
    row: u32,
    width: u32,
    height: u32,
    /// Empty if this pass has no colour.
    pub(crate) rgba: Vec<&'a mut [u8]>,
    pub(crate) aovs: Vec<(Aov, AovRows<'a>)>,
}

impl Block<'_> {
    /// All blocks of a frame, row by row from the top left, without buffers.
    pub(crate) fn all(width: u32, height: u32) -> impl Iterator<Item = Self> {
        let across = width.div_ceil(TILE);
        (0..across * height.div_ceil(TILE)).map(move |i| {
            let (column, row) = (i % across, i / across);
            let side = |place: u32, size: u32| TILE.min(size - place * TILE);
            let (w, h) = (side(column, width), side(row, height));
            Self {
                column,
                row,
                width: w,
                height: h,
                rgba: Vec::new(),
                aovs: Vec::new(),
            }
        })
    }
}

/// What a thread keeps between blocks.
pub(crate) struct Scratch {
    buffers: TileBuffers,
    setups: SetupCache,
    stages: Stages,
    hits: Vec<(u32, Hit)>,
    run: Vec<Hit>,
    shaded: Vec<[f32; 4]>,
    /// Samples of the tile.
    tile: Vec<[f32; 4]>,
    /// Sums over the samples of each pixel.
    sums: Vec<[f32; 4]>,
    covered: Vec<bool>,
}

impl Scratch {
    pub(crate) fn new() -> Self {
        Self {
            buffers: TileBuffers::new(),
            setups: SetupCache::new(),
            stages: Stages::default(),
            hits: Vec::new(),
            run: Vec::with_capacity(RUN),
            shaded: Vec::with_capacity(RUN),
            tile: vec![[0.0; 4]; PIXELS],
            sums: vec![[0.0; 4]; PIXELS],
            covered: vec![false; PIXELS],
        }
    }
}

impl<'a> Job<'a> {
    pub(crate) fn new(
        scene: &Scene,
        settings: &Settings,
        plan: &'a Plan<'a>,
        prepared: &'a Prepared<'a>,
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
            plan,
            prepared,
            background: [light(r) * a, light(g) * a, light(b) * a, a],
            color: scene.color,
            samples: prepared.size().width() / settings.width,
            tiles_across: prepared.size().width().div_ceil(TILE),
        }
    }

    /// Draws a block and returns how many of its pixels are covered.
    pub(crate) fn draw(&self, mut block: Block<'_>, scratch: &mut Scratch) -> u64 {
        scratch.sums.fill([0.0; 4]);
        scratch.covered.fill(false);
        let n = self.samples;
        for y in block.row * n..(block.row + 1) * n {
            for x in block.column * n..(block.column + 1) * n {
                let index = (y * self.tiles_across + x) as usize;
                let inside = x < self.tiles_across && index < self.prepared.tiles();
                if inside {
                    self.draw_tile(index, &mut block, scratch);
                }
            }
        }
        let samples = (n * n) as f32;
        for (y, row) in block.rgba.into_iter().enumerate() {
            for (x, pixel) in row.chunks_exact_mut(4).enumerate() {
                let mean = scratch.sums[y * TILE as usize + x].map(|sum| sum / samples);
                pixel.copy_from_slice(&self.encode(mean));
            }
        }
        let (width, height) = (block.width as usize, block.height as usize);
        let rows = scratch.covered.chunks_exact(TILE as usize).take(height);
        rows.map(|row| row[..width].iter().filter(|c| **c).count() as u64)
            .sum()
    }

    fn draw_tile(&self, index: usize, block: &mut Block<'_>, scratch: &mut Scratch) {
        self.prepared
            .visible(index, self.plan, &mut scratch.buffers);
        scratch.setups.clear();
        self.write_aovs(index, block, scratch);
        if block.rgba.is_empty() {
            return;
        }
        scratch.tile.fill(self.background);
        self.gather_visible(index, scratch);
        self.shade_hits(index, block, scratch);
        self.gather_blended(index, scratch);
        self.shade_hits(index, block, scratch);
        let tile = self.prepared.tile(index);
        for y in 0..tile.height {
            for x in 0..tile.width {
                let pixel = self.pixel(block, tile.x0 + x, tile.y0 + y);
                let sample = scratch.tile[(y * TILE + x) as usize];
                for (sum, value) in scratch.sums[pixel].iter_mut().zip(sample) {
                    *sum += value;
                }
            }
        }
    }

    /// The pixel of a block that holds a sample.
    fn pixel(&self, block: &Block<'_>, x: u32, y: u32) -> usize {
        let (x, y) = (
            x / self.samples - block.column * TILE,
            y / self.samples - block.row * TILE,
        );
        (y * TILE + x) as usize
    }

    /// Lists the visible samples, those of one surface together.
    fn gather_visible(&self, index: usize, scratch: &mut Scratch) {
        let tile = self.prepared.tile(index);
        scratch.hits.clear();
        let (mut last, mut draw, mut mixed) = (NONE, NONE, false);
        for y in 0..tile.height {
            for x in 0..tile.width {
                let id = scratch.buffers.id[(y * TILE + x) as usize];
                if id == NONE {
                    continue;
                }
                if id != last {
                    last = id;
                    let before = draw;
                    draw = self.prepared.source(id).0;
                    mixed |= before != NONE && before != draw;
                }
                scratch.hits.push((
                    draw,
                    Hit {
                        id,
                        x: tile.x0 + x,
                        y: tile.y0 + y,
                    },
                ));
            }
        }
        if mixed {
            scratch.hits.sort_by_key(|(draw, _)| *draw);
        }
    }

    /// Lists the blended samples in submission order.
    fn gather_blended(&self, index: usize, scratch: &mut Scratch) {
        scratch.hits.clear();
        let (hits, buffers) = (&mut scratch.hits, &scratch.buffers);
        self.prepared.blended(index, buffers, &mut |id, x, y| {
            hits.push((self.prepared.source(id).0, Hit { id, x, y }));
        });
    }

    /// Shades the listed samples in runs of one surface and composes each over what stands in the tile.
    fn shade_hits(&self, index: usize, block: &Block<'_>, scratch: &mut Scratch) {
        let tile = self.prepared.tile(index);
        let Scratch {
            setups,
            stages,
            hits,
            run,
            shaded,
            tile: samples,
            covered,
            ..
        } = scratch;
        for same in hits.chunk_by(|a, b| a.0 == b.0) {
            let surface = &self.plan.surfaces[same[0].0 as usize];
            for part in same.chunks(RUN) {
                run.clear();
                run.extend(part.iter().map(|(_, hit)| *hit));
                stages.shade(self.plan, surface, self.prepared, setups, run, shaded);
                for (hit, color) in run.iter().zip(&*shaded) {
                    let slot = ((hit.y - tile.y0) * TILE + hit.x - tile.x0) as usize;
                    samples[slot] = over(*color, samples[slot]);
                    covered[self.pixel(block, hit.x, hit.y)] |= color[3] > 0.0;
                }
            }
        }
    }

    fn write_aovs(&self, index: usize, block: &mut Block<'_>, scratch: &mut Scratch) {
        if block.aovs.is_empty() {
            return;
        }
        let tile = self.prepared.tile(index);
        let mut fragment = Fragment::default();
        for y in 0..tile.height {
            for x in 0..tile.width {
                let id = scratch.buffers.id[(y * TILE + x) as usize];
                if id == NONE {
                    continue;
                }
                let hit = Hit {
                    id,
                    x: tile.x0 + x,
                    y: tile.y0 + y,
                };
                scratch.setups.evaluate(self.prepared, hit, &mut fragment);
                let (draw, triangle) = self.prepared.source(id);
                let surface = &self.plan.surfaces[draw as usize];
                let (x, y) = (x as usize, y as usize);
                for (aov, rows) in &mut block.aovs {
                    match rows {
                        AovRows::U32(rows) => rows[y][x] = surface.mesh.face(triangle),
                        AovRows::F32(rows) => {
                            let channels = aov.channels();
                            let values = aov_values(*aov, surface, &fragment);
                            rows[y][x * channels..][..channels]
                                .copy_from_slice(&values[..channels]);
                        }
                    }
                }
            }
        }
    }

    fn encode(&self, premultiplied: [f32; 4]) -> [u8; 4] {
        let alpha = premultiplied[3];
        let encode = |c: f32| match self.color {
            ColorMode::Srgb => color::linear_to_srgb8(c),
            ColorMode::Raw => color::unit_to_u8(c),
        };
        let [r, g, b] = straight(premultiplied).map(encode);
        [r, g, b, color::unit_to_u8(alpha)]
    }
}

/// `front` over `back`, both premultiplied.
fn over(front: [f32; 4], back: [f32; 4]) -> [f32; 4] {
    if front[3] >= 1.0 {
        return front;
    }
    let k = 1.0 - front[3];
    [
        front[0] + k * back[0],
        front[1] + k * back[1],
        front[2] + k * back[2],
        front[3] + k * back[3],
    ]
}

/// Values of an f32 AOV, holes where the surface has none (or none that is finite).
fn aov_values(aov: Aov, surface: &Surface<'_>, fragment: &Fragment) -> [f32; 3] {
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

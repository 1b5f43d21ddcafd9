//! One pass over the frame, and its blocks of 64 x 64 pixels: each is a tile of samples, or several.

use std::ops::Range;

use texmap_math::color;
use texmap_math::simd::Scalar;
use texmap_raster::{BinnedDraws, TILE, block_index};

use super::supersample::Sums;
use super::{Context, Painter, is_whole};
use crate::plan::{BoundAlphaTests, Plan, Shader};
use crate::resolve::copy::fill_rows;
use crate::resolve::encode::encode;
use crate::resolve::rows::AovRows;
use crate::{Aov, RenderSettings};
use texmap_scene::{ColorMode, Scene};

/// One pass over the frame.
pub(crate) struct Job<'a> {
    pub(super) context: Context<'a>,
    /// Samples per pixel and axis of this pass, each in a tile of its own.
    pub(super) samples: u32,
    /// Tiles across the grid of samples.
    pub(super) tiles_across: u32,
}

/// A block and the parts of the frame that it owns.
pub(crate) struct Block<'r, 'a> {
    /// Position in blocks, from the left and from the top.
    pub(super) column: u32,
    pub(super) row: u32,
    /// Empty if this pass has no color.
    pub(crate) rgba: &'r mut [&'a mut [u8]],
    pub(crate) aovs: Vec<(Aov, AovRows<'r, 'a>)>,
}

impl<'r, 'a> Block<'r, 'a> {
    /// Takes the rows of [`Aov::Color`] out of the arrays.
    fn take_color(&mut self) -> ColorRows<'r, 'a> {
        let color = self.aovs.iter().position(|(aov, _)| *aov == Aov::Color)?;
        Some(self.aovs.swap_remove(color).1)
    }
}

impl Block<'_, '_> {
    /// All blocks of these rows of tiles, row by row from the top left, without buffers.
    pub(crate) fn all(width: u32, rows: Range<u32>) -> impl Iterator<Item = Self> {
        let across = width.div_ceil(TILE);
        rows.flat_map(move |row| (0..across).map(move |column| (column, row)))
            .map(|(column, row)| Self {
                column,
                row,
                rgba: &mut [],
                aovs: Vec::new(),
            })
    }
}

/// The buffers that a thread keeps between blocks.
pub(crate) struct Scratch {
    pub(super) painter: Painter,
    pub(super) sums: Sums,
}

impl Scratch {
    /// Out of line: it passes over the stack, and who calls may be called by itself, a thread that waits and takes another block.
    #[inline(never)]
    pub(crate) fn boxed() -> Box<Self> {
        Box::new(Self {
            painter: Painter::new(),
            sums: Sums::default(),
        })
    }
}

impl<'a> Job<'a> {
    pub(crate) fn new(
        scene: &Scene,
        settings: &RenderSettings,
        plan: &'a Plan<'a>,
        prepared: &'a BinnedDraws<'a>,
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
        let shaders = plan.surfaces.iter().map(|surface| {
            let shader = Shader::new(plan, surface);
            let color = surface.unlit.map(|color| color.tint(Scalar, [1.0; 4]));
            (shader, encode(scene.color, color.unwrap_or_default()))
        });
        Self {
            context: Context {
                plan,
                shaders: shaders.collect(),
                prepared,
                alpha: BoundAlphaTests::new(plan),
                mode: scene.color,
                background: [light(r) * a, light(g) * a, light(b) * a, a],
                samples,
            },
            samples: prepared.size().width() / settings.width,
            tiles_across: prepared.size().width().div_ceil(TILE),
        }
    }

    /// Draws a block and returns the number of its covered pixels. Out of line, as [`Scratch::boxed`].
    #[inline(never)]
    pub(crate) fn draw(&self, mut block: Block<'_, '_>, scratch: &mut Scratch) -> u64 {
        let color = block.take_color();
        if self.samples > 1 {
            return self.draw_supersampled(block, color, scratch);
        }
        let (context, painter) = (&self.context, &mut scratch.painter);
        let index = (block.row * self.tiles_across + block.column) as usize;
        if context.prepared.is_empty(index) {
            let word = encode(context.mode, context.background);
            fill_rows(context.plan.level, block.rgba, word);
            put_colors(color, |_| context.background);
            return 0;
        }
        if let Some(samples) = context.samples {
            painter.paint_multisampled(context, samples, index, color.is_some());
            painter.resolved().copy_to(context.plan.level, block.rgba);
            put_colors(color, |at| painter.mean_of_samples(at));
        } else if color.is_some() {
            painter.see(context, index, block.aovs.is_empty());
            painter.write_aovs(context, index, &mut block.aovs);
            painter.paint_light(context, index, block.rgba);
            put_colors(color, |at| painter.light_at(at));
        } else {
            painter.see(context, index, block.aovs.is_empty());
            if !block.aovs.is_empty() {
                painter.write_aovs(context, index, &mut block.aovs);
            }
            if block.rgba.is_empty() {
                return 0;
            }
            painter.paint_rows(context, index, block.rgba);
        }
        count_ones(painter.covered())
    }
}

/// The rows of [`Aov::Color`] in a block, if it is asked for.
pub(super) type ColorRows<'r, 'a> = Option<AovRows<'r, 'a>>;

/// Writes the light of each pixel, which is told by its index in the blocks of a tile.
fn put_colors(rows: ColorRows<'_, '_>, light: impl Fn(usize) -> [f32; 4]) {
    let Some(AovRows::F32(rows)) = rows else {
        return;
    };
    for (row, y) in rows.iter_mut().zip(0..) {
        for (pixel, x) in row.as_chunks_mut().0.iter_mut().zip(0..) {
            *pixel = light(block_index(x, y));
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

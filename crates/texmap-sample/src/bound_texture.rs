//! A texture and a sampler prepared for the kernels.

use crate::{
    address::{
        lod::{LodRange, TexelFootprint, is_magnified},
        wrap::{Axis, REACH, Wrap},
    },
    blocks::BlockView,
    encoded::Encoded,
    fetch::Apart,
    filter::{Kernel, ewa, gl_of},
    rgba8,
    sampler::{Filter, Mip, Precision, Sampler, TexelFilter},
    texel_data::{Chain, Format, Level},
    texture::Texture2d,
};
use texmap_math::{
    lanes::GatherTable,
    simd::{Isa, Scalar},
};

/// One word a texel, for the kernels that read it whole.
pub const RGBA8: u8 = 0;
/// One word a texel, for the f32 kernels.
pub const RGBA8_EXACT: u8 = 1;
/// Two words a texel.
pub const RGBA16: u8 = 2;
/// Floats, and bytes that are decoded at each look-up. Texels are fetched one by one, and filtered in lanes.
pub const SCALAR_FETCH: u8 = 3;
/// Compressed blocks, decoded in lanes; texels are addressed in block order.
pub const BLOCKS: u8 = 5;
/// No format of a view but of kernels: any of those with f32 weights, asked for at each texel. Rare filters have one compiled form.
pub const ANY: u8 = 4;
/// No format of a view but of kernels: [`RGBA8_EXACT`] or [`RGBA16`].
pub(crate) const EXACT_WORDS: u8 = 6;

/// The format by which kernels with f32 weights read a chain.
#[inline(always)]
pub(crate) fn exact_format(chain: &Chain<'_>) -> u8 {
    match chain.format {
        Format::Rgba8 => RGBA8_EXACT,
        Format::Rgba16 if chain.encoded.is_none() => RGBA16,
        _ if matches!(chain.encoded, Some(Encoded::Blocks(_))) => BLOCKS,
        _ => SCALAR_FETCH,
    }
}

/// Most levels of a chain: 32768 down to 1.
const LEVELS: usize = 16;

/// A texture and a sampler prepared for the kernels; made once per batch, without allocating.
#[derive(Clone, Debug)]
pub struct BoundTexture<'a> {
    pub(crate) chain: &'a Chain<'a>,
    pub(crate) words: GatherTable<'a>,
    pub(crate) apart: Apart<'a>,
    pub(crate) blocks: Option<BlockView<'a>>,
    /// [`RGBA8`] and so on.
    pub format: u8,
    /// Every alpha is exactly one, and no texel is the border.
    pub(crate) opaque: bool,
    pub(crate) flip: bool,
    /// Both axes repeat over powers of two: their wraps are masks.
    pub(crate) masked: bool,
    pub(crate) axes: [Axis; 2],
    /// Some axis ends at the border colour.
    pub(crate) bordered: bool,
    /// In units of the format, and packed.
    pub(crate) border: [f32; 4],
    pub(crate) border_word: u32,
    pub(crate) offsets: [u32; LEVELS],
    levels: [LevelView; LEVELS],
    size: (i32, i32),
    /// Steps of a scaled coordinate a texel: 256 where weights are bytes.
    pub(crate) unit: f32,
    /// Scaled coordinates below this are used as they are.
    pub(crate) reach: f32,
    pub(crate) last: i32,
    pub(crate) scale: f32,
    /// The kernel that the filter takes.
    pub kind: Kernel,
    /// Choices of OpenGL that the filter comes down to.
    pub(crate) gl: (TexelFilter, TexelFilter, Mip),
    /// Largest ratio of a footprint's axes.
    pub(crate) most: u8,
    /// Width of an elliptical filter.
    pub(crate) width: f32,
    pub(crate) precision: Precision,
    pub(crate) lod_range: LodRange,
    /// Bias and limits change nothing that the levels of a chain do not.
    pub(crate) plain_lod: bool,
}

/// One level of a [`BoundTexture`], ready to be spread over lanes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LevelView {
    pub(crate) offset: i32,
    pub(crate) width: i32,
    pub(crate) height: i32,
    /// Last row of a flipped texture, else 0: what a wrapped row is turned round with.
    pub(crate) turn: i32,
    /// Units that the sides have: texels, or their 256ths under weights of a byte.
    pub(crate) units_x: f32,
    pub(crate) units_y: f32,
    /// log2 of the width, where it is a power of two.
    pub(crate) shift: u32,
}

impl<'a> BoundTexture<'a> {
    /// `None` only of a texture without a texel.
    pub fn new(sampler: &Sampler, t: &'a Texture2d<'_>) -> Option<Self> {
        let chain = &t.chain;
        let format = if rgba8::applies(sampler, chain) {
            RGBA8
        } else {
            exact_format(chain)
        };
        Self::of_chain(sampler, chain, Kernel::of(sampler.filter), format)
    }

    /// The view of any chain.
    pub(crate) fn of_chain(
        sampler: &Sampler,
        chain: &'a Chain<'_>,
        kind: Kernel,
        format: u8,
    ) -> Option<Self> {
        let mut view = Self::single(sampler, chain, kind, format)?;
        for (i, level) in chain.levels.iter().enumerate().take(LEVELS) {
            view.levels[i] = view.level_of(level);
            view.offsets[i] = view.levels[i].offset as u32;
        }
        Some(view)
    }

    /// [`of_chain`](Self::of_chain) for one lane, which finds the one level that it reads by itself.
    #[inline(always)]
    pub(crate) fn single(
        sampler: &Sampler,
        chain: &'a Chain<'_>,
        kind: Kernel,
        format: u8,
    ) -> Option<Self> {
        let base = chain.levels.first()?;
        let axes = sampler.axes(chain);
        let bordered =
            sampler.wrap_u == Wrap::ClampToBorder || sampler.wrap_v == Wrap::ClampToBorder;
        let most = match sampler.filter {
            Filter::Anisotropic(most) | Filter::Ewa { ratio: most, .. } => most.clamp(1, 16),
            _ => 1,
        };
        let width = match sampler.filter {
            Filter::Ewa { percent, .. } => ewa::width(percent),
            _ => 1.0,
        };
        let unit = if format == RGBA8 { 256.0 } else { 1.0 };
        let lod_range = sampler.lod_range();
        let LodRange { bias, min, max } = lod_range;
        let mut view = Self {
            chain,
            // An encoded texture without levels has no words.
            words: GatherTable::new(chain.words()).or_else(|| GatherTable::new(&[0]))?,
            apart: Apart::new(chain),
            blocks: match &chain.encoded {
                Some(Encoded::Blocks(blocks)) => blocks.view(),
                _ => None,
            },
            format,
            // Floats may be above one, which is opaque and yet no constant.
            opaque: chain.opaque && !bordered && chain.format != Format::Rgba32,
            flip: chain.flip,
            masked: axes[0].scaled_first && axes[1].scaled_first,
            axes,
            bordered,
            border: [0.0; 4],
            border_word: 0,
            offsets: [0; LEVELS],
            levels: [LevelView::NONE; LEVELS],
            size: (base.width, base.height),
            unit,
            reach: REACH * unit,
            last: chain.levels.len() as i32 - 1,
            scale: chain.format.scale(),
            kind,
            gl: gl_of(sampler.filter),
            most,
            width,
            precision: sampler.precision,
            lod_range,
            plain_lod: bias == 0.0 && min <= 0.0 && max >= LEVELS as f32,
        };
        if bordered {
            view = view.with_border(sampler);
        }
        Some(view)
    }

    /// As it is where an axis ends at the border.
    #[inline(always)]
    pub(crate) fn with_border(mut self, sampler: &Sampler) -> Self {
        (self.bordered, self.opaque) = (true, false);
        self.border = sampler.border_in(self.chain.format.units());
        self.border_word = rgba8::border(sampler.border);
        self
    }

    /// True if a look-up whose u and v change by no more than this to the right and down reads level 0 alone, whatever filter
    /// without probes has chosen a level for it.
    pub fn is_magnified_by(&self, [ux, uy]: [f32; 2], [vx, vy]: [f32; 2]) -> bool {
        is_magnified(self, &TexelFootprint::new(Scalar, self, ux, vx, uy, vy))
    }

    /// True if cells (addresses and weights of texels) that a batch of look-ups finds in one of both serve the other, too: filter, wraps,
    /// limits and the sides of all levels are the same, and texels lie in the same order in words.
    pub fn shares_cells(&self, other: &Self) -> bool {
        let [texels, others] = [self, other].map(|view| match view.format {
            RGBA8_EXACT => Some(1),
            RGBA16 => Some(2),
            _ => None,
        });
        let (Some(texels), Some(others)) = (texels, others) else {
            return false;
        };
        let same_level = |(a, b): (&LevelView, &LevelView)| {
            (a.width, a.height, a.turn) == (b.width, b.height, b.turn)
                && i64::from(a.offset) * others == i64::from(b.offset) * texels
        };
        matches!(self.kind, Kernel::Bilinear | Kernel::Trilinear)
            && self.kind == other.kind
            && self.axes == other.axes
            && !self.bordered
            && self.precision == other.precision
            && self.lod_range == other.lod_range
            && self.last == other.last
            && self.levels.iter().zip(&other.levels).all(same_level)
    }

    /// Columns and rows of level 0.
    #[inline(always)]
    pub fn size(&self) -> (i32, i32) {
        self.size
    }

    /// A level that the chain has.
    #[inline(always)]
    pub(crate) fn level<I: Isa>(&self, level: i32) -> LevelView {
        if I::LANES == 1 {
            self.level_of(&self.chain.levels[level as usize])
        } else {
            self.levels[(level & 15) as usize]
        }
    }

    #[inline(always)]
    fn level_of(&self, level: &Level) -> LevelView {
        let Level { width, height, .. } = *level;
        let offset = match self.format {
            SCALAR_FETCH => self.apart.first_of(level),
            _ => level.offset,
        };
        LevelView {
            offset: offset as i32,
            width,
            height,
            turn: if self.flip { height - 1 } else { 0 },
            units_x: width as f32 * self.unit,
            units_y: height as f32 * self.unit,
            shift: width.trailing_zeros(),
        }
    }
}

impl LevelView {
    const NONE: Self = Self {
        offset: 0,
        width: 1,
        height: 1,
        turn: 0,
        units_x: 1.0,
        units_y: 1.0,
        shift: 0,
    };
}

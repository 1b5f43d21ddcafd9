//! Sixteen look-ups at once; outside semantic versioning.
//!
//! Every function gives, lane by lane, the bits of its scalar twin on every SIMD level. What can
//! change a bit (level, probes, wrap) is decided per lane; the tests on whole vectors below only
//! choose between paths that give the same bits.
//!
//! A stage of one's own, generic over the SIMD level, with the dispatch around it:
//! ```
//! use texmap_math::{Level, fearless_simd::{Simd, dispatch, f32x16, prelude::*}};
//! use texmap_sample::lanes::{View, packed};
//! use texmap_sample::{ColorSpace, Filter, Origin, Precision, Sampler, Texture2d};
//!
//! fn stage<S: Simd>(s: S, view: &View<'_>, u: &[f32; 16], out: &mut [u32; 16]) {
//!     s.vectorize(
//!         #[inline(always)]
//!         || {
//!             let (u, v) = (f32x16::from_slice(s, u), f32x16::splat(s, 0.5));
//!             packed::bilinear_lanes(s, view, u, v).store_slice(out);
//!         },
//!     );
//! }
//!
//! let texels = vec![0, 0, 0, 255, 200, 100, 50, 255];
//! let t = Texture2d::from_rgba8(2, 1, texels, ColorSpace::Linear, Origin::TopLeft)?;
//! let s = Sampler { filter: Filter::Bilinear, precision: Precision::Fast, ..Sampler::default() };
//! let view = View::new(&s, &t).expect("bytes have lanes under any wrap");
//! let u: [f32; 16] = core::array::from_fn(|i| i as f32 / 16.0);
//! let mut out = [0; 16];
//! dispatch!(Level::new(), simd => stage(simd, &view, &u, &mut out));
//! // u = 1/4 and 3/4 are the centres, 1/2 lies halfway.
//! assert_eq!(out[4].to_le_bytes(), [0, 0, 0, 255]);
//! assert_eq!(out[8].to_le_bytes(), [100, 50, 25, 255]);
//! assert_eq!(out[12].to_le_bytes(), [200, 100, 50, 255]);
//! # Ok::<(), texmap_sample::SampleError>(())
//! ```

#[path = "lanes/apart.rs"]
mod apart;
#[path = "address/texel.rs"]
mod at;
#[path = "lanes/axis.rs"]
mod axis;
#[path = "fetch.rs"]
pub mod float;
#[path = "filter/gl.rs"]
pub mod gl;
#[path = "rgba8.rs"]
pub mod packed;

pub use crate::pattern::gradient_noise_lanes;
pub(crate) use at::{At, Corners, Place};
pub(crate) use axis::{index, place};

use apart::Apart;

use crate::{
    filter::{axes, ewa, gl_of},
    sampler::{Cubic, Filter, Mip, Precision, Sampler, Texel},
    texels::{Chain, Format},
    texture::Texture2d,
    wrap::{Axis, REACH, Wrap},
};
use texmap_math::lanes::Words;

/// One word a texel, for the kernels that read it whole.
pub const RGBA8: u8 = 0;
/// One word a texel, for the f32 kernels.
pub const RGBA8_EXACT: u8 = 1;
/// Two words a texel.
pub const RGBA16: u8 = 2;
/// Floats, and bytes that are decoded at each look-up: texels are fetched one by one, and filtered in lanes.
pub const APART: u8 = 3;
/// No format of a view but of kernels: any of those with f32 weights, asked for at each texel. Rare filters have one compiled form.
pub const ANY: u8 = 4;

/// How kernels with f32 weights read a chain.
pub(crate) fn exact_format(chain: &Chain<'_>) -> u8 {
    match chain.format {
        Format::Rgba8 => RGBA8_EXACT,
        Format::Rgba16 if chain.encoded.is_none() => RGBA16,
        _ => APART,
    }
}

/// Most levels of a chain: 32768 down to 1.
const LEVELS: usize = 16;

/// The kernel that a filter takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Kind {
    /// The nearest texel of level 0.
    Nearest,
    /// Bilinear on level 0.
    Bilinear,
    /// Bilinear on the two levels around.
    Trilinear,
    /// Probes along the long axis.
    Anisotropic,
    /// Another combination of OpenGL's.
    Gl,
    /// Sixteen texels of level 0.
    Bicubic(Cubic),
    /// All texels of an ellipse.
    Ewa,
}

impl Kind {
    fn of(filter: Filter) -> Self {
        match filter {
            Filter::Ewa { .. } => return Self::Ewa,
            Filter::Bicubic(kernel) => return Self::Bicubic(kernel),
            Filter::Anisotropic(_) => return Self::Anisotropic,
            _ => {}
        }
        match gl_of(filter) {
            (Texel::Nearest, Texel::Nearest, Mip::None) => Self::Nearest,
            (Texel::Linear, Texel::Linear, Mip::None) => Self::Bilinear,
            (Texel::Linear, Texel::Linear, Mip::Linear) => Self::Trilinear,
            _ => Self::Gl,
        }
    }

    /// Whether it is one of the three that need no more than a place and a level.
    #[must_use]
    pub fn is_plain(self) -> bool {
        matches!(self, Self::Nearest | Self::Bilinear | Self::Trilinear)
    }
}

/// A texture and a sampler prepared for the kernels; made once per batch, without allocating.
#[derive(Clone, Debug)]
pub struct View<'a> {
    pub(crate) words: Words<'a>,
    apart: Apart<'a>,
    /// [`RGBA8`] and so on.
    pub format: u8,
    /// Every alpha is exactly one, and no tap reads a border.
    pub(crate) opaque: bool,
    flip: bool,
    /// Both axes repeat over powers of two: their wraps are masks.
    pub(crate) masked: bool,
    axes: [Axis; 2],
    /// Some axis ends at the border colour.
    bordered: bool,
    /// In units of the format, and packed.
    border: [f32; 4],
    border_word: u32,
    offsets: [u32; LEVELS],
    levels: [LevelView; LEVELS],
    /// Steps of a scaled coordinate a texel: 256 where weights are bytes.
    unit: f32,
    /// Scaled coordinates below this are used as they are.
    reach: f32,
    pub(crate) last: i32,
    pub(crate) scale: f32,
    /// Which kernel the filter takes.
    pub kind: Kind,
    pub(crate) most: u8,
    /// Width of an elliptical filter.
    pub(crate) width: f32,
    pub(crate) precision: Precision,
    pub(crate) bias: f32,
    pub(crate) lod_min: f32,
    pub(crate) lod_max: f32,
    /// Bias and limits change nothing that the levels of a chain do not.
    pub(crate) plain_lod: bool,
}

/// One level of a [`View`], ready to be spread over lanes.
#[derive(Clone, Copy, Debug)]
struct LevelView {
    offset: i32,
    width: i32,
    height: i32,
    /// Last row of a flipped texture, else 0: what a wrapped row is turned round with.
    turn: i32,
    /// Units that the sides have: texels, or their 256ths under weights of a byte.
    units_x: f32,
    units_y: f32,
    /// log2 of the width, where it is a power of two.
    shift: u32,
}

impl LevelView {
    fn new(offset: usize, width: i32, height: i32, flip: bool, unit: f32) -> Self {
        Self {
            offset: offset as i32,
            width,
            height,
            turn: if flip { height - 1 } else { 0 },
            units_x: width as f32 * unit,
            units_y: height as f32 * unit,
            shift: width.trailing_zeros(),
        }
    }
}

impl<'a> View<'a> {
    /// `None` only of a texture without a texel.
    pub fn new(sampler: &Sampler, t: &'a Texture2d<'_>) -> Option<Self> {
        let kind = Kind::of(sampler.filter);
        let chain = &t.chain;
        let format = if packed::applies(sampler, chain) {
            RGBA8
        } else {
            exact_format(chain)
        };
        Self::prepared(sampler, chain, kind, format)
    }

    /// The view of any chain whose texels and filter have lanes.
    pub(crate) fn prepared(
        sampler: &Sampler,
        chain: &'a Chain<'_>,
        kind: Kind,
        format: u8,
    ) -> Option<Self> {
        let axes = axes(sampler, chain);
        let bordered = [sampler.wrap_u, sampler.wrap_v].contains(&Wrap::ClampToBorder);
        let most = match sampler.filter {
            Filter::Anisotropic(most) | Filter::Ewa { ratio: most, .. } => most.clamp(1, 16),
            _ => 1,
        };
        let width = match sampler.filter {
            Filter::Ewa { percent, .. } => ewa::width(percent),
            _ => 1.0,
        };
        let unit = if format == RGBA8 { 256.0 } else { 1.0 };
        let mut offsets = [0; LEVELS];
        let mut levels = [LevelView::new(0, 1, 1, false, unit); LEVELS];
        let apart = Apart::new(chain);
        for (i, level) in chain.levels.iter().enumerate().take(LEVELS) {
            let offset = match format {
                APART => apart.first_of(level),
                _ => level.offset,
            };
            offsets[i] = offset as u32;
            levels[i] = LevelView::new(offset, level.width, level.height, chain.flip, unit);
        }
        let bias = sampler.lod_bias();
        Some(Self {
            // An encoded texture without levels has no words.
            words: Words::new(chain.words()).or_else(|| Words::new(&[0]))?,
            apart,
            format,
            // Floats may be above one, which is opaque and yet no constant.
            opaque: chain.opaque && !bordered && chain.format != Format::Rgba32,
            flip: chain.flip,
            masked: axes.iter().all(|axis| axis.scaled_first),
            axes,
            bordered,
            border: sampler.border_in(chain.format.units()),
            border_word: packed::border(sampler.border),
            offsets,
            levels,
            unit,
            reach: REACH * unit,
            last: chain.levels.len() as i32 - 1,
            scale: chain.format.scale(),
            kind,
            most,
            width,
            precision: sampler.precision,
            bias,
            lod_min: sampler.lod.min,
            lod_max: sampler.lod.max,
            plain_lod: bias == 0.0 && sampler.lod.min <= 0.0 && sampler.lod.max >= LEVELS as f32,
        })
    }

    /// As it is where a third axis may end at the border.
    pub(crate) fn with_border(mut self) -> Self {
        (self.bordered, self.opaque) = (true, false);
        self
    }

    /// Whether a tap may read the border.
    pub(crate) fn is_bordered(&self) -> bool {
        self.bordered
    }

    /// Columns and rows of level 0.
    pub fn size(&self) -> (i32, i32) {
        (self.levels[0].width, self.levels[0].height)
    }
}

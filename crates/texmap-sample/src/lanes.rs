//! Sixteen look-ups at once; outside semantic versioning.
//!
//! Every function gives, lane by lane, the bits of its scalar twin on every SIMD level. What can
//! change a bit (level, probes, wrap) is decided per lane; the tests on whole vectors below only
//! choose between paths that give the same bits.

pub mod float;
pub mod packed;

use crate::{
    filter::{axes, gl_of},
    sampler::{Filter, Mip, Precision, Sampler, Texel},
    texels::Format,
    texture::Texture2d,
    wrap::{BELOW_ONE, REACH},
};
use texmap_math::{
    fearless_simd::{f32x16, i32x16, prelude::*, u32x16},
    lanes::{Words, floor_to_i32, gather},
};

/// One word a texel; the bytes kernels read it whole.
pub const RGBA8: u8 = 0;
/// RGBA8 whose alpha is 255 throughout: the f32 kernels need not look.
pub const RGBX8: u8 = 1;
/// Two words a texel.
pub const RGBA16: u8 = 2;

/// Most levels of a chain: 32768 down to 1.
const LEVELS: usize = 16;

/// The filters that have lanes. The other combinations of OpenGL, the cubics and EWA do not.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// The nearest texel of level 0.
    Nearest,
    /// Bilinear on level 0.
    Bilinear,
    /// Bilinear on the two levels around.
    Trilinear,
    /// Probes along the long axis.
    Anisotropic,
}

impl Kind {
    fn of(filter: Filter) -> Option<Self> {
        match filter {
            Filter::Bicubic(_) | Filter::Ewa(_) => return None,
            Filter::Anisotropic(_) => return Some(Self::Anisotropic),
            _ => {}
        }
        match gl_of(filter) {
            (Texel::Nearest, Texel::Nearest, Mip::None) => Some(Self::Nearest),
            (Texel::Linear, Texel::Linear, Mip::None) => Some(Self::Bilinear),
            (Texel::Linear, Texel::Linear, Mip::Linear) => Some(Self::Trilinear),
            _ => None,
        }
    }
}

/// A texture and a sampler prepared for the kernels; made once per batch, without allocating.
#[derive(Clone, Debug)]
pub struct View<'a> {
    pub(crate) words: Words<'a>,
    /// [`RGBA8`] and so on.
    pub format: u8,
    pub(crate) opaque: bool,
    flip: bool,
    offsets: [u32; LEVELS],
    sizes: [(i32, i32); LEVELS],
    pub(crate) last: i32,
    pub(crate) scale: f32,
    /// Which kernel the filter takes.
    pub kind: Kind,
    pub(crate) most: u8,
    pub(crate) precision: Precision,
    pub(crate) bias: f32,
    pub(crate) lod_min: f32,
    pub(crate) lod_max: f32,
}

impl<'a> View<'a> {
    /// `None` where there are no lanes and look-ups run one at a time: filters that are not a
    /// [`Kind`], wraps other than repeat, sides that are not powers of two, float texels, and cut-out
    /// bytes under exact weights.
    pub fn new(sampler: &Sampler, t: &'a Texture2d<'_>) -> Option<Self> {
        let kind = Kind::of(sampler.filter)?;
        let chain = &t.chain;
        let format = match chain.format {
            Format::Rgba8 if packed::applies(sampler, chain) => RGBA8,
            Format::Rgba8 if chain.opaque => RGBX8,
            Format::Rgba16 => RGBA16,
            _ => return None,
        };
        if !axes(sampler, chain).iter().all(|axis| axis.scaled_first) {
            return None;
        }
        let most = match sampler.filter {
            Filter::Anisotropic(most) => most.clamp(1, 16),
            _ => 1,
        };
        let (mut offsets, mut sizes) = ([0; LEVELS], [(1, 1); LEVELS]);
        for (i, level) in chain.levels.iter().enumerate().take(LEVELS) {
            offsets[i] = level.offset as u32;
            sizes[i] = (level.width, level.height);
        }
        let bias = if sampler.lod.bias.is_nan() {
            0.0
        } else {
            sampler.lod.bias.clamp(-32.0, 32.0)
        };
        Some(Self {
            words: Words::new(chain.words())?,
            format,
            opaque: chain.opaque,
            flip: chain.flip,
            offsets,
            sizes,
            last: chain.levels.len() as i32 - 1,
            scale: chain.format.scale(),
            kind,
            most,
            precision: sampler.precision,
            bias,
            lod_min: sampler.lod.min,
            lod_max: sampler.lod.max,
        })
    }

    /// Columns and rows of level 0.
    pub fn size(&self) -> (i32, i32) {
        self.sizes[0]
    }
}

/// The level of each lane.
#[derive(Clone, Copy)]
pub(crate) struct At<S: Simd> {
    offset: i32x16<S>,
    width: i32x16<S>,
    height: i32x16<S>,
    pub(crate) wf: f32x16<S>,
    pub(crate) hf: f32x16<S>,
    /// log2 of the width of a power of two where all lanes share the level.
    shift: Option<u32>,
}

impl<S: Simd> At<S> {
    #[inline(always)]
    pub(crate) fn uniform(s: S, view: &View<'_>, level: i32) -> Self {
        let level = (level & 15) as usize;
        let (w, h) = view.sizes[level];
        Self {
            offset: i32x16::splat(s, view.offsets[level] as i32),
            width: i32x16::splat(s, w),
            height: i32x16::splat(s, h),
            wf: f32x16::splat(s, w as f32),
            hf: f32x16::splat(s, h as f32),
            shift: Some(w.trailing_zeros()),
        }
    }

    #[inline(always)]
    pub(crate) fn per_lane(s: S, view: &View<'_>, level: i32x16<S>) -> Self {
        let one = i32x16::splat(s, 1);
        let (w, h) = view.sizes[0];
        let (w, h) = (i32x16::splat(s, w) >> level, i32x16::splat(s, h) >> level);
        let width = w.simd_gt(one).select(w, one);
        let height = h.simd_gt(one).select(h, one);
        let offset = match Words::new(&view.offsets) {
            Some(offsets) => gather(s, offsets, level.bitcast()).bitcast(),
            None => i32x16::splat(s, 0),
        };
        Self {
            offset,
            width,
            height,
            wf: width.to_float::<f32x16<S>>(),
            hf: height.to_float::<f32x16<S>>(),
            shift: None,
        }
    }

    /// Texels before a row of the level.
    #[inline(always)]
    pub(crate) fn row_start(&self, y: i32x16<S>) -> i32x16<S> {
        match self.shift {
            Some(shift) => y << shift,
            None => y * self.width,
        }
    }

    /// First word of a texel counted within the level.
    #[inline(always)]
    pub(crate) fn word<const FORMAT: u8>(&self, texel: i32x16<S>) -> u32x16<S> {
        let word = match FORMAT {
            RGBA16 => texel << 1,
            _ => texel,
        };
        (word + self.offset).bitcast()
    }
}

/// Scalar [`Axis::place`](crate::wrap::Axis::place) for sixteen, on an axis that repeats over a power of two.
#[inline(always)]
pub(crate) fn place<S: Simd>(s: S, u: f32x16<S>, nf: f32x16<S>) -> f32x16<S> {
    let x = u * nf;
    let inside = x.abs().simd_lt(f32x16::splat(s, REACH));
    if inside.all_true() {
        return x;
    }
    inside.select(x, fraction(s, u) * nf)
}

#[inline(always)]
fn fraction<S: Simd>(s: S, u: f32x16<S>) -> f32x16<S> {
    let zero = f32x16::splat(s, 0.0);
    let whole = f32x16::splat(s, 8_388_608.0);
    let u = u.abs().simd_lt(whole).select(u, zero);
    let f = u - floor_to_i32(s, u).to_float::<f32x16<S>>();
    let f = f.simd_gt(zero).select(f, zero);
    let top = f32x16::splat(s, BELOW_ONE);
    f.simd_gt(top).select(top, f)
}

/// The wrapped column.
#[inline(always)]
pub(crate) fn column<S: Simd>(at: &At<S>, i: i32x16<S>) -> i32x16<S> {
    i & (at.width - 1)
}

/// The wrapped row, counted from the top of memory.
#[inline(always)]
pub(crate) fn row<S: Simd>(view: &View<'_>, at: &At<S>, j: i32x16<S>) -> i32x16<S> {
    let last = at.height - 1;
    let y = j & last;
    if view.flip { y ^ last } else { y }
}

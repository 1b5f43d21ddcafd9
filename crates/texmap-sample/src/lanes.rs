//! Sixteen look-ups at once; outside semantic versioning.
//!
//! Every function gives, lane by lane, the bits of its scalar twin on every SIMD level. What can
//! change a bit (level, probes, wrap) is decided per lane; the tests on whole vectors below only
//! choose between paths that give the same bits.

pub mod float;
pub mod packed;

use crate::{
    filter::gl_of,
    sampler::{Filter, Mip, Precision, Sampler, Texel},
    texels::{Chain, Format},
    texture::Texture2d,
    wrap::{Axis, BELOW_ONE, REACH, Wrap},
};
use texmap_math::{
    fearless_simd::{f32x16, i32x16, mask32x16, prelude::*, u32x16},
    lanes::{Words, floor_to_i32, gather},
};

/// Formats as constants of the kernels.
pub const RGBA8: u8 = 0;
/// RGBA8 whose alpha is 255 throughout.
pub const RGBX8: u8 = 1;
/// Two words a texel.
pub const RGBA16: u8 = 2;
/// Four words a texel.
pub const RGBA32: u8 = 3;
/// One float a texel.
pub const R32: u8 = 4;

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
    /// Both axes repeat over powers of two.
    pub simple: bool,
    pub(crate) opaque: bool,
    pub(crate) x: Axis,
    pub(crate) y: Axis,
    flip: bool,
    offsets: [u32; LEVELS],
    sizes: [(i32, i32); LEVELS],
    pub(crate) last: i32,
    pub(crate) border: [f32; 4],
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
    /// `None` for filters that have no lane form (see [`Kind`]); they run one at a time.
    pub fn new(sampler: &Sampler, t: &'a Texture2d<'_>) -> Option<Self> {
        let kind = Kind::of(sampler.filter)?;
        Self::of_chain(sampler, &t.chain, kind)
    }

    pub(crate) fn of_chain(sampler: &Sampler, chain: &'a Chain<'_>, kind: Kind) -> Option<Self> {
        let most = match sampler.filter {
            Filter::Anisotropic(most) => most.clamp(1, 16),
            _ => 1,
        };
        let base = &chain.levels[0];
        let (x, y) = (
            Axis::new(sampler.wrap_u, base.width),
            Axis::new(sampler.wrap_v, base.height),
        );
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
            format: match chain.format {
                Format::Rgba8 if chain.opaque && !x.has_border() && !y.has_border() => RGBX8,
                Format::Rgba8 => RGBA8,
                Format::Rgba16 => RGBA16,
                Format::Rgba32 => RGBA32,
                Format::R32 => R32,
            },
            simple: x.scaled_first && y.scaled_first,
            opaque: chain.opaque,
            x,
            y,
            flip: chain.flip,
            offsets,
            sizes,
            last: chain.levels.len() as i32 - 1,
            border: sampler.border.map(|c| c * chain.format.units()),
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

    /// Texels before a row of the level; a negative row (outside a border) gives some number.
    #[inline(always)]
    pub(crate) fn row_start<const SIMPLE: bool>(&self, y: i32x16<S>) -> i32x16<S> {
        match self.shift {
            Some(shift) if SIMPLE => y << shift,
            _ => y * self.width,
        }
    }

    /// First word of a texel counted within the level.
    #[inline(always)]
    pub(crate) fn word<const FORMAT: u8>(&self, texel: i32x16<S>) -> u32x16<S> {
        let word = match FORMAT {
            RGBA16 => texel << 1,
            RGBA32 => texel << 2,
            _ => texel,
        };
        (word + self.offset).bitcast()
    }
}

/// Scalar [`Axis::place`] for sixteen.
#[inline(always)]
pub(crate) fn place<S: Simd, const SIMPLE: bool>(
    s: S,
    u: f32x16<S>,
    nf: f32x16<S>,
    axis: Axis,
) -> f32x16<S> {
    if SIMPLE || axis.scaled_first {
        let x = u * nf;
        let inside = x.abs().simd_lt(f32x16::splat(s, REACH));
        if inside.all_true() {
            return x;
        }
        return inside.select(x, fraction(s, u) * nf);
    }
    match axis.wrap {
        Wrap::Repeat => fraction(s, u) * nf,
        Wrap::MirroredRepeat => fraction(s, u * 0.5) * 2.0 * nf,
        _ => clamp(s, u) * nf,
    }
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

#[inline(always)]
fn clamp<S: Simd>(s: S, u: f32x16<S>) -> f32x16<S> {
    let (low, high) = (f32x16::splat(s, -64.0), f32x16::splat(s, 65.0));
    // NaN gives 0, and so passes both tests.
    let u = u.simd_eq(u).select(u, f32x16::splat(s, 0.0));
    let u = u.simd_gt(low).select(u, low);
    u.simd_gt(high).select(high, u)
}

/// Scalar [`Axis::index`] for sixteen, for taps at most one texel from a [`place`].
#[inline(always)]
pub(crate) fn index<S: Simd, const SIMPLE: bool>(
    s: S,
    i: i32x16<S>,
    n: i32x16<S>,
    axis: Axis,
) -> i32x16<S> {
    let zero = i32x16::splat(s, 0);
    if SIMPLE || axis.scaled_first {
        return i & (n - 1);
    }
    let last = n - 1;
    match axis.wrap {
        Wrap::Repeat => {
            let i = i.simd_lt(zero).select(i + n, i);
            i.simd_ge(n).select(i - n, i)
        }
        Wrap::MirroredRepeat => {
            let i = i.simd_ge(n).select(n + last - i, i);
            i.simd_lt(zero).select(!i, i)
        }
        Wrap::ClampToEdge => {
            let i = i.simd_lt(zero).select(zero, i);
            i.simd_gt(last).select(last, i)
        }
        Wrap::ClampToBorder => {
            let outside = i.simd_lt(zero) | i.simd_ge(n);
            outside.select(i32x16::splat(s, -1), i)
        }
        Wrap::MirrorClampToEdge => {
            let i = i.simd_lt(zero).select(!i, i);
            i.simd_gt(last).select(last, i)
        }
    }
}

/// Rows counted from the top of memory.
#[inline(always)]
pub(crate) fn flip<S: Simd, const SIMPLE: bool>(
    view: &View<'_>,
    at: &At<S>,
    y: i32x16<S>,
) -> i32x16<S> {
    if !view.flip {
        y
    } else if SIMPLE {
        y ^ (at.height - 1)
    } else {
        at.height - 1 - y
    }
}

/// Lanes whose indices lie outside a border; only asked where an axis has one.
#[inline(always)]
pub(crate) fn outside<S: Simd>(s: S, x: i32x16<S>, y: i32x16<S>) -> mask32x16<S> {
    (x | y).simd_lt(i32x16::splat(s, 0))
}

/// The indices and the weight of a linear blend on one axis, before the blend's own arithmetic.
#[inline(always)]
pub(crate) fn axis_x<S: Simd, const SIMPLE: bool>(
    s: S,
    view: &View<'_>,
    at: &At<S>,
    u: f32x16<S>,
) -> f32x16<S> {
    place::<S, SIMPLE>(s, u, at.wf, view.x)
}

/// As [`axis_x`] for v.
#[inline(always)]
pub(crate) fn axis_y<S: Simd, const SIMPLE: bool>(
    s: S,
    view: &View<'_>,
    at: &At<S>,
    v: f32x16<S>,
) -> f32x16<S> {
    place::<S, SIMPLE>(s, v, at.hf, view.y)
}

/// Wrapped, but not yet flipped.
#[inline(always)]
pub(crate) fn column<S: Simd, const SIMPLE: bool>(
    s: S,
    view: &View<'_>,
    at: &At<S>,
    i: i32x16<S>,
) -> i32x16<S> {
    index::<S, SIMPLE>(s, i, at.width, view.x)
}

/// Wrapped and flipped; outside a border it stays negative.
#[inline(always)]
pub(crate) fn row<S: Simd, const SIMPLE: bool>(
    s: S,
    view: &View<'_>,
    at: &At<S>,
    j: i32x16<S>,
) -> i32x16<S> {
    let y = index::<S, SIMPLE>(s, j, at.height, view.y);
    let flipped = flip::<S, SIMPLE>(view, at, y);
    if !SIMPLE && view.y.has_border() {
        y.simd_lt(i32x16::splat(s, 0)).select(y, flipped)
    } else {
        flipped
    }
}

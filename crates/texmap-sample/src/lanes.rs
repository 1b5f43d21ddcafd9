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

pub mod float;
pub mod packed;

pub use crate::pattern::gradient_noise_lanes;

use crate::{
    encoded::Encoded,
    filter::{axes, gl_of},
    sampler::{Cubic, Filter, Mip, Precision, Sampler, Texel},
    texels::{Chain, Format, Level},
    texture::Texture2d,
    wrap::{Axis, BELOW_ONE, REACH, Wrap},
};
use texmap_math::{
    fearless_simd::{f32x16, i32x16, mask32x16, prelude::*, u32x16},
    lanes::{Words, floor_to_i32, gather, is_wide},
};

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
    Gl {
        /// Texels of magnified lanes.
        mag: Texel,
        /// Texels of the others.
        min: Texel,
        /// Levels of the others.
        mip: Mip,
    },
    /// Sixteen texels of level 0.
    Bicubic(Cubic),
    /// All texels of an ellipse.
    Ewa,
}

impl Kind {
    fn of(filter: Filter) -> Self {
        match filter {
            Filter::Ewa(_) => return Self::Ewa,
            Filter::Bicubic(kernel) => return Self::Bicubic(kernel),
            Filter::Anisotropic(_) => return Self::Anisotropic,
            _ => {}
        }
        match gl_of(filter) {
            (Texel::Nearest, Texel::Nearest, Mip::None) => Self::Nearest,
            (Texel::Linear, Texel::Linear, Mip::None) => Self::Bilinear,
            (Texel::Linear, Texel::Linear, Mip::Linear) => Self::Trilinear,
            (mag, min, mip) => Self::Gl { mag, min, mip },
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
        let format = match chain.format {
            Format::Rgba8 if packed::applies(sampler, chain) => RGBA8,
            Format::Rgba8 => RGBA8_EXACT,
            Format::Rgba16 if chain.encoded.is_none() => RGBA16,
            _ => APART,
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
            Filter::Anisotropic(most) | Filter::Ewa(most) => most.clamp(1, 16),
            _ => 1,
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
        let bias = if sampler.lod.bias.is_nan() {
            0.0
        } else {
            sampler.lod.bias.clamp(-32.0, 32.0)
        };
        Some(Self {
            // An encoded texture without levels has no words.
            words: Words::new(chain.words()).or_else(|| Words::new(&[0]))?,
            apart,
            format,
            opaque: chain.opaque && !bordered,
            flip: chain.flip,
            masked: axes.iter().all(|axis| axis.scaled_first),
            axes,
            bordered,
            border: sampler.border.map(|c| c * chain.format.units()),
            border_word: packed::border(sampler.border),
            offsets,
            levels,
            unit,
            reach: REACH * unit,
            last: chain.levels.len() as i32 - 1,
            scale: chain.format.scale(),
            kind,
            most,
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

/// Texels that are fetched one by one, counted through all levels.
#[derive(Clone, Copy, Debug)]
struct Apart<'a> {
    words: &'a [u32],
    format: Format,
    encoded: Option<&'a Encoded>,
    /// Texels that are encoded: those of level 0.
    kept: usize,
    last: usize,
}

impl<'a> Apart<'a> {
    fn new(chain: &'a Chain<'_>) -> Self {
        let base = &chain.levels[0];
        let kept = match chain.encoded {
            Some(_) => base.width as usize * base.height as usize,
            None => 0,
        };
        let count = kept + chain.words().len() / chain.format.words();
        Self {
            words: chain.words(),
            format: chain.format,
            encoded: chain.encoded.as_ref(),
            kept,
            last: count.saturating_sub(1),
        }
    }

    fn first_of(&self, level: &Level) -> usize {
        match level.offset {
            Level::ENCODED => 0,
            offset => self.kept + offset / self.format.words(),
        }
    }

    /// Unscaled texels, channel by channel; of those beyond the end, the last. One compiled form serves all filters and levels.
    #[inline(never)]
    fn fetch(&self, at: &[u32; 16]) -> [[f32; 16]; 4] {
        let (words, kept) = (self.words, self.kept);
        // The kind of texel is asked once.
        match (self.encoded, self.format) {
            (Some(encoded), _) => self.each(at, |i| match i.checked_sub(kept) {
                None => encoded.decode(i),
                Some(i) => Format::Rgba16.fetch(words, 2 * i),
            }),
            (None, Format::Rgba32) => {
                let texels = words.as_chunks::<4>().0;
                self.each(at, |i| texels[i].map(f32::from_bits))
            }
            (None, format) => self.each(at, |i| format.fetch(words, i * format.words())),
        }
    }

    #[inline(always)]
    fn each(&self, at: &[u32; 16], texel: impl Fn(usize) -> [f32; 4]) -> [[f32; 16]; 4] {
        let mut out = [[0.0; 16]; 4];
        for (i, at) in at.iter().enumerate() {
            let [r, g, b, a] = texel((*at as usize).min(self.last));
            (out[0][i], out[1][i], out[2][i], out[3][i]) = (r, g, b, a);
        }
        out
    }
}

/// Where the four texels of a bilinear look-up are.
pub(crate) enum Corners<S: Simd> {
    /// The left ones of both rows: the right ones are the next texels in memory, and reading such pairs is the fast way.
    Pairs([u32x16<S>; 2]),
    /// Upper left, upper right, lower left, lower right.
    Apart([Place<S>; 4]),
}

/// The level of each lane.
#[derive(Clone, Copy)]
pub(crate) struct At<S: Simd> {
    offset: i32x16<S>,
    pub(crate) width: i32x16<S>,
    pub(crate) height: i32x16<S>,
    turn: i32x16<S>,
    pub(crate) units_x: f32x16<S>,
    units_y: f32x16<S>,
    /// log2 of the width of a power of two where all lanes share the level.
    shift: Option<u32>,
}

impl<S: Simd> At<S> {
    #[inline(always)]
    pub(crate) fn uniform(s: S, view: &View<'_>, level: i32) -> Self {
        let level = &view.levels[(level & 15) as usize];
        Self {
            offset: i32x16::splat(s, level.offset),
            width: i32x16::splat(s, level.width),
            height: i32x16::splat(s, level.height),
            turn: i32x16::splat(s, level.turn),
            units_x: f32x16::splat(s, level.units_x),
            units_y: f32x16::splat(s, level.units_y),
            shift: Some(level.shift),
        }
    }

    #[inline(always)]
    pub(crate) fn per_lane(s: S, view: &View<'_>, level: i32x16<S>) -> Self {
        let (zero, one) = (i32x16::splat(s, 0), i32x16::splat(s, 1));
        let (w, h) = view.size();
        let (w, h) = (i32x16::splat(s, w) >> level, i32x16::splat(s, h) >> level);
        let width = w.simd_gt(one).select(w, one);
        let height = h.simd_gt(one).select(h, one);
        let offset = match Words::new(&view.offsets) {
            Some(offsets) => gather(s, offsets, level.bitcast()).bitcast(),
            None => zero,
        };
        Self {
            offset,
            width,
            height,
            turn: if view.flip { height - 1 } else { zero },
            units_x: width.to_float::<f32x16<S>>() * view.unit,
            units_y: height.to_float::<f32x16<S>>() * view.unit,
            shift: None,
        }
    }

    /// The level of each lane, which are often one.
    #[inline(always)]
    pub(crate) fn of(s: S, view: &View<'_>, level: i32x16<S>) -> Self {
        if level.simd_eq(i32x16::splat(s, level[0])).all_true() {
            Self::uniform(s, view, level[0])
        } else {
            Self::per_lane(s, view, level)
        }
    }

    /// First word of a texel counted within the level; the texel itself where it is fetched apart.
    #[inline(always)]
    pub(crate) fn word<const FORMAT: u8>(&self, view: &View<'_>, texel: i32x16<S>) -> u32x16<S> {
        let word = match FORMAT {
            RGBA16 => texel << 1,
            ANY => texel << u32::from(view.format == RGBA16),
            _ => texel,
        };
        (word + self.offset).bitcast()
    }

    /// Texels before a row in memory.
    #[inline(always)]
    fn row_start(&self, y: i32x16<S>) -> i32x16<S> {
        match self.shift {
            Some(shift) => y << shift,
            None => y * self.width,
        }
    }

    /// The scaled coordinates, whose floor holds a texel (and its fraction, where units are fractions).
    #[inline(always)]
    pub(crate) fn place(
        &self,
        s: S,
        view: &View<'_>,
        u: f32x16<S>,
        v: f32x16<S>,
    ) -> (f32x16<S>, f32x16<S>) {
        if !view.masked {
            return (
                place(s, view, view.axes[0], u, self.units_x),
                place(s, view, view.axes[1], v, self.units_y),
            );
        }
        let (x, y) = (u * self.units_x, v * self.units_y);
        let reach = f32x16::splat(s, view.reach);
        let (in_x, in_y) = (x.abs().simd_lt(reach), y.abs().simd_lt(reach));
        if (in_x & in_y).all_true() {
            return (x, y);
        }
        (
            in_x.select(x, fraction(s, u) * self.units_x),
            in_y.select(y, fraction(s, v) * self.units_y),
        )
    }

    /// The texel at unwrapped indices.
    #[inline(always)]
    pub(crate) fn texel<const FORMAT: u8>(
        &self,
        s: S,
        view: &View<'_>,
        i: i32x16<S>,
        j: i32x16<S>,
    ) -> Place<S> {
        if view.masked {
            let y = (j & (self.height - 1)) ^ self.turn;
            let x = i & (self.width - 1);
            return Place {
                word: self.word::<FORMAT>(view, self.row_start(y) + x),
                sign: x,
            };
        }
        let (x, y) = self.wrapped(s, view, i, j);
        self.general::<FORMAT>(view, x, y)
    }

    /// The texels at unwrapped indices (i, j), (i + 1, j), (i, j + 1), (i + 1, j + 1).
    #[inline(always)]
    pub(crate) fn corners<const FORMAT: u8>(
        &self,
        s: S,
        view: &View<'_>,
        i: i32x16<S>,
        j: i32x16<S>,
    ) -> Corners<S> {
        if view.masked {
            let (x_mask, y_mask) = (self.width - 1, self.height - 1);
            let x0 = i & x_mask;
            let r0 = self.row_start((j & y_mask) ^ self.turn);
            let r1 = self.row_start(((j + 1) & y_mask) ^ self.turn);
            let left = [
                self.word::<FORMAT>(view, r0 + x0),
                self.word::<FORMAT>(view, r1 + x0),
            ];
            if is_wide(s) && !x0.simd_eq(x_mask).any_true() {
                return Corners::Pairs(left);
            }
            let x1 = (i + 1) & x_mask;
            let right = [
                self.word::<FORMAT>(view, r0 + x1),
                self.word::<FORMAT>(view, r1 + x1),
            ];
            return Corners::Apart([
                Place {
                    word: left[0],
                    sign: x0,
                },
                Place {
                    word: right[0],
                    sign: x0,
                },
                Place {
                    word: left[1],
                    sign: x0,
                },
                Place {
                    word: right[1],
                    sign: x0,
                },
            ]);
        }
        let (x0, y0) = self.wrapped(s, view, i, j);
        let (x1, y1) = self.wrapped(s, view, i + 1, j + 1);
        let left = [
            self.general::<FORMAT>(view, x0, y0),
            self.general::<FORMAT>(view, x0, y1),
        ];
        if is_wide(s) && !view.bordered && (x1 - x0).simd_eq(1).all_true() {
            return Corners::Pairs([left[0].word, left[1].word]);
        }
        Corners::Apart([
            left[0],
            self.general::<FORMAT>(view, x1, y0),
            left[1],
            self.general::<FORMAT>(view, x1, y1),
        ])
    }

    /// [`wrapped`](Self::wrapped) of a column, however far outside.
    #[inline(always)]
    pub(crate) fn far_column(&self, s: S, view: &View<'_>, i: i32x16<S>) -> i32x16<S> {
        far_index(s, view.axes[0], i, self.width)
    }

    /// [`wrapped`](Self::wrapped) of a row, however far outside.
    #[inline(always)]
    pub(crate) fn far_row(&self, s: S, view: &View<'_>, j: i32x16<S>) -> i32x16<S> {
        far_index(s, view.axes[1], j, self.height)
    }

    /// Wrapped indices; [`OUTSIDE`](crate::wrap::OUTSIDE) on the border.
    #[inline(always)]
    pub(crate) fn wrapped(
        &self,
        s: S,
        view: &View<'_>,
        i: i32x16<S>,
        j: i32x16<S>,
    ) -> (i32x16<S>, i32x16<S>) {
        (
            index(s, view.axes[0], i, self.width),
            index(s, view.axes[1], j, self.height),
        )
    }

    /// The texel at wrapped indices of a volume.
    #[inline(always)]
    pub(crate) fn in_slice<const FORMAT: u8>(
        &self,
        view: &View<'_>,
        [x, y, z]: [i32x16<S>; 3],
    ) -> Place<S> {
        let turned = if view.flip { self.turn - y } else { y };
        let row = z * self.height + turned;
        Place {
            word: self.word::<FORMAT>(view, row * self.width + x),
            sign: x | y | z,
        }
    }

    /// The texel at wrapped indices.
    #[inline(always)]
    pub(crate) fn general<const FORMAT: u8>(
        &self,
        view: &View<'_>,
        x: i32x16<S>,
        y: i32x16<S>,
    ) -> Place<S> {
        let turned = if view.flip { self.turn - y } else { y };
        Place {
            word: self.word::<FORMAT>(view, turned * self.width + x),
            sign: x | y,
        }
    }
}

/// Where a tap reads.
#[derive(Clone, Copy)]
pub(crate) struct Place<S: Simd> {
    /// First word of the texel; anything where the tap reads the border.
    pub(crate) word: u32x16<S>,
    /// Negative where the tap reads the border.
    sign: i32x16<S>,
}

impl<S: Simd> Place<S> {
    /// Lanes that read the border instead of a texel.
    #[inline(always)]
    pub(crate) fn outside(&self, s: S) -> mask32x16<S> {
        self.sign.simd_lt(i32x16::splat(s, 0))
    }
}

/// Scalar [`Axis::place`] for sixteen.
#[inline(always)]
pub(crate) fn place<S: Simd>(
    s: S,
    view: &View<'_>,
    axis: Axis,
    u: f32x16<S>,
    units: f32x16<S>,
) -> f32x16<S> {
    match axis.wrap {
        Wrap::Repeat if axis.scaled_first => {
            let x = u * units;
            let inside = x.abs().simd_lt(f32x16::splat(s, view.reach));
            inside.select(x, fraction(s, u) * units)
        }
        Wrap::Repeat => fraction(s, u) * units,
        Wrap::MirroredRepeat => fraction(s, u * 0.5) * 2.0 * units,
        Wrap::ClampToEdge | Wrap::ClampToBorder | Wrap::MirrorClampToEdge => {
            let (low, high) = (f32x16::splat(s, -64.0), f32x16::splat(s, 65.0));
            let u = u.simd_eq(u).select(u, f32x16::splat(s, 0.0));
            let u = u.simd_gt(high).select(high, u);
            u.simd_gt(low).select(u, low) * units
        }
    }
}

/// Scalar [`Axis::index`] for sixteen, for indices that [`place`] leads to.
#[inline(always)]
pub(crate) fn index<S: Simd>(s: S, axis: Axis, i: i32x16<S>, n: i32x16<S>) -> i32x16<S> {
    let zero = i32x16::splat(s, 0);
    match axis.wrap {
        Wrap::Repeat if axis.scaled_first => i & (n - 1),
        // Fractions keep the index within a texel of 0..n.
        Wrap::Repeat => {
            let i = i.simd_lt(zero).select(i + n, i);
            i.simd_ge(n).select(i - n, i)
        }
        // Two indices beyond 0..2n, which cubics reach, come back as well.
        Wrap::MirroredRepeat => {
            let i = i.simd_lt(zero).select(-1 - i, i);
            let back = n + n - 1 - i;
            let i = i.simd_lt(back).select(i, back);
            let i = i.simd_lt(zero).select(-1 - i, i);
            i.simd_lt(n).select(i, n - 1)
        }
        Wrap::ClampToEdge => {
            let i = at_least_zero(s, i);
            i.simd_lt(n).select(i, n - 1)
        }
        Wrap::ClampToBorder => {
            let inside = i.simd_lt(n) & i.simd_ge(zero);
            inside.select(i, i32x16::splat(s, crate::wrap::OUTSIDE))
        }
        Wrap::MirrorClampToEdge => {
            let i = i.simd_lt(zero).select(-1 - i, i);
            i.simd_lt(n).select(i, n - 1)
        }
    }
}

/// [`index`] of any index, however far outside.
#[inline(always)]
pub(crate) fn far_index<S: Simd>(s: S, axis: Axis, i: i32x16<S>, n: i32x16<S>) -> i32x16<S> {
    match axis.wrap {
        Wrap::Repeat if !axis.scaled_first => remainder(s, i, n),
        Wrap::MirroredRepeat => {
            let m = remainder(s, i, n + n);
            m.simd_lt(n).select(m, n + n - 1 - m)
        }
        _ => index(s, axis, i, n),
    }
}

/// `i` modulo `n`, from 0 on. Below 2^17 the quotient in f32 is on the right side of every integer.
#[inline(always)]
fn remainder<S: Simd>(s: S, i: i32x16<S>, n: i32x16<S>) -> i32x16<S> {
    i - n * floor_to_i32(s, i.to_float::<f32x16<S>>() / n.to_float::<f32x16<S>>())
}

#[inline(always)]
fn at_least_zero<S: Simd>(s: S, i: i32x16<S>) -> i32x16<S> {
    let zero = i32x16::splat(s, 0);
    i.simd_gt(zero).select(i, zero)
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

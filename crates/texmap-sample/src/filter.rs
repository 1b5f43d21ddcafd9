//! Filters: one kernel each, and the table that picks it.

pub(crate) mod anisotropic;
pub(crate) mod bicubic;
pub(crate) mod bilinear;
pub(crate) mod cell;
pub(crate) mod ewa;
pub(crate) mod gl;
pub(crate) mod nearest;
pub(crate) mod summed_area;
pub(crate) mod trilinear;

use crate::{
    address::lod::{self, TexelFootprint},
    bound_texture::{ANY, BoundTexture, RGBA8, RGBA8_EXACT, RGBA16, exact_format},
    fetch::Color,
    rgba8,
    sampler::{Cubic, Filter, Mip, Sampler, TexelFilter},
    texel_data::Chain,
};
use texmap_math::{
    footprint::Footprint,
    simd::{ByteIsa, Isa, One, Scalar},
};

/// The kernel that a filter takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Kernel {
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
    /// All texels of an upright rectangle.
    SummedArea,
}

impl Kernel {
    #[inline(always)]
    pub(crate) fn of(filter: Filter) -> Self {
        match filter {
            Filter::Ewa { .. } => return Self::Ewa,
            Filter::SummedArea => return Self::SummedArea,
            Filter::Bicubic(kernel) => return Self::Bicubic(kernel),
            Filter::Anisotropic(_) => return Self::Anisotropic,
            _ => {}
        }
        match gl_of(filter) {
            (TexelFilter::Nearest, TexelFilter::Nearest, Mip::None) => Self::Nearest,
            (TexelFilter::Linear, TexelFilter::Linear, Mip::None) => Self::Bilinear,
            (TexelFilter::Linear, TexelFilter::Linear, Mip::Linear) => Self::Trilinear,
            _ => Self::Gl,
        }
    }

    /// True if it has a kernel with 8-bit weights.
    #[inline(always)]
    pub(crate) fn has_bytes(self) -> bool {
        !matches!(self, Self::Bicubic(_) | Self::Ewa | Self::SummedArea)
    }

    /// True for the three that need no more than coordinates and a level.
    #[must_use]
    pub fn is_plain(self) -> bool {
        matches!(self, Self::Nearest | Self::Bilinear | Self::Trilinear)
    }
}

/// OpenGL's choices of texels and levels for a filter, where no axis of the footprint matters.
#[inline(always)]
pub(crate) fn gl_of(filter: Filter) -> (TexelFilter, TexelFilter, Mip) {
    match filter {
        // Cubics have their own kernel on level 0.
        Filter::Bilinear | Filter::Bicubic(_) => {
            (TexelFilter::Linear, TexelFilter::Linear, Mip::None)
        }
        Filter::Nearest => (TexelFilter::Nearest, TexelFilter::Nearest, Mip::None),
        Filter::MipNearest => (TexelFilter::Nearest, TexelFilter::Nearest, Mip::Nearest),
        Filter::BilinearMipNearest => (TexelFilter::Linear, TexelFilter::Linear, Mip::Nearest),
        // So is a summed area without its table.
        Filter::Trilinear | Filter::Anisotropic(_) | Filter::Ewa { .. } | Filter::SummedArea => {
            (TexelFilter::Linear, TexelFilter::Linear, Mip::Linear)
        }
        Filter::Gl { mag, min, mip } => (mag, min, mip),
    }
}

/// The look-ups of as many lanes as a kernel takes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LookUp<I: Isa> {
    pub(crate) uv: [I::F32; 2],
    /// `Some` for filters that take its axes.
    pub(crate) footprint: Option<TexelFootprint<I>>,
    /// The limited level of detail without a footprint.
    pub(crate) flat: f32,
}

impl<I: Isa> LookUp<I> {
    /// The level of detail, limited as far as the levels of the texture do not; 0 for levels below it where all lanes are magnified, as
    /// every filter takes them.
    #[inline(always)]
    pub(crate) fn lod(&self, i: I, view: &BoundTexture<'_>) -> I::F32 {
        match &self.footprint {
            // Most of a near surface: the logarithm costs more than its texels.
            Some(d) if lod::is_magnified(view, d) => i.f32(0.0),
            Some(d) if view.plain_lod => lod::unlimited_lod(i, view, d),
            Some(d) => lod::lod(i, view, d),
            None => i.f32(self.flat),
        }
    }
}

/// A filter with f32 weights, on the texels of [`FORMAT`](Self::FORMAT).
pub(crate) trait FilterKernel {
    const FORMAT: u8;
    const INPUT: Input;
    /// `lod` is that of [`Input::Level`].
    fn color<I: Isa>(i: I, view: &BoundTexture<'_>, at: &LookUp<I>, lod: I::F32) -> Color<I>;
}

/// A filter of one cell or two whose addresses are found for a run of vectors, before the first texel is read. The cells of one texture
/// serve all that share its geometry: see [`BoundTexture::shares_cells`].
pub(crate) trait CellKernel: Copy {
    const INPUT: Input;
    const ZERO: Self;
    /// Puts the cells of a vector of coordinates here, with addresses in the words of the view.
    fn find<I: Isa>(&mut self, i: I, view: &BoundTexture<'_>, at: &LookUp<I>, lod: I::F32);
    /// Turns addresses of the other format of one or two words a texel into those of `format`. Of textures without a border.
    fn readdress<I: Isa>(&mut self, i: I, format: u8);
    /// [`color`](FilterKernel::color) of the kernel for `FORMAT`, the view's, of the same look-ups.
    fn color<I: Isa, const FORMAT: u8>(&self, i: I, view: &BoundTexture<'_>) -> Color<I>;
}

/// The part of a look-up that a filter reads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Input {
    /// Coordinates alone.
    Coordinates,
    /// Coordinates and the level of detail. Batches find it one vector ahead: the logarithm is a long chain of operations, beside which
    /// a processor does others.
    Level,
    /// Coordinates and the footprint.
    Footprint,
}

/// A filter with 8-bit weights on RGBA8.
pub(crate) trait ByteKernel {
    /// True if sixteen lanes are faster on 128-bit levels than four.
    const WIDE: bool;
    fn word<I: ByteIsa>(i: I, view: &BoundTexture<'_>, at: &LookUp<I>) -> I::U32;
}

/// Runs a kernel: over a batch, or for one look-up.
pub(crate) trait Run {
    type Out;
    fn color<K: FilterKernel>(self) -> Self::Out;
    /// `F` for one look-up, `K` for batches.
    fn cells<F: FilterKernel, K: CellKernel>(self) -> Self::Out;
    fn bytes<K: ByteKernel>(self) -> Self::Out;
}

/// Runs the kernel of a filter on a format. Probes and ellipses need a footprint; look-ups without one are trilinear.
#[inline(always)]
pub(crate) fn run<R: Run>(kind: Kernel, format: u8, has_footprint: bool, run: R) -> R::Out {
    use Kernel::{Anisotropic, Bicubic, Bilinear, Ewa, Gl, Nearest, SummedArea, Trilinear};
    let kind = match kind {
        Anisotropic | Ewa if !has_footprint => Trilinear,
        kind => kind,
    };
    match (format, kind) {
        (RGBA8, Nearest) => run.bytes::<rgba8::nearest::Nearest>(),
        (RGBA8, Bilinear) => run.bytes::<rgba8::bilinear::Bilinear>(),
        (RGBA8, Anisotropic) => run.bytes::<rgba8::anisotropic::Anisotropic>(),
        (RGBA8, Gl) => run.bytes::<rgba8::gl::Gl>(),
        (RGBA8, _) => run.bytes::<rgba8::trilinear::Trilinear>(),
        (RGBA8_EXACT, Bilinear) => run.cells::<bilinear::Bilinear<RGBA8_EXACT>, cell::Cell>(),
        (RGBA8_EXACT, Trilinear) => {
            run.cells::<trilinear::Trilinear<RGBA8_EXACT>, trilinear::Cells>()
        }
        (RGBA16, Nearest) => run.color::<nearest::Nearest<RGBA16>>(),
        (RGBA16, Bilinear) => run.cells::<bilinear::Bilinear<RGBA16>, cell::Cell>(),
        (RGBA16, Trilinear) => run.cells::<trilinear::Trilinear<RGBA16>, trilinear::Cells>(),
        (_, Anisotropic) => run.color::<anisotropic::Anisotropic>(),
        (_, Bicubic(_)) => run.color::<bicubic::Bicubic>(),
        (_, Ewa) => run.color::<ewa::Ewa>(),
        (_, SummedArea) => run.color::<summed_area::Rectangle>(),
        (_, Nearest | Bilinear | Trilinear | Gl) => run.color::<gl::Gl>(),
    }
}

/// One look-up, `flat` the limited level of detail where it has no footprint.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Single<'a> {
    pub(crate) sampler: &'a Sampler,
    pub(crate) chain: &'a Chain<'a>,
    pub(crate) uv: [f32; 2],
    pub(crate) footprint: Option<Footprint>,
    pub(crate) flat: f32,
}

impl Single<'_> {
    #[inline(always)]
    fn look_up(&self, view: &BoundTexture<'_>) -> LookUp<Scalar> {
        LookUp {
            uv: self.uv,
            footprint: self.footprint.map(
                #[inline(always)]
                |d| TexelFootprint::of(view, d),
            ),
            flat: self.flat,
        }
    }

    #[inline(never)]
    pub(crate) fn word<K: ByteKernel>(self) -> u32 {
        match self.view(RGBA8) {
            Some(view) => K::word(Scalar, &view, &self.look_up(&view)).0,
            None => 0,
        }
    }

    #[inline(always)]
    fn view(&self, format: u8) -> Option<BoundTexture<'_>> {
        let kind = Kernel::of(self.sampler.filter);
        BoundTexture::single(self.sampler, self.chain, kind, format)
    }
}

impl Run for Single<'_> {
    type Out = [f32; 4];

    #[inline(never)]
    fn color<K: FilterKernel>(self) -> [f32; 4] {
        let format = match K::FORMAT {
            ANY => exact_format(self.chain),
            format => format,
        };
        match self.view(format) {
            Some(view) => {
                let at = self.look_up(&view);
                let lod = match K::INPUT {
                    Input::Level => at.lod(Scalar, &view),
                    Input::Coordinates | Input::Footprint => 0.0,
                };
                K::color(Scalar, &view, &at, lod)
            }
            None => [0.0; 4],
        }
    }

    #[inline(always)]
    fn cells<F: FilterKernel, K: CellKernel>(self) -> [f32; 4] {
        self.color::<F>()
    }

    #[inline(always)]
    fn bytes<K: ByteKernel>(self) -> [f32; 4] {
        rgba8::unpack(Scalar, One(self.word::<K>()))
    }
}

/// See [`Single`].
#[inline(always)]
pub(crate) fn sample(
    sampler: &Sampler,
    chain: &Chain<'_>,
    uv: [f32; 2],
    footprint: Option<Footprint>,
    flat: f32,
) -> [f32; 4] {
    let format = if rgba8::applies(sampler, chain) {
        RGBA8
    } else {
        exact_format(chain)
    };
    let single = Single {
        sampler,
        chain,
        uv,
        footprint,
        flat,
    };
    run(
        Kernel::of(sampler.filter),
        format,
        footprint.is_some(),
        single,
    )
}

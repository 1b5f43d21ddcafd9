use crate::{
    address::{
        lod::{LodRange, TexelFootprint, lod},
        wrap::{Axis, Wrap},
    },
    bound_texture::{BoundTexture, exact_format},
    filter::{self, Kernel, anisotropic::Axes},
    texel_data::{Chain, scaled},
    texture::Texture2d,
};
use core::str::FromStr;
use texmap_math::{footprint::Footprint, simd::Scalar};

/// Kernel of a bicubic filter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Cubic {
    /// Interpolating, sharp, overshoots (a = -1/2; Keys 1981).
    CatmullRom,
    /// B = C = 1/3: a little blur, little ringing (Mitchell and Netravali 1988).
    Mitchell,
    /// The smoothing cubic B-spline; never leaves the range of its texels.
    BSpline,
}

/// Choice of texels within one level, in the terms of OpenGL.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum TexelFilter {
    /// The texel that holds the coordinate.
    Nearest,
    /// Four texels weighted by distance.
    Linear,
}

/// Choice of levels, in the terms of OpenGL.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Mip {
    /// Level 0 only.
    None,
    /// The nearest level.
    Nearest,
    /// The two levels around, blended.
    Linear,
}

/// The rule by which texels make a colour.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Filter {
    /// The nearest texel of level 0.
    Nearest,
    /// Bilinear on level 0.
    Bilinear,
    /// Sixteen texels of level 0.
    Bicubic(Cubic),
    /// The nearest texel of the nearest level.
    MipNearest,
    /// Bilinear in the nearest level.
    BilinearMipNearest,
    /// Bilinear in the two levels around.
    #[default]
    Trilinear,
    /// Up to this many (2 to 16) trilinear probes along the long axis of the footprint, no closer than a texel.
    Anisotropic(u8),
    /// The elliptical weighted average (Heckbert 1989). Ellipses of half a width or height above `4 ratio + 4` texels, which only
    /// coarsest levels and textures without mips see, are bilinear look-ups instead, so that far surfaces cost no more.
    Ewa {
        /// Largest ratio of the ellipse's axes, 1 to 16.
        ratio: u8,
        /// Width of the pixel's Gaussian in hundredths of Heckbert's, 25 to 200 (others are cut to that): 75 is nearest to a box
        /// pixel, less is sharper and aliases.
        percent: u8,
    },
    /// The exact mean over the bounding rectangle of the footprint, each side at least a texel (Crow 1984), from the texture's
    /// [table](crate::Texture2d::with_summed_area); trilinear on textures without one. Bias and limits of levels hold for each side.
    SummedArea,
    /// Any of OpenGL's combinations: `mag` where the texture is magnified, else `min` with `mip`.
    Gl {
        /// Texels where one texel covers a pixel or more.
        mag: TexelFilter,
        /// Texels elsewhere.
        min: TexelFilter,
        /// Levels elsewhere.
        mip: Mip,
    },
}

impl Filter {
    /// The elliptical weighted average at Heckbert's width, with at most this ratio of axes (1 to 16).
    #[must_use]
    pub const fn ewa(ratio: u8) -> Self {
        Self::Ewa {
            ratio,
            percent: 100,
        }
    }

    /// True if look-ups ask for the size of a pixel, so that they need a footprint.
    #[must_use]
    pub fn reads_derivatives(self) -> bool {
        !matches!(self, Self::Nearest | Self::Bilinear | Self::Bicubic(_))
    }

    /// True if look-ups leave level 0, so that the texture needs a mip chain.
    #[must_use]
    pub fn reads_mips(self) -> bool {
        self.reads_derivatives()
            && !matches!(self, Self::Gl { mip: Mip::None, .. } | Self::SummedArea)
    }

    /// True if look-ups read the table of [`Texture2d::with_summed_area`](crate::Texture2d::with_summed_area).
    #[must_use]
    pub fn reads_summed_area(self) -> bool {
        self == Self::SummedArea
    }
}

/// Precision of filter weights.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Precision {
    /// f32 weights, exact logarithm, anisotropic probes on two blended levels.
    #[default]
    Exact,
    /// 8-bit weights on 8-bit results, integer logarithm, anisotropic probes on one level.
    Fast,
}

/// Shifts and limits the level of detail: `clamp(lod + bias, min, max)`; where `min` is above `max`, `max`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lod {
    /// Added to every level, cut to +-32; NaN reads as 0.
    pub bias: f32,
    /// Smallest level; NaN limits nothing.
    pub min: f32,
    /// Largest level; NaN limits nothing.
    pub max: f32,
}

impl Default for Lod {
    fn default() -> Self {
        Self {
            bias: 0.0,
            min: 0.0,
            max: 1000.0,
        }
    }
}

/// Everything about a look-up but the texture and the coordinates.
///
/// Results are linear light, premultiplied. No call allocates.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sampler {
    /// The rule by which texels make a colour.
    pub filter: Filter,
    /// Outside `[0, 1)` in u.
    pub wrap_u: Wrap,
    /// Outside `[0, 1)` in v.
    pub wrap_v: Wrap,
    /// Linear premultiplied colour of [`Wrap::ClampToBorder`]. NaN reads as 0, and values are cut to +-2^100.
    pub border: [f32; 4],
    /// Level of detail.
    pub lod: Lod,
    /// Precision of weights.
    pub precision: Precision,
}

impl Sampler {
    /// The colour at `uv` on level 0 (a pixel as large as a texel).
    pub fn sample(&self, t: &Texture2d<'_>, uv: [f32; 2]) -> [f32; 4] {
        self.sample_lod(t, uv, 0.0)
    }

    /// The colour at `uv` where one pixel step moves uv by the footprint.
    pub fn sample_grad(&self, t: &Texture2d<'_>, uv: [f32; 2], d: Footprint) -> [f32; 4] {
        filter::sample(self, &t.chain, uv, Some(d), 0.0)
    }

    /// The colour at `uv` with a level of detail of the caller's (bias and limits apply).
    ///
    /// An anisotropic or EWA filter takes a round footprint of that level, a summed area a square one.
    pub fn sample_lod(&self, t: &Texture2d<'_>, uv: [f32; 2], lod: f32) -> [f32; 4] {
        filter::sample(self, &t.chain, uv, None, self.limit_lod(lod))
    }

    /// The level of detail of a footprint: log2 of the longer column of the Jacobian in texels,
    /// plus bias, between the limits; not cut to the levels that the texture has.
    pub fn lod(&self, t: &Texture2d<'_>, d: Footprint) -> f32 {
        self.view(t).map_or(0.0, |view| {
            lod(Scalar, &view, &TexelFootprint::of(&view, d))
        })
    }

    /// Number of trilinear look-ups that an anisotropic filter takes for a footprint; 1 for the others.
    pub fn probes(&self, t: &Texture2d<'_>, d: Footprint) -> u32 {
        match self.filter {
            Filter::Anisotropic(_) => self.view(t).map_or(1, |view| {
                let axes = Axes::new(Scalar, &TexelFootprint::of(&view, d));
                axes.probes(Scalar, view.most) as u32
            }),
            _ => 1,
        }
    }

    /// The texture as one lane reads it.
    #[inline(always)]
    pub(crate) fn view<'a>(&self, t: &'a Texture2d<'_>) -> Option<BoundTexture<'a>> {
        let (kind, format) = (Kernel::of(self.filter), exact_format(&t.chain));
        BoundTexture::single(self, &t.chain, kind, format)
    }

    /// The wraps of both axes.
    #[inline(always)]
    pub(crate) fn axes(&self, t: &Chain<'_>) -> [Axis; 2] {
        let base = &t.levels[0];
        [
            Axis::new(self.wrap_u, base.width),
            Axis::new(self.wrap_v, base.height),
        ]
    }

    /// Bias and limits of levels, the bias within its range.
    pub(crate) fn lod_range(&self) -> LodRange {
        let Lod { bias, min, max } = self.lod;
        let bias = if bias.is_nan() {
            0.0
        } else {
            bias.clamp(-32.0, 32.0)
        };
        LodRange { bias, min, max }
    }

    /// The border in units of a format, finite in any of them.
    pub(crate) fn border_in(&self, units: f32) -> [f32; 4] {
        scaled(finite_border(self.border), units)
    }

    /// Bias and limits; NaN reads as 0.
    #[inline(always)]
    pub(crate) fn limit_lod(&self, lod: f32) -> f32 {
        let lod = if lod.is_nan() { 0.0 } else { lod };
        self.lod_range().limit(Scalar, lod)
    }
}

/// A border that is finite in the units of any format: within 2^100, NaN as 0.
pub(crate) fn finite_border(border: [f32; 4]) -> [f32; 4] {
    const MOST: f32 = 1.267_650_6e30;
    let mut out = [0.0; 4];
    for (out, c) in out.iter_mut().zip(border) {
        if !c.is_nan() {
            *out = c.clamp(-MOST, MOST);
        }
    }
    out
}

/// `nearest`, `bilinear`, `bicubic:mitchell`, `mip-nearest`, `bilinear-mip-nearest`, `trilinear`,
/// `anisotropic:16`, `ewa:8`, `ewa:8:0.75` (ratio and width), `summed-area`.
impl FromStr for Filter {
    type Err = &'static str;

    fn from_str(s: &str) -> Result<Self, Self::Err> {
        let (name, parameter) = s.split_once(':').map_or((s, None), |(n, p)| (n, Some(p)));
        let ratio = |text: Option<&str>, low: u8| match text {
            None => Ok(16),
            Some(p) => match p.parse::<u8>() {
                Ok(n) if (low..=16).contains(&n) => Ok(n),
                _ => Err("the ratio must be a whole number up to 16, as in anisotropic:16"),
            },
        };
        match (name, parameter) {
            ("nearest", None) => Ok(Self::Nearest),
            ("bilinear", None) => Ok(Self::Bilinear),
            ("mip-nearest", None) => Ok(Self::MipNearest),
            ("bilinear-mip-nearest", None) => Ok(Self::BilinearMipNearest),
            ("trilinear", None) => Ok(Self::Trilinear),
            ("summed-area", None) => Ok(Self::SummedArea),
            ("bicubic", None | Some("catmull-rom")) => Ok(Self::Bicubic(Cubic::CatmullRom)),
            ("bicubic", Some("mitchell")) => Ok(Self::Bicubic(Cubic::Mitchell)),
            ("bicubic", Some("b-spline")) => Ok(Self::Bicubic(Cubic::BSpline)),
            ("anisotropic", _) => ratio(parameter, 2).map(Self::Anisotropic),
            ("ewa", _) => {
                let (axes, width) = match parameter.and_then(|p| p.split_once(':')) {
                    Some((axes, width)) => (Some(axes), Some(width)),
                    None => (parameter, None),
                };
                Ok(Self::Ewa {
                    ratio: ratio(axes, 1)?,
                    percent: width.map_or(Ok(100), percent)?,
                })
            }
            _ => Err(
                "know nearest, bilinear, bicubic:catmull-rom|mitchell|b-spline, mip-nearest, \
                      bilinear-mip-nearest, trilinear, anisotropic:2..16, ewa:1..16[:0.25..2], \
                      summed-area",
            ),
        }
    }
}

/// Hundredths of a width of 0.25 to 2 with at most two decimals.
fn percent(width: &str) -> Result<u8, &'static str> {
    let hundredths = width.parse::<f32>().map_or(f32::NAN, |w| w * 100.0);
    let whole = texmap_math::float::floor_f32(hundredths + 0.5);
    if (25.0..=200.0).contains(&whole) && (hundredths - whole).abs() < 1e-3 {
        Ok(whole as u8)
    } else {
        Err("the width must be 0.25 to 2 in steps of 0.01, as in ewa:8:0.75")
    }
}

/// `repeat`, `mirrored-repeat`, `clamp-to-edge`, `clamp-to-border`, `mirror-clamp-to-edge`.
impl FromStr for Wrap {
    type Err = &'static str;

    fn from_str(s: &str) -> Result<Self, Self::Err> {
        match s {
            "repeat" => Ok(Self::Repeat),
            "mirrored-repeat" => Ok(Self::MirroredRepeat),
            "clamp-to-edge" => Ok(Self::ClampToEdge),
            "clamp-to-border" => Ok(Self::ClampToBorder),
            "mirror-clamp-to-edge" => Ok(Self::MirrorClampToEdge),
            _ => Err(
                "know repeat, mirrored-repeat, clamp-to-edge, clamp-to-border, mirror-clamp-to-edge",
            ),
        }
    }
}

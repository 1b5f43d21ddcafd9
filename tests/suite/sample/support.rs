//! Textures and numbers that the sampler's tests share.

use texmap_sample::{
    Alpha, ColorSpace, Cubic, Filter, Image, Mip, Origin, Sampler, TexelData, TexelFilter,
    Texture2d, Wrap,
};

pub(crate) const WRAPS: [Wrap; 5] = [
    Wrap::Repeat,
    Wrap::MirroredRepeat,
    Wrap::ClampToEdge,
    Wrap::ClampToBorder,
    Wrap::MirrorClampToEdge,
];

/// Every filter, the anisotropic ones at two ratios.
pub(crate) fn filters() -> Vec<Filter> {
    let mut all = vec![
        Filter::Nearest,
        Filter::Bilinear,
        Filter::Bicubic(Cubic::CatmullRom),
        Filter::Bicubic(Cubic::Mitchell),
        Filter::Bicubic(Cubic::BSpline),
        Filter::MipNearest,
        Filter::BilinearMipNearest,
        Filter::Trilinear,
        Filter::Anisotropic(2),
        Filter::Anisotropic(16),
        Filter::ewa(4),
        Filter::ewa(16),
        Filter::SummedArea,
    ];
    for mag in [TexelFilter::Nearest, TexelFilter::Linear] {
        for min in [TexelFilter::Nearest, TexelFilter::Linear] {
            for mip in [Mip::None, Mip::Nearest, Mip::Linear] {
                all.push(Filter::Gl { mag, min, mip });
            }
        }
    }
    all
}

/// The awkward sizes of the conformance suites.
pub(crate) const SIZES: [(u32, u32); 9] = [
    (63, 57),
    (4, 8),
    (32, 64),
    (3, 7),
    (31, 55),
    (127, 99),
    (1, 9),
    (8, 1),
    (1, 1),
];

/// Random words (PCG XSH RR, O'Neill 2014).
pub(crate) struct Random(u64);

impl Random {
    pub(crate) fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1)
    }

    pub(crate) fn word(&mut self) -> u32 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        let x = (((self.0 >> 18) ^ self.0) >> 27) as u32;
        x.rotate_right((self.0 >> 59) as u32)
    }

    /// Uniform in [0, 1) with 24 bits.
    pub(crate) fn unit(&mut self) -> f32 {
        (self.word() >> 8) as f32 / 16_777_216.0
    }

    pub(crate) fn range(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * self.unit()
    }
}

pub(crate) fn bilinear_clamped() -> Sampler {
    Sampler {
        filter: Filter::Bilinear,
        wrap_u: Wrap::ClampToEdge,
        wrap_v: Wrap::ClampToEdge,
        ..Sampler::default()
    }
}

pub(crate) fn float_texture(
    width: u32,
    height: u32,
    channels: u32,
    texels: &[f32],
) -> Texture2d<'static> {
    Texture2d::new(&Image {
        width,
        height,
        channels,
        texels: TexelData::F32(texels),
        color: ColorSpace::Linear,
        alpha: Alpha::Premultiplied,
        origin: Origin::TopLeft,
    })
    .expect("a good texture")
}

pub(crate) fn random_floats(width: u32, height: u32, seed: u64) -> Texture2d<'static> {
    let mut random = Random::new(seed);
    let texels: Vec<f32> = (0..width * height * 4).map(|_| random.unit()).collect();
    float_texture(width, height, 4, &texels)
}

pub(crate) fn random_bytes(width: u32, height: u32, seed: u64) -> Texture2d<'static> {
    let mut random = Random::new(seed);
    let texels: Vec<u8> = (0..width * height * 4)
        .map(|i| if i % 4 == 3 { 255 } else { random.word() as u8 })
        .collect();
    Texture2d::from_rgba8(width, height, texels, ColorSpace::Linear, Origin::TopLeft)
        .expect("a good texture")
}

pub(crate) fn largest_difference(a: [f32; 4], b: [f64; 4]) -> f64 {
    a.iter()
        .zip(b)
        .map(|(a, b)| (f64::from(*a) - b).abs())
        .fold(0.0, f64::max)
}

//! Decoded images to the words of a chain.

use crate::{
    error::SampleError,
    texel_data::{Chain, Format, Level, TexelData, Words, rounded_words, scaled},
    texture::{Alpha, ColorSpace, Image, Origin, TEXEL_LIMIT},
};
use alloc::{sync::Arc, vec, vec::Vec};
use texmap_math::color;

/// Words of a level 0: a chain adds at most a third (2D) to them, and gather indices are 31-bit.
pub(crate) const MAX_WORDS: usize = 3 << 28;

/// Checks, decodes and packs `depth` images that stand one after the other.
pub(crate) fn upload(image: &Image<'_>, depth: u32) -> Result<Chain<'static>, SampleError> {
    let Image { width, height, .. } = *image;
    let count = image.check(depth)?;
    let format = choose_format(image);
    if count * format.words() > MAX_WORDS {
        return Err(SampleError::TooLarge { width, height });
    }
    let mut words = Vec::with_capacity(count * format.words());
    let opaque = match image.texels {
        TexelData::U8(bytes) => push_bytes(image, bytes, format, &mut words),
        _ => push_values(image, count, format, &mut words)?,
    };
    let level = Level {
        offset: 0,
        width: width as i32,
        height: height as i32,
        depth: depth as i32,
    };
    Ok(Chain {
        words: Words::Owned(Arc::new(words)),
        encoded: None,
        format,
        levels: vec![level],
        flip: image.origin == Origin::BottomLeft,
        opaque,
        sums: None,
    })
}

/// Appends the texels of bytes; true if all are opaque.
fn push_bytes(image: &Image<'_>, bytes: &[u8], format: Format, words: &mut Vec<u32>) -> bool {
    let to = &mut Pushed {
        color: image.color,
        straight: image.alpha == Alpha::Straight,
        wide: format == Format::Rgba16,
        words,
        opaque: true,
    };
    match (image.channels, image.alpha) {
        (2, Alpha::Data) => to.push_all(bytes, |[x, y]| [x, y, 0, 255]),
        (1, _) => to.push_all(bytes, rgba::<1>),
        (2, _) => to.push_all(bytes, rgba::<2>),
        (3, _) => to.push_all(bytes, rgba::<3>),
        _ => to.push_all(bytes, rgba::<4>),
    }
    to.opaque
}

struct Pushed<'w> {
    color: ColorSpace,
    straight: bool,
    wide: bool,
    words: &'w mut Vec<u32>,
    opaque: bool,
}

impl Pushed<'_> {
    #[inline(always)]
    fn push_all<const N: usize>(&mut self, bytes: &[u8], rgba: impl Fn([u8; N]) -> [u8; 4]) {
        let (texels, (color, straight)) = (bytes.as_chunks().0, (self.color, self.straight));
        let mut least = 255;
        let texels = texels.iter().map(|texel| {
            let texel = rgba(*texel);
            least = least.min(texel[3]);
            texel
        });
        if self.wide {
            let words = texels.flat_map(|texel| {
                let [r, g, b, a] = texel16(texel, color, straight);
                [r | g << 16, b | a << 16]
            });
            self.words.extend(words);
        } else {
            // Straight alpha is 0 or 255 here.
            let words = texels.map(|texel| match texel {
                [.., 0] if straight => 0,
                texel => u32::from_le_bytes(texel),
            });
            self.words.extend(words);
        }
        self.opaque = least == 255;
    }
}

/// Red to alpha of a texel of 1 to 4 channels: one is grey, the second of two is opacity.
#[inline(always)]
pub(crate) fn rgba<const N: usize>(texel: [u8; N]) -> [u8; 4] {
    match texel[..] {
        [x] => [x, x, x, 255],
        [x, a] => [x, x, x, a],
        [r, g, b] => [r, g, b, 255],
        [r, g, b, a, ..] => [r, g, b, a],
        [] => [0; 4],
    }
}

/// A texel of bytes, red to alpha, in 16 bits of linear light, premultiplied where its alpha is straight.
#[inline(always)]
pub(crate) fn texel16([r, g, b, a]: [u8; 4], color: ColorSpace, straight: bool) -> [u32; 4] {
    // Opaque sRGB texels, as of photographs, need no more than a table.
    if color == ColorSpace::Srgb && (a == 255 || !straight) {
        let light = |c| u32::from(color::srgb8_to_linear16(c));
        return [light(r), light(g), light(b), u32::from(a) * 257];
    }
    let light = |c: u8| match color {
        ColorSpace::Srgb => color::srgb8_to_linear(c),
        ColorSpace::Linear => f32::from(c) / 255.0,
    };
    let a = f32::from(a) / 255.0;
    let opacity = if straight { a } else { 1.0 };
    let light = [light(r) * opacity, light(g) * opacity, light(b) * opacity];
    rounded_words(scaled([light[0], light[1], light[2], a], 65535.0), 65535.0)
}

/// Appends the texels of an image of 16 bits or floats; true if all are opaque.
fn push_values(
    image: &Image<'_>,
    count: usize,
    format: Format,
    words: &mut Vec<u32>,
) -> Result<bool, SampleError> {
    let mut opaque = true;
    let curve = Curve::new(image, count);
    for i in 0..count {
        let c = read_texel(image, &curve, i);
        // The sRGB curve and the opacity of float texels may take them beyond the limit.
        if !c.iter().all(|c| c.abs() <= TEXEL_LIMIT) {
            let (x, y) = (i as u32 % image.width, i as u32 / image.width);
            return Err(SampleError::Texel { x, y });
        }
        opaque &= c[3] >= 1.0;
        format.push(words, scaled(c, format.units()));
    }
    Ok(opaque)
}

/// Linear light of every 16-bit sRGB value, where an image has more texels than there are values; else empty.
struct Curve(Vec<f32>);

impl Curve {
    fn new(image: &Image<'_>, texels: usize) -> Self {
        let asked = image.color == ColorSpace::Srgb && matches!(image.texels, TexelData::U16(_));
        let count = if asked && texels > usize::from(u16::MAX) {
            1 << 16
        } else {
            0
        };
        let all = (0..=u16::MAX).take(count);
        Self(all.map(color::srgb16_to_linear).collect())
    }

    fn light(&self, c: u16) -> f32 {
        let found = self.0.get(usize::from(c)).copied();
        found.unwrap_or_else(|| color::srgb16_to_linear(c))
    }
}

/// Texel `i`, linear and premultiplied.
fn read_texel(image: &Image<'_>, curve: &Curve, i: usize) -> [f32; 4] {
    let n = image.channels as usize;
    let value = |k: usize| image.texels.value(i * n + k);
    let light = |k: usize| match (image.color, image.texels) {
        (ColorSpace::Linear, _) => value(k),
        (ColorSpace::Srgb, TexelData::U8(t)) => color::srgb8_to_linear(t[i * n + k]),
        (ColorSpace::Srgb, TexelData::U16(t)) => curve.light(t[i * n + k]),
        (ColorSpace::Srgb, TexelData::F32(t)) => color::srgb_to_linear(t[i * n + k]),
    };
    let [r, g, b, a] = match (n, image.alpha) {
        (1, _) => [light(0), light(0), light(0), 1.0],
        (2, Alpha::Data) => [light(0), light(1), 0.0, 1.0],
        (2, _) => [light(0), light(0), light(0), value(1)],
        (3, _) => [light(0), light(1), light(2), 1.0],
        _ => [light(0), light(1), light(2), value(3)],
    };
    if image.alpha == Alpha::Straight {
        [r * a, g * a, b * a, a]
    } else {
        [r, g, b, a]
    }
}

/// Bytes stay bytes when decoding and premultiplying change none of them.
pub(crate) fn choose_format(image: &Image<'_>) -> Format {
    match image.texels {
        TexelData::F32(_) if image.channels == 1 => Format::R32,
        TexelData::F32(_) => Format::Rgba32,
        TexelData::U16(_) => Format::Rgba16,
        TexelData::U8(_) if image.color == ColorSpace::Srgb => Format::Rgba16,
        TexelData::U8(t) => {
            let has_alpha = image.alpha == Alpha::Straight && image.channels.is_multiple_of(2);
            let n = image.channels as usize;
            let soft = |texel: &[u8]| !matches!(texel[n - 1], 0 | 255);
            if has_alpha && t.chunks_exact(n).any(soft) {
                Format::Rgba16
            } else {
                Format::Rgba8
            }
        }
    }
}

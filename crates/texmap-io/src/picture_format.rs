//! Formats of the picture files that are written, and the layout of their pixels. The ending of a name chooses the format.

use std::io::{self, Write};
use std::ops::AddAssign;
use std::path::Path;

use image::codecs::hdr::HdrEncoder;
use image::codecs::jpeg::JpegEncoder;
use image::codecs::webp::WebPEncoder;
use image::{ExtendedColorType, ImageEncoder};
use texmap_math::color;
use texmap_sample::ColorSpace;

use crate::open_exr::write_floats;
use crate::{IoError, atomic};

/// A format that pictures are written in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PictureFormat {
    /// Whole numbers of 8 or 16 bits from 0 to 1, straight alpha.
    Png,
    /// Radiance: linear light, 8 bits of mantissa that share an exponent, no alpha, nothing below 0.
    Hdr,
    /// OpenEXR: linear light as 32-bit floats, premultiplied alpha.
    Exr,
    /// Whole numbers of 8 bits from 0 to 1 at quality 90, no alpha.
    Jpeg,
    /// Whole numbers of 8 bits from 0 to 1, straight alpha, lossless.
    WebP,
}

impl PictureFormat {
    /// Every format.
    pub const ALL: [Self; 5] = [Self::Png, Self::Jpeg, Self::WebP, Self::Hdr, Self::Exr];

    /// The format that the ending of a name says, in capitals or not.
    #[must_use]
    pub fn of(path: &Path) -> Option<Self> {
        let ending = path.extension()?.to_str()?;
        let named = |format: &Self| {
            let mut names = format.endings().iter();
            names.any(|name| ending.eq_ignore_ascii_case(name))
        };
        Self::ALL.into_iter().find(named)
    }

    /// The ending of its names, without a dot.
    #[must_use]
    pub fn ending(self) -> &'static str {
        self.endings()[0]
    }

    /// All endings that its names may have, the usual one first.
    fn endings(self) -> &'static [&'static str] {
        match self {
            Self::Png => &["png"],
            Self::Hdr => &["hdr"],
            Self::Exr => &["exr"],
            Self::Jpeg => &["jpg", "jpeg"],
            Self::WebP => &["webp"],
        }
    }
}

/// Layout in memory of the pixels of a file, which are made of linear, premultiplied colours.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PixelCode {
    /// Red, green, blue and straight alpha of 8 bits, sRGB or as they are.
    Png8(ColorSpace),
    /// Red, green, blue and straight alpha of 16 bits, sRGB or as they are.
    Png16(ColorSpace),
    /// Red, green and blue of 8 bits over black, sRGB or as they are.
    Jpeg(ColorSpace),
    /// As [`Png8`](Self::Png8).
    WebP(ColorSpace),
    /// Red, green and blue over black, rounded to RGBE.
    Hdr,
    /// Red, green and blue over black.
    Exr,
    /// Red, green, blue and alpha, premultiplied.
    ExrAlpha,
}

/// Pixels that a file does not hold as they were.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Lost {
    /// Clipped at the largest value, by more than rounding.
    pub above: u64,
    /// Clipped at 0, by more than rounding.
    pub below: u64,
    /// Not opaque, in a file without alpha: kept as they look over black.
    pub transparent: u64,
}

impl Lost {
    /// True if the file holds every pixel as it is.
    #[must_use]
    pub fn nothing(&self) -> bool {
        *self == Self::default()
    }
}

impl AddAssign for Lost {
    fn add_assign(&mut self, other: Self) {
        self.above += other.above;
        self.below += other.below;
        self.transparent += other.transparent;
    }
}

/// The largest value that RGBE holds: 255/256 of 2^127.
const HDR_MOST: f32 = f32::from_bits(0x7eff_0000);

/// JPEG quality, out of 100; above it, files grow without a visible gain.
const JPEG_QUALITY: u8 = 90;

impl PixelCode {
    /// Bytes of a pixel.
    #[must_use]
    pub fn bytes(self) -> usize {
        match self {
            Self::Png8(_) | Self::WebP(_) => 4,
            Self::Jpeg(_) => 3,
            Self::Png16(_) => 8,
            Self::Hdr | Self::Exr => 12,
            Self::ExrAlpha => 16,
        }
    }

    fn format(self) -> PictureFormat {
        match self {
            Self::Png8(_) | Self::Png16(_) => PictureFormat::Png,
            Self::Jpeg(_) => PictureFormat::Jpeg,
            Self::WebP(_) => PictureFormat::WebP,
            Self::Hdr => PictureFormat::Hdr,
            Self::Exr | Self::ExrAlpha => PictureFormat::Exr,
        }
    }

    /// Encodes linear, premultiplied colours into as many times [`bytes`](Self::bytes). Colours and bytes beyond the shorter slice are
    /// left out. NaN becomes 0 in PNG and HDR.
    pub fn encode(self, colors: &[[f32; 4]], out: &mut [u8]) -> Lost {
        let mut lost = Lost::default();
        for (c, out) in colors.iter().zip(out.chunks_exact_mut(self.bytes())) {
            match self {
                Self::Png8(space) | Self::WebP(space) => {
                    let c = straight(*c);
                    lost.count(&c[..3], 1.0, 0.5 / 255.0);
                    let [r, g, b] = bytes([c[0], c[1], c[2]], space);
                    out.copy_from_slice(&[r, g, b, color::unit_to_u8(c[3])]);
                }
                Self::Jpeg(space) => {
                    let [r, g, b, a] = *c;
                    lost.count(&[r, g, b], 1.0, 0.5 / 255.0);
                    lost.transparent += u64::from(a < 1.0);
                    out.copy_from_slice(&bytes([r, g, b], space));
                }
                Self::Png16(space) => {
                    let c = straight(*c);
                    lost.count(&c[..3], 1.0, 0.5 / 65535.0);
                    let word = |c: f32| match space {
                        ColorSpace::Srgb => unit_to_u16(color::linear_to_srgb(c)),
                        ColorSpace::Linear => unit_to_u16(c),
                    };
                    let [r, g, b, a] = c;
                    let words = [word(r), word(g), word(b), unit_to_u16(a)];
                    out.copy_from_slice(words.map(u16::to_be_bytes).as_flattened());
                }
                Self::Hdr => {
                    let [r, g, b, a] = *c;
                    lost.count(&[r, g, b], HDR_MOST, 0.0);
                    lost.transparent += u64::from(a < 1.0);
                    let held = shared_exponent([r, g, b]);
                    out.copy_from_slice(held.map(f32::to_ne_bytes).as_flattened());
                }
                Self::Exr => {
                    let [r, g, b, a] = *c;
                    lost.transparent += u64::from(a < 1.0);
                    out.copy_from_slice([r, g, b].map(f32::to_ne_bytes).as_flattened());
                }
                Self::ExrAlpha => {
                    out.copy_from_slice(c.map(f32::to_ne_bytes).as_flattened());
                }
            }
        }
        lost
    }
}

impl Lost {
    /// Counts a pixel with values beyond 0 to `most` by more than `half` a step.
    fn count(&mut self, values: &[f32], most: f32, half: f32) {
        self.above += u64::from(values.iter().any(|c| *c > most + half));
        self.below += u64::from(values.iter().any(|c| *c < -half));
    }
}

fn bytes(c: [f32; 3], space: ColorSpace) -> [u8; 3] {
    c.map(|c| match space {
        ColorSpace::Srgb => color::linear_to_srgb8(c),
        ColorSpace::Linear => color::unit_to_u8(c),
    })
}

fn straight([r, g, b, a]: [f32; 4]) -> [f32; 4] {
    if a > 0.0 {
        [r / a, g / a, b / a, a]
    } else {
        [0.0, 0.0, 0.0, a]
    }
}

/// `[0, 1]` to 16 bits, nearest: clamped, NaN gives 0.
fn unit_to_u16(c: f32) -> u16 {
    // Conversions clamp.
    (f64::from(c) * 65535.0 + 0.5) as u16
}

/// The nearest colour whose channels are multiples of 1/256 of a power of two above the largest: RGBE keeps it as it is, while it would
/// cut others off.
fn shared_exponent(c: [f32; 3]) -> [f32; 3] {
    let c = c.map(|c| if c > 0.0 { c.min(HDR_MOST) } else { 0.0 });
    let largest = c[0].max(c[1]).max(c[2]);
    // 2^-119: below, RGBE has no eight bits.
    if largest < 1.504_632_8e-36 {
        return [0.0; 3];
    }
    // The power of two at or below the largest, over 128.
    let mut step = f32::from_bits(largest.to_bits() & 0x7f80_0000) / 128.0;
    let steps = |c: f32, step: f32| (c / step + 0.5) as u32;
    if steps(largest, step) > 255 {
        step *= 2.0;
    }
    c.map(|c| steps(c, step) as f32 * step)
}

/// Writes a picture, whole or not at all: `rows` gives its pixels as [`PixelCode::encode`] makes them, row by row from the top, any
/// number of bytes at a time. PNG is compressed as they come; the other formats are held in memory first.
///
/// # Errors
/// [`IoError::Write`], also when bytes are missing or left over, a side is zero, or `rows` fails.
pub fn write_pixels(
    path: &Path,
    code: PixelCode,
    size: (u32, u32),
    rows: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), IoError> {
    atomic::write(path, |out| encode(out, code, size, &mut atomic::once(rows)))
}

/// The encoders are compiled once for all rows.
fn encode(
    out: &mut dyn Write,
    code: PixelCode,
    (width, height): (u32, u32),
    rows: &mut dyn FnMut(&mut dyn Write) -> io::Result<()>,
) -> io::Result<()> {
    let depth = match code {
        PixelCode::Png8(_) => png::BitDepth::Eight,
        PixelCode::Png16(_) => png::BitDepth::Sixteen,
        _ => return encode_whole(out, code, (width, height), rows),
    };
    let mut encoder = png::Encoder::new(out, width, height);
    encoder.set_color(png::ColorType::Rgba);
    encoder.set_depth(depth);
    encoder.set_compression(png::Compression::Fast);
    encoder.set_filter(png::Filter::Paeth);
    let mut writer = encoder.write_header()?;
    let mut stream = writer.stream_writer()?;
    rows(&mut stream)?;
    stream.finish()?;
    Ok(writer.finish()?)
}

fn encode_whole(
    out: &mut dyn Write,
    code: PixelCode,
    (width, height): (u32, u32),
    rows: &mut dyn FnMut(&mut dyn Write) -> io::Result<()>,
) -> io::Result<()> {
    let mut pixels: Vec<u8> = Vec::new();
    rows(&mut pixels)?;
    let expected = code.bytes() as u64 * u64::from(width) * u64::from(height);
    if expected == 0 || pixels.len() as u64 != expected {
        let problem = format!("{} bytes for {width} x {height} pixels", pixels.len());
        return Err(io::Error::new(io::ErrorKind::InvalidInput, problem));
    }
    let kind = match code {
        PixelCode::ExrAlpha => ExtendedColorType::Rgba32F,
        PixelCode::Jpeg(_) => ExtendedColorType::Rgb8,
        PixelCode::Png8(_) | PixelCode::WebP(_) => ExtendedColorType::Rgba8,
        PixelCode::Png16(_) => ExtendedColorType::Rgba16,
        PixelCode::Hdr | PixelCode::Exr => ExtendedColorType::Rgb32F,
    };
    let written = match code.format() {
        PictureFormat::Hdr => HdrEncoder::new(out).write_image(&pixels, width, height, kind),
        PictureFormat::Jpeg => {
            let encoder = JpegEncoder::new_with_quality(out, JPEG_QUALITY);
            encoder.write_image(&pixels, width, height, kind)
        }
        PictureFormat::WebP => {
            WebPEncoder::new_lossless(out).write_image(&pixels, width, height, kind)
        }
        PictureFormat::Png | PictureFormat::Exr => {
            return write_floats(out, (width, height), &pixels, code.bytes() / 4);
        }
    };
    written.map_err(io::Error::other)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn endings_say_the_format() {
        let of = |name: &str| PictureFormat::of(Path::new(name));
        assert_eq!(of("a.b.PNG"), Some(PictureFormat::Png));
        assert_eq!(of("sky.Hdr"), Some(PictureFormat::Hdr));
        assert_eq!(of("exr.exr"), Some(PictureFormat::Exr));
        assert_eq!(of("a.jpeg"), Some(PictureFormat::Jpeg));
        for other in ["a.bmp", "png", "a.png.gz", "a.", ""] {
            assert_eq!(of(other), None, "{other}");
        }
    }

    #[test]
    fn lost_values_are_counted_and_rounding_is_not() {
        let colors = [
            [1.001, 0.5, 0.0, 1.0],
            [1.01, -0.01, 0.0, 1.0],
            // Premultiplied: 1.2 of straight red.
            [0.6, 0.0, 0.0, 0.5],
            [0.0; 4],
        ];
        let mut out = [0; 64];
        let code = PixelCode::Png8(ColorSpace::Linear);
        let lost = code.encode(&colors, &mut out);
        assert_eq!((lost.above, lost.below, lost.transparent), (2, 1, 0));
        assert_eq!(out[..4], [255, 128, 0, 255]);
        assert_eq!(out[8..16], [255, 0, 0, 128, 0, 0, 0, 0]);
        let lost = PixelCode::Hdr.encode(&colors, &mut out);
        assert_eq!((lost.above, lost.below, lost.transparent), (0, 1, 2));
        assert!(PixelCode::ExrAlpha.encode(&colors, &mut out).nothing());
    }

    #[test]
    fn sixteen_bits_come_back_in_either_space() {
        let mut out = [0; 8];
        for code in (0..=u16::MAX).step_by(7) {
            let light = color::srgb16_to_linear(code);
            PixelCode::Png16(ColorSpace::Srgb).encode(&[[light, light, light, 1.0]], &mut out);
            assert_eq!(u16::from_be_bytes([out[0], out[1]]), code);
            let plain = f32::from(code) / 65535.0;
            PixelCode::Png16(ColorSpace::Linear).encode(&[[plain, 0.0, 0.0, 1.0]], &mut out);
            assert_eq!(u16::from_be_bytes([out[0], out[1]]), code);
        }
    }

    /// The nearest colour with one exponent is at most half a step of its largest channel away, and RGBE keeps it.
    #[test]
    fn shared_exponents_round() {
        let mut seed = 5_u32;
        for _ in 0..20_000 {
            let mut next = || {
                seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                (seed >> 8) as f32 / 16_777_216.0
            };
            let scale = f32::from_bits((((next() * 200.0) as u32) + 20) << 23);
            let c = [next() * scale, next() * scale, next() * scale];
            let largest = c[0].max(c[1]).max(c[2]);
            let held = shared_exponent(c);
            for (c, held) in c.iter().zip(held) {
                assert!((c - held).abs() <= largest / 255.0, "{c} {held}");
            }
            assert_eq!(shared_exponent(held), held);
        }
        assert_eq!(shared_exponent([0.999, 0.5, 0.0]), [1.0, 0.5, 0.0]);
        let most = shared_exponent([f32::MAX, f32::NAN, -1.0]);
        assert_eq!(most, [HDR_MOST, 0.0, 0.0]);
    }

    #[test]
    fn every_format_comes_back() {
        let dir = tempfile::tempdir().unwrap();
        let colors: Vec<[f32; 4]> = (0..20 * 3)
            .map(|i| [i as f32 / 64.0, 0.25, 1.0 - i as f32 / 64.0, 1.0])
            .collect();
        for code in [
            PixelCode::Png8(ColorSpace::Srgb),
            PixelCode::Png16(ColorSpace::Srgb),
            PixelCode::Jpeg(ColorSpace::Srgb),
            PixelCode::WebP(ColorSpace::Srgb),
            PixelCode::Hdr,
            PixelCode::Exr,
            PixelCode::ExrAlpha,
        ] {
            let path = dir.path().join(format!("a.{}", code.format().ending()));
            let mut bytes = vec![0; colors.len() * code.bytes()];
            assert!(code.encode(&colors, &mut bytes).nothing());
            let write = |bytes: &[u8]| {
                write_pixels(&path, code, (20, 3), |out| {
                    bytes.chunks(7).try_for_each(|part| out.write_all(part))
                })
            };
            write(&bytes).unwrap();
            let (texture, _) = crate::image_io::read_texture(&path, ColorSpace::Srgb).unwrap();
            for (i, c) in (0..).zip(&colors) {
                let back = texture.texel(0, i % 20, i / 20).unwrap();
                let tolerance = match code {
                    PixelCode::Jpeg(_) => 0.06,
                    _ => 0.005,
                };
                for (a, b) in c.iter().zip(back) {
                    assert!((a - b).abs() < tolerance, "{code:?} {c:?} {back:?}");
                }
                if code.format() == PictureFormat::Exr {
                    assert_eq!(*c, back);
                }
            }
            let old = std::fs::read(&path).unwrap();
            assert_eq!(
                write(&bytes[code.bytes()..]).unwrap_err().code(),
                "write-failed"
            );
            assert_eq!(std::fs::read(&path).unwrap(), old, "the old file is left");
        }
    }
}

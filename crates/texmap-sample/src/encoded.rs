//! Images that stay as their files hold them: decoded at each look-up instead of once.

use crate::{
    error::SampleError,
    texels::{Chain, Format, Level, Texels, Words},
    texture::{Alpha, ColorSpace, Image, Origin, Texture2d, choose_format, read_texel, upload},
};
use alloc::{sync::Arc, vec, vec::Vec};
use texmap_math::color;

/// Bytes of a picture as level 0 of a chain of 16-bit levels.
#[derive(Clone, Debug)]
pub(crate) struct Encoded {
    bytes: Arc<Vec<u8>>,
    /// All but the bytes.
    shape: Image<'static>,
}

impl Encoded {
    /// Unscaled texel `i`, as [`Format::Rgba16`] would hold it. Out of line: every filter fetches texels.
    #[inline(never)]
    pub(crate) fn fetch(&self, i: usize) -> [f32; 4] {
        let n = self.shape.channels as usize;
        let light = |c: u8| f32::from(color::srgb8_to_linear16(c));
        // What photographs hold needs no more than a table.
        match self.bytes[i * n..(i + 1) * n] {
            [r, g, b] | [r, g, b, 255] if self.shape.color == ColorSpace::Srgb => {
                [light(r), light(g), light(b), 65535.0]
            }
            _ => {
                let image = Image {
                    texels: Texels::U8(&self.bytes),
                    ..self.shape
                };
                Format::Rgba16.rounded(read_texel(&image, i))
            }
        }
    }
}

impl Texture2d<'static> {
    /// As [`Texture2d::new`], with the same values, but 8-bit colours that would take 16 bits a channel are kept as they are: 1 to 4
    /// bytes a texel instead of 8. Each look-up decodes its texels, one place at a time, which takes several times as long; for large
    /// pictures that are read about once. Straight alpha, rows top to bottom.
    ///
    /// # Errors
    /// As [`Texture2d::new`].
    pub fn from_encoded8(
        (width, height): (u32, u32),
        channels: u32,
        texels: Vec<u8>,
        color: ColorSpace,
        origin: Origin,
    ) -> Result<Self, SampleError> {
        let shape = Image {
            width,
            height,
            channels,
            texels: Texels::U8(&[]),
            color,
            alpha: Alpha::Straight,
            origin,
        };
        let given = Image {
            texels: Texels::U8(&texels),
            ..shape
        };
        given.check(1)?;
        if choose_format(&given) != Format::Rgba16 {
            return Ok(Self {
                chain: upload(&given, 1)?,
            });
        }
        let n = channels as usize;
        let opaque = n % 2 == 1 || texels.chunks_exact(n).all(|texel| texel[n - 1] == 255);
        let level = Level {
            offset: Level::ENCODED,
            width: width as i32,
            height: height as i32,
            depth: 1,
        };
        let encoded = Encoded {
            bytes: Arc::new(texels),
            shape,
        };
        Ok(Self {
            chain: Chain {
                words: Words::Owned(Arc::new(Vec::new())),
                encoded: Some(encoded),
                format: Format::Rgba16,
                levels: vec![level],
                flip: origin == Origin::BottomLeft,
                opaque,
            },
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Filter, Sampler, sample_slice};
    use texmap_math::{Footprint, Level};

    /// 13 x 7 texels, every byte another.
    fn bytes(channels: u32) -> Vec<u8> {
        (0..13 * 7 * channels)
            .map(|i| (i * 151 % 256) as u8)
            .collect()
    }

    fn both(channels: u32, color: ColorSpace) -> [Texture2d<'static>; 2] {
        let given = bytes(channels);
        let kept =
            Texture2d::from_encoded8((13, 7), channels, given.clone(), color, Origin::BottomLeft);
        let image = Image {
            width: 13,
            height: 7,
            channels,
            texels: Texels::U8(&given),
            color,
            alpha: Alpha::Straight,
            origin: Origin::BottomLeft,
        };
        [kept.unwrap(), Texture2d::new(&image).unwrap()]
    }

    #[test]
    fn bytes_that_stay_have_the_values_of_words() {
        for channels in 1..=4 {
            for color in [ColorSpace::Srgb, ColorSpace::Linear] {
                let [kept, words] = both(channels, color).map(Texture2d::with_mips);
                assert_eq!(kept.levels(), words.levels());
                assert_eq!(kept.has_alpha(), words.has_alpha());
                for level in 0..words.levels() {
                    let (w, h) = words.level_size(level).unwrap();
                    for (x, y) in (0..h).flat_map(|y| (0..w).map(move |x| (x, y))) {
                        let (a, b) = (kept.texel(level, x, y), words.texel(level, x, y));
                        assert_eq!(a, b, "{channels} {color:?} {level} {x} {y}");
                    }
                }
                for filter in [
                    Filter::Nearest,
                    Filter::Bilinear,
                    Filter::Trilinear,
                    Filter::Ewa(8),
                ] {
                    let sampler = Sampler {
                        filter,
                        ..Sampler::default()
                    };
                    let u: Vec<f32> = (0..64).map(|i| i as f32 * 0.037 - 0.4).collect();
                    let v: Vec<f32> = (0..64).map(|i| i as f32 * -0.051 + 1.3).collect();
                    let grads = vec![Footprint::new(0.2, 0.03, -0.05, 0.3); 64];
                    let look = |t| {
                        let mut out = vec![[0.0; 4]; 64];
                        sample_slice(Level::new(), &sampler, t, &u, &v, Some(&grads), &mut out)
                            .unwrap();
                        out
                    };
                    assert_eq!(look(&kept), look(&words), "{channels} {color:?} {filter:?}");
                }
            }
        }
    }

    #[test]
    fn a_cut_out_keeps_its_coverage() {
        let [kept, words] = both(4, ColorSpace::Srgb).map(|t| t.with_coverage_mips(0.5));
        for level in 0..words.levels() {
            assert_eq!(kept.texel(level, 0, 0), words.texel(level, 0, 0));
        }
    }

    /// The mutant "decode after filter": means of bytes are not means of light.
    #[test]
    fn texels_are_decoded_before_they_are_mixed() {
        let texels = vec![0, 0, 0, 255, 255, 255];
        let t = Texture2d::from_encoded8((2, 1), 3, texels, ColorSpace::Srgb, Origin::TopLeft);
        let sampler = Sampler {
            filter: Filter::Bilinear,
            ..Sampler::default()
        };
        let middle = sampler.sample(&t.unwrap(), [0.5, 0.5])[0];
        assert!((middle - 0.5).abs() < 1e-5, "{middle}");
    }

    #[test]
    fn a_wrong_length_is_an_error() {
        let short =
            Texture2d::from_encoded8((2, 2), 3, vec![0; 11], ColorSpace::Srgb, Origin::TopLeft);
        assert_eq!(
            short.unwrap_err(),
            SampleError::Length {
                expected: 12,
                got: 11
            }
        );
        let none = Texture2d::from_encoded8((2, 2), 0, vec![], ColorSpace::Srgb, Origin::TopLeft);
        assert_eq!(none.unwrap_err(), SampleError::Channels(0));
    }
}

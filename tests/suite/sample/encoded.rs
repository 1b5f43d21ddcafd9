//! Textures that keep their bytes and decode them at each look-up.

use crate::support::filters;
use texmap_math::{Footprint, Level};
use texmap_sample::{
    Alpha, ColorSpace, Filter, Image, Origin, SampleError, Sampler, TexelData, Texture2d,
    sample_slice,
};

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
        texels: TexelData::U8(&given),
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
            let [kept, words] = both(channels, color).map(|t| t.with_mips().with_summed_area());
            assert_eq!(kept.levels(), words.levels());
            assert_eq!(kept.has_alpha(), words.has_alpha());
            for level in 0..words.levels() {
                let (w, h) = words.level_size(level).unwrap();
                for (x, y) in (0..h).flat_map(|y| (0..w).map(move |x| (x, y))) {
                    let (a, b) = (kept.texel(level, x, y), words.texel(level, x, y));
                    assert_eq!(a, b, "{channels} {color:?} {level} {x} {y}");
                }
            }
            for filter in filters() {
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
    let short = Texture2d::from_encoded8((2, 2), 3, vec![0; 11], ColorSpace::Srgb, Origin::TopLeft);
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

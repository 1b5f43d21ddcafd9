//! Buffers of the crate `image` in and out.

use image::{Rgba32FImage, RgbaImage};
use texmap_sample::{Alpha, ColorSpace, Image, Origin, SampleError, TexelData, Texture2d};

/// A texture of 8-bit texels with straight alpha; the first row of the image is `v = 0`.
///
/// # Errors
/// A side of 0 or beyond the sampler's limit.
pub fn texture_from_rgba8(
    image: &RgbaImage,
    color: ColorSpace,
) -> Result<Texture2d<'static>, SampleError> {
    let (width, height) = image.dimensions();
    Texture2d::from_rgba8(
        width,
        height,
        image.as_raw().clone(),
        color,
        Origin::TopLeft,
    )
}

/// A texture of f32 texels in linear light with straight alpha; the first row of the image is `v = 0`.
///
/// # Errors
/// A side of 0 or beyond the sampler's limit, a value that is not finite.
pub fn texture_from_f32(image: &Rgba32FImage) -> Result<Texture2d<'static>, SampleError> {
    let (width, height) = image.dimensions();
    Texture2d::new(&Image {
        width,
        height,
        channels: 4,
        texels: TexelData::F32(image.as_raw()),
        color: ColorSpace::Linear,
        alpha: Alpha::Straight,
        origin: Origin::TopLeft,
    })
}

/// A picture as a buffer of the crate `image`.
#[cfg(feature = "render")]
pub trait ToImage {
    /// The same bytes: sRGB with straight alpha under the default colour mode.
    fn to_image(&self) -> RgbaImage;
}

#[cfg(feature = "render")]
impl ToImage for texmap_render::Frame {
    fn to_image(&self) -> RgbaImage {
        RgbaImage::from_raw(self.width, self.height, self.rgba.clone()).unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use texmap_math::color::srgb8_to_linear;

    #[test]
    fn texels_keep_their_places_and_values() {
        let image = RgbaImage::from_fn(3, 2, |x, y| {
            image::Rgba([x as u8 * 100, y as u8 * 50, 7, 255])
        });
        let texture = texture_from_rgba8(&image, ColorSpace::Srgb).expect("a valid size");
        let [r, g, ..] = texture.texel(0, 2, 1).expect("inside");
        assert!((r - srgb8_to_linear(200)).abs() < 1e-4 && (g - srgb8_to_linear(50)).abs() < 1e-4);
        let image =
            Rgba32FImage::from_fn(2, 1, |x, _| image::Rgba([x as f32 * 40.0, 0.5, -1.0, 1.0]));
        let texture = texture_from_f32(&image).expect("a valid size");
        assert_eq!(texture.texel(0, 1, 0), Some([40.0, 0.5, -1.0, 1.0]));
        assert!(texture_from_rgba8(&RgbaImage::new(0, 4), ColorSpace::Srgb).is_err());
    }
}

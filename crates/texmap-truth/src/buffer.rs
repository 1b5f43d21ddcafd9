//! Images and arrays read for comparison: what `texmap diff` and `texmap hash` work on.

use std::borrow::Cow;
use std::path::Path;

use texmap_io::IoError;
use texmap_io::image_io::{Depth, read_image};
use texmap_io::npy::{self, Data};
use texmap_render::hash_pixels;

use crate::metrics::{Metrics, MetricsError, Shape, check, measure};
use crate::picture::Picture;
use crate::ssim::ssim;
use crate::strip::heat;

/// The decoded values of a file, kept in the file's own depth.
#[derive(Clone, Debug)]
pub struct Buffer {
    /// Size; an array of more than three axes has its first ones as rows.
    pub shape: Shape,
    /// The largest value of the format: 1 for images of whole numbers (their codes are divided by 255 or 65535), else the largest finite
    /// magnitude that the colours of the image or the array hold.
    pub peak: f64,
    values: Values,
    /// Lengths of an array's axes.
    axes: Vec<usize>,
}

/// The difference of two buffers.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// Figures of all values; of red, green and blue for images.
    pub values: Metrics,
    /// Figures of the alpha of images, unless both are opaque all over.
    pub alpha: Option<Metrics>,
    /// Mean structural similarity ([`ssim`]) of the values, where there is one.
    pub ssim: Option<f64>,
}

impl Comparison {
    /// Nothing beyond the limit, and no value that is finite in one of them only.
    #[must_use]
    pub fn passes(&self) -> bool {
        self.values.passes() && self.alpha.is_none_or(|alpha| alpha.passes())
    }
}

/// The meaning of the values of a buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Meaning {
    /// The codes of an image of whole numbers, sRGB.
    Codes,
    /// The linear light of an image of floats (HDR, EXR).
    Light,
    /// The numbers of an array.
    Array,
}

#[derive(Clone, Debug)]
enum Values {
    Image(Depth),
    Array(Data),
}

impl Buffer {
    /// Reads a `.npy` array, or else an image of any format that textures may have.
    ///
    /// # Errors
    /// If the file cannot be read or decoded.
    pub fn read(path: &Path) -> Result<Self, IoError> {
        if path
            .extension()
            .is_some_and(|e| e.eq_ignore_ascii_case("npy"))
        {
            return Ok(Self::of_array(npy::read(path)?));
        }
        let image = read_image(path)?;
        let (width, height) = (image.width as usize, image.height as usize);
        Ok(Self::image(width, height, image.texels))
    }

    fn image(width: usize, height: usize, texels: Depth) -> Self {
        let mut this = Self {
            shape: Shape {
                width,
                height,
                channels: 4,
            },
            peak: 1.0,
            values: Values::Image(texels),
            axes: Vec::new(),
        };
        if this.meaning() == Meaning::Light {
            this.peak = this.largest((0..this.len()).filter(|i| i % 4 != 3));
        }
        this
    }

    /// The lengths of the axes of an array, the first of which [`shape`](Self::shape) has as rows; empty for an image.
    #[must_use]
    pub fn axes(&self) -> &[usize] {
        &self.axes
    }

    /// The meaning of the values.
    #[must_use]
    pub fn meaning(&self) -> Meaning {
        match &self.values {
            Values::Image(Depth::F32(_)) => Meaning::Light,
            Values::Image(_) => Meaning::Codes,
            Values::Array(_) => Meaning::Array,
        }
    }

    /// The largest finite magnitude of these values.
    fn largest(&self, indices: impl Iterator<Item = usize>) -> f64 {
        indices
            .map(|i| self.value(i).abs())
            .filter(|v| v.is_finite())
            .fold(0.0, f64::max)
    }

    /// An image as [`read`](Self::read) takes it from a file: four values a pixel, rows top to bottom. `None` unless that is their number.
    #[must_use]
    pub fn of_image(width: usize, height: usize, texels: Depth) -> Option<Self> {
        let expected = width.checked_mul(height)?.checked_mul(4)?;
        let found = match &texels {
            Depth::U8(t) => t.len(),
            Depth::U16(t) => t.len(),
            Depth::F32(t) => t.len(),
        };
        (found == expected).then(|| Self::image(width, height, texels))
    }

    /// The values of an array, as [`read`](Self::read) takes them from a `.npy` file.
    #[must_use]
    pub fn of_array(array: npy::Array) -> Self {
        let shape = match array.shape.as_slice() {
            [] => Shape {
                width: 1,
                height: 1,
                channels: 1,
            },
            [width] => Shape {
                width: *width,
                height: 1,
                channels: 1,
            },
            [height, width] => Shape {
                width: *width,
                height: *height,
                channels: 1,
            },
            [rows @ .., width, channels] => Shape {
                width: *width,
                height: rows.iter().product(),
                channels: *channels,
            },
        };
        let mut this = Self {
            shape,
            peak: 0.0,
            values: Values::Array(array.data),
            axes: array.shape,
        };
        this.peak = this.largest(0..this.len());
        this
    }

    fn len(&self) -> usize {
        match &self.values {
            Values::Image(Depth::U8(v)) | Values::Array(Data::U8(v)) => v.len(),
            Values::Image(Depth::U16(v)) | Values::Array(Data::U16(v)) => v.len(),
            Values::Image(Depth::F32(v)) | Values::Array(Data::F32(v)) => v.len(),
            Values::Array(Data::U32(v)) => v.len(),
        }
    }

    /// A value, counted as they are interleaved: 0 to 1 for images of whole numbers, else what is written.
    ///
    /// # Panics
    /// Beyond the last one that `shape` has.
    #[must_use]
    pub fn value(&self, index: usize) -> f64 {
        match &self.values {
            Values::Image(Depth::U8(v)) => f64::from(v[index]) / 255.0,
            Values::Image(Depth::U16(v)) => f64::from(v[index]) / 65535.0,
            Values::Image(Depth::F32(v)) | Values::Array(Data::F32(v)) => v[index].into(),
            Values::Array(Data::U8(v)) => v[index].into(),
            Values::Array(Data::U16(v)) => v[index].into(),
            Values::Array(Data::U32(v)) => v[index].into(),
        }
    }

    /// [`hash_pixels`] of the width, the height and the values as little-endian bytes of the file's own depth.
    /// For an 8-bit image it is the `pixel_hash` of `render --json`.
    #[must_use]
    pub fn hash(&self) -> String {
        let bytes: Cow<'_, [u8]> = match &self.values {
            Values::Image(Depth::U8(v)) | Values::Array(Data::U8(v)) => v.into(),
            Values::Image(Depth::U16(v)) | Values::Array(Data::U16(v)) => {
                v.iter().flat_map(|x| x.to_le_bytes()).collect()
            }
            Values::Image(Depth::F32(v)) | Values::Array(Data::F32(v)) => {
                v.iter().flat_map(|x| x.to_le_bytes()).collect()
            }
            Values::Array(Data::U32(v)) => v.iter().flat_map(|x| x.to_le_bytes()).collect(),
        };
        let side = |n: usize| u32::try_from(n).unwrap_or(u32::MAX);
        hash_pixels(side(self.shape.width), side(self.shape.height), &bytes)
    }

    /// Compares with the expected values; `limit` is the largest difference that does not count as over.
    ///
    /// # Errors
    /// If the sizes differ or are empty.
    pub fn compare(&self, expected: &Self, limit: f64) -> Result<Comparison, MetricsError> {
        check(expected.shape, expected.len(), self.len())?;
        let pair = |index: usize| (expected.value(index), self.value(index));
        let peak = expected.peak.max(self.peak);
        let shape = expected.shape;
        let image = |buffer: &Self| buffer.meaning() != Meaning::Array;
        if !(image(self) && image(expected)) {
            return Ok(Comparison {
                values: measure(shape, limit, (0..self.len()).map(pair)),
                alpha: None,
                ssim: ssim(shape, shape.channels, peak, pair),
            });
        }
        let pixels = shape.width * shape.height;
        let part = |channels: usize| Shape { channels, ..shape };
        let colors = (0..3 * pixels).map(|i| pair(i / 3 * 4 + i % 3));
        let alphas = (0..pixels).map(|i| pair(4 * i + 3));
        let opaque = alphas.clone().all(|(e, a)| e == 1.0 && a == 1.0);
        Ok(Comparison {
            values: measure(part(3), limit, colors),
            alpha: (!opaque).then(|| {
                let mut alpha = measure(part(1), limit, alphas);
                for place in [&mut alpha.max_at, &mut alpha.non_finite_at] {
                    place.iter_mut().for_each(|place| place.channel = 3);
                }
                alpha
            }),
            ssim: ssim(shape, 3, peak, pair),
        })
    }

    /// The differences as heat: black where equal, white at `white` and above, magenta where only one value is
    /// finite. `None` when the sizes differ.
    pub fn heat(&self, expected: &Self, white: f64) -> Option<Picture> {
        let Shape {
            width,
            height,
            channels,
        } = self.shape;
        let side = |n: usize| u32::try_from(n).ok();
        let mut picture = Picture::new(side(width)?, side(height)?, [0, 0, 0, 255]);
        if self.shape != expected.shape || channels == 0 {
            return None;
        }
        let off = |i: usize| {
            let (e, a) = (expected.value(i), self.value(i));
            match (
                e == a || e.is_nan() && a.is_nan(),
                e.is_finite() && a.is_finite(),
            ) {
                (true, _) => 0.0,
                (false, true) => (a - e).abs() / white,
                (false, false) => f64::NAN,
            }
        };
        for index in 0..width * height {
            let values = index * channels..(index + 1) * channels;
            let worst = values.map(off).fold(0.0, |w: f64, d| {
                if w.is_nan() || d.is_nan() {
                    f64::NAN
                } else {
                    w.max(d)
                }
            });
            picture.set((index % width) as i64, (index / width) as i64, heat(worst));
        }
        Some(picture)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn array(shape: &[usize], values: &[f32]) -> Buffer {
        Buffer::of_array(npy::Array {
            shape: shape.to_vec(),
            data: Data::F32(values.to_vec()),
        })
    }

    #[test]
    fn arrays_of_any_rank_have_a_shape() {
        let shape = |axes: &[usize]| {
            let Shape {
                width,
                height,
                channels,
            } = array(axes, &vec![0.0; axes.iter().product()]).shape;
            (width, height, channels)
        };
        assert_eq!(shape(&[]), (1, 1, 1));
        assert_eq!(shape(&[5]), (5, 1, 1));
        assert_eq!(shape(&[2, 5]), (5, 2, 1));
        assert_eq!(shape(&[2, 3, 5, 4]), (5, 6, 4));
    }

    #[test]
    fn heat_and_figures_show_the_one_value_that_differs() {
        let a = array(&[2, 2], &[0.0, 1.0, f32::NAN, 3.0]);
        let b = array(&[2, 2], &[0.0, 1.5, f32::NAN, 3.0]);
        let found = b.compare(&a, 0.1).unwrap();
        let metrics = found.values;
        assert_eq!(
            (metrics.over_limit, metrics.max, metrics.non_finite),
            (1, 0.5, 0)
        );
        assert!(metrics.holes == 1 && found.alpha.is_none() && found.ssim.is_none());
        let heat = b.heat(&a, 0.5).unwrap();
        assert_eq!(heat.get(1, 0), [255, 255, 255, 255]);
        assert_eq!(
            (heat.get(0, 0), heat.get(0, 1)),
            ([0, 0, 0, 255], [0, 0, 0, 255])
        );
        assert!(a.heat(&array(&[4], &[0.0; 4]), 1.0).is_none());
        assert!(a.compare(&array(&[4, 2], &[0.0; 8]), 0.0).is_err());
    }

    #[test]
    fn codes_of_any_depth_count_from_0_to_1_and_alpha_apart() {
        let image = |texels| Buffer::of_image(1, 1, texels);
        let bytes = image(Depth::U8(vec![255, 0, 51, 255])).unwrap();
        let words = image(Depth::U16(vec![65535, 0, 13107, 0])).unwrap();
        let found = words.compare(&bytes, 0.0).unwrap();
        assert_eq!((found.values.max, found.values.over_limit), (0.0, 0));
        assert_eq!(found.alpha.map(|alpha| alpha.max), Some(1.0));
        let light = image(Depth::F32(vec![3.0, 0.0, 0.5, 9.0])).unwrap();
        assert_eq!((light.peak, light.meaning()), (3.0, Meaning::Light));
        assert!(image(Depth::U8(vec![0; 3])).is_none());
    }

    #[test]
    fn hashes_tell_shape_depth_and_values_apart() {
        let bytes = Buffer::of_array(npy::Array {
            shape: vec![2, 2],
            data: Data::U8(vec![0; 4]),
        });
        let wide = array(&[1, 4], &[0.0; 4]);
        let square = array(&[2, 2], &[0.0; 4]);
        let minus = array(&[2, 2], &[0.0, 0.0, 0.0, -0.0]);
        let all = [bytes.hash(), wide.hash(), square.hash(), minus.hash()];
        assert!(
            all.iter()
                .enumerate()
                .all(|(i, h)| all[..i].iter().all(|other| other != h))
        );
    }
}

//! Images and arrays read for comparison: what `texmap diff` and `texmap hash` work on.

use std::borrow::Cow;
use std::path::Path;

use texmap_io::IoError;
use texmap_io::image_io::{Depth, read_image};
use texmap_io::npy::{self, Data};
use texmap_render::hash_pixels;

use crate::metrics::{Metrics, MetricsError, Shape, check, measure};
use crate::picture::Picture;
use crate::strip::heat;

/// The decoded values of a file, kept in the file's own depth.
#[derive(Clone, Debug)]
pub struct Buffer {
    /// Size; an array of more than three axes has its first ones as rows.
    pub shape: Shape,
    /// The largest value of the format: 1 for images (their codes are divided by 255 or 65535), else the
    /// largest finite value that the array holds.
    pub peak: f64,
    values: Values,
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
    /// What is wrong with the file.
    pub fn read(path: &Path) -> Result<Self, IoError> {
        if path
            .extension()
            .is_some_and(|e| e.eq_ignore_ascii_case("npy"))
        {
            return Ok(Self::of_array(npy::read(path)?));
        }
        let image = read_image(path)?;
        Ok(Self {
            shape: Shape {
                width: image.width as usize,
                height: image.height as usize,
                channels: 4,
            },
            peak: 1.0,
            values: Values::Image(image.texels),
        })
    }

    fn of_array(array: npy::Array) -> Self {
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
        };
        this.peak = (0..this.len())
            .map(|i| this.value(i).abs())
            .filter(|v| v.is_finite())
            .fold(0.0, f64::max);
        this
    }

    fn len(&self) -> usize {
        match &self.values {
            Values::Image(Depth::U8(v)) | Values::Array(Data::U8(v)) => v.len(),
            Values::Image(Depth::U16(v)) | Values::Array(Data::U16(v)) => v.len(),
            Values::Array(Data::F32(v)) => v.len(),
            Values::Array(Data::U32(v)) => v.len(),
        }
    }

    /// A value, counted as they are interleaved: 0 to 1 for images, what is written for arrays.
    ///
    /// # Panics
    /// Beyond the last one that `shape` has.
    #[must_use]
    pub fn value(&self, index: usize) -> f64 {
        match &self.values {
            Values::Image(Depth::U8(v)) => f64::from(v[index]) / 255.0,
            Values::Image(Depth::U16(v)) => f64::from(v[index]) / 65535.0,
            Values::Array(Data::F32(v)) => v[index].into(),
            Values::Array(Data::U8(v)) => v[index].into(),
            Values::Array(Data::U16(v)) => v[index].into(),
            Values::Array(Data::U32(v)) => v[index].into(),
        }
    }

    /// [`hash_pixels`] of the width, the height and the values as little-endian bytes of the file's own depth:
    /// what `render --json` calls `pixel_hash`, for an 8-bit image.
    #[must_use]
    pub fn hash(&self) -> String {
        let bytes: Cow<'_, [u8]> = match &self.values {
            Values::Image(Depth::U8(v)) | Values::Array(Data::U8(v)) => v.into(),
            Values::Image(Depth::U16(v)) | Values::Array(Data::U16(v)) => {
                v.iter().flat_map(|x| x.to_le_bytes()).collect()
            }
            Values::Array(Data::F32(v)) => v.iter().flat_map(|x| x.to_le_bytes()).collect(),
            Values::Array(Data::U32(v)) => v.iter().flat_map(|x| x.to_le_bytes()).collect(),
        };
        let side = |n: usize| u32::try_from(n).unwrap_or(u32::MAX);
        hash_pixels(side(self.shape.width), side(self.shape.height), &bytes)
    }

    /// Compares with the expected values; `limit` is the largest difference that does not count as over.
    ///
    /// # Errors
    /// When the sizes differ or are empty.
    pub fn compare(&self, expected: &Self, limit: f64) -> Result<Metrics, MetricsError> {
        check(expected.shape, expected.len(), self.len())?;
        let pairs = (0..self.len()).map(|i| (expected.value(i), self.value(i)));
        Ok(measure(expected.shape, limit, pairs))
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
        let metrics = b.compare(&a, 0.1).unwrap();
        assert_eq!(
            (metrics.over_limit, metrics.max, metrics.non_finite),
            (1, 0.5, 0)
        );
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

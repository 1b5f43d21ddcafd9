//! Figures of two images: averages for charts, counts for gates.
//!
//! Averages hide stability bugs (a crack one pixel wide leaves the PSNR of a 256x256 image near 28 dB), so
//! every comparison also counts the values beyond a limit and those that are not finite.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use thiserror::Error;

/// Size of an interleaved image: `width * height * channels` values, rows top to bottom.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shape {
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Values of a pixel.
    pub channels: usize,
}

impl Shape {
    fn values(self) -> Option<usize> {
        self.width
            .checked_mul(self.height)?
            .checked_mul(self.channels)
    }

    fn place(self, index: usize) -> Place {
        let pixel = index / self.channels;
        Place {
            x: pixel % self.width,
            y: pixel / self.width,
            channel: index % self.channels,
        }
    }
}

/// Position of a value in an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place {
    /// Column, 0 at the left.
    pub x: usize,
    /// Row, 0 at the top.
    pub y: usize,
    /// Channel of the pixel.
    pub channel: usize,
}

/// The difference of two images. All differences are absolute, in the unit of the values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Metrics {
    /// Values compared: both finite.
    pub compared: usize,
    /// Mean absolute difference; 0 when nothing was compared.
    pub mean: f64,
    /// Root of the mean squared difference; 0 when nothing was compared.
    pub rmse: f64,
    /// The difference that 99.9 % of the compared values do not exceed (nearest rank).
    pub p999: f64,
    /// Largest difference.
    pub max: f64,
    /// The first value that has the largest difference, if any value differs.
    pub max_at: Option<Place>,
    /// Values that differ by more than the limit.
    pub over_limit: usize,
    /// Values of which exactly one is finite, or that are unequal infinities.
    pub non_finite: usize,
    /// The first value counted by `non_finite`.
    pub non_finite_at: Option<Place>,
    /// Holes that both images have: two NaN, or equal infinities. They are no difference.
    pub holes: usize,
}

impl Metrics {
    /// Peak signal-to-noise ratio in decibels for values of the range `0..=peak`. Infinite for equal images.
    pub fn psnr(&self, peak: f64) -> f64 {
        if self.rmse == 0.0 {
            f64::INFINITY
        } else {
            20.0 * (peak / self.rmse).log10()
        }
    }

    /// Nothing beyond the limit and nothing computed that is not finite.
    pub fn passes(&self) -> bool {
        self.over_limit == 0 && self.non_finite == 0
    }
}

/// Error of two images that cannot be compared.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum MetricsError {
    /// A slice does not hold what the shape says.
    #[error(
        "{which} image holds {found} values, {width} x {height} x {channels} asks for {expected}"
    )]
    Length {
        /// `expected` or `actual`.
        which: &'static str,
        /// Values in the slice.
        found: usize,
        /// Values that the shape asks for.
        expected: usize,
        /// Width of the shape.
        width: usize,
        /// Height of the shape.
        height: usize,
        /// Channels of the shape.
        channels: usize,
    },
    /// A side of the shape is 0, or the product overflows.
    #[error("an image of {0} x {1} with {2} channels cannot be compared")]
    Shape(usize, usize, usize),
}

/// Compares two images of f32, f64 or 8-bit values. `limit` is the largest difference that does not count as
/// over; it and all differences are in the values' own unit (code values, 0..=255, for bytes).
///
/// # Errors
/// If the shape is empty or a slice has another length than the shape.
pub fn compare<T: Copy + Into<f64>>(
    shape: Shape,
    expected: &[T],
    actual: &[T],
    limit: f64,
) -> Result<Metrics, MetricsError> {
    check(shape, expected.len(), actual.len())?;
    let pairs = expected.iter().zip(actual);
    Ok(measure(
        shape,
        limit,
        pairs.map(|(&e, &a)| (e.into(), a.into())),
    ))
}

/// Checks that a shape holds values, and both images as many.
pub(crate) fn check(shape: Shape, expected: usize, actual: usize) -> Result<(), MetricsError> {
    let Shape {
        width,
        height,
        channels,
    } = shape;
    let values = shape
        .values()
        .filter(|&n| n > 0)
        .ok_or(MetricsError::Shape(width, height, channels))?;
    for (which, found) in [("expected", expected), ("actual", actual)] {
        if found != values {
            return Err(MetricsError::Length {
                which,
                found,
                expected: values,
                width,
                height,
                channels,
            });
        }
    }
    Ok(())
}

/// The figures of values in order, as many as the shape holds.
pub(crate) fn measure(
    shape: Shape,
    limit: f64,
    pairs: impl ExactSizeIterator<Item = (f64, f64)>,
) -> Metrics {
    let mut compared = 0;
    let mut largest = Largest::of(pairs.len());
    let (mut sum, mut squares, mut max, mut max_at) = (0.0, 0.0, 0.0, None);
    let (mut over_limit, mut non_finite, mut non_finite_at, mut holes) = (0, 0, None, 0);
    for (index, (expected, actual)) in pairs.enumerate() {
        if expected.is_finite() && actual.is_finite() {
            let difference = (actual - expected).abs();
            sum += difference;
            squares += difference * difference;
            over_limit += usize::from(difference > limit);
            if difference > max {
                (max, max_at) = (difference, Some(shape.place(index)));
            }
            compared += 1;
            largest.push(difference);
        } else if !(expected == actual || expected.is_nan() && actual.is_nan()) {
            non_finite += 1;
            non_finite_at = non_finite_at.or(Some(shape.place(index)));
        } else {
            holes += 1;
        }
    }
    let count = compared.max(1) as f64;
    Metrics {
        compared,
        mean: sum / count,
        rmse: (squares / count).sqrt(),
        p999: largest.p999(compared),
        max,
        max_at,
        over_limit,
        non_finite,
        non_finite_at,
        holes,
    }
}

/// The largest differences, as many as can lie at or above their 99.9 %: what is below need not be kept.
struct Largest {
    /// Bits of numbers that are not negative: in their order.
    kept: BinaryHeap<Reverse<u64>>,
    most: usize,
}

impl Largest {
    /// Of at most `values` differences.
    fn of(values: usize) -> Self {
        // One more than a thousandth, and one for the rounding of a rank.
        let most = values / 1000 + 2;
        Self {
            kept: BinaryHeap::with_capacity(most),
            most,
        }
    }

    fn push(&mut self, difference: f64) {
        let bits = difference.to_bits();
        if self.kept.len() < self.most {
            self.kept.push(Reverse(bits));
        } else if let Some(mut least) = self.kept.peek_mut()
            && least.0 < bits
        {
            *least = Reverse(bits);
        }
    }

    /// [`quantile`] of all `count` differences that were pushed.
    fn p999(self, count: usize) -> f64 {
        let kept = self.kept.into_sorted_vec();
        let found = kept.get(count.saturating_sub(rank(count, 0.999)));
        found.map_or(0.0, |least| f64::from_bits(least.0))
    }
}

/// The smallest value that at least the part `q` of the values do not exceed; 0 for no values.
pub fn quantile(values: &mut [f64], q: f64) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let rank = rank(values.len(), q);
    *values.select_nth_unstable_by(rank - 1, f64::total_cmp).1
}

/// The nearest rank, counted from 1.
fn rank(count: usize, q: f64) -> usize {
    ((count as f64 * q).ceil() as usize).clamp(1, count.max(1))
}

/// A number as text in at most four digits.
pub fn figure(value: f64) -> String {
    let size = value.abs();
    if value == value.trunc() && size < 1e7 {
        format!("{value}")
    } else if !value.is_finite() {
        value.to_string()
    } else if !(1e-3..1e5).contains(&size) {
        format!("{value:.2e}")
    } else {
        let digits = (3 - size.log10().floor() as i32).clamp(0, 6) as usize;
        let text = format!("{value:.digits$}");
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ROW: Shape = Shape {
        width: 2000,
        height: 1,
        channels: 1,
    };

    #[test]
    fn averages_hide_what_counts_show() {
        // One value of 2000 is off by one: the 99.9 % figure stays 0, the maximum and the count do not.
        let expected = vec![0.0; 2000];
        let mut actual = expected.clone();
        actual[1234] = 1.0;
        let m = compare(ROW, &expected, &actual, 0.5).unwrap();
        assert_eq!(
            (m.p999, m.max, m.over_limit, m.non_finite),
            (0.0, 1.0, 1, 0)
        );
        assert_eq!(
            m.max_at,
            Some(Place {
                x: 1234,
                y: 0,
                channel: 0
            })
        );
        assert_eq!(m.mean, 1.0 / 2000.0);
        assert_eq!(m.rmse, (1.0f64 / 2000.0).sqrt());
        assert!(!m.passes());
    }

    #[test]
    fn p999_is_the_nearest_rank() {
        let expected = vec![0.0f32; 2000];
        let actual: Vec<f32> = (1..=2000).map(|i| i as f32).collect();
        assert_eq!(compare(ROW, &expected, &actual, 1e9).unwrap().p999, 1998.0);
    }

    #[test]
    fn p999_of_any_number_of_values_is_that_of_all_in_order() {
        let mut seed = 1_u32;
        for count in (1..40).chain([999, 1000, 1001, 1999, 2000, 2001, 12_345]) {
            let holes = count / 7;
            let mut differences: Vec<f64> = (0..count)
                .map(|_| {
                    seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                    f64::from(seed >> 20)
                })
                .collect();
            let mut actual = differences.clone();
            actual.resize(count + holes, f64::NAN);
            let shape = Shape {
                width: count + holes,
                ..ROW
            };
            let found = compare(shape, &vec![0.0; count + holes], &actual, 0.0).unwrap();
            assert_eq!(found.compared, count);
            assert_eq!(found.p999, quantile(&mut differences, 0.999), "{count}");
        }
    }

    #[test]
    fn a_hole_in_both_is_no_error_and_a_hole_in_one_is() {
        let shape = Shape {
            width: 2,
            height: 2,
            channels: 1,
        };
        let nan = f32::NAN;
        let m = compare(shape, &[nan, 1.0, 2.0, 3.0], &[nan, 1.0, nan, 3.0], 0.0).unwrap();
        assert_eq!((m.compared, m.non_finite, m.over_limit), (2, 1, 0));
        assert_eq!(m.holes, 1);
        assert_eq!(
            m.non_finite_at,
            Some(Place {
                x: 0,
                y: 1,
                channel: 0
            })
        );
        assert!(!m.passes());
    }

    #[test]
    fn psnr_of_known_noise() {
        let shape = Shape {
            width: 1,
            height: 1,
            channels: 1,
        };
        let m = compare(shape, &[0u8], &[255], 0.0).unwrap();
        assert_eq!(m.psnr(255.0), 0.0);
        assert_eq!(
            compare(shape, &[9u8], &[9], 0.0).unwrap().psnr(255.0),
            f64::INFINITY
        );
    }

    #[test]
    fn shapes_that_do_not_fit_are_refused() {
        let shape = Shape {
            width: 2,
            height: 2,
            channels: 1,
        };
        assert!(matches!(
            compare(shape, &[0.0; 4], &[0.0; 3], 0.0),
            Err(MetricsError::Length {
                which: "actual",
                ..
            })
        ));
        let empty = Shape { width: 0, ..shape };
        assert!(matches!(
            compare::<f32>(empty, &[], &[], 0.0),
            Err(MetricsError::Shape(0, 2, 1))
        ));
        let huge = Shape {
            width: usize::MAX,
            height: 2,
            channels: 1,
        };
        assert!(matches!(
            compare::<f32>(huge, &[], &[], 0.0),
            Err(MetricsError::Shape(..))
        ));
    }

    #[test]
    fn figures_have_four_digits_at_most() {
        for (value, text) in [
            (0.0, "0"),
            (1826.0, "1826"),
            (0.5, "0.5"),
            (175.7263, "175.7"),
            (2.4e-7, "2.40e-7"),
            (f64::INFINITY, "inf"),
            (0.00390625, "0.003906"),
        ] {
            assert_eq!(figure(value), text);
        }
    }
}

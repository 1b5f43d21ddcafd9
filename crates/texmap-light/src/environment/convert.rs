//! An environment in another layout: means of the old light over the area of each new texel.

use texmap_math::float::sqrt;
use texmap_math::glam::{DVec2, DVec3};
use texmap_math::progress::{Progress, no_progress};
use texmap_math::simd::Scalar;

use super::Environment;
use crate::EnvironmentLayout;
use crate::error::LightError;
use crate::vector::narrow;

impl Environment {
    /// The environment in another layout, with faces of `size` texels in height. Each new texel is the mean of the old light over its
    /// area, by at least one look-up per old texel that it covers.
    ///
    /// # Errors
    /// As [`Environment::from_fn`].
    pub fn convert(&self, chart: EnvironmentLayout, size: u32) -> Result<Self, LightError> {
        self.convert_with_progress(chart, size, &no_progress)
    }

    /// [`convert`](Self::convert) with a callback that hears of each row of texels and may end the work.
    ///
    /// # Errors
    /// As [`Environment::from_fn`]; [`LightError::Cancelled`] after a break.
    pub fn convert_with_progress(
        &self,
        chart: EnvironmentLayout,
        size: u32,
        progress: Progress<'_>,
    ) -> Result<Self, LightError> {
        let count = |chart: EnvironmentLayout, w: u32, h: u32| {
            chart.faces() as f64 * f64::from(w) * f64::from(h)
        };
        let (width, height) = self.size();
        let ratio = count(self.layout, width, height)
            / count(chart, size.max(1) * chart.aspect(), size.max(1));
        // Solid angles within a layout differ by up to 5.2, and lat-long's poles by more. Two look-ups a texel and axis.
        let n = (2.0 * sqrt(ratio)) as u32 + 1;
        let n = if ratio <= 0.25 { 1 } else { n.min(64) };
        Self::from_directions(chart, size, progress, |face, centre, sides| {
            let mut sum = DVec3::ZERO;
            for j in 0..n {
                for i in 0..n {
                    let inside = |k: u32| (f64::from(k) + 0.5) / f64::from(n) - 0.5;
                    let uv = (centre + DVec2::new(inside(i), inside(j))) / sides;
                    let (at, uv) = self.layout.place(Scalar, narrow(chart.direction(face, uv)));
                    let (at, uv) = (at.0 as usize, DVec2::from(uv.map(f64::from)));
                    sum += DVec3::from(self.bilinear(self.levels[0], at, uv).map(f64::from));
                }
            }
            narrow(sum / f64::from(n * n))
        })
    }
}

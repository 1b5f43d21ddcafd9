//! Specular maps: the light of an environment that a highlight gathers around each direction.

use alloc::vec::Vec;

use texmap_math::det;
use texmap_math::float::sqrt;
use texmap_math::glam::{DVec2, DVec3};

use super::Environment;
use crate::Chart;
use crate::error::LightError;

impl Environment {
    /// A specular map: the light that a highlight of this exponent gathers around each direction R, the mean of L(d) with
    /// weight `max(0, R.d)^exponent` over all texels by their solid angle (MIT 6.837, lecture 18, slide 30: area
    /// lights in an environment map in place of the highlight's formula). Directions whose weight is below a millionth are
    /// left out by patches of texels. The work is texels of the result times texels of this map inside of the lobe:
    /// [`convert`](Self::convert) to a small one first.
    ///
    /// # Errors
    /// [`LightError::Exponent`] unless the exponent is finite and at least 0; else as [`Environment::from_fn`].
    pub fn blur(&self, chart: Chart, size: u32, exponent: f32) -> Result<Self, LightError> {
        if !(exponent.is_finite() && exponent >= 0.0) {
            return Err(LightError::Exponent { exponent });
        }
        let lobe = Lobe::new(f64::from(exponent));
        let patches = self.patches();
        let map = Self::from_fn(chart, size, |r| {
            let (mut sum, mut weights) = (DVec3::ZERO, 0.0);
            for patch in &patches {
                if lobe.misses(r, patch) {
                    continue;
                }
                for (d, light, angle) in &patch.texels {
                    let weight = angle * lobe.at(r.dot(*d));
                    if weight > 0.0 {
                        sum += *light * weight;
                        weights += weight;
                    }
                }
            }
            // A lobe narrower than a texel meets none.
            if weights > 0.0 {
                (sum / weights).to_array().map(|c| c as f32)
            } else {
                self.light(r.to_array().map(|c| c as f32))
            }
        })?;
        Ok(Self {
            exponent: Some(exponent),
            ..map
        })
    }

    /// Texels a side of a cube's faces at which a map blurred by this exponent is read off by no more than a hundredth of
    /// its range: bilinear look-ups are off by h^2 / 8 times the second derivatives, which at the peak of cos^n are n
    /// each, for texels of h = 2 / side radians. At least 8; at most 256, from an exponent of 650 on.
    #[must_use]
    pub fn blurred_size(exponent: f32) -> u32 {
        let side = 10.0 * sqrt(f64::from(exponent));
        // NaN counts as 0.
        let side = if side > 8.0 { side } else { 8.0 };
        let side = if side < 256.0 { side } else { 256.0 };
        texmap_math::float::ceil(side) as u32
    }

    /// [`blur`](Self::blur) from no more texels than the lobe needs: of a larger map, from a cube of half as many texels again a
    /// side as [`blurred_size`](Self::blurred_size).
    ///
    /// # Errors
    /// As [`Environment::blur`].
    pub fn specular_map(&self, chart: Chart, size: u32, exponent: f32) -> Result<Self, LightError> {
        let gathered = Self::blurred_size(exponent) * 3 / 2;
        let count = |chart: Chart, width: u32, height: u32| {
            chart.faces() as u64 * u64::from(width) * u64::from(height)
        };
        if count(self.chart, self.size().0, self.size().1) > count(Chart::Cube, gathered, gathered)
        {
            let gathered = self.convert(Chart::Cube, gathered)?;
            gathered.blur(chart, size, exponent)
        } else {
            self.blur(chart, size, exponent)
        }
    }

    /// All texels by patches of up to 8 x 8.
    fn patches(&self) -> Vec<Patch> {
        const SIDE: u32 = 8;
        let size @ (width, height) = self.size();
        let texel = |face: usize, x: u32, y: u32| {
            let centre = |c: u32, n: u32| (f64::from(c) + 0.5) / f64::from(n);
            let uv = DVec2::new(centre(x, width), centre(y, height));
            let at = self.levels[0].index(face, x as usize + 1, y as usize + 1);
            (
                self.chart.direction(face, uv),
                DVec3::from(self.texels[at].map(f64::from)),
                self.chart.solid_angle(face, (x, y), size),
            )
        };
        let mut patches = Vec::new();
        for face in 0..self.chart.faces() {
            for y0 in (0..height).step_by(SIDE as usize) {
                for x0 in (0..width).step_by(SIDE as usize) {
                    let columns = x0..width.min(x0 + SIDE);
                    let rows = y0..height.min(y0 + SIDE);
                    let places = rows.flat_map(|y| columns.clone().map(move |x| (x, y)));
                    patches.push(Patch::new(places.map(|(x, y)| texel(face, x, y)).collect()));
                }
            }
        }
        patches
    }
}

/// Neighbouring texels: direction, light and solid angle of each, inside of a cone.
struct Patch {
    texels: Vec<(DVec3, DVec3, f64)>,
    axis: DVec3,
    /// Radians from the axis to the farthest of the directions.
    radius: f64,
}

impl Patch {
    fn new(texels: Vec<(DVec3, DVec3, f64)>) -> Self {
        let sum: DVec3 = texels.iter().map(|t| t.0).sum();
        let axis = sum.normalize_or_zero();
        let least = texels.iter().map(|t| t.0.dot(axis)).fold(1.0, f64::min);
        Self {
            texels,
            axis,
            radius: det::acos(least),
        }
    }
}

/// `x^exponent` for 0..=1 from a table of even steps; off by at most (exponent / 4096)^2 / 8.
struct Lobe {
    powers: Vec<f64>,
    /// Radians beyond which the power is below a millionth.
    reach: f64,
}

impl Lobe {
    const STEPS: usize = 4096;

    fn new(exponent: f64) -> Self {
        let power = |i: usize| det::pow(1.0 - i as f64 / Self::STEPS as f64, exponent);
        let least = if exponent > 0.0 {
            det::pow(1e-6, 1.0 / exponent)
        } else {
            0.0
        };
        Self {
            powers: (0..=Self::STEPS).map(power).collect(),
            reach: det::acos(least),
        }
    }

    /// Whether a patch is out of reach from a direction of unit length.
    fn misses(&self, r: DVec3, patch: &Patch) -> bool {
        let angle = self.reach + patch.radius;
        angle < core::f64::consts::PI && r.dot(patch.axis) < det::cos(angle)
    }

    fn at(&self, x: f64) -> f64 {
        if x.is_nan() || x <= 0.0 {
            return 0.0;
        }
        let t = (1.0 - if x < 1.0 { x } else { 1.0 }) * Self::STEPS as f64;
        let i = (t as usize).min(Self::STEPS - 1);
        let k = t - i as f64;
        self.powers[i] * (1.0 - k) + self.powers[i + 1] * k
    }
}

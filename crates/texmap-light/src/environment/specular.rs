//! Specular maps: the light of an environment that a highlight gathers around each direction.

use alloc::vec::Vec;
use core::ops::Range;

use texmap_math::float::sqrt;
use texmap_math::glam::{DVec2, DVec3};
use texmap_math::lanes::{GatherTable, LANES};
use texmap_math::progress::{Progress, no_progress};
use texmap_math::simd::{Isa, prelude::*};
use texmap_math::{Level, deterministic_f64, dispatch_simd};

use super::Environment;
use crate::EnvironmentLayout;
use crate::error::LightError;
use crate::lanes::Vector;
use crate::vector::{dot, narrow, splat};

impl Environment {
    /// A specular map: the light that a highlight of this exponent gathers around each direction R, the mean of L(d) with
    /// weight `max(0, R.d)^exponent` over all texels by their solid angle (MIT 6.837, lecture 18, slide 30: area
    /// lights in an environment map instead of the highlight's formula). Directions whose weight is below a millionth are
    /// left out by patches of texels. The work is texels of the result times texels of this map inside of the lobe:
    /// [`convert`](Self::convert) to a small one first.
    ///
    /// # Errors
    /// [`LightError::Exponent`] unless the exponent is finite and at least 0; else as [`Environment::from_fn`].
    pub fn blur(
        &self,
        chart: EnvironmentLayout,
        size: u32,
        exponent: f32,
    ) -> Result<Self, LightError> {
        self.blur_with_progress(chart, size, exponent, &no_progress)
    }

    fn blur_with_progress(
        &self,
        chart: EnvironmentLayout,
        size: u32,
        exponent: f32,
        progress: Progress<'_>,
    ) -> Result<Self, LightError> {
        if !(exponent.is_finite() && exponent >= 0.0) {
            return Err(LightError::Exponent { exponent });
        }
        let gathering = Gathering::new(self, f64::from(exponent));
        let level = crate::level();
        let map = Self::from_directions(chart, size, progress, |face, centre, sides| {
            let r = chart.direction(face, centre / sides);
            let [red, green, blue, weights] = gathering.sums(level, r);
            // A lobe narrower than a texel meets none.
            if weights > LEAST_WEIGHT {
                [red, green, blue].map(|c| (c / weights) as f32)
            } else {
                self.radiance(narrow(r))
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
    pub fn specular_map(
        &self,
        chart: EnvironmentLayout,
        size: u32,
        exponent: f32,
    ) -> Result<Self, LightError> {
        self.specular_map_with_progress(chart, size, exponent, &no_progress)
    }

    /// [`specular_map`](Self::specular_map) with a callback that hears of each row of texels, of the smaller map and then of the blurred
    /// one, and may end the work.
    ///
    /// # Errors
    /// As [`Environment::blur`]; [`LightError::Cancelled`] after a break.
    pub fn specular_map_with_progress(
        &self,
        chart: EnvironmentLayout,
        size: u32,
        exponent: f32,
        progress: Progress<'_>,
    ) -> Result<Self, LightError> {
        let gathered = Self::blurred_size(exponent) * 3 / 2;
        let count = |chart: EnvironmentLayout, width: u32, height: u32| {
            chart.faces() as u64 * u64::from(width) * u64::from(height)
        };
        if count(self.layout, self.size().0, self.size().1)
            > count(EnvironmentLayout::Cube, gathered, gathered)
        {
            self.convert_with_progress(EnvironmentLayout::Cube, gathered, progress)?
                .blur_with_progress(chart, size, exponent, progress)
        } else {
            self.blur_with_progress(chart, size, exponent, progress)
        }
    }
}

/// 2^-60: the products of light and smaller weights would lose digits to subnormal numbers.
const LEAST_WEIGHT: f64 = 8.7e-19;

/// An environment's texels by patches, and the lobe that gathers them.
struct Gathering {
    patches: Vec<Patch>,
    texels: Vec<Sixteen>,
    lobe: Lobe,
}

/// Sixteen texels; those that a patch lacks have no solid angle.
#[derive(Default)]
struct Sixteen {
    direction: [[f32; LANES]; 3],
    /// Light times solid angle, and solid angle.
    light: [[f32; LANES]; 4],
}

/// Neighbouring texels inside of a cone.
struct Patch {
    /// Range of the patch's texels among all.
    texels: Range<usize>,
    axis: DVec3,
    /// Cosine of the angle from the axis beyond which no direction's lobe reaches a texel.
    least: f64,
}

impl Gathering {
    /// Texels a side of a patch.
    const SIDE: u32 = 8;

    fn new(environment: &Environment, exponent: f64) -> Self {
        let size @ (width, height) = environment.size();
        let mut this = Self {
            patches: Vec::new(),
            texels: Vec::new(),
            lobe: Lobe::new(exponent),
        };
        let texel = |face: usize, x: u32, y: u32| {
            let centre = |c: u32, n: u32| (f64::from(c) + 0.5) / f64::from(n);
            let uv = DVec2::new(centre(x, width), centre(y, height));
            let at = environment.levels[0].index(face, x as usize + 1, y as usize + 1);
            (
                environment.layout.direction(face, uv),
                environment.texels[at],
                environment.layout.solid_angle(face, (x, y), size),
            )
        };
        let mut texels = Vec::new();
        for face in 0..environment.layout.faces() {
            for y0 in (0..height).step_by(Self::SIDE as usize) {
                for x0 in (0..width).step_by(Self::SIDE as usize) {
                    let columns = x0..width.min(x0 + Self::SIDE);
                    let rows = y0..height.min(y0 + Self::SIDE);
                    texels.clear();
                    for y in rows {
                        texels.extend(columns.clone().map(|x| texel(face, x, y)));
                    }
                    this.push(&texels);
                }
            }
        }
        this
    }

    /// A patch of these: direction, light and solid angle of each.
    fn push(&mut self, texels: &[(DVec3, [f32; 3], f64)]) {
        let sum: DVec3 = texels.iter().map(|t| t.0).sum();
        let axis = sum.normalize_or_zero();
        let least = texels.iter().map(|t| t.0.dot(axis)).fold(1.0, f64::min);
        let angle = self.lobe.reach + deterministic_f64::acos(least);
        let start = self.texels.len();
        for part in texels.chunks(LANES) {
            let mut sixteen = Sixteen::default();
            for (i, (d, light, angle)) in part.iter().enumerate() {
                let d = narrow(*d);
                let [r, g, b] = light.map(|c| (f64::from(c) * angle) as f32);
                for (column, c) in sixteen.direction.iter_mut().zip(d) {
                    column[i] = c;
                }
                for (column, c) in sixteen.light.iter_mut().zip([r, g, b, *angle as f32]) {
                    column[i] = c;
                }
            }
            self.texels.push(sixteen);
        }
        self.patches.push(Patch {
            texels: start..self.texels.len(),
            axis,
            least: if angle < core::f64::consts::PI {
                deterministic_f64::cos(angle)
            } else {
                -2.0
            },
        });
    }

    /// Light times weight of all texels that the lobe around `r` reaches, and weights.
    fn sums(&self, level: Level, r: DVec3) -> [f64; 4] {
        let mut sums = [[0.0; LANES]; 4];
        dispatch_simd!(level, i => self.sum_lanes(i, r, &mut sums));
        sums.map(|lanes| lanes.into_iter().map(f64::from).sum())
    }

    /// The sums of each of sixteen columns of texels.
    #[inline(always)]
    fn sum_lanes<I: Isa>(&self, i: I, r: DVec3, sums: &mut [[f32; LANES]; 4]) {
        let to = splat(i, narrow(r));
        for patch in self.near(r) {
            for at in (0..LANES).step_by(I::LANES) {
                let mut lanes = [i.f32(0.0); 4];
                for (lanes, sum) in lanes.iter_mut().zip(&*sums) {
                    *lanes = i.load_f32(&sum[at..]);
                }
                for texels in &self.texels[patch.texels.clone()] {
                    let [x, y, z] = &texels.direction;
                    let d = [
                        i.load_f32(&x[at..]),
                        i.load_f32(&y[at..]),
                        i.load_f32(&z[at..]),
                    ];
                    let weight = self.lobe.of(i, to, d);
                    for (lanes, light) in lanes.iter_mut().zip(&texels.light) {
                        *lanes = *lanes + i.load_f32(&light[at..]) * weight;
                    }
                }
                for (lanes, sum) in lanes.iter().zip(&mut *sums) {
                    lanes.store(&mut sum[at..]);
                }
            }
        }
    }

    /// Patches that the lobe around `r` reaches.
    fn near(&self, r: DVec3) -> impl Iterator<Item = &Patch> {
        let patches = self.patches.iter();
        patches.filter(move |p| r.dot(p.axis) >= p.least)
    }
}

/// `x^exponent` for 0..=1 from a table of even steps; off by at most (exponent / 4096)^2 / 8, and by exponent / 10^7.
struct Lobe {
    powers: Vec<f32>,
    /// Radians beyond which the power is below a millionth.
    reach: f64,
}

impl Lobe {
    const STEPS: i32 = 4096;

    fn new(exponent: f64) -> Self {
        let power = |i| {
            deterministic_f64::pow(1.0 - f64::from(i) / f64::from(Self::STEPS), exponent) as f32
        };
        let least = if exponent > 0.0 {
            deterministic_f64::pow(1e-6, 1.0 / exponent)
        } else {
            0.0
        };
        Self {
            powers: (0..=Self::STEPS).map(power).collect(),
            reach: deterministic_f64::acos(least),
        }
    }

    /// Weights of directions `d` from `r`, both of unit length.
    #[inline(always)]
    fn of<I: Isa>(&self, i: I, r: Vector<I>, d: Vector<I>) -> I::F32 {
        let Some(words) = GatherTable::new(bytemuck::cast_slice(&self.powers)) else {
            return i.f32(0.0);
        };
        let x = dot(d, r);
        let t = (i.f32(1.0) - x.below(i.f32(1.0))) * Self::STEPS as f32;
        let at = t.floor_to_i32().min(i.i32(Self::STEPS - 1));
        let k = t - at.to_f32();
        let [p, q] = i.gather_pairs(words, at.to_u32());
        let weight = p.to_f32_bits() * (i.f32(1.0) - k) + q.to_f32_bits() * k;
        x.simd_gt(0.0).select(weight, i.f32(0.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use texmap_math::simd::Scalar;

    /// One sum at every width.
    #[test]
    fn widths_agree() {
        for chart in EnvironmentLayout::ALL {
            let mut seed = 1u32;
            let noise = Environment::from_fn(chart, 21, |_| {
                seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                [8, 12, 16].map(|shift| f32::from((seed >> shift) as u8))
            });
            let noise = noise.unwrap();
            for exponent in [0.0, 1.0, 7.5, 900.0] {
                let gathering = Gathering::new(&noise, exponent);
                for d in [DVec3::X, DVec3::NEG_Z, DVec3::new(0.36, -0.48, 0.8)] {
                    let mut plain = [[0.0; LANES]; 4];
                    gathering.sum_lanes(Scalar, d, &mut plain);
                    every_width!(i => {
                        let mut sums = [[0.0; LANES]; 4];
                        gathering.sum_lanes(i, d, &mut sums);
                        assert_eq!(sums, plain, "{chart:?} {exponent}");
                    });
                    let sums = plain.map(|c| c.into_iter().sum::<f32>());
                    assert!(sums[3] > 0.0 && sums.iter().all(|c| c.is_finite()));
                }
            }
        }
    }

    /// Light gathered by a lobe that meets none of few texels, as their weights are the smallest numbers, is not beyond all light.
    #[test]
    fn narrow_lobes_make_no_light() {
        for layout in EnvironmentLayout::ALL {
            for height in 1..5 {
                let mut light = 0.0;
                let few = Environment::from_fn(layout, height, |_| {
                    light = (light + 2.7) % 5.0;
                    [light - 3.8, -3.1, 3.7]
                });
                let few = few.unwrap();
                for exponent in (1..=256).step_by(5) {
                    let map = few.specular_map(layout, 2, exponent as f32).unwrap();
                    let found = map.inner_texels().flatten();
                    let most = found.fold(0.0f32, |most, c| most.max(c.abs()));
                    assert!(
                        most <= 3.8 * 1.001,
                        "{layout:?} {height} {exponent}: {most}"
                    );
                }
            }
        }
    }
}

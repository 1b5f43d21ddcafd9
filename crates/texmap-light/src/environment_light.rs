//! Environments that light surfaces: their light gathered by the lobes of roughnesses and by a diffuse surface.

mod gather;
mod levels;
mod prefilter;
mod roughnesses;
mod samples;
mod studio;

use texmap_math::deterministic_f64;
use texmap_math::simd::{Isa, Scalar, prelude::*};

use crate::environment::Environment;
use crate::error::LightError;
use crate::lanes::Vector;
use levels::Levels;
pub use prefilter::Prefilter;
pub use roughnesses::Roughnesses;
use roughnesses::{STEPS, level, roughness_of};
pub use samples::{EnvironmentSample, LEAST_SAMPLE_COSINE};

/// Light from every direction as surfaces receive it: the sum over all directions is taken once, for each of twelve roughnesses and
/// for a diffuse surface, and read by direction. Radiances from 0 to a million; others count as the nearer end.
/// Texels are held in one word, off by 1/512 of their
/// brightest channel at most.
///
/// A level holds the reflection of a surface seen head on (Karis 2013); [`ReflectionLobes`](crate::ReflectionLobes) makes that of one seen
/// aslant of several.
#[derive(Clone, Debug, PartialEq)]
pub struct EnvironmentLight {
    /// A cube. Level k holds the light that the lobe of [`roughness_of_level`](Self::roughness_of_level) gathers; level 0 is the environment. A level that was not
    /// made reads as the next rougher one that was, the roughest as the last.
    rough: Levels,
    /// The levels that were made.
    roughnesses: Roughnesses,
    /// Cosine-weighted means over hemispheres: irradiance over pi. Level 1 is light at grazing incidence: its weights are those of level 0
    /// times `(1 - N.L)^5`.
    diffuse: Levels,
    /// Cosine and sine of the turn about +Y.
    turn: [f32; 2],
    /// Its +Y stands on +Z.
    z_up: bool,
}

impl EnvironmentLight {
    /// The light that the lobes gather of an environment, from a cube of `size` texels a side. `size` is at least 16 and at most
    /// [`Environment::MAX_SIDE`]; a quarter of a lat-long's width keeps its detail. With the feature `rayon` by every thread of the
    /// current pool; the same bits. [`Prefilter::light`] gathers for some roughnesses alone.
    ///
    /// # Errors
    /// [`LightError::LayoutSize`] for another size.
    pub fn new(environment: &Environment, size: u32) -> Result<Self, LightError> {
        Prefilter::new(environment, size).and_then(|mut made| made.light(Roughnesses::ALL))
    }

    fn of(rough: Levels, diffuse: Levels, roughnesses: Roughnesses) -> Self {
        Self {
            rough,
            roughnesses,
            diffuse,
            turn: [1.0, 0.0],
            z_up: false,
        }
    }

    /// This light with the levels of another, as it is turned; `None` unless both are of one environment.
    #[must_use]
    pub fn with_levels_of(&self, other: &Self) -> Option<Self> {
        let same = self.diffuse == other.diffuse && self.rough.has_first_level_of(&other.rough);
        same.then(|| Self {
            turn: self.turn,
            z_up: self.z_up,
            ..other.clone()
        })
    }

    /// The roughnesses that it was made for: all, unless it is of [`Prefilter::light`]. `Scene::check` of texmap-scene refuses
    /// surfaces of others.
    #[must_use]
    pub fn roughnesses(&self) -> Roughnesses {
        self.roughnesses
    }

    /// The light turned about +Y by an angle in radians. A right angle turns +X to -Z. An angle that is not finite is 0.
    #[must_use]
    pub fn turned(mut self, angle: f64) -> Self {
        let (sin, cos) = deterministic_f64::sin_cos(if angle.is_finite() { angle } else { 0.0 });
        self.turn = [cos as f32, sin as f32];
        self
    }

    /// Upright on +Z: what was at +Y, above, comes to +Z and what was at +Z, in front, to -Y. A [turn](Self::turned) is one about +Z then.
    #[must_use]
    pub fn upright_on_z(mut self) -> Self {
        self.z_up = true;
        self
    }

    /// Texels a side of the environment itself.
    #[must_use]
    pub fn size(&self) -> u32 {
        self.rough.size()
    }

    /// Number of roughness levels.
    #[must_use]
    pub fn levels(&self) -> usize {
        self.rough.count()
    }

    /// The level that [`radiance`](Self::radiance) reads for a perceptual roughness, cut to 0 to 1; a fraction mixes two levels. NaN is 0.
    ///
    /// ```
    /// use texmap_light::EnvironmentLight;
    /// assert_eq!(EnvironmentLight::level_of_roughness(0.25), 3.5);
    /// assert_eq!(EnvironmentLight::roughness_of_level(3), 0.2);
    /// assert_eq!(EnvironmentLight::roughness_of_level(4), 0.3);
    /// ```
    #[must_use]
    pub fn level_of_roughness(roughness: f32) -> f32 {
        level(Scalar, F32s::<Scalar>::clamp(roughness, 0.0, 1.0))
    }

    /// Perceptual roughness of the lobe that gathers the light of a level: 0, 0.1, 0.15, 0.2, and further in steps of 0.1; 1 beyond the
    /// last.
    #[must_use]
    pub fn roughness_of_level(level: usize) -> f32 {
        roughness_of(level.min(STEPS))
    }

    /// Light that a lobe of this perceptual roughness gathers around a direction of any length, the mean of the environment with
    /// the weight `D(H) (L.R)`. Zero and non-finite directions read as +Z. Of a roughness that it was [not made
    /// for](Self::roughnesses) it is that of the next rougher one, or of the roughest.
    #[must_use]
    pub fn radiance(&self, roughness: f32, direction: [f32; 3]) -> [f32; 3] {
        self.radiance_lanes(Scalar, roughness, direction)
    }

    /// Light that a diffuse white surface of this normal gives off: its irradiance over pi.
    #[must_use]
    pub fn irradiance(&self, normal: [f32; 3]) -> [f32; 3] {
        self.irradiance_lanes(Scalar, normal)
    }

    /// Mean of the light that arrives at grazing incidence, with the weight `(N.L) (1 - N.L)^5`. A smooth dielectric mirrors it, so that
    /// less of it becomes diffuse light.
    #[must_use]
    pub fn grazing(&self, normal: [f32; 3]) -> [f32; 3] {
        let [_, grazing] = self.diffuse_lanes(Scalar, normal, true);
        grazing
    }

    /// [`radiance`](Self::radiance) for the lanes of a block; outside of semantic versioning.
    #[inline(always)]
    pub fn radiance_lanes<I: Isa>(
        &self,
        i: I,
        roughness: I::F32,
        direction: Vector<I>,
    ) -> Vector<I> {
        let lod = level(i, roughness.clamp(i.f32(0.0), i.f32(1.0)));
        self.rough.radiance(i, lod, self.turned_lanes(i, direction))
    }

    /// [`irradiance`](Self::irradiance) for the lanes of a block; outside of semantic versioning.
    #[inline(always)]
    pub fn irradiance_lanes<I: Isa>(&self, i: I, normal: Vector<I>) -> Vector<I> {
        self.diffuse
            .radiance(i, i.f32(0.0), self.turned_lanes(i, normal))
    }

    /// [`irradiance`](Self::irradiance) for the lanes of a block and, if it is asked for, [`grazing`](Self::grazing), else the same again.
    #[inline(always)]
    pub(crate) fn diffuse_lanes<I: Isa>(
        &self,
        i: I,
        normal: Vector<I>,
        grazing: bool,
    ) -> [Vector<I>; 2] {
        self.diffuse
            .first_two(i, self.turned_lanes(i, normal), grazing)
    }

    /// A direction in the environment's own axes.
    #[inline(always)]
    fn turned_lanes<I: Isa>(&self, _: I, direction: Vector<I>) -> Vector<I> {
        let [cos, sin] = self.turn;
        let [x, y, z] = match (self.z_up, direction) {
            (false, d) => d,
            (true, [x, y, z]) => [x, z, -y],
        };
        [x * cos - z * sin, y, x * sin + z * cos]
    }
}

#[cfg(test)]
mod tests;

//! Environments that light surfaces: their light gathered by the lobes of roughnesses and by a diffuse surface.

mod gather;
mod studio;

use alloc::vec::Vec;

use texmap_math::deterministic_f64;
use texmap_math::simd::{Isa, Scalar, prelude::*};

use crate::environment::Environment;
use crate::error::LightError;
use crate::lanes::Vector;
use crate::{EnvironmentLayout, level};
use gather::{Kernel, Texels};

/// Light from every direction as surfaces receive it: the sum over all directions is taken once, for each of eleven roughnesses and
/// for a diffuse surface, and read by direction. Radiances from 0 to a million; others count as the nearer end.
///
/// A rough reflection is that of a surface seen head on, turned to the mirrored direction (Karis 2013): exact there, and off where
/// the eye sees a surface at grazing incidence, whose reflections are longer than wide.
#[derive(Clone, Debug, PartialEq)]
pub struct EnvironmentLight {
    /// A cube. Level k holds the light that the lobe of a roughness of k / 10 gathers; level 0 is the environment.
    rough: Environment,
    /// Cosine-weighted means over hemispheres: irradiance over pi.
    diffuse: Environment,
    /// Cosine and sine of the turn about +Y.
    turn: [f32; 2],
}

/// Levels of roughness but the first.
const STEPS: usize = 10;
/// Texels a side of the diffuse cube: the kink that a sun makes at its horizon is off by 1.2 % of its light. (Nine spherical
/// harmonics are off by 6 %.)
const DIFFUSE_SIZE: u32 = 32;
/// Most texels a side of the environment that a diffuse surface gathers.
const DIFFUSE_SOURCE: u32 = 64;
/// Brightest texel.
const MOST: f32 = 1e6;

/// Texels a side that the lobe of a level needs, at most.
fn side(step: usize) -> u32 {
    match step {
        0 | 1 => 128,
        2..=3 => 64,
        4..=6 => 32,
        _ => 16,
    }
}

impl EnvironmentLight {
    /// The light that the lobes gather of an environment, from a cube of `size` texels a side. `size` is at least 16 and at most
    /// [`Environment::MAX_SIDE`]; a quarter of a lat-long's width keeps its detail. With the feature `rayon` by every thread of the
    /// current pool; the same bits.
    ///
    /// # Errors
    /// [`LightError::LayoutSize`] for another size.
    pub fn new(environment: &Environment, size: u32) -> Result<Self, LightError> {
        if size < 16 {
            return Err(LightError::LayoutSize {
                chart: EnvironmentLayout::Cube,
                width: size,
                height: size,
            });
        }
        let same = environment.layout() == EnvironmentLayout::Cube && environment.size().0 == size;
        let cube = if same {
            environment.clone()
        } else {
            environment.convert(EnvironmentLayout::Cube, size)?
        };
        Self::of_cube(cube)
    }

    /// The light of a cube that has the size of level 0.
    fn of_cube(cube: Environment) -> Result<Self, LightError> {
        let (size, _) = cube.size();
        let mut cube = cube;
        for texel in cube.texels.iter_mut().flatten() {
            *texel = F32s::<Scalar>::clamp(*texel, 0.0, MOST);
        }
        let cube = cube.with_mips();
        // The level of at most so many texels a side.
        let level_of = |most: u32| {
            let sizes = cube.levels.iter();
            sizes
                .take_while(|level| level.width > most)
                .count()
                .min(cube.levels.len() - 1)
        };
        let mut sources: Vec<(usize, Texels)> = Vec::new();
        let mut gathered = |source: usize, size: u32, kernel: Kernel| {
            if sources.iter().all(|(level, _)| *level != source) {
                sources.push((source, Texels::new(&cube, source)));
            }
            let found = sources.iter().find(|(level, _)| *level == source);
            let texels = found.map(|(_, texels)| texels);
            let level = level();
            Environment::from_directions(EnvironmentLayout::Cube, size, |face, centre, sides| {
                let r = EnvironmentLayout::Cube.direction(face, centre / sides);
                texels.map_or([0.0; 3], |texels| texels.gather(level, kernel, r))
            })
        };
        let mut rough = alloc::vec![];
        for step in 1..=STEPS {
            let size = size.min(side(step));
            let roughness = step as f32 / STEPS as f32;
            let kernel = Kernel::ggx(roughness * roughness);
            // The smallest are gathered from more: their patches of sixteen are wide.
            let source = if size > 16 { size } else { 2 * size };
            rough.push(gathered(level_of(source), size, kernel)?);
        }
        let diffuse = gathered(level_of(DIFFUSE_SOURCE), DIFFUSE_SIZE, Kernel::Cosine)?;
        Ok(Self {
            rough: Environment::of_levels(&cube, &rough),
            diffuse,
            turn: [1.0, 0.0],
        })
    }

    /// The light turned about +Y by an angle in radians. A right angle turns +X to -Z.
    #[must_use]
    pub fn turned(mut self, angle: f64) -> Self {
        let (sin, cos) = deterministic_f64::sin_cos(angle);
        self.turn = [cos as f32, sin as f32];
        self
    }

    /// Texels a side of the environment itself.
    #[must_use]
    pub fn size(&self) -> u32 {
        self.rough.size().0
    }

    /// Number of roughness levels. Level k of `n` holds the light that the lobe of a roughness of `k / (n - 1)` gathers.
    #[must_use]
    pub fn levels(&self) -> usize {
        self.rough.levels()
    }

    /// Light that a lobe of this perceptual roughness gathers around a direction of any length, the mean of the environment with
    /// the weight `D(H) (L.R)`. Zero and non-finite directions read as +Z.
    #[must_use]
    pub fn radiance(&self, roughness: f32, direction: [f32; 3]) -> [f32; 3] {
        self.radiance_lanes(Scalar, roughness, direction)
    }

    /// Light that a diffuse white surface of this normal gives off: its irradiance over pi.
    #[must_use]
    pub fn irradiance(&self, normal: [f32; 3]) -> [f32; 3] {
        self.irradiance_lanes(Scalar, normal)
    }

    /// [`radiance`](Self::radiance) for the lanes of a block; outside of semantic versioning.
    #[inline(always)]
    pub fn radiance_lanes<I: Isa>(
        &self,
        i: I,
        roughness: I::F32,
        direction: Vector<I>,
    ) -> Vector<I> {
        let lod = roughness.clamp(i.f32(0.0), i.f32(1.0)) * STEPS as f32;
        self.rough
            .level_lanes(i, lod, self.turned_lanes(i, direction))
    }

    /// [`irradiance`](Self::irradiance) for the lanes of a block; outside of semantic versioning.
    #[inline(always)]
    pub fn irradiance_lanes<I: Isa>(&self, i: I, normal: Vector<I>) -> Vector<I> {
        self.diffuse
            .level_lanes(i, i.f32(0.0), self.turned_lanes(i, normal))
    }

    /// A direction in the environment's own axes.
    #[inline(always)]
    fn turned_lanes<I: Isa>(&self, _: I, [x, y, z]: Vector<I>) -> Vector<I> {
        let [cos, sin] = self.turn;
        [x * cos - z * sin, y, x * sin + z * cos]
    }
}

#[cfg(test)]
mod tests;

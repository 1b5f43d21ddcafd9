//! An environment gathered by lobes: the levels of a prefiltered map.

use alloc::vec::Vec;

use texmap_math::simd::{Scalar, prelude::*};

use super::gather::{Kernel, Texels};
use super::levels::Levels;
use super::roughnesses::{Roughnesses, STEPS, roughness_of};
use super::{EnvironmentLight, studio};
use crate::EnvironmentLayout;
use crate::environment::Environment;
use crate::error::LightError;

/// An environment ready to be gathered by the lobes of roughnesses and of a diffuse surface. Radiances from 0 to a million; others count
/// as the nearer end. With the feature `rayon` by every thread of the current pool; the same bits.
#[derive(Debug)]
pub struct Prefilter {
    /// A cube with mips.
    cube: Environment,
    /// Levels of the cube that were gathered.
    sources: Vec<(usize, Texels)>,
    /// The light of diffuse surfaces and the levels of roughness that are at hand for a light.
    pub(super) diffuse: Option<[Environment; 2]>,
    pub(super) rough: [Option<Environment>; STEPS],
}

/// Texels a side of the cubes of diffuse surfaces: the kink that a sun makes at its horizon is off by 1.2 % of its light. (Nine spherical
/// harmonics are off by 6 %.)
pub(super) const DIFFUSE_SIZE: u32 = 32;
/// Most texels a side of the environment that a diffuse surface gathers.
const DIFFUSE_SOURCE: u32 = 64;
/// Brightest texel.
const MOST: f32 = 1e6;

/// Texels a side of a level of roughness, from a cube of `most`.
pub(super) fn level_size(most: u32, step: usize) -> u32 {
    most.min(side(roughness_of(step)))
}

/// Texels a side that the lobe of a roughness needs, at most.
fn side(roughness: f32) -> u32 {
    match roughness {
        r if r < 0.15 => 128,
        r if r < 0.35 => 64,
        r if r < 0.65 => 32,
        _ => 16,
    }
}

impl Prefilter {
    /// By way of a cube of `size` texels a side: at least 16, at most [`Environment::MAX_SIDE`]; a quarter of a lat-long's width keeps
    /// its detail.
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
        Ok(Self::of_cube(cube))
    }

    /// Of a cube as it is.
    pub(super) fn of_cube(mut cube: Environment) -> Self {
        for texel in cube.texels.iter_mut().flatten() {
            *texel = F32s::<Scalar>::clamp(*texel, 0.0, MOST);
        }
        Self {
            cube: cube.with_mips(),
            sources: Vec::new(),
            diffuse: None,
            rough: [const { None }; STEPS],
        }
    }

    /// The room of [`EnvironmentLight::studio`]. Nothing is gathered: its light is held.
    #[must_use]
    pub fn studio() -> Self {
        let (diffuse, rough) = studio::gathered();
        Self {
            diffuse: Some(diffuse),
            rough: rough.map(Some),
            ..Self::of_cube(studio::room())
        }
    }

    /// The light for surfaces of some roughnesses. Levels that were made for an earlier light are not made again.
    ///
    /// # Errors
    /// [`LightError::LayoutSize`] as [`Environment::from_fn`] has them; the sizes here are within its range.
    pub fn light(&mut self, roughnesses: Roughnesses) -> Result<EnvironmentLight, LightError> {
        let layout = EnvironmentLayout::Cube;
        let diffuse = match self.diffuse.take() {
            Some(made) => made,
            None => self.diffuse()?,
        };
        let [cosine, grazing] = &diffuse;
        let packed = Levels::new(cosine, &[Some(grazing)]);
        self.diffuse = Some(diffuse);
        for step in roughnesses.levels() {
            if self.rough[step - 1].is_none() {
                let size = level_size(self.cube.size().0, step);
                self.rough[step - 1] = Some(self.lobe(layout, size, roughness_of(step))?);
            }
        }
        let mut levels = [None; STEPS];
        for step in roughnesses.levels() {
            levels[step - 1] = self.rough[step - 1].as_ref();
        }
        let rough = Levels::new(&self.cube, &levels);
        Ok(EnvironmentLight::of(rough, packed, roughnesses))
    }

    /// The environment itself, a cube with mips.
    #[must_use]
    pub fn cube(&self) -> &Environment {
        &self.cube
    }

    /// The environment filtered by the lobe of a perceptual roughness, 0 to 1: around the centre of each texel, its mean with the weight
    /// `D(H) (L.R)`, as seen head on (Karis 2013). `size` is the height of a face; where the lobe leaves no detail for so many
    /// texels they are interpolated. A roughness of 0 gives the environment.
    ///
    /// # Errors
    /// [`LightError::LayoutSize`] as [`Environment::from_fn`] has them.
    pub fn ggx(
        &mut self,
        layout: EnvironmentLayout,
        size: u32,
        roughness: f32,
    ) -> Result<Environment, LightError> {
        let roughness = F32s::<Scalar>::clamp(roughness, 0.0, 1.0);
        if roughness == 0.0 {
            return self.cube.convert(layout, size);
        }
        self.resized(layout, size, side(roughness), |this, layout, size| {
            this.lobe(layout, size, roughness)
        })
    }

    /// Irradiance over pi: the light of a white diffuse surface that faces the centre of each texel.
    ///
    /// # Errors
    /// As [`ggx`](Self::ggx).
    pub fn irradiance(
        &mut self,
        layout: EnvironmentLayout,
        size: u32,
    ) -> Result<Environment, LightError> {
        self.resized(layout, size, DIFFUSE_SIZE, Self::cosine)
    }

    /// Made with `most` texels at most, and interpolated from there.
    fn resized(
        &mut self,
        layout: EnvironmentLayout,
        size: u32,
        most: u32,
        make: impl Fn(&mut Self, EnvironmentLayout, u32) -> Result<Environment, LightError>,
    ) -> Result<Environment, LightError> {
        // A face of the only one of a layout shows as much as six.
        let most = if layout.faces() == 6 { most } else { 2 * most };
        if size <= most {
            return make(self, layout, size);
        }
        make(self, layout, most)?.convert(layout, size)
    }

    pub(super) fn lobe(
        &mut self,
        layout: EnvironmentLayout,
        size: u32,
        roughness: f32,
    ) -> Result<Environment, LightError> {
        // The smallest are gathered from more: their patches of sixteen are wide.
        let source = if size > 16 { size } else { (2 * size).max(32) };
        self.gathered(layout, size, source, Kernel::ggx(roughness * roughness))
    }

    /// The light that diffuse surfaces receive: all of it, and that at grazing incidence.
    fn diffuse(&mut self) -> Result<[Environment; 2], LightError> {
        let layout = EnvironmentLayout::Cube;
        let grazing = self.gathered(layout, DIFFUSE_SIZE, DIFFUSE_SOURCE, Kernel::Grazing)?;
        Ok([self.cosine(layout, DIFFUSE_SIZE)?, grazing])
    }

    fn cosine(&mut self, layout: EnvironmentLayout, size: u32) -> Result<Environment, LightError> {
        self.gathered(layout, size, DIFFUSE_SOURCE, Kernel::Cosine)
    }

    /// Gathered from the level of the cube with at most `source` texels a side.
    fn gathered(
        &mut self,
        layout: EnvironmentLayout,
        size: u32,
        source: u32,
        kernel: Kernel,
    ) -> Result<Environment, LightError> {
        let levels = &self.cube.levels;
        let above = levels.iter().take_while(|level| level.width > source);
        let wanted = above.count().min(levels.len() - 1);
        let found = self.sources.iter().position(|(level, _)| *level == wanted);
        let source = found.unwrap_or(self.sources.len());
        if found.is_none() {
            self.sources.push((wanted, Texels::new(&self.cube, wanted)));
        }
        let (_, texels) = &self.sources[source];
        texels.lobe(kernel).environment(layout, size)
    }
}

//! Shadow maps: depths as a light sees them, and the ray of each texel.

mod look_up;
mod place;

use alloc::vec::Vec;

use texmap_math::glam::{DMat4, DVec2, DVec3};

use crate::error::{LightError, same_length};
pub use look_up::ShadowBias;
pub(crate) use look_up::{STEEP, STEEPEST};

/// Depths as a light sees them, in the metric in which they are compared: distance along the light's axis for parallel and
/// spot lights, distance from the light for point lights. Never the value of a depth buffer against a length.
#[derive(Clone, Debug, PartialEq)]
pub struct ShadowMap {
    kind: ShadowKind,
    /// Side of a face in texels.
    size: u32,
    /// Faces one after the other, rows top to bottom; infinity where the light sees nothing.
    depths: Vec<f32>,
}

/// Kind of the light that a shadow map belongs to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ShadowKind {
    /// Parallel light: a square of half-side `half` in the light's x and y.
    Directional {
        /// World to light space: looks along -Z, distances kept (no scale).
        light_from_world: DMat4,
        /// Half the side of the map, world units.
        half: f64,
    },
    /// A cone from a point, seen through a square pyramid.
    Spot {
        /// World to light space, the light in its origin, looking along -Z, distances kept.
        light_from_world: DMat4,
        /// Tangent of half the angle of the pyramid.
        tan_half: f64,
    },
    /// All around a point: six faces +X -X +Y -Y +Z -Z of 90 degrees, oriented as [`EnvironmentLayout::Cube`](crate::EnvironmentLayout::Cube).
    Point {
        /// The light.
        position: DVec3,
    },
}

impl ShadowMap {
    /// A map from depths.
    ///
    /// # Errors
    /// [`LightError::Length`] unless `depths` holds `size * size` values (six times that for a point light);
    /// [`LightError::Texel`] for a NaN or negative depth of a spot or point light.
    pub fn new(kind: ShadowKind, size: u32, depths: Vec<f32>) -> Result<Self, LightError> {
        same_length("depths", depths.len(), Self::count(&kind, size))?;
        let least = match kind {
            ShadowKind::Directional { .. } => f32::NEG_INFINITY,
            _ => 0.0,
        };
        // Without a way out of each part, many are compared at once.
        let good = |part: &[f32]| part.iter().fold(true, |good, d| good & (*d >= least));
        if depths.chunks(256).all(good) {
            return Ok(Self { kind, size, depths });
        }
        let bad = depths.iter().position(|d| d.is_nan() || *d < least);
        Err(LightError::Texel {
            index: bad.unwrap_or(0),
        })
    }

    /// [`new`](Self::new) for depths that the caller has found to be good.
    ///
    /// # Errors
    /// [`LightError::Length`], as there.
    #[doc(hidden)]
    pub fn from_valid(kind: ShadowKind, size: u32, depths: Vec<f32>) -> Result<Self, LightError> {
        same_length("depths", depths.len(), Self::count(&kind, size))?;
        Ok(Self { kind, size, depths })
    }

    /// Number of depths of a map.
    fn count(kind: &ShadowKind, size: u32) -> usize {
        let side = size.max(1) as usize;
        match kind {
            ShadowKind::Point { .. } => side.saturating_mul(side).saturating_mul(6),
            _ => side.saturating_mul(side),
        }
    }

    /// Origin and direction of the ray of a texel in world space, for the code that fills the map. `origin + depth * direction` is
    /// the point at a stored depth.
    #[must_use]
    pub fn ray(kind: &ShadowKind, size: u32, face: usize, x: u32, y: u32) -> (DVec3, DVec3) {
        let centre = |i: u32| (f64::from(i) + 0.5) / f64::from(size) * 2.0 - 1.0;
        let p = DVec2::new(centre(x), -centre(y));
        match kind {
            ShadowKind::Directional {
                light_from_world,
                half,
            } => {
                let world = light_from_world.inverse();
                (
                    world.transform_point3((p * *half).extend(0.0)),
                    world.transform_vector3(DVec3::NEG_Z),
                )
            }
            ShadowKind::Spot {
                light_from_world,
                tan_half,
            } => {
                let world = light_from_world.inverse();
                (
                    world.transform_point3(DVec3::ZERO),
                    world.transform_vector3((p * *tan_half).extend(-1.0)),
                )
            }
            ShadowKind::Point { position } => {
                let uv = DVec2::new(0.5 + 0.5 * p.x, 0.5 - 0.5 * p.y);
                (
                    *position,
                    crate::EnvironmentLayout::Cube.direction(face, uv),
                )
            }
        }
    }

    /// The stored depth of a texel; `None` outside of the map. For pictures of the map.
    #[must_use]
    pub fn depth_at(&self, face: usize, x: u32, y: u32) -> Option<f32> {
        if x >= self.size || y >= self.size {
            return None;
        }
        let side = self.size as usize;
        let row = face.checked_mul(side)?.checked_add(y as usize)?;
        let index = row.checked_mul(side)?.checked_add(x as usize)?;
        self.depths.get(index).copied()
    }

    /// Side of a face in texels.
    #[must_use]
    pub fn size(&self) -> u32 {
        self.size
    }

    pub(crate) fn depths(&self) -> &[f32] {
        &self.depths
    }

    /// The depths, to be used again; a map of size 0, in which everything is lit, is left.
    pub(crate) fn take_depths(&mut self) -> Vec<f32> {
        self.size = 0;
        core::mem::take(&mut self.depths)
    }

    /// The light that it belongs to.
    #[must_use]
    pub fn kind(&self) -> &ShadowKind {
        &self.kind
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn maps_are_checked() {
        let kind = ShadowKind::Directional {
            light_from_world: DMat4::IDENTITY,
            half: 2.6,
        };
        assert!(matches!(
            ShadowMap::new(kind, 4, alloc::vec![0.0; 15]),
            Err(LightError::Length { .. })
        ));
        assert_eq!(
            ShadowMap::new(kind, 1, alloc::vec![f32::NAN]),
            Err(LightError::Texel { index: 0 })
        );
        let point = ShadowKind::Point {
            position: DVec3::ZERO,
        };
        for kind in [kind, point] {
            let large = ShadowMap::new(kind, u32::MAX, Vec::new());
            assert!(matches!(large, Err(LightError::Length { .. })));
        }
        let map = ShadowMap::new(kind, 2, alloc::vec![0.5; 4]).unwrap();
        assert_eq!(map.depth_at(0, 1, 1), Some(0.5));
        for face in [1, 1 << 62, 1 << 63, usize::MAX] {
            assert_eq!(map.depth_at(face, 1, 1), None);
        }
    }
}

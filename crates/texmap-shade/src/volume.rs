//! Volumes: boxes of matter that shines and absorbs, between the eye and the opaque surface.

use texmap_math::glam::{DMat4, DVec3};
use texmap_math::simd::F32s;
use texmap_math::{Level, ViewRays};
use texmap_sample::{Sampler, Texture2d};

use crate::batch::{Batch, Colors};
use texmap_scene::{Scene, SceneError, Volume};

/// A volume as the stages read it.
pub struct VolumeStage<'s> {
    matter: texmap_sample::VolumeIntegrator<'s>,
    rays: ViewRays,
    /// The eye, and the matrix of directions, in the space of the grid.
    eye: DVec3,
    volume_from_view: DMat4,
    /// `depth = offset + scale / distance` along the view.
    depth: (f64, f64),
}

impl<'s> VolumeStage<'s> {
    /// A volume in front of everything opaque. `transfer` maps density to color.
    pub fn new(
        volume: &'s Volume,
        scene: &'s Scene,
        transfer: Option<(&'s Texture2d<'static>, &'s Sampler)>,
        rays: ViewRays,
        level: Level,
        view_from_world: DMat4,
        projection: DMat4,
    ) -> Result<Self, SceneError> {
        let grid = &scene.effects.grids[volume.grid];
        let matter = texmap_sample::VolumeIntegrator::new(
            grid,
            &volume.sampler,
            transfer,
            volume.density,
            volume.step,
        )
        .map_err(|error| SceneError::Value {
            place: format!("volume of grid {}", volume.grid),
            what: "its numbers".to_owned(),
            value: error.to_string(),
            expected: "see Scene::check",
        })?
        .on_level(level);
        let volume_from_world = volume.world_from_volume.inverse();
        Ok(Self {
            matter,
            rays,
            eye: volume_from_world.transform_point3(scene.camera.eye),
            volume_from_view: volume_from_world * view_from_world.inverse(),
            depth: (-projection.z_axis.z, projection.w_axis.z),
        })
    }

    /// The light that the volume sends to the eye at the fragments of a batch, clipped at 1, and its opacity.
    pub fn shade(&self, batch: &Batch<'_>, out: &mut Colors) {
        for (index, at, bit) in batch.fragments() {
            let ray = self.rays.through(batch.sample(at, bit));
            let length = ray.length();
            let along = self.volume_from_view.transform_vector3(ray / length);
            let (offset, scale) = self.depth;
            let near = f64::from(batch.depth(at, bit)) - offset;
            let solid = if near > 0.0 {
                scale / near * length
            } else {
                f64::INFINITY
            };
            let seen = self
                .matter
                .integrate(self.eye.to_array(), along.to_array(), (0.0, solid));
            let [r, g, b, a] = seen.color;
            let [r, g, b] = [r, g, b].map(|c| c.below(1.0));
            out.set(index, [r, g, b, a]);
        }
    }
}

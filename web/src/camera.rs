//! The camera of a request.

use serde::Deserialize;
use texmap_math::glam::DVec3;
use texmap_scene::Scene;

/// Parts of a camera that replace those of the scene, as `--camera-eye`, `--camera-look`, `--camera-up` and `--fov` do.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
pub(crate) struct CameraAt {
    eye: Option<[f64; 3]>,
    look: Option<[f64; 3]>,
    up: Option<[f64; 3]>,
    fov: Option<f64>,
}

impl CameraAt {
    pub(crate) fn set(&self, scene: &mut Scene) {
        let camera = &mut scene.camera;
        for (part, given) in [
            (&mut camera.eye, self.eye),
            (&mut camera.look, self.look),
            (&mut camera.up, self.up),
        ] {
            if let Some(given) = given {
                *part = DVec3::from(given);
            }
        }
        if let Some(degrees) = self.fov {
            camera.fov_x = degrees.to_radians();
        }
    }
}

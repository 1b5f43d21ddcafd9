//! The least that a scene needs.

use texmap_math::Camera;
use texmap_math::glam::DVec3;
use texmap_scene::{ColorMode, Mesh, Scene};

/// Raw colours, black opaque background, no light, nothing in it. The camera stands in the origin, looks along -Z and sees
/// 90 degrees.
#[must_use]
pub fn empty() -> Scene {
    Scene {
        color: ColorMode::Raw,
        ..Scene::new(Camera {
            eye: DVec3::ZERO,
            look: DVec3::NEG_Z,
            up: DVec3::Y,
            fov_x: std::f64::consts::FRAC_PI_2,
            near: 1e-4,
            far: f64::INFINITY,
        })
    }
}

/// Four corners, counter-clockwise from the lower left, as two triangles with the whole texture on them.
#[must_use]
pub fn quad(positions: [[f32; 3]; 4]) -> Mesh {
    Mesh {
        positions: positions.to_vec(),
        uvs: vec![[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    }
}

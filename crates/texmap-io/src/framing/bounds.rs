//! The bounding sphere of a scene.

use texmap_math::camera::Camera;
use texmap_math::deterministic_f64;
use texmap_math::glam::DVec3;
use texmap_scene::Scene;

use super::{Up, View};

/// A sphere around all vertices: centre of their bounding box, radius to the farthest one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    /// World position.
    pub center: DVec3,
    /// 0 for a single point.
    pub radius: f64,
}

impl Bounds {
    /// `None` for a scene without vertices.
    pub fn of(scene: &Scene) -> Option<Self> {
        let points = || {
            scene.meshes.iter().flat_map(|mesh| {
                let used = mesh.triangles.as_flattened().iter();
                used.map(|&i| {
                    mesh.world_from_object
                        .transform_point3(DVec3::from(mesh.positions[i as usize].map(f64::from)))
                })
            })
        };
        let first = points().next()?;
        let (low, high) = points().fold((first, first), |(low, high), p| (low.min(p), high.max(p)));
        let center = (low + high) * 0.5;
        let radius = points()
            .fold(0.0_f64, |r, p| r.max((p - center).length_squared()))
            .sqrt();
        Some(Self { center, radius })
    }

    /// A camera that shows the whole sphere in a picture of `aspect` = width / height, with a margin of 5 %.
    /// `fov_x` in radians.
    pub fn camera(&self, view: View, fov_x: f64, aspect: f64) -> Camera {
        let half_x = 0.5 * fov_x;
        let half_y = deterministic_f64::atan(deterministic_f64::tan(half_x) / aspect);
        let radius = if self.radius > 0.0 { self.radius } else { 1.0 };
        let distance = 1.05 * radius / deterministic_f64::sin(half_x.min(half_y));
        let direction = view.direction(Up::Y);
        Camera {
            eye: self.center + direction * (distance / direction.length()),
            look: self.center,
            up: view.up(Up::Y),
            fov_x,
            near: distance * 1e-3,
            far: f64::INFINITY,
            lens: Default::default(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::framing::AUTO_FOV;

    #[test]
    fn the_whole_sphere_is_inside_the_picture_from_every_side() {
        let bounds = Bounds {
            center: DVec3::new(3.0, -2.0, 7.0),
            radius: 2.5,
        };
        for (name, view) in View::ALL {
            assert_eq!(name.parse(), Ok(view));
            assert_eq!(view.name(), name);
            for aspect in [0.5, 1.0, 16.0 / 9.0] {
                let camera = bounds.camera(view, AUTO_FOV, aspect);
                let clip = camera.clip_from_world(aspect).unwrap();
                // Points of the sphere on a coarse grid of directions.
                for x in -2..=2 {
                    for y in -2..=2 {
                        for z in -2..=2 {
                            let d = DVec3::new(f64::from(x), f64::from(y), f64::from(z));
                            if d == DVec3::ZERO {
                                continue;
                            }
                            let p = bounds.center + d / d.length() * bounds.radius;
                            let c = clip * p.extend(1.0);
                            assert!(
                                c.w > camera.near && c.x.abs() <= c.w && c.y.abs() <= c.w,
                                "{name} {aspect}"
                            );
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn a_camera_a_little_too_near_would_fail_that_test() {
        let bounds = Bounds {
            center: DVec3::ZERO,
            radius: 1.0,
        };
        let mut camera = bounds.camera(View::Front, AUTO_FOV, 1.0);
        camera.eye *= 0.6;
        let c = camera.clip_from_world(1.0).unwrap() * DVec3::X.extend(1.0);
        assert!(c.x.abs() > c.w);
    }
}

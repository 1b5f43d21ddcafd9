//! Coordinates of a point in a shadow map. They are face, texel, depth, and the slope of the depth over the plane of the point.

use texmap_math::float::sqrt;
use texmap_math::glam::{DVec2, DVec3};

use super::{ShadowKind, ShadowMap};
use crate::cube_face::direction_of;

/// Coordinates of a point in a map.
pub(super) struct Place {
    pub(super) face: usize,
    /// Texels from the top left.
    pub(super) texel: DVec2,
    pub(super) depth: f64,
    /// Change of the receiver's depth per texel, if its plane is not seen edge-on.
    pub(super) slope: DVec2,
    /// World size of a texel there.
    pub(super) texel_size: f64,
}

impl ShadowMap {
    /// Coordinates of a point on a plane of this normal; `None` outside of the map.
    pub(super) fn place(&self, point: DVec3, normal: DVec3) -> Option<Place> {
        if !point.is_finite() {
            return None;
        }
        let size = f64::from(self.size);
        match self.kind {
            ShadowKind::Directional {
                light_from_world,
                half,
            } => {
                let p = light_from_world.transform_point3(point);
                let n = light_from_world.transform_vector3(normal);
                let texel_size = 2.0 * half / size;
                // z = -depth falls along the plane n.p = c: d(depth)/dx = n.x / n.z.
                let slope = if n.z != 0.0 {
                    DVec2::new(n.x, -n.y) / n.z * texel_size
                } else {
                    DVec2::ZERO
                };
                self.at(0, p.truncate() / half, -p.z, slope, texel_size)
            }
            ShadowKind::Spot {
                light_from_world,
                tan_half,
            } => {
                let p = light_from_world.transform_point3(point);
                if p.z.is_nan() || p.z >= 0.0 {
                    return None;
                }
                let depth = -p.z;
                let ray = p / depth;
                let n = light_from_world.transform_vector3(normal);
                let step = 2.0 * tan_half / size;
                // On the plane n.(depth ray) = c, depth = c / n.ray.
                let slope = DVec2::new(n.x, -n.y) * (-depth * step / n.dot(ray));
                self.at(0, ray.truncate() / tan_half, depth, slope, depth * step)
            }
            ShadowKind::Point { position } => {
                let d = point - position;
                let (face, uv) = crate::EnvironmentLayout::Cube.locate(d);
                let distance = sqrt(d.dot(d));
                let major = d.abs().max_element();
                if !(major > 0.0 && distance.is_finite()) {
                    return None;
                }
                let ray = d / major;
                let step = 2.0 / size;
                let axis = |of| DVec3::from(direction_of(face, of).map(f64::from));
                let (right, down) = (axis([1.0, 0.0, 0.0]), axis([0.0, 1.0, 0.0]));
                // distance = c |ray| / n.ray on the receiver's plane.
                let along = |axis: DVec3| {
                    (distance * (ray.dot(axis) / ray.dot(ray) - normal.dot(axis) / normal.dot(ray)))
                        * step
                };
                let slope = DVec2::new(along(right), along(down));
                let p = DVec2::new(2.0 * uv.x - 1.0, 1.0 - 2.0 * uv.y);
                self.at(face, p, distance, slope, major * step)
            }
        }
    }

    /// `p` in -1..=1 over the face, y up.
    fn at(
        &self,
        face: usize,
        p: DVec2,
        depth: f64,
        slope: DVec2,
        texel_size: f64,
    ) -> Option<Place> {
        let texel = DVec2::new(p.x * 0.5 + 0.5, 0.5 - p.y * 0.5) * f64::from(self.size);
        // Clamped before it becomes an integer: coordinates of 1e30 are outside, not an overflow.
        let inside = texel.min_element() >= 0.0
            && texel.max_element() < f64::from(self.size) + 1e-9
            && depth.is_finite();
        let last = f64::from(self.size) - 0.5;
        let texel = DVec2::new(
            if texel.x < last { texel.x } else { last },
            if texel.y < last { texel.y } else { last },
        );
        let slope = if slope.is_finite() {
            slope
        } else {
            DVec2::splat(f64::MAX)
        };
        inside.then_some(Place {
            face,
            texel,
            depth,
            slope,
            texel_size,
        })
    }
}

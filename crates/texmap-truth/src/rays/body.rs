//! The bodies that rays meet: a triangle of a mesh or a unit solid, placed in the world, with a box around it.

use rstar::{AABB, RTreeObject};
use texmap_math::glam::{DMat3, DMat4, DVec2, DVec3};
use texmap_scene::Mesh;
use texmap_uv::{Origin, Shape, ShapeFace};

use super::RayHit;
use super::solids;
use crate::frame::{wide, world};

#[derive(Debug)]
pub(super) struct Body {
    kind: Kind,
    object: usize,
    bounds: AABB<[f64; 3]>,
}

#[derive(Debug)]
enum Kind {
    Triangle {
        corners: [DVec3; 3],
        normals: Option<[DVec3; 3]>,
        uvs: Option<[DVec2; 3]>,
        index: u32,
        mirrored: bool,
    },
    Solid {
        shape: Shape,
        object_from_world: DMat4,
        normal_to_world: DMat3,
    },
}

impl RTreeObject for Body {
    type Envelope = AABB<[f64; 3]>;

    fn envelope(&self) -> Self::Envelope {
        self.bounds
    }
}

impl Body {
    /// Object and triangle (0 of a solid).
    pub(super) fn source(&self) -> (usize, u32) {
        match self.kind {
            Kind::Triangle { index, .. } => (self.object, index),
            Kind::Solid { .. } => (self.object, 0),
        }
    }

    pub(super) fn meet(
        &self,
        origin: DVec3,
        direction: DVec3,
        range: (f64, f64),
    ) -> Option<RayHit> {
        match &self.kind {
            Kind::Triangle {
                corners: [a, b, c],
                normals,
                uvs,
                index,
                mirrored,
            } => {
                let (u, v) = (*b - *a, *c - *a);
                let (t, weights) = triangle(origin, direction, *a, u, v)?;
                if !(t > range.0 && t < range.1) {
                    return None;
                }
                let flat = if *mirrored { v.cross(u) } else { u.cross(v) };
                let smooth = normals
                    .map(|n| n[0] * weights.x + n[1] * weights.y + n[2] * weights.z)
                    .filter(|n| n.length_squared() > 0.0);
                Some(RayHit {
                    t,
                    point: origin + direction * t,
                    normal: smooth.unwrap_or(flat).normalize(),
                    uv: uvs.map(|uv| uv[0] * weights.x + uv[1] * weights.y + uv[2] * weights.z),
                    part: ShapeFace::Whole,
                    object: self.object,
                    triangle: *index,
                    weights,
                })
            }
            Kind::Solid {
                shape,
                object_from_world,
                normal_to_world,
            } => {
                let o = object_from_world.transform_point3(origin);
                let d = object_from_world.transform_vector3(direction);
                let (t, normal) = solids::meet(*shape, o, d, range)?;
                let (part, uv) = shape.uv(o + d * t, Origin::TopLeft);
                Some(RayHit {
                    t,
                    point: origin + direction * t,
                    normal: (*normal_to_world * normal).normalize(),
                    uv: Some(DVec2::from(uv)),
                    part,
                    object: self.object,
                    triangle: 0,
                    weights: DVec3::ZERO,
                })
            }
        }
    }
}

/// Distance of a ray to the plane of a triangle `a, a + u, a + v`, and the corner weights there, if it meets the triangle or its
/// edge. Source: Moeller and Trumbore 1997.
fn triangle(o: DVec3, d: DVec3, a: DVec3, u: DVec3, v: DVec3) -> Option<(f64, DVec3)> {
    let p = d.cross(v);
    let det = u.dot(p);
    let s = o - a;
    let q = s.cross(u);
    let (b, c, t) = (s.dot(p) / det, d.dot(q) / det, v.dot(q) / det);
    (b >= 0.0 && c >= 0.0 && b + c <= 1.0 && t.is_finite())
        .then(|| (t, DVec3::new(1.0 - b - c, b, c)))
}

pub(super) fn push_mesh(mesh: &Mesh, object: usize, bodies: &mut Vec<Body>) {
    let world = world(mesh);
    let linear = DMat3::from_mat4(mesh.world_from_object);
    let to_world = linear.inverse().transpose();
    let mirrored = linear.determinant() < 0.0;
    for (index, corners) in mesh.triangles.iter().enumerate() {
        let at = corners.map(|v| world[v as usize]);
        let area = (at[1] - at[0]).cross(at[2] - at[0]);
        if !area.is_finite() || area == DVec3::ZERO {
            continue;
        }
        let uv = |v: u32| {
            mesh.uvs
                .get(v as usize)
                .map(|uv| DVec2::from(uv.map(f64::from)))
        };
        let normal = |v: u32| {
            let n = mesh.normals.get(v as usize)?;
            Some((to_world * wide(*n)).normalize_or_zero())
        };
        bodies.push(Body {
            bounds: bounds(&at),
            kind: Kind::Triangle {
                corners: at,
                normals: all(corners.map(normal)),
                uvs: all(corners.map(uv)),
                index: index as u32,
                mirrored,
            },
            object,
        });
    }
}

fn all<T: Copy>([a, b, c]: [Option<T>; 3]) -> Option<[T; 3]> {
    Some([a?, b?, c?])
}

pub(super) fn solid(shape: Shape, world: DMat4, object: usize) -> Option<Body> {
    let determinant = world.determinant();
    if !determinant.is_finite() || determinant == 0.0 {
        return None;
    }
    let corner = |i: u32| {
        let side = |bit: u32| if i >> bit & 1 == 0 { -0.5 } else { 0.5 };
        world.transform_point3(DVec3::new(side(0), side(1), side(2)))
    };
    let corners: Vec<DVec3> = (0..8).map(corner).collect();
    Some(Body {
        bounds: bounds(&corners),
        kind: Kind::Solid {
            shape,
            object_from_world: world.inverse(),
            normal_to_world: DMat3::from_mat4(world).inverse().transpose(),
        },
        object,
    })
}

/// A box around points, a little larger, so that flat things keep a thickness.
fn bounds(points: &[DVec3]) -> AABB<[f64; 3]> {
    let low = points.iter().copied().fold(DVec3::INFINITY, DVec3::min);
    let high = points.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
    let air = DVec3::splat(1e-9 * (1.0 + low.abs().max(high.abs()).max_element()));
    AABB::from_bounds((low - air).to_array(), (high + air).to_array())
}

#[cfg(test)]
mod tests {
    use super::super::tests::{EVERYWHERE, noise};
    use super::super::{RayObject, RayScene};
    use super::*;

    /// Normals of a squeezed and mirrored ball by the inverse transpose, against the gradient of its equation. The matrix itself
    /// must fail.
    #[test]
    fn normals_go_by_the_inverse_transpose() {
        let world = DMat4::from_translation(DVec3::new(1.0, 2.0, -3.0))
            * DMat4::from_axis_angle(DVec3::new(1.0, 1.0, 0.0).normalize(), 0.7)
            * DMat4::from_scale(DVec3::new(-3.0, 0.5, 1.5));
        let scene = RayScene::new([RayObject::Solid(Shape::Sphere, world)]);
        let inverse = world.inverse();
        let implicit = |p: DVec3| inverse.transform_point3(p).length_squared();
        let (mut seed, mut worst, mut naive, mut met) = (9, 0.0f64, 0.0f64, 0);
        for _ in 0..2_000 {
            let mut v = || DVec3::new(noise(&mut seed), noise(&mut seed), noise(&mut seed));
            let origin = DVec3::new(1.0, 2.0, -3.0) + v() * 6.0;
            let target = DVec3::new(1.0, 2.0, -3.0) + v() * 0.4;
            if implicit(origin) < 0.3 {
                continue;
            }
            let Some(hit) = scene.nearest(origin, target - origin, EVERYWHERE) else {
                continue;
            };
            met += 1;
            let h = 1e-6;
            let gradient = DVec3::from_array(
                [DVec3::X, DVec3::Y, DVec3::Z]
                    .map(|a| implicit(hit.point + a * h) - implicit(hit.point - a * h)),
            )
            .normalize();
            worst = worst.max((gradient - hit.normal).length());
            let straight = world.transform_vector3(inverse.transform_point3(hit.point));
            naive = naive.max((gradient - straight.normalize()).length());
        }
        assert!(met > 1_000 && worst < 1e-7, "{met} {worst:e}");
        assert!(naive > 0.5, "{naive}");
    }
}

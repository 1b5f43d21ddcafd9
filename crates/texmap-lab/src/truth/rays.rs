//! A ray tracer in f64: what light and mirrors really do, for whatever is judged by it. Meshes and the unit solids, hard shadows,
//! shadows of area lights, mirror rays; a bounding volume hierarchy finds what a ray may meet.

use bvh::aabb::{Aabb, Bounded};
use bvh::bounding_hierarchy::BHShape;
use bvh::bvh::Bvh;
use bvh::ray::Ray;
use nalgebra::{Point3, Vector3};
use texmap_math::glam::{DMat3, DMat4, DVec2, DVec3};
use texmap_render::Mesh;
use texmap_uv::{Origin, Part, Shape};

use super::{solids, wide};

/// Everything that rays can meet, in world space.
#[derive(Debug)]
pub struct RayScene {
    bodies: Vec<Body>,
    tree: Option<Bvh<f64, 3>>,
}

/// Where a ray meets a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayHit {
    /// The point is `origin + t direction`.
    pub t: f64,
    /// The point, world space.
    pub point: DVec3,
    /// Unit normal in world space, outwards (for triangles: of the counter-clockwise side): interpolated where a mesh has normals.
    pub normal: DVec3,
    /// Texture coordinates: v down for solids, as they are in the mesh for meshes; `None` for a mesh without.
    pub uv: Option<DVec2>,
    /// The part of a solid, whole for a mesh.
    pub part: Part,
    /// The object, counted as they were given.
    pub object: usize,
    /// Triangle of a mesh, 0 for a solid.
    pub triangle: u32,
    /// Weights over the triangle's corners, 0 for a solid.
    pub weights: DVec3,
}

/// What a ray scene is made of.
#[derive(Clone, Copy, Debug)]
pub enum RayObject<'a> {
    /// Triangles under the mesh's own transform.
    Mesh(&'a Mesh),
    /// A unit solid (-0.5..=0.5), object to world. A matrix without an inverse makes it invisible.
    Solid(Shape, DMat4),
}

/// A rectangle that shines.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AreaLight {
    /// One corner.
    pub corner: DVec3,
    /// From it along one side.
    pub u: DVec3,
    /// And along the other.
    pub v: DVec3,
}

#[derive(Debug)]
struct Body {
    kind: Kind,
    object: usize,
    bounds: [DVec3; 2],
    node: usize,
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

impl Bounded<f64, 3> for Body {
    fn aabb(&self) -> Aabb<f64, 3> {
        let point = |p: DVec3| Point3::new(p.x, p.y, p.z);
        Aabb::with_bounds(point(self.bounds[0]), point(self.bounds[1]))
    }
}

impl BHShape<f64, 3> for Body {
    fn set_bh_node_index(&mut self, index: usize) {
        self.node = index;
    }

    fn bh_node_index(&self) -> usize {
        self.node
    }
}

impl RayScene {
    /// A scene of these objects; `RayHit::object` counts them in this order. Triangles without area and those with a corner that is
    /// not finite are left out.
    pub fn new<'a>(objects: impl IntoIterator<Item = RayObject<'a>>) -> Self {
        let mut bodies = Vec::new();
        for (object, item) in objects.into_iter().enumerate() {
            match item {
                RayObject::Mesh(mesh) => push_mesh(mesh, object, &mut bodies),
                RayObject::Solid(shape, world) => bodies.extend(solid(shape, world, object)),
            }
        }
        let tree = (!bodies.is_empty()).then(|| Bvh::build(&mut bodies));
        Self { bodies, tree }
    }

    /// The nearest surface with `range.0 < t < range.1` along `origin + t direction`, seen from either side.
    pub fn nearest(&self, origin: DVec3, direction: DVec3, range: (f64, f64)) -> Option<RayHit> {
        let mut best: Option<RayHit> = None;
        self.visit(origin, direction, |body| {
            let far = best.map_or(range.1, |hit| hit.t);
            if let Some(hit) = body.meet(origin, direction, (range.0, far)) {
                best = Some(hit);
            }
            true
        });
        best
    }

    /// Whether anything stands between a point and a place: hits at `0 < t < 1` of the way count.
    pub fn blocked(&self, point: DVec3, place: DVec3) -> bool {
        self.meets(point, place - point, (0.0, 1.0))
    }

    /// Whether anything is met at all along a ray.
    pub fn meets(&self, origin: DVec3, direction: DVec3, range: (f64, f64)) -> bool {
        let mut met = false;
        self.visit(origin, direction, |body| {
            met |= body.meet(origin, direction, range).is_some();
            !met
        });
        met
    }

    /// Share of an area light that a point sees, 0..=1: rays to the centres of `side` x `side` equal parts. A hard shadow for 1.
    pub fn sees(&self, point: DVec3, light: &AreaLight, side: u32) -> f64 {
        let side = side.max(1);
        let place = |i: u32| (f64::from(i) + 0.5) / f64::from(side);
        let free = (0..side * side)
            .filter(|i| {
                let to = light.corner + light.u * place(i % side) + light.v * place(i / side);
                !self.blocked(point, to)
            })
            .count();
        free as f64 / f64::from(side * side)
    }

    /// The mirror ray at a hit: its origin, lifted off the surface by `lift`, and its direction, of the length of `direction`.
    pub fn mirror(hit: &RayHit, direction: DVec3, lift: f64) -> (DVec3, DVec3) {
        let toward_eye = texmap_math::reflection::reflect(-direction, hit.normal);
        let side = if hit.normal.dot(direction) > 0.0 {
            -1.0
        } else {
            1.0
        };
        (hit.point + hit.normal * (side * lift), toward_eye)
    }

    /// Bodies whose boxes the ray meets, until `go_on` says no.
    fn visit(&self, origin: DVec3, direction: DVec3, mut go_on: impl FnMut(&Body) -> bool) {
        let Some(tree) = &self.tree else { return };
        if !(origin.is_finite() && direction.is_finite()) || direction == DVec3::ZERO {
            return;
        }
        let ray = Ray::new(
            Point3::new(origin.x, origin.y, origin.z),
            Vector3::new(direction.x, direction.y, direction.z),
        );
        for body in tree.traverse_iterator(&ray, &self.bodies) {
            if !go_on(body) {
                return;
            }
        }
    }
}

impl Body {
    fn meet(&self, origin: DVec3, direction: DVec3, range: (f64, f64)) -> Option<RayHit> {
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
                    part: Part::Whole,
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

/// Where a ray meets the plane of a triangle `a, a + u, a + v`, and the corner weights there, if it meets the triangle or its edge
/// (Moeller and Trumbore 1997).
fn triangle(o: DVec3, d: DVec3, a: DVec3, u: DVec3, v: DVec3) -> Option<(f64, DVec3)> {
    let p = d.cross(v);
    let det = u.dot(p);
    let s = o - a;
    let q = s.cross(u);
    let (b, c, t) = (s.dot(p) / det, d.dot(q) / det, v.dot(q) / det);
    (b >= 0.0 && c >= 0.0 && b + c <= 1.0 && t.is_finite())
        .then(|| (t, DVec3::new(1.0 - b - c, b, c)))
}

fn push_mesh(mesh: &Mesh, object: usize, bodies: &mut Vec<Body>) {
    let world = super::world(mesh);
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
            node: 0,
        });
    }
}

fn all<T: Copy>([a, b, c]: [Option<T>; 3]) -> Option<[T; 3]> {
    Some([a?, b?, c?])
}

fn solid(shape: Shape, world: DMat4, object: usize) -> Option<Body> {
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
        node: 0,
    })
}

/// A box around points, a little larger, so that flat things keep a thickness.
fn bounds(points: &[DVec3]) -> [DVec3; 2] {
    let low = points.iter().copied().fold(DVec3::INFINITY, DVec3::min);
    let high = points.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
    let air = DVec3::splat(1e-9 * (1.0 + low.abs().max(high.abs()).max_element()));
    [low - air, high + air]
}

#[cfg(test)]
mod tests {
    use super::*;
    use texmap_math::camera::Camera;

    const EVERYWHERE: (f64, f64) = (0.0, f64::INFINITY);

    fn grid(n: u32) -> Mesh {
        let mut mesh = Mesh::default();
        let at = |i: u32| f64::from(i) / f64::from(n) * 2.0 - 1.0;
        for (i, j) in (0..=n).flat_map(|j| (0..=n).map(move |i| (i, j))) {
            let (x, y) = (at(i), at(j));
            mesh.positions.push([
                x as f32,
                y as f32,
                (0.3 * (3.0 * x).sin() * (2.0 * y).cos()) as f32,
            ]);
            mesh.uvs
                .push([(0.5 * x + 0.5) as f32, (0.5 - 0.5 * y) as f32]);
        }
        for (i, j) in (0..n).flat_map(|j| (0..n).map(move |i| (i, j))) {
            let a = j * (n + 1) + i;
            mesh.triangles.push([a, a + 1, a + n + 2]);
            mesh.triangles.push([a, a + n + 2, a + n + 1]);
        }
        mesh
    }

    fn noise(seed: &mut u32) -> f64 {
        *seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(*seed >> 8) / f64::from(1 << 23) - 1.0
    }

    /// The hierarchy drops nothing and the nearest is the nearest: against a loop over all triangles.
    #[test]
    fn the_tree_finds_what_a_loop_finds() {
        let mesh = grid(12);
        let scene = RayScene::new([RayObject::Mesh(&mesh)]);
        let (mut seed, mut met) = (5, 0);
        for _ in 0..3_000 {
            let mut v = || DVec3::new(noise(&mut seed), noise(&mut seed), noise(&mut seed));
            let (o, d) = (v() * 2.0, v());
            let all = scene.bodies.iter().filter_map(|b| b.meet(o, d, EVERYWHERE));
            let expected = all.map(|hit| hit.t).fold(f64::INFINITY, f64::min);
            let found = scene
                .nearest(o, d, EVERYWHERE)
                .map_or(f64::INFINITY, |hit| hit.t);
            assert_eq!(found, expected);
            assert_eq!(scene.meets(o, d, EVERYWHERE), found.is_finite());
            met += u32::from(found.is_finite());
        }
        assert!(met > 200, "{met}");
    }

    /// uv and position of the caster of whole frames, a code path that shares nothing with this one.
    #[test]
    fn eye_rays_see_what_the_frame_caster_sees() {
        use crate::reference::{Caster, Pinhole};
        let mesh = grid(6);
        let camera = Camera {
            eye: DVec3::new(0.5, -2.0, 2.5),
            look: DVec3::ZERO,
            up: DVec3::Z,
            fov_x: 0.9,
            near: 1e-3,
            far: f64::INFINITY,
        };
        let corners: Vec<_> = mesh
            .triangles
            .iter()
            .map(|t| t.map(|v| wide(mesh.positions[v as usize])))
            .collect();
        let pinhole = Pinhole::of_camera(&camera, 40, 40).unwrap();
        let caster = Caster::new(pinhole, 40, 40, &corners);
        let scene = RayScene::new([RayObject::Mesh(&mesh)]);
        let mut seen = 0;
        for (x, y) in (0..40).flat_map(|y| (0..40).map(move |x| (x, y))) {
            let (px, py) = (f64::from(x) + 0.5, f64::from(y) + 0.5);
            let expected = caster.nearest(px, py, false);
            let found = scene.nearest(pinhole.eye, pinhole.direction(px, py), EVERYWHERE);
            assert_eq!(
                expected.as_ref().map(|h| h.triangle),
                found.map(|h| h.triangle)
            );
            let (Some(a), Some(b)) = (expected, found) else {
                continue;
            };
            seen += 1;
            let uv = |k: usize| {
                a.attribute(
                    mesh.triangles[a.triangle as usize].map(|v| f64::from(mesh.uvs[v as usize][k])),
                )
            };
            let found = b.uv.unwrap();
            assert!((found - DVec2::new(uv(0), uv(1))).length() < 1e-12);
        }
        assert!(seen > 500, "{seen}");
    }

    /// Normals of a squeezed and mirrored ball by the inverse transpose, against the gradient of its equation; the matrix itself
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

    /// A square before a small lamp: umbra, half shadow and light where similar triangles put them.
    #[test]
    fn area_lights_have_penumbrae_of_the_right_width() {
        let plate = RayObject::Solid(
            Shape::Plane,
            DMat4::from_translation(DVec3::new(0.0, 0.0, 1.0)),
        );
        let scene = RayScene::new([plate]);
        // Lamp of side 0.4 at height 3 over the plate of side 1 at height 1.
        let lamp = AreaLight {
            corner: DVec3::new(-0.2, -0.2, 3.0),
            u: DVec3::X * 0.4,
            v: DVec3::Y * 0.4,
        };
        let at = |x: f64| scene.sees(DVec3::new(x, 0.0, 0.0), &lamp, 40);
        // The plate's edge throws the lamp's ends to 0.75 -+ 0.1.
        assert_eq!((at(0.0), at(0.64), at(0.86)), (0.0, 0.0, 1.0));
        assert!((at(0.75) - 0.5).abs() < 0.03);
        assert!((at(0.70) - 0.25).abs() < 0.03 && (at(0.80) - 0.75).abs() < 0.03);
        let hard = |x: f64| scene.sees(DVec3::new(x, 0.0, 0.0), &lamp, 1);
        assert_eq!((hard(0.74), hard(0.76)), (0.0, 1.0));
    }

    #[test]
    fn mirrors_keep_the_angle_and_start_off_the_surface() {
        let ball = RayObject::Solid(Shape::Sphere, DMat4::from_scale(DVec3::splat(2.0)));
        let scene = RayScene::new([ball]);
        let (eye, d) = (DVec3::new(0.3, 0.2, 5.0), DVec3::new(0.0, 0.1, -1.0));
        let hit = scene.nearest(eye, d, EVERYWHERE).unwrap();
        let (origin, mirrored) = RayScene::mirror(&hit, d, 1e-9);
        assert!((mirrored.length() - d.length()).abs() < 1e-12);
        assert!((mirrored.dot(hit.normal) + d.dot(hit.normal)).abs() < 1e-12);
        assert!(origin.length() > 1.0 && !scene.meets(origin, mirrored, EVERYWHERE));
    }

    #[test]
    fn nothing_and_nonsense_are_met_by_no_ray() {
        let empty = RayScene::new([]);
        assert_eq!(empty.nearest(DVec3::ZERO, DVec3::X, EVERYWHERE), None);
        let mut mesh = grid(1);
        mesh.positions[0] = [f32::NAN, 0.0, 0.0];
        mesh.triangles.push([1, 1, 2]);
        let flat = RayObject::Solid(Shape::Box, DMat4::from_scale(DVec3::new(1.0, 0.0, 1.0)));
        let scene = RayScene::new([RayObject::Mesh(&mesh), flat]);
        assert!(scene.bodies.is_empty());
        let ball = RayScene::new([RayObject::Solid(Shape::Sphere, DMat4::IDENTITY)]);
        assert!(!ball.meets(DVec3::new(0.0, 0.0, 3.0), DVec3::ZERO, EVERYWHERE));
        assert!(!ball.meets(DVec3::splat(f64::NAN), DVec3::X, EVERYWHERE));
    }
}

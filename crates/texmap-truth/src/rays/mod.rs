//! A ray tracer in f64: what light and mirrors really do, for whatever is judged by it. Meshes and the unit solids, hard shadows,
//! shadows of area lights, mirror rays; an R-tree of their boxes finds the candidates of a ray.

mod body;
mod solids;
mod walk;

use rstar::RTree;
use texmap_math::glam::{DMat4, DVec2, DVec3};
use texmap_scene::Mesh;
use texmap_uv::{Shape, ShapeFace};

use body::{Body, push_mesh, solid};

/// Everything that rays can meet, in world space.
#[derive(Debug)]
pub struct RayScene {
    tree: RTree<Body>,
}

/// The hit of a ray on a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayHit {
    /// The point is `origin + t direction`.
    pub t: f64,
    /// The point, world space.
    pub point: DVec3,
    /// Unit normal in world space, outwards (for triangles: of the counter-clockwise side): interpolated where a mesh has normals.
    pub normal: DVec3,
    /// Texture coordinates: v down for solids, as they are in the mesh for meshes. `None` for a mesh without.
    pub uv: Option<DVec2>,
    /// The part of a solid, whole for a mesh.
    pub part: ShapeFace,
    /// The object, counted as they were given.
    pub object: usize,
    /// Triangle of a mesh, 0 for a solid.
    pub triangle: u32,
    /// Weights over the triangle's corners, 0 for a solid.
    pub weights: DVec3,
}

/// An object of a ray scene.
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
        Self {
            tree: RTree::bulk_load(bodies),
        }
    }

    /// The nearest surface with `range.0 < t < range.1` along `origin + t direction`, seen from either side.
    pub fn nearest(&self, origin: DVec3, direction: DVec3, range: (f64, f64)) -> Option<RayHit> {
        let mut best: Option<RayHit> = None;
        self.walk(origin, direction, range, |body, range| {
            if let Some(hit) = body.meet(origin, direction, range) {
                best = Some(hit);
                return Some(hit.t);
            }
            Some(range.1)
        });
        best
    }

    /// True if anything stands between two points: hits at `0 < t < 1` of the way count.
    pub fn blocked(&self, point: DVec3, place: DVec3) -> bool {
        self.meets(point, place - point, (0.0, 1.0))
    }

    /// True if a ray meets anything within a range of t.
    pub fn meets(&self, origin: DVec3, direction: DVec3, range: (f64, f64)) -> bool {
        self.meets_any(origin, direction, range, |_| true)
    }

    /// True if some hit along a ray counts.
    pub(crate) fn meets_any(
        &self,
        origin: DVec3,
        direction: DVec3,
        range: (f64, f64),
        mut counts: impl FnMut(&RayHit) -> bool,
    ) -> bool {
        let mut met = false;
        self.walk(origin, direction, range, |body, range| {
            met = body
                .meet(origin, direction, range)
                .is_some_and(|hit| counts(&hit));
            (!met).then_some(range.1)
        });
        met
    }

    /// Object and triangle of everything whose box a ray meets, nearer boxes first. The visitor gets the end of the range and returns
    /// that of what is left.
    pub(crate) fn candidates(
        &self,
        origin: DVec3,
        direction: DVec3,
        range: (f64, f64),
        mut each: impl FnMut((usize, u32), f64) -> f64,
    ) {
        self.walk(origin, direction, range, |body, range| {
            Some(each(body.source(), range.1))
        });
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
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::wide;
    use texmap_math::camera::Camera;

    pub(super) const EVERYWHERE: (f64, f64) = (0.0, f64::INFINITY);

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

    pub(super) fn noise(seed: &mut u32) -> f64 {
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
            let all = scene.tree.iter().filter_map(|b| b.meet(o, d, EVERYWHERE));
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
        use crate::caster::{Caster, Pinhole};
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

    /// Things of ever smaller size make a hierarchy as deep as they are many.
    #[test]
    fn a_hierarchy_of_any_depth_is_walked() {
        let mut mesh = Mesh::default();
        for k in 0..100u32 {
            let side = 0.5f32.powi(k as i32);
            let first = mesh.positions.len() as u32;
            let corner = |x: f32, y: f32| [x * side, y * side, 0.0];
            mesh.positions
                .extend([corner(1.0, 0.0), corner(1.5, 0.0), corner(1.0, 0.5)]);
            mesh.triangles.push([first, first + 1, first + 2]);
        }
        let scene = RayScene::new([RayObject::Mesh(&mesh)]);
        for k in 0..100u32 {
            let side = 0.5f64.powi(k as i32);
            let origin = DVec3::new(1.1 * side, 0.1 * side, 1.0);
            let hit = scene.nearest(origin, DVec3::NEG_Z, EVERYWHERE).unwrap();
            assert_eq!(hit.triangle, k);
        }
    }

    /// A square before a small area light: umbra, half shadow and light where similar triangles put them.
    #[test]
    fn area_lights_have_penumbrae_of_the_right_width() {
        let plate = RayObject::Solid(
            Shape::Plane,
            DMat4::from_translation(DVec3::new(0.0, 0.0, 1.0)),
        );
        let scene = RayScene::new([plate]);
        // Light of side 0.4 at height 3 over the plate of side 1 at height 1.
        let light = AreaLight {
            corner: DVec3::new(-0.2, -0.2, 3.0),
            u: DVec3::X * 0.4,
            v: DVec3::Y * 0.4,
        };
        let at = |x: f64| scene.sees(DVec3::new(x, 0.0, 0.0), &light, 40);
        // The plate's edge projects the light's ends to 0.75 -+ 0.1.
        assert_eq!((at(0.0), at(0.64), at(0.86)), (0.0, 0.0, 1.0));
        assert!((at(0.75) - 0.5).abs() < 0.03);
        assert!((at(0.70) - 0.25).abs() < 0.03 && (at(0.80) - 0.75).abs() < 0.03);
        let hard = |x: f64| scene.sees(DVec3::new(x, 0.0, 0.0), &light, 1);
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
        assert!(scene.tree.size() == 0);
        let ball = RayScene::new([RayObject::Solid(Shape::Sphere, DMat4::IDENTITY)]);
        assert!(!ball.meets(DVec3::new(0.0, 0.0, 3.0), DVec3::ZERO, EVERYWHERE));
        assert!(!ball.meets(DVec3::splat(f64::NAN), DVec3::X, EVERYWHERE));
    }
}

//! The accuracy scene of shadow maps: a closed mesh of height 1 on a plane under a low sun, against hard shadow rays.

use std::path::Path;

use texmap_light::{Light, ShadowBias, ShadowKind, ShadowMap};
use texmap_math::camera::Camera;
use texmap_math::deterministic_f64;
use texmap_math::glam::{DMat4, DVec2, DVec3};
use texmap_render::shadow_map;
use texmap_scene::{Material, Mesh, Scene, shadow_kind};

use crate::LabError;
use texmap_truth::caster::Pinhole;
use texmap_truth::rays::{RayHit, RayObject, RayScene};

/// Half the side of the shadow map, world units.
pub(crate) const HALF: f64 = 2.6;

/// A mesh on its plane.
#[derive(Debug)]
pub struct ShadowScene {
    /// Z up; the light is set by each measurement.
    pub scene: Scene,
    pub(crate) rays: RayScene,
}

/// Shares of the points that face the light and lie outside of the band around the true shadow's edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Figures {
    /// Lit in truth, dark by the map, with nothing but the receiver's own plane around.
    pub false_shadow: f64,
    /// The same within 1.5 texels of a crease where the surface rises from that plane: a bias that is exact for a plane does not
    /// reach the neighbour's depth.
    pub creases: f64,
    /// Dark in truth, lit by the map.
    pub false_light: f64,
    /// Share of all points that lie in the band.
    pub band: f64,
}

impl ShadowScene {
    /// The scene's own closed mesh, a ring that stands on the plane.
    pub fn ring() -> Self {
        let (around, along) = (64u32, 32u32);
        let mut mesh = Mesh {
            name: "ring".into(),
            ..Mesh::default()
        };
        let turn = |i: u32, n: u32| {
            deterministic_f64::sin_cos(f64::from(i) / f64::from(n) * std::f64::consts::TAU)
        };
        for (i, j) in (0..around).flat_map(|i| (0..along).map(move |j| (i, j))) {
            let ((sin, cos), (up, out)) = (turn(i, around), turn(j, along));
            let r = 0.35 + 0.15 * out;
            mesh.positions
                .push([(r * cos) as f32, (0.15 * up) as f32, (0.5 + r * sin) as f32]);
            let at = |i: u32, j: u32| i % around * along + j % along;
            let (a, b, c, d) = (at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
            mesh.triangles.extend([[a, c, b], [a, d, c]]);
        }
        Self::of(vec![mesh])
    }

    /// The models of a file, Y up, scaled to height 1 and set on the plane.
    ///
    /// # Errors
    /// If the file cannot be read.
    pub fn standing(path: &Path) -> Result<Self, LabError> {
        let mut loaded = texmap_io::load_model(path, &texmap_io::LoadOptions::default())
            .map_err(|e| LabError::Cases(e.to_string()))?;
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for p in loaded.meshes.iter().flat_map(|m| &m.positions) {
            let p = DVec3::from(p.map(f64::from));
            (low, high) = (low.min(p), high.max(p));
        }
        let scale = 1.0 / (high.y - low.y);
        let foot = DVec3::new(0.5 * (low.x + high.x), low.y, 0.5 * (low.z + high.z));
        // Y up to Z up.
        let turn = DMat4::from_cols(
            DVec3::X.extend(0.0),
            DVec3::Z.extend(0.0),
            DVec3::NEG_Y.extend(0.0),
            DVec3::ZERO.extend(1.0),
        );
        let world = turn * DMat4::from_scale(DVec3::splat(scale)) * DMat4::from_translation(-foot);
        for mesh in &mut loaded.meshes {
            mesh.world_from_object = world;
            mesh.material = 0;
        }
        Ok(Self::of(loaded.meshes))
    }

    /// Meshes on the floor.
    pub(crate) fn of(mut meshes: Vec<Mesh>) -> Self {
        meshes.push(floor(3.0));
        Self::of_meshes(meshes)
    }

    pub(crate) fn of_meshes(meshes: Vec<Mesh>) -> Self {
        let rays = RayScene::new(meshes.iter().map(RayObject::Mesh));
        let scene = Scene {
            background: [0.5, 0.6, 0.7, 1.0],
            lights: vec![sun(60.0)],
            materials: vec![Material::default()],
            meshes,
            ..Scene::new(Camera {
                eye: DVec3::new(1.6, -2.2, 1.2),
                look: DVec3::new(0.0, 0.0, 0.3),
                up: DVec3::Z,
                fov_x: 50.0f64.to_radians(),
                near: 1e-4,
                far: f64::INFINITY,
                lens: Default::default(),
            })
        };
        Self { scene, rays }
    }

    /// Points that a picture of `pixels` x `pixels` sees, each with the normal of its triangle's plane.
    pub(crate) fn points(&self, pixels: u32) -> Result<Vec<(DVec3, DVec3)>, LabError> {
        let pinhole = Pinhole::of_camera(&self.scene.camera, pixels, pixels)?;
        let place = |i: u32| f64::from(i) + 0.5;
        Ok((0..pixels * pixels)
            .filter_map(|i| {
                let ray = pinhole.direction(place(i % pixels), place(i / pixels));
                let hit = self.rays.nearest(pinhole.eye, ray, (0.0, f64::INFINITY))?;
                let plane = self.plane(&hit);
                // The side that is seen.
                let side = if plane.dot(ray) > 0.0 { -1.0 } else { 1.0 };
                Some((hit.point, plane * side))
            })
            .collect())
    }

    pub(crate) fn plane(&self, hit: &RayHit) -> DVec3 {
        let mesh = &self.scene.meshes[hit.object];
        let [a, b, c] = mesh.triangles[hit.triangle as usize].map(|v| {
            let p = DVec3::from(mesh.positions[v as usize].map(f64::from));
            mesh.world_from_object.transform_point3(p)
        });
        (b - a).cross(c - a).normalize()
    }

    /// The map of the sun at an elevation (degrees).
    ///
    /// # Errors
    /// Sizes out of range.
    pub fn map(&self, elevation: f64, size: u32) -> Result<ShadowMap, LabError> {
        let mut scene = self.scene.clone();
        scene.lights = vec![sun(elevation)];
        let kind = shadow_kind(&scene, 0, Some((DVec3::ZERO, HALF)))?;
        Ok(shadow_map(&scene, &kind, size, 1)?)
    }

    /// False shadow and false light of a map under a bias, over a picture of `pixels` x `pixels`.
    ///
    /// # Errors
    /// Sizes out of range.
    pub fn measure(
        &self,
        elevation: f64,
        size: u32,
        bias: ShadowBias,
        pcf_size: u32,
        pixels: u32,
    ) -> Result<Figures, LabError> {
        let map = self.map(elevation, size)?;
        let toward = toward(elevation);
        let texel = 2.0 * HALF / f64::from(size);
        let (a, b) = across(toward);
        let dark = |p: DVec3, n: DVec3| self.dark(p, n, toward);
        let (mut count, mut band) = (0u32, 0u32);
        let (mut shadow, mut light, mut creases) = (0u32, 0u32, 0u32);
        for (point, normal) in self.points(pixels)? {
            if normal.dot(toward) <= 0.02 {
                continue;
            }
            count += 1;
            let truth = dark(point, normal);
            let around = || {
                (0..8).map(|k| {
                    let (sin, cos) =
                        deterministic_f64::sin_cos(f64::from(k) * std::f64::consts::FRAC_PI_4);
                    (a * cos + b * sin) * (1.5 * texel)
                })
            };
            let edge = around().any(|o| {
                self.surface_beside(point + o, toward)
                    .is_none_or(|(p, n)| dark(p, n) != truth)
            });
            if edge {
                band += 1;
                continue;
            }
            // The receiver's plane goes on into the body: it rises beside it.
            let crease = around().any(|o| {
                let p = point + o - toward * (normal.dot(o) / normal.dot(toward));
                dark(p, normal) != truth
            });
            let lit = map.visibility(point, normal, bias, pcf_size);
            let unlit = !truth && lit < 1.0;
            creases += u32::from(unlit && crease);
            shadow += u32::from(unlit && !crease);
            light += u32::from(truth && lit > 0.0);
        }
        let share = |n: u32| f64::from(n) / f64::from((count - band).max(1));
        Ok(Figures {
            false_shadow: share(shadow),
            false_light: share(light),
            creases: share(creases),
            band: f64::from(band) / f64::from(count.max(1)),
        })
    }

    /// False shadow among all points, of those that lie outside of the map: by the rule that they are lit, and with the look-up
    /// clamped to the map's edge.
    ///
    /// # Errors
    /// Sizes out of range.
    pub fn outside(&self, elevation: f64, size: u32, pixels: u32) -> Result<(f64, f64), LabError> {
        let map = self.map(elevation, size)?;
        let toward = toward(elevation);
        let &ShadowKind::Directional {
            light_from_world,
            half,
        } = map.kind()
        else {
            return Ok((f64::NAN, f64::NAN));
        };
        let (mut count, mut ruled, mut clamped) = (0u32, 0u32, 0u32);
        for (point, normal) in self.points(pixels)? {
            if normal.dot(toward) <= 0.02 || self.dark(point, normal, toward) {
                continue;
            }
            count += 1;
            let p = light_from_world.transform_point3(point);
            let at = DVec2::new(p.x, -p.y) / half * 0.5 + 0.5;
            if at.min_element() >= 0.0 && at.max_element() < 1.0 {
                continue;
            }
            ruled += u32::from(map.visibility(point, normal, ShadowBias::Slope(1e-4), 1) < 1.0);
            let texel = |c: f64| {
                (c * f64::from(size))
                    .floor()
                    .clamp(0.0, f64::from(size - 1)) as u32
            };
            let stored = map
                .depth_at(0, texel(at.x), texel(at.y))
                .map_or(f64::INFINITY, f64::from);
            // A generous bias: only the position can be wrong here.
            clamped += u32::from(-p.z > stored + 0.02);
        }
        let share = |n: u32| f64::from(n) / f64::from(count.max(1));
        Ok((share(ruled), share(clamped)))
    }

    /// The surface on the light's ray through a point, nearest to it: its point and the side that faces the light. A plane of the
    /// receiver would do on the floor, but on facets that the light grazes it runs into the body and calls everything dark.
    pub(crate) fn surface_beside(&self, place: DVec3, toward: DVec3) -> Option<(DVec3, DVec3)> {
        let range = (0.0, f64::INFINITY);
        let up = self.rays.nearest(place, toward, range);
        let down = self.rays.nearest(place, -toward, range);
        let hit = match (up, down) {
            (Some(up), Some(down)) if up.t < down.t => up,
            (up, down) => down.or(up)?,
        };
        let plane = self.plane(&hit);
        let side = if plane.dot(toward) < 0.0 { -1.0 } else { 1.0 };
        Some((hit.point, plane * side))
    }

    fn dark(&self, point: DVec3, normal: DVec3, toward: DVec3) -> bool {
        self.rays
            .meets(point + normal * 1e-4, toward, (0.0, f64::INFINITY))
    }
}

/// From the scene to the sun.
fn toward(elevation: f64) -> DVec3 {
    let (sin, cos) = deterministic_f64::sin_cos(elevation.to_radians());
    DVec3::new(0.8 * cos, -0.6 * cos, sin)
}

/// The sun at an elevation in degrees.
pub fn sun(elevation: f64) -> Light {
    Light::Directional {
        color: [1.0; 3],
        direction: (-toward(elevation)).as_vec3().to_array(),
    }
}

/// Two unit vectors square to a direction.
pub(crate) fn across(d: DVec3) -> (DVec3, DVec3) {
    let a = d.cross(DVec3::X).normalize();
    (a, d.cross(a).normalize())
}

/// The plane z = 0, up to `half` along x and y.
pub(crate) fn floor(half: f32) -> Mesh {
    Mesh {
        name: "floor".into(),
        positions: vec![
            [-half, -half, 0.0],
            [half, -half, 0.0],
            [half, half, 0.0],
            [-half, half, 0.0],
        ],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    }
}

//! The nearest camera of a direction that shows every vertex within a fraction of the picture.
//!
//! In the axes of the picture (x to the right, y up, z to the eye) a vertex is at most the fraction `t` of the half width at distance 1 from
//! the line of sight where `x - ex <= t (ez - z)` and `ex - x <= t (ez - z)`. With `A = max(x + t z)` and `B = max(-x + t z)` over all
//! vertices that is `ez >= (A + B) / 2t`, and at the least `ez` the eye is at `ex = (A - B) / 2`. The same holds for y; the larger `ez`
//! serves both.

use std::borrow::Borrow;

use texmap_math::camera::{Camera, Lens};
use texmap_math::deterministic_f64;
use texmap_math::glam::{DMat3, DVec3};
use texmap_math::{parallel, wide};
use texmap_scene::{Mesh, Scene};

use super::Framing;

/// Vertices that a thread takes at once.
const VERTICES: usize = 1 << 14;

/// Extremes of the vertices in the axes of a picture.
struct Extent {
    /// Largest x + tx z, -x + tx z, y + ty z, -y + ty z.
    reach: [f64; 4],
    /// Least and largest x, y, z.
    low: DVec3,
    high: DVec3,
}

impl Extent {
    const EMPTY: Self = Self {
        reach: [f64::NEG_INFINITY; 4],
        low: DVec3::INFINITY,
        high: DVec3::NEG_INFINITY,
    };

    fn add(&mut self, p: DVec3, [tx, ty]: [f64; 2]) {
        let (x, y) = (tx * p.z, ty * p.z);
        for (reach, value) in self
            .reach
            .iter_mut()
            .zip([x + p.x, x - p.x, y + p.y, y - p.y])
        {
            *reach = reach.max(value);
        }
        (self.low, self.high) = (self.low.min(p), self.high.max(p));
    }

    /// The extent of two sets of vertices.
    fn and(mut self, other: Self) -> Self {
        for (reach, value) in self.reach.iter_mut().zip(other.reach) {
            *reach = reach.max(value);
        }
        (self.low, self.high) = (self.low.min(other.low), self.high.max(other.high));
        self
    }

    /// The extent of all vertices that triangles use, each added by `add`; on every thread.
    fn of(scene: &Scene, add: impl Fn(&mut Self, DVec3) + Sync) -> Self {
        let of_mesh = |mesh: &Mesh| {
            let used = used(mesh);
            let blocks = mesh.positions.chunks(VERTICES);
            let blocks = blocks.zip(used.chunks(VERTICES));
            let extents = parallel::map(blocks, |(positions, used)| {
                let mut extent = Self::EMPTY;
                each_used(mesh, positions, used, |p| add(&mut extent, p));
                extent
            });
            extents.into_iter().fold(Self::EMPTY, Self::and)
        };
        let extents = parallel::map(scene.meshes.iter(), of_mesh);
        extents.into_iter().fold(Self::EMPTY, Self::and)
    }

    fn camera(
        &self,
        framing: &Framing,
        axes: &DMat3,
        [tx, ty]: [f64; 2],
        aspect: f64,
    ) -> Option<Camera> {
        let size = self.high - self.low;
        if !size.is_finite() {
            return None;
        }
        let [a, b, c, d] = self.reach;
        // Nothing touches the eye: a needle along the line of sight has no width.
        let gap = match size.max_element() {
            largest if largest > 0.0 => 0.1 * largest,
            _ => 1.0,
        };
        let ez = ((a + b) / (2.0 * tx))
            .max((c + d) / (2.0 * ty))
            .max(self.high.z + gap);
        let (eye, parallel_width) = if framing.parallel {
            let middle = (self.low + self.high) * 0.5;
            let width = size.x.max(size.y * aspect) / Framing::FILL;
            let width = if width > 0.0 { width } else { gap };
            (DVec3::new(middle.x, middle.y, ez), Some(width))
        } else {
            (DVec3::new((a - b) * 0.5, (c - d) * 0.5, ez), None)
        };
        let distance = ez - 0.5 * (self.low.z + self.high.z);
        let nearest = ez - self.high.z;
        Some(Camera {
            eye: *axes * eye,
            look: *axes * (eye - DVec3::Z * distance),
            up: axes.y_axis,
            fov_x: framing.fov_x,
            near: (distance * 1e-3).min(nearest * 0.5),
            far: match framing.parallel {
                true => ez - self.low.z + gap,
                false => f64::INFINITY,
            },
            lens: Lens {
                parallel_width,
                ..Lens::default()
            },
        })
    }
}

/// Fractions of the half width and half height at distance 1 that vertices may reach.
fn share(framing: &Framing, aspect: f64) -> [f64; 2] {
    let tx = Framing::FILL * deterministic_f64::tan(0.5 * framing.fov_x);
    [tx, tx / aspect]
}

/// Right, up and backward of a picture seen from `back`.
fn axes(back: DVec3, up: DVec3) -> DMat3 {
    let back = back.normalize();
    let right = up.cross(back).normalize();
    DMat3::from_cols(right, back.cross(right), back)
}

/// A camera that shows the whole of each scene.
pub(super) fn whole<E>(
    scenes: impl IntoIterator<Item = Result<impl Borrow<Scene>, E>>,
    framing: &Framing,
    back: DVec3,
    up: DVec3,
    aspect: f64,
) -> Result<Option<Camera>, E> {
    let (axes, share) = (axes(back, up), share(framing, aspect));
    let into = axes.transpose();
    let mut all = Extent::EMPTY;
    for scene in scenes {
        let scene = scene?;
        let extent = Extent::of(scene.borrow(), |extent, p| extent.add(into * p, share));
        all = all.and(extent);
    }
    Ok(all.camera(framing, &axes, share, aspect))
}

pub(super) fn turntable(
    scene: &Scene,
    framing: &Framing,
    back: DVec3,
    aspect: f64,
    frames: u32,
) -> Vec<Camera> {
    let share @ [tx, ty] = share(framing, aspect);
    let upright = framing.up.direction();
    // The axis goes through the middle of the box around all vertices.
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    each_vertex(scene, |p| (low, high) = (low.min(p), high.max(p)));
    let middle = (low + high) * 0.5;
    let back = back.normalize();
    let sin = back.dot(upright);
    let along = back - upright * sin;
    // From straight above the table turns the picture about its middle; it is seen from the front then.
    let along = match along.length() {
        length if length > 1e-6 => along / length,
        _ => framing.up.turn(DVec3::Z),
    };
    let cos = (1.0 - sin * sin).max(0.0).sqrt();
    let first = axes(along, upright);
    // A vertex runs round a circle of radius r at height h: its extremes over the whole turn, in the axes of a picture.
    let extent = Extent::of(scene, |extent, p| {
        let p = p - middle;
        let h = p.dot(upright);
        let r = (p - upright * h).length();
        let (rise, depth) = (h * cos, h * sin);
        let over =
            |t: f64, part: f64| (part * part + (t * r * cos) * (t * r * cos)).sqrt() + t * depth;
        let reach = [
            over(tx, r),
            over(tx, r),
            rise + ty * depth + r * (ty * cos - sin).abs(),
            -rise + ty * depth + r * (ty * cos + sin).abs(),
        ];
        for (reach, value) in extent.reach.iter_mut().zip(reach) {
            *reach = reach.max(value);
        }
        let half = DVec3::new(r, r * sin.abs(), r * cos);
        let at = DVec3::new(0.0, rise, depth);
        (extent.low, extent.high) = (extent.low.min(at - half), extent.high.max(at + half));
    });
    let camera = |frame: u32| {
        let angle = core::f64::consts::TAU * f64::from(frame) / f64::from(frames);
        let (s, c) = deterministic_f64::sin_cos(angle);
        let horizontal = first.z_axis * c + first.x_axis * s;
        let back = horizontal * cos + upright * sin;
        let right = upright.cross(horizontal);
        let axes = DMat3::from_cols(right, back.cross(right), back);
        let camera = extent.camera(framing, &axes, share, aspect)?;
        Some(Camera {
            eye: camera.eye + middle,
            look: camera.look + middle,
            ..camera
        })
    };
    (0..frames).filter_map(camera).collect()
}

/// Calls `add` with every vertex that a triangle uses, in world space. Vertices that are not finite are left out.
fn each_vertex(scene: &Scene, mut add: impl FnMut(DVec3)) {
    for mesh in &scene.meshes {
        each_used(mesh, &mesh.positions, &used(mesh), &mut add);
    }
}

/// True for each vertex of a mesh that a triangle uses.
fn used(mesh: &Mesh) -> Vec<bool> {
    let mut used = vec![false; mesh.positions.len()];
    for vertex in mesh.triangles.as_flattened() {
        if let Some(used) = used.get_mut(*vertex as usize) {
            *used = true;
        }
    }
    used
}

fn each_used(mesh: &Mesh, positions: &[[f32; 3]], used: &[bool], mut add: impl FnMut(DVec3)) {
    for (position, _) in positions.iter().zip(used).filter(|(_, used)| **used) {
        let p = mesh.world_from_object.transform_point3(wide(*position));
        if p.is_finite() {
            add(p);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::framing::{Up, View};
    use texmap_math::glam::DMat4;
    use texmap_scene::Mesh;

    /// Corners of an uneven box, away from the origin and turned.
    fn scene() -> Scene {
        let corner = |i: u32| [0, 1, 2].map(|k| if i >> k & 1 == 1 { 1.0 } else { -1.0 });
        let mesh = Mesh {
            positions: (0..8).map(corner).chain([[900.0; 3]]).collect(),
            triangles: vec![[0, 1, 2], [3, 4, 5], [6, 7, 0]],
            world_from_object: DMat4::from_translation(DVec3::new(30.0, -4.0, 7.0))
                * DMat4::from_scale(DVec3::new(3.0, 0.7, 1.4)),
            ..Mesh::default()
        };
        let mut scene = Scene::new(Camera::look_at([0.0; 3], [0.0, 0.0, 1.0]));
        scene.meshes.push(mesh);
        scene
    }

    /// Least and largest clip x / w and y / w.
    fn seen(scene: &Scene, camera: &Camera, aspect: f64) -> [f64; 4] {
        let clip = camera.clip_from_world(aspect).unwrap();
        let mut out = [
            f64::INFINITY,
            f64::NEG_INFINITY,
            f64::INFINITY,
            f64::NEG_INFINITY,
        ];
        each_vertex(scene, |p| {
            let c = clip * p.extend(1.0);
            assert!(c.z < c.w && c.w > 0.0, "before the near plane");
            let (x, y) = (c.x / c.w, c.y / c.w);
            out = [out[0].min(x), out[1].max(x), out[2].min(y), out[3].max(y)];
        });
        out
    }

    #[test]
    fn the_tighter_direction_is_filled_exactly_from_every_side() {
        let scene = scene();
        for up in [Up::Y, Up::Z] {
            for parallel in [false, true] {
                for (name, view) in View::ALL {
                    assert_eq!(name.parse(), Ok(view));
                    for aspect in [0.4, 1.0, 16.0 / 9.0] {
                        let framing = Framing {
                            view,
                            up,
                            parallel,
                            ..Framing::default()
                        };
                        let camera = framing.camera(&scene, aspect).unwrap();
                        let [left, right, low, high] = seen(&scene, &camera, aspect);
                        let most = [-left, right, -low, high].into_iter().fold(0.0, f64::max);
                        assert!(
                            (most - Framing::FILL).abs() < 1e-9,
                            "{name} {aspect} {most}"
                        );
                        let (wide, tall) = (right - left, high - low);
                        let filled = wide.max(tall) * 0.5;
                        assert!(
                            (filled - Framing::FILL).abs() < 1e-9,
                            "{name} {aspect} {filled}"
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn a_camera_a_little_nearer_would_fail_that_test() {
        let scene = scene();
        let mut camera = Framing::default().camera(&scene, 1.0).unwrap();
        camera.eye = camera.eye * 0.99 + camera.look * 0.01;
        let [left, right, ..] = seen(&scene, &camera, 1.0);
        assert!(right.max(-left) > Framing::FILL + 1e-3);
    }

    #[test]
    fn a_turntable_goes_round_at_one_distance_and_cuts_nothing() {
        let scene = scene();
        for up in [Up::Y, Up::Z] {
            let framing = Framing {
                up,
                ..Framing::default()
            };
            let cameras = framing.turntable(&scene, 1.5, 24);
            assert_eq!(cameras.len(), 24);
            let distance = |c: &Camera| (c.eye - c.look).length();
            let mut most: f64 = 0.0;
            for camera in &cameras {
                assert!((distance(camera) - distance(&cameras[0])).abs() < 1e-9);
                let [left, right, low, high] = seen(&scene, camera, 1.5);
                most = [most, -left, right, -low, high]
                    .into_iter()
                    .fold(0.0, f64::max);
            }
            assert!(most <= Framing::FILL + 1e-9 && most > 0.85, "{most}");
            // The first looks from where the single picture does; a quarter later the eye is at the right.
            let back = |c: &Camera| (c.eye - c.look).normalize();
            let single = framing.camera(&scene, 1.5).unwrap();
            assert!((back(&cameras[0]) - back(&single)).length() < 1e-9);
            let turned = up.direction().cross(back(&cameras[0]));
            assert!((back(&cameras[6]).dot(turned) - turned.length_squared()).abs() < 1e-9);
        }
    }

    #[test]
    fn points_needles_and_nothing_have_cameras_or_none() {
        let mut scene = scene();
        scene.meshes[0].world_from_object = DMat4::from_scale(DVec3::ZERO);
        assert!(
            Framing::default()
                .camera(&scene, 1.0)
                .unwrap()
                .view()
                .is_ok()
        );
        scene.meshes[0].world_from_object = DMat4::from_scale(DVec3::Z);
        let front = Framing {
            view: View::Front,
            ..Framing::default()
        };
        let camera = front.camera(&scene, 1.0).unwrap();
        assert!(camera.view().is_ok() && camera.eye.z > 1.0 + camera.near);
        let parallel = Framing {
            parallel: true,
            ..front
        };
        assert!(parallel.camera(&scene, 1.0).unwrap().view().is_ok());
        scene.meshes.clear();
        assert!(Framing::default().camera(&scene, 1.0).is_none());
        assert!(Framing::default().turntable(&scene, 1.0, 3).is_empty());
    }
}

//! Contents of a finished picture in numbers, and warnings about pictures that show little.

use serde::Serialize;
use texmap_math::color::srgb8_to_linear;
use texmap_math::glam::DVec3;
use texmap_math::wide;
use texmap_render::{Aov, AovData, Frame};
use texmap_scene::{ColorMode, Scene};

/// A picture in numbers.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct PictureReport {
    /// Fraction of the pixels in which a surface is seen.
    coverage: f64,
    /// Mean of red, green, blue (stored values, 0 to 1, weighed by alpha in linear light) and alpha.
    mean_color: [f64; 4],
    /// The meshes that are seen at the centre of some pixel, in the order of the scene.
    meshes: Vec<MeshReport>,
}

/// A mesh as it is seen.
#[derive(Clone, Debug, Serialize)]
struct MeshReport {
    /// Index in the scene, as in `--aov mesh`.
    id: u32,
    name: String,
    /// Pixels whose centre shows it.
    pixels: u64,
    /// Left, top, right, bottom: the first pixels and those behind the last.
    bounds: [u32; 4],
}

impl PictureReport {
    /// The frame must have [`Aov::Mesh`].
    pub(crate) fn new(scene: &Scene, frame: &Frame) -> Self {
        let pixels = f64::from(frame.width) * f64::from(frame.height);
        Self {
            coverage: six(frame.stats.pixels_covered as f64 / pixels),
            mean_color: mean(frame, scene.color).map(six),
            meshes: meshes(scene, frame),
        }
    }
}

/// Six significant digits.
fn six(value: f64) -> f64 {
    format!("{value:.5e}").parse().unwrap_or(value)
}

fn mean(frame: &Frame, mode: ColorMode) -> [f64; 4] {
    let (mut sum, mut alphas) = ([0.0; 3], 0.0);
    for [r, g, b, a] in frame.rgba.as_chunks::<4>().0 {
        let alpha = f64::from(*a) / 255.0;
        alphas += alpha;
        for (sum, code) in sum.iter_mut().zip([r, g, b]) {
            *sum += alpha
                * match mode {
                    ColorMode::Srgb => f64::from(srgb8_to_linear(*code)),
                    ColorMode::Raw => f64::from(*code) / 255.0,
                };
        }
    }
    let stored = |light: f64| match mode {
        ColorMode::Srgb => f64::from(texmap_math::color::linear_to_srgb(light as f32)),
        ColorMode::Raw => light,
    };
    let [r, g, b] = sum.map(|sum| {
        if alphas > 0.0 {
            stored(sum / alphas)
        } else {
            0.0
        }
    });
    [r, g, b, alphas / (frame.rgba.len() / 4).max(1) as f64]
}

fn meshes(scene: &Scene, frame: &Frame) -> Vec<MeshReport> {
    let ids = frame.aovs.iter().find(|(aov, ..)| *aov == Aov::Mesh);
    let Some((_, _, AovData::U32(ids))) = ids else {
        return Vec::new();
    };
    let mut seen: Vec<(u64, [u32; 4])> = vec![(0, [u32::MAX, u32::MAX, 0, 0]); scene.meshes.len()];
    for (row, y) in ids.chunks(frame.width.max(1) as usize).zip(0..) {
        for (id, x) in row.iter().zip(0..) {
            if let Some((pixels, [left, top, right, bottom])) = seen.get_mut(*id as usize) {
                *pixels += 1;
                (*left, *top) = ((*left).min(x), (*top).min(y));
                (*right, *bottom) = ((*right).max(x + 1), (*bottom).max(y + 1));
            }
        }
    }
    let report = |((id, mesh), (pixels, bounds))| {
        let mesh: &texmap_scene::Mesh = mesh;
        MeshReport {
            id,
            name: mesh.name.clone(),
            pixels,
            bounds,
        }
    };
    let all = (0..).zip(&scene.meshes).zip(seen).map(report);
    all.filter(|mesh| mesh.pixels > 0).collect()
}

/// Warnings about a picture that shows something, but nothing to be told apart. (The renderer warns where nothing is drawn.)
pub(crate) fn warning(frame: &Frame) -> Option<String> {
    let pixels = frame.rgba.as_chunks::<4>().0;
    let first = pixels.first()?;
    let alike = pixels.len() > 1 && pixels.iter().all(|pixel| pixel == first);
    let [r, g, b, a] = first;
    (alike && frame.stats.pixels_covered > 0).then(|| {
        format!(
            "every pixel has the same colour, #{r:02x}{g:02x}{b:02x}{a:02x}: move the camera away, give light, or choose another --background"
        )
    })
}

/// A warning if the eye stands inside of a mesh: within its box, and on the inner side of its surface as seen straight ahead.
pub(crate) fn inside(scene: &Scene) -> Option<String> {
    let eye = scene.camera.eye;
    let ahead = (scene.camera.look - eye).normalize_or_zero();
    let mesh = scene.meshes.iter().find(|mesh| {
        let place = |p: &[f32; 3]| mesh.world_from_object.transform_point3(wide(*p));
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for p in mesh.positions.iter().map(place) {
            (low, high) = (low.min(p), high.max(p));
        }
        let in_box = eye.cmpgt(low).all() && eye.cmplt(high).all();
        in_box && {
            let turns = mesh.world_from_object.determinant() < 0.0;
            let mut winding = 0;
            for triangle in &mesh.triangles {
                let corner = |i: u32| mesh.positions.get(i as usize).map(place);
                if let [Some(a), Some(b), Some(c)] = triangle.map(corner) {
                    winding += crossing(eye, ahead, [a, b, c]);
                }
            }
            // Leaving through a front from behind.
            (if turns { -winding } else { winding }) > 0
        }
    })?;
    Some(format!(
        "the camera stands inside of mesh '{}': --views or --view place it outside",
        mesh.name
    ))
}

/// 1 where a ray leaves through a triangle from its back, -1 where it enters through its front, else 0.
fn crossing(eye: DVec3, ahead: DVec3, [a, b, c]: [DVec3; 3]) -> i32 {
    let [a, b, c] = [a - eye, b - eye, c - eye];
    let volume = |p: DVec3, q: DVec3| ahead.dot(p.cross(q));
    let (u, v, w) = (volume(b, c), volume(c, a), volume(a, b));
    let side = if u > 0.0 && v >= 0.0 && w >= 0.0 || u >= 0.0 && v > 0.0 && w >= 0.0 {
        1
    } else if u < 0.0 && v <= 0.0 && w <= 0.0 || u <= 0.0 && v < 0.0 && w <= 0.0 {
        -1
    } else {
        return 0;
    };
    let at = (a * u + b * v + c * w) / (u + v + w);
    if at.dot(ahead) > 0.0 { side } else { 0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use texmap_math::Camera;
    use texmap_math::glam::DMat4;
    use texmap_scene::Mesh;

    fn ball(eye: [f64; 3]) -> Scene {
        let mut scene = Scene::new(Camera::look_at(eye, [0.3, 0.2, 9.0]));
        scene.meshes.push(Mesh::sphere(24, 12));
        scene
    }

    #[test]
    fn an_eye_inside_of_a_ball_is_noticed_and_one_outside_is_not() {
        assert!(inside(&ball([0.0, 0.1, 0.2])).is_some());
        // Inside of the box, outside of the ball.
        assert!(inside(&ball([0.9, 0.9, 0.9])).is_none());
        assert!(inside(&ball([0.0, 0.0, -3.0])).is_none());
        let mut mirrored = ball([0.0, 0.1, 0.2]);
        mirrored.meshes[0].world_from_object = DMat4::from_scale(DVec3::new(-1.0, 1.0, 1.0));
        assert!(inside(&mirrored).is_some());
    }

    #[test]
    fn numbers_have_six_digits() {
        assert_eq!(six(0.123_456_789), 0.123_457);
        assert_eq!(six(0.0), 0.0);
    }
}

//! Wireframes: the edges of the faces over a finished picture, antialiased, hidden where a surface stands before them.

use texmap_math::color::{linear_to_srgb8, srgb8_to_linear, unit_to_u8};
use texmap_math::glam::{DMat4, DVec2, DVec4};
use texmap_math::wide;
use texmap_scene::{ColorMode, Mesh, Scene};

/// Width of a line in pixels.
const WIDTH: f64 = 1.0;
/// Colour of a line, linear light.
const INK: f32 = 0.004;

/// Draws the edges of a scene's faces into a picture of it, as seen by the scene's camera. Diagonals inside of a face are left out.
///
/// `size` is the width and height in pixels. `depth` holds the depth of each pixel, rows top to bottom: 1 at the near plane, 0 far away,
/// NaN where nothing is drawn. `rgba` holds its bytes, straight alpha, in the scene's colour mode; `colors` its linear colours,
/// premultiplied, where the caller keeps them. Nothing is drawn where a length does not fit `size` or the camera is degenerate; corners
/// that are not finite draw no edge.
pub fn wireframe(
    scene: &Scene,
    size: [u32; 2],
    depth: &[f32],
    rgba: &mut [u8],
    colors: Option<&mut [f32]>,
) {
    let [width, height] = size;
    let pixels = width as usize * height as usize;
    if pixels == 0 || depth.len() != pixels || rgba.len() != 4 * pixels {
        return;
    }
    let aspect = f64::from(width) / f64::from(height);
    let Ok(clip_from_world) = scene.camera.clip_from_world(aspect) else {
        return;
    };
    let mut lines = Lines {
        size: size.map(|n| n as usize),
        behind: farthest(depth, width as usize),
        cover: vec![0.0; pixels],
    };
    for mesh in &scene.meshes {
        lines.mesh(mesh, clip_from_world * mesh.world_from_object);
    }
    ink_bytes(rgba, &lines.cover, scene.color);
    if let Some(colors) = colors {
        ink_colors(colors, &lines.cover);
    }
}

struct Lines {
    size: [usize; 2],
    /// Depth that a line needs to be seen at a pixel.
    behind: Vec<f32>,
    /// Fraction of each pixel that lines cover.
    cover: Vec<f32>,
}

impl Lines {
    fn mesh(&mut self, mesh: &Mesh, clip_from_object: DMat4) {
        let corners: Vec<DVec4> = mesh
            .positions
            .iter()
            .map(|p| clip_from_object * wide(*p).extend(1.0))
            .collect();
        for [a, b] in edges(mesh) {
            let ends = (corners.get(a as usize), corners.get(b as usize));
            if let (Some(a), Some(b)) = ends {
                self.edge(*a, *b);
            }
        }
    }

    fn edge(&mut self, mut a: DVec4, mut b: DVec4) {
        // In front of the near plane, where w is above 0 as well.
        let distance = |p: DVec4| p.w - p.z;
        match (distance(a) >= 0.0, distance(b) >= 0.0) {
            (false, false) => return,
            (true, true) => {}
            (inside, _) => {
                let t = distance(a) / (distance(a) - distance(b));
                let cut = a + (b - a) * t;
                *(if inside { &mut b } else { &mut a }) = cut;
            }
        }
        if !(a.w > 0.0 && b.w > 0.0 && a.is_finite() && b.is_finite()) {
            return;
        }
        let [width, height] = self.size.map(|n| n as f64);
        let place = |p: DVec4| {
            let at = DVec2::new(
                (p.x / p.w + 1.0) * 0.5 * width,
                (1.0 - p.y / p.w) * 0.5 * height,
            );
            (at, p.z / p.w)
        };
        let ((from, near), (to, far)) = (place(a), place(b));
        let along = to - from;
        // Steps go from pixel to pixel along the longer side.
        let steep = along.y.abs() > along.x.abs();
        let turn = |p: DVec2| if steep { DVec2::new(p.y, p.x) } else { p };
        let (from, along) = (turn(from), turn(along));
        let length = along.length();
        if length.partial_cmp(&1e-9) != Some(std::cmp::Ordering::Greater) {
            return;
        }
        let slope = along.y / along.x;
        // Distance from the line for a step of one pixel across it.
        let cosine = along.x.abs() / length;
        let most = if steep { height } else { width };
        let (low, high) = (from.x.min(from.x + along.x), from.x.max(from.x + along.x));
        let first = (low - 0.5).round().max(0.0);
        let last = (high - 0.5).round().min(most - 1.0);
        let mut x = first;
        while x <= last {
            let centre = (x + 0.5).clamp(low, high);
            let t = (centre - from.x) / along.x;
            let middle = from.y + (centre - from.x) * slope;
            let depth = near + (far - near) * t;
            for step in -1..=1 {
                let y = middle.floor() + f64::from(step);
                let distance = (y + 0.5 - middle).abs() * cosine;
                let cover = (0.5 * WIDTH + 0.5 - distance).clamp(0.0, 1.0) as f32;
                let [column, row] = if steep { [y, x] } else { [x, y] };
                if column >= 0.0 && column < width && row >= 0.0 && row < height {
                    let at = row as usize * self.size[0] + column as usize;
                    if depth >= f64::from(self.behind[at]) {
                        self.cover[at] = self.cover[at].max(cover);
                    }
                }
            }
            x += 1.0;
        }
    }
}

/// The edges of a mesh as pairs of vertices, each once; diagonals inside of a source face are none.
fn edges(mesh: &Mesh) -> Vec<[u32; 2]> {
    let mut all: Vec<[u32; 3]> = Vec::with_capacity(3 * mesh.triangles.len());
    for ([a, b, c], number) in mesh.triangles.iter().zip(0..) {
        let face = mesh.face(number);
        all.extend([[a, b], [b, c], [c, a]].map(|[a, b]| [*a.min(b), *a.max(b), face]));
    }
    all.sort_unstable();
    let of_one_face = all.chunk_by(|a, b| a == b);
    let outer =
        of_one_face.filter_map(|same| (same.len() == 1).then_some([same[0][0], same[0][1]]));
    let mut edges: Vec<[u32; 2]> = outer.collect();
    edges.dedup();
    edges
}

/// Of each pixel the farthest depth around it, a little behind: an edge of a surface is seen on it and beside it. Nothing hides a line
/// where a neighbour is empty.
fn farthest(depth: &[f32], width: usize) -> Vec<f32> {
    let least = |values: [f32; 3]| {
        values.into_iter().fold(f32::INFINITY, |least, v| {
            least.min(if v.is_nan() { 0.0 } else { v })
        })
    };
    let row = |row: &[f32]| -> Vec<f32> {
        let at = |x: usize| row.get(x).copied().unwrap_or(f32::INFINITY);
        (0..row.len())
            .map(|x| least([at(x.wrapping_sub(1)), at(x), at(x + 1)]))
            .collect()
    };
    let rows: Vec<Vec<f32>> = depth.chunks(width).map(row).collect();
    let mut out = Vec::with_capacity(depth.len());
    for y in 0..rows.len() {
        let above = rows.get(y.wrapping_sub(1)).unwrap_or(&rows[y]);
        let below = rows.get(y + 1).unwrap_or(&rows[y]);
        let columns = above.iter().zip(&rows[y]).zip(below);
        out.extend(columns.map(|((a, b), c)| least([*a, *b, *c]) * 0.9998));
    }
    out
}

/// Lines over bytes of straight alpha.
fn ink_bytes(rgba: &mut [u8], cover: &[f32], mode: ColorMode) {
    for (pixel, cover) in rgba.as_chunks_mut::<4>().0.iter_mut().zip(cover) {
        if *cover == 0.0 {
            continue;
        }
        let alpha = f32::from(pixel[3]) / 255.0;
        let over = cover + alpha * (1.0 - cover);
        for channel in &mut pixel[..3] {
            let back = match mode {
                ColorMode::Srgb => srgb8_to_linear(*channel),
                ColorMode::Raw => f32::from(*channel) / 255.0,
            };
            let mixed = (INK * cover + back * alpha * (1.0 - cover)) / over;
            *channel = match mode {
                ColorMode::Srgb => linear_to_srgb8(mixed),
                ColorMode::Raw => unit_to_u8(mixed),
            };
        }
        pixel[3] = unit_to_u8(over);
    }
}

/// Lines over linear colours, premultiplied.
fn ink_colors(colors: &mut [f32], cover: &[f32]) {
    for (pixel, cover) in colors.as_chunks_mut::<4>().0.iter_mut().zip(cover) {
        let front = [INK * cover, INK * cover, INK * cover, *cover];
        for (value, front) in pixel.iter_mut().zip(front) {
            *value = front + *value * (1.0 - cover);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use texmap_math::Camera;
    use texmap_math::glam::DVec3;

    /// A square of one face, made of two triangles, before the eye; a smaller one behind it.
    fn scene(back: bool) -> Scene {
        let mut scene = Scene::new(Camera::look_at([0.0, 0.0, 3.0], [0.0; 3]));
        let square = |z: f32, half: f32| Mesh {
            positions: vec![
                [-half, -half, z],
                [half, -half, z],
                [half, half, z],
                [-half, half, z],
            ],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            faces: vec![0, 0],
            ..Mesh::default()
        };
        scene.meshes = vec![square(0.0, 1.0)];
        if back {
            scene.meshes.push(square(-1.0, 0.4));
        }
        scene
    }

    /// Depth of the front square over the whole picture, or of an empty one.
    fn inked(scene: &Scene, solid: bool) -> Vec<bool> {
        let clip = scene.camera.clip_from_world(1.0).unwrap() * DVec4::W;
        let depth = if solid {
            (clip.z / clip.w) as f32
        } else {
            f32::NAN
        };
        let mut rgba = vec![255; 64 * 64 * 4];
        let mut colors = vec![1.0; 64 * 64 * 4];
        let depth = vec![depth; 64 * 64];
        wireframe(scene, [64, 64], &depth, &mut rgba, Some(&mut colors));
        let changed: Vec<bool> = rgba.chunks(4).map(|p| p != [255; 4]).collect();
        let linear = colors.chunks(4).map(|p| p != [1.0; 4]);
        assert!(linear.eq(changed.iter().copied()));
        changed
    }

    #[test]
    fn outlines_are_drawn_and_diagonals_and_hidden_edges_are_not() {
        let plain = inked(&scene(false), true);
        // A side of the square stands at 32 +- 32 / (3 tan 30).
        let side = (32.0 + 32.0 / (3.0 * 30_f64.to_radians().tan())) as usize;
        assert!(plain[32 * 64 + side] && plain[32 * 64 + 63 - side]);
        assert!(!plain[30 * 64 + 33] && !plain[33 * 64 + 30] && !plain[32 * 64 + 32]);
        assert_eq!(
            plain,
            inked(&scene(true), true),
            "what stands behind draws no line"
        );
        assert_ne!(
            plain,
            inked(&scene(true), false),
            "and does where nothing stands before it"
        );
    }

    #[test]
    fn lines_through_the_eye_plane_end_at_it() {
        let mut scene = scene(false);
        scene.camera.eye = DVec3::new(0.0, 0.2, 0.9);
        scene.camera.look = DVec3::new(0.9, 0.0, 0.1);
        assert!(inked(&scene, false).contains(&true));
    }

    #[test]
    fn arrays_of_another_size_are_left_alone() {
        let mut rgba = vec![255; 4 * 63];
        wireframe(&scene(false), [8, 8], &[0.0; 64], &mut rgba, None);
        assert_eq!(rgba, vec![255; 4 * 63]);
    }

    #[test]
    fn edges_of_missing_vertices_are_not_drawn() {
        let mut scene = Scene::new(Camera::look_at([0.0, 0.0, 4.0], [0.0; 3]));
        scene.materials = vec![texmap_scene::Material::default()];
        scene.meshes = vec![Mesh::cube()];
        scene.meshes[0].triangles.push([0, 1, 999]);
        let mut rgba = [0; 4 * 64];
        wireframe(&scene, [8, 8], &[f32::NAN; 64], &mut rgba, None);
    }
}

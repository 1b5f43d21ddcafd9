//! Visibility: pixels of a mesh that other meshes do not hide.

use std::cmp::Ordering;

use texmap_math::glam::{DMat3, DVec2, DVec4};
use texmap_raster::{Cull, DepthTest};

use super::pilot::{PixelSample, PixelSamples};
use texmap_scene::{AlphaMode, Scene};

/// Cells a side of the grid over the picture.
const CELLS: usize = 64;

/// Takes away the pixels of each mesh that an opaque triangle covers. `positions` are those of all meshes: x and y in pixels
/// times w, clip z, w.
///
/// Triangles come from near to far, and one that lies behind two other meshes all over a cell is not looked at there: a pile of
/// them costs little more than its upper ones.
pub(super) fn keep_visible(
    scene: &Scene,
    positions: &[Vec<DVec4>],
    size: DVec2,
    places: &mut [PixelSamples],
) {
    if scene.depth_test == DepthTest::Always {
        return;
    }
    let mut cells = cells(places, size);
    let mut drawn = drawn(scene, positions);
    drawn.sort_by(|a, b| b.nearest.total_cmp(&a.nearest));
    for triangle in &drawn {
        let at = triangle.corners.map(|p| DVec2::new(p.x, p.y) / p.w);
        let (low, high) = (at[0].min(at[1]).min(at[2]), at[0].max(at[1]).max(at[2]));
        let ([x0, y0], [x1, y1]) = (cell(low, size), cell(high, size));
        let mut weights = None;
        for index in (y0..=y1).flat_map(|y| (x0..=x1).map(move |x| y * CELLS + x)) {
            let cell = &mut cells[index];
            if cell.pixels.is_empty() || cell.behind >= triangle.nearest * NEARER {
                continue;
            }
            let weights = weights.get_or_insert_with(|| triangle.matrix().inverse());
            cell.behind = f64::INFINITY;
            for pixel in &mut cell.pixels {
                let e = *weights * pixel.centre.extend(1.0);
                if e.min_element() >= 0.0 {
                    pixel.cover(e.x + e.y + e.z, triangle.mesh);
                }
                cell.behind = cell.behind.min(pixel.nearest[1].0);
            }
        }
    }
    for (mesh, list) in places.iter_mut().enumerate() {
        list.list.retain(|place| {
            let [x, y] = cell(place.centre, size);
            let pixels = &cells[y * CELLS + x].pixels;
            let found = pixels.binary_search_by(|p| order(p.centre, place.centre));
            let other = found.map_or(f64::NEG_INFINITY, |at| pixels[at].nearest_but(mesh));
            !(other > place.nearness() * NEARER)
        });
    }
}

/// Pixels of a part of the picture that some mesh is tried at.
#[derive(Clone)]
struct Cell {
    /// By rows.
    pixels: Vec<Pixel>,
    /// The least nearness of the second of the two nearest meshes in each: what lies behind it hides nothing more.
    behind: f64,
}

#[derive(Clone)]
struct Pixel {
    centre: DVec2,
    /// 1/w and index of the nearest mesh, and of the nearest of the others.
    nearest: [(f64, usize); 2],
}

impl Pixel {
    fn cover(&mut self, inv_w: f64, mesh: usize) {
        let [first, second] = &mut self.nearest;
        if mesh == first.1 {
            first.0 = first.0.max(inv_w);
        } else if inv_w > first.0 {
            *second = std::mem::replace(first, (inv_w, mesh));
        } else if inv_w > second.0 {
            *second = (inv_w, mesh);
        }
    }

    /// 1/w of the nearest mesh but this one.
    fn nearest_but(&self, mesh: usize) -> f64 {
        let [first, second] = self.nearest;
        if first.1 == mesh { second.0 } else { first.0 }
    }
}

/// The pixels of all meshes, each once.
fn cells(places: &[PixelSamples], size: DVec2) -> Vec<Cell> {
    let empty = Cell {
        pixels: Vec::new(),
        behind: f64::NEG_INFINITY,
    };
    let mut cells = vec![empty; CELLS * CELLS];
    for place in places.iter().flat_map(|list| &list.list) {
        let [x, y] = cell(place.centre, size);
        cells[y * CELLS + x].pixels.push(Pixel {
            centre: place.centre,
            nearest: [(f64::NEG_INFINITY, usize::MAX); 2],
        });
    }
    for cell in &mut cells {
        cell.pixels.sort_by(|a, b| order(a.centre, b.centre));
        cell.pixels.dedup_by(|a, b| a.centre == b.centre);
    }
    cells
}

/// By rows.
fn order(a: DVec2, b: DVec2) -> Ordering {
    a.y.total_cmp(&b.y).then(a.x.total_cmp(&b.x))
}

/// A triangle that hides what is behind it.
struct Drawn {
    mesh: usize,
    corners: [DVec4; 3],
    /// The greatest 1/w of its corners.
    nearest: f64,
}

impl Drawn {
    fn matrix(&self) -> DMat3 {
        DMat3::from_cols_array_2d(&self.corners.map(|p| [p.x, p.y, p.w]))
    }
}

/// Every opaque triangle that is drawn whole.
fn drawn(scene: &Scene, positions: &[Vec<DVec4>]) -> Vec<Drawn> {
    let mut drawn = Vec::new();
    for (m, mesh) in scene.meshes.iter().enumerate() {
        let material = &scene.materials[mesh.material];
        if material.alpha != AlphaMode::Opaque {
            continue;
        }
        for triangle in &mesh.triangles {
            let corners = triangle.map(|i| positions[m][i as usize]);
            // A triangle that crosses the near plane is not drawn as a whole: it hides nothing.
            if !corners.iter().all(|p| p.w > 1e-9 && p.z <= p.w) {
                continue;
            }
            let [a, b, c] = corners.map(|p| 1.0 / p.w);
            let triangle = Drawn {
                mesh: m,
                corners,
                nearest: a.max(b).max(c),
            };
            let area = triangle.matrix().determinant();
            // Rows run down the picture: the front is clockwise there.
            let seen = match material.cull {
                Cull::None => area != 0.0,
                Cull::Back => area < 0.0,
                Cull::Front => area > 0.0,
            };
            if seen && area.is_finite() {
                drawn.push(triangle);
            }
        }
    }
    drawn
}

/// Surfaces that touch do not hide one another.
const NEARER: f64 = 1.0 + 1e-6;

/// The cell of a pixel, or of the edge of the picture nearest to it.
fn cell(p: DVec2, size: DVec2) -> [usize; 2] {
    let c = (p / size * CELLS as f64).clamp(DVec2::ZERO, DVec2::splat(CELLS as f64 - 1.0));
    [c.x as usize, c.y as usize]
}

impl PixelSample {
    fn nearness(&self) -> f64 {
        self.inv_w.dot(self.centre.extend(1.0))
    }
}

#[cfg(test)]
mod tests {
    use texmap_math::glam::DMat4;
    use texmap_scene::{Material, Mesh};

    use super::*;
    use crate::gain::Lighting;
    use crate::pilot::pixel_grid::places;
    use crate::view::View;

    /// True if an opaque triangle of another mesh lies before a place: each is asked.
    fn hidden(scene: &Scene, positions: &[Vec<DVec4>], mesh: usize, place: &PixelSample) -> bool {
        drawn(scene, positions).iter().any(|triangle| {
            let e = triangle.matrix().inverse() * place.centre.extend(1.0);
            let inv_w = e.x + e.y + e.z;
            triangle.mesh != mesh && e.min_element() >= 0.0 && inv_w > place.nearness() * NEARER
        })
    }

    #[test]
    fn piles_of_triangles_hide_what_each_of_them_hides() {
        const SIZE: f64 = 48.0;
        let mut state = 7u64;
        let mut random = move || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            (state >> 40) as f64 / (1u64 << 24) as f64
        };
        let mut scene = crate::tests::scene();
        let cut = Material {
            cull: Cull::Back,
            ..Material::default()
        };
        let clear = Material {
            alpha: AlphaMode::Blend,
            ..Material::default()
        };
        scene.materials = vec![Material::default(), cut, clear];
        let mut positions = Vec::new();
        scene.meshes = (0..60)
            .map(|i| {
                // Two triangles at depths of their own, some beyond the picture.
                let corners: Vec<DVec4> = (0..6)
                    .map(|_| {
                        let (x, y, w) = (random() * 1.4 - 0.2, random() * 1.4 - 0.2, random());
                        let w = 1.0 + f64::from(i % 7) + w;
                        DVec4::new(x * SIZE * w, y * SIZE * w, 0.0, w)
                    })
                    .collect();
                positions.push(corners);
                Mesh {
                    positions: vec![[0.0; 3]; 6],
                    triangles: vec![[0, 1, 2], [3, 4, 5]],
                    material: i as usize % 3,
                    ..Mesh::default()
                }
            })
            .collect();
        let lighting = Lighting::new(&scene, &[]);
        let size = DVec2::splat(SIZE);
        let all: Vec<PixelSamples> = scene
            .meshes
            .iter()
            .zip(&positions)
            .map(|(mesh, positions)| {
                let view = View {
                    scene: &scene,
                    mesh,
                    lighting: &lighting,
                    positions,
                    size,
                    view_from_world: DMat4::IDENTITY,
                    half: [1.0; 2],
                };
                places(&view, 128)
            })
            .collect();
        let expected: Vec<Vec<DVec2>> = all
            .iter()
            .enumerate()
            .map(|(mesh, list)| {
                let seen = list.list.iter();
                let seen = seen.filter(|place| !hidden(&scene, &positions, mesh, place));
                seen.map(|place| place.centre).collect()
            })
            .collect();
        let before: usize = all.iter().map(|list| list.list.len()).sum();
        let mut all = all;
        keep_visible(&scene, &positions, size, &mut all);
        let centres = |list: &PixelSamples| list.list.iter().map(|p| p.centre).collect::<Vec<_>>();
        let found: Vec<Vec<DVec2>> = all.iter().map(centres).collect();
        assert!(found == expected);
        let after: usize = found.iter().map(Vec::len).sum();
        assert!(after * 2 < before && after > 500, "{after} of {before}");
    }
}

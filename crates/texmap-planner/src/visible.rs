//! Visibility: pixels of a mesh that other meshes do not hide.

use texmap_math::glam::{DMat3, DVec2, DVec4};
use texmap_raster::{Cull, DepthTest};

use super::pilot::{PixelSample, PixelSamples};
use texmap_scene::{AlphaMode, Scene};

/// Cells a side of the grid over the picture.
const CELLS: usize = 64;

/// Takes away the pixels of each mesh that an opaque triangle covers. `positions` are those of all meshes: x and y in pixels
/// times w, clip z, w.
///
/// Linear in the triangles of the scene, each of which looks at the pixels in its part of the picture alone.
pub(super) fn keep_visible(
    scene: &Scene,
    positions: &[Vec<DVec4>],
    size: DVec2,
    places: &mut [PixelSamples],
) {
    if scene.depth_test == DepthTest::Always {
        return;
    }
    let mut cells: Vec<Vec<(usize, usize)>> = vec![Vec::new(); CELLS * CELLS];
    for (mesh, list) in places.iter().enumerate() {
        for (i, place) in list.list.iter().enumerate() {
            let [x, y] = cell(place.centre, size);
            cells[y * CELLS + x].push((mesh, i));
        }
    }
    let mut hidden: Vec<Vec<bool>> = places
        .iter()
        .map(|list| vec![false; list.list.len()])
        .collect();
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
            let matrix = DMat3::from_cols_array_2d(&corners.map(|p| [p.x, p.y, p.w]));
            let area = matrix.determinant();
            // Rows run down the picture: the front is clockwise there.
            let drawn = match material.cull {
                Cull::None => area != 0.0,
                Cull::Back => area < 0.0,
                Cull::Front => area > 0.0,
            };
            if !drawn || !area.is_finite() {
                continue;
            }
            let at = corners.map(|p| DVec2::new(p.x, p.y) / p.w);
            let (low, high) = (at[0].min(at[1]).min(at[2]), at[0].max(at[1]).max(at[2]));
            let ([x0, y0], [x1, y1]) = (cell(low, size), cell(high, size));
            let mut weights = None;
            for cell in (y0..=y1).flat_map(|y| (x0..=x1).map(move |x| y * CELLS + x)) {
                for &(owner, i) in &cells[cell] {
                    if owner == m || hidden[owner][i] {
                        continue;
                    }
                    let place = &places[owner].list[i];
                    let weights = weights.get_or_insert_with(|| matrix.inverse());
                    let e = *weights * place.centre.extend(1.0);
                    let inv_w = e.x + e.y + e.z;
                    hidden[owner][i] = e.min_element() >= 0.0 && inv_w > place.nearness() * NEARER;
                }
            }
        }
    }
    for (list, hidden) in places.iter_mut().zip(hidden) {
        let mut hidden = hidden.into_iter();
        list.list.retain(|_| !hidden.next().unwrap_or(false));
    }
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

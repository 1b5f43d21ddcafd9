//! Positions in the picture at which a mesh is tried: all pixels of its part, or a jittered grid over it.

use texmap_math::CameraFrame;
use texmap_math::glam::{DMat3, DVec2, DVec3};

use super::{PixelSample, PixelSamples, Source};
use crate::View;

/// Positions a side of the grid over the mesh's part of the picture, where that has more pixels.
const GRID: u32 = 128;
/// Most positions of all meshes together: a third of a gigabyte.
const POSITIONS: f64 = 2_097_152.0;

/// Positions a side of the grids of all meshes: fewer where many meshes fill much of the picture.
pub(crate) fn grid(views: &[View<'_>]) -> u32 {
    let most = f64::from(GRID * GRID);
    let positions = |view: &View<'_>| {
        let area = bounds(view).map_or(0.0, |(low, high)| (high - low).element_product());
        area.min(most)
    };
    let all: f64 = views.iter().map(positions).sum();
    match all <= POSITIONS {
        true => GRID,
        false => ((f64::from(GRID) * (POSITIONS / all).sqrt()) as u32).max(1),
    }
}

/// Pixels with the mesh's nearest triangle there: all in its part of the picture, or a jittered grid of `side` x `side`.
pub(crate) fn places(view: &View<'_>, side: u32) -> PixelSamples {
    let source = source(view);
    let Some((low, high)) = bounds(view) else {
        return PixelSamples {
            list: Vec::new(),
            source,
            share: 1.0,
        };
    };
    let (low, high) = (low.floor(), high.ceil());
    let [wide, tall] = (high - low).to_array();
    let all = wide * tall <= f64::from(side * side);
    let (columns, rows) = if all {
        (wide as u32, tall as u32)
    } else {
        (side, side)
    };
    let cells = columns * rows;
    let positions: Vec<DVec2> = (0..cells)
        .map(|i| {
            let jitter = DVec2::new(hash(2 * i), hash(2 * i + 1));
            let jitter = if all { DVec2::splat(0.5) } else { jitter };
            let cell = DVec2::new(f64::from(i % columns), f64::from(i / columns));
            let count = DVec2::new(f64::from(columns), f64::from(rows));
            let at = low + (high - low) * (cell + jitter) / count;
            // Pixel centres: the renderer takes no other samples.
            at.floor() + 0.5
        })
        .collect();
    let grid = Grid {
        low,
        high,
        columns,
        rows,
    };
    let mut nearest: Vec<Option<(f64, PixelSample)>> = vec![None; cells as usize];
    for triangle in &view.mesh.triangles {
        let corners = triangle.map(|i| view.positions[i as usize]);
        let world = triangle.map(|i| view.world(i));
        let uvs = triangle.map(|i| {
            let uv = view.mesh.uvs.get(i as usize);
            uv.map_or([0.0; 2], |uv| uv.map(f64::from))
        });
        let [a, b, c] = corners.map(|p| DVec3::new(p.x, p.y, p.w));
        let m = DMat3::from_cols(a, b, c);
        if m.determinant() == 0.0 || !m.is_finite() {
            continue;
        }
        let weights = m.inverse();
        // Rows of the inverse are the planes of the corners' weights over w.
        let plane = |values: [f64; 3]| weights.transpose() * DVec3::from(values);
        let world = [0, 1, 2].map(|k| plane(world.map(|c| c[k])));
        let uv = [0, 1].map(|k| plane(uvs.map(|c| c[k])));
        let plane_w = plane([1.0; 3]);
        let Some((from, to)) = grid.range(&corners.map(|p| DVec3::new(p.x, p.y, p.w))) else {
            continue;
        };
        for j in from.1..=to.1 {
            for i in from.0..=to.0 {
                let index = (j * columns + i) as usize;
                let p = positions[index];
                let e = weights * DVec3::new(p.x, p.y, 1.0);
                let inv_w = e.x + e.y + e.z;
                if !(e.min_element() >= 0.0 && inv_w > 0.0)
                    || nearest[index].is_some_and(|(w, _)| w >= inv_w)
                {
                    continue;
                }
                let place = PixelSample {
                    centre: p,
                    uv,
                    world,
                    inv_w: plane_w,
                };
                nearest[index] = Some((inv_w, place));
            }
        }
    }
    let seen = nearest.into_iter().flatten().map(|(_, place)| place);
    PixelSamples {
        list: seen.collect(),
        source,
        share: (f64::from(cells) / (wide * tall)).min(1.0),
    }
}

fn source(view: &View<'_>) -> Source {
    match (view.mesh.uv_projection, view.mesh.texture_frame) {
        (Some(map), _) => Source::Round(map),
        (None, Some(frame)) => {
            let frame = frame.transform(view.view_from_world * view.mesh.world_from_object);
            let camera = CameraFrame::new(frame, view.rays());
            Source::Frame(camera.planes())
        }
        (None, None) => Source::Vertices,
    }
}

/// The mesh's part of the picture in pixels; the whole picture where it crosses the eye's plane.
fn bounds(view: &View<'_>) -> Option<(DVec2, DVec2)> {
    let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
    for p in view
        .mesh
        .triangles
        .iter()
        .flatten()
        .map(|i| view.positions[*i as usize])
    {
        if !(p.w > 1e-9) {
            return Some((DVec2::ZERO, view.size));
        }
        let at = DVec2::new(p.x, p.y) / p.w;
        (low, high) = (low.min(at), high.max(at));
    }
    let (low, high) = (low.max(DVec2::ZERO), high.min(view.size));
    (low.cmplt(high).all()).then_some((low, high))
}

/// Cells over a part of the picture.
struct Grid {
    low: DVec2,
    high: DVec2,
    columns: u32,
    rows: u32,
}

impl Grid {
    /// The cells that a triangle may touch, both ends included.
    fn range(&self, corners: &[DVec3; 3]) -> Option<((u32, u32), (u32, u32))> {
        let last = (self.columns - 1, self.rows - 1);
        if corners.iter().any(|p| !(p.z > 1e-9)) {
            return Some(((0, 0), last));
        }
        let count = DVec2::new(f64::from(self.columns), f64::from(self.rows));
        let (mut from, mut to) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for p in corners {
            let cell = (DVec2::new(p.x, p.y) / p.z - self.low) / (self.high - self.low) * count;
            (from, to) = (from.min(cell), to.max(cell));
        }
        // A position may lie a pixel away from its cell.
        let reach = count / (self.high - self.low) + 1.0;
        let (from, to) = ((from - reach).floor(), (to + reach).ceil());
        let end = DVec2::new(f64::from(last.0), f64::from(last.1));
        if to.min_element() < 0.0 || from.cmpgt(end).any() {
            return None;
        }
        let index = |c: DVec2| {
            let c = c.clamp(DVec2::ZERO, end);
            (c.x as u32, c.y as u32)
        };
        Some((index(from), index(to)))
    }
}

/// A number in 0..1 for each index, the same everywhere.
fn hash(index: u32) -> f64 {
    let mut h = index.wrapping_add(1).wrapping_mul(0x9e37_79b9);
    h ^= h >> 16;
    h = h.wrapping_mul(0x21f0_aaad);
    h ^= h >> 15;
    h = h.wrapping_mul(0x735a_2d97);
    f64::from(h ^ (h >> 15)) / 4_294_967_296.0
}

#[cfg(test)]
mod tests {
    use texmap_math::glam::{DMat4, DVec4};

    use super::*;
    use crate::pilot::FEWEST;

    #[test]
    fn many_meshes_that_fill_the_picture_share_their_positions() {
        let scene = crate::tests::scene();
        let lighting = crate::Lighting::new(&scene, &[]);
        let positions = [[0.0, 0.0], [640.0, 0.0], [640.0, 640.0], [0.0, 640.0]]
            .map(|[x, y]| DVec4::new(x, y, 0.0, 1.0));
        let side = |count: usize| {
            let view = || View {
                scene: &scene,
                mesh: &scene.meshes[0],
                lighting: &lighting,
                positions: &positions,
                size: DVec2::splat(640.0),
                view_from_world: DMat4::IDENTITY,
                half: [1.0; 2],
            };
            grid(&std::iter::repeat_with(view).take(count).collect::<Vec<_>>())
        };
        assert_eq!((side(1), side(128)), (GRID, GRID));
        for count in [129, 1000, 20_000, 200_000] {
            let all = count as f64 * f64::from(side(count).pow(2));
            let fits = (POSITIONS / 2.0..=POSITIONS).contains(&all);
            assert!(fits, "{count}: {all}");
        }
        assert!(side(20_000).pow(2) as usize >= FEWEST);
    }
}

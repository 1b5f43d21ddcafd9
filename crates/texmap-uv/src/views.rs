//! Edges seen from outside, by a depth map from each of 14 sides.

use alloc::vec;
use alloc::vec::Vec;
use texmap_math::glam::{DMat3, DVec2, DVec3};
use texmap_math::{float, parallel};

use crate::mesh::{Mesh, length, unit_or_zero};
use crate::topology::{Topology, edge_length};

/// Edge of a depth map.
const SIZE: usize = 256;

/// Most pixels that the triangles and edges of one view may meet. Very many large ones get a smaller map.
const PIXELS: f64 = (1 << 25) as f64;

/// Mean part of the edges' length that is seen from the six axes and the eight corners of a cube. Views are without
/// perspective; each edge is named by one corner. Depth is compared at the pixels of a 256 x 256 map (a smaller one
/// where triangles overlap hundreds of times), so the answer is a measure, not a proof.
pub(crate) fn seen(mesh: &Mesh<'_>, topology: &Topology, edges: &[usize]) -> f64 {
    let (low, high) = mesh.bounds(&DMat3::IDENTITY);
    let (centre, radius) = ((low + high) * 0.5, length(high - low) * 0.5);
    let total: f64 = edges.iter().map(|&k| edge_length(mesh, topology, k)).sum();
    if radius <= 0.0 || total <= 0.0 {
        return 0.0;
    }
    let directions: Vec<DVec3> = (0..27)
        .map(|k| {
            DVec3::new(
                f64::from(k % 3 - 1),
                f64::from(k / 3 % 3 - 1),
                f64::from(k / 9 - 1),
            )
        })
        .filter(|d| matches!(d.dot(*d) as u32, 1 | 3))
        .map(unit_or_zero)
        .collect();
    let shares = parallel::map(directions.iter().copied(), |direction| {
        let mut view = View::new(centre, radius, direction, SIZE);
        while view.size > 8 && view.pixels(mesh, topology, edges) > PIXELS {
            view = View::new(centre, radius, direction, view.size / 2);
        }
        let depth = view.depth(mesh);
        edges
            .iter()
            .map(|&k| {
                view.length_seen(&depth, mesh.point(k), mesh.point(topology.next[k] as usize))
            })
            .sum::<f64>()
            / total
    });
    shares.iter().sum::<f64>() / shares.len() as f64
}

struct View {
    centre: DVec3,
    right: DVec3,
    up: DVec3,
    /// Toward the eye.
    back: DVec3,
    /// Pixels per unit.
    scale: f64,
    /// Edge of the depth map.
    size: usize,
}

impl View {
    fn new(centre: DVec3, radius: f64, back: DVec3, size: usize) -> Self {
        let helper = if back.y.abs() < 0.9 {
            DVec3::Y
        } else {
            DVec3::X
        };
        let right = unit_or_zero(helper.cross(back));
        Self {
            centre,
            right,
            up: back.cross(right),
            back,
            scale: (size as f64 - 2.0) / (2.0 * radius),
            size,
        }
    }

    /// Pixels of the boxes around the triangles, and of the edges: what a view costs.
    fn pixels(&self, mesh: &Mesh<'_>, topology: &Topology, edges: &[usize]) -> f64 {
        let place = |k: usize| self.place(mesh.point(k)).0;
        let triangles = mesh.faces().triangles().map(|(_, corners)| {
            let [a, b, c] = corners.map(place);
            let e = a.max(b).max(c) - a.min(b).min(c);
            (e.x + 1.0) * (e.y + 1.0)
        });
        let edges = edges.iter().map(|&k| {
            let across = place(topology.next[k] as usize) - place(k);
            across.x.abs() + across.y.abs() + 1.0
        });
        triangles.sum::<f64>() + edges.sum::<f64>()
    }

    /// Pixel position and nearness.
    fn place(&self, p: DVec3) -> (DVec2, f64) {
        let d = p - self.centre;
        (
            DVec2::new(d.dot(self.right), d.dot(self.up)) * self.scale + self.size as f64 * 0.5,
            d.dot(self.back),
        )
    }

    /// Largest nearness at each pixel centre.
    fn depth(&self, mesh: &Mesh<'_>) -> Vec<f64> {
        let mut map = vec![f64::NEG_INFINITY; self.size * self.size];
        for (_, corners) in mesh.faces().triangles() {
            let [a, b, c] = corners.map(|k| self.place(mesh.point(k)));
            let area = (b.0 - a.0).perp_dot(c.0 - a.0);
            if area == 0.0 {
                continue;
            }
            let (low, high) = (a.0.min(b.0).min(c.0), a.0.max(b.0).max(c.0));
            // Pixel centres at k + 0.5.
            let first = |x: f64| float::ceil(x - 0.5) as usize;
            let after = |x: f64| (float::floor(x - 0.5) as isize + 1).max(0) as usize;
            for y in first(low.y)..after(high.y).min(self.size) {
                for x in first(low.x)..after(high.x).min(self.size) {
                    let p = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
                    let (wb, wc) = (
                        (p - a.0).perp_dot(c.0 - a.0) / area,
                        (b.0 - a.0).perp_dot(p - a.0) / area,
                    );
                    if wb >= 0.0 && wc >= 0.0 && wb + wc <= 1.0 {
                        let near = a.1 + (b.1 - a.1) * wb + (c.1 - a.1) * wc;
                        let slot = &mut map[y * self.size + x];
                        *slot = if near > *slot { near } else { *slot };
                    }
                }
            }
        }
        map
    }

    fn length_seen(&self, depth: &[f64], a: DVec3, b: DVec3) -> f64 {
        let ((pa, _), (pb, _)) = (self.place(a), self.place(b));
        let across = pb - pa;
        let steps = float::ceil(float::sqrt(across.dot(across))) as usize + 1;
        // Two and a half pixels: the surface around an edge rises between pixel centres.
        let slack = 2.5 / self.scale;
        let hits = (0..steps)
            .filter(|k| {
                let (p, near) = self.place(a + (b - a) * ((*k as f64 + 0.5) / steps as f64));
                let (x, y) = (
                    (p.x as usize).min(self.size - 1),
                    (p.y as usize).min(self.size - 1),
                );
                near + slack >= depth[y * self.size + x]
            })
            .count();
        length(b - a) * hits as f64 / steps as f64
    }
}

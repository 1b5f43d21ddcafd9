//! Adaptive tessellation without cracks: edges that are too long are halved, again and again.
//!
//! Vertices of one position are one point, whatever normals and coordinates they carry, and whether an edge is halved is decided
//! once for each pair of points: if any triangle at it finds it too long. So neighbours always agree, across seams of
//! coordinates, split normals and borders of meshes, and no vertex ever lies within the edge of another triangle (no
//! T-junctions). A triangle with one, two or three halved edges becomes two, three or four.

use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};

use texmap_math::glam::DVec3;

/// Attributes of a corner, with the index of its point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Vertex {
    pub(crate) point: u32,
    pub(crate) mesh: u32,
    pub(crate) normal: [f32; 3],
    pub(crate) uv: [f32; 2],
    pub(crate) lightmap_uv: [f32; 2],
    pub(crate) color: [f32; 3],
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Triangle {
    pub(crate) vertices: [u32; 3],
    /// Number of the triangle in its mesh before any edge was halved.
    pub(crate) base: u32,
}

/// Triangles of one or more meshes over shared points.
#[derive(Debug, Default)]
pub(crate) struct Net {
    /// Object space.
    pub(crate) points: Vec<[f32; 3]>,
    pub(crate) vertices: Vec<Vertex>,
    pub(crate) triangles: Vec<Triangle>,
}

/// Keys are pairs of indices; only looked up, never walked through.
pub(crate) type Pairs<T> = HashMap<u64, T, BuildHasherDefault<PairHasher>>;

/// Of two indices, whichever comes first.
pub(crate) fn pair(a: u32, b: u32) -> u64 {
    let (low, high) = if a < b { (a, b) } else { (b, a) };
    u64::from(low) << 32 | u64::from(high)
}

/// Multiplicative hashing (Knuth, volume 3, 6.4); for keys that no adversary chooses.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct PairHasher(u64);

impl Hasher for PairHasher {
    fn finish(&self) -> u64 {
        self.0
    }

    fn write(&mut self, bytes: &[u8]) {
        bytes.iter().for_each(|b| self.write_u64(u64::from(*b)));
    }

    fn write_u64(&mut self, key: u64) {
        let mixed = (self.0 ^ key ^ key >> 29).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        self.0 = mixed ^ mixed >> 32;
    }
}

impl Net {
    /// Halves edges until `too_long` holds for none.
    ///
    /// # Errors
    /// The number of triangles as soon as there are more than `limit`.
    ///
    /// `too_long(a, b)` must not depend on the order of its two vertices. Edges between two corners at one point stay.
    pub(crate) fn refine(
        &mut self,
        too_long: impl Fn(&Self, &Vertex, &Vertex) -> bool,
        limit: usize,
    ) -> Result<(), usize> {
        let mut done = Vec::with_capacity(self.triangles.len());
        let mut open = std::mem::take(&mut self.triangles);
        while !open.is_empty() {
            let halved = self.halve(&open, &too_long);
            let mut next = Vec::with_capacity(4 * open.len());
            // Midpoints of vertices: two at one pair of points where a seam runs.
            let mut middles = Pairs::default();
            for triangle in open {
                let mids = [0, 1, 2].map(|k| {
                    let [a, b] = [k, (k + 1) % 3].map(|k| triangle.vertices[k]);
                    self.middle(a, b, &halved, &mut middles)
                });
                if mids == [None; 3] {
                    done.push(triangle);
                } else {
                    self.split(triangle, mids, &mut next);
                }
                if done.len() + next.len() > limit {
                    return Err(done.len() + next.len());
                }
            }
            open = next;
        }
        // In the order of the triangles that they come from.
        done.sort_by_key(|t| (self.vertices[t.vertices[0] as usize].mesh, t.base));
        self.triangles = done;
        Ok(())
    }

    /// The middle of every edge that some triangle finds too long.
    fn halve(
        &mut self,
        open: &[Triangle],
        too_long: &impl Fn(&Self, &Vertex, &Vertex) -> bool,
    ) -> Pairs<u32> {
        let mut halved = Pairs::default();
        for triangle in open {
            for k in 0..3 {
                let [a, b] = [k, (k + 1) % 3].map(|k| self.vertices[triangle.vertices[k] as usize]);
                let key = pair(a.point, b.point);
                if a.point == b.point || halved.contains_key(&key) || !too_long(self, &a, &b) {
                    continue;
                }
                let middle = mean(self.points[a.point as usize], self.points[b.point as usize]);
                halved.insert(key, self.points.len() as u32);
                self.points.push(middle);
            }
        }
        halved
    }

    fn middle(
        &mut self,
        a: u32,
        b: u32,
        halved: &Pairs<u32>,
        middles: &mut Pairs<u32>,
    ) -> Option<u32> {
        let [p, q] = [a, b].map(|v| self.vertices[v as usize]);
        let point = *halved.get(&pair(p.point, q.point))?;
        Some(*middles.entry(pair(a, b)).or_insert_with(|| {
            self.vertices.push(Vertex {
                point,
                mesh: p.mesh,
                normal: mean(p.normal, q.normal),
                uv: mean(p.uv, q.uv),
                lightmap_uv: mean(p.lightmap_uv, q.lightmap_uv),
                color: mean(p.color, q.color),
            });
            self.vertices.len() as u32 - 1
        }))
    }

    /// The parts of a triangle: their order and the diagonal are its own affair, its edges are not.
    fn split(&self, triangle: Triangle, mids: [Option<u32>; 3], out: &mut Vec<Triangle>) {
        let mut add = |vertices| {
            out.push(Triangle {
                vertices,
                ..triangle
            });
        };
        let turned = |by: usize| {
            let at = |k: usize| (k + by) % 3;
            (
                [0, 1, 2].map(|k| triangle.vertices[at(k)]),
                [0, 1, 2].map(|k| mids[at(k)]),
            )
        };
        for by in 0..3 {
            let (v, m) = turned(by);
            match m {
                [Some(x), Some(y), Some(z)] => {
                    add([v[0], x, z]);
                    add([x, v[1], y]);
                    add([z, y, v[2]]);
                    add([x, y, z]);
                    return;
                }
                [Some(x), Some(y), None] => {
                    add([x, v[1], y]);
                    if self.distance(x, v[2]) <= self.distance(v[0], y) {
                        add([v[0], x, v[2]]);
                        add([x, y, v[2]]);
                    } else {
                        add([v[0], x, y]);
                        add([v[0], y, v[2]]);
                    }
                    return;
                }
                [Some(x), None, None] => {
                    add([v[0], x, v[2]]);
                    add([x, v[1], v[2]]);
                    return;
                }
                _ => {}
            }
        }
    }

    fn distance(&self, a: u32, b: u32) -> f64 {
        let [a, b] = [a, b].map(|v| self.position(&self.vertices[v as usize]));
        (b - a).length_squared()
    }

    pub(crate) fn position(&self, vertex: &Vertex) -> DVec3 {
        DVec3::from(self.points[vertex.point as usize].map(f64::from))
    }
}

/// The same bits in either order; halves first, so that it cannot overflow.
fn mean<const N: usize>(a: [f32; N], b: [f32; N]) -> [f32; N] {
    std::array::from_fn(|i| 0.5 * a[i] + 0.5 * b[i])
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;

    /// Two triangles over a square with a seam along the diagonal: the corners of both sides are apart.
    fn seam() -> Net {
        let vertex = |point: u32, side: f32| Vertex {
            point,
            mesh: 0,
            normal: [0.0, 0.0, 1.0],
            uv: [side, point as f32],
            lightmap_uv: [0.0; 2],
            color: [1.0; 3],
        };
        Net {
            points: vec![
                [0.0, 0.0, 0.0],
                [4.0, 0.0, 0.0],
                [4.0, 3.0, 0.0],
                [0.0, 3.0, 0.0],
            ],
            vertices: vec![
                vertex(0, 0.0),
                vertex(1, 0.0),
                vertex(2, 0.0),
                vertex(0, 1.0),
                vertex(2, 1.0),
                vertex(3, 1.0),
            ],
            triangles: vec![
                Triangle {
                    vertices: [0, 1, 2],
                    base: 0,
                },
                Triangle {
                    vertices: [3, 4, 5],
                    base: 1,
                },
            ],
        }
    }

    /// Number of triangles at each edge, by points.
    fn edges(net: &Net) -> BTreeMap<u64, u32> {
        let mut edges = BTreeMap::new();
        for t in &net.triangles {
            let p = t.vertices.map(|v| net.vertices[v as usize].point);
            for k in 0..3 {
                *edges.entry(pair(p[k], p[(k + 1) % 3])).or_default() += 1;
            }
        }
        edges
    }

    fn area(net: &Net) -> f64 {
        let at = |v: u32| net.position(&net.vertices[v as usize]);
        let area = |t: &Triangle| {
            let [a, b, c] = t.vertices.map(at);
            0.5 * (b - a).cross(c - a).z
        };
        net.triangles.iter().map(area).sum()
    }

    /// An uneven rule, finer towards one corner and on one side of the seam only.
    fn uneven(net: &Net, a: &Vertex, b: &Vertex) -> bool {
        let [p, q] = [a, b].map(|v| net.position(v));
        let near = p.length().min(q.length());
        (q - p).length() > 0.05 + 0.1 * near && (a.uv[0] == 0.0 || near < 1.0)
    }

    #[test]
    fn inner_edges_keep_two_triangles_and_the_border_one() {
        let mut net = seam();
        net.refine(uneven, 100_000).unwrap();
        assert!(net.triangles.len() > 500, "{}", net.triangles.len());
        assert!(
            (area(&net) - 12.0).abs() < 1e-5,
            "nothing is lost or turned over"
        );
        for (key, count) in edges(&net) {
            let [a, b] = [key >> 32, key & 0xffff_ffff].map(|p| net.points[p as usize]);
            let border =
                (0..2).any(|axis| a[axis] == b[axis] && [0.0, [4.0, 3.0][axis]].contains(&a[axis]));
            assert_eq!(count, if border { 1 } else { 2 }, "{a:?} {b:?}");
        }
        // The negative twin: each triangle decides for itself, and the seam opens.
        let mut torn = seam();
        for v in 3..6 {
            torn.points
                .push(torn.points[torn.vertices[v].point as usize]);
            torn.vertices[v].point = torn.points.len() as u32 - 1;
        }
        torn.refine(uneven, 100_000).unwrap();
        let at = |net: &Net| {
            let on = |p: &&[f32; 3]| (p[1] * 4.0 - p[0] * 3.0).abs() < 1e-5;
            net.points
                .iter()
                .filter(on)
                .map(|p| p.map(f32::to_bits))
                .collect::<Vec<_>>()
        };
        let both = at(&torn)
            .iter()
            .filter(|p| at(&torn).iter().filter(|q| q == p).count() == 2)
            .count();
        assert!(
            both < at(&torn).len(),
            "points on one side of the seam alone"
        );
    }

    #[test]
    fn limits_and_folded_edges_hold() {
        let always = |_: &Net, _: &Vertex, _: &Vertex| true;
        assert!(seam().refine(always, 1_000).is_err());
        // A triangle that is a line, and one that is a point.
        let mut flat = seam();
        flat.vertices[1].point = 0;
        flat.vertices.iter_mut().skip(3).for_each(|v| v.point = 0);
        let long =
            |net: &Net, a: &Vertex, b: &Vertex| (net.position(a) - net.position(b)).length() > 1.0;
        flat.refine(long, 1_000).unwrap();
        assert!(flat.triangles.len() < 40);
    }
}

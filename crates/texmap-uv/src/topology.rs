//! The neighbours of a mesh: which corners own the same edge in space, and whether the picture goes on across it.

use alloc::vec;
use alloc::vec::Vec;
use texmap_math::glam::DVec3;

use crate::mesh::{Faces, Mesh, length};
use crate::uv_set::UvSet;

/// No neighbour: the rim of the mesh.
pub(crate) const RIM: u32 = u32::MAX;
/// More than one neighbour.
pub(crate) const MANY: u32 = u32::MAX - 1;

/// Neighbours across edges. The edge of a corner runs from it to the next corner of its face.
pub(crate) struct Topology {
    /// First of the equal positions, for every position.
    pub(crate) welded: Vec<u32>,
    /// Face of each corner.
    pub(crate) face: Vec<u32>,
    /// Next corner around the face.
    pub(crate) next: Vec<u32>,
    /// The corner that owns the same edge in the neighbouring face, [`RIM`] or [`MANY`].
    pub(crate) twin: Vec<u32>,
    /// Both corners of faces that run along an edge and back, either first, ascending.
    bridges: Vec<[u32; 2]>,
}

impl Topology {
    pub(crate) fn new(mesh: &Mesh<'_>) -> Self {
        let (faces, welded) = (mesh.faces(), mesh.welded());
        let count = faces.corners().len();
        let (mut face, mut next) = (vec![0; count], vec![0; count]);
        for f in 0..faces.len() {
            let r = faces.range(f);
            for k in r.clone() {
                face[k] = f as u32;
                next[k] = if k + 1 == r.end {
                    r.start as u32
                } else {
                    k as u32 + 1
                };
            }
        }
        let corner_vertex: Vec<u32> = faces
            .corners()
            .iter()
            .map(|&i| welded[i as usize])
            .collect();
        let ends = |k: usize| {
            let (a, b) = (corner_vertex[k], corner_vertex[next[k] as usize]);
            if a < b { (a, b) } else { (b, a) }
        };
        // Corners sorted by the lower end of their edge, by counting; each with the higher end before it.
        let mut start = vec![0u32; mesh.positions().len() + 1];
        for k in 0..count {
            start[ends(k).0 as usize + 1] += 1;
        }
        for v in 1..start.len() {
            start[v] += start[v - 1];
        }
        let (mut fill, mut sorted) = (start.clone(), vec![0u64; count]);
        for k in 0..count {
            let (low, high) = ends(k);
            let slot = &mut fill[low as usize];
            sorted[*slot as usize] = u64::from(high) << 32 | k as u64;
            *slot += 1;
        }
        let (mut twin, mut bridges) = (vec![RIM; count], Vec::new());
        for (v, range) in start.windows(2).enumerate() {
            let bucket = &mut sorted[range[0] as usize..range[1] as usize];
            bucket.sort_unstable();
            for group in bucket.chunk_by(|a, b| a >> 32 == b >> 32) {
                match *group {
                    // An edge without length joins nothing.
                    [edge, ..] if edge >> 32 == v as u64 => {}
                    [_] => {}
                    [a, b] if face[a as u32 as usize] != face[b as u32 as usize] => {
                        (twin[a as u32 as usize], twin[b as u32 as usize]) = (b as u32, a as u32);
                    }
                    _ => {
                        let edges = group.iter().map(|e| *e as u32).collect();
                        bridges.extend(link(faces, &face, &next, edges, &mut twin));
                    }
                }
            }
        }
        bridges.extend_from_within(..);
        let half = bridges.len() / 2;
        bridges[half..].iter_mut().for_each(|pair| pair.reverse());
        bridges.sort_unstable();
        Self {
            welded,
            face,
            next,
            twin,
            bridges,
        }
    }

    /// The corner of the neighbouring face at the same end of the edge of `k`: of its start, and of its end.
    pub(crate) fn across(&self, mesh: &Mesh<'_>, k: usize) -> Option<[usize; 2]> {
        let twin = self.twin[k];
        if twin == RIM || twin == MANY {
            return None;
        }
        let (t, t_next) = (twin as usize, self.next[twin as usize] as usize);
        let vertex = |k: usize| self.welded[mesh.faces().corners()[k] as usize];
        // Neighbours of one winding run along the edge in opposite directions.
        Some(if vertex(t) == vertex(k) {
            [t, t_next]
        } else {
            [t_next, t]
        })
    }

    /// The positions of both ends of the edge of `k`, as numbers, the lower one first.
    pub(crate) fn ends(&self, mesh: &Mesh<'_>, k: usize) -> [u32; 2] {
        let [a, b] =
            [k, self.next[k] as usize].map(|k| self.welded[mesh.faces().corners()[k] as usize]);
        [a.min(b), a.max(b)]
    }

    /// One corner for all corners that are twins of one another over faces without area: the lower one of the two
    /// faces at the ends of the chain.
    pub(crate) fn name(&self, k: usize) -> usize {
        let last = |mut k: usize| {
            // Very long chains may have several names.
            for _ in 0..64 {
                let pair = self
                    .bridges
                    .binary_search_by_key(&(k as u32), |pair| pair[0]);
                let Ok(pair) = pair else { break };
                let other = self.bridges[pair][1] as usize;
                if self.twin[other] >= MANY {
                    return other;
                }
                k = self.twin[other] as usize;
            }
            k
        };
        last(k).min(last(self.twin[k] as usize))
    }

    /// True if the picture goes on across the edge of `k`: both ends use the same texture coordinates.
    pub(crate) fn joined(&self, mesh: &Mesh<'_>, set: &UvSet, k: usize) -> bool {
        let here = [k, self.next[k] as usize].map(|c| set.corners[c]);
        self.across(mesh, k)
            .is_some_and(|there| there.map(|c| set.corners[c]) == here)
    }
}

/// Twins on an edge that is not simply that of two faces, its corners in ascending order. The pairs of corners of faces
/// that run along it and back.
///
/// A face that runs along the edge and back (two of its corners have one position, as in the fans of quads at a pole)
/// has no area there: it stands between its neighbours like a bridge. Beside such faces two may meet, as on any edge.
fn link(
    faces: &Faces,
    face: &[u32],
    next: &[u32],
    edges: Vec<u32>,
    twin: &mut [u32],
) -> Vec<[u32; 2]> {
    let of = |k: u32| face[k as usize];
    // Corners of one face follow one another.
    let mut bridges: Vec<[u32; 2]> = Vec::new();
    let mut solid: Vec<u32> = Vec::new();
    for part in edges.chunk_by(|a, b| of(*a) == of(*b)) {
        match *part {
            [a, b] => bridges.push([a, b]),
            [k] => solid.push(k),
            _ => solid.extend(part),
        }
    }
    if solid.len() > 2 {
        edges.iter().for_each(|&k| twin[k as usize] = MANY);
        return Vec::new();
    }
    // From one solid face over the bridges to the other, each step to the bridge that shares both positions if
    // there is one, and else to one that runs the opposite way.
    let position = |k: u32| faces.corners()[k as usize];
    let ends = |k: u32| [position(k), position(next[k as usize])];
    let fit = |from: u32, to: u32| {
        let ([a, b], [c, d]) = (ends(from), ends(to));
        match (a == d, b == c) {
            (true, true) => 2,
            (true, _) | (_, true) => 1,
            _ => 0,
        }
    };
    let pairs = bridges.clone();
    let mut solid = solid.into_iter();
    bridges.reverse();
    let Some(mut from) = solid.next().or_else(|| bridges.pop().map(|[_, out]| out)) else {
        return pairs;
    };
    let mut join = |a: u32, b: u32| (twin[a as usize], twin[b as usize]) = (b, a);
    while !bridges.is_empty() {
        // Among a few: very many faces without area may lie on one edge.
        let near = bridges.len().saturating_sub(16)..bridges.len();
        let choices = near.flat_map(|i| [(i, 1), (i, 0)]);
        let best = choices.max_by_key(|&(i, end)| fit(from, bridges[i][end]));
        let Some((i, end)) = best else { break };
        let bridge = bridges.remove(i);
        join(from, bridge[end]);
        from = bridge[1 - end];
    }
    if let Some(last) = solid.next() {
        join(from, last);
    }
    pairs
}

/// Length in space of the edge of corner `k`.
pub(crate) fn edge_length(mesh: &Mesh<'_>, topology: &Topology, k: usize) -> f64 {
    let d: DVec3 = mesh.point(topology.next[k] as usize) - mesh.point(k);
    length(d)
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::islands::Islands;

    pub(crate) fn flat(mesh: &Mesh<'_>) -> UvSet {
        let values: Vec<[f32; 2]> = (0..mesh.faces().corners().len())
            .map(|k| mesh.point(k))
            .map(|p| [p.x as f32, p.y as f32])
            .collect();
        UvSet::shared(mesh, &values)
    }

    /// Two quads that meet in a pole, each with a corner of its own there. Their fans have faces without area, which
    /// are no seam, whether the corners share a position or not.
    #[test]
    fn faces_without_area_stand_between_their_neighbours() {
        let positions = [
            [0.0, 1.0, 0.0],
            [0.0, 1.0, 0.0],
            [0.0, 1.0, 0.0],
            [-1.0, 0.0, 0.0],
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
        ];
        for poles in [[0, 1, 2], [0, 0, 0]] {
            let [a, b, c] = poles;
            // Quads (3, 4, b, a) and (4, 5, c, b), from the pole: a fan begins with the face without area.
            let whole = [[a, 3, 4, b], [b, 4, 5, c]];
            let mut quads = Faces::new();
            whole.iter().for_each(|q| quads.push(q));
            let triangles: Vec<[u32; 3]> = whole
                .iter()
                .flat_map(|q| [[q[3], q[0], q[1]], [q[3], q[1], q[2]]])
                .collect();
            let mut orders = [triangles.clone(), triangles.clone()];
            orders[1].reverse();
            for faces in orders
                .iter()
                .map(|t| Faces::from_triangles(t))
                .chain([quads])
            {
                let mesh = Mesh::new(&positions, &faces).unwrap();
                let topology = Topology::new(&mesh);
                let set = flat(&mesh);
                assert_eq!(Islands::new(&mesh, &set, &topology).count, 1, "{faces:?}");
                assert!(!topology.twin.contains(&MANY), "{faces:?}");
                for (k, &twin) in topology.twin.iter().enumerate().filter(|(_, t)| **t < MANY) {
                    assert_eq!(topology.twin[twin as usize], k as u32);
                    assert_ne!(topology.face[k], topology.face[twin as usize]);
                }
                // The rim: from the pole along the lower side and back.
                let rim: f64 = (0..topology.twin.len())
                    .filter(|&k| topology.twin[k] == RIM)
                    .map(|k| edge_length(&mesh, &topology, k))
                    .sum();
                assert!((rim - 2.0 - 2.0 * f64::sqrt(2.0)).abs() < 1e-12, "{rim}");
            }
        }
    }

    #[test]
    fn many_faces_without_area_on_one_edge_are_one_chain() {
        let positions = [[0.0; 3], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]];
        let mut triangles = vec![[0, 1, 2], [1, 0, 3]];
        triangles.extend([[0, 1, 1]; 5000]);
        let faces = Faces::from_triangles(&triangles);
        let mesh = Mesh::new(&positions, &faces).unwrap();
        let topology = Topology::new(&mesh);
        let set = flat(&mesh);
        assert_eq!(Islands::new(&mesh, &set, &topology).count, 1);
        // A third face with area: now it is an edge of too many.
        triangles.push([0, 1, 2]);
        let faces = Faces::from_triangles(&triangles);
        let topology = Topology::new(&Mesh::new(&positions, &faces).unwrap());
        assert!(topology.twin.contains(&MANY));
    }

    #[test]
    fn three_faces_on_one_edge_join_nothing() {
        let positions = [
            [0.0; 3],
            [0.0, 1.0, 0.0],
            [1.0, 0.0, 0.0],
            [-1.0, 0.0, 0.0],
            [0.0, 0.0, 1.0],
        ];
        let faces = Faces::from_triangles(&[[0, 1, 2], [1, 0, 3], [0, 1, 4]]);
        let mesh = Mesh::new(&positions, &faces).unwrap();
        let topology = Topology::new(&mesh);
        assert_eq!(topology.twin.iter().filter(|t| **t == MANY).count(), 3);
        let set = UvSet::shared(&mesh, &[[0.0, 0.0]; 9]);
        assert_eq!(Islands::new(&mesh, &set, &topology).count, 3);
    }
}

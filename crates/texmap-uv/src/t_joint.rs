//! T-joints: vertices that lie inside an edge of a face that does not have them.
//!
//! Along such an edge neighbours do not share vertices: rounding leaves gaps of single pixels between them, and a
//! picture mapped by vertices bends on one side only.

use alloc::vec;
use alloc::vec::Vec;
use texmap_math::float;
use texmap_math::glam::DVec3;

use crate::mesh::{Mesh, length};
use crate::parallel;
use crate::topology::{RIM, Topology};

/// A vertex inside a foreign edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TJoint {
    /// Index of the position; of equal positions the first.
    pub vertex: u32,
    /// The face whose edge it lies in.
    pub face: u32,
    /// The edge's ends, as indices of positions.
    pub edge: [u32; 2],
}

/// Finds the T-joints of a mesh, by face. Only edges of a single face have any: an edge that two faces share has no
/// gap. A vertex lies in an edge when it is nearer to it than a millionth of its length or what rounding to f32 moves
/// it, and not within that of its ends. Linear in the edges for meshes whose rims have similar lengths; the same list
/// on any number of threads.
#[must_use]
pub fn t_joints(mesh: &Mesh<'_>) -> Vec<TJoint> {
    find(mesh, &Topology::new(mesh))
}

pub(crate) fn find(mesh: &Mesh<'_>, topology: &Topology) -> Vec<TJoint> {
    let corners = mesh.faces().corners();
    let ends =
        |k: usize| [k, topology.next[k] as usize].map(|k| topology.welded[corners[k] as usize]);
    let rim: Vec<usize> = (0..corners.len())
        .filter(|&k| topology.twin[k] == RIM && ends(k)[0] != ends(k)[1])
        .collect();
    let mut vertices: Vec<u32> = rim.iter().flat_map(|&k| ends(k)).collect();
    vertices.sort_unstable();
    vertices.dedup();
    let sum: f64 = rim
        .iter()
        .map(|&k| length(mesh.vertex(ends(k)[1]) - mesh.vertex(ends(k)[0])))
        .sum();
    if rim.is_empty() || !(sum > 0.0) {
        return Vec::new();
    }
    let grid = Grid::new(mesh, vertices, sum / rim.len() as f64);
    parallel::collect_chunks(rim.len(), |range| {
        let (mut out, mut near) = (Vec::new(), Vec::new());
        for &k in &rim[range] {
            let edge = ends(k);
            near.clear();
            inside(mesh, &grid, edge, &mut near);
            near.sort_unstable();
            near.dedup();
            out.extend(near.iter().map(|&vertex| TJoint {
                vertex,
                face: topology.face[k],
                edge,
            }));
        }
        out
    })
}

/// Vertices in the open edge.
fn inside(mesh: &Mesh<'_>, grid: &Grid, edge: [u32; 2], out: &mut Vec<u32>) {
    let [a, b] = edge.map(|v| mesh.vertex(v));
    let (along, most) = (b - a, a.abs().max(b.abs()).max_element());
    let whole = length(along);
    let tolerance = whole * 1e-6 + most * 2e-7;
    // Pieces of a cell's length: a long diagonal edge meets few of the cells in its box.
    let pieces = float::ceil(whole / grid.cell).clamp(1.0, 1e6);
    for piece in 0..pieces as u32 {
        let [p, q] = [f64::from(piece), f64::from(piece) + 1.0].map(|t| a + along * (t / pieces));
        grid.each(p.min(q) - tolerance, p.max(q) + tolerance, |v| {
            let from = mesh.vertex(v) - a;
            let t = from.dot(along) / whole;
            let off = length(from - along * (t / whole));
            if !edge.contains(&v) && off <= tolerance && t > tolerance && t < whole - tolerance {
                out.push(v);
            }
        });
    }
}

/// Vertices sorted by the cube of space they lie in, found by a hash of the cube.
struct Grid {
    cell: f64,
    slots: usize,
    starts: Vec<u32>,
    members: Vec<u32>,
}

impl Grid {
    fn new(mesh: &Mesh<'_>, vertices: Vec<u32>, cell: f64) -> Self {
        let mut grid = Self {
            cell,
            slots: vertices.len().next_power_of_two(),
            starts: Vec::new(),
            members: vec![0; vertices.len()],
        };
        let slot = |v: u32| grid.slot(grid.cube(mesh.vertex(v)));
        let mut starts = vec![0u32; grid.slots + 1];
        for &v in &vertices {
            starts[slot(v) + 1] += 1;
        }
        for s in 0..grid.slots {
            starts[s + 1] += starts[s];
        }
        let (mut fill, mut members) = (starts.clone(), vec![0; vertices.len()]);
        for &v in &vertices {
            let place = &mut fill[slot(v)];
            members[*place as usize] = v;
            *place += 1;
        }
        (grid.starts, grid.members) = (starts, members);
        grid
    }

    fn cube(&self, p: DVec3) -> [i64; 3] {
        p.to_array().map(|c| float::floor(c / self.cell) as i64)
    }

    fn slot(&self, cube: [i64; 3]) -> usize {
        // Multipliers of Teschner et al., "Optimized Spatial Hashing for Collision Detection" (2003).
        let mixed = cube
            .iter()
            .zip([73_856_093_i64, 19_349_663, 83_492_791])
            .fold(0, |h, (c, m)| h ^ c.wrapping_mul(m));
        (mixed ^ (mixed >> 17)) as usize & (self.slots - 1)
    }

    /// Visits the vertices of all cubes between two points, others among them.
    fn each(&self, low: DVec3, high: DVec3, mut visit: impl FnMut(u32)) {
        let (low, high) = (self.cube(low), self.cube(high));
        for x in low[0]..=high[0] {
            for y in low[1]..=high[1] {
                for z in low[2]..=high[2] {
                    let slot = self.slot([x, y, z]);
                    let range = self.starts[slot] as usize..self.starts[slot + 1] as usize;
                    self.members[range].iter().for_each(|&v| visit(v));
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Faces;

    /// Two squares above one of twice their width: the middle vertex lies in the long edge.
    #[test]
    fn a_vertex_inside_a_longer_edge_is_found() {
        let scale = 1.0 / 3.0;
        let positions = [
            [0.0, 0.0, 0.0],
            [2.0, 0.0, 0.0],
            [2.0, 1.0, 0.0],
            [0.0, 1.0, 0.0],
            [1.0, 1.0, 0.0],
            [0.0, 2.0, 0.0],
            [1.0, 2.0, 0.0],
            [2.0, 2.0, 0.0],
        ]
        .map(|p: [f32; 3]| p.map(|c| c * scale + 7.0));
        let mut faces = Faces::new();
        faces.push(&[0, 1, 2, 3]);
        faces.push(&[3, 4, 6, 5]);
        faces.push(&[4, 2, 7, 6]);
        let mesh = Mesh::new(&positions, &faces).unwrap();
        let joint = TJoint {
            vertex: 4,
            face: 0,
            edge: [2, 3],
        };
        assert_eq!(t_joints(&mesh), [joint]);
        // Cured by a face that has the vertex.
        let mut cured = Faces::new();
        cured.push(&[0, 1, 2, 4, 3]);
        cured.push(&[3, 4, 6, 5]);
        cured.push(&[4, 2, 7, 6]);
        assert_eq!(t_joints(&Mesh::new(&positions, &cured).unwrap()), []);
        // A hundredth beside the edge it is no joint but a gap of its own.
        let mut moved = positions;
        moved[4][1] += 0.01;
        assert_eq!(t_joints(&Mesh::new(&moved, &faces).unwrap()), []);
    }

    #[test]
    fn long_diagonals_and_crowds_are_searched_in_pieces() {
        // A fan of small triangles along one long diagonal edge.
        let n = 500u32;
        let at = |t: f64| [t, 0.7 * t, -0.3 * t].map(|c| c as f32);
        let mut positions = vec![at(0.0), at(f64::from(n)), [0.0, 300.0, 0.0]];
        let mut faces = Faces::new();
        faces.push(&[0, 1, 2]);
        for i in 0..n {
            let first = positions.len() as u32;
            let (a, b) = (at(f64::from(i)), at(f64::from(i + 1)));
            positions.extend([b, a, [b[0], b[1] - 1.0, b[2]]]);
            faces.push(&[first, first + 1, first + 2]);
        }
        let mesh = Mesh::new(&positions, &faces).unwrap();
        let found = t_joints(&mesh);
        assert_eq!(found.len(), n as usize - 1);
        assert!(found.iter().all(|j| j.face == 0 && j.edge == [0, 1]));
    }
}

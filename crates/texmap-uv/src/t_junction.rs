//! T-junctions: vertices that lie inside an edge of a face that does not have them.
//!
//! Along such an edge neighbours do not share vertices: rounding leaves gaps of single pixels between them, and a
//! picture mapped by vertices bends on one side only.

use alloc::vec::Vec;
use texmap_math::glam::DVec3;

use crate::mesh::{Mesh, length};
use crate::topology::{RIM, Topology};
use crate::tree::{Bounds, BoxTree, Meter, search_each, steps_for};

/// A vertex inside a foreign edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TJunction {
    /// Index of the position; of equal positions the first.
    pub vertex: u32,
    /// The face whose edge it lies in.
    pub face: u32,
    /// The edge's ends, as indices of positions.
    pub edge: [u32; 2],
}

/// The T-junctions of a mesh, by face.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct TJunctions {
    /// The T-junctions that were found; the first ones of each edge where they are more than 2^17 and more than 16 for each edge of
    /// a single face.
    pub list: Vec<TJunction>,
    /// Number of T-junctions that were found, in the list or not.
    pub count: usize,
    /// So many vertices lie along so many edges that the search was broken off: there may be more.
    pub at_least: bool,
}

/// Finds the T-junctions of a mesh, by face. Only edges of a single face have any: an edge that two faces share has no
/// gap. A vertex lies in an edge when it is nearer to it than a millionth of its length or what rounding to f32 moves
/// it, and not within that of its ends. At most n log n steps for n edges on any input; the same list on any number of
/// threads.
#[must_use]
pub fn t_junctions(mesh: &Mesh<'_>) -> TJunctions {
    find(mesh, &Topology::new(mesh))
}

pub(crate) fn find(mesh: &Mesh<'_>, topology: &Topology) -> TJunctions {
    let corners = mesh.faces().corners();
    let ends =
        |k: usize| [k, topology.next[k] as usize].map(|k| topology.welded[corners[k] as usize]);
    let rim: Vec<usize> = (0..corners.len())
        .filter(|&k| topology.twin[k] == RIM && ends(k)[0] != ends(k)[1])
        .collect();
    let mut vertices: Vec<u32> = rim.iter().flat_map(|&k| ends(k)).collect();
    vertices.sort_unstable();
    vertices.dedup();
    let tree = BoxTree::new(vertices, |v| [mesh.vertex(v); 2]);
    let (found, open) = search_each(rim.len(), steps_for(rim.len()), |i, meter, out| {
        let first = out.len();
        let done = inside(mesh, &tree, ends(rim[i]), meter, out);
        out[first..].sort_unstable();
        done
    });
    let joint = |(i, vertex): (u32, u32)| TJunction {
        vertex,
        face: topology.face[rim[i as usize]],
        edge: ends(rim[i as usize]),
    };
    let (count, most) = (found.len(), most_listed(rim.len()));
    // Every edge keeps its first ones: a list cut at its end would say nothing of later faces.
    let each = if count <= most {
        count
    } else {
        most / rim.len()
    };
    let of_edges = found.chunk_by(|(a, _), (b, _)| a == b);
    let listed = of_edges.flat_map(|of_edge| of_edge.iter().take(each));
    TJunctions {
        list: listed.copied().map(joint).collect(),
        count,
        at_least: !open.is_empty(),
    }
}

/// Most T-junctions of a list for this many edges: vertices along one line are n^2 / 3 of them.
fn most_listed(edges: usize) -> usize {
    (16 * edges).max(1 << 17)
}

/// Steps of a search that a vertex found counts for: finds have a bound as well.
const FOUND: u64 = 64;

/// Vertices in the open edge; false if the meter ran out.
fn inside(
    mesh: &Mesh<'_>,
    tree: &BoxTree,
    edge: [u32; 2],
    meter: &mut Meter,
    out: &mut Vec<u32>,
) -> bool {
    let [a, b] = edge.map(|v| mesh.vertex(v));
    let (along, most) = (b - a, a.abs().max(b.abs()).max_element());
    let whole = length(along);
    let tolerance = whole * 1e-6 + most * 2e-7;
    // Nothing is so far from both ends.
    if whole <= 2.0 * tolerance {
        return true;
    }
    let reach = tolerance * 1.001;
    let (low, high) = (a.min(b) - reach, a.max(b) + reach);
    tree.search(
        meter,
        |bounds| {
            let [l, h] = bounds;
            let beside = l.x > high.x || l.y > high.y || l.z > high.z;
            let before = h.x < low.x || h.y < low.y || h.z < low.z;
            !beside && !before && meets(a, along, bounds, reach)
        },
        |v, meter| {
            let from = mesh.vertex(v) - a;
            let t = from.dot(along) / whole;
            let off = length(from - along * (t / whole));
            if edge.contains(&v) || off > tolerance || t <= tolerance || t >= whole - tolerance {
                return true;
            }
            let enough = meter.take(FOUND);
            if enough {
                out.push(v);
            }
            enough
        },
    )
}

/// True if the segment from `a` along `along` meets the box, enlarged by `reach` on all sides (slabs).
fn meets(a: DVec3, along: DVec3, [low, high]: &Bounds, reach: f64) -> bool {
    let (mut from, mut to) = (0.0, 1.0);
    for k in 0..3 {
        let (near, far) = (low[k] - reach - a[k], high[k] + reach - a[k]);
        if along[k] == 0.0 {
            if near > 0.0 || far < 0.0 {
                return false;
            }
            continue;
        }
        let (s, t) = (near / along[k], far / along[k]);
        let (s, t) = if s < t { (s, t) } else { (t, s) };
        from = if s > from { s } else { from };
        to = if t < to { t } else { to };
    }
    from <= to
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
        let joint = TJunction {
            vertex: 4,
            face: 0,
            edge: [2, 3],
        };
        assert_eq!(t_junctions(&mesh).list, [joint]);
        // Cured by a face that has the vertex.
        let mut cured = Faces::new();
        cured.push(&[0, 1, 2, 4, 3]);
        cured.push(&[3, 4, 6, 5]);
        cured.push(&[4, 2, 7, 6]);
        assert_eq!(
            t_junctions(&Mesh::new(&positions, &cured).unwrap()),
            TJunctions::default()
        );
        // A hundredth beside the edge it is no joint but a gap of its own.
        let mut moved = positions;
        moved[4][1] += 0.01;
        assert_eq!(
            t_junctions(&Mesh::new(&moved, &faces).unwrap()),
            TJunctions::default()
        );
    }

    #[test]
    fn one_long_diagonal_edge_meets_every_vertex_in_it() {
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
        let found = t_junctions(&mesh).list;
        assert_eq!(found.len(), n as usize - 1);
        assert!(found.iter().all(|j| j.face == 0 && j.edge == [0, 1]));
    }
    /// Triangles of which one edge lies along one line: the list stays short, with a part of every edge, and the count is told.
    #[test]
    fn vertices_along_one_line_have_a_short_list() {
        let of_count = |count: u32| {
            let (mut positions, mut faces) = (Vec::new(), Faces::new());
            for i in 0..count {
                let x = i as f32 / 1024.0;
                positions.extend([[x, 0.0, 0.0], [32.0 - x, 0.0, 0.0], [16.0, 1.0, 64.0 * x]]);
                faces.push(&[3 * i, 3 * i + 1, 3 * i + 2]);
            }
            t_junctions(&Mesh::new(&positions, &faces).unwrap())
        };
        // Edge i has the vertices of all edges within it.
        let pairs = |count: usize| count * (count - 1);
        let few = of_count(300);
        assert_eq!((few.list.len(), few.count), (pairs(300), pairs(300)));
        let many = of_count(1000);
        assert!(!many.at_least);
        assert_eq!(many.count, pairs(1000));
        assert!(many.list.len() <= 1 << 17, "{}", many.list.len());
        let faces = many.list.chunk_by(|a, b| a.face == b.face);
        assert_eq!(faces.count(), 999, "the innermost has none");
    }
}

//! Neighbours and groups: which triangles around a vertex share its tangent (Mikkelsen 2008, section 3.2).

use alloc::vec;
use alloc::vec::Vec;

use super::triangles::{Input, Triangle};

/// No neighbour, no group.
pub(super) const NONE: u32 = u32::MAX;

/// The vertex of each corner of the triangles: the lowest corner of equal position, normal and texture coordinate.
pub(super) fn weld(input: &Input<'_>, triangles: &[Triangle]) -> Vec<[u32; 3]> {
    // One zero for both signs.
    let key = |k: u32| {
        let (p, n, t) = (input.position(k), input.normal(k), input.uv(k));
        [p.x, p.y, p.z, n.x, n.y, n.z, t.x, t.y].map(|c| (c + 0.0).to_bits())
    };
    // Equal corners have one position: corners are sorted by the position alone, and further only among equal ones.
    let places = input.mesh.welded();
    let corners = input.mesh.faces().corners();
    let place = |k: u32| places[corners[k as usize] as usize];
    let mut order: Vec<u32> = (0..corners.len() as u32).collect();
    order.sort_unstable_by_key(|&k| (place(k), k));
    let mut first = vec![0; corners.len()];
    for here in order.chunk_by_mut(|&a, &b| place(a) == place(b)) {
        here.sort_by_cached_key(|&k| (key(k), k));
        for equal in here.chunk_by(|&a, &b| key(a) == key(b)) {
            for &k in equal {
                first[k as usize] = equal[0];
            }
        }
    }
    triangles
        .iter()
        .map(|t| t.corners.map(|k| first[k as usize]))
        .collect()
}

/// The triangle across each edge: one that runs along it in the opposite direction. Of several the first that is free, in
/// order of the triangles.
pub(super) fn neighbours(vertices: &[[u32; 3]]) -> Vec<[u32; 3]> {
    let mut edges: Vec<(u32, u32, u32)> = Vec::with_capacity(vertices.len() * 3);
    for (f, v) in vertices.iter().enumerate() {
        for k in 0..3 {
            let (a, b) = (v[k], v[(k + 1) % 3]);
            edges.push((a.min(b), a.max(b), 3 * f as u32 + k as u32));
        }
    }
    edges.sort_unstable();
    let mut across = vec![[NONE; 3]; vertices.len()];
    for group in edges.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
        let split = |edge: u32| (edge as usize / 3, edge as usize % 3);
        let rises = |edge: u32| {
            let (f, k) = split(edge);
            vertices[f][k] == group[0].0
        };
        // The next candidates for edges that fall, and for those that rise: what is passed is never free again.
        let mut next = [0; 2];
        for (i, &(.., edge)) in group.iter().enumerate() {
            let (f, k) = split(edge);
            if across[f][k] != NONE {
                continue;
            }
            let up = rises(edge);
            let at = &mut next[usize::from(up)];
            *at = (*at).max(i + 1);
            while let Some(&(.., other)) = group.get(*at) {
                let (g, l) = split(other);
                *at += 1;
                if rises(other) != up && across[g][l] == NONE {
                    (across[f][k], across[g][l]) = (g as u32, f as u32);
                    break;
                }
            }
        }
    }
    across
}

/// Triangles around one vertex that are joined by edges and mapped with one orientation.
pub(super) struct Group {
    pub(super) vertex: u32,
    pub(super) upright: bool,
    /// The triangles, in the order in which they were met.
    pub(super) faces: Vec<u32>,
}

/// Groups around all vertices. A vague triangle takes the orientation of the first group that meets it.
pub(super) fn groups(
    triangles: &mut [Triangle],
    vertices: &[[u32; 3]],
    across: &[[u32; 3]],
) -> Vec<Group> {
    let mut of = vec![[NONE; 3]; triangles.len()];
    let mut groups: Vec<Group> = Vec::new();
    let mut open = Vec::new();
    for f in 0..triangles.len() {
        for i in 0..3 {
            if triangles[f].vague || of[f][i] != NONE {
                continue;
            }
            let id = groups.len() as u32;
            let (vertex, upright) = (vertices[f][i], triangles[f].upright);
            let mut faces = vec![f as u32];
            of[f][i] = id;
            // The edge before the corner is visited first, then the one after it.
            let around = |f: usize, i: usize| [across[f][i], across[f][(i + 2) % 3]];
            open.extend(around(f, i));
            while let Some(g) = open.pop() {
                let g = g as usize;
                let Some(j) = vertices
                    .get(g)
                    .and_then(|v| v.iter().position(|v| *v == vertex))
                else {
                    continue;
                };
                if of[g][j] != NONE {
                    continue;
                }
                if triangles[g].vague && of[g] == [NONE; 3] {
                    triangles[g].upright = upright;
                }
                if triangles[g].upright != upright {
                    continue;
                }
                of[g][j] = id;
                faces.push(g as u32);
                open.extend(around(g, j));
            }
            groups.push(Group {
                vertex,
                upright,
                faces,
            });
        }
    }
    groups
}

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
    let count = input.mesh.positions().len();
    let mut order = by_key(0..corners.len() as u32, count, place);
    let mut first = vec![0; corners.len()];
    for here in order.chunk_by_mut(|&a, &b| place(a) == place(b)) {
        if here.iter().all(|&k| key(k) == key(here[0])) {
            here.iter().for_each(|&k| first[k as usize] = here[0]);
            continue;
        }
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
    // Edges by their lower vertex, then by the other one; the order of the triangles is kept.
    let count = vertices
        .iter()
        .flatten()
        .max()
        .map_or(0, |v| *v as usize + 1);
    let ends = |edge: u32| {
        let (v, k) = (vertices[edge as usize / 3], edge as usize % 3);
        let (a, b) = (v[k], v[(k + 1) % 3]);
        (a.min(b), a.max(b))
    };
    let mut edges = by_key(0..3 * vertices.len() as u32, count, |edge| ends(edge).0);
    for from in edges.chunk_by_mut(|&a, &b| ends(a).0 == ends(b).0) {
        from.sort_unstable_by_key(|&edge| (ends(edge).1, edge));
    }
    let mut across = vec![[NONE; 3]; vertices.len()];
    for group in edges.chunk_by(|&a, &b| ends(a) == ends(b)) {
        let split = |edge: u32| (edge as usize / 3, edge as usize % 3);
        let rises = |edge: u32| {
            let (f, k) = split(edge);
            vertices[f][k] == ends(group[0]).0
        };
        // The next candidates for edges that fall, and for those that rise: what is passed is never free again.
        let mut next = [0; 2];
        for (i, &edge) in group.iter().enumerate() {
            let (f, k) = split(edge);
            if across[f][k] != NONE {
                continue;
            }
            let up = rises(edge);
            let at = &mut next[usize::from(up)];
            *at = (*at).max(i + 1);
            while let Some(&other) = group.get(*at) {
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

/// Items in the order of their keys, which are below `count`, and in their own order where keys are equal.
fn by_key(items: core::ops::Range<u32>, count: usize, key: impl Fn(u32) -> u32) -> Vec<u32> {
    let mut ends = vec![0_u32; count];
    items.clone().for_each(|item| ends[key(item) as usize] += 1);
    let mut sum = 0;
    for end in &mut ends {
        (*end, sum) = (sum, sum + *end);
    }
    let mut out = vec![0; items.len()];
    for item in items {
        let end = &mut ends[key(item) as usize];
        out[*end as usize] = item;
        *end += 1;
    }
    out
}

/// Triangles around one vertex that are joined by edges and mapped with one orientation.
pub(super) struct Group {
    pub(super) vertex: u32,
    /// Place of its first triangle in [`Groups::faces`]; its last one lies before the first of the next group.
    first: u32,
}

/// Groups around all vertices.
#[derive(Default)]
pub(super) struct Groups {
    pub(super) all: Vec<Group>,
    /// The triangles of each group, in the order in which they were met.
    faces: Vec<u32>,
    /// The place in `faces` of each corner of the triangles; [`NONE`] for corners that belong to no group.
    pub(super) places: Vec<[u32; 3]>,
}

impl Groups {
    pub(super) fn faces(&self, group: usize) -> &[u32] {
        let next = self.all.get(group + 1);
        let end = next.map_or(self.faces.len(), |next| next.first as usize);
        &self.faces[self.all[group].first as usize..end]
    }

    /// Adds a corner of a triangle to the last group.
    fn add(&mut self, triangle: usize, corner: usize) {
        self.places[triangle][corner] = self.faces.len() as u32;
        self.faces.push(triangle as u32);
    }
}

/// Groups around all vertices. A vague triangle takes the orientation of the first group that meets it.
pub(super) fn groups(
    triangles: &mut [Triangle],
    vertices: &[[u32; 3]],
    across: &[[u32; 3]],
) -> Groups {
    let mut groups = Groups {
        places: vec![[NONE; 3]; triangles.len()],
        ..Groups::default()
    };
    let mut open = Vec::new();
    for f in 0..triangles.len() {
        for i in 0..3 {
            if triangles[f].vague || groups.places[f][i] != NONE {
                continue;
            }
            let (vertex, upright) = (vertices[f][i], triangles[f].upright);
            groups.all.push(Group {
                vertex,
                first: groups.faces.len() as u32,
            });
            groups.add(f, i);
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
                if groups.places[g][j] != NONE {
                    continue;
                }
                if triangles[g].vague && groups.places[g] == [NONE; 3] {
                    triangles[g].upright = upright;
                }
                if triangles[g].upright != upright {
                    continue;
                }
                groups.add(g, j);
                open.extend(around(g, j));
            }
        }
    }
    groups
}

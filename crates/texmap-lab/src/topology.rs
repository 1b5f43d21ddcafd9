//! Open edges of a mesh, counted by the positions of its corners.

use std::collections::BTreeMap;

use texmap_scene::Mesh;

/// Edges, by the bits of their ends (both zeros alike), at which not exactly two triangles lie. Over all meshes together. Triangles with
/// two corners at one position cover nothing and do not count.
pub fn open_edges<'a>(meshes: impl IntoIterator<Item = &'a Mesh>) -> usize {
    let mut edges: BTreeMap<[[u32; 3]; 2], u32> = BTreeMap::new();
    for mesh in meshes {
        let at = |v: u32| mesh.positions[v as usize].map(|c| (c + 0.0).to_bits());
        for t in &mesh.triangles {
            let [a, b, c] = t.map(at);
            if a == b || b == c || c == a {
                continue;
            }
            for mut ends in [[a, b], [b, c], [c, a]] {
                ends.sort_unstable();
                *edges.entry(ends).or_default() += 1;
            }
        }
    }
    edges.values().filter(|count| **count != 2).count()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_square_has_four_and_a_tetrahedron_none() {
        let mut mesh = Mesh {
            positions: vec![
                [0.0; 3],
                [1.0, 0.0, 0.0],
                [1.0, 1.0, 0.0],
                [0.0, 1.0, 0.0],
                [-0.0, 0.0, 1.0],
            ],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            ..Mesh::default()
        };
        assert_eq!(open_edges([&mesh]), 4);
        mesh.triangles = vec![[0, 1, 2], [0, 1, 4], [1, 2, 4], [2, 0, 4]];
        assert_eq!(open_edges([&mesh]), 0);
        // The same corner as a vertex of its own, and a triangle that is a line.
        mesh.positions.push([0.0, -0.0, 0.0]);
        mesh.triangles[3] = [2, 5, 4];
        mesh.triangles.push([0, 5, 4]);
        assert_eq!(open_edges([&mesh]), 0);
    }
}

//! Texture coordinates of a mesh, and its vertex buffer.

use alloc::vec;
use alloc::vec::Vec;

use crate::{Mesh, UvError};

/// Texture coordinates of a mesh, indexed per corner like the `vt` of an OBJ.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct UvSet {
    /// The coordinates.
    pub uvs: Vec<[f32; 2]>,
    /// For each corner of the faces, in order, an index into `uvs`.
    pub corners: Vec<u32>,
}

impl UvSet {
    /// Shares equal coordinates among the corners of a position (and of positions equal to it). A vertex is split
    /// only where its corners differ.
    ///
    /// # Panics
    /// Never for a `values` of one entry per corner, which every caller in this crate makes.
    pub(crate) fn shared(mesh: &Mesh<'_>, values: &[[f32; 2]]) -> Self {
        const NONE: u32 = u32::MAX;
        // Longest chain; a pole of very many faces has its further coordinates in a tree.
        const CHAIN: usize = 32;
        let welded = mesh.welded();
        // For each position a chain of the coordinates it has so far.
        let mut head = vec![NONE; mesh.positions.len()];
        let mut next: Vec<u32> = Vec::new();
        let mut further = alloc::collections::BTreeMap::new();
        let mut set = Self {
            uvs: Vec::new(),
            corners: Vec::with_capacity(values.len()),
        };
        for (&position, value) in mesh.faces.corners().iter().zip(values) {
            let position = welded[position as usize];
            let bits = value.map(f32::to_bits);
            let (mut at, mut steps) = (head[position as usize], 0);
            while at != NONE && set.uvs[at as usize].map(f32::to_bits) != bits {
                at = next[at as usize];
                steps += 1;
            }
            let mut append = |after: u32| {
                set.uvs.push(*value);
                next.push(after);
                set.uvs.len() as u32 - 1
            };
            if at == NONE && steps < CHAIN {
                at = append(head[position as usize]);
                head[position as usize] = at;
            } else if at == NONE {
                at = *further
                    .entry((position, bits))
                    .or_insert_with(|| append(NONE));
            }
            set.corners.push(at);
        }
        set
    }

    /// Checks that the set fits the mesh.
    ///
    /// # Errors
    /// A wrong number of corners, an index without a coordinate, a coordinate that is not finite.
    pub fn check(&self, mesh: &Mesh<'_>) -> Result<(), UvError> {
        let expected = mesh.faces.corners().len();
        if self.corners.len() != expected {
            return Err(UvError::WrongLength {
                what: "the list of texture corners",
                found: self.corners.len(),
                expected,
            });
        }
        for face in 0..mesh.faces.len() {
            for &index in &self.corners[mesh.faces.range(face)] {
                match self.uvs.get(index as usize) {
                    None => {
                        return Err(UvError::BadIndex {
                            face,
                            index,
                            count: self.uvs.len(),
                        });
                    }
                    Some(uv) if !uv.iter().all(|c| c.is_finite()) => {
                        return Err(UvError::NotFinite { face, index });
                    }
                    Some(_) => {}
                }
            }
        }
        Ok(())
    }

    /// The coordinate of a corner.
    #[must_use]
    pub fn at(&self, corner: usize) -> [f32; 2] {
        self.uvs[self.corners[corner] as usize]
    }

    /// The coordinates of all corners in order.
    #[must_use]
    pub fn per_corner(&self) -> Vec<[f32; 2]> {
        self.corners.iter().map(|&i| self.uvs[i as usize]).collect()
    }
}

/// Vertices with one index for all of their attributes, as a graphics API or a file of triangles wants them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct VertexBuffer {
    /// For each vertex the position of the mesh that it is.
    pub positions: Vec<u32>,
    /// For each vertex its coordinates.
    pub uvs: Vec<[f32; 2]>,
    /// For each vertex its tangent; empty if none were given.
    pub tangents: Vec<[f32; 4]>,
    /// The faces as fans, three vertices each.
    pub indices: Vec<[u32; 3]>,
}

impl UvSet {
    /// Splits the positions of the mesh where coordinates or tangents of its corners differ. Nothing else is split. Vertices
    /// stand in the order in which the corners first need them. `tangents` has one entry per corner, or none.
    ///
    /// # Errors
    /// A set or tangents that do not fit the mesh.
    pub fn split(&self, mesh: &Mesh<'_>, tangents: &[[f32; 4]]) -> Result<VertexBuffer, UvError> {
        self.check(mesh)?;
        if !tangents.is_empty() && tangents.len() != self.corners.len() {
            return Err(UvError::WrongLength {
                what: "the list of tangents",
                found: tangents.len(),
                expected: self.corners.len(),
            });
        }
        let mut out = VertexBuffer::default();
        let mut known = alloc::collections::BTreeMap::new();
        let mut vertices = Vec::with_capacity(self.corners.len());
        for (corner, &position) in mesh.faces.corners().iter().enumerate() {
            let (uv, tangent) = (self.at(corner), tangents.get(corner));
            let key = (
                position,
                uv.map(f32::to_bits),
                tangent.map(|t| t.map(f32::to_bits)),
            );
            let vertex = *known.entry(key).or_insert_with(|| {
                out.positions.push(position);
                out.uvs.push(uv);
                out.tangents.extend(tangent);
                out.positions.len() as u32 - 1
            });
            vertices.push(vertex);
        }
        let triangles = mesh.faces.triangles();
        out.indices = triangles
            .map(|(_, corners)| corners.map(|k| vertices[k]))
            .collect();
        Ok(out)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Faces;
    use core::ops::Range;

    /// A cube's corner has one position and three coordinates. A vertex buffer has 24 vertices, and no more.
    #[test]
    fn vertices_split_where_corners_differ() {
        let positions: Vec<[f32; 3]> = (0..8)
            .map(|i| [i & 1, i >> 1 & 1, i >> 2].map(|c| c as f32))
            .collect();
        let mut faces = Faces::new();
        for face in [
            [0, 1, 3, 2],
            [5, 4, 6, 7],
            [4, 0, 2, 6],
            [1, 5, 7, 3],
            [2, 3, 7, 6],
            [4, 5, 1, 0],
        ] {
            faces.push(&face);
        }
        let mesh = Mesh::new(&positions, &faces).unwrap();
        let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let squares = |face: usize| square.map(|[u, v]| [u + 2.0 * face as f32, v]);
        let own: Vec<[f32; 2]> = (0..6).flat_map(squares).collect();
        let split = UvSet::shared(&mesh, &own).split(&mesh, &[]).unwrap();
        assert_eq!((split.positions.len(), split.indices.len()), (24, 12));
        for (triangle, (_, corners)) in split.indices.iter().zip(faces.triangles()) {
            for (vertex, k) in triangle.iter().zip(corners) {
                let vertex = *vertex as usize;
                assert_eq!(split.positions[vertex], faces.corners()[k]);
                assert_eq!(split.uvs[vertex], own[k]);
            }
        }
        // One coordinate for all: nothing to split but where tangents say so.
        let one = UvSet::shared(&mesh, &[[0.5; 2]; 24]);
        assert_eq!(one.split(&mesh, &[]).unwrap().positions.len(), 8);
        let mut tangents = vec![[1.0, 0.0, 0.0, 1.0]; 24];
        tangents[4][3] = -1.0;
        let split = one.split(&mesh, &tangents).unwrap();
        assert_eq!((split.positions.len(), split.tangents.len()), (9, 9));
        assert!(one.split(&mesh, &tangents[1..]).is_err());
    }

    #[test]
    fn corners_share_what_is_equal_and_split_what_is_not() {
        let positions = [[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
        let faces = Faces::from_triangles(&[[0, 1, 2], [0, 2, 3]]);
        let mesh = Mesh::new(&positions, &faces).unwrap();
        let values = [
            [0.0, 0.0],
            [1.0, 0.0],
            [1.0, 1.0],
            [0.0, 0.0],
            [2.0, 1.0],
            [0.0, 1.0],
        ];
        let set = UvSet::shared(&mesh, &values);
        assert_eq!(set.uvs.len(), 5);
        assert_eq!(set.corners, [0, 1, 2, 0, 3, 4]);
        assert_eq!(set.per_corner(), values);
    }

    /// A vertex with a coordinate of its own in each of many faces, in pairs. Equal ones are shared on either side of the
    /// longest chain.
    #[test]
    fn a_pole_of_many_coordinates_shares_equal_ones() {
        let positions = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let faces = Faces::from_triangles(&[[0, 1, 2]; 200]);
        let mesh = Mesh::new(&positions, &faces).unwrap();
        let values: Vec<[f32; 2]> = (0..200)
            .flat_map(|i| [[(i % 100) as f32, 0.5], [0.0; 2], [1.0; 2]])
            .collect();
        let set = UvSet::shared(&mesh, &values);
        assert_eq!(set.per_corner(), values);
        assert_eq!(set.uvs.len(), 102);
        let poles =
            |faces: Range<usize>| -> Vec<u32> { faces.map(|f| set.corners[3 * f]).collect() };
        assert_eq!(poles(0..100), poles(100..200));
    }
}

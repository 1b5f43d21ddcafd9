//! Cutting the picture along edges of the mesh, and sewing it together again.

use alloc::vec;
use alloc::vec::Vec;
use texmap_math::deterministic_f64;
use texmap_math::glam::DVec2;

use crate::islands::{Islands, compact, root, separate};
use crate::mesh::{Mesh, length};
use crate::topology::{MANY, Topology};
use crate::uv_set::UvSet;
use crate::{UvError, parallel};

/// Edges to cut along: pairs of positions, and all edges whose faces meet at a larger angle.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SeamEdges<'a> {
    /// Pairs of indices of positions.
    pub pairs: &'a [[u32; 2]],
    /// Cut where the normals of two faces differ by more than this, radians in (0, pi).
    pub angle: Option<f64>,
}

impl SeamEdges<'_> {
    /// For every corner whether its edge is cut.
    pub(crate) fn marks(&self, mesh: &Mesh<'_>, topology: &Topology) -> Result<Vec<bool>, UvError> {
        let mut marks = edges_named(mesh, topology, self.pairs)?;
        let Some(angle) = self.angle else {
            return Ok(marks);
        };
        if !(angle > 0.0 && angle < core::f64::consts::PI) {
            return Err(UvError::BadParameter {
                what: "cut angle",
                value: angle,
            });
        }
        let least = deterministic_f64::cos(angle);
        let normals = parallel::collect_chunks(mesh.faces().len(), |range| {
            range.map(|f| mesh.face_normal(f)).collect()
        });
        for (k, mark) in marks
            .iter_mut()
            .enumerate()
            .filter(|(k, _)| topology.twin[*k] < MANY)
        {
            let [a, b] = [k, topology.twin[k] as usize].map(|k| normals[topology.face[k] as usize]);
            // Without dividing: a face without area cuts nothing.
            let (dot, size) = (a.dot(b), length(a) * length(b));
            *mark |= size > 0.0 && dot < least * size;
        }
        Ok(marks)
    }
}

/// For every corner whether its edge is among `pairs`.
fn edges_named(
    mesh: &Mesh<'_>,
    topology: &Topology,
    pairs: &[[u32; 2]],
) -> Result<Vec<bool>, UvError> {
    let count = mesh.positions().len();
    let mut wanted = alloc::collections::BTreeMap::new();
    for &[a, b] in pairs {
        if let Some(&index) = [a, b].iter().find(|i| **i as usize >= count) {
            return Err(UvError::NotAnEdge {
                a,
                b: if index == a { b } else { index },
            });
        }
        let [a2, b2] = [a, b].map(|i| topology.welded[i as usize]);
        wanted.insert((a2.min(b2), a2.max(b2)), ([a, b], false));
    }
    let marks = (0..topology.next.len()).map(|k| {
        let [a, b] = [k, topology.next[k] as usize]
            .map(|k| topology.welded[mesh.faces().corners()[k] as usize]);
        wanted
            .get_mut(&(a.min(b), a.max(b)))
            .is_some_and(|(_, found)| {
                *found = true;
                true
            })
    });
    let marks: Vec<bool> = marks.collect();
    match wanted.values().find(|(_, found)| !found) {
        Some(([a, b], _)) => Err(UvError::NotAnEdge { a: *a, b: *b }),
        None => Ok(marks),
    }
}

/// Splits the coordinates along the cuts. Nothing moves: pack afterwards to part the pieces.
///
/// # Errors
/// A pair that is no edge, an angle out of range, a set that does not fit the mesh.
pub fn cut_seams(mesh: &Mesh<'_>, set: &UvSet, cuts: &SeamEdges<'_>) -> Result<UvSet, UvError> {
    set.check(mesh)?;
    let topology = Topology::new(mesh);
    let marks = cuts.marks(mesh, &topology)?;
    // Corners around a vertex stay together across uncut edges.
    let mut parent: Vec<u32> = (0..set.corners.len() as u32).collect();
    for k in (0..set.corners.len()).filter(|&k| !marks[k] && topology.joined(mesh, set, k)) {
        let Some(there) = topology.across(mesh, k) else {
            continue;
        };
        for (a, b) in [k, topology.next[k] as usize].into_iter().zip(there) {
            let (a, b) = (root(&mut parent, a as u32), root(&mut parent, b as u32));
            parent[a.max(b) as usize] = a.min(b);
        }
    }
    let mut out = UvSet {
        uvs: Vec::new(),
        corners: vec![0; set.corners.len()],
    };
    for k in 0..set.corners.len() {
        let r = root(&mut parent, k as u32) as usize;
        out.corners[k] = if r == k {
            out.uvs.push(set.at(k));
            out.uvs.len() as u32 - 1
        } else {
            out.corners[r]
        };
    }
    Ok(out)
}

/// Joins the picture across edges, in order: of two islands the smaller one (fewer faces) is moved, turned and scaled so that the
/// edge fits; within one island both sides take the mean. At most n log n steps for n corners and edges.
///
/// # Errors
/// A pair that is no edge between two faces, an edge without length in the picture.
pub fn sew_seams(mesh: &Mesh<'_>, set: &UvSet, pairs: &[[u32; 2]]) -> Result<UvSet, UvError> {
    set.check(mesh)?;
    let topology = Topology::new(mesh);
    let edges = shared_edges(mesh, &topology, pairs)?;
    let mut set = set.clone();
    let islands = Islands::new(mesh, &set, &topology);
    separate(&topology, &islands, &mut set);
    let mut sewing = Sewing::new(&set, islands);
    for (k, there) in edges {
        let here = [k, topology.next[k] as usize];
        let [one, two] = [here[0], there[0]].map(|k| sewing.island[topology.face[k] as usize]);
        if one != two {
            let size = |island: u32| sewing.faces[island as usize].len();
            if size(one) >= size(two) {
                sewing.fit(mesh, there, here, [two, one])?;
            } else {
                sewing.fit(mesh, here, there, [one, two])?;
            }
        }
        for (keep, merge) in here.into_iter().zip(there) {
            sewing.merge(keep, merge);
        }
    }
    let Sewing {
        mut parent, uvs, ..
    } = sewing;
    for index in &mut set.corners {
        *index = root(&mut parent, *index);
    }
    set.uvs = uvs;
    Ok(compact(&set))
}

/// For each pair the first corner whose edge it is and which has a neighbour, and the neighbour's corners at its ends.
fn shared_edges(
    mesh: &Mesh<'_>,
    topology: &Topology,
    pairs: &[[u32; 2]],
) -> Result<Vec<(usize, [usize; 2])>, UvError> {
    let marks = edges_named(mesh, topology, pairs)?;
    let mut known = alloc::collections::BTreeMap::new();
    for k in (0..marks.len()).filter(|&k| marks[k]) {
        if let Some(there) = topology.across(mesh, k) {
            known.entry(topology.ends(mesh, k)).or_insert((k, there));
        }
    }
    pairs
        .iter()
        .map(|&[a, b]| {
            let [low, high] = [a, b].map(|i| topology.welded[i as usize]);
            known
                .get(&[low.min(high), low.max(high)])
                .copied()
                .ok_or(UvError::NotAnEdge { a, b })
        })
        .collect()
}

/// Islands and coordinates while edges are sewn. The smaller island moves, so that a face moves log n times at most.
struct Sewing<'a> {
    corners: &'a [u32],
    uvs: Vec<[f32; 2]>,
    /// Coordinates that have become one are a tree.
    parent: Vec<u32>,
    /// Island of each face, and the faces of each island.
    island: Vec<u32>,
    faces: Vec<Vec<u32>>,
    /// The last move of each coordinate.
    moved: Vec<u32>,
    moves: u32,
}

impl<'a> Sewing<'a> {
    fn new(set: &'a UvSet, islands: Islands) -> Self {
        let mut faces = vec![Vec::new(); islands.count];
        for (face, island) in islands.of_face.iter().enumerate() {
            faces[*island as usize].push(face as u32);
        }
        Self {
            corners: &set.corners,
            uvs: set.uvs.clone(),
            parent: (0..set.uvs.len() as u32).collect(),
            island: islands.of_face,
            faces,
            moved: vec![0; set.uvs.len()],
            moves: 0,
        }
    }

    fn index(&mut self, corner: usize) -> usize {
        root(&mut self.parent, self.corners[corner]) as usize
    }

    fn at(&mut self, corner: usize) -> DVec2 {
        let index = self.index(corner);
        DVec2::from(self.uvs[index].map(f64::from))
    }

    /// Moves an island, by a similarity, so that the edge between the corners `moved` comes to lie on `still`. The island then
    /// becomes part of the other one.
    fn fit(
        &mut self,
        mesh: &Mesh<'_>,
        moved: [usize; 2],
        still: [usize; 2],
        [island, other]: [u32; 2],
    ) -> Result<(), UvError> {
        let ([pivot, p], [target, q]) = (moved.map(|k| self.at(k)), still.map(|k| self.at(k)));
        let (from, to) = (p - pivot, q - target);
        let squared = from.dot(from);
        if squared == 0.0 || to == DVec2::ZERO {
            return Err(UvError::BadParameter {
                what: "length of a sewn edge in the picture",
                value: 0.0,
            });
        }
        // The similarity as one complex factor.
        let factor = DVec2::new(from.dot(to), from.perp_dot(to)) / squared;
        self.moves += 1;
        let faces = core::mem::take(&mut self.faces[island as usize]);
        for &face in &faces {
            self.island[face as usize] = other;
            for k in mesh.faces().range(face as usize) {
                let index = self.index(k);
                if core::mem::replace(&mut self.moved[index], self.moves) != self.moves {
                    let d = DVec2::from(self.uvs[index].map(f64::from)) - pivot;
                    let p = target
                        + DVec2::new(
                            factor.x * d.x - factor.y * d.y,
                            factor.x * d.y + factor.y * d.x,
                        );
                    self.uvs[index] = [p.x as f32, p.y as f32];
                }
            }
        }
        self.faces[other as usize].extend(faces);
        Ok(())
    }

    /// Makes the coordinates of two corners one, their mean.
    fn merge(&mut self, keep: usize, merge: usize) {
        let (keep, merge) = (self.index(keep), self.index(merge));
        let (p, q) = (self.uvs[keep], self.uvs[merge]);
        self.uvs[keep] =
            core::array::from_fn(|i| ((f64::from(p[i]) + f64::from(q[i])) * 0.5) as f32);
        self.parent[merge] = keep as u32;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Faces;
    use crate::topology::tests::flat;

    /// Two squares side by side, sharing the edge 1-2.
    const PAIR: [[f32; 3]; 6] = [
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [1.0, 1.0, 0.0],
        [0.0, 1.0, 0.0],
        [2.0, 0.0, 0.0],
        [2.0, 1.0, 0.0],
    ];

    fn pair() -> Faces {
        let mut faces = Faces::new();
        faces.push(&[0, 1, 2, 3]);
        faces.push(&[1, 4, 5, 2]);
        faces
    }

    #[test]
    fn a_cut_parts_shells_and_sewing_joins_them() {
        let faces = pair();
        let mesh = Mesh::new(&PAIR, &faces).unwrap();
        let set = flat(&mesh);
        let topology = Topology::new(&mesh);
        assert_eq!(Islands::new(&mesh, &set, &topology).count, 1);
        let mut parted = cut_seams(
            &mesh,
            &set,
            &SeamEdges {
                pairs: &[[2, 1]],
                angle: None,
            },
        )
        .unwrap();
        assert_eq!(Islands::new(&mesh, &parted, &topology).count, 2);
        assert_eq!(parted.uvs.len(), 8);
        // Turn and shrink the second square, then sew it on again.
        for i in 4..8 {
            let [u, v] = parted.uvs[i];
            parted.uvs[i] = [-0.5 * v + 3.0, 0.5 * u];
        }
        let sewn = sew_seams(&mesh, &parted, &[[1, 2]]).unwrap();
        assert_eq!(Islands::new(&mesh, &sewn, &topology).count, 1);
        for (k, uv) in sewn.per_corner().iter().enumerate() {
            let p = mesh.point(k);
            assert!(
                (f64::from(uv[0]) - p.x).abs() < 1e-6 && (f64::from(uv[1]) - p.y).abs() < 1e-6,
                "{uv:?} {p}"
            );
        }
    }

    #[test]
    fn what_is_no_edge_is_named() {
        let faces = pair();
        let mesh = Mesh::new(&PAIR, &faces).unwrap();
        let set = flat(&mesh);
        let cut_at = |pairs: &[[u32; 2]]| cut_seams(&mesh, &set, &SeamEdges { pairs, angle: None });
        assert_eq!(cut_at(&[[0, 2]]), Err(UvError::NotAnEdge { a: 0, b: 2 }));
        assert_eq!(cut_at(&[[0, 99]]), Err(UvError::NotAnEdge { a: 0, b: 99 }));
        // The rim cannot be sewn.
        assert_eq!(
            sew_seams(&mesh, &set, &[[0, 1]]),
            Err(UvError::NotAnEdge { a: 0, b: 1 })
        );
    }
}

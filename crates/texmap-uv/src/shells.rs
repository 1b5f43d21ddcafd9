//! Which faces hang together: edges in space and in the picture, shells, cutting and sewing.

use alloc::vec;
use alloc::vec::Vec;
use texmap_math::det;
use texmap_math::glam::{DVec2, DVec3};

use crate::mesh::{Faces, Mesh, UvSet, length};
use crate::{UvError, parallel};

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
        let mut twin = vec![RIM; count];
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
                        link(faces, &face, &next, edges, &mut twin);
                    }
                }
            }
        }
        Self {
            welded,
            face,
            next,
            twin,
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

    /// The places of both ends of the edge of `k`, the lower one first.
    pub(crate) fn ends(&self, mesh: &Mesh<'_>, k: usize) -> [u32; 2] {
        let [a, b] =
            [k, self.next[k] as usize].map(|k| self.welded[mesh.faces().corners()[k] as usize]);
        [a.min(b), a.max(b)]
    }

    /// One corner for all corners that are twins of one another over faces without area: the lower one of the two
    /// faces at the ends of the chain.
    pub(crate) fn name(&self, mesh: &Mesh<'_>, k: usize) -> usize {
        let ends = self.ends(mesh, k);
        let last = |mut k: usize| {
            // Very long chains may have several names.
            for _ in 0..64 {
                let other = mesh
                    .faces()
                    .range(self.face[k] as usize)
                    .find(|&o| o != k && self.ends(mesh, o) == ends);
                let Some(other) = other else { break };
                if self.twin[other] >= MANY {
                    return other;
                }
                k = self.twin[other] as usize;
            }
            k
        };
        last(k).min(last(self.twin[k] as usize))
    }

    /// Whether the picture goes on across the edge of `k`: both ends use the same texture coordinates.
    pub(crate) fn joined(&self, mesh: &Mesh<'_>, set: &UvSet, k: usize) -> bool {
        let here = [k, self.next[k] as usize].map(|c| set.corners[c]);
        self.across(mesh, k)
            .is_some_and(|there| there.map(|c| set.corners[c]) == here)
    }
}

/// Twins on an edge that is not simply that of two faces, its corners in ascending order.
///
/// A face that runs along the edge and back (two of its corners lie in one place, as in the fans of quads at a pole)
/// has no area there: it stands between its neighbours like a bridge. Beside such faces two may meet, as on any edge.
fn link(faces: &Faces, face: &[u32], next: &[u32], edges: Vec<u32>, twin: &mut [u32]) {
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
        return;
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
    let mut solid = solid.into_iter();
    bridges.reverse();
    let Some(mut from) = solid.next().or_else(|| bridges.pop().map(|[_, out]| out)) else {
        return;
    };
    let mut join = |a: u32, b: u32| (twin[a as usize], twin[b as usize]) = (b, a);
    while !bridges.is_empty() {
        // Among a few: very many faces without area may lie on one edge.
        let near = bridges.len().saturating_sub(16)..bridges.len();
        let choices = near.flat_map(|i| [(i, 1), (i, 0)]);
        let best = choices.max_by_key(|&(i, end)| fit(from, bridges[i][end]));
        let Some((i, end)) = best else { return };
        let bridge = bridges.remove(i);
        join(from, bridge[end]);
        from = bridge[1 - end];
    }
    if let Some(last) = solid.next() {
        join(from, last);
    }
}

/// Faces grouped into connected pieces of the picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Shells {
    /// Shell of each face; shells are numbered by their lowest face.
    pub(crate) of_face: Vec<u32>,
    pub(crate) count: usize,
}

impl Shells {
    pub(crate) fn new(mesh: &Mesh<'_>, set: &UvSet, topology: &Topology) -> Self {
        Self::linked(mesh.faces().len(), topology, |k| {
            topology.joined(mesh, set, k)
        })
    }

    /// Groups faces over the edges for which `link` holds.
    pub(crate) fn linked(
        faces: usize,
        topology: &Topology,
        link: impl Fn(usize) -> bool + Sync + Send,
    ) -> Self {
        let links = parallel::collect_chunks(topology.twin.len(), |range| {
            let pairs = range
                .filter(|&k| topology.twin[k] < MANY && (k as u32) < topology.twin[k] && link(k));
            pairs
                .map(|k| [topology.face[k], topology.face[topology.twin[k] as usize]])
                .collect()
        });
        let mut parent: Vec<u32> = (0..faces as u32).collect();
        for [a, b] in links {
            let (a, b) = (root(&mut parent, a), root(&mut parent, b));
            // The lower face leads, so numbers do not depend on the order.
            parent[a.max(b) as usize] = a.min(b);
        }
        let (mut of_face, mut count) = (vec![0; faces], 0);
        for f in 0..faces {
            let r = root(&mut parent, f as u32) as usize;
            of_face[f] = if r == f {
                count += 1;
                count - 1
            } else {
                of_face[r]
            };
        }
        Self {
            of_face,
            count: count as usize,
        }
    }
}

fn root(parent: &mut [u32], mut f: u32) -> u32 {
    while parent[f as usize] != f {
        parent[f as usize] = parent[parent[f as usize] as usize];
        f = parent[f as usize];
    }
    f
}

/// Gives every shell its own coordinates where two shells share one (they touch in a point).
pub(crate) fn separate(topology: &Topology, shells: &Shells, set: &mut UvSet) {
    let mut owner = vec![RIM; set.uvs.len()];
    let mut copies = alloc::collections::BTreeMap::new();
    for k in 0..set.corners.len() {
        let (shell, index) = (shells.of_face[topology.face[k] as usize], set.corners[k]);
        if owner[index as usize] == RIM {
            owner[index as usize] = shell;
        } else if owner[index as usize] != shell {
            set.corners[k] = *copies.entry((shell, index)).or_insert_with(|| {
                set.uvs.push(set.uvs[index as usize]);
                set.uvs.len() as u32 - 1
            });
        }
    }
}

/// Edges to cut along: pairs of positions, and all edges whose faces meet at a larger angle.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Cuts<'a> {
    /// Pairs of indices of positions.
    pub pairs: &'a [[u32; 2]],
    /// Cut where the normals of two faces differ by more than this, radians in (0, pi).
    pub angle: Option<f64>,
}

impl Cuts<'_> {
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
        let least = det::cos(angle);
        for (k, mark) in marks
            .iter_mut()
            .enumerate()
            .filter(|(k, _)| topology.twin[*k] < MANY)
        {
            let [a, b] =
                [k, topology.twin[k] as usize].map(|k| mesh.face_normal(topology.face[k] as usize));
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
pub fn cut(mesh: &Mesh<'_>, set: &UvSet, cuts: &Cuts<'_>) -> Result<UvSet, UvError> {
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

/// Joins the picture across edges, in order: of two shells the smaller one (fewer faces) is moved, turned and scaled
/// so that the edge fits; within one shell both sides take the mean.
///
/// # Errors
/// A pair that is no edge between two faces, an edge without length in the picture.
pub fn sew(mesh: &Mesh<'_>, set: &UvSet, pairs: &[[u32; 2]]) -> Result<UvSet, UvError> {
    set.check(mesh)?;
    let topology = Topology::new(mesh);
    let mut set = set.clone();
    for &[a, b] in pairs {
        let marks = edges_named(mesh, &topology, &[[a, b]])?;
        let edge = (0..marks.len())
            .filter(|&k| marks[k])
            .find_map(|k| topology.across(mesh, k).map(|there| (k, there)));
        let Some((k, there)) = edge else {
            return Err(UvError::NotAnEdge { a, b });
        };
        let here = [k, topology.next[k] as usize];
        let shells = Shells::new(mesh, &set, &topology);
        separate(&topology, &shells, &mut set);
        let [one, two] = [here[0], there[0]].map(|k| shells.of_face[topology.face[k] as usize]);
        if one != two {
            let size = |shell: u32| shells.of_face.iter().filter(|s| **s == shell).count();
            let (still, moved, shell) = if size(one) >= size(two) {
                (here, there, two)
            } else {
                (there, here, one)
            };
            let at = |k: usize| DVec2::from(set.at(k).map(f64::from));
            let (from, to) = (at(moved[1]) - at(moved[0]), at(still[1]) - at(still[0]));
            let squared = from.dot(from);
            if squared == 0.0 || to == DVec2::ZERO {
                return Err(UvError::BadParameter {
                    what: "length of a sewn edge in the picture",
                    value: 0.0,
                });
            }
            // The similarity as one complex factor.
            let factor = DVec2::new(from.dot(to), from.perp_dot(to)) / squared;
            let (pivot, target) = (at(moved[0]), at(still[0]));
            let mut done = vec![false; set.uvs.len()];
            for c in (0..set.corners.len())
                .filter(|&c| shells.of_face[topology.face[c] as usize] == shell)
            {
                let index = set.corners[c] as usize;
                if !core::mem::replace(&mut done[index], true) {
                    let d = DVec2::from(set.uvs[index].map(f64::from)) - pivot;
                    let p = target
                        + DVec2::new(
                            factor.x * d.x - factor.y * d.y,
                            factor.x * d.y + factor.y * d.x,
                        );
                    set.uvs[index] = [p.x as f32, p.y as f32];
                }
            }
        }
        for (keep, merge) in here.into_iter().zip(there) {
            let (keep, merge) = (set.corners[keep], set.corners[merge]);
            let (p, q) = (set.uvs[keep as usize], set.uvs[merge as usize]);
            set.uvs[keep as usize] =
                core::array::from_fn(|i| ((f64::from(p[i]) + f64::from(q[i])) * 0.5) as f32);
            set.corners
                .iter_mut()
                .filter(|c| **c == merge)
                .for_each(|c| *c = keep);
        }
    }
    Ok(compact(&set))
}

/// Drops coordinates that no corner uses.
pub(crate) fn compact(set: &UvSet) -> UvSet {
    let mut place = vec![RIM; set.uvs.len()];
    let mut out = UvSet {
        uvs: Vec::new(),
        corners: Vec::with_capacity(set.corners.len()),
    };
    for &index in &set.corners {
        let slot = &mut place[index as usize];
        if *slot == RIM {
            *slot = out.uvs.len() as u32;
            out.uvs.push(set.uvs[index as usize]);
        }
        out.corners.push(*slot);
    }
    out
}

/// Length in space of the edge of corner `k`.
pub(crate) fn edge_length(mesh: &Mesh<'_>, topology: &Topology, k: usize) -> f64 {
    let d: DVec3 = mesh.point(topology.next[k] as usize) - mesh.point(k);
    length(d)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Faces;

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

    fn flat(mesh: &Mesh<'_>) -> UvSet {
        let values: Vec<[f32; 2]> = (0..mesh.faces().corners().len())
            .map(|k| mesh.point(k))
            .map(|p| [p.x as f32, p.y as f32])
            .collect();
        UvSet::shared(mesh, &values)
    }

    #[test]
    fn a_cut_parts_shells_and_sewing_joins_them() {
        let faces = pair();
        let mesh = Mesh::new(&PAIR, &faces).unwrap();
        let set = flat(&mesh);
        let topology = Topology::new(&mesh);
        assert_eq!(Shells::new(&mesh, &set, &topology).count, 1);
        let mut parted = cut(
            &mesh,
            &set,
            &Cuts {
                pairs: &[[2, 1]],
                angle: None,
            },
        )
        .unwrap();
        assert_eq!(Shells::new(&mesh, &parted, &topology).count, 2);
        assert_eq!(parted.uvs.len(), 8);
        // Turn and shrink the second square, then sew it on again.
        for i in 4..8 {
            let [u, v] = parted.uvs[i];
            parted.uvs[i] = [-0.5 * v + 3.0, 0.5 * u];
        }
        let sewn = sew(&mesh, &parted, &[[1, 2]]).unwrap();
        assert_eq!(Shells::new(&mesh, &sewn, &topology).count, 1);
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
        let cut_at = |pairs: &[[u32; 2]]| cut(&mesh, &set, &Cuts { pairs, angle: None });
        assert_eq!(cut_at(&[[0, 2]]), Err(UvError::NotAnEdge { a: 0, b: 2 }));
        assert_eq!(cut_at(&[[0, 99]]), Err(UvError::NotAnEdge { a: 0, b: 99 }));
        // The rim cannot be sewn.
        assert_eq!(
            sew(&mesh, &set, &[[0, 1]]),
            Err(UvError::NotAnEdge { a: 0, b: 1 })
        );
    }

    /// Two quads that meet in a pole, each with a corner of its own there: their fans have faces without area, which
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
                assert_eq!(Shells::new(&mesh, &set, &topology).count, 1, "{faces:?}");
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
        assert_eq!(Shells::new(&mesh, &set, &topology).count, 1);
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
        assert_eq!(Shells::new(&mesh, &set, &topology).count, 3);
    }
}

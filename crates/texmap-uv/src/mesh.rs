//! Faces over shared positions, and texture coordinates with an index of their own per corner.

use alloc::vec;
use alloc::vec::Vec;
use core::ops::Range;
use texmap_math::float;
use texmap_math::glam::{DMat3, DVec3};

use crate::UvError;

/// Polygons as one list of corners; each corner is an index of a position.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Faces {
    corners: Vec<u32>,
    starts: Vec<u32>,
    /// Faces that are no fans, and three of their own corners for each triangle.
    cuts: Vec<(usize, Vec<[u32; 3]>)>,
}

impl Default for Faces {
    fn default() -> Self {
        Self {
            corners: Vec::new(),
            starts: vec![0],
            cuts: Vec::new(),
        }
    }
}

impl Faces {
    /// No faces.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// One face per triangle.
    #[must_use]
    pub fn from_triangles(triangles: &[[u32; 3]]) -> Self {
        Self {
            corners: triangles.as_flattened().to_vec(),
            starts: (0..=triangles.len() as u32).map(|f| f * 3).collect(),
            cuts: Vec::new(),
        }
    }

    /// Appends a face.
    pub fn push(&mut self, corners: &[u32]) {
        self.corners.extend_from_slice(corners);
        self.starts.push(self.corners.len() as u32);
    }

    /// Appends a face of which the triangles are known, as a concave one needs it: each has three of its corners, by their number among them.
    /// Two triangles less than corners are asked for; a face with more, with fewer, or with numbers beyond its corners is a fan.
    pub fn push_cut(&mut self, corners: &[u32], triangles: &[[u32; 3]]) {
        let fits = triangles.len() + 2 == corners.len()
            && triangles
                .as_flattened()
                .iter()
                .all(|k| (*k as usize) < corners.len());
        let fan = |k: usize| [0, k as u32 + 1, k as u32 + 2];
        if fits && !triangles.iter().enumerate().all(|(k, t)| *t == fan(k)) {
            self.cuts.push((self.len(), triangles.to_vec()));
        }
        self.push(corners);
    }

    /// Number of faces.
    #[must_use]
    pub fn len(&self) -> usize {
        self.starts.len() - 1
    }

    /// True if there is no face.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// All corners, face after face.
    #[must_use]
    pub fn corners(&self) -> &[u32] {
        &self.corners
    }

    /// Range of the corners of a face in [`Faces::corners`].
    #[must_use]
    pub fn range(&self, face: usize) -> Range<usize> {
        self.starts[face] as usize..self.starts[face + 1] as usize
    }

    /// The corners of a face.
    #[must_use]
    pub fn face(&self, face: usize) -> &[u32] {
        &self.corners[self.range(face)]
    }

    /// The triangles of every face, those of [`Faces::push_cut`] or the fan around its first corner: the face, and the indices of three
    /// corners in [`Faces::corners`].
    pub fn triangles(&self) -> impl Iterator<Item = (usize, [usize; 3])> + '_ {
        (0..self.len()).flat_map(|f| self.cut(f).map(move |corners| (f, corners)))
    }

    /// The triangles of one face of a checked mesh: the number of each in [`Faces::triangles`] and its corners.
    pub(crate) fn triangles_of(&self, face: usize) -> impl Iterator<Item = (u32, [usize; 3])> + '_ {
        // A face of n corners, three at least, has n - 2 triangles.
        let first = self.range(face).start - 2 * face;
        let numbers = first as u32..;
        numbers.zip(self.cut(face))
    }

    fn cut(&self, face: usize) -> impl Iterator<Item = [usize; 3]> + '_ {
        let range = self.range(face);
        let known = self.cuts.binary_search_by_key(&face, |(face, _)| *face);
        let known = known.ok().map(|at| self.cuts[at].1.as_slice());
        (0..range.len().saturating_sub(2)).map(move |k| {
            let own = known.map_or([0, k + 1, k + 2], |known| known[k].map(|c| c as usize));
            own.map(|corner| range.start + corner)
        })
    }
}

/// A mesh whose indices and positions have been checked.
#[derive(Clone, Copy, Debug)]
pub struct Mesh<'a> {
    pub(crate) positions: &'a [[f32; 3]],
    pub(crate) faces: &'a Faces,
}

impl<'a> Mesh<'a> {
    /// Checks the mesh. A position that no face uses may be anything.
    ///
    /// # Errors
    /// No face, a face of fewer than three corners, an index without a position, a position that is not finite.
    pub fn new(positions: &'a [[f32; 3]], faces: &'a Faces) -> Result<Self, UvError> {
        if faces.is_empty() {
            return Err(UvError::Empty);
        }
        for face in 0..faces.len() {
            let corners = faces.face(face);
            if corners.len() < 3 {
                return Err(UvError::TooFewCorners {
                    face,
                    corners: corners.len(),
                });
            }
            for &index in corners {
                match positions.get(index as usize) {
                    None => {
                        return Err(UvError::BadIndex {
                            face,
                            index,
                            count: positions.len(),
                        });
                    }
                    Some(p) if !p.iter().all(|c| c.is_finite()) => {
                        return Err(UvError::NotFinite { face, index });
                    }
                    Some(_) => {}
                }
            }
        }
        Ok(Self { positions, faces })
    }

    /// The positions.
    #[must_use]
    pub fn positions(&self) -> &'a [[f32; 3]] {
        self.positions
    }

    /// The faces.
    #[must_use]
    pub fn faces(&self) -> &'a Faces {
        self.faces
    }

    /// Position of a corner, by its index into [`Faces::corners`].
    pub(crate) fn point(&self, corner: usize) -> DVec3 {
        self.vertex(self.faces.corners[corner])
    }

    pub(crate) fn vertex(&self, index: u32) -> DVec3 {
        DVec3::from(self.positions[index as usize].map(f64::from))
    }

    /// Twice the area of a face times its normal (Newell); zero for a face without area.
    pub(crate) fn face_normal(&self, face: usize) -> DVec3 {
        let r = self.faces.range(face);
        let origin = self.point(r.start);
        (r.start + 1..r.end - 1)
            .map(|k| (self.point(k) - origin).cross(self.point(k + 1) - origin))
            .sum()
    }

    /// Unit normal of every position: the area-weighted mean of the faces around it, zero where there is none.
    pub(crate) fn vertex_normals(&self) -> Vec<DVec3> {
        let mut normals = vec![DVec3::ZERO; self.positions.len()];
        for face in 0..self.faces.len() {
            let normal = self.face_normal(face);
            for &i in self.faces.face(face) {
                normals[i as usize] += normal;
            }
        }
        normals.into_iter().map(unit_or_zero).collect()
    }

    /// Unit normal of every position: the area-weighted mean of the faces around it; +Y where there is none.
    #[must_use]
    pub fn smooth_normals(&self) -> Vec<[f32; 3]> {
        let or_up = |n: DVec3| if n == DVec3::ZERO { DVec3::Y } else { n };
        self.vertex_normals()
            .into_iter()
            .map(|n| or_up(n).to_array().map(|c| c as f32))
            .collect()
    }

    /// Lowest and highest coordinates of the positions in use, along the columns of `axes`.
    pub(crate) fn bounds(&self, axes: &DMat3) -> (DVec3, DVec3) {
        let turned = axes.transpose();
        let first = turned * self.vertex(self.faces.corners[0]);
        self.faces
            .corners
            .iter()
            .map(|&i| turned * self.vertex(i))
            .fold((first, first), |(low, high), p| (low.min(p), high.max(p)))
    }

    /// The first position of each group of equal positions, for every position. A mesh split along texture
    /// seams or hard edges is one surface again.
    pub(crate) fn welded(&self) -> Vec<u32> {
        // Hashed keys may collide, by chance or by design: then they are sorted.
        self.welded_by_hash(self.positions.len() as u64 * 8 + 1024)
            .unwrap_or_else(|| self.welded_by_sorting())
    }

    /// Bits of a position, with one zero for both signs.
    fn key(&self, i: u32) -> [u32; 3] {
        self.positions[i as usize].map(|c| (c + 0.0).to_bits())
    }

    /// As [`Mesh::welded`] by a table with open addresses; `None` after that many steps in it.
    fn welded_by_hash(&self, mut steps: u64) -> Option<Vec<u32>> {
        const FREE: u32 = u32::MAX;
        let bits = (2 * self.positions.len())
            .next_power_of_two()
            .ilog2()
            .max(1);
        let mut table = vec![FREE; 1 << bits];
        let mut first: Vec<u32> = Vec::with_capacity(self.positions.len());
        for i in 0..self.positions.len() as u32 {
            let own = self.key(i);
            // The high bits of a product by an odd number near 2^64 / golden ratio (Knuth 1998, section 6.4), per word.
            let mixed = own.iter().fold(0u64, |h, &word| {
                (h.rotate_left(29) ^ u64::from(word)).wrapping_mul(0x9e37_79b9_7f4a_7c15)
            });
            let mut slot = (mixed >> (64 - bits)) as usize;
            while table[slot] != FREE && self.key(table[slot]) != own {
                steps = steps.checked_sub(1)?;
                slot = (slot + 1) & (table.len() - 1);
            }
            if table[slot] == FREE {
                table[slot] = i;
            }
            first.push(table[slot]);
        }
        Some(first)
    }

    fn welded_by_sorting(&self) -> Vec<u32> {
        let mut order: Vec<u32> = (0..self.positions.len() as u32).collect();
        order.sort_unstable_by_key(|&i| (self.key(i), i));
        let mut first = vec![0; order.len()];
        for equal in order.chunk_by(|&a, &b| self.key(a) == self.key(b)) {
            for &i in equal {
                first[i as usize] = equal[0];
            }
        }
        first
    }
}

pub(crate) fn length(v: DVec3) -> f64 {
    float::sqrt(v.x * v.x + v.y * v.y + v.z * v.z)
}

pub(crate) fn unit_or_zero(v: DVec3) -> DVec3 {
    let l = length(v);
    if l > 0.0 && l.is_finite() {
        v / l
    } else {
        DVec3::ZERO
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bad_meshes_name_their_face() {
        let positions = [
            [0.0; 3],
            [1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [f32::NAN, 0.0, 0.0],
        ];
        let check = |faces: &Faces| Mesh::new(&positions, faces).map(|_| ());
        assert_eq!(check(&Faces::new()), Err(UvError::Empty));
        let mut faces = Faces::from_triangles(&[[0, 1, 2]]);
        assert_eq!(check(&faces), Ok(()));
        faces.push(&[0, 1]);
        assert_eq!(
            check(&faces),
            Err(UvError::TooFewCorners {
                face: 1,
                corners: 2
            })
        );
        assert_eq!(
            check(&Faces::from_triangles(&[[0, 1, 2], [0, 1, 4]])),
            Err(UvError::BadIndex {
                face: 1,
                index: 4,
                count: 4
            })
        );
        assert_eq!(
            check(&Faces::from_triangles(&[[0, 3, 2]])),
            Err(UvError::NotFinite { face: 0, index: 3 })
        );
    }

    /// Twenty thousand positions in pairs, zeros of both signs among them: each finds the first of its kind.
    #[test]
    fn equal_positions_are_one() {
        let half = 10_000u32;
        let at = |i: u32| [(i % 97) as f32 - 48.0, (i / 97) as f32, 0.0];
        let mut positions: Vec<[f32; 3]> = (0..half).map(at).collect();
        positions.extend((0..half).rev().map(|i| {
            let [x, y, _] = at(i);
            [x, y, -0.0]
        }));
        let faces = Faces::from_triangles(&[[0, 1, 2]]);
        let mesh = Mesh::new(&positions, &faces).unwrap();
        let expected: Vec<u32> = (0..half).chain((0..half).rev()).collect();
        assert_eq!(mesh.welded(), expected);
        // A position that no face uses may be anything.
        let odd = [[0.0; 3], [1.0; 3], [2.0; 3], [f32::NAN; 3], [f32::NAN; 3]];
        assert_eq!(Mesh::new(&odd, &faces).unwrap().welded(), [0, 1, 2, 3, 3]);
        assert_eq!(mesh.welded_by_hash(10), None);
        for positions in [&positions[..], &odd] {
            let mesh = Mesh::new(positions, &faces).unwrap();
            assert_eq!(mesh.welded_by_sorting(), mesh.welded());
        }
    }

    /// The letter L from its inner corner's neighbour on: the fan turns a triangle around, the triangles given do not.
    #[test]
    fn concave_faces_have_the_triangles_they_came_with() {
        let ell = [
            [2.0, 1.0],
            [1.0, 1.0],
            [1.0, 2.0],
            [0.0, 2.0],
            [0.0, 0.0],
            [2.0, 0.0],
        ];
        let positions = ell.map(|[x, y]: [f32; 2]| [x, y, 0.0]);
        let set = crate::UvSet {
            uvs: ell.map(|uv| uv.map(|c| c / 2.0)).to_vec(),
            corners: (0..6).collect(),
        };
        let corners = [0, 1, 2, 3, 4, 5];
        let good = [[1, 2, 3], [1, 3, 4], [0, 1, 4], [0, 4, 5]];
        let look = |triangles: &[[u32; 3]]| {
            let mut faces = Faces::from_triangles(&[[0, 1, 4]]);
            faces.push_cut(&corners, triangles);
            let mut all = set.clone();
            all.corners.splice(0..0, [0, 1, 4]);
            let mesh = Mesh::new(&positions, &faces).unwrap();
            let options = crate::ReportOptions {
                origin: crate::Origin::BottomLeft,
                ..crate::ReportOptions::default()
            };
            let report = crate::report(&mesh, &all, &options).unwrap();
            let cut: Vec<_> = faces.triangles().skip(1).collect();
            (report.flipped, cut)
        };
        let (flipped, cut) = look(&good);
        assert_eq!(flipped, 0);
        assert_eq!(cut[1], (1, [4, 6, 7]));
        let fan: Vec<_> = (1..5).map(|k| (1, [3, 3 + k, 4 + k])).collect();
        for other in [
            &good[..3],
            &[[0, 1, 6]; 4],
            &[[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]],
        ] {
            let (flipped, cut) = look(other);
            assert_eq!((flipped, &cut), (1, &fan));
        }
    }
}

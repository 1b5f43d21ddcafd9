//! Normals of corners: those of the file, and for faces that bring none the area-weighted mean over each smoothing group.

use std::collections::HashMap;

use texmap_math::glam::DVec3;
use texmap_math::parallel;

use super::read::{Corner, Face, NONE, Obj};

/// A normal for every corner of a model.
///
/// Normals have numbers: first those of the file, then one for each vertex in its first smoothing group, then those of corners that
/// have one of their own.
#[derive(Debug)]
pub(super) struct Normals<'a> {
    obj: &'a Obj,
    smooth: Smooth,
    own: Vec<[f32; 3]>,
}

impl<'a> Normals<'a> {
    pub(super) fn of(obj: &'a Obj) -> Self {
        let (normals, corners) = (&obj.normals, &obj.corners);
        let complete = parallel::first(normals.len(), |i| !has_direction(normals[i])).is_none()
            && parallel::first(corners.len(), |i| corners[i].normal == NONE).is_none();
        Self {
            obj,
            smooth: match complete {
                true => Smooth::default(),
                false => Smooth::of(obj),
            },
            own: Vec::new(),
        }
    }

    /// Number of the normal at a corner of a face whose area normal is `area`.
    pub(super) fn at(&mut self, face: &Face, corner: Corner, area: impl Fn() -> DVec3) -> u32 {
        let given = self.obj.normals.get(corner.normal as usize);
        if given.is_some_and(|n| has_direction(*n)) {
            return corner.normal;
        }
        let vertex = corner.vertex as usize;
        let mean = self.smooth.means[vertex];
        if face.smoothing != 0 && self.smooth.groups[vertex] == face.smoothing && !mean[0].is_nan()
        {
            return (self.obj.normals.len() + vertex) as u32;
        }
        let normal = self.smooth.at(face, corner.vertex, area());
        if self.own.last() != Some(&normal) {
            self.own.push(normal);
        }
        (self.obj.normals.len() + self.smooth.means.len() + self.own.len() - 1) as u32
    }

    /// The normal of this number: of the file of any length, else a unit vector.
    pub(super) fn get(&self, number: u32) -> [f32; 3] {
        let (given, means) = (&self.obj.normals, &self.smooth.means);
        let number = number as usize;
        match number.checked_sub(given.len()) {
            None => given[number],
            Some(mean) if mean < means.len() => means[mean],
            Some(own) => self.own[own - means.len()],
        }
    }
}

/// True if a finite vector is not zero.
fn has_direction(v: [f32; 3]) -> bool {
    v != [0.0; 3]
}

/// Most ranges of vertices. Each goes over all faces once more.
const MOST_RANGES: usize = 4;

/// Sums of area normals at a range of vertices.
struct Range<'a> {
    /// The first vertex.
    first: usize,
    sums: &'a mut [[f64; 3]],
    groups: &'a mut [u32],
    others: HashMap<(u32, u32), DVec3>,
}

impl Range<'_> {
    fn add_all(&mut self, obj: &Obj) {
        // Memory that is read before its first write is mapped twice.
        self.groups.fill(0);
        self.sums.fill([0.0; 3]);
        let (mut corners, mut points) = (&obj.corners[..], Vec::new());
        for face in &obj.faces {
            let (own, rest) = corners.split_at(face.corners as usize);
            corners = rest;
            let touches = own.iter().any(|corner| self.place(*corner).is_some());
            if face.smoothing != 0 && touches {
                self.add(face, own, obj.area_normal(own, &mut points));
            }
        }
    }

    /// The place of a corner's vertex in the range.
    fn place(&self, corner: Corner) -> Option<usize> {
        let place = (corner.vertex as usize).wrapping_sub(self.first);
        (place < self.sums.len()).then_some(place)
    }

    /// Adds a face of this area normal.
    fn add(&mut self, face: &Face, corners: &[Corner], area: DVec3) {
        for corner in corners {
            let Some(place) = self.place(*corner) else {
                continue;
            };
            let group = &mut self.groups[place];
            if *group == 0 {
                *group = face.smoothing;
            }
            if *group == face.smoothing {
                let sum = &mut self.sums[place];
                *sum = (DVec3::from(*sum) + area).to_array();
            } else {
                let key = (corner.vertex, face.smoothing);
                *self.others.entry(key).or_default() += area;
            }
        }
    }
}

/// Means of area normals per vertex and smoothing group.
#[derive(Debug, Default)]
struct Smooth {
    /// The first group of each vertex, 0 where there is none.
    groups: Vec<u32>,
    /// The unit mean in it; NaN where it has no direction.
    means: Vec<[f32; 3]>,
    /// The sums in other groups, by vertex and group.
    others: HashMap<(u32, u32), DVec3>,
}

impl Smooth {
    /// Each thread goes over all faces and sums the normals of its own range of vertices, in the order of the file.
    fn of(obj: &Obj) -> Self {
        let count = obj.positions.len();
        let (mut groups, mut means) = (vec![0; count], vec![[0.0; 3]; count]);
        let mut sums = vec![[0.0; 3]; count];
        let threads = parallel::threads().min(MOST_RANGES);
        let side = count.div_ceil(threads).max(1);
        let ranges = groups.chunks_mut(side).zip(sums.chunks_mut(side));
        let ranges = ranges.zip(means.chunks_mut(side)).enumerate();
        let others = parallel::map(ranges, |(number, ((groups, sums), means))| {
            let mut range = Range {
                first: number * side,
                sums,
                groups,
                others: HashMap::new(),
            };
            range.add_all(obj);
            for (mean, sum) in means.iter_mut().zip(&*range.sums) {
                let unit = unit(DVec3::from(*sum));
                *mean = unit.map_or([f32::NAN; 3], |n| n.as_vec3().to_array());
            }
            range.others
        });
        Self {
            groups,
            means,
            others: others.into_iter().flatten().collect(),
        }
    }

    /// Unit normal at a corner that has not the mean of its first group: of another group, or of the face where the group is flat or
    /// cancels out.
    fn at(&self, face: &Face, vertex: u32, area: DVec3) -> [f32; 3] {
        let sum = self.others.get(&(vertex, face.smoothing));
        (sum.and_then(|sum| unit(*sum)))
            .or_else(|| unit(area))
            .unwrap_or(DVec3::Z)
            .as_vec3()
            .to_array()
    }
}

impl Obj {
    /// The area normal of a face; `points` is scratch for its corners.
    pub(super) fn area_normal(&self, corners: &[Corner], points: &mut Vec<DVec3>) -> DVec3 {
        points.clear();
        points.extend(corners.iter().map(|c| {
            let point = self.positions[c.vertex as usize];
            DVec3::from(point.map(f64::from))
        }));
        area_normal(points)
    }
}

/// Sum of the cross products of the fan: twice the area, along the normal.
fn area_normal(polygon: &[DVec3]) -> DVec3 {
    fan_areas(polygon).sum()
}

/// The cross product of each triangle of the fan.
pub(super) fn fan_areas(polygon: &[DVec3]) -> impl Iterator<Item = DVec3> {
    let (first, rest) = polygon.split_first().unwrap_or((&DVec3::ZERO, &[]));
    rest.windows(2)
        .map(|pair| (pair[0] - *first).cross(pair[1] - *first))
}

/// `v` scaled to length 1, unless it has none; scaled by its largest part first, so that squares neither overflow
/// nor vanish.
pub(crate) fn unit(v: DVec3) -> Option<DVec3> {
    let largest = v.abs().max_element();
    let scaled = v / largest;
    (largest > 0.0 && scaled.is_finite()).then(|| scaled / scaled.length())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn face(smoothing: u32) -> Face {
        Face {
            line: 1,
            corners: 3,
            has_uv: false,
            smoothing,
        }
    }

    fn corner(vertex: u32) -> Corner {
        Corner {
            vertex,
            uv: NONE,
            normal: NONE,
        }
    }

    /// A model of triangles with these groups, whose corners are given by their positions.
    fn model(triangles: &[(u32, [u32; 3])], positions: &[[f32; 3]]) -> Obj {
        let faces = triangles.iter().map(|(group, _)| face(*group)).collect();
        let corners = triangles.iter().flat_map(|(_, t)| t.map(corner)).collect();
        Obj {
            positions: positions.to_vec(),
            faces,
            corners,
            ..Obj::default()
        }
    }

    fn at(obj: &Obj, triangle: usize, vertex: u32) -> [f32; 3] {
        let mut normals = Normals::of(obj);
        let own = &obj.corners[3 * triangle..][..3];
        let area = || obj.area_normal(own, &mut Vec::new());
        let number = normals.at(&obj.faces[triangle], corner(vertex), area);
        normals.get(number)
    }

    #[test]
    fn larger_faces_weigh_more_and_flat_ones_stand_alone() {
        // Normals of areas 3 along z and 4 along y at the vertex 0.
        let positions = [
            [0.0; 3],
            [3.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [0.0, 0.0, 4.0],
            [1.0, 0.0, 0.0],
        ];
        let obj = model(
            &[
                (1, [0, 1, 2]),
                (1, [0, 3, 4]),
                (0, [0, 2, 3]),
                (2, [0, 2, 3]),
            ],
            &positions,
        );
        assert_eq!(at(&obj, 0, 0), [0.0, 0.8, 0.6]);
        assert_eq!(at(&obj, 2, 0), [1.0, 0.0, 0.0]);
        assert_eq!(at(&obj, 3, 0), [1.0, 0.0, 0.0]);
        assert_eq!(at(&obj, 1, 3), [0.0, 1.0, 0.0]);
    }

    #[test]
    fn opposite_faces_and_slivers_still_have_normals() {
        let positions = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let obj = model(
            &[(1, [0, 1, 2]), (1, [0, 2, 1]), (0, [0, 1, 1])],
            &positions,
        );
        assert_eq!(at(&obj, 0, 0), [0.0, 0.0, 1.0]);
        assert_eq!(at(&obj, 1, 0), [0.0, 0.0, -1.0]);
        assert_eq!(at(&obj, 2, 0), [0.0, 0.0, 1.0]);
        assert_eq!(
            unit(DVec3::splat(1e-200)).map(|v| v.x),
            unit(DVec3::splat(1e200)).map(|v| v.x)
        );
        assert_eq!(unit(DVec3::new(f64::NAN, 1.0, 0.0)), None);
    }
}

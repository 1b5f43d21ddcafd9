//! Normals for faces that bring none: the area-weighted mean over each smoothing group.

use std::collections::HashMap;

use texmap_math::glam::DVec3;

use super::read::{Corner, Face};

/// Sums of area normals per vertex and smoothing group.
#[derive(Debug)]
pub(super) struct Smooth {
    /// Of each vertex: its first group (0 before there is one) and the sum in it.
    first: Vec<(u32, DVec3)>,
    /// The sums in other groups, by vertex and group.
    others: HashMap<(u32, u32), DVec3>,
}

impl Smooth {
    pub(super) fn new(vertices: usize) -> Self {
        Self {
            first: vec![(0, DVec3::ZERO); vertices],
            others: HashMap::new(),
        }
    }

    /// Adds a face of this area normal.
    pub(super) fn add(&mut self, face: &Face, corners: &[Corner], area: DVec3) {
        if face.smoothing == 0 {
            return;
        }
        for corner in corners {
            let (group, sum) = &mut self.first[corner.vertex as usize];
            if *group == 0 {
                *group = face.smoothing;
            }
            if *group == face.smoothing {
                *sum += area;
            } else {
                let key = (corner.vertex, face.smoothing);
                *self.others.entry(key).or_default() += area;
            }
        }
    }

    /// Unit normal at a corner: of the group, or of the face where the group is flat or cancels out.
    pub(super) fn at(&self, face: &Face, vertex: u32, area: DVec3) -> [f32; 3] {
        let sum = match self.first[vertex as usize] {
            _ if face.smoothing == 0 => Some(area),
            (group, sum) if group == face.smoothing => Some(sum),
            _ => self.others.get(&(vertex, face.smoothing)).copied(),
        };
        unit(sum.unwrap_or(area))
            .or_else(|| unit(area))
            .unwrap_or(DVec3::Z)
            .as_vec3()
            .to_array()
    }
}

/// Sum of the cross products of the fan: twice the area, along the normal.
pub(super) fn area_normal(polygon: &[DVec3]) -> DVec3 {
    let Some((&first, rest)) = polygon.split_first() else {
        return DVec3::ZERO;
    };
    rest.windows(2)
        .map(|pair| (pair[0] - first).cross(pair[1] - first))
        .sum()
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
    use super::super::read::NONE;
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

    #[test]
    fn larger_faces_weigh_more_and_flat_ones_stand_alone() {
        let mut smooth = Smooth::new(6);
        smooth.add(&face(1), &[corner(0)], DVec3::new(0.0, 0.0, 3.0));
        smooth.add(&face(1), &[corner(0)], DVec3::new(0.0, 4.0, 0.0));
        smooth.add(&face(0), &[corner(0)], DVec3::new(9.0, 0.0, 0.0));
        assert_eq!(smooth.at(&face(1), 0, DVec3::Z), [0.0, 0.8, 0.6]);
        assert_eq!(smooth.at(&face(0), 0, DVec3::X * 7.0), [1.0, 0.0, 0.0]);
        assert_eq!(smooth.at(&face(2), 0, DVec3::Y), [0.0, 1.0, 0.0]);
    }

    #[test]
    fn opposite_faces_and_slivers_still_have_normals() {
        let mut smooth = Smooth::new(6);
        smooth.add(&face(1), &[corner(0)], DVec3::Z);
        smooth.add(&face(1), &[corner(0)], DVec3::NEG_Z);
        assert_eq!(smooth.at(&face(1), 0, DVec3::NEG_Z), [0.0, 0.0, -1.0]);
        assert_eq!(smooth.at(&face(1), 5, DVec3::ZERO), [0.0, 0.0, 1.0]);
        assert_eq!(
            unit(DVec3::splat(1e-200)).map(|v| v.x),
            unit(DVec3::splat(1e200)).map(|v| v.x)
        );
        assert_eq!(unit(DVec3::new(f64::NAN, 1.0, 0.0)), None);
    }
}

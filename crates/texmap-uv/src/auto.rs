//! Automatic mapping by several planes: each face goes to the axis direction it faces.

use alloc::vec;
use alloc::vec::Vec;
use texmap_math::glam::DVec3;

use crate::mesh::{Mesh, UvSet, unit_or_zero};
use crate::overlap::{self, Flat};
use crate::pack::{Page, pack};
use crate::shells::Shells;
use crate::solid::Part;
use crate::topology::Topology;
use crate::{Origin, UvError, parallel};

/// Maps every face by the plane of one of the six axis directions, the one its normal is nearest to (equal ones are
/// settled z before y before x), and packs the connected regions into one page.
///
/// A face whose neighbours mostly lie on another plane joins them if it faces that plane by less than 70 degrees. A
/// region that folds over itself is divided until no two of its triangles overlap. Faces without area follow a
/// neighbour.
///
/// # Errors
/// More charts than the page can hold.
pub fn auto_planes(mesh: &Mesh<'_>, page: Page, origin: Origin) -> Result<UvSet, UvError> {
    let topology = Topology::new(mesh);
    let faces = mesh.faces().len();
    let normals = parallel::collect_chunks(faces, |range| {
        range.map(|f| unit_or_zero(mesh.face_normal(f))).collect()
    });
    let sides = sides(mesh, &topology, &normals);
    let corner = |k: usize| {
        sides[topology.face[k] as usize]
            .flat(mesh.point(k))
            .uv(origin)
    };
    let values: Vec<[f64; 2]> = (0..mesh.faces().corners().len()).map(corner).collect();
    let group = divide(mesh, &topology, &sides, &values);
    let flat: Vec<[f32; 2]> = values.iter().map(|v| v.map(|c| c as f32)).collect();
    // One index per position and chart.
    let mut known = alloc::collections::BTreeMap::new();
    let mut set = UvSet {
        uvs: Vec::new(),
        corners: Vec::with_capacity(flat.len()),
    };
    for (k, value) in flat.iter().enumerate() {
        let key = (
            group[topology.face[k] as usize],
            topology.welded[mesh.faces().corners()[k] as usize],
        );
        set.corners.push(*known.entry(key).or_insert_with(|| {
            set.uvs.push(*value);
            set.uvs.len() as u32 - 1
        }));
    }
    pack(mesh, &set, page)
}

fn sides(mesh: &Mesh<'_>, topology: &Topology, normals: &[DVec3]) -> Vec<Part> {
    let mut sides: Vec<Part> = normals.iter().map(|n| Part::facing(*n)).collect();
    for _ in 0..4 {
        let before = sides.clone();
        for f in 0..sides.len() {
            let around: Vec<Part> = mesh
                .faces()
                .range(f)
                .filter_map(|k| topology.across(mesh, k))
                .map(|[there, _]| before[topology.face[there] as usize])
                .collect();
            let votes = |side: Part| around.iter().filter(|s| **s == side).count();
            let flat = normals[f] == DVec3::ZERO;
            let winner = around
                .iter()
                .copied()
                .find(|s| *s != before[f] && votes(*s) * 3 >= around.len() * 2);
            if let Some(side) = winner.filter(|s| flat || normals[f].dot(s.outward()) > 0.342) {
                sides[f] = side;
            }
        }
    }
    sides
}

/// A chart number per face: connected faces of one side that do not overlap in its plane.
fn divide(mesh: &Mesh<'_>, topology: &Topology, sides: &[Part], values: &[[f64; 2]]) -> Vec<u32> {
    let faces = mesh.faces().len();
    let mut layer = vec![0u32; faces];
    let mut triangles = Vec::new();
    for (index, (f, c)) in mesh.faces().triangles().enumerate() {
        let [p, q, r] = c.map(|k| texmap_math::glam::DVec2::from(values[k]));
        let twice = (q - p).perp_dot(r - p);
        if twice != 0.0 {
            let turned = if twice > 0.0 { [p, q, r] } else { [p, r, q] };
            triangles.push(Flat {
                corners: turned,
                face: f as u32,
                index: index as u32,
            });
        }
    }
    loop {
        let joined = |k: usize| {
            let [a, b] = [
                topology.face[k] as usize,
                topology.face[topology.twin[k] as usize] as usize,
            ];
            sides[a] == sides[b] && layer[a] == layer[b]
        };
        let shells = Shells::linked(faces, topology, joined);
        let overlaps = overlap::find(&triangles, Some(&shells.of_face), true);
        if overlaps.list.is_empty() {
            return shells.of_face;
        }
        // The later face of each pair moves up a layer; at worst every face ends on its own.
        let mut moved = vec![false; faces];
        for [_, later] in overlaps.list {
            moved[later as usize] = true;
        }
        for (layer, _) in layer.iter_mut().zip(&moved).filter(|(_, moved)| **moved) {
            *layer += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Faces, ReportOptions, report};

    /// A spiral ramp around y: every face looks up, and the second turn lies above the first.
    #[test]
    fn a_ramp_above_itself_is_divided() {
        let mut positions = Vec::new();
        let mut faces = Faces::new();
        for k in 0..=40u32 {
            let (s, c) = texmap_math::det::sin_cos(f64::from(k) * 0.35);
            let y = 0.02 * k as f32;
            positions.extend([[c as f32, y, s as f32], [2.0 * c as f32, y, 2.0 * s as f32]]);
            if k > 0 {
                let b = 2 * k;
                faces.push(&[b - 2, b, b + 1, b - 1]);
            }
        }
        let mesh = Mesh::new(&positions, &faces).unwrap();
        let set = auto_planes(&mesh, Page::default(), Origin::TopLeft).unwrap();
        let report = report(&mesh, &set, &ReportOptions::default()).unwrap();
        assert_eq!(
            (report.overlapping, report.outside, report.collapsed),
            (0, 0, 0)
        );
        assert!(report.shells >= 3, "{} shells", report.shells);
        assert!(report.angle_max < 1.05, "{}", report.angle_max);
    }
}

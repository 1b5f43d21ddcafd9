//! Automatic mapping by several planes: each face goes to the axis direction it faces.

use alloc::vec;
use alloc::vec::Vec;
use texmap_math::glam::DVec3;

use crate::islands::Islands;
use crate::mesh::{Mesh, unit_or_zero};
use crate::overlap::{self, Flat};
use crate::pack::{AtlasSize, pack};
use crate::solid::ShapeFace;
use crate::topology::Topology;
use crate::uv_set::UvSet;
use crate::{Origin, UvError, parallel};

/// A surface that folds over itself is divided in this many rounds, one layer each. A surface that folds more often is divided at
/// once.
const ROUNDS: u32 = 8;

/// Maps every face by the nearest of six axis planes, and packs the connected regions into one atlas. The plane is
/// that of the axis direction nearest to the face's normal; equal ones are settled z before y before x.
///
/// A face whose neighbours mostly lie on another plane joins them if it faces that plane by less than 70 degrees. A
/// region that folds over itself is divided until no two of its triangles overlap. Faces without area follow a
/// neighbour.
///
/// # Errors
/// More islands than the atlas can hold.
pub fn auto_planes(mesh: &Mesh<'_>, atlas: AtlasSize, origin: Origin) -> Result<UvSet, UvError> {
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
    // One index per position and island.
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
    pack(mesh, &set, atlas)
}

const SIDES: [ShapeFace; 6] = [
    ShapeFace::Front,
    ShapeFace::Back,
    ShapeFace::Top,
    ShapeFace::Bottom,
    ShapeFace::Right,
    ShapeFace::Left,
];

fn sides(mesh: &Mesh<'_>, topology: &Topology, normals: &[DVec3]) -> Vec<ShapeFace> {
    let mut sides: Vec<ShapeFace> = normals.iter().map(|n| ShapeFace::facing(*n)).collect();
    for _ in 0..4 {
        let before = sides.clone();
        for f in 0..sides.len() {
            let (mut votes, mut around) = ([0; 6], 0);
            for [there, _] in mesh
                .faces()
                .range(f)
                .filter_map(|k| topology.across(mesh, k))
            {
                let side = before[topology.face[there] as usize];
                around += 1;
                votes[SIDES.iter().position(|s| *s == side).unwrap_or(0)] += 1;
            }
            let flat = normals[f] == DVec3::ZERO;
            // No two of them have two thirds.
            let winner = SIDES
                .into_iter()
                .zip(votes)
                .find(|&(side, votes)| side != before[f] && votes > 0 && votes * 3 >= around * 2)
                .map(|(side, _)| side);
            if let Some(side) = winner.filter(|s| flat || normals[f].dot(s.outward()) > 0.342) {
                sides[f] = side;
            }
        }
    }
    sides
}

/// An island number per face: connected faces of one side that do not overlap in its plane.
fn divide(
    mesh: &Mesh<'_>,
    topology: &Topology,
    sides: &[ShapeFace],
    values: &[[f64; 2]],
) -> Vec<u32> {
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
    let islands = |layer: &[u32]| {
        Islands::linked(faces, topology, |k| {
            let [a, b] = [k, topology.twin[k] as usize].map(|k| topology.face[k] as usize);
            sides[a] == sides[b] && layer[a] == layer[b]
        })
    };
    for round in 0..ROUNDS {
        let found = overlap::find(&triangles, Some(&islands(&layer).of_face));
        if found.later.is_empty() && found.unfinished.is_empty() {
            return islands(&layer).of_face;
        }
        if !found.unfinished.is_empty() {
            break;
        }
        // The later face of each pair moves up a layer.
        for &face in &found.later {
            layer[face as usize] = round + 1;
        }
    }
    first_fit(&triangles, &islands(&layer).of_face, &mut layer);
    islands(&layer).of_face
}

/// Moves each face that overlaps earlier ones of its group to the first layer where it overlaps none. Faces that cannot be
/// compared with all others, since too many lie at one point, to layers of their own.
fn first_fit(triangles: &[Flat], group: &[u32], layer: &mut [u32]) {
    let (pairs, unfinished) = overlap::pairs(triangles, Some(group));
    let old = layer.to_vec();
    // Layers above all those in use, of which each number below belongs to one old layer.
    let layers = ROUNDS + 1;
    layer.fill(0);
    let mut taken = Vec::new();
    for of_one in pairs.chunk_by(|a, b| a[0] == b[0]) {
        taken.clear();
        taken.extend(of_one.iter().map(|[_, earlier]| layer[*earlier as usize]));
        taken.sort_unstable();
        taken.dedup();
        let free = taken.iter().zip(0..).find(|(taken, free)| **taken != *free);
        layer[of_one[0][0] as usize] = free.map_or(taken.len() as u32, |(_, free)| free);
    }
    let most = layer.iter().copied().max().unwrap_or(0) + 1;
    for (new, old) in layer.iter_mut().zip(old) {
        *new = *new * layers + old;
    }
    for face in unfinished {
        layer[face as usize] = most * layers + face;
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
            let (s, c) = texmap_math::deterministic_f64::sin_cos(f64::from(k) * 0.35);
            let y = 0.02 * k as f32;
            positions.extend([[c as f32, y, s as f32], [2.0 * c as f32, y, 2.0 * s as f32]]);
            if k > 0 {
                let b = 2 * k;
                faces.push(&[b - 2, b, b + 1, b - 1]);
            }
        }
        let mesh = Mesh::new(&positions, &faces).unwrap();
        let set = auto_planes(&mesh, AtlasSize::default(), Origin::TopLeft).unwrap();
        let report = report(&mesh, &set, &ReportOptions::default()).unwrap();
        assert_eq!(
            (report.overlapping, report.outside, report.collapsed),
            (0, 0, 0)
        );
        assert!(report.islands >= 3, "{} islands", report.islands);
        assert!(report.angle_max < 1.05, "{}", report.angle_max);
    }
}

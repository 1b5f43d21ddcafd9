//! Automatic mapping by several planes: each face goes to the axis direction it faces.

use alloc::vec;
use alloc::vec::Vec;
use texmap_math::glam::{DVec2, DVec3};

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
    let values: Vec<DVec2> = (0..mesh.faces().corners().len())
        .map(|k| {
            let [right, up] = sides[topology.face[k] as usize].seen(mesh.point(k));
            match origin {
                Origin::TopLeft => DVec2::new(right, -up),
                Origin::BottomLeft => DVec2::new(right, up),
            }
        })
        .collect();
    let islands = divide(mesh, &topology, &sides, &values);
    let island = |k: usize| islands.of_face[topology.face[k] as usize];
    // Floats far from zero would lose what a small island far from the origin, or a model in small units, has in digits.
    let mut low = vec![DVec2::INFINITY; islands.count];
    let mut most = 0.0f64;
    for (k, value) in values.iter().enumerate() {
        let low = &mut low[island(k) as usize];
        *low = low.min(*value);
        most = most.max(value.abs().max_element());
    }
    // Differences of the largest floats are none.
    let unit = if most < 1e38 { 1.0 } else { 0.25 };
    // One index per position and island.
    let mut known = alloc::collections::BTreeMap::new();
    let mut set = UvSet {
        uvs: Vec::new(),
        corners: Vec::with_capacity(values.len()),
    };
    for (k, value) in values.iter().enumerate() {
        let key = (
            island(k),
            topology.welded[mesh.faces().corners()[k] as usize],
        );
        set.corners.push(*known.entry(key).or_insert_with(|| {
            let own = (*value - low[key.0 as usize]) * unit;
            set.uvs.push(own.as_vec2().to_array());
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

/// The islands: connected faces of one side that do not overlap in its plane.
fn divide(mesh: &Mesh<'_>, topology: &Topology, sides: &[ShapeFace], values: &[DVec2]) -> Islands {
    let faces = mesh.faces().len();
    let mut layer = vec![0u32; faces];
    let mut triangles = Vec::new();
    for (index, (f, c)) in mesh.faces().triangles().enumerate() {
        let [p, q, r] = c.map(|k| values[k]);
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
        let present = islands(&layer);
        let found = overlap::find(&triangles, Some(&present.of_face));
        if found.later.is_empty() && found.unfinished.is_empty() {
            return present;
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
    islands(&layer)
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

    /// A grid of hills in units of other sizes, about the origin and far from it.
    #[test]
    fn the_unit_of_a_model_does_not_matter() {
        let side = 24u32;
        let mut faces = Faces::new();
        for (x, y) in (1..side).flat_map(|y| (1..side).map(move |x| (x, y))) {
            let k = y * side + x;
            faces.push(&[k - side - 1, k - side, k, k - 1]);
        }
        let hills = |unit: f32, away: f32| -> Vec<[f32; 3]> {
            let at = |k: u32| {
                let (x, y) = ((k % side) as f32, (k / side) as f32);
                let wave = texmap_math::deterministic_f64::sin_cos(f64::from(x * 0.9 + y * 0.7)).0;
                [x + away, y - away, 2.0 * wave as f32].map(|c| c * unit)
            };
            (0..side * side).map(at).collect()
        };
        for away in [0.0, 4096.0] {
            let of_unit = |unit: f32| {
                let positions = hills(unit, away);
                let mesh = Mesh::new(&positions, &faces).unwrap();
                let set = auto_planes(&mesh, AtlasSize::default(), Origin::TopLeft).unwrap();
                let report = report(&mesh, &set, &ReportOptions::default()).unwrap();
                assert_eq!((report.collapsed, report.overlapping), (0, 0), "{unit}");
                set
            };
            let plain = of_unit(1.0);
            // Powers of two, so that positions are rounded alike.
            for unit in [
                1.0 / (1u64 << 60) as f32,
                1.0 / 1048576.0,
                1048576.0,
                (1u64 << 60) as f32,
            ] {
                assert_eq!(of_unit(unit), plain, "unit {unit}, {away} away");
            }
        }
    }
}

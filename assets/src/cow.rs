//! The purple cow: an implicit body, lofted horns, ears, tail and bell, one painted atlas over all of it.

mod atlas;
mod hide;
mod loft;
mod nets;
mod shape;

use texmap_math::glam::DVec3;

use crate::mesh::{Corner, Mesh, unit};
use crate::picture::{Picture, rgb};
use atlas::Surface;
use loft::{Station, Tube};

/// Edge of the atlas in texels.
const SIZE: u32 = 1024;

/// The parts in the order of their groups.
pub(crate) const PARTS: [&str; 6] = ["body", "eyes", "ears", "horns", "tail", "bell"];
const BODY: usize = 0;
const EYES: usize = 1;
const EARS: usize = 2;
const HORNS: usize = 3;
const TAIL: usize = 4;
const BELL: usize = 5;

/// The mesh and its texture.
pub(crate) fn cow() -> (Mesh, Picture) {
    let surface = surface();
    let places = atlas::layout(&surface, f64::from(SIZE), 8.0);
    let picture = atlas::paint(&surface, &places, SIZE, rgb(hide::PURPLE), &hide::color);
    let mut mesh = Mesh {
        positions: surface.points.clone(),
        normals: surface.normals.clone(),
        ..Mesh::default()
    };
    for (part, name) in PARTS.iter().enumerate() {
        let mut faces = Vec::new();
        for f in (0..surface.faces.len()).filter(|&f| surface.parts[f] == part) {
            let corners = surface.faces[f].iter().zip(&places[f]).map(|(&i, place)| {
                mesh.uvs
                    .push([place.x / f64::from(SIZE), 1.0 - place.y / f64::from(SIZE)]);
                Corner {
                    position: i,
                    uv: mesh.uvs.len() - 1,
                    normal: i,
                }
            });
            faces.push(corners.collect());
        }
        mesh.groups.push(((*name).into(), faces));
    }
    (mesh.welded(), picture)
}

fn surface() -> Surface {
    let mut surface = Surface::default();
    let mut body = nets::net(
        &shape::body,
        DVec3::new(-1.26, -0.06, -0.63),
        0.042,
        [68, 45, 30],
    );
    body.relax(&shape::body, 6);
    let normals: Vec<DVec3> = body
        .points
        .iter()
        .map(|p| unit(shape::gradient(&shape::body, *p)))
        .collect();
    surface.add(
        BODY,
        &body.points,
        &normals,
        body.quads.iter().map(|q| q.to_vec()),
    );
    let mut pair = |part: usize, tube: &Tube| {
        for tube in [tube, &tube.mirrored()] {
            surface.add(
                part,
                &tube.points,
                &tube.normals(),
                tube.faces.iter().cloned(),
            );
        }
    };
    pair(EYES, &loft::ball(shape::EYE, shape::EYE_RADIUS, 12, 20));
    pair(EARS, &ear());
    pair(HORNS, &horn());
    for (part, tube) in [(TAIL, tail()), (BELL, bell())] {
        surface.add(
            part,
            &tube.points,
            &tube.normals(),
            tube.faces.iter().cloned(),
        );
    }
    surface
}

fn station(x: f64, y: f64, z: f64, wide: f64, thick: f64) -> Station {
    Station {
        centre: DVec3::new(x, y, z),
        wide,
        thick,
    }
}

fn ear() -> Tube {
    let stations = [
        station(0.93, 1.52, 0.17, 0.035, 0.03),
        station(0.92, 1.55, 0.26, 0.075, 0.032),
        station(0.91, 1.55, 0.36, 0.105, 0.03),
        station(0.90, 1.51, 0.46, 0.085, 0.025),
        station(0.90, 1.45, 0.53, 0.012, 0.012),
    ];
    loft::tube(&stations, DVec3::new(0.25, 1.0, 0.35), 4, 14)
}

fn horn() -> Tube {
    let stations = [
        station(0.93, 1.60, 0.11, 0.055, 0.055),
        station(0.91, 1.71, 0.18, 0.052, 0.052),
        station(0.93, 1.82, 0.20, 0.036, 0.036),
        station(0.97, 1.90, 0.17, 0.006, 0.006),
    ];
    loft::tube(&stations, DVec3::X, 5, 12)
}

fn tail() -> Tube {
    let stations = [
        station(-0.88, 1.14, 0.0, 0.05, 0.05),
        station(-1.02, 1.16, 0.0, 0.042, 0.042),
        station(-1.14, 1.02, 0.01, 0.033, 0.033),
        station(-1.18, 0.82, 0.05, 0.028, 0.028),
        station(-1.20, 0.66, 0.08, 0.03, 0.03),
        station(-1.20, 0.55, 0.10, 0.075, 0.07),
        station(-1.18, 0.45, 0.11, 0.055, 0.05),
        station(-1.15, 0.35, 0.11, 0.004, 0.004),
    ];
    loft::tube(&stations, DVec3::X, 4, 12)
}

fn bell() -> Tube {
    let stations = [
        station(0.80, 0.97, 0.0, 0.01, 0.01),
        station(0.80, 0.955, 0.0, 0.05, 0.05),
        station(0.81, 0.87, 0.0, 0.075, 0.075),
        station(0.82, 0.82, 0.0, 0.10, 0.10),
        station(0.82, 0.805, 0.0, 0.02, 0.02),
    ];
    loft::tube(&stations, DVec3::X, 4, 16)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    /// Every edge is used once in each direction: no hole, no fin, one winding.
    #[test]
    fn the_cow_is_closed_and_faces_outward() {
        let surface = surface();
        let mut edges: BTreeMap<(usize, usize), i32> = BTreeMap::new();
        let mut volume = 0.0;
        for face in &surface.faces {
            for k in 0..face.len() {
                let (a, b) = (face[k], face[(k + 1) % face.len()]);
                *edges.entry((a, b)).or_default() += 1;
            }
            for k in 1..face.len() - 1 {
                let [a, b, c] = [face[0], face[k], face[k + 1]].map(|i| surface.points[i]);
                volume += a.dot(b.cross(c)) / 6.0;
            }
        }
        let bad = edges
            .iter()
            .filter(|((a, b), n)| **n != 1 || edges.get(&(*b, *a)) != Some(&1))
            .count();
        assert_eq!(bad, 0, "edges not used once each way");
        assert!(volume > 0.5, "volume {volume}");
    }

    #[test]
    fn uvs_lie_in_the_atlas_and_keep_their_winding() {
        let (mesh, picture) = cow();
        assert!(mesh.uvs.iter().flatten().all(|c| (0.0..=1.0).contains(c)));
        assert_eq!((picture.width, picture.height), (SIZE, SIZE));
        let (mut flipped, mut total) = (0, 0);
        for face in mesh.groups.iter().flat_map(|(_, faces)| faces) {
            let t = |k: usize| mesh.uvs[face[k].uv];
            let area: f64 = (0..face.len())
                .map(|k| {
                    let (a, b) = (t(k), t((k + 1) % face.len()));
                    a[0] * b[1] - a[1] * b[0]
                })
                .sum();
            flipped += usize::from(area < 0.0);
            total += 1;
        }
        assert!(
            flipped * 500 < total,
            "{flipped} of {total} faces are mirrored in the atlas"
        );
    }
}

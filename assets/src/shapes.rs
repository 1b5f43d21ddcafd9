//! Plain solids with texture coordinates.

use texmap_math::{deterministic_f64, glam::DVec3};

use crate::mesh::{Corner, Mesh, unit};

/// The unit cube; each face shows the whole picture upright to a viewer in front of it (top and bottom as seen
/// with the front face below or above them).
pub(crate) fn cube() -> Mesh {
    let mut mesh = Mesh::default();
    let sides = [
        ("right", DVec3::X, DVec3::NEG_Z, DVec3::Y),
        ("left", DVec3::NEG_X, DVec3::Z, DVec3::Y),
        ("top", DVec3::Y, DVec3::X, DVec3::NEG_Z),
        ("bottom", DVec3::NEG_Y, DVec3::X, DVec3::Z),
        ("front", DVec3::Z, DVec3::X, DVec3::Y),
        ("back", DVec3::NEG_Z, DVec3::NEG_X, DVec3::Y),
    ];
    for (name, outward, u, v) in sides {
        let corner = |a: f64, b: f64| (outward * 0.5 + u * (a - 0.5) + v * (b - 0.5), [a, b]);
        mesh.polygon(
            name,
            &[
                corner(0.0, 0.0),
                corner(1.0, 0.0),
                corner(1.0, 1.0),
                corner(0.0, 1.0),
            ],
        );
    }
    mesh.welded()
}

/// The unit cube with each face in a cell of 3 x 2.
pub(crate) fn unfolded_cube() -> Mesh {
    let mut cube = cube();
    let mut uvs = Vec::new();
    for (number, corner) in cube
        .groups
        .iter_mut()
        .enumerate()
        .flat_map(|(number, (_, faces))| {
            let corners = faces.iter_mut().flatten();
            corners.map(move |corner| (number, corner))
        })
    {
        let [u, v] = cube.uvs[corner.uv];
        let (column, row) = ((number % 3) as f64, (number / 3) as f64);
        // Half a texel of 32 stays clear around each cell.
        let inset = |c: f64| (0.5 + 31.0 * c) / 32.0;
        corner.uv = uvs.len();
        uvs.push([
            (column + inset(u)) / 3.0,
            1.0 - (row + 1.0 - inset(v)) / 2.0,
        ]);
    }
    cube.uvs = uvs;
    cube
}

/// A square on the ground, twice the picture each way.
pub(crate) fn plate() -> Mesh {
    let mut mesh = Mesh::default();
    let corner = |x: f64, z: f64| (DVec3::new(x, 0.0, z), [x + 1.0, 1.0 - z]);
    let corners = [(-1.0, 1.0), (1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)];
    mesh.polygon("plate", &corners.map(|(x, z)| corner(x, z)));
    mesh.welded()
}

/// A head without features, for a label texture: longitude is u with the face at u = 0.5 (+Z), latitude is v.
pub(crate) fn head() -> Mesh {
    const AROUND: usize = 48;
    const DOWN: usize = 32;
    let mut mesh = Mesh::default();
    for j in 0..=DOWN {
        let (sin, cos) = deterministic_f64::sin_cos(j as f64 / DOWN as f64 * core::f64::consts::PI);
        for i in 0..=AROUND {
            let (x, z) = deterministic_f64::sin_cos(
                (i as f64 / AROUND as f64 - 0.5) * core::f64::consts::TAU,
            );
            // Narrower toward the chin.
            let taper = if cos < 0.0 {
                1.0 - 0.22 * cos * cos
            } else {
                1.0
            };
            let mut p = DVec3::new(0.74 * x * sin * taper, cos, 0.84 * z * sin * taper);
            // A nose: a bump on the front, just below the middle.
            let (a, b) = (p.x / 0.14, (p.y + 0.10) / 0.22);
            let bump = 1.0 - a * a - b * b;
            if p.z > 0.0 && bump > 0.0 {
                p.z += 0.16 * bump * bump;
            }
            let u = if j == 0 || j == DOWN {
                (i as f64 + 0.5) / AROUND as f64
            } else {
                i as f64 / AROUND as f64
            };
            mesh.uvs.push([u, 1.0 - j as f64 / DOWN as f64]);
            mesh.positions.push(p);
        }
    }
    // The last column stands where the first one does.
    for j in 0..=DOWN {
        mesh.positions[j * (AROUND + 1) + AROUND] = mesh.positions[j * (AROUND + 1)];
    }
    let mut faces: Vec<Vec<Corner>> = Vec::new();
    for (j, i) in (0..DOWN * AROUND).map(|k| (k / AROUND, k % AROUND)) {
        let corner = |di: usize, dj: usize| {
            let k = (j + dj) * (AROUND + 1) + i + di;
            Corner {
                position: k,
                uv: k,
                normal: k,
            }
        };
        faces.push(match j {
            0 => vec![corner(0, 0), corner(0, 1), corner(1, 1)],
            _ if j == DOWN - 1 => vec![corner(0, 0), corner(0, 1), corner(1, 0)],
            _ => vec![corner(0, 0), corner(0, 1), corner(1, 1), corner(1, 0)],
        });
    }
    mesh.normals = vec![DVec3::Y; mesh.positions.len()];
    mesh.groups.push(("head".into(), faces));
    smooth(mesh.welded())
}

/// A house: four walls and a gable roof, each divided into squares so that a round mapping has vertices to hold on
/// to; every wall shows the picture once.
pub(crate) fn house() -> Mesh {
    const STEPS: usize = 8;
    let at = DVec3::new;
    let mut mesh = Mesh::default();
    let mut panel = |name: &str, corners: [DVec3; 4]| {
        let point = |i: usize, j: usize| {
            let (s, t) = (i as f64 / STEPS as f64, j as f64 / STEPS as f64);
            let low = corners[0] * (1.0 - s) + corners[1] * s;
            let high = corners[3] * (1.0 - s) + corners[2] * s;
            (low * (1.0 - t) + high * t, [s, t])
        };
        for (i, j) in (0..STEPS * STEPS).map(|k| (k % STEPS, k / STEPS)) {
            mesh.polygon(
                name,
                &[
                    point(i, j),
                    point(i + 1, j),
                    point(i + 1, j + 1),
                    point(i, j + 1),
                ],
            );
        }
    };
    // Width 2, depth 1.5, eaves at 1, ridge at 1.75 along x; the middle of the house is the origin's height 0.875.
    let (x, z, eaves, ridge, floor) = (1.0, 0.75, 0.125, 0.875, -0.875);
    panel(
        "front",
        [
            at(-x, floor, z),
            at(x, floor, z),
            at(x, eaves, z),
            at(-x, eaves, z),
        ],
    );
    panel(
        "back",
        [
            at(x, floor, -z),
            at(-x, floor, -z),
            at(-x, eaves, -z),
            at(x, eaves, -z),
        ],
    );
    panel(
        "right",
        [
            at(x, floor, z),
            at(x, floor, -z),
            at(x, eaves, -z),
            at(x, eaves, z),
        ],
    );
    panel(
        "left",
        [
            at(-x, floor, -z),
            at(-x, floor, z),
            at(-x, eaves, z),
            at(-x, eaves, -z),
        ],
    );
    panel(
        "floor",
        [
            at(-x, floor, -z),
            at(x, floor, -z),
            at(x, floor, z),
            at(-x, floor, z),
        ],
    );
    panel(
        "roof_front",
        [
            at(-x, eaves, z),
            at(x, eaves, z),
            at(x, ridge, 0.0),
            at(-x, ridge, 0.0),
        ],
    );
    panel(
        "roof_back",
        [
            at(x, eaves, -z),
            at(-x, eaves, -z),
            at(-x, ridge, 0.0),
            at(x, ridge, 0.0),
        ],
    );
    for side in [x, -x] {
        // A gable: strips that end at the rafters, so that the rim meets the roof's squares vertex to vertex.
        for j in 0..STEPS {
            let (t0, t1) = (j as f64 / STEPS as f64, (j + 1) as f64 / STEPS as f64);
            let rim = |t: f64, far: f64| {
                let p = at(side, eaves * (1.0 - t) + ridge * t, far * z * (1.0 - t));
                (
                    p,
                    [
                        0.5 + 0.5 * far * (1.0 - t) * if side > 0.0 { -1.0 } else { 1.0 },
                        t,
                    ],
                )
            };
            let turn = if side > 0.0 { 1.0 } else { -1.0 };
            let mut strip = vec![rim(t0, turn)];
            if j == 0 {
                // The lower rim carries the vertices of the wall.
                strip.extend((1..STEPS).map(|i| {
                    let share = i as f64 / STEPS as f64;
                    let far = turn * (1.0 - 2.0 * share);
                    (at(side, eaves, far * z), [share, 0.0])
                }));
            }
            strip.extend([rim(t0, -turn), rim(t1, -turn)]);
            if j + 1 < STEPS {
                strip.push(rim(t1, turn));
            }
            mesh.polygon(
                if side > 0.0 {
                    "gable_right"
                } else {
                    "gable_left"
                },
                &strip,
            );
        }
    }
    mesh.welded()
}

/// A box of 1 x 3 x 1, turned by 270 degrees from its lower to its upper end: the "twisty object".
pub(crate) fn twisted_box() -> Mesh {
    const ROWS: usize = 48;
    const COLUMNS: usize = 6;
    let mut mesh = Mesh::default();
    let turned = |p: DVec3| {
        let (sin, cos) =
            deterministic_f64::sin_cos((p.y / 3.0 + 0.5) * 1.5 * core::f64::consts::PI);
        DVec3::new(p.x * cos + p.z * sin, p.y, p.z * cos - p.x * sin)
    };
    let mut panel = |name: &str, rows: usize, place: &dyn Fn(f64, f64) -> DVec3| {
        let point = |i: usize, j: usize| {
            let (s, t) = (i as f64 / COLUMNS as f64, j as f64 / rows as f64);
            (turned(place(s, t)), [s, t])
        };
        for (i, j) in (0..COLUMNS * rows).map(|k| (k % COLUMNS, k / COLUMNS)) {
            mesh.polygon(
                name,
                &[
                    point(i, j),
                    point(i + 1, j),
                    point(i + 1, j + 1),
                    point(i, j + 1),
                ],
            );
        }
    };
    let y = |t: f64| 3.0 * t - 1.5;
    panel("front", ROWS, &|s, t| DVec3::new(s - 0.5, y(t), 0.5));
    panel("right", ROWS, &|s, t| DVec3::new(0.5, y(t), 0.5 - s));
    panel("back", ROWS, &|s, t| DVec3::new(0.5 - s, y(t), -0.5));
    panel("left", ROWS, &|s, t| DVec3::new(-0.5, y(t), s - 0.5));
    panel("top", COLUMNS, &|s, t| DVec3::new(s - 0.5, 1.5, 0.5 - t));
    panel("bottom", COLUMNS, &|s, t| {
        DVec3::new(s - 0.5, -1.5, t - 0.5)
    });
    mesh.welded()
}

/// A solid of revolution from its profile (radius, height), from the top down; v follows the profile.
pub(crate) fn turned(name: &str, profile: &[[f64; 2]]) -> Mesh {
    const AROUND: usize = 32;
    let mut mesh = Mesh::default();
    let last = profile.len() - 1;
    let point = |i: usize, j: usize| {
        let (sin, cos) = deterministic_f64::sin_cos(
            (i % AROUND) as f64 / AROUND as f64 * core::f64::consts::TAU,
        );
        let [r, h] = profile[j];
        (
            DVec3::new(sin * r, h, cos * r),
            [i as f64 / AROUND as f64, 1.0 - j as f64 / last as f64],
        )
    };
    for (j, i) in (0..last * AROUND).map(|k| (k / AROUND, k % AROUND)) {
        let (a, b, c, d) = (
            point(i, j),
            point(i, j + 1),
            point(i + 1, j + 1),
            point(i + 1, j),
        );
        let pole = |p: (DVec3, [f64; 2])| (p.0, [(i as f64 + 0.5) / AROUND as f64, p.1[1]]);
        if profile[j][0] == 0.0 {
            mesh.polygon(name, &[pole(a), b, c]);
        } else if profile[j + 1][0] == 0.0 {
            mesh.polygon(name, &[a, pole(b), d]);
        } else {
            mesh.polygon(name, &[a, b, c, d]);
        }
    }
    mesh.welded()
}

/// Profile of the unit cylinder: caps in rings, side in rows.
pub(crate) fn cylinder_profile() -> Vec<[f64; 2]> {
    let cap = |h: f64| (0..4).map(move |k| [f64::from(k) / 8.0, h]);
    let side = (0..=8).map(|k| [0.5, 0.5 - f64::from(k) / 8.0]);
    cap(0.5)
        .chain(side)
        .chain(cap(-0.5).collect::<Vec<_>>().into_iter().rev())
        .collect()
}

/// Profile of the unit cone: from the apex down, and the base.
pub(crate) fn cone_profile() -> Vec<[f64; 2]> {
    let side = (0..=8).map(|k| [f64::from(k) / 16.0, 0.5 - f64::from(k) / 8.0]);
    side.chain((0..4).rev().map(|k| [f64::from(k) / 8.0, -0.5]))
        .collect()
}

/// Profile of the unit ball.
pub(crate) fn ball_profile() -> Vec<[f64; 2]> {
    let ring = |k: u32| {
        let (sin, cos) = deterministic_f64::sin_cos(f64::from(k) / 16.0 * core::f64::consts::PI);
        [0.5 * sin, 0.5 * cos]
    };
    let mut profile: Vec<[f64; 2]> = (0..=16).map(ring).collect();
    (profile[0][0], profile[16][0]) = (0.0, 0.0);
    profile
}

/// The unit ball in 24 x 16 parts, smooth.
pub(crate) fn coarse_ball() -> Mesh {
    const AROUND: usize = 24;
    const DOWN: usize = 16;
    let mut mesh = Mesh::default();
    let point = |i: usize, j: usize| {
        let (sin, cos) = deterministic_f64::sin_cos(j as f64 / DOWN as f64 * core::f64::consts::PI);
        let (x, z) = deterministic_f64::sin_cos(
            (i % AROUND) as f64 / AROUND as f64 * core::f64::consts::TAU,
        );
        let ring = if j == 0 || j == DOWN { 0.0 } else { 0.5 * sin };
        let uv = [i as f64 / AROUND as f64, 1.0 - j as f64 / DOWN as f64];
        (DVec3::new(x * ring, 0.5 * cos, z * ring), uv)
    };
    for (j, i) in (0..DOWN * AROUND).map(|k| (k / AROUND, k % AROUND)) {
        let (a, b, c, d) = (
            point(i, j),
            point(i, j + 1),
            point(i + 1, j + 1),
            point(i + 1, j),
        );
        match j {
            0 => mesh.polygon("ball", &[a, b, c]),
            _ if j + 1 == DOWN => mesh.polygon("ball", &[a, b, d]),
            _ => mesh.polygon("ball", &[a, b, c, d]),
        }
    }
    smooth(mesh.welded())
}

/// Replaces the normals by the area-weighted mean of the faces around each position.
pub(crate) fn smooth(mut mesh: Mesh) -> Mesh {
    let mut normals = vec![DVec3::ZERO; mesh.positions.len()];
    for face in mesh.groups.iter().flat_map(|(_, faces)| faces) {
        for k in 1..face.len() - 1 {
            let [a, b, c] = [0, k, k + 1].map(|k| mesh.positions[face[k].position]);
            for corner in [0, k, k + 1] {
                normals[face[corner].position] += (b - a).cross(c - a);
            }
        }
    }
    for corner in mesh
        .groups
        .iter_mut()
        .flat_map(|(_, faces)| faces)
        .flatten()
    {
        corner.normal = corner.position;
    }
    mesh.normals = normals.into_iter().map(unit).collect();
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    #[test]
    fn the_solids_are_closed_and_face_outward() {
        let solids = [
            ("cube", cube(), 1.0),
            ("house", house(), 2.0 * 1.5 * 1.0 + 0.5 * 1.5 * 0.75 * 2.0),
            ("twisted box", twisted_box(), 3.0),
            (
                "cylinder",
                turned("c", &cylinder_profile()),
                core::f64::consts::PI / 4.0,
            ),
            (
                "cone",
                turned("c", &cone_profile()),
                core::f64::consts::PI / 12.0,
            ),
            (
                "ball",
                turned("b", &ball_profile()),
                core::f64::consts::PI / 6.0,
            ),
        ];
        for (name, mesh, expected) in solids {
            let mut edges: BTreeMap<(usize, usize), u32> = BTreeMap::new();
            let mut volume = 0.0;
            for face in mesh.groups.iter().flat_map(|(_, faces)| faces) {
                for k in 0..face.len() {
                    let next = face[(k + 1) % face.len()].position;
                    *edges.entry((face[k].position, next)).or_default() += 1;
                }
                for k in 1..face.len() - 1 {
                    let [a, b, c] = [0, k, k + 1].map(|k| mesh.positions[face[k].position]);
                    volume += a.dot(b.cross(c)) / 6.0;
                }
            }
            let open = edges
                .iter()
                .filter(|((a, b), n)| **n != 1 || !edges.contains_key(&(*b, *a)))
                .count();
            assert_eq!(open, 0, "{name}: edges not used once each way");
            assert!(
                (volume / expected - 1.0).abs() < 0.03,
                "{name}: volume {volume}, expected {expected}"
            );
        }
    }
}

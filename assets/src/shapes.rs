//! Plain solids with texture coordinates.

use texmap_math::{det, glam::DVec3};

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

/// A head without features, for a label texture: longitude is u with the face at u = 0.5 (+Z), latitude is v.
pub(crate) fn head() -> Mesh {
    const AROUND: usize = 48;
    const DOWN: usize = 32;
    let mut mesh = Mesh::default();
    for j in 0..=DOWN {
        let (sin, cos) = det::sin_cos(j as f64 / DOWN as f64 * core::f64::consts::PI);
        for i in 0..=AROUND {
            let (x, z) = det::sin_cos((i as f64 / AROUND as f64 - 0.5) * core::f64::consts::TAU);
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

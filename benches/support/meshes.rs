//! Meshes of any size by formula.

use std::f64::consts::{PI, TAU};

use texmap_math::deterministic_f64;
use texmap_math::glam::DVec3;
use texmap_uv::Faces;

/// Positions and faces.
pub type Mesh = (Vec<[f32; 3]>, Faces);

/// A ball of about `triangles` triangles, open at the poles.
pub fn ball(triangles: usize) -> Mesh {
    let down = (((triangles / 4) as f64).sqrt() as u32).max(2);
    let around = 2 * down;
    let mut positions = Vec::new();
    for j in 0..=down {
        let (sin, cos) =
            deterministic_f64::sin_cos((f64::from(j) + 0.5) / (f64::from(down) + 1.0) * PI);
        for i in 0..around {
            let (z, x) = deterministic_f64::sin_cos(f64::from(i) / f64::from(around) * TAU);
            positions.push([sin * x, cos, -sin * z].map(|c| c as f32));
        }
    }
    let at = |j: u32, i: u32| j * around + i % around;
    (positions, grid(down, around, at))
}

/// A trefoil knot of about `triangles` triangles with lumps on its skin: closed, and curved both ways.
pub fn knot(triangles: usize) -> Mesh {
    let across = (((triangles / 2) as f64 / 10.0).sqrt() as u32).max(8);
    let along = across * 10;
    // (2, 3) torus knot.
    let middle = |t: f64| {
        let ((s2, c2), (s3, c3)) = (
            deterministic_f64::sin_cos(2.0 * t),
            deterministic_f64::sin_cos(3.0 * t),
        );
        DVec3::new((2.0 + c3) * c2, s3, (2.0 + c3) * s2)
    };
    let mut positions = Vec::new();
    for i in 0..along {
        let t = f64::from(i) / f64::from(along) * TAU;
        let (here, next) = (middle(t), middle(t + 1e-4));
        let ahead = (next - here) / (next - here).dot(next - here).sqrt();
        // Across the knot: away from the torus' ring.
        let (s2, c2) = deterministic_f64::sin_cos(2.0 * t);
        let out = here - DVec3::new(2.0 * c2, 0.0, 2.0 * s2);
        let side = ahead.cross(out);
        let side = side / side.dot(side).sqrt();
        let up = side.cross(ahead);
        for j in 0..across {
            let a = f64::from(j) / f64::from(across) * TAU;
            let (sin, cos) = deterministic_f64::sin_cos(a);
            let lump =
                1.0 + 0.15 * deterministic_f64::sin(24.0 * t) * deterministic_f64::sin(3.0 * a);
            let p = here + (side * cos + up * sin) * (0.45 * lump);
            positions.push(p.to_array().map(|c| c as f32));
        }
    }
    let at = |i: u32, j: u32| (i % along) * across + j % across;
    (positions, grid(along, across, at))
}

/// Two triangles for each cell of `rows` x `columns`.
fn grid(rows: u32, columns: u32, at: impl Fn(u32, u32) -> u32) -> Faces {
    let cells = (0..rows).flat_map(|j| (0..columns).map(move |i| (j, i)));
    let triangles: Vec<[u32; 3]> = cells
        .flat_map(|(j, i)| {
            let [a, b, c, d] = [at(j, i), at(j + 1, i), at(j + 1, i + 1), at(j, i + 1)];
            [[a, b, c], [a, c, d]]
        })
        .collect();
    Faces::from_triangles(&triangles)
}

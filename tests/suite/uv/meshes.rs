//! Meshes with known answers.

use texmap_math::deterministic_f64;
use texmap_uv::Faces;

/// A ball of radius `radius` by longitude and latitude, without split vertices and with one vertex at each pole.
pub(crate) fn ball(around: u32, down: u32, radius: f64) -> (Vec<[f32; 3]>, Faces) {
    let mut positions = vec![[0.0, radius as f32, 0.0]];
    for j in 1..down {
        let (sin, cos) =
            deterministic_f64::sin_cos(f64::from(j) / f64::from(down) * std::f64::consts::PI);
        for i in 0..around {
            let (z, x) = deterministic_f64::sin_cos(
                f64::from(i) / f64::from(around) * std::f64::consts::TAU,
            );
            positions.push([radius * sin * x, radius * cos, -radius * sin * z].map(|c| c as f32));
        }
    }
    positions.push([0.0, -radius as f32, 0.0]);
    let ring = |j: u32, i: u32| 1 + (j - 1) * around + i % around;
    let mut triangles = Vec::new();
    for i in 0..around {
        triangles.push([0, ring(1, i), ring(1, i + 1)]);
        for j in 1..down - 1 {
            triangles.push([ring(j, i), ring(j + 1, i), ring(j + 1, i + 1)]);
            triangles.push([ring(j, i), ring(j + 1, i + 1), ring(j, i + 1)]);
        }
        triangles.push([
            ring(down - 1, i),
            positions.len() as u32 - 1,
            ring(down - 1, i + 1),
        ]);
    }
    (positions, Faces::from_triangles(&triangles))
}

/// The side of a cylinder of radius `radius` and height `height` around y.
pub(crate) fn tube(around: u32, rows: u32, radius: f64, height: f64) -> (Vec<[f32; 3]>, Faces) {
    let (mut positions, mut faces) = (Vec::new(), Faces::new());
    for j in 0..=rows {
        for i in 0..around {
            let (z, x) = deterministic_f64::sin_cos(
                f64::from(i) / f64::from(around) * std::f64::consts::TAU,
            );
            let y = height * (f64::from(j) / f64::from(rows) - 0.5);
            positions.push([radius * x, y, -radius * z].map(|c| c as f32));
        }
    }
    for (j, i) in (0..rows * around).map(|k| (k / around, k % around)) {
        let at = |dj: u32, di: u32| (j + dj) * around + (i + di) % around;
        faces.push(&[at(0, 0), at(0, 1), at(1, 1), at(1, 0)]);
    }
    (positions, faces)
}

/// A square of `cells` x `cells` in x and y whose height z grows with x by `slope`.
pub(crate) fn ramp(cells: u32, slope: f64) -> (Vec<[f32; 3]>, Faces) {
    let (mut positions, mut faces) = (Vec::new(), Faces::new());
    for (j, i) in (0..=cells).flat_map(|j| (0..=cells).map(move |i| (j, i))) {
        let (x, y) = (
            f64::from(i) / f64::from(cells),
            f64::from(j) / f64::from(cells),
        );
        positions.push([x as f32, y as f32, (slope * x) as f32]);
    }
    for (j, i) in (0..cells).flat_map(|j| (0..cells).map(move |i| (j, i))) {
        let at = |dj: u32, di: u32| (j + dj) * (cells + 1) + i + di;
        faces.push(&[at(0, 0), at(0, 1), at(1, 1), at(1, 0)]);
    }
    (positions, faces)
}

//! Meshes of simple shapes: quads, cubes and spheres, each with texture coordinates from the top left.

use texmap_math::deterministic_f64;
use texmap_math::glam::DVec3;

use crate::Mesh;

impl Mesh {
    /// A quad from its corners: top left, then clockwise as one looks at it. It carries the whole texture once.
    #[must_use]
    pub fn quad(corners: [[f32; 3]; 4]) -> Self {
        let mut mesh = Self::default();
        mesh.push_quad(corners);
        mesh
    }

    /// A cube of edge 2 about the origin. Each side carries the whole texture once; faces are numbered front (+Z), right, back, left, top,
    /// bottom.
    #[must_use]
    pub fn cube() -> Self {
        let sides = [
            (DVec3::Z, DVec3::X, DVec3::Y),
            (DVec3::X, DVec3::NEG_Z, DVec3::Y),
            (DVec3::NEG_Z, DVec3::NEG_X, DVec3::Y),
            (DVec3::NEG_X, DVec3::Z, DVec3::Y),
            (DVec3::Y, DVec3::X, DVec3::NEG_Z),
            (DVec3::NEG_Y, DVec3::X, DVec3::Z),
        ];
        let mut mesh = Self::default();
        for (out, right, up) in sides {
            let corners = [
                out - right + up,
                out + right + up,
                out + right - up,
                out - right - up,
            ];
            mesh.push_quad(corners.map(|p| p.as_vec3().to_array()));
        }
        mesh
    }

    /// A sphere of radius 1 about the origin, with normals. `columns` x `rows` patches, at least 3 x 2, around the y axis.
    ///
    /// u runs left to right as seen from outside: -Z at 0, -X at 1/4, +Z at 1/2, +X at 3/4. v is 0 at the upper pole and 1 at the lower;
    /// a pole has a vertex for each triangle, with the u of the middle of that.
    #[must_use]
    pub fn sphere(columns: u32, rows: u32) -> Self {
        let (columns, rows) = (columns.max(3), rows.max(2));
        let mut mesh = Self::default();
        for j in 0..=rows {
            let v = f64::from(j) / f64::from(rows);
            let (sin, cos) = deterministic_f64::sin_cos(v * std::f64::consts::PI);
            // Exact poles, so that the patches there close.
            let sin = if j == 0 || j == rows { 0.0 } else { sin };
            for i in 0..=columns {
                let u = f64::from(i) / f64::from(columns);
                // Exact seam: the last column lies on the first.
                let (s, c) = deterministic_f64::sin_cos(
                    f64::from(i % columns) / f64::from(columns) * std::f64::consts::TAU,
                );
                let at_pole = j == 0 || j == rows;
                let half = if at_pole {
                    0.5 / f64::from(columns)
                } else {
                    0.0
                };
                let p = DVec3::new(-sin * s, cos, -sin * c).as_vec3().to_array();
                mesh.positions.push(p);
                mesh.normals.push(p);
                mesh.uvs.push([(u + half) as f32, v as f32]);
            }
        }
        let vertex = |i: u32, j: u32| j * (columns + 1) + i;
        for (j, i) in (0..rows).flat_map(|j| (0..columns).map(move |i| (j, i))) {
            let [a, b, c, d] = [
                vertex(i, j),
                vertex(i, j + 1),
                vertex(i + 1, j + 1),
                vertex(i + 1, j),
            ];
            let triangles = match j {
                0 => &[[a, b, c]][..],
                j if j + 1 == rows => &[[a, b, d]],
                _ => &[[a, b, c], [a, c, d]],
            };
            mesh.triangles.extend(triangles);
            mesh.faces.extend(triangles.iter().map(|_| j * columns + i));
        }
        mesh
    }

    fn push_quad(&mut self, corners: [[f32; 3]; 4]) {
        let first = self.positions.len() as u32;
        let face = self.faces.last().map_or(0, |face| face + 1);
        self.positions.extend(corners);
        self.uvs
            .extend([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]);
        self.triangles
            .extend([[0, 3, 2], [0, 2, 1]].map(|t: [u32; 3]| t.map(|i| first + i)));
        self.faces.extend([face; 2]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use texmap_math::wide;

    /// Fronts look away from the origin, surfaces are closed, and u grows to the right as one looks at a front.
    #[test]
    fn shapes_are_closed_and_face_outwards() {
        for (mesh, triangles) in [(Mesh::cube(), 12), (Mesh::sphere(8, 4), 48)] {
            assert_eq!(mesh.triangles.len(), triangles);
            assert_eq!(mesh.faces.len(), triangles);
            let mut volume = 0.0;
            for t in &mesh.triangles {
                let [a, b, c] = t.map(|v| wide(mesh.positions[v as usize]));
                assert!((a + b + c).dot(mesh.cross(*t)) > 0.0);
                volume += a.dot(b.cross(c)) / 6.0;
                let [p, q, r] = t.map(|v| mesh.uvs[v as usize]);
                let turn = (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
                // v grows down: counter-clockwise on the surface is clockwise in u and v.
                assert!(turn < 0.0, "{p:?} {q:?} {r:?}");
            }
            assert!(volume > 2.5 && volume < 8.001, "{volume}");
        }
    }

    #[test]
    fn quads_face_their_viewer() {
        let quad = Mesh::quad([
            [-1.0, 1.0, 0.0],
            [1.0, 1.0, 0.0],
            [1.0, -1.0, 0.0],
            [-1.0, -1.0, 0.0],
        ]);
        assert!(quad.triangles.iter().all(|t| quad.cross(*t).z > 0.0));
        assert_eq!(quad.faces, [0, 0]);
    }
}

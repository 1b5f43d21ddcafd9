//! Shapes that shadow maps get wrong: a ball with bumps and a terrain with creases.

use texmap_math::deterministic_f64;
use texmap_math::glam::DVec3;
use texmap_scene::Mesh;

use crate::shadow_scene::ShadowScene;

impl ShadowScene {
    /// A ball with shallow bumps over the floor; its columns and rows are its coordinates.
    pub fn bumpy_ball() -> Self {
        let (around, rows) = (96u32, 48u32);
        let turn = |i: u32, n: u32| {
            deterministic_f64::sin_cos(f64::from(i) / f64::from(n) * std::f64::consts::TAU)
        };
        let mut mesh = Mesh {
            name: "ball".into(),
            ..Mesh::default()
        };
        for (j, i) in (0..=rows).flat_map(|j| (0..=around).map(move |i| (j, i))) {
            let ((sin, cos), (out, up)) = (turn(i % around, around), turn(j, 2 * rows));
            let d = DVec3::new(out * cos, out * sin, up);
            let wave = |x: f64| deterministic_f64::sin_cos(x).0;
            let bump = wave(9.0 * d.x) + wave(11.0 * d.y + 1.0) * wave(7.0 * d.z + 0.5);
            let p = d * (0.45 * (1.0 + 0.04 * bump)) + DVec3::Z * 0.5;
            mesh.positions.push(p.as_vec3().to_array());
            mesh.uvs
                .push([i as f32 / around as f32, j as f32 / rows as f32]);
        }
        for (j, i) in (0..rows).flat_map(|j| (0..around).map(move |i| (j, i))) {
            let at = |j: u32, i: u32| j * (around + 1) + i;
            let (a, b) = (at(j, i), at(j, i + 1));
            let (c, d) = (at(j + 1, i + 1), at(j + 1, i));
            if j + 1 < rows {
                mesh.triangles.push([a, d, c]);
            }
            if j > 0 {
                mesh.triangles.push([a, c, b]);
            }
        }
        Self::of(vec![mesh])
    }

    /// Hills of large flat facets with creases between them, instead of the floor.
    pub fn terrain() -> Self {
        let cells = 24u32;
        let place = |i: u32| f64::from(i) / f64::from(cells) * 4.0 - 2.0;
        let mut mesh = Mesh {
            name: "terrain".into(),
            ..Mesh::default()
        };
        for (y, x) in (0..=cells).flat_map(|j| (0..=cells).map(move |i| (place(j), place(i)))) {
            let wave = |x: f64| deterministic_f64::sin_cos(x).0;
            let height = wave(2.1 * x + 0.7) * wave(1.7 * y) + 0.4 * wave(5.3 * x - 3.1 * y);
            let z = 0.25 * height.abs();
            mesh.positions.push([x as f32, y as f32, z as f32]);
        }
        for (j, i) in (0..cells).flat_map(|j| (0..cells).map(move |i| (j, i))) {
            let at = |j: u32, i: u32| j * (cells + 1) + i;
            let (a, b) = (at(j, i), at(j, i + 1));
            let (c, d) = (at(j + 1, i + 1), at(j + 1, i));
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
        Self::of_meshes(vec![mesh])
    }
}

//! Meshes of the benchmark scenes: position, normal, texture coordinate and tangent a vertex.

use texmap_math::deterministic_f64::sin_cos;

/// Width of the colour target in pixels.
pub const WIDTH: u32 = 1920;
/// Height of the colour target in pixels.
pub const HEIGHT: u32 = 1080;

/// A triangle mesh as separate arrays of equal length, one entry a vertex.
#[derive(Clone, Debug, Default)]
pub struct BenchMesh {
    /// Object (or clip) space positions.
    pub positions: Vec<[f32; 3]>,
    /// Unit normals.
    pub normals: Vec<[f32; 3]>,
    /// Texture coordinates; v = 0 is the first row of the texture.
    pub uvs: Vec<[f32; 2]>,
    /// Unit tangents.
    pub tangents: Vec<[f32; 3]>,
    /// Counter-clockwise triangles.
    pub triangles: Vec<[u32; 3]>,
}

impl BenchMesh {
    fn push(&mut self, position: [f64; 3], normal: [f64; 3], uv: [f64; 2], tangent: [f64; 3]) {
        self.positions.push(position.map(|c| c as f32));
        self.normals.push(normal.map(|c| c as f32));
        self.uvs.push(uv.map(|c| c as f32));
        self.tangents.push(tangent.map(|c| c as f32));
    }

    fn quad(&mut self) {
        let n = self.positions.len() as u32 - 4;
        self.triangles
            .extend([[n, n + 1, n + 2], [n, n + 2, n + 3]]);
    }
}

/// A square floor of half-side `e` at y = 0 with uv = k (x, z).
#[must_use]
pub fn floor(e: f64, k: f64) -> BenchMesh {
    let mut mesh = BenchMesh::default();
    for (x, z) in [(-e, e), (e, e), (e, -e), (-e, -e)] {
        mesh.push(
            [x, 0.0, z],
            [0.0, 1.0, 0.0],
            [k * x, k * z],
            [1.0, 0.0, 0.0],
        );
    }
    mesh.quad();
    mesh
}

/// The unit sphere of `sectors` x `stacks`, counter-clockwise seen from outside.
#[must_use]
pub fn sphere(sectors: u32, stacks: u32) -> BenchMesh {
    let mut mesh = BenchMesh::default();
    for i in 0..=stacks {
        let (st, ct) = sin_cos(core::f64::consts::PI * f64::from(i) / f64::from(stacks));
        for j in 0..=sectors {
            let (sp, cp) = sin_cos(core::f64::consts::TAU * f64::from(j) / f64::from(sectors));
            let p = [st * sp, ct, st * cp];
            let uv = [
                4.0 * f64::from(j) / f64::from(sectors),
                2.0 * f64::from(i) / f64::from(stacks),
            ];
            mesh.push(p, p, uv, [cp, 0.0, -sp]);
        }
    }
    for i in 0..stacks {
        for j in 0..sectors {
            let a = i * (sectors + 1) + j;
            let b = a + sectors + 1;
            if i != 0 {
                mesh.triangles.push([a, b, a + 1]);
            }
            if i != stacks - 1 {
                mesh.triangles.push([a + 1, b, b + 1]);
            }
        }
    }
    mesh
}

/// Eight full-screen quads in clip space, farthest first, each with its own turn and scale of uv.
/// z is GL clip depth (-1 near, 1 far).
#[must_use]
pub fn layers() -> BenchMesh {
    let mut mesh = BenchMesh::default();
    for l in 0..8 {
        let l = f64::from(l);
        let (sin, cos) = sin_cos(0.1 * l);
        let scale = (0.6 + 0.2 * l) / 1024.0;
        for (x, y) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
            let px = if x > 0.0 { f64::from(WIDTH) } else { 0.0 };
            let py = if y > 0.0 { f64::from(HEIGHT) } else { 0.0 };
            mesh.push(
                [x, y, 0.8 - 0.2 * l],
                [0.0, 0.0, 1.0],
                [scale * (cos * px - sin * py), scale * (sin * px + cos * py)],
                [1.0, 0.0, 0.0],
            );
        }
        mesh.quad();
    }
    mesh
}

/// Eight full-screen quads in clip space at z = 0 with uv inside 0..1.
#[must_use]
pub fn rects() -> BenchMesh {
    let mut mesh = BenchMesh::default();
    for l in 0..8 {
        let s = 1.0 - f64::from(l) / 16.0;
        for (x, y) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
            let uv = [if x > 0.0 { s } else { 0.0 }, if y > 0.0 { s } else { 0.0 }];
            mesh.push([x, y, 0.0], [0.0, 0.0, 1.0], uv, [1.0, 0.0, 0.0]);
        }
        mesh.quad();
    }
    mesh
}

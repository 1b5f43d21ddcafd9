//! Geometry and cameras of the yardstick scenes, to the pixel those that llvmpipe draws.
use texmap_math::deterministic_f64::{sin_cos, tan};
use texmap_math::glam::{DMat4, DVec3, DVec4};

/// The unit sphere of the mesh scenes: `slices` x `stacks` cells, counter-clockwise outside.
#[derive(Debug, Clone, Default)]
pub struct Sphere {
    /// Positions, which are the normals too.
    pub positions: Vec<[f32; 3]>,
    /// u and v of each vertex: four repeats around, two from pole to pole.
    pub uvs: Vec<f32>,
    /// Triangles.
    pub indices: Vec<[u32; 3]>,
}

impl Sphere {
    /// Vertex i * (slices + 1) + j lies at th = pi i / stacks, ph = 2 pi j / slices.
    #[must_use]
    pub fn new(slices: u32, stacks: u32) -> Self {
        let mut sphere = Self::default();
        let pi = std::f64::consts::PI;
        for i in 0..=stacks {
            let (st, ct) = sin_cos(pi * f64::from(i) / f64::from(stacks));
            for j in 0..=slices {
                let (sp, cp) = sin_cos(2.0 * pi * f64::from(j) / f64::from(slices));
                sphere
                    .positions
                    .push([(st * sp) as f32, ct as f32, (st * cp) as f32]);
                sphere
                    .uvs
                    .push((4.0 * f64::from(j) / f64::from(slices)) as f32);
                sphere
                    .uvs
                    .push((2.0 * f64::from(i) / f64::from(stacks)) as f32);
            }
        }
        for i in 0..stacks {
            for j in 0..slices {
                let a = i * (slices + 1) + j;
                let b = a + slices + 1;
                if i > 0 {
                    sphere.indices.push([a, b, a + 1]);
                }
                if i < stacks - 1 {
                    sphere.indices.push([a + 1, b, b + 1]);
                }
            }
        }
        sphere
    }
}

/// OpenGL clip depth -w..w to reversed 0..w: z' = (w - z) / 2.
fn reversed() -> DMat4 {
    DMat4::from_cols(
        DVec4::X,
        DVec4::Y,
        DVec4::new(0.0, 0.0, -0.5, 0.0),
        DVec4::new(0.0, 0.0, 0.5, 1.0),
    )
}

fn perspective(fov_y: f64, aspect: f64, near: f64, far: f64) -> DMat4 {
    let f = 1.0 / tan(fov_y / 2.0);
    DMat4::from_cols(
        DVec4::new(f / aspect, 0.0, 0.0, 0.0),
        DVec4::new(0.0, f, 0.0, 0.0),
        DVec4::new(0.0, 0.0, (far + near) / (near - far), -1.0),
        DVec4::new(0.0, 0.0, 2.0 * far * near / (near - far), 0.0),
    )
}

fn orthographic(half: f64, near: f64, far: f64) -> DMat4 {
    DMat4::from_cols(
        DVec4::new(1.0 / half, 0.0, 0.0, 0.0),
        DVec4::new(0.0, 1.0 / half, 0.0, 0.0),
        DVec4::new(0.0, 0.0, 2.0 / (near - far), 0.0),
        DVec4::new(0.0, 0.0, (far + near) / (near - far), 1.0),
    )
}

/// rotX(30 degrees) * rotY(40 degrees).
fn model() -> DMat4 {
    let degrees = std::f64::consts::PI / 180.0;
    let ((sx, cx), (sy, cy)) = (sin_cos(30.0 * degrees), sin_cos(40.0 * degrees));
    let x = DMat4::from_cols(
        DVec4::X,
        DVec4::new(0.0, cx, sx, 0.0),
        DVec4::new(0.0, -sx, cx, 0.0),
        DVec4::W,
    );
    let y = DMat4::from_cols(
        DVec4::new(cy, 0.0, -sy, 0.0),
        DVec4::Y,
        DVec4::new(sy, 0.0, cy, 0.0),
        DVec4::W,
    );
    x * y
}

/// Clip from object of the mesh scenes: 1920x1080, 60 degrees from top to bottom, the eye at z = 1.7344.
#[must_use]
pub fn mesh_camera() -> DMat4 {
    let view = DMat4::from_translation(DVec3::new(0.0, 0.0, -1.7344));
    let fov = std::f64::consts::FRAC_PI_3;
    reversed() * perspective(fov, 16.0 / 9.0, 0.1, 100.0) * view * model()
}

/// Clip from object of the depth scenes: 2048x2048, orthographic.
#[must_use]
pub fn depth_camera() -> DMat4 {
    let view = DMat4::from_translation(DVec3::new(0.0, 0.0, -2.0));
    reversed() * orthographic(1.1442, 0.5, 4.0) * view * model()
}

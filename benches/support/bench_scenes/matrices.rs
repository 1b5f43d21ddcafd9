//! GL-convention matrices of the benchmark scenes.
//!
//! Computed in f64, stored as f32, products summed in f64 and rounded to f32, so that every
//! renderer in a race multiplies by the same numbers. Column-major; clip depth -w..w.

use texmap_math::deterministic_f64::{sin_cos, tan};
use texmap_math::glam::{DMat4, DVec4};

/// A column-major 4x4 matrix of f32.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GlMatrix(pub [f32; 16]);

impl GlMatrix {
    /// The identity.
    pub const IDENTITY: Self = {
        let mut m = [0.0; 16];
        m[0] = 1.0;
        m[5] = 1.0;
        m[10] = 1.0;
        m[15] = 1.0;
        Self(m)
    };

    /// Clip coordinates 0..1: the map from -1..1 in x, y and z.
    #[must_use]
    pub fn bias() -> Self {
        Self::from_columns([
            [0.5, 0.0, 0.0, 0.0],
            [0.0, 0.5, 0.0, 0.0],
            [0.0, 0.0, 0.5, 0.0],
            [0.5, 0.5, 0.5, 1.0],
        ])
    }

    /// gluPerspective: vertical field of view in degrees, width / height, near, far.
    #[must_use]
    pub fn perspective(fov_y: f64, aspect: f64, near: f64, far: f64) -> Self {
        let t = 1.0 / tan(fov_y.to_radians() / 2.0);
        Self::from_columns([
            [t / aspect, 0.0, 0.0, 0.0],
            [0.0, t, 0.0, 0.0],
            [0.0, 0.0, (far + near) / (near - far), -1.0],
            [0.0, 0.0, 2.0 * far * near / (near - far), 0.0],
        ])
    }

    /// glOrtho(-hx, hx, -hy, hy, near, far).
    #[must_use]
    pub fn orthographic(hx: f64, hy: f64, near: f64, far: f64) -> Self {
        Self::from_columns([
            [1.0 / hx, 0.0, 0.0, 0.0],
            [0.0, 1.0 / hy, 0.0, 0.0],
            [0.0, 0.0, 2.0 / (near - far), 0.0],
            [0.0, 0.0, (far + near) / (near - far), 1.0],
        ])
    }

    /// gluLookAt with up = +Y; the view must not be vertical.
    #[must_use]
    pub fn look_at(eye: [f64; 3], target: [f64; 3]) -> Self {
        let norm = |v: [f64; 3]| {
            let l = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
            v.map(|c| c / l)
        };
        let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let f = norm([target[0] - eye[0], target[1] - eye[1], target[2] - eye[2]]);
        let s = norm([-f[2], 0.0, f[0]]);
        let u = [
            s[1] * f[2] - s[2] * f[1],
            s[2] * f[0] - s[0] * f[2],
            s[0] * f[1] - s[1] * f[0],
        ];
        Self::from_columns([
            [s[0], u[0], -f[0], 0.0],
            [s[1], u[1], -f[1], 0.0],
            [s[2], u[2], -f[2], 0.0],
            [-dot(s, eye), -dot(u, eye), dot(f, eye), 1.0],
        ])
    }

    /// Rotation about +X by degrees.
    #[must_use]
    pub fn rotate_x(degrees: f64) -> Self {
        let (s, c) = sin_cos(degrees.to_radians());
        Self::from_columns([
            [1.0, 0.0, 0.0, 0.0],
            [0.0, c, s, 0.0],
            [0.0, -s, c, 0.0],
            [0.0, 0.0, 0.0, 1.0],
        ])
    }

    /// Rotation about +Y by degrees.
    #[must_use]
    pub fn rotate_y(degrees: f64) -> Self {
        let (s, c) = sin_cos(degrees.to_radians());
        Self::from_columns([
            [c, 0.0, -s, 0.0],
            [0.0, 1.0, 0.0, 0.0],
            [s, 0.0, c, 0.0],
            [0.0, 0.0, 0.0, 1.0],
        ])
    }

    /// Translation.
    #[must_use]
    pub fn translate(x: f64, y: f64, z: f64) -> Self {
        let mut m = Self::IDENTITY;
        m.0[12] = x as f32;
        m.0[13] = y as f32;
        m.0[14] = z as f32;
        m
    }

    /// `self * other`, summed in f64 and rounded to f32.
    #[must_use]
    pub fn then_after(&self, other: &Self) -> Self {
        let mut out = [0.0; 16];
        for (i, value) in out.iter_mut().enumerate() {
            let (column, row) = (i / 4, i % 4);
            let mut sum = 0.0;
            for k in 0..4 {
                sum += f64::from(self.0[k * 4 + row]) * f64::from(other.0[column * 4 + k]);
            }
            *value = sum as f32;
        }
        Self(out)
    }

    /// The same map into texmap's clip space: reversed depth 0..w by z' = (w - z) / 2.
    #[must_use]
    pub fn reversed_depth(&self) -> DMat4 {
        let mut columns = [DVec4::ZERO; 4];
        for (i, column) in columns.iter_mut().enumerate() {
            let c: [f64; 4] = core::array::from_fn(|k| f64::from(self.0[i * 4 + k]));
            *column = DVec4::new(c[0], c[1], (c[3] - c[2]) / 2.0, c[3]);
        }
        DMat4::from_cols(columns[0], columns[1], columns[2], columns[3])
    }

    fn from_columns(columns: [[f64; 4]; 4]) -> Self {
        Self(core::array::from_fn(|i| columns[i / 4][i % 4] as f32))
    }
}

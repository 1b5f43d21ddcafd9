use texmap_math::{deterministic_f64, footprint::Footprint};

/// Scale, then turn, then shift of texture coordinates (KHR_texture_transform).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UvTransform {
    /// Added last.
    pub offset: [f32; 2],
    /// Applied first.
    pub scale: [f32; 2],
    /// Radians, counter-clockwise as seen in an image whose v grows downward:
    /// `u' = u cos + v sin`, `v' = v cos - u sin`.
    pub rotation: f32,
}

impl Default for UvTransform {
    fn default() -> Self {
        Self {
            offset: [0.0; 2],
            scale: [1.0; 2],
            rotation: 0.0,
        }
    }
}

impl UvTransform {
    /// The rows `[a, b, c]` of the affine map: `u' = a u + b v + c`.
    pub fn rows(&self) -> [[f32; 3]; 2] {
        let (sin, cos) = if self.rotation == 0.0 {
            (0.0, 1.0)
        } else {
            deterministic_f64::sin_cos(f64::from(self.rotation))
        };
        let (sin, cos) = (sin as f32, cos as f32);
        let [sx, sy] = self.scale;
        [
            [sx * cos, sy * sin, self.offset[0]],
            [-sx * sin, sy * cos, self.offset[1]],
        ]
    }

    /// Moves a coordinate.
    pub fn apply(&self, uv: [f32; 2]) -> [f32; 2] {
        self.rows().map(|[a, b, c]| a * uv[0] + b * uv[1] + c)
    }

    /// Moves the derivatives that belong to a coordinate.
    pub fn apply_footprint(&self, d: Footprint) -> Footprint {
        let [[a, b, _], [c, e, _]] = self.rows();
        Footprint {
            du_dx: a * d.du_dx + b * d.dv_dx,
            dv_dx: c * d.du_dx + e * d.dv_dx,
            du_dy: a * d.du_dy + b * d.dv_dy,
            dv_dy: c * d.du_dy + e * d.dv_dy,
        }
    }
}

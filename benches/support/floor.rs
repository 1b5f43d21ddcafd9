//! Perspective floors of 1920x1080 pixels as planes of u w, v w and w, evaluated sixteen pixels at a time.

use texmap_math::deterministic_f64;
use texmap_math::fearless_simd::{f32x16, prelude::*};
use texmap_math::lanes::iota;

/// Columns of the picture.
pub const WIDTH: usize = 1920;
/// Rows of the picture.
pub const HEIGHT: usize = 1080;
/// Pixels of a tile's side: pictures are drawn tile by tile.
pub const TILE: usize = 64;

/// A floor that fills the picture: each plane is (constant, per column, per row).
#[derive(Clone, Copy, Debug)]
pub struct Floor {
    u: [f32; 3],
    v: [f32; 3],
    w: [f32; 3],
}

/// Coordinates of sixteen pixels, and w.
#[derive(Clone, Copy)]
pub struct Places<S: Simd> {
    /// Texture coordinates.
    pub u: f32x16<S>,
    /// Texture coordinates.
    pub v: f32x16<S>,
    w: f32x16<S>,
}

impl<S: Simd> std::fmt::Debug for Places<S> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Places")
    }
}

impl Floor {
    /// Seen from height 1 by a camera of 60 degrees from top to bottom, turned by `yaw` degrees, whose
    /// 1/w grows by `ratio` from the bottom row to the top; `repeats` copies of the texture a unit.
    #[must_use]
    pub fn new(ratio: f64, repeats: f64, yaw: f64) -> Self {
        let half = deterministic_f64::tan(std::f64::consts::PI / 6.0);
        // -d.y of a ray runs from sin - half cos (top) to sin + half cos (bottom).
        let slope = half * (ratio + 1.0) / (ratio - 1.0);
        let pitch = deterministic_f64::atan2(slope, 1.0);
        let (sp, cp) = deterministic_f64::sin_cos(pitch);
        let (sy, cy) = deterministic_f64::sin_cos(yaw.to_radians());
        let forward = [sy * cp, -sp, -cy * cp];
        let right = [cy, 0.0, sy];
        let up = [sy * sp, cp, -cy * sp];
        let step = 2.0 * half / HEIGHT as f64;
        let plane = |k: usize, scale: f64| {
            let corner = forward[k] - right[k] * half * WIDTH as f64 / HEIGHT as f64 + up[k] * half;
            [
                corner + 0.5 * step * (right[k] - up[k]),
                right[k] * step,
                -up[k] * step,
            ]
            .map(|c| (c * scale) as f32)
        };
        Self {
            u: plane(0, repeats),
            v: plane(2, repeats),
            w: plane(1, -1.0),
        }
    }

    /// The yardsticks: all magnified or nearly; half magnified (at 1024 texels); four times as dense.
    #[must_use]
    pub fn near() -> Self {
        Self::new(4.0, 0.25, 25.0)
    }

    /// See [`Floor::near`].
    #[must_use]
    pub fn far() -> Self {
        Self::new(28.0, 0.21, 25.0)
    }

    /// See [`Floor::near`].
    #[must_use]
    pub fn far1() -> Self {
        Self::new(28.0, 0.84, 25.0)
    }

    /// The pixels `x..x + 16` of row `y`, one exact division each.
    #[inline(always)]
    pub fn places<S: Simd>(&self, s: S, x: usize, y: usize) -> Places<S> {
        let column = iota(s).to_float::<f32x16<S>>() + x as f32;
        let row = y as f32;
        let plane = |[c, dx, dy]: [f32; 3]| column * dx + (c + dy * row);
        let r = f32x16::splat(s, 1.0) / plane(self.w);
        Places {
            u: plane(self.u) * r,
            v: plane(self.v) * r,
            w: r,
        }
    }

    /// du/dx, dv/dx, du/dy, dv/dy of the same pixels, by the quotient rule.
    #[inline(always)]
    pub fn slopes<S: Simd>(&self, p: &Places<S>) -> [f32x16<S>; 4] {
        let ([_, ux, uy], [_, vx, vy], [_, wx, wy]) = (self.u, self.v, self.w);
        [
            (ux - p.u * wx) * p.w,
            (vx - p.v * wx) * p.w,
            (uy - p.u * wy) * p.w,
            (vy - p.v * wy) * p.w,
        ]
    }
}

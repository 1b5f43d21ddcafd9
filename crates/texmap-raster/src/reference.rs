//! The obvious f64 and integer forms, one sample at a time, for tests and for reading.
use texmap_math::edge::TriangleEdges;
use texmap_math::fixed::{FixedPoint, snap_point};
use texmap_math::glam::{DVec2, DVec4};

use crate::TargetSize;

/// The pixel position of a clip-space vertex snapped to 1/256 pixel, y down. `None` for w <= 0 and far outside.
#[must_use]
pub fn snap(clip: DVec4, size: TargetSize) -> Option<FixedPoint> {
    if clip.w.is_nan() || clip.w <= 0.0 {
        return None;
    }
    let x = (clip.x + clip.w) * (0.5 * f64::from(size.width())) / clip.w;
    let y = (clip.w - clip.y) * (0.5 * f64::from(size.height())) / clip.w;
    snap_point(DVec2::new(x, y))
}

/// True if the snapped triangle covers a pixel's centre, by exact edge functions and the top-left rule. Positions are within 2^29, pixels
/// within 2^21, as [`snap`] gives them.
#[must_use]
pub fn covers(triangle: [FixedPoint; 3], x: i32, y: i32) -> bool {
    TriangleEdges::new(triangle).is_some_and(|t| t.covers(FixedPoint::pixel_centre(x, y)))
}

/// Weights over the vertices, adding to 1, of the point of the triangle's plane that is seen at pixel position (`x`, `y`).
/// Vertices behind the eye are welcome. `None` where the plane is seen edge-on or not at all.
///
/// The point P = sum b_i V_i is seen at (nx, ny) when P.x = nx P.w and P.y = ny P.w: two linear conditions on b.
#[must_use]
pub fn weights(clip: &[DVec4; 3], size: TargetSize, x: f64, y: f64) -> Option<[f64; 3]> {
    let nx = 2.0 * x / f64::from(size.width()) - 1.0;
    let ny = 1.0 - 2.0 * y / f64::from(size.height());
    let p = clip.map(|v| v.x - nx * v.w);
    let q = clip.map(|v| v.y - ny * v.w);
    let b = [
        p[1] * q[2] - p[2] * q[1],
        p[2] * q[0] - p[0] * q[2],
        p[0] * q[1] - p[1] * q[0],
    ];
    let sum = b[0] + b[1] + b[2];
    (sum != 0.0).then(|| b.map(|v| v / sum))
}

/// The perspective-correct value at a pixel position.
#[must_use]
pub fn perspective(
    clip: &[DVec4; 3],
    values: [f64; 3],
    size: TargetSize,
    x: f64,
    y: f64,
) -> Option<f64> {
    let b = weights(clip, size, x, y)?;
    Some(b[0] * values[0] + b[1] * values[1] + b[2] * values[2])
}

/// The screen-linear (affine) value at a pixel position, for vertices in front of the eye.
#[must_use]
pub fn affine(
    clip: &[DVec4; 3],
    values: [f64; 3],
    size: TargetSize,
    x: f64,
    y: f64,
) -> Option<f64> {
    perspective(&clip.map(|v| v / v.w), values, size, x, y)
}

//! Barycentric coordinates on the screen and in the plane of the triangle.

use glam::DVec2;

/// Barycentric coordinates of `p` in a screen triangle, by three edge functions over their sum: they add to 1, and are exactly 0 or
/// 1 at a vertex. None without area and for numbers that are not finite.
#[must_use]
pub fn screen(triangle: [DVec2; 3], p: DVec2) -> Option<[f64; 3]> {
    let [a, b, c] = triangle.map(|v| v - p);
    normalised([b.perp_dot(c), c.perp_dot(a), a.perp_dot(b)])
}

/// Barycentric coordinates in the plane of the triangle from those on the screen and 1/w of each vertex:
/// `l_i inv_w_i / sum`. None where the sum is 0 or not finite.
#[must_use]
pub fn perspective(screen: [f64; 3], inv_w: [f64; 3]) -> Option<[f64; 3]> {
    normalised([
        screen[0] * inv_w[0],
        screen[1] * inv_w[1],
        screen[2] * inv_w[2],
    ])
}

/// The weighted sum of three values.
#[inline]
#[must_use]
pub fn blend(weights: [f64; 3], values: [f64; 3]) -> f64 {
    weights[0] * values[0] + weights[1] * values[1] + weights[2] * values[2]
}

/// [`screen`] in f32.
#[must_use]
pub fn screen_f32(triangle: [[f32; 2]; 3], p: [f32; 2]) -> Option<[f32; 3]> {
    let [a, b, c] = triangle.map(|v| [v[0] - p[0], v[1] - p[1]]);
    let cross = |a: [f32; 2], b: [f32; 2]| a[0] * b[1] - a[1] * b[0];
    normalised_f32([cross(b, c), cross(c, a), cross(a, b)])
}

/// [`perspective`] in f32.
#[must_use]
pub fn perspective_f32(screen: [f32; 3], inv_w: [f32; 3]) -> Option<[f32; 3]> {
    normalised_f32([
        screen[0] * inv_w[0],
        screen[1] * inv_w[1],
        screen[2] * inv_w[2],
    ])
}

/// [`blend`] in f32.
#[inline]
#[must_use]
pub fn blend_f32(weights: [f32; 3], values: [f32; 3]) -> f32 {
    weights[0] * values[0] + weights[1] * values[1] + weights[2] * values[2]
}

fn normalised(e: [f64; 3]) -> Option<[f64; 3]> {
    let sum = e[0] + e[1] + e[2];
    (sum != 0.0 && sum.is_finite()).then(|| e.map(|e| e / sum))
}

fn normalised_f32(e: [f32; 3]) -> Option<[f32; 3]> {
    let sum = e[0] + e[1] + e[2];
    (sum != 0.0 && sum.is_finite()).then(|| e.map(|e| e / sum))
}

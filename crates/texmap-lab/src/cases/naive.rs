//! The methods that must fail: as they stand in textbooks and lectures, kept for comparison.

/// An edge function in f32: `(x1 - x0)(y - y0) - (y1 - y0)(x - x0)`. The rounding depends on which end comes
/// first, so two triangles may both claim or both refuse a pixel on their common edge.
pub(super) fn edge_f32(a: [f32; 2], b: [f32; 2], p: [f32; 2]) -> f32 {
    (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0])
}

/// The edge function as a plane `A x + B y + C` in f32 (MIT 6.837, lecture 18, slide 4): C cancels far from
/// the origin.
pub(super) fn edge_plane_f32(a: [f32; 2], b: [f32; 2], p: [f32; 2]) -> f32 {
    let (ea, eb) = (a[1] - b[1], b[0] - a[0]);
    let ec = -(ea * a[0] + eb * a[1]);
    ea * p[0] + eb * p[1] + ec
}

/// True if an edge owns the centres that lie on it. Left edges and top edges do, for a triangle whose edge
/// functions are positive inside and whose y grows downward.
pub(super) fn top_left(a: [f32; 2], b: [f32; 2]) -> bool {
    let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
    dy < 0.0 || dy == 0.0 && dx > 0.0
}

/// Coverage counts of triangles (positive orientation, pixel positions) by a given edge function.
/// `inclusive` takes every centre on an edge (lecture 18: `e >= 0`), otherwise the top-left rule decides.
pub(super) fn coverage(
    origin: (u32, u32),
    size: (u32, u32),
    triangles: &[[[f32; 2]; 3]],
    edge: fn([f32; 2], [f32; 2], [f32; 2]) -> f32,
    inclusive: bool,
) -> Vec<u32> {
    let mut counts = vec![0; size.0 as usize * size.1 as usize];
    for triangle in triangles {
        let sides = [0, 1, 2].map(|i| (triangle[i], triangle[(i + 1) % 3]));
        let owns = sides.map(|(a, b)| inclusive || top_left(a, b));
        for y in 0..size.1 {
            for x in 0..size.0 {
                let p = [(origin.0 + x) as f32 + 0.5, (origin.1 + y) as f32 + 0.5];
                let inside = sides.iter().zip(owns).all(|(&(a, b), owns)| {
                    let e = edge(a, b, p);
                    e > 0.0 || owns && e == 0.0
                });
                counts[(y * size.0 + x) as usize] += u32::from(inside);
            }
        }
    }
    counts
}

/// The parabola through the ends and the middle of a perspective span, at screen fraction t.
pub(super) fn quadratic(t: f64, middle: f64) -> f64 {
    // s(0) = 0, s(1/2) = middle, s(1) = 1.
    (4.0 * middle - 1.0) * t + (2.0 - 4.0 * middle) * t * t
}

//! Three-component f32 arithmetic in one fixed order of operations.

use texmap_math::float::sqrt_f32;

pub(crate) fn sub(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub(crate) fn scale(a: [f32; 3], k: f32) -> [f32; 3] {
    [a[0] * k, a[1] * k, a[2] * k]
}

pub(crate) fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Unit vector; zero for a vector without a direction (zero or not finite). Divided by the largest
/// component first, so that no length under- or overflows.
pub(crate) fn normalize(a: [f32; 3]) -> [f32; 3] {
    let largest = a[0].abs().max(a[1].abs()).max(a[2].abs());
    if !(largest > 0.0 && largest < f32::INFINITY) {
        return [0.0; 3];
    }
    let a = [a[0] / largest, a[1] / largest, a[2] / largest];
    let length = sqrt_f32(dot(a, a));
    // A NaN component passes `max` and shows here.
    if length.is_nan() || length <= 0.0 {
        return [0.0; 3];
    }
    [a[0] / length, a[1] / length, a[2] / length]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normalize_survives_every_magnitude() {
        for k in [1e-38, 1e-20, 1.0, 1e20, 1e38] {
            let n = normalize([3.0 * k, 0.0, -3.0 * k]);
            assert!(
                (n[0] - 0.5f32.sqrt()).abs() < 1e-6 && n[0] == -n[2],
                "{k}: {n:?}"
            );
        }
        assert_eq!(normalize([0.0, -0.0, 0.0]), [0.0; 3]);
        assert_eq!(normalize([f32::NAN, 1.0, 0.0]), [0.0; 3]);
        assert_eq!(normalize([f32::INFINITY, 1.0, 0.0]), [0.0; 3]);
    }
}

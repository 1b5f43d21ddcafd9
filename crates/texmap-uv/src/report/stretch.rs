//! Stretch of a triangle, after Sander, Snyder, Gortler and Hoppe (2001): the singular values of the map from the
//! picture to space.

use texmap_math::float;
use texmap_math::glam::DVec2;

use super::{ReportOptions, TriangleReport};
use crate::Origin;
use crate::mesh::{Mesh, length};
use crate::uv_set::UvSet;

/// Stretch of one triangle before it is normalised.
#[derive(Clone, Copy)]
pub(super) struct Raw {
    pub(super) space: f64,
    /// Signed.
    pub(super) picture: f64,
    high: f64,
    low: f64,
}

pub(super) fn raw(
    mesh: &Mesh<'_>,
    set: &UvSet,
    corners: [usize; 3],
    options: &ReportOptions,
) -> Raw {
    let [a, b, c] = corners.map(|k| mesh.point(k));
    let [p, q, r] = corners.map(|k| DVec2::from(set.at(k).map(f64::from)));
    let (e1, e2, f1, f2) = (b - a, c - a, q - p, r - p);
    let twice = f1.perp_dot(f2);
    let space = length(e1.cross(e2)) * 0.5;
    let sign = if options.origin == Origin::TopLeft {
        -1.0
    } else {
        1.0
    };
    // Rounding of f32 coordinates leaves a sliver where the exact triangle has no area.
    let longest = f1.dot(f1).max(f2.dot(f2)).max((f2 - f1).dot(f2 - f1));
    if space == 0.0 || twice.abs() <= longest * 1e-12 {
        return Raw {
            space,
            picture: 0.0,
            high: f64::INFINITY,
            low: 0.0,
        };
    }
    // Derivatives of the position along u and v, and the singular values of the pair.
    let (su, sv) = (
        (e1 * f2.y - e2 * f1.y) / twice,
        (e2 * f1.x - e1 * f2.x) / twice,
    );
    let (x, y, z) = (su.dot(su), su.dot(sv), sv.dot(sv));
    let root = float::sqrt((x - z) * (x - z) + 4.0 * y * y);
    let high = float::sqrt((x + z + root) * 0.5);
    // The smaller one by the area: the difference under its own root loses all digits on slivers.
    let low = space * 2.0 / twice.abs() / high;
    Raw {
        space,
        picture: sign * twice * 0.5,
        high,
        low,
    }
}

/// The stretch of a triangle, as 1 for the mean of the whole mesh; its face and corners are left open.
pub(super) fn normalised(r: &Raw, scale: f64) -> TriangleReport {
    let (high, low) = (r.high * scale, r.low * scale);
    let area = high * low;
    let finite = r.high.is_finite();
    TriangleReport {
        face: 0,
        corners: [0; 3],
        l2: if finite {
            float::sqrt((high * high + low * low) * 0.5) as f32
        } else {
            f32::INFINITY
        },
        linf: if finite { high as f32 } else { f32::INFINITY },
        angle: if finite {
            (r.high / r.low) as f32
        } else {
            f32::INFINITY
        },
        area: if finite {
            (if area > 1.0 { area } else { 1.0 / area }) as f32
        } else {
            f32::INFINITY
        },
        density: f32::NAN,
        outside: false,
        flipped: r.picture < 0.0,
        collapsed: r.space > 0.0 && r.picture == 0.0,
        overlapping: false,
    }
}

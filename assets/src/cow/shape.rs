//! The cow's body as a blend of ellipsoids and tapered limbs; x forward, y up, hooves on y = 0.

use texmap_math::glam::DVec3;

use crate::mesh::length;

pub(crate) const MUZZLE: DVec3 = DVec3::new(1.34, 1.19, 0.0);
pub(crate) const UDDER: DVec3 = DVec3::new(-0.42, 0.50, 0.0);
pub(crate) const EYE: DVec3 = DVec3::new(1.125, 1.50, 0.125);
pub(crate) const EYE_RADIUS: f64 = 0.098;
pub(crate) const NECK: (DVec3, DVec3) = (DVec3::new(0.45, 1.00, 0.0), DVec3::new(0.90, 1.33, 0.0));

/// Signed distance, negative inside; close to a true distance near the surface.
pub(crate) fn body(p: DVec3) -> f64 {
    let p = DVec3::new(p.x, p.y, p.z.abs());
    let at = |x, y, z| DVec3::new(x, y, z);
    let mut d = limb(p, at(-0.55, 0.90, 0.0), 0.43, at(0.38, 0.92, 0.0), 0.41);
    d = melt(
        d,
        ellipsoid(p, at(-0.08, 0.80, 0.0), at(0.62, 0.42, 0.45)),
        0.2,
    );
    d = melt(
        d,
        ellipsoid(p, at(-0.72, 1.02, 0.0), at(0.28, 0.29, 0.36)),
        0.15,
    );
    d = melt(d, limb(p, NECK.0, 0.31, NECK.1, 0.20), 0.18);
    d = melt(d, head(p), 0.12);
    for (hip, knee, hoof) in [
        (
            at(0.40, 0.72, 0.22),
            at(0.45, 0.38, 0.235),
            at(0.45, 0.06, 0.24),
        ),
        (
            at(-0.66, 0.78, 0.23),
            at(-0.74, 0.40, 0.25),
            at(-0.68, 0.06, 0.25),
        ),
    ] {
        let mut leg = limb(p, hip, 0.19, knee, 0.115);
        leg = melt(leg, limb(p, knee, 0.115, hoof, 0.105), 0.08);
        leg = melt(
            leg,
            ellipsoid(p, hoof + at(0.02, 0.03, 0.0), at(0.15, 0.13, 0.135)),
            0.04,
        );
        d = melt(d, leg, 0.12);
    }
    let mut udder = ellipsoid(p, UDDER, at(0.19, 0.16, 0.17));
    for x in [-0.50, -0.34] {
        udder = melt(
            udder,
            limb(p, at(x, 0.42, 0.07), 0.045, at(x, 0.32, 0.085), 0.034),
            0.04,
        );
    }
    d = melt(d, udder, 0.06);
    // The ground flattens the hooves.
    -melt(-d, p.y - 0.005, 0.03)
}

fn head(p: DVec3) -> f64 {
    let at = |x, y, z| DVec3::new(x, y, z);
    let mut d = ellipsoid(p, at(0.98, 1.43, 0.0), at(0.25, 0.26, 0.24));
    d = melt(
        d,
        limb(p, at(1.05, 1.36, 0.0), 0.20, at(1.28, 1.22, 0.0), 0.16),
        0.1,
    );
    d = melt(d, ellipsoid(p, MUZZLE, at(0.15, 0.145, 0.205)), 0.09);
    // Cheeks, brow and forelock.
    d = melt(
        d,
        ellipsoid(p, at(1.08, 1.33, 0.13), at(0.13, 0.12, 0.09)),
        0.1,
    );
    d = melt(
        d,
        ellipsoid(p, at(1.02, 1.65, 0.0), at(0.09, 0.07, 0.09)),
        0.06,
    );
    // Nostrils.
    let nostril = ellipsoid(p, nostril_at(), at(0.04, 0.032, 0.028));
    -melt(-d, nostril, 0.02)
}

/// Middle of the nostril on the side z > 0.
pub(crate) fn nostril_at() -> DVec3 {
    MUZZLE + DVec3::new(0.128, 0.06, 0.085)
}

/// A segment with a radius at each end.
pub(crate) fn limb(p: DVec3, a: DVec3, ra: f64, b: DVec3, rb: f64) -> f64 {
    let along = b - a;
    let t = ((p - a).dot(along) / along.dot(along)).clamp(0.0, 1.0);
    length(p - a - along * t) - (ra + (rb - ra) * t)
}

pub(crate) fn ellipsoid(p: DVec3, centre: DVec3, radii: DVec3) -> f64 {
    let q = (p - centre) / radii;
    let (a, b) = (length(q), length(q / radii));
    if b < 1e-9 {
        -radii.min_element()
    } else {
        a * (a - 1.0) / b
    }
}

/// The smaller of two distances, rounded where they differ by less than `width`.
fn melt(a: f64, b: f64, width: f64) -> f64 {
    let h = (width - (a - b).abs()).max(0.0);
    (if a < b { a } else { b }) - h * h / (4.0 * width)
}

/// Central differences.
pub(crate) fn gradient(field: &dyn Fn(DVec3) -> f64, p: DVec3) -> DVec3 {
    let e = 1e-4;
    let along = |axis: DVec3| (field(p + axis * e) - field(p - axis * e)) / (2.0 * e);
    DVec3::new(along(DVec3::X), along(DVec3::Y), along(DVec3::Z))
}

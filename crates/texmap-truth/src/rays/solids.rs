//! Rays against the unit solids, in their own space: analytic, without triangles (the chain of the Brown "Ray" assignments, the
//! root of SUSTech CS lecture 08).

use texmap_math::glam::DVec3;
use texmap_uv::Shape;

/// Every `t` in `range` at which the ray `origin + t direction` meets the surface, with the outward normal there (any length).
/// The nearest is returned.
pub(super) fn meet(
    shape: Shape,
    origin: DVec3,
    direction: DVec3,
    range: (f64, f64),
) -> Option<(f64, DVec3)> {
    let mut nearest: Option<(f64, DVec3)> = None;
    let mut offer = |t: f64, normal: DVec3| {
        let nearer = nearest.is_none_or(|(best, _)| t < best);
        // NaN and infinity (a ray along the surface) are in no range.
        if t > range.0 && t < range.1 && nearer {
            nearest = Some((t, normal));
        }
    };
    let (o, d) = (origin, direction);
    match shape {
        Shape::Plane => {
            let t = -o.z / d.z;
            let p = o + d * t;
            if within(p.x) && within(p.y) {
                offer(t, DVec3::Z);
            }
        }
        Shape::Box => {
            for axis in 0..3 {
                for side in [-0.5, 0.5] {
                    let t = (side - o[axis]) / d[axis];
                    let p = o + d * t;
                    if (0..3).all(|other| other == axis || within(p[other])) {
                        let mut normal = DVec3::ZERO;
                        normal[axis] = 2.0 * side;
                        offer(t, normal);
                    }
                }
            }
        }
        Shape::Sphere => {
            for t in roots(d.dot(d), o.dot(d), o.dot(o) - 0.25) {
                offer(t, o + d * t);
            }
        }
        Shape::Cylinder => {
            let flat = |v: DVec3| DVec3::new(v.x, 0.0, v.z);
            let (of, df) = (flat(o), flat(d));
            for t in roots(df.dot(df), of.dot(df), of.dot(of) - 0.25) {
                let p = o + d * t;
                if within(p.y) {
                    offer(t, flat(p));
                }
            }
            for side in [-0.5, 0.5] {
                cap(o, d, side, &mut offer);
            }
        }
        Shape::Cone => {
            // x^2 + z^2 = k^2 with k = (0.5 - y) / 2, which falls by d.y / 2 along the ray.
            let (k, dk) = ((0.5 - o.y) * 0.5, -d.y * 0.5);
            let a = d.x * d.x + d.z * d.z - dk * dk;
            let b = o.x * d.x + o.z * d.z - k * dk;
            let c = o.x * o.x + o.z * o.z - k * k;
            for t in roots(a, b, c) {
                let p = o + d * t;
                if within(p.y) {
                    offer(t, DVec3::new(p.x, (0.5 - p.y) * 0.25, p.z));
                }
            }
            cap(o, d, -0.5, &mut offer);
        }
    }
    nearest
}

fn within(c: f64) -> bool {
    (-0.5..=0.5).contains(&c)
}

/// The disc of radius 0.5 at a height.
fn cap(o: DVec3, d: DVec3, y: f64, offer: &mut impl FnMut(f64, DVec3)) {
    let t = (y - o.y) / d.y;
    let p = o + d * t;
    if p.x * p.x + p.z * p.z <= 0.25 {
        offer(t, DVec3::Y * (2.0 * y));
    }
}

/// Roots of `a t^2 + 2 b t + c`, without cancellation; those that do not exist are NaN.
fn roots(a: f64, b: f64, c: f64) -> [f64; 2] {
    let root = (b * b - a * c).sqrt();
    let q = -(b + if b < 0.0 { -root } else { root });
    if a == 0.0 {
        // A ray along a cone's side meets it once.
        return [-c / (2.0 * b), f64::NAN];
    }
    [q / a, c / q]
}

#[cfg(test)]
mod tests {
    use super::*;
    use texmap_uv::{Origin, ShapeFace};

    const ALL: [Shape; 5] = [
        Shape::Plane,
        Shape::Box,
        Shape::Cylinder,
        Shape::Cone,
        Shape::Sphere,
    ];

    fn parts(shape: Shape) -> &'static [ShapeFace] {
        match shape {
            Shape::Plane | Shape::Sphere => &[ShapeFace::Whole],
            Shape::Cylinder => &[ShapeFace::Side, ShapeFace::Top, ShapeFace::Bottom],
            Shape::Cone => &[ShapeFace::Side, ShapeFace::Bottom],
            Shape::Box => &[
                ShapeFace::Right,
                ShapeFace::Left,
                ShapeFace::Top,
                ShapeFace::Bottom,
                ShapeFace::Front,
                ShapeFace::Back,
            ],
        }
    }

    /// The truth and the uv mapper hold each other: rays to points that the mapper gives meet the surface there.
    #[test]
    fn rays_meet_the_points_that_the_mapper_places() {
        let mut met = 0;
        for shape in ALL {
            for &part in parts(shape) {
                for (i, j) in (1..20).flat_map(|i| (1..20).map(move |j| (i, j))) {
                    let uv = [f64::from(i) / 20.0 + 0.003, f64::from(j) / 20.0 + 0.007];
                    let target = shape.point(part, uv, Origin::TopLeft);
                    if matches!(part, ShapeFace::Top | ShapeFace::Bottom)
                        && shape != Shape::Box
                        && target.x.hypot(target.z) > 0.49
                    {
                        continue;
                    }
                    // From outside, along a slanted line.
                    let out = if shape == Shape::Plane {
                        DVec3::Z
                    } else {
                        target.normalize()
                    };
                    let origin = target + out * 2.0 + DVec3::new(0.03, -0.02, 0.05);
                    let (t, normal) = meet(shape, origin, target - origin, (0.0, f64::INFINITY))
                        .unwrap_or_else(|| panic!("{shape:?} {part:?} {uv:?}"));
                    let p = origin + (target - origin) * t;
                    assert!(normal.dot(origin - p) > 0.0, "the normal points out");
                    if (t - 1.0).abs() > 1e-9 {
                        // Another part stands before it.
                        assert!(t < 1.0, "{shape:?} {part:?} {uv:?}: {t}");
                        continue;
                    }
                    met += 1;
                    let (found, back) = shape.uv(p, Origin::TopLeft);
                    assert_eq!(found, part);
                    for k in 0..2 {
                        assert!(
                            (back[k] - uv[k]).abs() < 1e-9,
                            "{shape:?} {part:?} {uv:?}: {back:?}"
                        );
                    }
                }
            }
        }
        assert!(met > 3_500, "{met}");
    }

    #[test]
    fn rays_that_miss_or_graze_are_not_nan() {
        for shape in ALL {
            for (o, d) in [
                (DVec3::new(0.0, 3.0, 0.0), DVec3::Y),
                (DVec3::new(2.0, 0.0, 0.0), DVec3::Y),
                (DVec3::new(0.6, 0.0, 0.3), DVec3::Z),
                (DVec3::ZERO, DVec3::ZERO),
                (DVec3::splat(f64::NAN), DVec3::X),
            ] {
                assert_eq!(
                    meet(shape, o, d, (0.0, f64::INFINITY)),
                    None,
                    "{shape:?} {o} {d}"
                );
            }
            let along = meet(shape, DVec3::new(0.5, -3.0, 0.0), DVec3::Y, (0.0, 99.0));
            assert!(along.is_none_or(|(t, n)| t.is_finite() && n.is_finite()));
        }
    }
}
